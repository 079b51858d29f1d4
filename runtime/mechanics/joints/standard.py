"""Joints by the objects that bodies share: spherical, cylindrical, screw, planar, revolute, prismatic, rigid (7.5)."""

from __future__ import annotations

from dataclasses import InitVar, dataclass, field
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...codegen.errors import InputError
from ...common.deprecation import renamed_attribute, renamed_keywords
from ...common.validation import as_float, finite_array
from ...core.multivector import Algebra, Multivector
from ..screws import geometry
from . import placement
from .base import Condition, Joint, check_kind, check_named, check_one_algebra, direction_of
from .local_relations import relations

Array = NDArray[Any]


def _is_line(x: Multivector) -> bool:
    return "line" in x.algebra.kinds and set(x.kind.blades) <= set(x.algebra.kind("line").blades)


def _same(x: Multivector, other: Multivector | None) -> Condition:
    return Condition(x, x if other is None else other)


@dataclass(frozen=True, eq=False)
class _SharedObject(Joint):
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
    geometry: Multivector = None  # type: ignore[assignment]  # then it is made from a position and directions
    other: Multivector | None = field(default=None, kw_only=True)
    kinds: ClassVar[tuple[str, ...]]
    is_sequence = True

    def _check(self) -> None:
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


@dataclass(frozen=True, eq=False)
class Spherical(_SharedObject):
    """Rotation about a shared point (7.5.1): a point, or in CGA a sphere. Mobility 3.

    Its coordinates are a rotation vector, its speeds those about the world's axes x, y, z, as they are at the start.
    In place of the object ``point=``, a position, of ``algebra=`` (`bladesmith.cga3d`, or `pga3d`).
    """

    point: InitVar[ArrayLike | None] = field(default=None, kw_only=True)
    algebra: InitVar[Algebra | None] = field(default=None, kw_only=True)
    kinds = ("point", "sphere", "flat_point")
    mobility = 3

    def __post_init__(self, point: ArrayLike | None, algebra: Algebra | None) -> None:
        placement.place(self, ("geometry",), placement.ball, algebra, point=point)
        self._check()


@dataclass(frozen=True, eq=False)
class Cylindrical(_SharedObject):
    """Rotation about a shared line and translation along it (7.5.2). Mobility 2.

    In place of the line ``point=`` and ``axis=``, of ``algebra=`` (`bladesmith.cga3d`, or `pga3d`).
    """

    point: InitVar[ArrayLike | None] = field(default=None, kw_only=True)
    axis: InitVar[ArrayLike | None] = field(default=None, kw_only=True)
    algebra: InitVar[Algebra | None] = field(default=None, kw_only=True)
    kinds = ("line", "twist")
    mobility = 2

    def __post_init__(self, point: ArrayLike | None, axis: ArrayLike | None, algebra: Algebra | None) -> None:
        placement.place(self, ("geometry",), placement.line, algebra, point=point, axis=axis)
        self._check()


@dataclass(frozen=True, eq=False)
class Screw(Cylindrical):
    """Rotation about a shared line, and translation along it by a pitch for each radian. Mobility 1.

    Parameters
    ----------
    a, b : str
    geometry : Multivector
        A line, or the twist of one, in the world, where the bodies are at the start.
    pitch : float
        Advance along the line for one radian, right-handed; a nut with a lead of 2 mm has 0.002/(2 pi).
    other : Multivector, optional
        The same line as the second body has it.
    point, axis : array (3,), optional
        In place of the line, of ``algebra`` (`bladesmith.cga3d`, or `pga3d`).
    """

    pitch: float = field(kw_only=True)
    mobility = 1

    def __post_init__(self, point: ArrayLike | None, axis: ArrayLike | None, algebra: Algebra | None) -> None:
        super().__post_init__(point, axis, algebra)
        object.__setattr__(self, "pitch", as_float(self.pitch, f"{self.label}: its pitch"))


@dataclass(frozen=True, eq=False)
class Planar(_SharedObject):
    """Translation in a shared plane and rotation about its normal (7.5.3). Mobility 3.

    In place of the plane ``point=`` and ``normal=``, of ``algebra=`` (`bladesmith.cga3d`, or `pga3d`).
    """

    point: InitVar[ArrayLike | None] = field(default=None, kw_only=True)
    normal: InitVar[ArrayLike | None] = field(default=None, kw_only=True)
    algebra: InitVar[Algebra | None] = field(default=None, kw_only=True)
    kinds = ("plane",)
    mobility = 3

    def __post_init__(self, point: ArrayLike | None, normal: ArrayLike | None, algebra: Algebra | None) -> None:
        placement.place(self, ("geometry",), placement.plane, algebra, point=point, normal=normal)
        self._check()


