"""Joints: geometry that two bodies share (thesis 7.5), given in the world where the bodies are at the start.

A joint is one or more bilinear conditions B(X, Y) = H on an object X of one body and an object Y of the other. For most
it is X = Y.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from ..algebras import Algebra
from ..calls import call
from ..codegen.errors import InputError, ShapeError
from ..dynamics.given import LARGEST_COEFFICIENT, check_coefficients, finite, shown
from ..multivector import Multivector

Array = NDArray[Any]


@dataclass(frozen=True, eq=False)
class Condition:
    """B(X, Y) = H of an object of the first body and one of the second, both in the world at the start.

    Attributes
    ----------
    x, y : Multivector
    product : callable, optional
        B; None where the objects are one and stay one.
    target : Multivector or float, optional
        H; what B is at the start, if left out.
    equivariant : bool
        Whether B goes along when X and Y are moved as one.
    """

    x: Multivector
    y: Multivector
    product: Callable[[Multivector, Multivector], Any] | None = None
    target: Any = None
    equivariant: bool = True


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
    #: Of these freedoms, how many are slides; None where that is not checked.
    sliding: ClassVar[int | None] = None
    remedy: str = ""

    def axes(self, objects: list[Multivector]) -> Array | None:
        """Directions (n, 3) that the coordinates of n joints of this sort grow along, or turn about, of the objects
        (n,) of their conditions."""
        return None

    def conditions(self) -> list[Condition]:
        """What it asks for."""
        raise NotImplementedError

    @property
    def label(self) -> str:
        """For messages."""
        return f"{type(self).__name__}({self.a!r}, {self.b!r})"


def check_named(joint: Joint, objects: Iterable[tuple[str, Any]]) -> None:
    """Check the names and objects of a joint."""
    for name in (joint.a, joint.b):
        if not isinstance(name, str) or not name:
            raise InputError(f"a joint is between bodies by name; {name!r} is none.")
    if joint.a == joint.b:
        raise InputError(f"{joint.label} is between a body and itself.")
    for what, x in objects:
        if not isinstance(x, Multivector):
            raise InputError(f"{joint.label}: {what} is {shown(x)}; one multivector is needed.")
        if x.shape:
            raise InputError(f"{joint.label}: {what} is a batch {x.shape}; one multivector is needed.")
        if "twist" not in x.algebra.kinds:
            raise InputError(f"{joint.label}: {what} is of {x.algebra.name}; joints are of cga3d or pga3d.")
        if np.iscomplexobj(x.values):
            raise InputError(f"{joint.label}: {what} holds complex numbers; real ones are needed.")
        check_coefficients(x, f"{joint.label}: {what}")
        if float(np.abs(x.values).max()) > LARGEST_COEFFICIENT:
            raise InputError(f"{joint.label}: {what} has coefficients beyond {LARGEST_COEFFICIENT:g}.")
        if not np.any(x.values):
            raise InputError(f"{joint.label}: {what} is zero; it holds nothing.")


def check_one_algebra(joint: Joint, objects: list[Multivector]) -> None:
    names = {x.algebra.name for x in objects}
    if len(names) > 1:
        raise InputError(f"{joint.label}: its objects are of {' and '.join(sorted(names))}; one algebra is needed.")


def check_kind(joint: Joint, x: Multivector, kinds: tuple[str, ...], what: str) -> None:
    """Check the kind of an object, by what it is and not by how it was made."""
    for kind in kinds:
        if kind in x.algebra.kinds:
            known = x.algebra.kind(kind)
            if set(x.kind.blades) <= set(known.blades):
                return
    raise InputError(f"{joint.label}: {what} is a {x.kind.name}; a {' or a '.join(kinds)} is needed.")


def direction_of(x: Multivector) -> Array | None:
    """Directions (..., 3) of axes, or normals; None of what has none. They are not of a length of one."""
    for kind in ("line", "circle", "plane", "point_pair"):  # a line is a circle too
        if kind in x.algebra.kinds and set(x.kind.blades) <= set(x.algebra.kind(kind).blades):
            p = x.as_kind(kind, check=False).parameters()
            found = p.b - p.a if kind == "point_pair" else p.direction if kind == "line" else p.normal
            if np.isfinite(found).all():
                return np.asarray(found)
    if set(x.kind.blades) <= set(x.algebra.kind("twist").blades):  # a screw has an axis too
        return np.asarray(call(x.algebra, "mechanics.screw_vectors", x).values[0].values)
    return None


def _is_line(x: Multivector) -> bool:
    return "line" in x.algebra.kinds and set(x.kind.blades) <= set(x.algebra.kind("line").blades)


def _same(x: Multivector, other: Multivector | None) -> Condition:
    return Condition(x, x if other is None else other)


@dataclass(frozen=True, eq=False)
class _Shared(Joint):
    """A joint that is one object, the same in both bodies.

    Parameters
    ----------
    a, b : str
        The bodies.
    geometry : Multivector
        In the world, where the bodies are at the start.
    other : Multivector, optional
        The same object as the second body has it, if that is not (yet) at the first one's: see `Mechanism.residual`.
    """

    a: str
    b: str
    geometry: Multivector
    other: Multivector | None = field(default=None, kw_only=True)
    kinds: ClassVar[tuple[str, ...]]

    def __post_init__(self) -> None:
        what = f"the {self.kinds[0]}"
        given = [self.geometry] if self.other is None else [self.geometry, self.other]
        for x in given:
            check_named(self, [(what, x)])
            check_kind(self, x, self.kinds, what)
        check_one_algebra(self, given)

    def conditions(self) -> list[Condition]:
        return [_same(self.geometry, self.other)]

    def axes(self, objects: list[Multivector]) -> Array | None:
        return direction_of(objects[0])


class Spherical(_Shared):
    """Turning about a shared point (7.5.1): a point, or in CGA a sphere. Mobility 3.

    Its coordinates are a rotation vector, its speeds those about the world's axes x, y, z, as they are at the start.
    """

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


@dataclass(frozen=True, eq=False)
class Revolute(Joint):
    """Turning about the axis of a shared circle, or about the line of a shared point pair (7.5.4). Mobility 1.

    In PGA, which has neither, the axis is a line and a point on it: give both.

    Parameters
    ----------
    a, b : str
    geometry, point : Multivector
        In the world, where the bodies are at the start. It turns counter-clockwise about the circle's normal, from the
        first point of a pair to the second, along the line.
    other, other_point : Multivector, optional
        The same objects as the second body has them, if they are not (yet) at the first one's.
    """

    a: str
    b: str
    geometry: Multivector
    point: Multivector | None = None
    other: Multivector | None = field(default=None, kw_only=True)
    other_point: Multivector | None = field(default=None, kw_only=True)
    mobility = 1

    def __post_init__(self) -> None:
        kinds = ("circle", "point_pair") if self.point is None else ("line", "twist")
        what = "the geometry" if self.point is None else "the axis"
        if self.point is None and self.other_point is not None:
            raise InputError(f"{self.label}: other_point is given without a point.")
        lines = [self.geometry] if self.other is None else [self.geometry, self.other]
        points = [x for x in (self.point, self.other_point) if x is not None]
        for x in lines:
            check_named(self, [(what, x)])
            if self.point is None and x.algebra.name == "pga3d":
                raise InputError(f"{self.label}: in pga3d it is given by a line and a point on it; there is no point.")
            check_kind(self, x, kinds, what)
        for x in points:
            check_named(self, [("the point", x)])
            check_kind(self, x, ("point",), "the point")
        check_one_algebra(self, [*lines, *points])

    def conditions(self) -> list[Condition]:
        found = [_same(self.geometry, self.other)]
        return found if self.point is None else [*found, _same(self.point, self.other_point)]

    def axes(self, objects: list[Multivector]) -> Array | None:
        return direction_of(objects[0])


@dataclass(frozen=True, eq=False)
class Prismatic(Joint):
    """Sliding along a line without turning (7.5.5), by two shared objects. Mobility 1.

    Two distinct parallel lines; a line and a plane that contains its direction; a line and a direction that is not
    parallel to it; two planes that are not parallel. It slides along the first line, or along the cross product of the
    planes' normals.
    """

    a: str
    b: str
    first: Multivector
    second: Multivector
    mobility = 1
    sliding = 1
    remedy = (
        "Give two distinct parallel lines, a line and a plane along it, a line and another direction, or two planes "
        "that are not parallel"
    )

    def __post_init__(self) -> None:
        check_named(self, [("the first object", self.first), ("the second object", self.second)])
        check_one_algebra(self, [self.first, self.second])
        from .local import relations

        relations(self.first.algebra, [self])

    def conditions(self) -> list[Condition]:
        return [Condition(self.first, self.first), Condition(self.second, self.second)]

    def axes(self, objects: list[Multivector]) -> Array | None:
        for x in objects:
            if _is_line(x):
                return direction_of(x)
        normals = [direction_of(x) for x in objects]
        return None if normals[0] is None or normals[1] is None else np.cross(normals[0], normals[1])


@dataclass(frozen=True, eq=False)
class Rigid(Joint):
    """Two bodies as one: a shared point and two shared planes through it. Mobility 0.

    Parameters
    ----------
    a, b : str
    place : array (3,)
        Where the bodies meet.
    algebra : Algebra, optional
        `bladesmith.cga3d` (default) or `pga3d`.
    """

    a: str
    b: str
    place: Any = (0.0, 0.0, 0.0)
    algebra: Any = None
    mobility = 0

    def __post_init__(self) -> None:
        check_named(self, [])
        from ..dynamics.screws import geometry

        if self.algebra is not None and not isinstance(self.algebra, Algebra):
            raise InputError(
                f"{self.label}: its algebra is {shown(self.algebra)}; bladesmith.cga3d or pga3d is needed."
            )
        geometry(self.algebra)
        place = finite(self.place, f"{self.label}: its place")
        if place.shape != (3,):
            raise ShapeError(f"{self.label}: its place has shape {place.shape}; three numbers are needed.")

    def conditions(self) -> list[Condition]:
        from ..dynamics.screws import geometry

        algebra, place = geometry(self.algebra), np.asarray(self.place, float)
        planes = [algebra.plane(normal, place @ normal) for normal in np.eye(3)[:2]]
        return [Condition(x, x) for x in (algebra.point(place), *planes)]
