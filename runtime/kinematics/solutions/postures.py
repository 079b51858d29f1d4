"""All postures of an arm: arguments, candidates, refinement on the arm itself, results and statuses."""

from __future__ import annotations

import copy
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...codegen.errors import InputError
from ...common.validation import as_bool, as_choice, positive_float
from ...core.multivector import Multivector
from ...dispatch.item_statuses import raise_first
from ...dispatch.multivector_data import Statuses, statuses
from ...status import Status
from ..serial.inverse import inverse
from .closed_form import are_parallel, common_point, parallel_postures, wrist_postures
from .elimination import elimination_postures
from .subproblems import Line

if TYPE_CHECKING:
    from ..serial.data import SerialChainData

Array = NDArray[Any]
#: Differences of all angles, modulo a turn, up to which two postures are one: at least, and at most, of singular ones;
#: in between what may be left of a pose (in radians and lengths) decides, over the margin of the Jacobian.
SAME, SAME_SINGULAR, LEFT = 1e-7, 1e-3, 1e-11
#: Steps that bring a candidate to the pose.
STEPS = 50
#: Singular values of the Jacobian, relative to the largest, below which a posture is singular.
DEPENDENT = 1e-6
#: Ways to all postures.
METHODS = ("wrist", "parallel", "elimination")
TURN = 2 * np.pi
#: What Newton's method is to leave, in radians and lengths of the arm: rounding.
SMALL = 1e-13
#: A motor whose squared norm is so far from 1 is not unit, even if it was rounded to single precision.
NOT_UNIT = 1e-5
#: Digits of angles by which postures are in order.
DECIMALS = 9
#: Eliminations of a pose, at most, and starts of Newton's method anywhere where these may not be enough.
ATTEMPTS, RANDOM_STARTS = 3, 500
#: Margins of postures that may have a twin nearby, and how far that is looked for.
NEAR, VERY_NEAR = 1e-2, 3e-4
DISTANCES = np.array([1e-3, 1e-2, 0.03, 0.1, 0.3, 0.8])
#: By how much limits may be exceeded, in radians: rounding.
BEYOND = 1e-12
#: A joint that advances by no more than this for a radian, relative to the arm's length, rotates.
ROUNDING = 1e-12


@dataclass(frozen=True)
class Postures:
    """Postures of an arm at poses (...), those of a pose in the order of their coordinates.

    Attributes
    ----------
    q : array (..., k, 6)
        Coordinates within the limits; NaN behind the last posture of a pose. k is the largest number of postures.
    count : array (...)
        Number of postures.
    status : array (...) of codes, or Status
        OK; NOT_UNIQUE: some posture is singular: it stands for a family, or is a double one; UNREACHABLE: no posture
        within the limits; INVALID: the pose is not finite, or not unit.
    singular : array (..., k) of bool
        Postures where the Jacobian loses rank: joints move while the tool rests, a family of postures of which this is
        one; or two postures meet.
    angle, distance : array (..., k)
        By how much the tool misses the pose.
    method : str
        "wrist", "parallel" (closed forms) or "elimination".
    """

    q: Array
    count: NDArray[np.int64]
    status: Statuses
    singular: NDArray[np.bool_]
    angle: Array
    distance: Array
    method: str

    def __len__(self) -> int:
        return len(self.q)


