"""Bezier curves of any degree, rational ones, and Hermite cubics through objects (thesis 4.8)."""

from __future__ import annotations

from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from ..codegen.errors import InputError
from ..common.deprecation import renamed_attribute
from ..common.validation import as_bool
from ..core.multivector import Multivector
from ..objects import arguments
from .base import Curve
from .bernstein import Array, Pieces, Quotient, bezier_pieces, hermite_pieces
from .control_objects import Controls, as_controls, concatenate, difference, rows_of, scalars

#: The least weight over the largest: the squares of weights, and what is divided by them, are numbers.
LIGHTEST = 1e-60


class Bezier(Curve):
    """Bezier curve sum_i b_i(t) X_i of degree n - 1 (thesis 4.8.1 to 4.8.4), from the first control to the last.

    Parameters
    ----------
    controls : Multivector (n,), or sequence of n >= 2
        Unit objects of one grade, rounds and flats mixed as they come; or circles as (center, normal, radius),
        mappings of these, or coefficients; point pairs as (a, b) or mappings.
    align : bool
        Turn each control over where it opposes the one before, in the sense of `objects.align`: between opposed
        objects sums may be imaginary. `flipped` says which were turned.
    raw : bool
        The controls are any multivectors of one grade, as those between the ends of a converted curve are.

    Raises
    ------
    InputError, GradeError, ShapeError
        For fewer than two controls, controls of several grades, or one that is no unit object: with its number.
    """

    def __init__(self, controls: Any, *, align: bool = False, raw: bool = False) -> None:
        if as_bool(align, "align") and as_bool(raw, "raw"):
            raise InputError("align turns unit objects over; raw controls are none.")
        super().__init__(as_controls(controls, align, raw))

    @classmethod
    def _of(cls, controls: Controls) -> Bezier:
        """On controls that are checked already."""
        new = cls.__new__(cls)
        Curve.__init__(new, controls)
        return new

    def _rows(self, rows: Array) -> Pieces:
        return bezier_pieces(rows)

    def to_hermite(self) -> Hermite:
        """Convert to ends and the derivatives there, for cubics whose ends are objects.

        Raises
        ------
        InputError
            If the degree is not 3.
        """
        if self.degree != 3:
            raise InputError(f"a Hermite curve is a cubic; this Bezier curve has degree {self.degree}.")
        c = self.controls
        kind = arguments.object_kind(c, "controls", c.grades)
        ends = [c[i].as_kind(kind) for i in (0, 3)]
        return Hermite(ends[0], 3 * (c[1] - c[0]), ends[1], 3 * (c[3] - c[2]))


class RationalBezier(Curve):
    """Rational Bezier curve sum_i w_i b_i(t) X_i / sum_i w_i b_i(t) (thesis 4.8.5); t runs over [0, 1].

    Parameters
    ----------
    controls : Multivector (n,), or sequence of n >= 2
        As for `Bezier`.
    weights : array (n,)
        Positive numbers; only their ratios count, and those end at 1e60.
    align : bool
        As for `Bezier`.

    Raises
    ------
    InputError, GradeError, ShapeError
        As for `Bezier`, and for weights that are not positive, or not as many as controls.
    """

    def __init__(self, controls: Any, weights: Any, *, align: bool = False) -> None:
        super().__init__(as_controls(controls, align))
        found = scalars(weights, len(self), "weights")
        if np.ndim(weights) == 0:
            raise InputError("weights is one number; give one for each control.")
        if (found <= 0).any():
            i = int(np.argmax(found <= 0))
            raise InputError(f"weights[{i}] is {found[i]:g}; weights are positive.")
        self._weights: Array = found / found.max()
        i = int(np.argmin(self._weights))
        if self._weights[i] < LIGHTEST:
            raise InputError(
                f"weights[{i}] is {found[i]:g}, less than {LIGHTEST:g} of the largest.",
                remedy="Leave such a control out",
            )

    @property
    def weights(self) -> Array:
        """Weights over the largest of them."""
        return self._weights.copy()

    def _rows(self, rows: Array) -> Quotient:
        return Quotient(rows, self._weights)

    def to_bezier(self) -> Bezier:
        """The Bezier curve of the weighted controls: its sums are larger, its projected values are the same."""
        c = self._controls
        scaled: Multivector = c.objects * self._weights
        return Bezier._of(Controls(scaled, scaled, c.flipped, c.frame, c.rows * self._weights[:, None]))


