"""Joints: geometry that two bodies share (thesis 7.5), given in the world where the bodies are at the start.

A joint is one or more bilinear conditions B(X, Y) = H on an object X of one body and an object Y of the other. For most
it is X = Y.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from ..codegen.errors import InputError, suggest
from ..multivector import Multivector

#: Products of `Bilinear` by name.
PRODUCTS: dict[str, Callable[[Multivector, Multivector], Multivector]] = {
    "outer": lambda x, y: x ^ y,
    "inner": lambda x, y: x | y,
    "meet": lambda x, y: x.meet(y),
    "anticommutator": lambda x, y: x.anticommutator(y),
}


@dataclass(frozen=True)
class Condition:
    """B(X, Y) = H of an object of the first body and one of the second, both in the world at the start.

    Attributes
    ----------
    x, y : Multivector
    product : callable, optional
        B; None where the objects are one and stay one.
    target : Multivector or float, optional
        H; what B is at the start, if left out.
    """

    x: Multivector
    y: Multivector
    product: Callable[[Multivector, Multivector], Any] | None = None
    target: Any = None


class Joint:
    """A joint between two bodies, by their names.

    Attributes
    ----------
    a, b : str
    mobility : int
        Of one body against the other.
    """

    a: str
    b: str
    mobility: int

    def conditions(self) -> list[Condition]:
        """What it asks for."""
        raise NotImplementedError

    @property
    def label(self) -> str:
        """For messages."""
        return f"{type(self).__name__}({self.a!r}, {self.b!r})"


def _named(joint: Joint, objects: Iterable[tuple[str, Any]]) -> None:
    """Check the names and objects of a joint."""
    for name in (joint.a, joint.b):
        if not isinstance(name, str) or not name:
            raise InputError(f"a joint is between bodies by name; {name!r} is none.")
    if joint.a == joint.b:
        raise InputError(f"{joint.label} is between a body and itself.")
    for what, x in objects:
        if not isinstance(x, Multivector) or x.shape:
            raise InputError(f"{joint.label}: {what} is a {type(x).__name__}; one multivector is needed.")
        if not np.isfinite(x.values).all():
            raise InputError(f"{joint.label}: {what} is not finite.")


def _of_kind(joint: Joint, x: Multivector, kinds: tuple[str, ...], what: str) -> None:
    """Check the kind of an object, by what it is and not by how it was made."""
    for kind in kinds:
        if kind in x.algebra.kinds:
            known = x.algebra.kind(kind)
            if set(x.kind.blades) <= set(known.blades):
                return
    raise InputError(f"{joint.label}: {what} is a {x.kind.name}; a {' or a '.join(kinds)} is needed.")


@dataclass(frozen=True)
class _Shared(Joint):
    """A joint that is one object, the same in both bodies."""

    a: str
    b: str
    geometry: Multivector
    kinds: ClassVar[tuple[str, ...]]

    def __post_init__(self) -> None:
        what = f"the {self.kinds[0]}"
        _named(self, [(what, self.geometry)])
        _of_kind(self, self.geometry, self.kinds, what)

    def conditions(self) -> list[Condition]:
        return [Condition(self.geometry, self.geometry)]


class Spherical(_Shared):
    """Turning about a shared point (7.5.1): a point, or in CGA a sphere. Mobility 3."""

    kinds = ("point", "sphere", "flat_point")
    mobility = 3


class Cylindrical(_Shared):
    """Turning about a shared line and sliding along it (7.5.2). Mobility 2."""

    kinds = ("line", "twist")
    mobility = 2


class Planar(_Shared):
    """Sliding in a shared plane and turning about its normal (7.5.3). Mobility 3."""

    kinds = ("plane",)
    mobility = 3


@dataclass(frozen=True)
class Revolute(Joint):
    """Turning about the axis of a shared circle, or about the line of a shared point pair (7.5.4). Mobility 1.

    In PGA, which has neither, the axis is a line and a point on it: give both.
    """

    a: str
    b: str
    geometry: Multivector
    point: Multivector | None = None
    mobility = 1

    def __post_init__(self) -> None:
        objects = [("the geometry", self.geometry), ("the point", self.point)]
        _named(self, objects[: 1 if self.point is None else 2])
        if self.point is None:
            _of_kind(self, self.geometry, ("circle", "point_pair"), "the geometry")
        else:
            _of_kind(self, self.geometry, ("line", "twist"), "the axis")

    def conditions(self) -> list[Condition]:
        found = [Condition(self.geometry, self.geometry)]
        return found if self.point is None else [*found, Condition(self.point, self.point)]


@dataclass(frozen=True)
class Prismatic(Joint):
    """Sliding along a line without turning (7.5.5), by two shared objects. Mobility 1.

    Two distinct parallel lines; a line and a plane that contains its direction; a line and a direction that is not
    parallel to it; two planes that are not parallel.
    """

    a: str
    b: str
    first: Multivector
    second: Multivector
    mobility = 1

    def __post_init__(self) -> None:
        _named(self, [("the first object", self.first), ("the second object", self.second)])
        from ..dynamics.pins import twists_left

        left = len(twists_left([self.first, self.second]))
        if left != 1:
            raise InputError(
                f"{self.label}: these two objects leave a mobility of {left}, not of 1.",
                remedy="Give two distinct parallel lines, a line and a plane along it, a line and another direction, "
                "or two planes that are not parallel",
            )

    def conditions(self) -> list[Condition]:
        return [Condition(self.first, self.first), Condition(self.second, self.second)]


@dataclass(frozen=True)
class Universal(Joint):
    """Two circles about one centre, one in each body, whose planes stay at right angles (7.5.6). Mobility 2.

    The printed condition, that <X Y>_4 = 0, only keeps them on one sphere: here the centre is shared, and
    (X ^ n_inf) . (Y ^ n_inf) = 0.
    """

    a: str
    b: str
    circle_a: Multivector
    circle_b: Multivector
    mobility = 2

    def __post_init__(self) -> None:
        _named(self, [("the first circle", self.circle_a), ("the second circle", self.circle_b)])
        circles = [x.parameters() for x in (self.circle_a, self.circle_b)]
        gap = float(np.linalg.norm(circles[0].center - circles[1].center))
        if gap > 1e-9 * (float(np.abs(circles[0].center).max()) + float(circles[0].radius)):
            raise InputError(f"{self.label}: the centres of the circles are {gap:.3g} apart; they are one.")
        cosine = float(circles[0].normal @ circles[1].normal)
        if abs(cosine) > 1e-9:
            raise InputError(f"{self.label}: the circles' planes are not at right angles; the cosine is {cosine:.3g}.")

    def conditions(self) -> list[Condition]:
        algebra = self.circle_a.algebra
        center = algebra.point(self.circle_a.parameters().center)
        infinity = algebra.multivector({"ni": 1.0})

        def cosine(x: Multivector, y: Multivector) -> Multivector:
            return (x ^ infinity) | (y ^ infinity)

        return [Condition(center, center), Condition(self.circle_a, self.circle_b, cosine, 0.0)]


@dataclass(frozen=True)
class Bilinear(Joint):
    """Any bilinear condition B(X, Y) = H of an object of each body (7.5).

    Parameters
    ----------
    a, b : str
    x, y : Multivector
        In the world at the start; x belongs to a, y to b.
    product : {"outer", "inner", "meet", "anticommutator"} or callable
    H : Multivector or float
    """

    a: str
    b: str
    x: Multivector
    y: Multivector
    product: str | Callable[[Multivector, Multivector], Any] = "outer"
    H: Any = 0
    mobility = -1

    def __post_init__(self) -> None:
        _named(self, [("x", self.x), ("y", self.y)])
        if not callable(self.product) and self.product not in PRODUCTS:
            raise InputError(
                f"{self.label}: {self.product!r} is no product; there are: {', '.join(PRODUCTS)}, and functions of two "
                f"objects.{suggest(self.product, PRODUCTS)}"
            )

    def conditions(self) -> list[Condition]:
        product = self.product if callable(self.product) else PRODUCTS[self.product]
        return [Condition(self.x, self.y, product, self.H)]
