"""Kernels that were traced and compiled before, by what their declarations read: then neither is done again.

A record names the compiled unit, which is in the cache under a key of its own text, and says what the kernel returns.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Sequence
from dataclasses import dataclass

from ..algebra.algebra import Algebra, Kind
from ..trace.declared_formula import DeclaredFormula
from ..trace.kernel import Input, Output
from ..trace.reached_code import reached_text
from . import source_digest, text_cache
from .cpu_features import best_instances
from .extension import build_identity

_DIGITS = 24


@dataclass(frozen=True)
class BuiltKernel:
    """What is known of a kernel without tracing it: its name, its unit's in the cache, and outputs without nodes."""

    symbol: str
    unit: str
    inputs: tuple[Input, ...]
    outputs: tuple[Output, ...]


class Place:
    """Where the record of a declared kernel is, or will be.

    Parameters
    ----------
    declared : DeclaredFormula
    precision : {"f64", "f32"}

    Raises
    ------
    CompilerMissingError
        If there is no compiler, whose version is a part of the key.
    """

    def __init__(self, declared: DeclaredFormula, precision: str) -> None:
        stamp, text = source_digest.stamp(), reached_text(declared)
        self._declared = declared
        self._group = self._key = ""
        if stamp is not None and text is not None:
            parts = [text, precision, [i.tag for i in best_instances(precision)], build_identity()]
            self._group = f"built_{stamp[:_DIGITS]}"
            self._key = hashlib.sha256(json.dumps(parts).encode()).hexdigest()

    def read(self) -> BuiltKernel | None:
        """The record; None where there is none."""
        if not self._group:
            return None
        try:
            symbol, unit, outputs = json.loads(text_cache.read(self._group, f"{self._key}.json") or "")
            found = tuple(_output(self._declared.algebra, *parts) for parts in outputs)
        except (ValueError, TypeError, RecursionError):
            return None
        text_cache.touch(self._group)
        inputs = tuple(Input(n, k) for n, k in zip(self._declared.arguments, self._declared.kinds, strict=True))
        return BuiltKernel(symbol, unit, inputs, found)

    def write(self, symbol: str, unit: str, outputs: Sequence[Output]) -> None:
        """Keep the record of a kernel that was compiled now."""
        if self._group and all(o.kind.algebra is self._declared.algebra for o in outputs):
            record = json.dumps([symbol, unit, [_parts(o) for o in outputs]])
            text_cache.write(self._group, {f"{self._key}.json": record})


def _parts(output: Output) -> list[object]:
    kind = output.kind
    return [output.name, output.role, kind.name, kind.blades, kind.constraints, kind.member, kind.form]


def _output(
    algebra: Algebra, name: str, role: str, kind: str, blades: list[int], constraints: list[str], member: str, form: str
) -> Output:
    made = Kind(algebra, kind, tuple(blades), tuple(constraints), member, form)
    known = algebra.kinds.get(kind)
    own = next((k for k in (known, known and known.layout) if k == made), made)  # the algebra's own is compared faster
    return Output(name, own or made, (), role)
