"""Torques and accelerations of joints: what chains and robots that branch have in common."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Any, Literal, NamedTuple, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...common.validation import broadcast_shapes, finite_array, real_array
from ...dispatch.item_statuses import array_result
from ...dispatch.multivector_data import Statuses
from ...mechanics.arguments import GRAVITY
from ...status import Status
from .bound import BoundDynamics
from .tree import Tree

Array = NDArray[Any]
Result = Array | tuple[Array, Statuses]


class InverseDerivatives(NamedTuple):
    """Derivatives (..., n, n) of forces by q, qd and qdd."""

    q: Array
    qd: Array
    qdd: Array


class ForwardDerivatives(NamedTuple):
    """Derivatives (..., n, n) of accelerations by q, qd and tau."""

    q: Array
    qd: Array
    tau: Array


class JointDynamics(ABC):
    """Dynamics of links on joints: torques of rotations, forces of translations, in the units of what is given.

    Coordinates, speeds, accelerations and forces are arrays (..., n), one number for each joint, that broadcast; 0 is
    none. Gravity is the acceleration of what falls, in the frame of the root. With ``status=True`` results come with
    codes of `bladesmith.Status`, INVALID where a result is not finite; with ``strict=True`` the first such item raises.
    """

    @property
    @abstractmethod
    def tree(self) -> Tree:
        """The links, compiled.

        Raises
        ------
        InputError
            If they have no inertias.
        """

    @overload
    def inverse_dynamics(
        self, q: ArrayLike, qd: ArrayLike = ..., qdd: ArrayLike = ..., gravity: ArrayLike = ..., *,
        status: Literal[False] = ..., strict: bool = ..., threads: int | None = ...,
    ) -> Array: ...  # fmt: skip
    @overload
    def inverse_dynamics(
        self, q: ArrayLike, qd: ArrayLike = ..., qdd: ArrayLike = ..., gravity: ArrayLike = ..., *,
        status: Literal[True], strict: bool = ..., threads: int | None = ...,
    ) -> tuple[Array, Statuses]: ...  # fmt: skip
    def inverse_dynamics(
        self, q: ArrayLike, qd: ArrayLike = 0, qdd: ArrayLike = 0, gravity: ArrayLike = GRAVITY, *,
        status: bool = False, strict: bool = False, threads: int | None = None,
    ) -> Result:  # fmt: skip
        """Forces (..., n) of the joints that a motion takes: M(q) qdd + h(q, qd), by Newton and Euler's equations.

        Parameters
        ----------
        q, qd, qdd : array (..., n)
            Coordinates, radians and lengths, their speeds and accelerations.
        gravity : array (3,)
        status, strict : bool
            See `JointDynamics`.
        threads : int, optional
            Default: the package's (`bladesmith.set_threads`).
        """
        motion = {"q": q, "qd": qd, "qdd": qdd}
        return self._forces("inverse_dynamics", motion, gravity, status, strict, threads)

    @overload
    def bias_forces(
        self, q: ArrayLike, qd: ArrayLike, gravity: ArrayLike = ..., *,
        status: Literal[False] = ..., strict: bool = ..., threads: int | None = ...,
    ) -> Array: ...  # fmt: skip
    @overload
    def bias_forces(
        self, q: ArrayLike, qd: ArrayLike, gravity: ArrayLike = ..., *,
        status: Literal[True], strict: bool = ..., threads: int | None = ...,
    ) -> tuple[Array, Statuses]: ...  # fmt: skip
    def bias_forces(
        self, q: ArrayLike, qd: ArrayLike, gravity: ArrayLike = GRAVITY, *, status: bool = False,
        strict: bool = False, threads: int | None = None,
    ) -> Result:  # fmt: skip
        """Forces (..., n) of the joints at zero acceleration, h(q, qd): of velocities, and of gravity."""
        return self._forces("bias_forces", {"q": q, "qd": qd, "qdd": 0}, gravity, status, strict, threads)

    @overload
    def gravity_torques(
        self, q: ArrayLike, gravity: ArrayLike = ..., *,
        status: Literal[False] = ..., strict: bool = ..., threads: int | None = ...,
    ) -> Array: ...  # fmt: skip
    @overload
    def gravity_torques(
        self, q: ArrayLike, gravity: ArrayLike = ..., *,
        status: Literal[True], strict: bool = ..., threads: int | None = ...,
    ) -> tuple[Array, Statuses]: ...  # fmt: skip
    def gravity_torques(
        self, q: ArrayLike, gravity: ArrayLike = GRAVITY, *, status: bool = False, strict: bool = False,
        threads: int | None = None,
    ) -> Result:  # fmt: skip
        """Forces (..., n) of the joints that hold the links at rest."""
        return self._forces("gravity_torques", {"q": q, "qd": 0, "qdd": 0}, gravity, status, strict, threads)

    @overload
    def mass_matrix(
        self, q: ArrayLike, *,
        status: Literal[False] = ..., strict: bool = ..., threads: int | None = ...,
    ) -> Array: ...  # fmt: skip
    @overload
    def mass_matrix(
        self, q: ArrayLike, *,
        status: Literal[True], strict: bool = ..., threads: int | None = ...,
    ) -> tuple[Array, Statuses]: ...  # fmt: skip
    def mass_matrix(
        self, q: ArrayLike, *, status: bool = False, strict: bool = False, threads: int | None = None
    ) -> Result:
        """Matrices M(q) (..., n, n), symmetric: forces for a unit of acceleration of each joint."""
        (x,), lead = self._items({"q": q})
        return array_result(self._mass_matrix(x, lead, threads), None, "mass_matrix", status, strict, 2)

    @overload
    def forward_dynamics(
        self, q: ArrayLike, qd: ArrayLike, tau: ArrayLike, gravity: ArrayLike = ..., *,
        status: Literal[False] = ..., strict: bool = ..., threads: int | None = ...,
    ) -> Array: ...  # fmt: skip
    @overload
    def forward_dynamics(
        self, q: ArrayLike, qd: ArrayLike, tau: ArrayLike, gravity: ArrayLike = ..., *,
        status: Literal[True], strict: bool = ..., threads: int | None = ...,
    ) -> tuple[Array, Statuses]: ...  # fmt: skip
    def forward_dynamics(
        self, q: ArrayLike, qd: ArrayLike, tau: ArrayLike, gravity: ArrayLike = GRAVITY, *, status: bool = False,
        strict: bool = False, threads: int | None = None,
    ) -> Result:  # fmt: skip
        """Accelerations (..., n) under forces of the joints, M^-1 (tau - h(q, qd)), by articulated bodies.

        SINGULAR: a joint moves nothing that has an inertia.
        """
        tree = self.tree
        if tree.is_shared:
            return self._shared_accelerations(q, qd, tau, gravity, status, strict, threads)
        (x, speeds, forces), lead = self._items({"q": q, "qd": qd, "tau": tau})
        found = tree.driver.forward_dynamics(_gravity(gravity), x, speeds, forces, _count(lead), threads)
        accelerations = tree.restored(found).reshape(*lead, tree.count)
        codes = None
        if not np.isfinite(accelerations).all():
            finite = np.broadcast_to(_finite(x) & _finite(speeds) & _finite(forces), (_count(lead),)).reshape(lead)
            known = np.where(np.isfinite(accelerations).all(-1), Status.OK, Status.SINGULAR)
            codes = np.asarray(np.where(finite, known, Status.INVALID), np.uint8)
            accelerations[codes != Status.OK] = np.nan
        return array_result(accelerations, codes, "forward_dynamics", status, strict, 1)

    def _shared_accelerations(
        self, q: ArrayLike, qd: ArrayLike, tau: ArrayLike, gravity: ArrayLike, status: Any, strict: Any,
        threads: int | None,
    ) -> Result:  # fmt: skip
        """Accelerations of coordinates that joints share: by the mass matrix, for articulated bodies have one each."""
        given = {name: self._numbers(x, name) for name, x in (("q", q), ("qd", qd), ("tau", tau))}
        bias = self.bias_forces(given["q"], given["qd"], gravity, threads=threads)
        forces, matrices = given["tau"] - bias, self.mass_matrix(given["q"], threads=threads)
        shape = np.broadcast_shapes(forces.shape, matrices.shape[:-1])
        matrices, forces = np.broadcast_to(matrices, (*shape, shape[-1])), np.broadcast_to(forces, shape)
        finite = np.asarray(np.isfinite(forces).all(-1) & np.isfinite(matrices).all((-1, -2)))
        usable = np.where(finite[..., None, None], matrices, np.eye(shape[-1]))
        sizes = np.linalg.svd(usable, compute_uv=False)
        known = finite & (sizes[..., -1] > np.finfo(float).eps * sizes[..., 0])
        usable = np.where(known[..., None, None], usable, np.eye(shape[-1]))
        found = np.where(known[..., None], np.linalg.solve(usable, forces[..., None])[..., 0], np.nan)
        codes = np.asarray(np.where(known, Status.OK, np.where(finite, Status.SINGULAR, Status.INVALID)), np.uint8)
        return array_result(found, codes, "forward_dynamics", status, strict, 1)

    def bound(self, gravity: ArrayLike = GRAVITY) -> BoundDynamics:
        """Dynamics of one motion in a call of some microseconds, with arrays that are bound once: for control loops."""
        return BoundDynamics(self.tree, _gravity(gravity))

    def inverse_dynamics_derivatives(
        self, q: ArrayLike, qd: ArrayLike = 0, qdd: ArrayLike = 0, gravity: ArrayLike = GRAVITY, *,
        threads: int | None = None,
    ) -> InverseDerivatives:  # fmt: skip
        """Derivatives (..., n, n) of `inverse_dynamics` by coordinates, speeds and accelerations.

        A row for each force, a column for what it is derived by. The loops are the tangents of the algorithm itself.
        """
        motion = self._items({"q": q, "qd": qd, "qdd": qdd})
        by_q, by_qd = (self._derivative("inverse_dynamics", by, motion, gravity, threads) for by in ("x", "speeds"))
        return InverseDerivatives(by_q, by_qd, self._mass_matrix(motion[0][0], motion[1], threads))

    def forward_dynamics_derivatives(
        self, q: ArrayLike, qd: ArrayLike, tau: ArrayLike, gravity: ArrayLike = GRAVITY, *,
        threads: int | None = None,
    ) -> ForwardDerivatives:  # fmt: skip
        """Derivatives (..., n, n) of `forward_dynamics` by coordinates, speeds and forces; the last is M^-1."""
        if self.tree.is_shared:  # M qdd + h = tau, differentiated
            found = self.inverse_dynamics_derivatives(
                q, qd, self.forward_dynamics(q, qd, tau, gravity, threads=threads), gravity, threads=threads
            )
            inverse = np.linalg.inv(found.qdd)
            return ForwardDerivatives(-inverse @ found.q, -inverse @ found.qd, inverse)
        motion = self._items({"q": q, "qd": qd, "tau": tau})
        of = ("x", "speeds", "forces")
        return ForwardDerivatives(*(self._derivative("forward_dynamics", by, motion, gravity, threads) for by in of))

    def _derivative(
        self, name: str, by: str, motion: tuple[list[Array], tuple[int, ...]], gravity: ArrayLike, threads: int | None
    ) -> Array:
        tree, (given, lead) = self.tree, motion
        along = tree.directions(given[0]) if by == "x" else list(np.eye(tree.driver.count))
        found = tree.driver.derivative(name, by, _gravity(gravity), given, along, _count(lead), threads)
        return tree.restored_matrices(found).reshape(*lead, tree.count, tree.count)

    def _mass_matrix(self, x: Array, lead: tuple[int, ...], threads: int | None) -> Array:
        tree = self.tree
        items = np.broadcast_to(x, (_count(lead), x.shape[-1]))
        found = tree.restored_matrices(tree.driver.mass_matrix(items, threads))
        return found.reshape(*lead, tree.count, tree.count)

    def _forces(
        self, what: str, motion: Mapping[str, ArrayLike], gravity: ArrayLike, status: Any, strict: Any,
        threads: int | None,
    ) -> Result:  # fmt: skip
        (x, speeds, accelerations), lead = self._items(motion)
        tree = self.tree
        found = tree.driver.inverse_dynamics(_gravity(gravity), x, speeds, accelerations, _count(lead), threads)
        return array_result(tree.restored(found).reshape(*lead, tree.count), None, what, status, strict, 1)

    def _items(self, given: Mapping[str, ArrayLike]) -> tuple[list[Array], tuple[int, ...]]:
        """Arrays (items, n) or (n,) in the driver's order, and the shape of the items."""
        tree = self.tree
        arrays = {name: self._numbers(value, name) for name, value in given.items()}
        lead = broadcast_shapes({name: a.shape[:-1] for name, a in arrays.items()})
        flat = []
        for name, a in arrays.items():
            if a.ndim > 1:
                n = a.shape[-1]
                a = (a if a.shape[:-1] == lead else np.broadcast_to(a, (*lead, n))).reshape(_count(lead), n)
            flat.append(tree.positions(a) if name == "q" else tree.sorted(a))
        return flat, lead

    def _numbers(self, value: Any, name: str) -> Array:
        """Coordinates "q", speeds, accelerations or forces (..., n), one number for each; 0 is none."""
        tree = self.tree
        if _is_zero(value):
            return tree.neutral if name == "q" else np.zeros(tree.count)
        return _real(value, name, tree.coordinate_count if name == "q" else tree.count)


def _is_zero(value: Any) -> bool:
    return not isinstance(value, Mapping) and np.ndim(value) == 0 and bool(value == 0)


def _real(value: ArrayLike, name: str, count: int) -> Array:
    return np.asarray(real_array(value, name, (..., count)), np.float64)


def _finite(x: Array) -> Array:
    return np.asarray(np.isfinite(x).all(-1))


def _count(lead: tuple[int, ...]) -> int:
    return math.prod(lead)


def _gravity(gravity: ArrayLike) -> Array:
    return finite_array(gravity, "gravity", (3,))
