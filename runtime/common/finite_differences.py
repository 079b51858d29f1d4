"""Derivatives of a function of time by differences of order eight, at a step chosen by comparison of steps."""

from __future__ import annotations

import math
from collections.abc import Callable
from fractions import Fraction
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..codegen.errors import InputError

Array = NDArray[Any]
#: Sample points of a derivative of order eight.
POINTS = 9
#: Samples before the time where both sides are in the run.
MIDDLE = 4
#: Steps are powers of ten of seconds: the smallest exponent,
MIN_EXPONENT = -6
#: and for short runs the smallest relative to their duration.
RELATIVE_EXPONENT = -4
#: A step is compared with this fraction of it: irrational, for a path looks the same at all multiples of its period.
GOLDEN = (math.sqrt(5) - 1) / 2
#: Derivatives that differ by more than this fraction have nothing in common, or are rounding of zero.
ALIKE = 1e-3


@cache
def weights(behind: int) -> tuple[Array, Array]:
    """Weights of the first and second derivative for values at -behind, .. steps: from the interpolating polynomial."""
    nodes = [Fraction(k - behind) for k in range(POINTS)]
    first, second = np.zeros(POINTS), np.zeros(POINTS)
    for j, node in enumerate(nodes):
        polynomial = [Fraction(1)]  # one at its own node and zero at all others, constant first
        for other in nodes[:j] + nodes[j + 1 :]:
            raised, kept = [Fraction(0), *polynomial], [*polynomial, Fraction(0)]
            polynomial = [(r - other * k) / (node - other) for r, k in zip(raised, kept, strict=True)]
        first[j], second[j] = float(polynomial[1]), 2 * float(polynomial[2])
    return first, second


class Differences:
    """A function of time with its first two derivatives by differences, at a step that is found once.

    They look at both sides of a time, so that the function is asked a little before and after the run. Of one that
    fails there derivatives near the ends are those from inside.
    """

    def __init__(self, function: Callable[[float], Array], times: tuple[float, float]) -> None:
        self._function, self._times = function, times
        self._bounded = False
        self._step = self._best()

    def __call__(self, t: float) -> tuple[Array, Array, Array]:
        return self._at(t, self._step)

    def _at(self, t: float, h: float) -> tuple[Array, Array, Array]:
        behind = self._behind(t, h) if self._bounded else MIDDLE
        middle = self._function(t)
        offsets = [k - behind for k in range(POINTS)]
        changes = [self._function(t + k * h) - middle if k else 0 * middle for k in offsets]
        first, second = (np.tensordot(w, np.array(changes), 1) for w in weights(behind))
        return middle, first / h, second / h**2

    def _behind(self, t: float, h: float) -> int:
        """How many nodes lie before a time, so that all of them are in the run."""
        begin, end = self._times
        before, after = (int((side + h * 1e-9) / h) for side in (t - begin, end - t))
        return max(min(MIDDLE, before), POINTS - 1 - after)

    def _best(self) -> float:
        begin, end = self._times
        low = (
            MIN_EXPONENT if end == begin else min(MIN_EXPONENT, math.floor(math.log10(end - begin)) + RELATIVE_EXPONENT)
        )
        steps: list[float] = [10.0 ** (k / 2) for k in range(2 * low, 1)]
        errors: list[tuple[float, float]] = []
        for h in steps:
            try:
                errors.append(self._error(h))
            except InputError:  # perhaps only so far outside
                errors.append((np.inf, np.inf))
        best = steps[_best_step(errors)]
        try:
            if np.isfinite(errors).any():
                for outside in (begin - MIDDLE * best, end + MIDDLE * best):
                    self._function(outside)
                return best
        except InputError:
            pass
        self._bounded = True  # and what fails inside is reported
        most = (end - begin) / (POINTS + 1)
        inside = [h for h in steps if h < most] or [most]
        return inside[_best_step([self._error(h) for h in inside])]

    def _error(self, h: float) -> tuple[float, float]:
        """How much the second derivative at a step differs from that at a smaller one, and as a share of it."""
        begin, end = self._times
        samples = [begin + share * (end - begin) for share in (0.13, 0.51, 0.87)]
        pairs = [(self._at(t, h)[2], self._at(t, GOLDEN * h)[2]) for t in samples]
        error = max(float(np.abs(a - b).max()) for a, b in pairs)
        size = max(float(np.abs(a).max()) for a, _ in pairs)
        return error, error / size if size else np.inf


def _best_step(errors: list[tuple[float, float]]) -> int:
    """Index of the smallest relative error if any is below `ALIKE` (long steps miss fast components), else absolute."""
    absolute, relative = np.array(errors).T
    return int(np.argmin(relative if relative.min() < ALIKE else absolute))
