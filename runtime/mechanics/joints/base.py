"""Joints: geometry that two bodies share (thesis 7.5), given in the world where the bodies are at the start.

A joint is one or more bilinear conditions B(X, Y) = H on an object X of one body and an object Y of the other. For most
it is X = Y.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from ...codegen.errors import InputError
from ...common.validation import as_instance, as_word, check_shape
from ...core.multivector import Multivector
from ...dispatch.formulas import evaluate
from ..arguments import LARGEST_COEFFICIENT, check_coefficients

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
        True if B commutes with displacements of X and Y as one.
    """

    x: Multivector
    y: Multivector
    product: Callable[[Multivector, Multivector], Any] | None = None
    target: Multivector | float | None = None
    equivariant: bool = True


class Joint:
    """A joint between two bodies, by their names.

    Attributes
    ----------
    a, b : str
    mobility : int
        Degrees of freedom of one body relative to the other.
    """

    a: str
    b: str
    mobility: int
    #: Number of translations among these degrees of freedom; None: not checked.
    sliding: ClassVar[int | None] = None
    remedy: str = ""
    #: Of a rotation that translates along its axis: the advance for a radian, right-handed. Objects do not say it: they
    #: leave both motions, of which the joint has one.
    pitch: float | None = None
    #: Whether the joint is its free motions one after the other: of translations, then of rotations.
    is_sequence: ClassVar[bool] = False

    def axes(self, objects: list[Multivector]) -> Array | None:
        """Directions (n, 3) of the coordinates of n joints of this type, from the objects (n,) of their conditions."""
        return None

    def conditions(self) -> list[Condition]:
        """Bilinear conditions of the joint."""
        raise NotImplementedError

    def rotations(self) -> tuple[Array, Array] | None:
        """A point and axes (n, 3) of rotations, in the order in which they come, where free twists do not say it."""
        return None

    @property
    def label(self) -> str:
        """Text for messages."""
        return f"{type(self).__name__}({self.a!r}, {self.b!r})"


def check_named(joint: Joint, objects: Iterable[tuple[str, Any]]) -> None:
    """Check the names and objects of a joint."""
    for name in (joint.a, joint.b):
        as_word(name, "the name of a joint's body")
    if joint.a == joint.b:
        raise InputError(f"{joint.label} is between a body and itself.")
    for what, x in objects:
        check_shape(
            as_instance(x, f"{joint.label}: {what}", Multivector, "one multivector"), f"{joint.label}: {what}", ()
        )
        if "twist" not in x.algebra.kinds:
            raise InputError(f"{joint.label}: {what} is of {x.algebra.name}; joints are of cga3d or pga3d.")
        if np.iscomplexobj(x.values):
            raise InputError(f"{joint.label}: {what} holds complex numbers; real ones are needed.")
        check_coefficients(x, f"{joint.label}: {what}")
        if float(np.abs(x.values).max()) > LARGEST_COEFFICIENT:
            raise InputError(f"{joint.label}: {what} has coefficients beyond {LARGEST_COEFFICIENT:g}.")
        if not np.any(x.values):
            raise InputError(f"{joint.label}: {what} is zero; it constrains nothing.")


def check_one_algebra(joint: Joint, objects: list[Multivector]) -> None:
    """Check that the objects of a joint are of one algebra."""
    names = {x.algebra.name for x in objects}
    if len(names) > 1:
        raise InputError(f"{joint.label}: its objects are of {' and '.join(sorted(names))}; one algebra is needed.")


def check_kind(joint: Joint, x: Multivector, kinds: tuple[str, ...], what: str) -> None:
    """Check the kind of an object, by its blades and not by its declared kind."""
    for kind in kinds:
        if kind in x.algebra.kinds:
            known = x.algebra.kind(kind)
            if set(x.kind.blades) <= set(known.blades):
                return
    raise InputError(f"{joint.label}: {what} is a {x.kind.name}; a {' or a '.join(kinds)} is needed.")


def direction_of(x: Multivector) -> Array | None:
    """Directions (..., 3) of axes or normals, of any length; None for objects without one."""
    for kind in ("line", "circle", "plane", "point_pair"):  # a line is a circle too
        if kind in x.algebra.kinds and set(x.kind.blades) <= set(x.algebra.kind(kind).blades):
            p = x.as_kind(kind, check=False).parameters()
            found = p.b - p.a if kind == "point_pair" else p.direction if kind == "line" else p.normal
            if np.isfinite(found).all():
                return np.asarray(found)
    if set(x.kind.blades) <= set(x.algebra.kind("twist").blades):  # a screw has an axis too
        return np.asarray(evaluate(x.algebra, "mechanics.screw_vectors", x).values[0].values)
    return None
