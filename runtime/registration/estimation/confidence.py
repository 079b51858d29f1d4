"""Inflation of confidence regions whose covariance is estimated from few residuals: Hotelling's T^2."""

from __future__ import annotations

from functools import lru_cache

#: Dimension of a twist.
DEGREES_OF_FREEDOM = 6
#: Confidence level of the regions.
LEVEL = 0.95
#: Quantile of chi^2 with six degrees of freedom at this level.
CHI_SQUARE = 12.591587243743977
#: Smallest second number of degrees of freedom: one gives a region 53 times as long.
MIN_RESIDUALS = 1.0
#: Sizes of a sample are rounded to this many steps per unit.
STEPS_PER_UNIT = 16


def hotelling_inflation(sample: float) -> float:
    """Factor of a covariance that turns the 95 % ellipsoid of the normal distribution into that of T^2.

    Parameters
    ----------
    sample : float
        Effective number of independent observations of the six numbers. T^2 is p m/(m - p + 1) F(p, m - p + 1).
    """
    return _inflation(round(sample * STEPS_PER_UNIT))


@lru_cache(maxsize=4096)
def _inflation(steps: int) -> float:
    from scipy.special import fdtri  # takes longer to import than all of this package

    sample = max(steps / STEPS_PER_UNIT, DEGREES_OF_FREEDOM - 1 + MIN_RESIDUALS)
    residuals = sample - DEGREES_OF_FREEDOM + 1
    return float(DEGREES_OF_FREEDOM * sample / residuals * fdtri(DEGREES_OF_FREEDOM, residuals, LEVEL) / CHI_SQUARE)
