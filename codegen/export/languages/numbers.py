"""Numbers in the precision of a file."""

from __future__ import annotations

import numpy as np


def rounded(number: float, precision: str) -> float:
    """The number in "f64" or "f32": infinite where it is too large for that."""
    if precision == "f64":
        return number
    with np.errstate(over="ignore"):
        return float(np.float32(number))
