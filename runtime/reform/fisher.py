"""How much larger a region must be where a covariance is estimated from few residuals: Hotelling's T^2."""

from __future__ import annotations

from functools import lru_cache

#: Numbers of a twist.
FREEDOMS = 6
#: The level of the regions, and the quantile of chi^2 with six degrees of freedom there.
LEVEL, CHI_SQUARE = 0.95, 12.591587243743977
#: Residuals of the second kind are never counted as fewer: one gives a region 53 times as long.
LEAST_RESIDUALS = 1.0
#: Halvings of an interval of the quantile.
HALVINGS = 60
#: Sizes of a sample are looked up on a grid of this many steps to the unit.
STEPS = 16


def beyond(f: float, residuals: float) -> float:
    """P(F > f) of Fisher's distribution with 6 and any positive number of degrees of freedom.

    The incomplete beta function I_x(a, 3) is x^a times a polynomial, with a half of the number and
    x = residuals/(residuals + 6 f).
    """
    a = residuals / 2
    y = FREEDOMS * f / (residuals + FREEDOMS * f)
    return float((1 - y) ** a * (1 + a * y + a * (a + 1) / 2 * y * y))


def quantile(residuals: float, level: float = LEVEL) -> float:
    """The f with P(F > f) = 1 - level."""
    low, high = 0.0, 1.0
    while beyond(high, residuals) > 1 - level:
        low, high = high, 2 * high
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        low, high = (middle, high) if beyond(middle, residuals) > 1 - level else (low, middle)
    return (low + high) / 2


def widening(sample: float) -> float:
    """By how much a covariance is multiplied, so that the 95 % ellipsoid of the normal law is that of T^2.

    Parameters
    ----------
    sample : float
        Effective number of independent observations of the six numbers. T^2 is p m/(m - p + 1) F(p, m - p + 1).
    """
    return _widening(round(sample * STEPS))


@lru_cache(maxsize=4096)
def _widening(steps: int) -> float:
    sample = max(steps / STEPS, FREEDOMS - 1 + LEAST_RESIDUALS)
    residuals = sample - FREEDOMS + 1
    return FREEDOMS * sample / residuals * quantile(residuals) / CHI_SQUARE
