"""Kinds of objects that are merged, and the kernels of each."""

from __future__ import annotations

from typing import NamedTuple

from ...formulas.objects import costs, merging
from ..kernel_spec import KernelSpec


class MergedKind(NamedTuple):
    """The kernels of a kind."""

    cost: KernelSpec
    aligned_cost: KernelSpec
    mean: KernelSpec
    aligned_mean: KernelSpec
    landmark: KernelSpec


def _kernels(kind: str) -> MergedKind:
    pair = (kind, kind)
    weighted = (*pair, "number", "number")
    return MergedKind(
        KernelSpec(costs.pair_cost, pair, f"cost_{kind}"),
        KernelSpec(costs.aligned_cost, pair, f"aligned_cost_{kind}"),
        KernelSpec(merging.mean_of_two, weighted, f"mean_{kind}"),
        KernelSpec(merging.aligned_mean_of_two, weighted, f"aligned_mean_{kind}"),
        KernelSpec(merging.landmark, (kind,), f"landmark_{kind}"),
    )


#: By name; all objects of one grade go as the last of that grade.
KINDS = {kind: _kernels(kind) for kind in ("point", "point_pair", "line", "circle", "plane", "sphere")}
