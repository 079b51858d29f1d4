"""Base class of curves: checks of parameters, sums of rows, and one projection to the blade manifold for a batch."""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from functools import cached_property
from typing import Any, Protocol, Self

import numpy as np
from numpy.typing import NDArray

from ..codegen.algebra.algebra import Kind
from ..codegen.errors import InputError
from ..common.deprecation import renamed_attribute
from ..common.dtypes import F64
from ..common.rich_display import Displayed
from ..common.validation import as_bool, check_shape, real_array
from ..core.multivector import Multivector
from ..dispatch.formulas import ArrayOperand, FormulaResult, evaluate
from ..dispatch.item_statuses import invalidate_nonfinite, merge_statuses, raise_first
from .bernstein import Array
from .control_objects import Controls, rows_of

#: A parameter outside the curve by less than this many rounding units of the domain is its end: i * (1/n) may be.
ROUNDING = 4


class Rows(Protocol):
    """Rows of numbers as functions of a parameter."""

    @property
    def degree(self) -> int:
        """Degree of the polynomials."""

    @property
    def ordinates(self) -> Array:
        """Coefficients of the sums."""

    @property
    def rates(self) -> Array:
        """Coefficients of their derivatives."""

    def at(self, t: Array) -> tuple[Array, Array]:
        """Rows, and sums of the absolute values of their terms, both (..., k)."""

    def rate_at(self, t: Array) -> Array:
        """Derivatives (..., k)."""


