"""How freely a chain's joints move its tool: singular values, rank, and what is lost at singular poses."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..calls import Numbers, call
from ..multivector import Multivector

if TYPE_CHECKING:
    from .chains import Chain

Array = NDArray[Any]
#: Singular values below this share of the largest count as zero.
TOLERANCE = 1e-9
#: Freedoms of a body.
MOST = 6
#: Poses by which the rank of a chain in general is found.
SAMPLES = 5


class Singularity(NamedTuple):
    """How freely the tool moves at poses (...).

    Turns are in radians, ways of the tool's origin in the chain's own `length`, so that both compare.

    Attributes
    ----------
    values : array (..., k)
        Singular values of the Jacobian, the largest first; k is 6 or the number of joints.
    rank : integer array (...)
        Of them those above 1e-9 of the largest.
    manipulability : array (...)
        Product of the first `freedom` of them: zero at singular poses.
    singular : array (...)
        Whether the rank is less than the chain's `freedom`.
    directions : Multivector (..., k)
        Twists of the world, one for each value: motions that the joints give the tool, freest first.
    lost : Multivector (...)
        Of the `freedom` directions the least free: at singular poses what no joint rates give.
    still : array (..., n)
        Unit joint rates that move the tool least; at singular poses, and with more joints than freedom, not at all.
    """

    values: Array
    rank: Any
    manipulability: Any
    singular: Any
    directions: Multivector
    lost: Multivector
    still: Array


def singularity(chain: Chain, q: ArrayLike, threads: int | None = 1) -> Singularity:
    """See `Chain.singularity`."""
    x = chain.coordinates(q)
    matrices, good = _scaled(chain, x, threads)
    left, values, right = np.linalg.svd(matrices, full_matrices=True)
    count = values.shape[-1]
    rank = (values > TOLERANCE * values[..., :1]).sum(-1)
    free = chain.freedom
    tool = chain.forward(np.where(good[..., None], x, 0.0), threads=threads)
    place = call(chain.algebra, "motions.translation_of", tool).value
    columns = np.swapaxes(left[..., :count], -1, -2)
    for few in range(free if free < MOST else 0):
        found = good & (rank == few)
        if found.any():
            columns[found, free - 1] = _gained(chain, matrices[found], left[found], right[found], few)
    unit = np.where(good, 1.0, np.nan)[..., None, None]
    directions = _twists(chain, columns * unit, np.asarray(place.values)[..., None, :])
    values = values * unit[..., 0]
    return Singularity(
        values, np.where(good, rank, 0)[()], np.prod(values[..., :free], -1)[()], (good & (rank < free))[()],
        directions, directions[..., free - 1], right[..., -1, :] * unit[..., 0],
    )  # fmt: skip


def _gained(chain: Chain, matrices: Array, left: Array, right: Array, rank: int) -> Array:
    """Of singular poses (m) of a chain that never has all six freedoms, the direction (m, 6) that it has nearby.

    Among all directions that are not there it is what the columns turn to, by dS = S x Omega, where joints move that
    leave the tool at rest, off the directions that are there.
    """
    rows = Numbers(np.ascontiguousarray(np.swapaxes(matrices, -1, -2)), MOST, "the columns")
    twists = call(chain.algebra, "twists.screw_of_row", rows).value
    rates = call(chain.algebra, "mechanics.bracket", twists[:, :, None], twists[:, None, :]).value
    turned = call(chain.algebra, "twists.screw_row", rates.as_kind("twist")).value  # (m, column, joint, 6)
    before = np.tril(np.ones((chain.count, chain.count)), -1)
    turned = turned * before[:, :, None]
    gain = np.einsum("mijr,mki->mrkj", turned, right[:, rank:]).reshape(len(matrices), MOST, -1)
    there = left[:, :, :rank]
    gain = gain - there @ (np.swapaxes(there, -1, -2) @ gain)
    found: Array = np.linalg.svd(gain)[0][:, :, 0]
    return found


def freedom(chain: Chain) -> int:
    """Rank of the Jacobian at poses in general."""
    low, high = (
        np.where(np.isfinite(side), side, other) for side, other in zip(chain.limits.T, (-3.0, 3.0), strict=True)
    )
    joints = np.arange(chain.count)
    share = (np.outer(np.arange(1, SAMPLES + 1), np.sqrt(2.0) * (joints + 1)) + 0.3 * joints) % 1
    matrices, _ = _scaled(chain, low + share * (high - low), 1)
    values = np.linalg.svd(matrices, compute_uv=False)
    return int((values > TOLERANCE * values[:, :1]).sum(-1).max())


def _scaled(chain: Chain, x: Array, threads: int | None) -> tuple[Array, Array]:
    """Jacobians at the tool's origin, a length worth a radian; zero where they are not finite, and where they are."""
    matrices = chain.jacobian(x, "world", np.zeros(3), threads=threads)
    matrices[..., 3:, :] /= chain.length
    good = np.isfinite(matrices).all((-1, -2))
    return np.where(good[..., None, None], matrices, 0.0), good


def _twists(chain: Chain, rows: Array, place: Array) -> Multivector:
    """Twists about the world's origin of turns and ways of a point of the tool."""
    vector = chain.algebra.kind("euclidean")
    turn = Numbers(np.ascontiguousarray(rows[..., :3]), vector, "the turns")
    way = Numbers(chain.length * rows[..., 3:], vector, "the ways")
    at = Numbers(np.broadcast_to(place, rows[..., :3].shape).copy(), vector, "the places")
    made: Multivector = call(chain.algebra, "chains.twist_about", turn, way, at).value
    return made
