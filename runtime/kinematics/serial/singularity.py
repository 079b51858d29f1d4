"""Singular values and rank of a chain's Jacobian, and the directions that are lost at singular poses."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...common.deprecation import renamed_attribute
from ...core.multivector import Multivector
from ...dispatch.formulas import ArrayOperand, evaluate
from .data import TOLERANCE, SerialChainData

Array = NDArray[Any]
#: Degrees of freedom of a body.
MOST = 6


class Singularity(NamedTuple):
    """Singularity measures of poses (...).

    Rotations are in radians, displacements of the tool's origin in the chain's own `length`, so that both compare.

    Attributes
    ----------
    singular_values : array (..., k)
        Singular values of the Jacobian, the largest first; k is 6 or the number of joints.
    rank : integer array (...)
        Number of singular values above 1e-9 of the largest.
    manipulability : array (...)
        Product of the first `freedom` singular values: zero at singular poses.
    singular : array (...)
        True where the rank is less than the chain's `freedom`.
    directions : Multivector (..., k)
        Twists of the world, one for each value: motions that the joints give the tool, freest first.
    lost_twist : Multivector (...)
        The least free of the `freedom` directions: at singular poses no joint rates give it.
    null_rates : array (..., n)
        Unit joint rates that move the tool least; at singular poses, and with more joints than freedom, not at all.
    """

    singular_values: Array
    rank: Array
    manipulability: Array
    singular: Array
    directions: Multivector
    lost_twist: Multivector
    null_rates: Array


for _old, _new in (("values", "singular_values"), ("lost", "lost_twist"), ("still", "null_rates")):
    setattr(Singularity, _old, renamed_attribute(_new))  # the body of a NamedTuple has fields only


def singularity(chain: SerialChainData, q: ArrayLike, threads: int | None = None) -> Singularity:
    """See `Chain.singularity`."""
    x = chain.coordinates(q)
    matrices, valid = chain.scaled_jacobian(x, threads)
    left, values, right = np.linalg.svd(matrices, full_matrices=True)
    count = values.shape[-1]
    rank = (values > TOLERANCE * values[..., :1]).sum(-1)
    free = chain.freedom
    tool = chain.forward(np.where(valid[..., None], x, 0.0), threads=threads)
    position = evaluate(chain.algebra, "motions.translation_of", tool).value
    columns = np.swapaxes(left[..., :count], -1, -2)
    for few in range(free if free < MOST else 0):
        members = valid & (rank == few)
        if members.any():
            columns[members, free - 1] = _nearby_direction(chain, matrices[members], left[members], right[members], few)
    unit = np.where(valid, 1.0, np.nan)[..., None, None]
    directions = _twists(chain, columns * unit, np.asarray(position.values)[..., None, :])
    values = values * unit[..., 0]
    return Singularity(
        values, np.where(valid, rank, 0)[()], np.prod(values[..., :free], -1)[()], (valid & (rank < free))[()],
        directions, directions[..., free - 1], right[..., -1, :] * unit[..., 0],
    )  # fmt: skip


def _nearby_direction(chain: SerialChainData, matrices: Array, left: Array, right: Array, rank: int) -> Array:
    """Directions (m, 6) lost at singular poses (m) of a chain that never has all six degrees of freedom.

    A lost direction is available at nearby poses: the columns rotate towards it, by dS = S x Omega, when joints move in
    the null space. It is the largest part of this rate outside of the directions that are available.
    """
    rows = ArrayOperand(np.ascontiguousarray(np.swapaxes(matrices, -1, -2)), MOST, "the columns")
    twists = evaluate(chain.algebra, "twists.screw_of_row", rows).value
    rates = evaluate(chain.algebra, "mechanics.bracket", twists[:, :, None], twists[:, None, :]).value
    column_rates = evaluate(chain.algebra, "twists.screw_row", rates.as_kind("twist")).value  # (m, column, joint, 6)
    before = np.tril(np.ones((chain.count, chain.count)), -1)
    column_rates = column_rates * before[:, :, None]
    gain = np.einsum("mijr,mki->mrkj", column_rates, right[:, rank:]).reshape(len(matrices), MOST, -1)
    available = left[:, :, :rank]
    gain = gain - available @ (np.swapaxes(available, -1, -2) @ gain)
    direction: Array = np.linalg.svd(gain)[0][:, :, 0]
    return direction


def _twists(chain: SerialChainData, rows: Array, position: Array) -> Multivector:
    """Twists about the world's origin, by rotations and displacements of a point of the tool."""
    vector = chain.algebra.kind("euclidean")
    rotation = ArrayOperand(np.ascontiguousarray(rows[..., :3]), vector, "the turns")
    displacement = ArrayOperand(chain.length * rows[..., 3:], vector, "the ways")
    at = ArrayOperand(np.broadcast_to(position, rows[..., :3].shape).copy(), vector, "the places")
    twists: Multivector = evaluate(chain.algebra, "chains.twist_about", rotation, displacement, at).value
    return twists
