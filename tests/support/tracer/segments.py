"""What the tests of pieces of curves share: random objects, and controls at 50 digits."""

from __future__ import annotations

import mpmath
import numpy as np
from mpmath import mpf

from ...oracles import circle_sums as oracle

U = 2.0**-53
FAR = np.array([1e6, -3e5, 2e6])
GOOD = ((0, 0, 0), (0, 0, 1), 1.0)


def circles(n, seed, at=(0.0, 0.0, 0.0), spread=2.0):
    random = np.random.default_rng(seed)
    return [
        (
            tuple((np.array(at) + [1.5 * i, 0, 0] + spread * random.normal(size=3)).tolist()),
            tuple(random.normal(size=3).tolist()),
            float(random.uniform(0.3, 2)),
        )
        for i in range(n)
    ]


def pairs(n, seed, at=(0.0, 0.0, 0.0)):
    random = np.random.default_rng(seed)
    return [
        tuple(tuple((np.array(at) + [i, 0, 0] + random.normal(size=3)).tolist()) for _ in range(2)) for i in range(n)
    ]


def exact(obj):
    return [oracle.exact(part) if np.ndim(part) else mpf(float(part)) for part in obj]


def row(obj, kind, found, piece):
    make = oracle.circle_row if kind == "circle" else oracle.pair_row
    return make(exact(obj), oracle.exact(found.center[piece]), mpf(float(found.size[piece])))


def combined(shares, objects, kind, found, piece):
    rows = [row(obj, kind, found, piece) for obj in objects]
    return [[mpmath.fsum(w * r[j] for w, r in zip(ws, rows, strict=True)) for j in range(10)] for ws in shares]


def assert_controls(found, piece, expected, ulps=200):
    got = found.controls[piece]
    size = max(abs(x) for r in expected for x in r)
    pairs_ = ((g, e) for gs, es in zip(got, expected, strict=True) for g, e in zip(gs, es, strict=True))
    worst = max(abs(mpf(float(g)) - e) for g, e in pairs_)
    assert worst <= ulps * U * size, float(worst / size)
