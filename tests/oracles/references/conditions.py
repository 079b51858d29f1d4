"""How much rounding of controls and rays moves what references say: derivatives in double precision."""

from __future__ import annotations

from math import comb
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .blades import METRIC as SQUARES
from .blades import PAIRS, parity

Array = NDArray[np.float64]
#: Imaginary step of derivatives: so small that its square is nothing. Real step of second ones.
STEP, WIDE = 1e-40, 1e-6
METRIC = np.array(SQUARES, float)
FIRST, SECOND = np.array(PAIRS).T


def derivatives(kind: str, controls: Array, origins: Array, directions: Array, t: Array) -> tuple[Array, Array, Array]:
    """Of F = (L v C)^2, or L ^ P, at parameters t (n,) of curves (n, controls, 10) and rays (n, 3).

    Returns
    -------
    change, rate, curvature : (n,) arrays
        What a relative change of one in the coefficients of controls and ray makes of F, to first order, in the
        frame of the numbers; the derivatives of F by t.
    """
    lines = _lines(origins, directions)
    value, unit = _blended(controls, t), np.eye(10)[:, None] * 1j * STEP
    by_sum = np.imag(_condition(kind, value + unit, lines + 0j)) / STEP
    by_line = np.imag(_condition(kind, value + 0j, lines + unit)) / STEP

    def rate(at: Array) -> Array:
        return np.asarray(np.imag(_condition(kind, _blended(controls, at + 1j * STEP), lines + 0j)) / STEP)

    sizes = np.einsum("kr,rk->r", np.abs(_basis(controls.shape[1] - 1, t)), np.linalg.norm(controls, axis=-1))
    change = np.linalg.norm(by_sum, axis=0) * sizes + np.linalg.norm(by_line, axis=0) * np.linalg.norm(lines, axis=-1)
    return change, rate(t), (rate(t + WIDE) - rate(t - WIDE)) / (2 * WIDE)


def _basis(n: int, t: Any) -> Any:
    return np.array([comb(n, k) * t**k * (1 - t) ** (n - k) for k in range(n + 1)])


def _blended(controls: Array, t: Any) -> Any:
    return np.einsum("kr,rkc->rc", _basis(controls.shape[1] - 1, t), controls)


def _lines(origins: Array, directions: Array) -> Array:
    """Entries of the skew matrices of rays."""
    square = np.sum(origins**2, -1, keepdims=True)
    points = np.concatenate([origins, (square - 1) / 2, (square + 1) / 2], -1)
    ways = np.concatenate([directions, np.zeros((len(directions), 2))], -1)
    vectors = np.stack([points, ways, np.broadcast_to([0.0, 0, 0, 1, 1], points.shape)], -2)
    entries = []
    for pair in PAIRS:
        rest = [m for m in range(5) if m not in pair]
        entries.append(parity((*pair, *rest)) * np.linalg.det(vectors[..., rest]))
    return np.stack(entries, -1)


def _condition(kind: str, sums: Any, lines: Any) -> Any:
    """F of skew matrices (..., 10) and lines (..., 10)."""
    sums, lines = np.broadcast_arrays(sums, lines)
    b = np.zeros((*sums.shape[:-1], 5, 5), complex)
    b[..., FIRST, SECOND], b[..., SECOND, FIRST] = sums, -sums
    m = b * METRIC
    square = m @ m
    sign = 1 if kind == "pairs" else -1
    p = sign * np.trace(square, axis1=-2, axis2=-1) / 2
    fourth = np.trace(square @ square, axis1=-2, axis2=-1)
    s = np.sqrt(fourth - p * p)
    small = np.where(p.real > 0, (2 * p * p - fourth) / (2 * (p + s)), (p - s) / 2)
    blade = (square @ b - (sign * small)[..., None, None] * b)[..., FIRST, SECOND]
    if kind == "pairs":
        return np.sum(blade * lines, -1)
    total = 0
    for k in range(5):
        y = 0
        for i, pair in enumerate(PAIRS):
            if k not in pair:
                rest = tuple(x for x in range(5) if x not in (k, *pair))
                y = y + parity((k, *pair, *rest)) * lines[..., i] * blade[..., PAIRS.index(rest)]
        total = total + METRIC[k] * y * y
    return total
