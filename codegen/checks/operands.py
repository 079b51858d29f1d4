"""Operands that kernels are tested on: random members of their kinds, and extreme ones."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from ..algebra.algebra import Kind
from ..algebra.members import NumericSource, sample
from ..execute.arrays import Array
from ..trace.kernel import Kernel

#: Size of huge numbers, and inverse of that of tiny ones, by bits of a number.
HUGE = {64: 1e6, 32: 1e3}
#: Distance from 1 and -1 of versors that are near to them.
NEAR = {64: 1e-6, 32: 1e-3}


def operand_cases(kernel: Kernel, dtype: Any, items: int, seed: int = 0) -> Iterator[tuple[str, list[Array]]]:
    """Cases of operands, by what they are.

    Ordinary members, huge and tiny ones, equal ones, versors near 1 and -1 (with them plain numbers near 1 and 0), and
    for layouts coefficients of which half are zero.

    Parameters
    ----------
    kernel : Kernel
    dtype : numpy type
        float64 or float32.
    items : int
        Items of each case.
    seed : int

    Yields
    ------
    (str, list of arrays)
        Text, and for each argument an array (items, size), or (items,) of plain numbers.
    """
    bits = 8 * np.dtype(dtype).itemsize
    kinds = [item.kind for item in kernel.inputs]

    def members(first: int, step: int, scale: float) -> list[Array]:
        return [_rows(kind, seed + first + step * n, scale, items, dtype) for n, kind in enumerate(kinds)]

    yield "ordinary members", members(1, 10, 1.0)
    yield f"members of size {HUGE[bits]:g}", members(2, 10, HUGE[bits])
    yield f"members of size {1 / HUGE[bits]:g}", members(3, 10, 1 / HUGE[bits])
    yield "equal members", members(4, 0, 1.0)
    for unit in (1.0, -1.0):
        near = [_near_unit(kind, seed + 20 + n, unit, NEAR[bits], items, dtype) for n, kind in enumerate(kinds)]
        yield f"versors near {unit:g}", near
    if all(kind.is_layout for kind in kinds):
        rng = np.random.default_rng(seed + 5)
        yield (
            "sparse coefficients",
            [np.where(rng.random(a.shape) < 0.5, a, 0).astype(dtype) for a in members(6, 1, 1.0)],
        )


def _rows(kind: Kind, seed: int, scale: float, items: int, dtype: Any) -> Array:
    source = NumericSource(items, seed, scale)
    if kind.form == "multivector":
        columns = kind.values(sample(kind, source))
    else:
        columns = [source.scalar() for _ in range(kind.size)]
    stacked = np.stack([np.broadcast_to(c, (items,)) for c in columns], -1).astype(dtype)
    return stacked[..., 0] if kind.is_scalar_argument else stacked


def _near_unit(kind: Kind, seed: int, unit: float, near: float, items: int, dtype: Any) -> Array:
    own = _rows(kind, seed, 1.0, items, np.float64)
    if kind.form != "multivector":
        return np.asarray(near * own + max(unit, 0.0)).astype(dtype)
    if kind.blades[0] != 0 or kind.is_layout:
        return own.astype(dtype)
    versor, neighbour = (sample(kind, _Neighbours(items, seed, step)) for step in (0.0, near))
    product = kind.values(versor * ~neighbour)  # a versor times the reverse of a near one
    if any("x['1']" in text for text in kind.constraints):
        unit = 1.0  # -x is none of this kind
    return unit * np.stack([np.broadcast_to(v, (items,)) for v in product], -1).astype(dtype)


class _Neighbours(NumericSource):
    """The same random numbers for the same seed, but for a relative step."""

    def __init__(self, items: int, seed: int, step: float) -> None:
        super().__init__(items, seed)
        self.step = step
        self.other = np.random.default_rng(seed + 1)

    def scalar(self) -> Any:
        return super().scalar() * (1 + self.step * self.other.normal(size=self.count))
