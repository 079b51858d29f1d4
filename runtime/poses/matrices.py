"""Poses from and to homogeneous matrices."""

from __future__ import annotations

from typing import Any, Literal, overload

import numpy as np

from ..codegen.errors import InputError, ShapeError
from ..common.validation import as_float, real_array
from ..core.geometry.euclidean import plain
from ..core.multivector import Multivector
from ..dispatch.formulas import ArrayOperand
from ..dispatch.item_statuses import array_result, invalidate, unsigned_zeros
from ..dispatch.multivector_data import Statuses
from .arguments import Array, as_pose, as_poses, call, checked_items, item, row_of

#: Shapes of matrices of poses.
SHAPES = ((3, 3), (3, 4), (4, 4))
#: Columns that are further from orthonormal than this are no rounding of single precision, or of text.
SHEARED = 1e-3


def from_matrix(matrix: Any, tolerance: float | None = None, *, strict: bool = True) -> Multivector:
    """Poses from homogeneous matrices (..., 4, 4), their first three rows (..., 3, 4), or rotations (..., 3, 3).

    Parameters
    ----------
    matrix : array
        Matrices that act on columns, from the left.
    tolerance : float, optional
        Take the nearest rotation, the orthogonal factor of the polar decomposition: up to this change of an entry.
        ``.deviation`` of the result says how large it was. By default a rotation is orthonormal to rounding.
    strict : bool
        True: raise `InputError` for the first matrix of no pose. False: it is NaN, with status `INVALID`.

    Returns
    -------
    Multivector, shape (...)
        Motors with non-negative real part.
    """
    m = real_array(matrix, "matrix")
    if m.shape[-2:] not in SHAPES:
        raise ShapeError(f"matrix has shape {m.shape}; it ends in (4, 4), (3, 4) or (3, 3).")
    full = np.zeros((*m.shape[:-2], 3, 4), m.dtype)
    full[..., : m.shape[-1]] = m[..., :3, :]
    operand = ArrayOperand(full.reshape(*m.shape[:-2], 12), 12, "matrix")
    last = np.abs(m[..., 3, :] - (0, 0, 0, 1)).max(-1) if m.shape[-2] == 4 else None
    if tolerance is None:
        x = as_poses(call("poses.pose_of_matrix", operand))
        if last is not None and last.any():
            x = invalidate(x, last != 0)
    else:
        limit = as_float(tolerance, "the tolerance, of entries of the rotation,", 0, below=1)
        result = call("poses.nearest_pose_of_matrix", operand)
        x, deviation = as_poses(result), plain(result.values[1])[..., 0]
        deviation = deviation if last is None else np.fmax(deviation, last)
        with np.errstate(invalid="ignore"):
            x = invalidate(x, ~(deviation <= limit))
        x._deviation = deviation

    def explain(index: tuple[int, ...]) -> InputError:
        return _no_pose(item("matrix", index), row_of(m, index, 2, x.shape), tolerance)

    return checked_items(x, strict, {"matrix": m}, explain)


def _no_pose(name: str, m: Array, tolerance: float | None) -> InputError:
    if m.shape == (4, 4) and np.abs(m[3] - (0, 0, 0, 1)).max() > (tolerance or 0):
        is_transposed = np.abs(m[:, 3] - (0, 0, 0, 1)).max() == 0
        remedy = "It looks transposed: pass np.swapaxes(matrix, -1, -2)" if is_transposed else None
        return InputError(f"the last row of {name} is {m[3].tolist()}; that of a pose is 0, 0, 0, 1.", remedy=remedy)
    r = m[:3, :3].astype(float)
    determinant = float(np.linalg.det(r))
    if determinant <= 0:
        remedy = "Reverse one of the axes: left-handed coordinates are none of a pose" if determinant else None
        what = "a reflection" if determinant else "singular"
        return InputError(f"{name} has the determinant {determinant:.6g}: it is {what}, not a rotation.", remedy=remedy)
    gram = r.T @ r
    off, scale = float(np.abs(gram - np.eye(3)).max()), float(np.cbrt(determinant))
    if tolerance is None and off < SHEARED:
        remedy = f"Pass tolerance={10.0 ** np.ceil(np.log10(2 * off)):.0e} for the nearest rotation"
    elif np.abs(gram - scale**2 * np.eye(3)).max() < SHEARED * scale**2:
        remedy = f"It is {scale:.6g} times a rotation: divide its first three columns by that"
    else:
        remedy = "It shears or stretches; a larger tolerance= takes the nearest rotation all the same"
    return InputError(f"the columns of {name} are not orthonormal: their products are off by {off:.3g}.", remedy=remedy)


@overload
def to_matrix(x: Multivector, *, status: Literal[False] = ..., strict: bool = ...) -> Array: ...
@overload
def to_matrix(x: Multivector, *, status: Literal[True], strict: bool = ...) -> tuple[Array, Statuses]: ...
def to_matrix(x: Multivector, *, status: bool = False, strict: bool = False) -> Array | tuple[Array, Statuses]:
    """Homogeneous matrices (..., 4, 4) of poses; options as of `act`."""
    pose = as_pose(x)
    entries: Array = unsigned_zeros(call("poses.matrix", pose).value)
    return array_result(entries.reshape(*pose.shape, 4, 4), pose._status, "to_matrix", status, strict, 2)
