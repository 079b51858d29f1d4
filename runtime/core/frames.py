"""Reciprocal frames: for vectors a_i the a^j in their span with a_i . a^j = 1 where i = j, and 0 elsewhere."""

from __future__ import annotations

import numpy as np

from ..codegen.errors import ShapeError
from ..common.validation import as_bool
from ..dispatch.coefficients import embed
from ..dispatch.item_statuses import raise_first
from ..dispatch.multivector_data import check_multivector
from ..status import Status
from .constructors import Constructors
from .kind_constraints import convert_to_kind
from .operators import P

#: Frames whose Gram matrix has a larger condition, to rounding, are dependent.
LEAST = 2.0**-50


def reciprocal_frame(algebra: Constructors[P], frame: P, strict: bool = False) -> P:
    """The reciprocal frames of frames (..., k) of vectors; SINGULAR: dependent vectors, or a null span."""
    check_multivector(frame, "the frame")
    vectors = convert_to_kind(frame, algebra.kind("vector").layout)
    if not frame.ndim or not 1 <= frame.shape[-1] <= algebra.dimension:
        raise ShapeError(f"the frame has the shape {frame.shape}; it ends in 1 to {algebra.dimension} vectors.")
    rows = embed(vectors, algebra.kind("vector")).astype(np.float64)
    sizes = np.abs(rows).max(-1, keepdims=True)
    with np.errstate(all="ignore"):
        unit = rows / np.where(sizes > 0, sizes, 1.0)
        metric = np.array(algebra.metric, float)
        gram = unit @ metric @ np.swapaxes(unit, -1, -2)
        finite = np.isfinite(gram).all((-2, -1))
        values = np.linalg.svd(np.where(finite[..., None, None], gram, 0.0), compute_uv=False)
        regular = finite & (values[..., -1] > LEAST * values[..., 0])
        safe = np.where(regular[..., None, None], gram, np.eye(gram.shape[-1]))
        found = np.linalg.solve(safe, unit)
        identity = np.eye(gram.shape[-1])
        for _ in range(2):  # the Gram matrix has the square of the frame's condition: Newton's steps on the vectors
            found += np.swapaxes(identity - unit @ metric @ np.swapaxes(found, -1, -2), -1, -2) @ found
        found = (found / np.where(sizes > 0, sizes, 1.0)).astype(frame.dtype)
    kept = regular & np.isfinite(found).all((-2, -1))  # lengths beyond the range of numbers are no answer
    found = np.where(kept[..., None, None], found, frame.dtype.type(np.nan))
    status = np.where(kept, Status.OK, np.where(finite & ~regular, Status.SINGULAR, Status.INVALID)).astype(np.uint8)
    result = algebra.wrap(algebra.kind("vector"), found, np.repeat(status[..., None], frame.shape[-1], -1))
    if as_bool(strict, "strict"):
        raise_first(result._status, "reciprocal_frame")
    return result
