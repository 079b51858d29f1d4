"""Poses of a mechanism in a batch: motors of its bodies, each with a status."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ....codegen.errors import InputError
from ....common.validation import as_instance, broadcast_shapes
from ....core.geometry.motors import motors_from
from ....core.multivector import Algebra, Multivector
from ....dispatch.formulas import evaluate
from ....dispatch.multivector_data import statuses
from ....mechanics.arguments import multivector_of
from ....mechanics.twists import screw_vectors
from ....status import Status
from ..structure import Assembly

Array = NDArray[Any]


class Poses(Mapping[str, Multivector]):
    """Poses of a mechanism: motors (...) of bodies by name, relative to the mechanism's own pose; NaN where no pose is
    found.

    Attributes
    ----------
    mechanism : Assembly
    own : array (..., bodies, 8)
        Motors of the bodies of `moving`, in the mechanism's frame.
    residual : array (...)
        The largest error of a joint or target, in the mechanism's unit of length.
    status : array of Status (...)
        OK; UNREACHABLE: proved, given positions are further apart than the bodies between them are long;
        NOT_CONVERGED: the search stalled or ran out of steps, which proves nothing; INVALID: input is not finite.
    """

    def __init__(self, mechanism: Assembly, own: Array, residual: Array, status: Array) -> None:
        self.mechanism, self.own, self.residual = mechanism, own, residual
        self.status = statuses(status, status.shape)

    @classmethod
    def of_item(cls, mechanism: Assembly, own: Array, residual: Any) -> Poses:
        """One pose that was found."""
        new = cls.__new__(cls)
        new.mechanism, new.own, new.residual, new.status = mechanism, own, np.array(residual), Status.OK
        return new

    @cached_property
    def _motors(self) -> Array:
        return self.mechanism.motors_to_world(self.own)

    def __getitem__(self, body: str) -> Multivector:
        b, algebra = self.mechanism.body_index(body), self.mechanism.algebra
        if b < 0:
            rest = np.zeros((*self.shape, 8))
            rest[..., algebra.kind("motor").blades.index(0)] = 1
            return algebra.wrap(algebra.kind("motor"), rest)
        return algebra.wrap(algebra.kind("motor"), np.ascontiguousarray(self._motors[..., b, :]))

    def __iter__(self) -> Any:
        return iter(self.mechanism.bodies)

    def __len__(self) -> int:
        return len(self.mechanism.bodies)

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the batch."""
        return self.own.shape[:-2]

    def __repr__(self) -> str:
        bad = int(np.count_nonzero(self.status))
        return f"<Poses {self.shape} of {self.mechanism!r}{f'; {bad} not found' if bad else ''}>"

    def coordinates(self, joint: Any) -> Array:
        """Coordinates (..., f) of a joint, relative to the mechanism's own pose; angles in (-pi, pi]."""
        m = self.mechanism
        j = m.find_joint(joint)
        if j is None:
            raise InputError(f"{joint!r} is not a joint of this mechanism.")
        relation = m.loops.relations[j]
        a, b = (self[name] for name in (m.joints[j].a, m.joints[j].b))
        relative = m.motors_from_world((~a * b).as_kind("motor", check=False).values)
        algebra = m.algebra
        one = np.zeros_like(relative)
        one[..., algebra.kind("motor").blades.index(0)] = 1
        kind = algebra.kind("motor")
        twist = evaluate(algebra, "joints.twist_between", algebra.wrap(kind, one), algebra.wrap(kind, relative)).value
        if pitch := m.joints[j].pitch:
            return _angles_of_screw(algebra, twist.values, relation.free[:, 0], pitch / m.frame.unit)[..., None]
        coordinates: Array = twist.values @ relation.to_coordinates.T
        return coordinates


def _angles_of_screw(algebra: Algebra, twists: Array, free: Array, pitch: float) -> Array:
    """Angles (...) of a screw joint from logarithms of its displacements: how far it has come says which turn."""
    axis, _ = screw_vectors(algebra, free)
    angle, path = (x @ axis for x in screw_vectors(algebra, twists))
    found: Array = angle + 2 * np.pi * np.round((path / pitch - angle) / (2 * np.pi))
    return found


def poses_of(mechanism: Assembly, x: Any, what: str) -> Poses:
    """Poses of this mechanism, from poses or from motors of bodies by name."""
    if not isinstance(x, Poses):
        return _poses_from_motors(mechanism, x)
    if x.mechanism is not mechanism:
        raise InputError(f"{what} is of another mechanism.", remedy="Give motors by body, as dict(poses) has them")
    return x


def _poses_from_motors(mechanism: Assembly, motors: Mapping[str, Multivector]) -> Poses:
    """Poses from motors of bodies by name; bodies that are not named stay."""
    as_instance(motors, "poses", Mapping, "a mapping of bodies to motors, or Poses,")
    algebra = mechanism.algebra
    coefficients = {}
    for name, motor in motors.items():
        if mechanism.body_index(name) >= 0:
            coefficients[name] = motor_coefficients(mechanism, motor, f"the motor of {name!r}")
    shape = broadcast_shapes({f"the motor of {name!r}": x.shape[:-1] for name, x in coefficients.items()})
    values = np.zeros((*shape, len(mechanism.moving), 8))
    values[..., algebra.kind("motor").blades.index(0)] = 1
    for name, rows in coefficients.items():
        values[..., mechanism.body_index(name), :] = rows
    return Poses(mechanism, mechanism.motors_from_world(values), np.zeros(shape), np.zeros(shape, np.uint8))


def motor_coefficients(mechanism: Assembly, x: Any, what: str) -> Array:
    """Coefficients (..., 8) of motors, NaN where an item is not finite."""
    algebra = mechanism.algebra
    kind = algebra.kind("motor")
    x = motors_from(x, algebra, what)
    bad = ~np.isfinite(x.values).all(-1)
    clean = algebra.scalar(1.0) if bad.all() else x
    if bad.any() and not bad.all():
        clean = x.algebra.wrap(x.kind.layout, np.where(bad[..., None], x.values[~bad][0], x.values))
    values = np.array(
        np.broadcast_to(multivector_of(clean, algebra, what).as_kind("motor").values, (*x.shape, kind.size))
    )
    values[bad] = np.nan
    return values
