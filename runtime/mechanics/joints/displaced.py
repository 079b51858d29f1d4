"""Joints displaced with their bodies, and their closure errors."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...core.geometry.scaling import in_units
from ...core.multivector import Algebra, Multivector
from .base import Condition, Joint
from .joint_locations import extent, joint_locations, length_scales

Array = NDArray[Any]


@dataclass(frozen=True, eq=False)
class DisplacedJoint(Joint):
    """A joint after displacements of its bodies.

    Attributes
    ----------
    joint : Joint
        Before the displacements.
    motor_a, motor_b : Multivector
        Displacements of its bodies.
    """

    joint: Joint
    motor_a: Multivector
    motor_b: Multivector

    def __post_init__(self) -> None:
        if isinstance(self.joint, DisplacedJoint):
            inner = self.joint
            object.__setattr__(self, "joint", inner.joint)
            object.__setattr__(self, "motor_a", self.motor_a * inner.motor_a)
            object.__setattr__(self, "motor_b", self.motor_b * inner.motor_b)

    @property
    def a(self) -> str:  # type: ignore[override]
        return self.joint.a

    @property
    def b(self) -> str:  # type: ignore[override]
        return self.joint.b

    @property
    def mobility(self) -> int:  # type: ignore[override]
        return self.joint.mobility

    @property
    def label(self) -> str:
        return self.joint.label

    @property
    def sliding(self) -> int | None:  # type: ignore[override]
        return self.joint.sliding

    @property
    def remedy(self) -> str:  # type: ignore[override]
        return self.joint.remedy

    @property
    def pitch(self) -> float | None:  # type: ignore[override]
        return self.joint.pitch

    def axes(self, objects: list[Multivector]) -> Array | None:
        return self.joint.axes(objects)

    def conditions(self) -> list[Condition]:
        return [self._displaced_condition(c) for c in self.joint.conditions()]

    def _displaced_condition(self, c: Condition) -> Condition:
        x, y, back = self.motor_a >> c.x, self.motor_b >> c.y, ~self.motor_a
        product = c.product
        if product is None or c.equivariant:
            target = self.motor_a >> c.target if isinstance(c.target, Multivector) else c.target
            return replace(c, x=x, y=y, target=target)
        return replace(c, x=x, y=y, product=lambda u, v: product(back >> u, back >> v))


def closure_errors(algebra: Algebra, joints: Sequence[Joint]) -> list[float]:
    """Closure error of each joint, relative to its length scale or, if it has none, to the extent of the mechanism."""
    conditions = [joint.conditions() for joint in joints]
    displaced = [c for each in conditions for c in each if not _is_undisplaced(c)]
    if not displaced:
        return [0.0] * len(joints)
    ends = np.concatenate([joint_locations([x[None]], 1) for c in displaced for x in (c.x, c.y)])
    size = extent(ends, (ends.min(0) + ends.max(0)) / 2) or 1.0
    return [max((_closure_error(algebra, c, size) for c in each), default=0.0) for each in conditions]


def _is_undisplaced(c: Condition) -> bool:
    return c.x is c.y and c.product is None


def _closure_error(algebra: Algebra, c: Condition, extent_of_all: float) -> float:
    if _is_undisplaced(c):
        return 0.0
    x, y = c.x, c.y
    zero = not isinstance(c.target, Multivector) and not c.target  # others hold only for these positions
    if c.product is None or (c.equivariant and zero):
        objects = [x] if c.product is None else [x, y]
        position = joint_locations([v[None] for v in objects], 1)
        away = ~algebra.translator(position[0])
        unit = length_scales([(away >> v)[None] for v in objects], position, extent_of_all)[0]
        x, y = (in_units(away >> v, unit) for v in (x, y))
    if c.product is None:
        return _magnitude(x - y) / max(_magnitude(x), np.finfo(float).tiny)
    value = c.product(x, y)
    if c.target is not None:
        value = value - c.target
    scale = _magnitude(x) * _magnitude(y)
    return _magnitude(value) / scale if scale > 0 else 0.0


def _magnitude(x: Any) -> float:
    return float(np.abs(x.values if isinstance(x, Multivector) else x).max(initial=0))