class Hermite(Curve):
    """Hermite cubic from c0 to c1 with derivatives v0 and v1 there (thesis 4.8.6); t runs over [0, 1].

    Parameters
    ----------
    c0, c1 : Multivector, shape ()
        Unit objects of one grade, or circles and point pairs by parameters, as for `Bezier`.
    v0, v1 : Multivector, shape (), or mapping
        Derivatives of the sum by t: any multivectors of that grade; ``{"from": X, "to": Y, "scale": s}`` is s (Y - X).
    align : bool
        Turn c1, and v1 with it, over where c1 opposes c0; see `Bezier`.

    Raises
    ------
    InputError, GradeError
        For objects that are no unit objects, and tangents that are not finite or of another grade.
    """

    def __init__(self, c0: Any, v0: Any, c1: Any, v1: Any, *, align: bool = False) -> None:
        tangents = concatenate([difference(v, f"v{i}") for i, v in enumerate((v0, v1))], "tangents")
        super().__init__(as_controls([c0, c1], align, tangents=[tangents]))
        if len(self) != 2 or len(tangents) != 2:
            raise InputError("a Hermite curve has one object and one tangent at each end; these are batches.")
        signs = np.where(self._controls.flipped, -1.0, 1.0)
        self._tangents: Multivector = tangents.astype(float) * signs
        self._original_tangents = v0, v1

    @property
    def original_tangents(self) -> tuple[Any, Any]:
        """Tangents v0 and v1 as they were handed over, before ``align`` turned v1."""
        return self._original_tangents

    given_tangents = renamed_attribute("original_tangents")

    @property
    def tangents(self) -> Multivector:
        """Derivatives v0 and v1, shape (2,); v1 reversed with c1."""
        return self._tangents.astype(self.controls.dtype)

    def blending(self) -> tuple[NDArray[np.intp], Array]:
        rows = np.eye(4)
        return np.arange(4)[None], _cubic(rows[:2], rows[2:]).ordinates

    def with_flipped_controls(self, which: Any) -> Self:
        new = super().with_flipped_controls(which)
        new._tangents = self._tangents * np.where(which, -1.0, 1.0)
        return new

    def _rows(self, rows: Array) -> Pieces:
        """Tangents are moved to the frame that the rows are in."""
        frame = self._controls.frame if rows is self._controls.rows else None
        moved: Multivector = self._tangents if frame is None else ~frame.translator >> self._tangents
        return _cubic(rows, rows_of(moved, self.kind))

    def to_bezier(self) -> Bezier:
        """Convert to a Bezier cubic, whose two inner controls are not objects."""
        return as_beziers(self)[0]

    def to_beziers(self) -> list[Bezier]:
        """`to_bezier`, in a list as for splines."""
        return as_beziers(self)


def _cubic(ends: Array, tangents: Array) -> Pieces:
    return hermite_pieces(np.array([0.0, 1.0]), ends[:1], tangents[:1], ends[1:], tangents[1:])


def as_beziers(curve: Curve) -> list[Bezier]:
    """Each polynomial piece of a curve as a Bezier curve over [0, 1]: the same sums, exact but for rounding."""
    local, world = curve._local, curve._world
    if not (isinstance(local, Pieces) and isinstance(world, Pieces)):
        raise TypeError(f"{type(curve).__name__} has no polynomial pieces.")
    controls = curve._controls
    pieces = []
    for inner, outer in zip(local.ordinates, world.ordinates, strict=True):
        sums = curve._multivector(outer).astype(curve.controls.dtype)
        pieces.append(Bezier._of(Controls(sums, sums, np.zeros(len(sums), bool), controls.frame, inner)))
    return pieces
