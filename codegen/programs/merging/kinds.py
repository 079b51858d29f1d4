"""Kinds of objects that are merged, and the kernels of each."""

from __future__ import annotations

from typing import NamedTuple

from ...formulas.objects import costs, merging
from ..kernel_spec import KernelSpec


class MergedKind(NamedTuple):
    """The kernels of a kind."""

    align: KernelSpec
    cost: KernelSpec
    mean: KernelSpec
    landmark: KernelSpec


def _kernels(kind: str) -> MergedKind:
    pair = (kind, kind)
    return MergedKind(
        KernelSpec(costs.align, pair, f"align_{kind}"),
        KernelSpec(costs.pair_cost, pair, f"cost_{kind}"),
        KernelSpec(merging.mean_of_two, (*pair, "number", "number"), f"mean_{kind}"),
        KernelSpec(merging.landmark, (kind,), f"landmark_{kind}"),
    )


#: By name; all objects of one grade go as the last of that grade.
KINDS = {kind: _kernels(kind) for kind in ("point", "point_pair", "line", "circle", "plane", "sphere")}