class _Problem:
    """Axes, and the motions G x = turn x + shift of the tool, about a point amid the axes: that is near is exact."""

    def __init__(self, lines: Sequence[Line], turn: Array, shift: Array, length: float) -> None:
        origin = np.mean([line.point for line in lines], axis=0)
        self.lines = [Line(line.direction, line.point - origin) for line in lines]
        self.turn, self.shift, self.length = turn, shift + turn @ origin - origin, length

    def reversed(self) -> _Problem:
        """The same arm from its other end: angles are opposite, in the opposite order."""
        other = copy.copy(self)
        other.lines, other.turn = self.lines[::-1], np.swapaxes(self.turn, -1, -2)
        other.shift = -np.einsum("nij,nj->ni", other.turn, self.shift)
        return other

    def closed_form(self, method: str | None) -> tuple[str, Array] | None:
        """Name of a closed form and its starts (N, k, 6); None if there is none from this end."""
        center = common_point(self.lines[3:], self.length)
        is_wrist = not are_parallel(self.lines[3:5]) and not are_parallel(self.lines[4:])
        if method in (None, "wrist") and center is not None and is_wrist:
            return "wrist", wrist_postures(self.lines, center, self.turn, self.turn @ center + self.shift)
        if method in (None, "parallel") and are_parallel(self.lines[1:4]) and not are_parallel(self.lines[3:5]):
            return "parallel", parallel_postures(self.lines, self.turn, self.shift)
        return None

    def starts(self, method: str | None) -> tuple[str, Array]:
        """Starts (N, k, 6) for all postures, and how they were found."""
        for problem, sign in ((self, 1), (self.reversed(), -1)):
            found = problem.closed_form(method)
            if found is not None:
                return found[0], sign * found[1][..., ::sign]
        if method not in (None, "elimination"):
            raise InputError(
                f"this arm has no closed form {method!r}.", remedy="Leave out method=, or give 'elimination'"
            )
        return "elimination", self.eliminated(np.arange(len(self.turn)), 0)

    def eliminated(self, items: Array, seed: int) -> Array:
        """Starts of the elimination from both ends: too far off for Newton's method they seldom are from both."""
        parts = []
        for problem, sign in ((self, 1), (self.reversed(), -1)):
            found = elimination_postures(problem.lines, problem.turn[items], problem.shift[items], self.length, seed)
            parts.append(sign * found[..., ::sign])
        return np.concatenate(parts, 1)


def all_solutions(
    chain: SerialChainData, pose: Multivector | ArrayLike, tolerance: float, method: str | None, strict: bool
) -> Postures:
    """See `Chain.all_solutions`."""
    positive_float(tolerance, "tolerance")
    if method is not None:
        as_choice(method, "method", METHODS)
    lines = _lines(chain)
    goals = chain.as_motors(pose, "the pose")
    flat = chain.algebra.wrap(goals.kind, np.ascontiguousarray(goals.values.reshape(-1, 8)))
    valid = _is_motor(flat)
    moved = (flat * ~chain.tool).as_kind("motor", check=False)
    matrices = np.where(valid[:, None, None], chain.algebra.matrix(moved), np.eye(4))
    problem = _Problem(lines, matrices[:, :3, :3], matrices[:, :3, 3], chain.length)
    found_by, starts = problem.starts(method)
    found = _refine(chain, flat, starts, tolerance)
    if found_by == "elimination":
        # without limits their number is even unless one is double: an odd one lacks a posture
        for seed in range(1, ATTEMPTS + 1):
            items = np.flatnonzero((found.distinct.sum(-1) % 2 == 1) & ~found.singular.any(-1) & valid)
            if len(items):
                more = problem.eliminated(items, seed) if seed < ATTEMPTS else _anywhere(items, seed)
                found = _with_starts(chain, flat, found, items, more, tolerance)
    items = found.near_singular(NEAR if found_by == "elimination" else VERY_NEAR)
    if len(items):
        found = _with_starts(chain, flat, found, items, _twins(chain, found, items), tolerance)
    items = found.near_singular(VERY_NEAR)
    if len(items) and found_by == "elimination":  # whose roots are least certain there
        found = _with_starts(chain, flat, found, items, _anywhere(items, 0), tolerance)
    return _result(chain, found, valid, goals.shape, found_by, strict)


def _lines(chain: SerialChainData) -> list[Line]:
    joints, limit = chain.parameters.joints, ROUNDING * chain.length
    remedy = "chain.inverse finds single solutions of any chain"
    if chain.count != 6 or chain.joint_count != 6:
        raise InputError(f"all postures are those of six axes, and this chain has {chain.joint_count}.", remedy=remedy)
    for name, joint in zip(chain.names, joints, strict=True):
        if joint[6] == 0 or abs(joint[7]) > limit:
            raise InputError(f"all postures are those of six rotations, and {name} translates.", remedy=remedy)
    return [Line(joint[3:6], at) for joint, at in zip(joints, chain.joint_positions, strict=True)]


