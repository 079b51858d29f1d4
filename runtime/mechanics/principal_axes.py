"""Principal moments and axes of inertia, from moments or tensors: checked, and decomposed by eigenvalues."""

from __future__ import annotations

from itertools import permutations
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..codegen.errors import InputError, ShapeError
from .given import MATRIX_TOLERANCE, finite

Array = NDArray[Any]
_ORDERS = np.array(list(permutations(range(3))))


def principal(inertia: Any, thin: bool = False) -> tuple[Array, Array]:
    """Principal moments (..., 3), and the principal axes as columns (..., 3, 3), of moments or of symmetric tensors.

    Axes are right-handed, each named after the axis of the body that it is nearest to.

    Parameters
    ----------
    inertia : array (..., 3) or (..., 3, 3)
        What ends in (3, 3) is taken for tensors; moments of a batch of three are (3, 1, 3), or three tensors.
    thin : bool
        Whether a moment may be zero, as of a rod about its axis.

    Raises
    ------
    InputError, ShapeError
        If a tensor is not symmetric, a moment is not positive, or one is larger than the other two together: which
        item, and by how much.
    """
    found = finite(inertia, "the inertia")
    if found.shape[-2:] == (3, 3):
        moments, axes = _decomposed(_symmetric(found))
    elif found.shape[-1:] == (3,):
        moments, axes = found, np.broadcast_to(np.eye(3), (*found.shape, 3)).copy()
    else:
        raise ShapeError(f"the inertia has shape {found.shape}; it ends in 3 (moments) or (3, 3) (a tensor).")
    size = moments.max(-1, initial=0.0)
    rounding = -MATRIX_TOLERANCE * size if thin else 0 * size
    bad = (moments.min(-1) < rounding if thin else moments.min(-1) <= 0) | (size <= 0)
    if bad.any():
        least = "not negative" if thin else "positive"
        raise InputError(
            f"a principal moment of inertia is {moments[bad].min():.3g}{_item(bad)}; they are {least}.",
            remedy="Give moments about the centre of mass, mass included",
        )
    moments = np.maximum(moments, 0.0)
    excess = 2 * size - moments.sum(-1)
    bad = excess > MATRIX_TOLERANCE * size
    if bad.any():
        raise InputError(
            f"the largest principal moment exceeds the sum of the others by {excess[bad].max():.3g}{_item(bad)}: "
            "no body has such an inertia.",
            remedy="Give moments about the centre of mass, mass included",
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


def _decomposed(tensor: Array) -> tuple[Array, Array]:
    """Eigenvalues and eigenvectors, ordered and turned towards the body's axes; a diagonal tensor is left as it is."""
    values, vectors = np.linalg.eigh(tensor)
    fits = np.abs(vectors)[..., np.arange(3), _ORDERS].sum(-1)  # of each order, along the body's axes
    order = _ORDERS[fits.argmax(-1)]
    values = np.take_along_axis(values, order, -1)
    vectors = np.take_along_axis(vectors, order[..., None, :], -1)
    along = vectors.diagonal(axis1=-2, axis2=-1)
    vectors = vectors * np.where(along < 0, -1.0, 1.0)[..., None, :]
    left = np.linalg.det(vectors) < 0  # the axis that is least along its own may point the other way
    weakest = np.abs(along).argmin(-1)
    flip = np.where(left[..., None] & (np.arange(3) == weakest[..., None]), -1.0, 1.0)
    return values, vectors * flip[..., None, :]


def _item(bad: Array) -> str:
    """Name of the first bad item of a batch."""
    if not bad.ndim:
        return ""
    place = tuple(int(i) for i in np.argwhere(bad)[0])
    return f" (item {place[0] if len(place) == 1 else place})"


__all__ = ["principal"]
