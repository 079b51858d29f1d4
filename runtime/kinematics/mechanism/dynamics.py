"""Torques and accelerations of mechanisms, loops included, in the coordinates of their inputs.

With the velocities A u of all bodies at speeds u of the inputs, and their accelerations gamma at u' = 0, D'Alembert's
principle is A^T (Q(A u' + gamma) - wrenches) = tau. The rates of twists follow from the joints as the twists do: what a
joint leaves free is fixed in its first body, and moves with it, dS = V x S (7.14); of two rotations one behind the
other the second is fixed in the second body.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...codegen.errors import InputError, SingularError
from ...common.validation import as_instance, broadcast_shapes, finite_array
from ...core.multivector import Multivector
from ...mechanics.arguments import GRAVITY
from ...mechanics.joints.base import Joint
from ...mechanics.joints.displaced import DisplacedJoint
from ...mechanics.joints.standard import Cylindrical, Planar, Prismatic, Revolute, Rigid, Spherical
from ...mechanics.rigid_body import RigidBody
from ...mechanics.twists import screw_vectors
from .arguments import as_list
from .jacobian import analyze
from .structure import Assembly

Array = NDArray[Any]
#: Joints whose freedoms keep their directions in the first body.
STEADY = (Revolute, Prismatic, Cylindrical, Planar, Spherical, Rigid)


@dataclass(frozen=True, eq=False)
class LinkInertias:
    """Inertias of bodies in the world, at the mechanism's pose.

    Attributes
    ----------
    masses : array (n,)
    centers : array (n, 3)
    tensors : array (n, 3, 3)
        About the centers.
    """

    masses: Array
    centers: Array
    tensors: Array


class MechanismDynamics(Assembly):
    """Dynamics of a mechanism at its pose, in the coordinates of inputs that move all of it."""

    _inertias: LinkInertias | None = None

    def with_inertias(self, bodies: Mapping[str, RigidBody]) -> Self:
        """This mechanism with inertias of its bodies, where they are now; those that are not named have none.

        Parameters
        ----------
        bodies : mapping of str to dynamics.RigidBody
            Their masses, moments, positions and orientations, as of a `dynamics.System`; velocities do not matter.

        Raises
        ------
        InputError
            If there is no such body, or it is a batch.
        """
        count = len(self.moving)
        masses, centers, tensors = np.zeros(count), np.zeros((count, 3)), np.zeros((count, 3, 3))
        for name, body in as_instance(bodies, "the bodies", Mapping, "a mapping of names to bodies").items():
            as_instance(body, f"bodies[{name!r}]", RigidBody, "a dynamics.RigidBody")
            if body.shape:
                raise InputError(f"bodies[{name!r}] is a batch {body.shape}; one body is needed.")
            i = self.body_index(name)
            if i >= 0:
                turn = np.asarray(body.rotation) @ body.axes
                masses[i], centers[i], tensors[i] = body.mass, body.position, turn @ np.diag(body.moments) @ turn.T
        restore, arguments, _ = self.__reduce__()
        new: Self = restore(*arguments)
        new._inertias = LinkInertias(masses, centers, tensors)
        return new

    def __reduce__(self) -> tuple[Any, ...]:
        return *super().__reduce__(), {"_inertias": self._inertias}

    def displaced_inertias(self, displacements: Mapping[str, Multivector]) -> LinkInertias | None:
        """Inertias where bodies are displaced by motors."""
        i = self._inertias
        if i is None:
            return None
        matrices = np.stack([self.algebra.matrix(displacements[name]) for name in self.moving])
        turns = matrices[:, :3, :3]
        centers = np.einsum("bij,bj->bi", turns, i.centers) + matrices[:, :3, 3]
        return LinkInertias(i.masses, centers, turns @ i.tensors @ np.swapaxes(turns, -1, -2))

    def inverse_dynamics(
        self, inputs: Any, qd: ArrayLike = 0, qdd: ArrayLike = 0, gravity: ArrayLike = GRAVITY
    ) -> Array:
        """Forces (..., k) of the inputs that a motion takes at this pose: M qdd + h(qd).

        Parameters
        ----------
        inputs : str, Joint or list
            Joints, as of `jacobian`, that determine the motion of all bodies: k coordinates.
        qd, qdd : array (..., k)
            Speeds and accelerations of the inputs; 0 is none.
        gravity : array (3,)

        Raises
        ------
        InputError
            If the mechanism has no inertias (`with_inertias`), or a joint has freedoms that vary with its pose.
        ConstraintError, UndeterminedError
            If the joints do not allow an input, or something moves while all inputs rest.
        """
        model = _Model.of(self, inputs)
        speeds, accelerations = model.numbers("qd", qd), model.numbers("qdd", qdd)
        broadcast_shapes({"qd": speeds.shape[:-1], "qdd": accelerations.shape[:-1]})
        return accelerations @ model.mass_matrix() + model.bias(speeds, gravity)

    def bias_forces(self, inputs: Any, qd: ArrayLike, gravity: ArrayLike = GRAVITY) -> Array:
        """Forces (..., k) of the inputs at zero acceleration."""
        return self.inverse_dynamics(inputs, qd, 0, gravity)

    def gravity_torques(self, inputs: Any, gravity: ArrayLike = GRAVITY) -> Array:
        """Forces (k,) of the inputs that hold the mechanism at rest."""
        return self.inverse_dynamics(inputs, 0, 0, gravity)

    def mass_matrix(self, inputs: Any) -> Array:
        """The matrix (k, k) of forces for a unit of acceleration of each input."""
        return _Model.of(self, inputs).mass_matrix()

    def forward_dynamics(self, inputs: Any, qd: ArrayLike, tau: ArrayLike, gravity: ArrayLike = GRAVITY) -> Array:
        """Accelerations (..., k) of the inputs under their forces.

        Raises
        ------
        SingularError
            If an input moves nothing that has an inertia.
        """
        model = _Model.of(self, inputs)
        speeds, forces = model.numbers("qd", qd), model.numbers("tau", tau)
        broadcast_shapes({"qd": speeds.shape[:-1], "tau": forces.shape[:-1]})
        matrix, left = model.mass_matrix(), forces - model.bias(speeds, gravity)
        sizes = np.linalg.svd(matrix, compute_uv=False)
        if not sizes[-1] > np.finfo(float).eps * len(matrix) * sizes[0]:
            raise SingularError("the mass matrix of the inputs is singular: an input moves nothing with an inertia.")
        return np.asarray(np.linalg.solve(matrix, left[..., None])[..., 0])


@dataclass(frozen=True, eq=False)
class _Model:
    """Linear relations of a mechanism at its pose; twists are w, v (6,) about the center and in the unit of its frame.

    Attributes
    ----------
    mechanism : MechanismDynamics
    velocities : array (bodies, 6, k)
        Angular velocity, and velocity of the center of mass, of each body for unit speeds of inputs.
    twists : array (bodies, 6, k)
    inverse : array (6 bodies, rows)
        From what the rows of joints, couplings and inputs give to rates of twists.
    joints : list of (int, array (rows, 6))
        A joint, and rows on the rate of the relative twist of its bodies.
    """

    mechanism: MechanismDynamics
    inertias: LinkInertias
    velocities: Array
    twists: Array
    inverse: Array
    joints: list[tuple[int, Array]]

    @classmethod
    def of(cls, mechanism: MechanismDynamics, inputs: Any) -> _Model:
        """The model, checked."""
        inertias = mechanism._inertias
        if inertias is None:
            raise InputError(
                "this mechanism has no inertias: only its kinematics are known.",
                remedy="Give them: mechanism.with_inertias({body: dynamics.RigidBody(...)})",
            )
        indices = [mechanism.find_joint(x) for x in as_list(inputs)]
        if not indices or None in indices:
            raise InputError("inputs of dynamics are joints.", remedy="Name joints of the mechanism")
        for joint in mechanism.joints:
            inner = joint.joint if isinstance(joint, DisplacedJoint) else joint
            if not isinstance(inner, STEADY) and inner.rotations() is None:
                raise InputError(f"{joint.label} has freedoms that vary with its pose, whose rates are not known.")
        analysis = analyze(mechanism, inputs, list(mechanism.moving))
        analysis.check()
        plain = np.hstack(screw_vectors(mechanism.algebra, np.eye(6))).T
        own = plain @ mechanism.from_world
        count, k = len(mechanism.moving), analysis.jacobian.shape[1]
        twists = own @ analysis.jacobian.reshape(count, 6, k)
        loops, back = mechanism.loops, np.linalg.inv(plain)
        blocks = [{j: relation.rows} for j, relation in enumerate(loops.relations)]
        blocks += [{j: power[None] for j, power in powers.items()} for powers in loops.coupling_powers]
        for j in indices:
            assert j is not None
            blocks.append({j: loops.relations[j].to_coordinates})
        ends = np.cumsum([0, *(len(next(iter(block.values()))) for block in blocks)])
        matrix, placed = np.zeros((int(ends[-1]), 6 * count)), list[tuple[int, Array]]()
        for block, first, last in zip(blocks, ends, ends[1:], strict=False):
            for j, rows in block.items():
                full = np.zeros((len(matrix), 6))
                full[first:last] = rows @ back
                placed.append((j, full))
                for body, sign in zip(mechanism.tree.ends[j], (-1, 1), strict=True):
                    if body >= 0:
                        matrix[:, 6 * body : 6 * body + 6] += sign * full
        velocities = _at_centers(mechanism, twists, inertias.centers)
        inverse = np.linalg.pinv(matrix, rcond=mechanism.rank_rtol)
        return cls(mechanism, inertias, velocities, twists, inverse, placed)

    def numbers(self, name: str, values: ArrayLike) -> Array:
        """Numbers (..., k) of the inputs."""
        k = self.velocities.shape[-1]
        if np.ndim(values) == 0 and not np.any(values):
            return np.zeros(k)
        return finite_array(values, name, (..., k))

    def mass_matrix(self) -> Array:
        a, i = self.velocities, self.inertias
        return np.asarray(
            np.einsum("bik,bij,bjl->kl", a[:, :3], i.tensors, a[:, :3])
            + np.einsum("bik,b,bil->kl", a[:, 3:], i.masses, a[:, 3:])
        )

    def bias(self, speeds: Array, gravity: ArrayLike) -> Array:
        """Forces (..., k) at zero acceleration, for speeds (..., k)."""
        i, unit = self.inertias, self.mechanism.frame.unit
        twists = np.einsum("bik,...k->...bi", self.twists, speeds)
        w = twists[..., :3]
        rates = self._rates(twists)
        arms = (i.centers - self.mechanism.frame.center) / unit
        velocity = twists[..., 3:] + np.cross(w, arms)
        angular = rates[..., :3]
        linear = unit * (rates[..., 3:] + np.cross(angular, arms) + np.cross(w, velocity))
        force = i.masses[:, None] * (linear - finite_array(gravity, "gravity", (3,)))
        moment = np.einsum("bij,...bj->...bi", i.tensors, angular)
        moment = moment + np.cross(w, np.einsum("bij,...bj->...bi", i.tensors, w))
        return np.asarray(
            np.einsum("bik,...bi->...k", self.velocities[:, :3], moment)
            + np.einsum("bik,...bi->...k", self.velocities[:, 3:], force)
        )

    def _rates(self, twists: Array) -> Array:
        """Rates (..., bodies, 6) of twists at zero acceleration of the inputs."""
        mechanism, zero = self.mechanism, np.zeros((*twists.shape[:-2], 6))
        right = np.zeros((*twists.shape[:-2], self.inverse.shape[1]))
        drifts: dict[int, Array] = {}
        for j, rows in self.joints:
            if j not in drifts:
                a, b = (twists[..., x, :] if x >= 0 else zero for x in mechanism.tree.ends[j])
                drifts[j] = _bracket(a, b - a) + self._between(mechanism.joints[j], b - a)
            right = right + drifts[j] @ rows.T
        return np.asarray((right @ self.inverse.T).reshape(twists.shape))

    def _between(self, joint: Joint, relative: Array) -> Array:
        """Rate of the second of two rotations by the first; zero for other joints."""
        inner = joint.joint if isinstance(joint, DisplacedJoint) else joint
        given = None if isinstance(inner, STEADY) else inner.rotations()
        if given is None:
            return np.zeros_like(relative)
        frame, (point, axes) = self.mechanism.frame, given
        if isinstance(joint, DisplacedJoint):
            first, second = (self.mechanism.algebra.matrix(m) for m in (joint.motor_a, joint.motor_b))
            point = first[:3, :3] @ point + first[:3, 3]
            axes = np.stack([first[:3, :3] @ axes[0], second[:3, :3] @ axes[1]])
        speeds = relative[..., :3] @ np.linalg.pinv(axes)
        arm = (np.asarray(point) - frame.center) / frame.unit
        parts = [speeds[..., k, None] * np.concatenate([axes[k], np.cross(arm, axes[k])]) for k in range(2)]
        return _bracket(*parts)


def _at_centers(mechanism: Assembly, twists: Array, centers: Array) -> Array:
    """Angular velocities, and velocities of centers of mass in the world's units, (bodies, 6, k) of twists."""
    frame = mechanism.frame
    arms = (centers - frame.center) / frame.unit
    linear = frame.unit * (twists[:, 3:] + np.cross(twists[:, :3], arms[:, :, None], axis=1))
    return np.concatenate([twists[:, :3], linear], 1)


def _bracket(a: Array, b: Array) -> Array:
    """Rate of a twist b (..., 6) that moves with a."""
    linear = np.cross(a[..., :3], b[..., 3:]) + np.cross(a[..., 3:], b[..., :3])
    return np.concatenate([np.cross(a[..., :3], b[..., :3]), linear], -1)
