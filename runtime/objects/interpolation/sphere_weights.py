"""Weights with which normalised spheres blend by their centers (thesis 3.11): its formulas are for another scale."""

from __future__ import annotations

from typing import Any, Literal, overload

import numpy as np
from numpy.typing import NDArray

from ...codegen.errors import GradeError, ShapeError
from ...common.validation import as_axis, finite_array
from ...core.multivector import Multivector
from ...dispatch.formulas import evaluate
from ...dispatch.item_statuses import array_result
from ...dispatch.multivector_data import Statuses
from ...status import Status
from ..arguments import as_objects


@overload
def sphere_weights(
    spheres: Multivector, weights: Any = ..., axis: int = ..., *, status: Literal[False] = ..., strict: bool = ...
) -> NDArray[Any]: ...  # fmt: skip
@overload
def sphere_weights(
    spheres: Multivector, weights: Any = ..., axis: int = ..., *, status: Literal[True], strict: bool = ...
) -> tuple[NDArray[Any], Statuses]: ...  # fmt: skip
def sphere_weights(
    spheres: Multivector, weights: Any = None, axis: int = 0, *, status: bool = False, strict: bool = False
) -> NDArray[Any] | tuple[NDArray[Any], Statuses]:
    """Weights a for unit spheres X such that the sphere of sum a X has its center at the weighted mean of theirs.

    Parameters
    ----------
    spheres : Multivector, shape (...)
        Unit spheres, X^2 = -1, with a sum along ``axis``.
    weights : array, optional
        Weights w of the centers, broadcasting with the spheres; equal by default.
    axis : int
        Axis to sum over.
    status : bool
        Return (weights, status): `SINGULAR` where a sum is zero, `INVALID` where it holds a plane or a bad item.
    strict : bool
        Raise `SingularError` for the first of them.

    Returns
    -------
    array (...)
        a = w r/sum(w r), along ``axis``: `average(X, a)` and `interpolate` of unit spheres then follow thesis 3.11,
        whose spheres are weighted S* . n_inf = -1, and for which alone its radii hold:
        ``r^2 = sum w r_i^2 - sum_{i<j} w_i w_j |c_i - c_j|^2``. NaN for sums of zero, or with a plane or bad item.

    Notes
    -----
    The other way round, unit spheres blended with a have their center at weights (a_i/r_i)/sum(a_j/r_j). Planes need
    none of this: their normals and offsets blend linearly, and the offset is divided by the length of the normal.
    """
    known = as_objects(spheres, "the spheres", (4,))
    if known.kind.name != "sphere":
        raise GradeError(f"the spheres are a {known.kind.name}; planes blend with the weights themselves.")
    axis = as_axis(axis, known.shape, "the spheres have")
    outcome = evaluate(known.algebra, "conformal.sphere_parameters", known)
    radius, orientation = (outcome.values[i]._data[..., 0] for i in (1, 2))
    given = finite_array(1.0 if weights is None else weights, "the weights")
    try:
        scaled = np.broadcast_to(given, known.shape) * radius * orientation
    except ValueError:
        raise ShapeError(f"weights of shape {given.shape} do not fit spheres of shape {known.shape}.") from None
    with np.errstate(all="ignore"):
        total = scaled.sum(axis, keepdims=True)
        result = np.asarray(scaled / np.where(total == 0, np.nan, total), known.dtype)
    codes = np.where(total == 0, np.uint8(Status.SINGULAR), np.uint8(Status.OK))
    return array_result(result, codes, "sphere_weights", status, strict)


__all__ = ["sphere_weights"]
