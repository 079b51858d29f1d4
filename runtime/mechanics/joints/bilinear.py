"""Joints as bilinear conditions on an object of each body: the universal joint, and any other (thesis 7.4, 7.5.6)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import InitVar, dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...codegen.errors import BladesmithError, InputError, ShapeError, suggest
from ...common.validation import finite_array
from ...core.multivector import Algebra, Multivector
from ..arguments import multivector_of
from . import placement
from .base import Condition, Joint, check_kind, check_named, check_one_algebra
from .local_relations import relations

Array = NDArray[Any]
#: Products of `Bilinear` by name.
PRODUCTS: dict[str, Callable[[Multivector, Multivector], Multivector]] = {
    "outer": lambda x, y: x ^ y,
    "inner": lambda x, y: x | y,
    "meet": lambda x, y: x.meet(y),
    "anticommutator": lambda x, y: x.anticommutator(y),
}


@dataclass(frozen=True, eq=False)
class Universal(Joint):
    """Two circles about one center, one in each body, whose planes stay at right angles (7.5.6). Mobility 2.

    The printed condition, that <X Y>_4 = 0, only keeps them on one sphere: here the center is shared, and
    (X ^ n_inf) . (Y ^ n_inf) = 0.

    In place of the circles ``point=`` and ``axis_a=``, ``axis_b=``, their axes.
    """

    a: str
    b: str
    circle_a: Multivector = None  # type: ignore[assignment]  # then they are made from a point and axes
    circle_b: Multivector = None  # type: ignore[assignment]
    point: InitVar[ArrayLike | None] = field(default=None, kw_only=True)
    axis_a: InitVar[ArrayLike | None] = field(default=None, kw_only=True)
    axis_b: InitVar[ArrayLike | None] = field(default=None, kw_only=True)
    algebra: InitVar[Algebra | None] = field(default=None, kw_only=True)
    mobility = 2
    is_sequence = True

    def __post_init__(
        self, point: ArrayLike | None, axis_a: ArrayLike | None, axis_b: ArrayLike | None, algebra: Algebra | None
    ) -> None:
        circles = ("circle_a", "circle_b")
        placement.place(self, circles, placement.cross, algebra, point=point, axis_a=axis_a, axis_b=axis_b)
        given = {"the first circle": self.circle_a, "the second circle": self.circle_b}
        check_named(self, given.items())
        check_one_algebra(self, list(given.values()))
        found = []
        for what, x in given.items():
            check_kind(self, x, ("circle",), what)
            circle = x.parameters()
            if not hasattr(circle, "radius"):
                raise InputError(f"{self.label}: {what} is a {type(circle).__name__.lower()}, and has no center.")
            found.append(circle)
        gap = float(np.linalg.norm(found[0].center - found[1].center))
        if gap > 1e-9 * (float(np.abs(found[0].center).max()) + float(found[0].radius)):
            raise InputError(f"{self.label}: the centers of the circles are {gap:.3g} apart; they must coincide.")
        cosine = float(found[0].normal @ found[1].normal)
        if abs(cosine) > 1e-9:
            raise InputError(f"{self.label}: the circles' planes are not at right angles; the cosine is {cosine:.3g}.")

    def rotations(self) -> tuple[Array, Array] | None:
        circles = [x.parameters() for x in (self.circle_a, self.circle_b)]
        return circles[0].center, np.stack([circle.normal for circle in circles])

    def conditions(self) -> list[Condition]:
        algebra = self.circle_a.algebra
        center = algebra.point(self.circle_a.parameters().center)
        infinity = algebra.multivector({"ni": 1.0})

        def cosine(x: Multivector, y: Multivector) -> Multivector:
            return (x ^ infinity) | (y ^ infinity)

        return [Condition(center, center), Condition(self.circle_a, self.circle_b, cosine, 0.0)]


@dataclass(frozen=True, eq=False)
class Bilinear(Joint):
    """Any bilinear condition B(X, Y) = H of an object of each body (7.5).

    Parameters
    ----------
    a, b : str
    x, y : Multivector
        In the world at the start; x belongs to a, y to b.
    product : {"outer", "inner", "meet", "anticommutator"} or callable
        A function of two multivectors, linear in each. It is taken in the frame of the first body.
    H : Multivector or float, optional
        Zero; None is what B is at the start.
    """

    a: str
    b: str
    x: Multivector
    y: Multivector
    product: str | Callable[[Multivector, Multivector], Any] = "outer"
    H: Multivector | float | None = 0
    mobility = -1

    def __post_init__(self) -> None:
        check_named(self, [("x", self.x), ("y", self.y)])
        check_one_algebra(self, [self.x, self.y])
        if not callable(self.product) and self.product not in PRODUCTS:
            raise InputError(
                f"{self.label}: {self.product!r} is not a product; there are: {', '.join(PRODUCTS)}, and functions of "
                f"two objects.{suggest(str(self.product), PRODUCTS)}"
            )
        if self.H is None:
            object.__setattr__(self, "H", self._apply(self.x, self.y))
        elif isinstance(self.H, Multivector):
            multivector_of(self.H, self.x.algebra, f"{self.label}: H")
        elif finite_array(self.H, f"{self.label}: H").shape:
            raise ShapeError(f"{self.label}: H has shape {np.shape(self.H)}; one multivector or number is needed.")
        relations(self.x.algebra, [self])

    def _apply(self, x: Multivector, y: Multivector) -> Multivector:
        """B(x, y), with errors of a user's function as InputError."""
        function = self.product if callable(self.product) else PRODUCTS[self.product]
        try:
            value = function(x, y)
        except BladesmithError:
            raise
        except Exception as error:
            raise InputError(f"{self.label}: its product raises {type(error).__name__}: {error}.") from error
        return multivector_of(value, x.algebra, f"{self.label}: its product")

    def conditions(self) -> list[Condition]:
        return [Condition(self.x, self.y, self._apply, self.H, equivariant=not callable(self.product))]
