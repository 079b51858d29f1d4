"""Descriptions of compiled kernels: operands, results and formula of each, and who finds them by formula."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

from ..codegen.algebra.algebra import Kind
from ..codegen.execute.arrays import Binding

#: An operand: a kind, 0 for a plain number per item, or the length of a row of plain numbers.
Key = Kind | int


@dataclass(frozen=True)
class Result:
    """One result of a kernel: a multivector's kind, a row of ``size`` plain numbers, or a status."""

    name: str
    kind: Kind | None
    size: int
    is_status: bool = False


@dataclass(frozen=True)
class Entry:
    """One kernel of a manifest.

    ``results`` of a product: kinds of its operands whose result has another kind than the output, as the generator
    proved; None where it did not.
    """

    symbol: str
    module: str
    formula: str
    names: tuple[str, ...]
    inputs: tuple[Key, ...]
    outputs: tuple[Result, ...]
    results: Mapping[tuple[Key, ...], Kind] | None = None


class KernelSource(Protocol):
    """Kernels of an algebra by formula, and the compiled function of each."""

    @property
    def entries(self) -> Mapping[str, Sequence[Entry]]:
        """Kernels by formula."""

    def bound(self, entry: Entry) -> Binding:
        """The kernel as a function of arrays."""