def _is_motor(goals: Multivector) -> NDArray[np.bool_]:
    """Which motors are finite, and unit to single precision."""
    with np.errstate(all="ignore"):
        square = np.asarray((goals * ~goals).grade(0).values[..., 0])
        return np.asarray(np.isfinite(goals.values).all(-1) & (np.abs(square - 1) < NOT_UNIT))


class _Refined(NamedTuple):
    """Angles (N, k, 6) that reach their poses, NaN for others; what is left, how far each is from being singular
    (the least singular value of its Jacobian, relative to the largest), and which is none of those before it."""

    q: Array
    angle: Array
    distance: Array
    margin: Array
    distinct: NDArray[np.bool_]

    def distinct_first(self) -> _Refined:
        """The same without columns in which no posture is new."""
        order = np.argsort(~self.distinct, axis=1, kind="stable")[:, : int(self.distinct.sum(-1).max(initial=0))]
        q = np.take_along_axis(self.q, order[..., None], 1)
        return _Refined(q, *(np.take_along_axis(values, order, 1) for values in self[1:]))

    def padded(self, count: int) -> _Refined:
        """A copy with so many columns."""
        return _Refined(*(
            np.concatenate(
                [v, np.full((len(v), count - v.shape[1], *v.shape[2:]), False if v.dtype == bool else np.nan)], 1
            )
            for v in self
        ))  # fmt: skip

    def near_singular(self, margin: float) -> Array:
        """Numbers of the poses with a posture that is nearly singular."""
        return np.flatnonzero(((self.margin < margin) & ~self.singular & self.distinct).any(-1))

    @property
    def singular(self) -> NDArray[np.bool_]:
        """Postures whose Jacobian loses rank."""
        return np.asarray(self.margin < DEPENDENT)


def _refine(chain: SerialChainData, goals: Multivector, starts: Array, tolerance: float) -> _Refined:
    """Bring candidates to the poses by Newton's method, without limits; those that are new, up to other columns."""
    items, candidates = np.nonzero(np.isfinite(starts).all(-1))
    free = copy.copy(chain)
    free.limits, free.searches = np.tile([-np.inf, np.inf], (6, 1)), {}
    targets = chain.algebra.wrap(goals.kind, goals.values[items])
    unit = chain.parameters.joints[:, 6]
    begin = starts[items, candidates] / unit
    found = inverse(free, targets, begin, SMALL, STEPS, 1, True, False, None, False, None)
    reached = (found.angle <= tolerance) & (found.distance <= tolerance * chain.length)
    q = np.full(starts.shape, np.nan)
    angle, distance = np.full(starts.shape[:-1], np.nan), np.full(starts.shape[:-1], np.nan)
    q[items, candidates] = np.where(reached[:, None], found.q * unit, np.nan)
    angle[items, candidates], distance[items, candidates] = found.angle, found.distance
    margin, _ = _margins(chain, q)
    return _Refined(q, angle, distance, margin, _first_of_each(q, margin)).distinct_first()


def _with_starts(
    chain: SerialChainData, goals: Multivector, found: _Refined, items: Array, starts: Array, tolerance: float
) -> _Refined:
    """Postures, and those from further starts for some poses."""
    part = chain.algebra.wrap(goals.kind, goals.values[items])
    other = _refine(chain, part, np.concatenate([found.q[items], starts], 1), tolerance)
    most = max(found.q.shape[1], other.q.shape[1])
    whole, part_of = found.padded(most), other.padded(most)
    for values, new in zip(whole, part_of, strict=True):
        values[items] = new
    return whole


