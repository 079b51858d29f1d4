"""Principal moments and axes of inertia, from moments or from tensors by their eigenvalues."""

from __future__ import annotations

from itertools import permutations
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..codegen.errors import InputError, ShapeError
from ..common.validation import finite_array, invalid
from .arguments import MATRIX_TOLERANCE
from .shapes import Shape

Array = NDArray[Any]
_ORDERS = np.array(list(permutations(range(3))))


def principal(inertia: Any, thin: bool = False) -> tuple[Array, Array]:
    """Principal moments (..., 3), and the principal axes as columns (..., 3, 3), of moments or of symmetric tensors.

    Axes are right-handed, each named after the axis of the body that it is nearest to.

    Parameters
    ----------
    inertia : array (..., 3) or (..., 3, 3)
        A shape that ends in (3, 3) means tensors; moments of a batch of three are (3, 1, 3), or three tensors.
    thin : bool
        True if a moment may be zero, as that of a rod about its axis.

    Raises
    ------
    InputError, ShapeError
        If a tensor is not symmetric, a moment is not positive, or one is larger than the other two together: which
        item, and by how much.
    """
    if isinstance(inertia, Shape):
        raise invalid(inertia, "the inertia", "moments or a tensor", remedy="That of a shape is shape.inertia(mass)")
    inertia = finite_array(inertia, "the inertia")
    if inertia.shape[-2:] == (3, 3):
        moments, axes = _eigen_decomposition(_symmetric(inertia))
    elif inertia.shape[-1:] == (3,):
        moments, axes = inertia, np.broadcast_to(np.eye(3), (*inertia.shape, 3)).copy()
    else:
        raise ShapeError(f"the inertia has shape {inertia.shape}; it ends in 3 (moments) or (3, 3) (a tensor).")
    size = moments.max(-1, initial=0.0)
    rounding = -MATRIX_TOLERANCE * size if thin else 0 * size
    bad = (moments.min(-1) < rounding if thin else moments.min(-1) <= 0) | (size <= 0)
    if bad.any():
        needed = "not negative" if thin else "positive"
        raise InputError(
            f"a principal moment of inertia is {moments[bad].min():.3g}{_item(bad)}; they are {needed}.",
            remedy="Give moments about the center of mass, mass included",
        )
    moments = np.maximum(moments, 0.0)
    excess = 2 * size - moments.sum(-1)
    bad = excess > MATRIX_TOLERANCE * size
    if bad.any():
        raise InputError(
            f"the largest principal moment exceeds the sum of the others by {excess[bad].max():.3g}{_item(bad)}: "
            "no body has such an inertia.",
            remedy="Give moments about the center of mass, mass included",
        )
    return moments, axes


def _symmetric(tensor: Array) -> Array:
    skew = np.abs(tensor - np.swapaxes(tensor, -1, -2)).max((-1, -2))
    bad = skew > MATRIX_TOLERANCE * np.abs(tensor).max((-1, -2))
    if bad.any():
        raise InputError(
            f"the inertia is not symmetric: it differs from its transpose by up to {skew[bad].max():.3g}{_item(bad)}.",
            remedy="Products of inertia enter both triangles with a minus sign, -integral of x y dm",
        )
    return np.asarray((tensor + np.swapaxes(tensor, -1, -2)) / 2)


def _eigen_decomposition(tensor: Array) -> tuple[Array, Array]:
    """Eigenvalues and eigenvectors, ordered and oriented like the body's axes; a diagonal tensor stays as it is."""
    values, vectors = np.linalg.eigh(tensor)
    alignment = np.abs(vectors)[..., np.arange(3), _ORDERS].sum(-1)  # of each order, with the body's axes
    order = _ORDERS[alignment.argmax(-1)]
    values = np.take_along_axis(values, order, -1)
    vectors = np.take_along_axis(vectors, order[..., None, :], -1)
    along = vectors.diagonal(axis1=-2, axis2=-1)
    vectors = vectors * np.where(along < 0, -1.0, 1.0)[..., None, :]
    left_handed = np.linalg.det(vectors) < 0  # the least aligned axis is flipped
    weakest = np.abs(along).argmin(-1)
    flip = np.where(left_handed[..., None] & (np.arange(3) == weakest[..., None]), -1.0, 1.0)
    return values, vectors * flip[..., None, :]


def _item(bad: Array) -> str:
    """Index of the first bad item of a batch, as messages end with it."""
    if not bad.ndim:
        return ""
    index = tuple(int(i) for i in np.argwhere(bad)[0])
    return f" (item {index[0] if len(index) == 1 else index})"


__all__ = ["principal"]
