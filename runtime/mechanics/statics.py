"""Statics: resultants and equilibrium of wrenches, and forces as others write them (thesis 6.2.1 and 6.2.5)."""

from __future__ import annotations

from typing import Any

import numpy as np

from .. import arrays
from ..arrays import truth
from ..calls import Numbers, call, finite, raise_first
from ..checks import converted
from ..codegen.errors import GradeError, InputError, ShapeError
from ..euclidean import is_origin, parameters_class
from ..loading import stock_algebra
from ..multivector import Multivector
from ..objects.closest import as_lines
from ..text import statuses
from .screws import Array, as_screw, geometry, moment_about, same_algebra, wrench_parts

Equilibrium = parameters_class("Equilibrium", "balanced", "residual", "force", "moment")
VectorForce = parameters_class("VectorForce", "force", "point", "couple")
#: How far forces in balance may be from zero, relative to the sum of their sizes: by precision, as `isclose` has it.
BALANCE = {np.dtype(np.float64): 1e-9, np.dtype(np.float32): 1e-4}
#: Rounding units of the moments about the origin that a moment about another point may be off by.
NOISE = 64


def resultant(wrenches: Any, axis: int = 0) -> Multivector:
    """The sum of wrenches: of a list, whose shapes broadcast, or along an axis of one batch.

    An item that is not finite makes its sum NaN, with status `INVALID`.
    """
    return finite(_stacked(wrenches, axis)[1])


def equilibrium(wrenches: Any, axis: int = 0, about: Any = 0, rtol: float | None = None) -> Any:
    """Whether wrenches on a body balance, and what they leave over.

    Parameters
    ----------
    wrenches : Multivector, or list of Multivector
        A batch, summed along ``axis``, or a list whose shapes broadcast.
    about : array (..., 3), or 0
        The point that moments are taken about. For a body far from the origin take one near it.
    rtol : float, optional
        Share of the sum of all forces, and of all moments, that may be left over; 1e-9 (float32: 1e-4).

    Returns
    -------
    Equilibrium
        Named tuple (balanced, residual, force, moment): truth values, the resultant wrench, the lengths of its force
        and of its moment about the point; ``.status`` is `INVALID` where a wrench is not finite.
    """
    terms, residual = _stacked(wrenches, axis)
    share = BALANCE[residual.dtype] if rtol is None else float(arrays.real(rtol, "rtol"))
    with np.errstate(all="ignore"):
        force = np.linalg.norm(wrench_parts(residual).force, axis=-1)
        moment = np.linalg.norm(moment_about(residual, about), axis=-1)
        forces = _size(wrench_parts(terms).force)
        moments, rounding = _size(moment_about(terms, about)), _size(wrench_parts(terms).moment)
        if not is_origin(about):
            reach = np.linalg.norm(arrays.rows(about, 3, "about"), axis=-1)
            rounding = rounding + reach * forces
        noise = NOISE * float(np.finfo(residual.dtype).eps)
        balanced = (force <= share * forces) & (moment <= share * moments + noise * rounding)
    result = Equilibrium(balanced[()], residual, force[()], moment[()])
    result.status = statuses(residual._status, residual.shape)
    return result


def _size(vectors: Array) -> Array:
    """Sum of lengths along the first axis."""
    lengths: Array = np.linalg.norm(vectors, axis=-1).sum(0)
    return lengths


def _stacked(wrenches: Any, axis: int) -> tuple[Multivector, Multivector]:
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
        if not first.ndim or not -first.ndim <= axis < first.ndim:
            raise ShapeError(f"the wrenches have shape {first.shape}, without an axis {axis} to sum along.")
        rows = np.moveaxis(first._data, axis if axis >= 0 else axis - 1, 0)
    algebra = first.algebra
    kind = algebra.layout("twist")
    return finite(algebra.wrap(kind, rows.copy())), finite(algebra.wrap(kind, np.ascontiguousarray(rows.sum(0))))


# -- forces in other hands ---------------------------------------------------------------------------------


def force_along(line: Multivector, intensity: Any = 1.0) -> Multivector:
    """The wrench of a force along unit lines of CGA (6.1, 6.2) or PGA, of a given intensity (...)."""
    if isinstance(line, Multivector) and line.algebra.is_degenerate:
        geometry(line.algebra)
        unit = line.as_kind("line")
    else:
        unit = as_lines(line, "the lines")
    return finite(call(unit.algebra, "twists.force_along", unit, Numbers(intensity, 0, "the intensity")).value)


def line_of_wrench(w: Multivector) -> Multivector:
    """The lines that a wrench is a sum of: its undual in CGA, itself in PGA."""
    x = as_screw(w, "the wrench")
    return finite(call(x.algebra, "twists.line_of_wrench", x).value)


def wrench_of_vector(force: Any, point: Any) -> Multivector:
    """The wrench of a force as Lasenby, Lasenby and Doran have it: a vector F = f + alpha n_inf at a point X (6.2.5).

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
    vector = converted(force, cga.layout_of(b for b in cga.kind("point").blades if b != cga.no.blades[0]))
    return finite(call(cga, "twists.wrench_of_vector", vector, point.as_kind("point")).value)


def vector_of_wrench(w: Multivector, strict: bool = False) -> Any:
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
    outcome = call(x.algebra, "twists.vector_of_wrench", x)
    status = outcome.status
    if truth(strict, "strict"):
        raise_first(status, "vector_of_wrench")
    result = VectorForce(*(finite(v) for v in outcome.values))
    result.status = statuses(status, x.shape)
    return result


def ideal_line(a: Any) -> Multivector:
    """Gunn's line at infinity e0 a of PGA, for vectors a (..., 3). It is a wrench: the couple of the moment -a."""
    pga = stock_algebra("pga3d")
    found = finite(call(pga, "twists.ideal_line", Numbers(a, pga.kind("euclidean"), "a")).value)
    return found.as_kind(pga.layout("twist"))


__all__ = [
    "Equilibrium", "VectorForce", "equilibrium", "force_along", "ideal_line", "line_of_wrench", "resultant",
    "vector_of_wrench", "wrench_of_vector",
]  # fmt: skip