class Curve(Displayed):
    """A curve of objects: sums of its controls, projected to blades (thesis 4.8).

    Call it, or its methods, with parameters of any shape. Values are objects of the kind of the controls; items that
    stand for no object are NaN with a status: `IMAGINARY` where the sum has no real projection, `SINGULAR` where
    nothing is left of it. Derivatives are by the parameter t; at a joint they are those of the piece that starts.
    Parameters outside the domain, and NaN, raise `InputError`; four rounding units count as inside.
    """

    def __init__(self, controls: Controls) -> None:
        self._controls = controls

    def _rows(self, rows: Array) -> Rows:
        """The curve through rows of coefficients of the controls; linear in them."""
        raise NotImplementedError

    @cached_property
    def _local(self) -> Rows:
        """In the frame of the controls."""
        return self._finite_rows(self._controls.rows)

    @cached_property
    def _world(self) -> Rows:
        """In the world."""
        if self._controls.frame is None:
            return self._local
        return self._finite_rows(rows_of(self._controls.objects, self.kind))

    def _finite_rows(self, rows: Array) -> Rows:
        """The curve through rows.

        Raises
        ------
        InputError
            If its sums are larger than numbers can be.
        """
        with np.errstate(all="ignore"):
            found = self._rows(rows)
            finite = bool(np.isfinite(found.ordinates).all() and np.isfinite(found.rates).all())
        if not finite:
            raise InputError(
                f"the sums of this {type(self).__name__} overflow.",
                remedy="Use smaller tangents, parameters of splines, or raw controls",
            )
        return found

    # -- what it is ----------------------------------------------------------------------------------------

    @property
    def controls(self) -> Multivector:
        """Control objects (n,), of reversed orientation where `flipped` says so."""
        return self._controls.objects

    @property
    def original_controls(self) -> Multivector | Sequence[Any]:
        """The controls as they were handed over, before ``align`` turned any."""
        return self._controls.original

    @property
    def flipped(self) -> NDArray[np.bool_]:
        """Mask (n,) of the controls whose orientation ``align`` changed."""
        return self._controls.flipped.copy()

    @property
    def kind(self) -> Kind:
        """Kind of the controls and of the values."""
        return self._controls.kind

    @property
    def segments(self) -> int:
        """Number of polynomial pieces."""
        return 1

    @property
    def domain(self) -> tuple[float, float]:
        """First and last parameter."""
        return 0.0, float(self.segments)

    @property
    def breaks(self) -> Array:
        """Parameters where pieces join, and the ends, (segments + 1,)."""
        return np.linspace(*self.domain, self.segments + 1)

    @property
    def degree(self) -> int:
        """Degree of the polynomials."""
        return self._local.degree

    def blending(self) -> tuple[NDArray[np.intp], Array]:
        """Weights of the controls in the Bernstein coefficients of each piece: curves are linear in them.

        Returns
        -------
        members : array (segments, m)
            Numbers of the controls that a piece takes from, the same count for all pieces.
        shares : array (segments, degree + 1, m)
            Coefficient k of piece i is ``sum_j shares[i, k, j] * controls[members[i, j]]``. Of a rational curve it
            holds the weight as well. A Hermite curve has its tangents as further controls, 2 and 3.
        """
        found = self._rows(np.eye(len(self))).ordinates
        shares = found.reshape(self.segments, -1, len(self))
        return np.broadcast_to(np.arange(len(self)), (self.segments, len(self))), shares

    def with_flipped_controls(self, which: Any) -> Self:
        """The curve through these controls with the orientation of some reversed.

        Parameters
        ----------
        which : array (n,) of bool
        """
        signs = np.where(np.asarray(which, bool), -1.0, 1.0)
        check_shape(signs, "which", (len(self),))
        new = copy(self)
        for name in ("_local", "_world"):
            new.__dict__.pop(name, None)
        new._controls = self._controls.with_signs(signs)
        return new

    turned = renamed_attribute("with_flipped_controls")
    given = renamed_attribute("original_controls")

    def __len__(self) -> int:
        """Number of controls."""
        return len(self._controls)

    def __repr__(self) -> str:
        start, end = self.domain
        return (
            f"<{type(self).__name__} of {len(self)} {self.kind.name}s, degree {self.degree}, on [{start:g}, {end:g}]>"
        )

    # -- values --------------------------------------------------------------------------------------------

    def __call__(self, t: Any, strict: bool = False) -> Multivector:
        """Objects at parameters t (...).

        Raises
        ------
        InputError
            If a parameter is outside the domain, or NaN.
        SingularError
            With ``strict``, for the first item without an object.
        """
        found = self._project(*map(self._multivector, self._local.at(self._inside(t))))
        x = self._to_world(found.value, found.status)
        if as_bool(strict, "strict"):
            raise_first(x._status, "a value of the curve")
        return x

    def derivative(self, t: Any, strict: bool = False) -> Multivector:
        """Derivatives of the objects by t, (...); same errors and statuses as the values."""
        inside = self._inside(t)
        raw, size, rate = map(self._multivector, (*self._local.at(inside), self._local.rate_at(inside)))
        found = evaluate(self.controls.algebra, "blades.project_rate", raw, rate)
        of_value = self._project(raw, size).status
        x = self._to_world(found.value, merge_statuses(of_value, found.status))
        if as_bool(strict, "strict"):
            raise_first(x._status, "a derivative of the curve")
        return x

    def _project(self, raw: Multivector, size: Multivector) -> FormulaResult:
        """Sums projected; far from the world's origin the controls are known to its rounding only."""
        frame, algebra = self._controls.frame, self.controls.algebra
        if frame is None or raw.grades == (1,):
            return evaluate(algebra, "blades.project_sum", raw, size)
        distance = ArrayOperand(float(np.linalg.norm(frame.origin)), 0, "distance")
        return evaluate(algebra, "blades.project_far_sum", raw, size, distance)

    def raw(self, t: Any) -> Multivector:
        """Sums of the controls at parameters t, not projected."""
        return self._multivector(self._world.at(self._inside(t))[0]).astype(self.controls.dtype)

    def raw_derivative(self, t: Any) -> Multivector:
        """Derivatives of the sums by t."""
        return self._multivector(self._world.rate_at(self._inside(t))).astype(self.controls.dtype)

    def _inside(self, t: Any) -> Array:
        """Checked parameters, with what is outside by rounding moved to the ends."""
        array: Array = np.asarray(real_array(t, "t"), np.float64)
        start, end = self.domain
        room = ROUNDING * float(np.finfo(F64).eps) * max(abs(start), abs(end))
        good = (array >= start - room) & (array <= end + room)
        if not good.all():
            place = tuple(int(i) for i in np.argwhere(~good)[0])
            name = f"t[{', '.join(map(str, place))}]" if place else "t"
            raise InputError(f"{name} is {float(array[place])!r}; the curve runs over [{start:g}, {end:g}].")
        return np.clip(array, start, end)

    def _multivector(self, rows: Array) -> Multivector:
        layout = self.controls.algebra.type_of(self.kind.layout, F64)
        return Multivector._make(layout, np.ascontiguousarray(rows), rows.shape[:-1])

    def _to_world(self, x: Multivector, status: NDArray[np.uint8] | None) -> Multivector:
        """Objects of the controls' frame in the world, in their precision; NaN without an answer."""
        frame = self._controls.frame
        moved = x if frame is None else frame.to_world(x)
        checked = Multivector._make(moved._type, moved._data, moved.shape, status)
        return invalidate_nonfinite(checked).astype(self.controls.dtype)
