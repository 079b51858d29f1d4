"""Error bounds of variants relative to the formula as written, over sampled inputs."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..algebra.algebra import Kind
from ..algebra.members import NumericSource, sample
from ..ir.graph import Node, evaluate
from ..rings.error_bound import BoundRing
from ..trace.kernel import Kernel

#: Sampled inputs per case.
SAMPLES = 64


def error_ratio(kernel: Kernel, roots: Sequence[Node]) -> float:
    """Largest ratio of a coefficient's error bound, computed by ``roots``, to that of the formula as written.

    One rounding of the coefficient itself is always allowed for: the written formula may copy what it returns.
    """
    ring = BoundRing()
    worst = 0.0
    for values in samples(kernel):
        bounded = {place: (v, 0.0) for place, v in values.items()}
        own = evaluate(roots, bounded, ring)
        written = evaluate(kernel.roots, bounded, ring)
        with np.errstate(all="ignore"):
            for (_, mine), (value, theirs) in zip(own, written, strict=True):
                allowed = np.maximum(theirs, np.abs(value))
                ratio = np.where(np.isfinite(allowed) & (mine > 0), mine / allowed, 0.0)
                worst = max(worst, float(np.max(np.where(np.isnan(ratio), np.inf, ratio))))
    return worst


def error_bound(kernel: Kernel, roots: Sequence[Node]) -> float:
    """Median, over ordinary sampled inputs, of the largest error bound of a coefficient.

    In units of roundoff of the largest coefficient of its output; 0 for results that are exact or never finite.
    """
    finite = finite_bounds(kernel, roots)
    return float(np.median(finite)) if finite.size else 0.0


def finite_bounds(kernel: Kernel, roots: Sequence[Node]) -> NDArray[np.float64]:
    """The error bounds of `error_bound` over ordinary sampled inputs, as far as they are finite."""
    with np.errstate(all="ignore"):
        bounded = {index: (v, 0.0) for index, v in next(samples(kernel)).items()}
        found = iter(evaluate(roots, bounded, BoundRing()))
        relative = [np.zeros(SAMPLES)]
        for output in kernel.outputs:
            pairs = np.array([[np.broadcast_to(x, SAMPLES) for x in next(found)] for _ in output.nodes])
            if output.role != "status":
                relative.append(np.max(pairs[:, 1], axis=0) / np.max(np.abs(pairs[:, 0]), axis=0))
        worst: NDArray[np.float64] = np.max(relative, axis=0)
    return worst[np.isfinite(worst)]


def samples(kernel: Kernel) -> Iterator[dict[tuple[int, int], Any]]:
    """Inputs for error bounds: ordinary members, large ones, near-coincident ones, versors near 1 and -1, and with
    them plain numbers near 1 and near 0.
    """
    near = 1e-6
    for scale, separation, unit in ((1, 0, 0), (100, 0, 0), (1, near, 0), (1, 0, 1), (1, 0, -1)):
        values: dict[tuple[int, int], Any] = {}
        first: dict[Kind, list[Any]] = {}
        source = NumericSource(SAMPLES, seed=7, scale=scale)
        for i, item in enumerate(kernel.inputs):
            if item.kind.form != "multivector":
                row = [source.scalar() for _ in range(item.kind.size)]
                if unit:
                    row = [near * v + max(unit, 0) for v in row]
            elif separation and item.kind in first:
                row = [v * (1 + separation * source.scalar()) for v in first[item.kind]]
            else:
                row = item.kind.values(sample(item.kind, source))
                if unit and item.kind.blades[0] == 0 and item.kind.form == "multivector":
                    row = [near * v for v in row]
                    row[0] = row[0] + unit
                first[item.kind] = row
            values.update({(i, j): v for j, v in enumerate(row)})
        yield values
