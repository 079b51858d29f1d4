"""Joint coordinates that bring a chain's tool to poses: arguments checked, results named; the search is compiled."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from operator import index
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..arrays import truth
from ..calls import raise_first
from ..codegen.errors import InputError, ShapeError
from ..dynamics.given import number
from ..multivector import Multivector
from ..status import Status
from .chains_engine import Search

if TYPE_CHECKING:
    from .chains import Chain

Array = NDArray[Any]
#: A target is out of reach when it is so much further than all lengths together: their sum is rounded.
REACH_MARGIN = 1e-9
#: Of the starts of further attempts.
SEED = 0
#: Where joints without limits start further attempts, radians or the chain's lengths.
RANGE = np.pi


@dataclass(frozen=True)
class Solution:
    """Coordinates that bring the tool to its targets. Unpacks as two: ``q, status = chain.inverse(...)``.

    Attributes
    ----------
    q : array (..., n)
        NaN where the target was not reached, unless the nearest was asked for.
    status : array (...) of codes, or Status
        OK; NOT_UNIQUE: reached at a singular pose, where others reach it too, or q is known to half the digits;
        UNREACHABLE: further than all lengths together, or the attempts came to rest short of it; NOT_CONVERGED: the
        nearest ran out of iterations; INVALID: target or start is not finite.
    angle, distance : array (...)
        By what turn and way the tool misses the target.
    steps : array (...)
        Newton steps that were tried.
    """

    q: Any
    status: Any
    angle: Any
    distance: Any
    steps: Any

    def __iter__(self) -> Iterator[Any]:
        return iter((self.q, self.status))


def inverse(
    chain: Chain,
    targets: Multivector,
    start: ArrayLike | None = None,
    *,
    tolerance: float = 1e-12,
    iterations: int = 60,
    attempts: int = 32,
    nearest: bool = False,
    strict: bool = False,
    threads: int | None = 1,
) -> Solution:
    """See `Chain.inverse`."""
    goals = chain.as_motors(targets, "the targets")
    begin = _middle(chain) if start is None else chain.coordinates(start, "start")
    try:
        lead = np.broadcast_shapes(goals.shape, begin.shape[:-1])
    except ValueError:
        raise ShapeError(f"targets and starts have shapes {goals.shape} and {begin.shape[:-1]}.") from None
    motors = np.broadcast_to(goals.values, (*lead, 8)).reshape(-1, 8)
    starts = np.broadcast_to(begin, (*lead, chain.count)).reshape(-1, chain.count)
    keep = truth(nearest, "nearest")
    how = _search(chain, tolerance, iterations, attempts, keep)
    found = chain._driver.inverse(motors, starts, how, threads)
    status = found["status"].astype(np.uint8)
    q = found["x"]
    if not keep:
        q[status != Status.OK] = np.nan
    if (status == Status.OK).any():
        status[(status == Status.OK) & (found["rank"] < chain.freedom)] = Status.NOT_UNIQUE
    codes = status.reshape(lead)
    if truth(strict, "strict"):
        raise_first(codes, "inverse")
    angle, distance = (found["errors"][:, i].reshape(lead)[()] for i in range(2))
    shown = codes if lead else Status(int(codes))
    return Solution(q.reshape(*lead, chain.count), shown, angle, distance, found["steps"].reshape(lead)[()])


def _search(chain: Chain, tolerance: float, iterations: int, attempts: int, nearest: bool) -> Search:
    """The options, checked; what they amount to is kept for further calls with the same."""
    key = number(tolerance, "tolerance"), _count(iterations, "iterations"), _count(attempts, "attempts"), nearest
    known = chain._searches.get(key)
    if known is None:
        lower, upper = (side.copy() for side in chain.limits.T)
        known = chain._searches[key] = Search(
            lower, upper, _kicks(chain, key[2] - 1), key[1], key[0], chain.length, chain.reach * (1 + REACH_MARGIN),
            nearest,
        )  # fmt: skip
    return known


def _count(value: Any, name: str) -> int:
    try:
        found = None if isinstance(value, bool) else index(value)
    except TypeError:
        found = None
    if found is None or found < 1:
        raise InputError(f"{name} is {value!r}; a whole number from 1 on is needed.")
    return found


def _ranges(chain: Chain) -> tuple[Array, Array]:
    """Where attempts start: the limits, or as far as makes sense."""
    turns, advance = chain._numbers.joints[:, 6], np.abs(chain._numbers.joints[:, 7])
    unit = np.where(turns > 0, 1, chain.length) / np.where(turns > 0, turns, advance)
    lower, upper = chain.limits.T
    bound = RANGE * unit
    low = np.where(np.isfinite(lower), lower, np.where(np.isfinite(upper), upper - 2 * bound, -bound))
    high = np.where(np.isfinite(upper), upper, np.where(np.isfinite(lower), lower + 2 * bound, bound))
    return low, high


def _middle(chain: Chain) -> Array:
    """Zero, or where limits leave it out the middle."""
    low, high = _ranges(chain)
    found: Array = np.where((chain.limits[:, 0] <= 0) & (chain.limits[:, 1] >= 0), 0.0, (low + high) / 2)
    return found


def _kicks(chain: Chain, count: int) -> Array:
    """Starts of further attempts (count, n), spread over the ranges; the same every time."""
    low, high = _ranges(chain)
    share = np.random.default_rng(SEED).random((count, chain.count))
    found: Array = low + share * (high - low)
    return found
