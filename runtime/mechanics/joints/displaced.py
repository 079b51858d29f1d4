"""Poses of a mechanism: joints that are moved with their bodies, and how far they are from closed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..algebras import Algebra
from ..lengths import in_units
from ..multivector import Multivector
from .joints import Condition, Joint
from .places import places_of, spread_of, units_of

Array = NDArray[Any]


@dataclass(frozen=True, eq=False)
class Placed(Joint):
    """A joint whose bodies have moved.

    Attributes
    ----------
    joint : Joint
        As it was at first.
    motor_a, motor_b : Multivector
        Of its bodies, from there.
    """

    joint: Joint
    motor_a: Multivector
    motor_b: Multivector

    def __post_init__(self) -> None:
        if isinstance(self.joint, Placed):
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

    def axes(self, objects: list[Multivector]) -> Array | None:
        return self.joint.axes(objects)

    def conditions(self) -> list[Condition]:
        return [self._moved(c) for c in self.joint.conditions()]

    def _moved(self, c: Condition) -> Condition:
        x, y, back = self.motor_a >> c.x, self.motor_b >> c.y, ~self.motor_a
        product = c.product
        if product is None or c.equivariant:
            target = self.motor_a >> c.target if isinstance(c.target, Multivector) else c.target
            return replace(c, x=x, y=y, target=target)
        return replace(c, x=x, y=y, product=lambda u, v: product(back >> u, back >> v))


def misfit(algebra: Algebra, joints: Sequence[Joint]) -> list[float]:
    """How far each joint is from holding, in its own length, or, of those that have none, in that of all."""
    conditions = [joint.conditions() for joint in joints]
    moved = [c for own in conditions for c in own if not _as_it_was(c)]
    if not moved:
        return [0.0] * len(joints)
    ends = np.concatenate([places_of([x[None]], 1) for c in moved for x in (c.x, c.y)])
    spread = spread_of(ends, (ends.min(0) + ends.max(0)) / 2) or 1.0
    return [max((_gap(algebra, c, spread) for c in own), default=0.0) for own in conditions]


def _as_it_was(c: Condition) -> bool:
    return c.x is c.y and c.product is None


def _gap(algebra: Algebra, c: Condition, spread: float) -> float:
    if _as_it_was(c):
        return 0.0
    x, y = c.x, c.y
    zero = not isinstance(c.target, Multivector) and not c.target  # any other value is one of these places and lengths
    if c.product is None or (c.equivariant and zero):
        seen = [x] if c.product is None else [x, y]
        place = places_of([v[None] for v in seen], 1)
        away = ~algebra.translator(place[0])
        unit = units_of([(away >> v)[None] for v in seen], place, spread)[0]
        x, y = (in_units(away >> v, unit) for v in (x, y))
    if c.product is None:
        return _size(x - y) / max(_size(x), np.finfo(float).tiny)
    value = c.product(x, y)
    if c.target is not None:
        value = value - c.target
    size = _size(x) * _size(y)
    return _size(value) / size if size > 0 else 0.0


def _size(x: Any) -> float:
    return float(np.abs(x.values if isinstance(x, Multivector) else x).max(initial=0))