@dataclass(frozen=True, eq=False)
class Revolute(Joint):
    """Rotation about an axis through a point: ``Revolute("a", "b", point=(0, 0, 1), axis=(0, 1, 0))``. Mobility 1.

    Or about the axis of a shared circle, or about the line of a shared point pair (7.5.4). In PGA, which has neither,
    the axis is a line and a point on it: give both.

    Parameters
    ----------
    a, b : str
    geometry, point : Multivector
        In the world, where the bodies are at the start. It turns counter-clockwise about the circle's normal, from the
        first point of a pair to the second, along the line. Of a circle only center and normal count: any radius.
    point, axis : array (3,), optional
        In their place: a position and a direction, about which it turns counter-clockwise.
    algebra : Algebra, optional
        Of objects that are made from these: `bladesmith.cga3d` (default) or `pga3d`.
    other, other_point : Multivector, optional
        The same objects as the second body has them, if they are not (yet) at the first one's.
    """

    a: str
    b: str
    geometry: Multivector = None  # type: ignore[assignment]  # then it is made from point and axis
    point: Any = None  # of PGA
    other: Multivector | None = field(default=None, kw_only=True)
    other_point: Multivector | None = field(default=None, kw_only=True)
    axis: InitVar[ArrayLike | None] = field(default=None, kw_only=True)
    algebra: InitVar[Algebra | None] = field(default=None, kw_only=True)
    mobility = 1
    is_sequence = True

    def __post_init__(self, axis: ArrayLike | None, algebra: Algebra | None) -> None:
        if self.geometry is None or axis is not None or algebra is not None:
            position = self.point
            object.__setattr__(self, "point", None)
            placement.place(self, ("geometry", "point"), placement.hinge, algebra, point=position, axis=axis)
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
    """Translation along a line without rotation (7.5.5), by two shared objects. Mobility 1.

    Two distinct parallel lines; a line and a plane that contains its direction; a line and a direction that is not
    parallel to it; two planes that are not parallel. It slides along the first line, or along the cross product of the
    planes' normals.

    In their place ``axis=``, along which it slides, and ``point=``, where pictures show it, of ``algebra=``
    (`bladesmith.cga3d`, or `pga3d`).
    """

    a: str
    b: str
    first: Multivector = None  # type: ignore[assignment]  # then they are made from an axis
    second: Multivector = None  # type: ignore[assignment]
    axis: InitVar[ArrayLike | None] = field(default=None, kw_only=True)
    point: InitVar[ArrayLike | None] = field(default=None, kw_only=True)
    algebra: InitVar[Algebra | None] = field(default=None, kw_only=True)
    mobility = 1
    sliding = 1
    is_sequence = True
    remedy = (
        "Give two distinct parallel lines, a line and a plane along it, a line and another direction, or two planes "
        "that are not parallel"
    )

    def __post_init__(self, axis: ArrayLike | None, point: ArrayLike | None, algebra: Algebra | None) -> None:
        at = np.zeros(3) if point is None and axis is not None else point
        placement.place(self, ("first", "second"), placement.slide, algebra, point=at, axis=axis)
        check_named(self, [("the first object", self.first), ("the second object", self.second)])
        check_one_algebra(self, [self.first, self.second])
        relations(self.first.algebra, [self])

    def conditions(self) -> list[Condition]:
        return [Condition(self.first, self.first), Condition(self.second, self.second)]

    def axes(self, objects: list[Multivector]) -> Array | None:
        for x in objects:
            if _is_line(x):
                return direction_of(x)
        normals = [direction_of(x) for x in objects]
        return None if normals[0] is None or normals[1] is None else np.cross(normals[0], normals[1])


@renamed_keywords(place="position")
@dataclass(frozen=True, eq=False)
class Rigid(Joint):
    """Two bodies as one: a shared point and two shared planes through it. Mobility 0.

    Parameters
    ----------
    a, b : str
    position : array (3,)
        Where the bodies meet.
    algebra : Algebra, optional
        `bladesmith.cga3d` (default) or `pga3d`.
    """

    a: str
    b: str
    position: ArrayLike = (0.0, 0.0, 0.0)
    algebra: Algebra | None = None
    mobility = 0
    is_sequence = True
    place = renamed_attribute("position")

    def __post_init__(self) -> None:
        check_named(self, [])
        geometry(self.algebra, f"{self.label}: its algebra")
        finite_array(self.position, f"{self.label}: its position", (3,))

    def conditions(self) -> list[Condition]:
        algebra, position = geometry(self.algebra), np.asarray(self.position, float)
        planes = [algebra.plane(normal, position @ normal) for normal in np.eye(3)[:2]]
        return [Condition(x, x) for x in (algebra.point(position), *planes)]