def _margins(chain: SerialChainData, q: Array) -> tuple[Array, Array]:
    """Least singular values (N, k) of Jacobians at angles, relative to the largest, and their directions (N, k, 6)."""
    margin, direction = np.full(q.shape[:-1], np.nan), np.full(q.shape, np.nan)
    known = np.isfinite(q).all(-1)
    if known.any():
        unit = chain.parameters.joints[:, 6]
        matrices, _ = chain.scaled_jacobian(q[known] / unit)
        _, values, rows = np.linalg.svd(matrices / unit)
        margin[known], direction[known] = values[:, -1] / values[:, 0], rows[:, -1]
    return margin, direction


def _twins(chain: SerialChainData, found: _Refined, items: Array) -> Array:
    """Starts beside nearly singular postures, to both sides, for they may have a twin there."""
    near = (found.margin < NEAR) & ~found.singular & found.distinct
    _, direction = _margins(chain, np.where(near[..., None], found.q, np.nan)[items])
    steps = np.multiply.outer(np.array([-1.0, 1.0]), DISTANCES).reshape(-1, 1)
    beside = found.q[items][..., None, :] + steps * direction[..., None, :]
    return np.asarray(beside.reshape(len(items), -1, 6))


def _anywhere(items: Array, seed: int) -> Array:
    return np.random.default_rng(seed).uniform(-np.pi, np.pi, (len(items), RANDOM_STARTS, 6))


def _first_of_each(q: Array, margin: Array) -> NDArray[np.bool_]:
    """Where a posture is none of those before it: further away than both may be off."""
    blur = np.clip(LEFT / margin, SAME, SAME_SINGULAR)
    first = np.asarray(np.isfinite(q).all(-1))
    for j in range(1, q.shape[1]):
        difference = q[:, :j] - q[:, j : j + 1]
        apart = np.abs(difference - TURN * np.round(difference / TURN)).max(-1)
        first[:, j] &= ~((apart < np.minimum(blur[:, :j], blur[:, j : j + 1])) & first[:, :j]).any(-1)
    return first


def _within_limits(q: Array, limits: Array) -> tuple[Array, NDArray[np.bool_]]:
    """Angles, by whole turns, within the limits and there next to zero; and which are."""
    low, high = limits.T
    near = q - TURN * np.round((q - np.clip(0.0, low, high)) / TURN)
    near = np.where(near < low - BEYOND, near + TURN, near)
    near = np.where(near > high + BEYOND, near - TURN, near)
    within = (near >= low - BEYOND) & (near <= high + BEYOND)
    return near, within.all(-1)


def _result(
    chain: SerialChainData, found: _Refined, valid: NDArray[np.bool_], lead: tuple[int, ...], method: str, strict: bool
) -> Postures:
    unit = chain.parameters.joints[:, 6]
    q, within = _within_limits(found.q, chain.limits * unit[:, None])
    q = np.clip(q / unit, *chain.limits.T)
    kept = found.distinct & within & valid[:, None]
    count = kept.sum(-1)
    keys = np.where(kept[..., None], np.round(q, DECIMALS), np.inf)
    order = np.array([np.lexsort(rows.T[::-1]) for rows in keys], int).reshape(len(keys), q.shape[1])
    order = order[:, : int(count.max(initial=0))]
    is_kept = np.take_along_axis(kept, order, 1)

    def chosen(values: Array, empty: Any) -> Array:
        if values.ndim == 3:
            values = np.where(is_kept[..., None], np.take_along_axis(values, order[..., None], 1), empty)
        else:
            values = np.where(is_kept, np.take_along_axis(values, order, 1), empty)
        return values.reshape(*lead, *values.shape[1:])

    codes = np.where(count == 0, Status.UNREACHABLE, Status.OK).astype(np.uint8)
    codes[(found.singular & kept).any(-1)] = Status.NOT_UNIQUE
    codes[~valid] = Status.INVALID
    if as_bool(strict, "strict"):
        raise_first(codes.reshape(lead), "all_solutions")
    return Postures(
        chosen(q, np.nan), count.reshape(lead)[()], statuses(codes.reshape(lead), lead), chosen(found.singular, False),
        chosen(found.angle, np.nan), chosen(found.distance, np.nan), method,
    )  # fmt: skip
