"""Statics: resultants and equilibrium of wrenches, and forces as lines and vectors (thesis 6.2.1 and 6.2.5)."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..codegen.errors import GradeError, InputError, ShapeError
from ..common.validation import as_axis, as_bool, as_float, real_array
from ..core.geometry.euclidean import is_origin
from ..core.geometry.parameters import Parameters
from ..core.kind_constraints import convert_to_kind
from ..core.multivector import Multivector
from ..core.registry import stock_algebra
from ..dispatch.formulas import ArrayOperand, evaluate
from ..dispatch.item_statuses import invalidate_nonfinite, raise_first
from ..dispatch.multivector_data import statuses
from ..objects.closest_points import as_lines
from .screws import Array, as_screw, finite_screw, geometry, moment_about, same_algebra, wrench_parts

#: Relative tolerance of balanced forces, of the sum of their sizes, by precision: that of `isclose`.
BALANCE_RTOL = {np.dtype(np.float64): 1e-9, np.dtype(np.float32): 1e-4}
#: Error of a moment about another point, in rounding units of the moments about the origin.
MOMENT_ROUNDING = 64


class Equilibrium(
    NamedTuple(
        "Equilibrium", [("balanced", NDArray[np.bool_]), ("residual", Multivector), ("force", Array), ("moment", Array)]
    ),
    Parameters,
):
    """Truth values, the resultant wrench, lengths of its force and of its moment, with ``.status``."""


class VectorForce(
    NamedTuple("VectorForce", [("force", Multivector), ("point", Multivector), ("couple", Multivector)]), Parameters
):
    """Force at a point, and a couple, with ``.status``."""


def resultant(wrenches: Any, axis: int = 0, strict: bool = False) -> Multivector:
    """Sum of wrenches: of a list, whose shapes broadcast, or along an axis of one batch.

    An item that is not finite makes its sum NaN, with status `INVALID`.
    """
    return finite_screw(_stack(wrenches, axis)[1], "resultant", strict)


def equilibrium(
    wrenches: Any, axis: int = 0, about: Any = 0, rtol: float | None = None, strict: bool = False
) -> Equilibrium:
    """Balance of the wrenches on a body, and their resultant.

    Parameters
    ----------
    wrenches : Multivector, or list of Multivector
        A batch, summed along ``axis``, or a list whose shapes broadcast.
    about : array (..., 3), or 0
        Point that moments are taken about. For a body far from the origin take one near it.
    rtol : float, optional
        Tolerance of the resultant force and moment, relative to the sums of the sizes; 1e-9 (float32: 1e-4).
    strict : bool
        Raise `SingularError` where a wrench is not finite.

    Returns
    -------
    Equilibrium
        Named tuple (balanced, residual, force, moment): truth values, the resultant wrench, the lengths of its force
        and of its moment about the point; ``.status`` is `INVALID` where a wrench is not finite.
    """
    terms, residual = _stack(wrenches, axis)
    if as_bool(strict, "strict"):
        raise_first(residual._status, "equilibrium")
    rtol = BALANCE_RTOL[residual.dtype] if rtol is None else as_float(rtol, "rtol", 0.0)
    with np.errstate(all="ignore"):
        force = np.linalg.norm(wrench_parts(residual).force, axis=-1)
        moment = np.linalg.norm(moment_about(residual, about), axis=-1)
        forces = _sum_of_lengths(wrench_parts(terms).force)
        moments, rounding = _sum_of_lengths(moment_about(terms, about)), _sum_of_lengths(wrench_parts(terms).moment)
        if not is_origin(about):
            distance = np.linalg.norm(real_array(about, "about", (..., 3)), axis=-1)
            rounding = rounding + distance * forces
        noise = MOMENT_ROUNDING * float(np.finfo(residual.dtype).eps)
        balanced = (force <= rtol * forces) & (moment <= rtol * moments + noise * rounding)
    result = Equilibrium(balanced[()], residual, force[()], moment[()])
    result.status = statuses(residual._status, residual.shape)
    return result


def _sum_of_lengths(vectors: Array) -> Array:
    """Sum of lengths along the first axis."""
    lengths: Array = np.linalg.norm(vectors, axis=-1).sum(0)
    return lengths


def _stack(wrenches: Any, axis: int) -> tuple[Multivector, Multivector]:
    """All wrenches along a first axis, and their sum."""
    if isinstance(wrenches, (list, tuple)):
        if not wrenches:
            raise InputError("there are no wrenches: the list is empty.")
        parts = [as_screw(x, f"wrench {i}") for i, x in enumerate(wrenches)]
        for x in parts[1:]:
            same_algebra(parts[0], x)
        try:
            rows = np.stack(np.broadcast_arrays(*(x._data for x in parts)))
        except ValueError:
            shapes = ", ".join(str(x.shape) for x in parts)
            raise ShapeError(f"wrenches of shapes {shapes} do not broadcast.") from None
        first = parts[0]
    else:
        first = as_screw(wrenches, "the wrenches")
        rows = np.moveaxis(first._data, as_axis(axis, first.shape, "the wrenches have"), 0)
    algebra = first.algebra
    kind = algebra.layout("twist")
    return invalidate_nonfinite(algebra.wrap(kind, rows.copy())), invalidate_nonfinite(
        algebra.wrap(kind, np.ascontiguousarray(rows.sum(0)))
    )


# -- other representations of forces ---------------------------------------------------------------------------------


def force_along(line: Multivector, intensity: Any = 1.0, strict: bool = False) -> Multivector:
    """Wrench of a force along unit lines of CGA (6.1, 6.2) or PGA, of a given intensity (...)."""
    if isinstance(line, Multivector) and line.algebra.is_degenerate:
        geometry(line.algebra)
        unit = line.as_kind("line")
    else:
        unit = as_lines(line, "the lines")
    wrench: Multivector = evaluate(
        unit.algebra, "twists.force_along", unit, ArrayOperand(intensity, 0, "the intensity")
    ).value
    return finite_screw(wrench, "force_along", strict)


def line_of_wrench(w: Multivector, strict: bool = False) -> Multivector:
    """Sum of lines that is a wrench: its undual in CGA, itself in PGA."""
    x = as_screw(w, "the wrench")
    return finite_screw(evaluate(x.algebra, "twists.line_of_wrench", x).value, "line_of_wrench", strict)


def wrench_of_vector(force: Any, point: Any, strict: bool = False) -> Multivector:
    """Wrench of a force as Lasenby, Lasenby and Doran write it: a vector F = f + alpha n_inf at a point X (6.2.5).

    Parameters
    ----------
    force : Multivector
        Vectors of `cga3d` on e1, e2, e3 and n_inf. alpha drops out.
    point : Multivector
        Points of `cga3d`.

    Returns
    -------
    Multivector
        (X ^ F ^ n_inf) I5.
    """
    cga = stock_algebra("cga3d")
    for x, what in ((force, "the force"), (point, "the point")):
        if not isinstance(x, Multivector) or x.algebra is not cga or x.grades != (1,):
            raise GradeError(f"{what}: a vector of cga3d is needed.")
    vector = convert_to_kind(force, cga.layout_of(b for b in cga.kind("point").blades if b != cga.no.blades[0]))
    wrench: Multivector = evaluate(cga, "twists.wrench_of_vector", vector, point.as_kind("point")).value
    return finite_screw(wrench, "wrench_of_vector", strict)


def vector_of_wrench(w: Multivector, strict: bool = False) -> VectorForce:
    """A wrench of CGA as force F = f at the point X of its axis nearest the origin, and a couple along the axis.

    Returns
    -------
    VectorForce
        Named tuple (force, point, couple) of multivectors, with ``.status``: w is the wrench of F at X plus the couple.
        `SINGULAR` and NaN: a couple alone has no axis.
    """
    x = as_screw(w, "the wrench")
    if x.algebra.is_degenerate:
        raise GradeError(f"forces as vectors are those of cga3d; this wrench belongs to {x.algebra.name}.")
    outcome = evaluate(x.algebra, "twists.vector_of_wrench", x)
    status = outcome.status
    if as_bool(strict, "strict"):
        raise_first(status, "vector_of_wrench")
    result = VectorForce(*(invalidate_nonfinite(v) for v in outcome.values))
    result.status = statuses(status, x.shape)
    return result


def ideal_line(a: Any, strict: bool = False) -> Multivector:
    """Gunn's line at infinity e0 a of PGA, for vectors a (..., 3). It is a wrench: the couple of the moment -a."""
    pga = stock_algebra("pga3d")
    line = evaluate(pga, "twists.ideal_line", ArrayOperand(a, pga.kind("euclidean"), "a")).value
    return finite_screw(invalidate_nonfinite(line).as_kind(pga.layout("twist")), "ideal_line", strict)


__all__ = [
    "Equilibrium", "VectorForce", "equilibrium", "force_along", "ideal_line", "line_of_wrench", "resultant",
    "vector_of_wrench", "wrench_of_vector",
]  # fmt: skip
