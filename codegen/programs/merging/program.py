"""The program that merges objects of any kind: the algorithms of `greedy` for each of them."""

from __future__ import annotations

from functools import cache

from ...ir.loops.nodes import Function
from ...ir.loops.scope import Static
from ...ir.loops.types import REAL, ArrayType, StaticType
from .. import Program
from ..stock import stock_numba, stock_program
from . import greedy
from .kinds import KINDS

#: The file with the algorithms.
SOURCE = "programs/merging/greedy.py"


def _functions(kind: str) -> dict[str, Function]:
    """What is called for a kind: arrays have as many rows as there are objects, or nodes."""
    signature = KINDS[kind].landmark.kernel_signature
    (_, size), (_, marks) = signature.inputs[0], signature.outputs[0]
    rows = {"rows": size, "landmarks": marks, "leaves": marks, "boxes": 2 * marks}
    types = {name: ArrayType(REAL, (None, length)) for name, length in rows.items()}
    found = {}
    for algorithm in (greedy.begin, greedy.find, greedy.queue, greedy.step):
        parameters = algorithm.text.parameters
        given = [Static(kind) if isinstance(p.type, StaticType) else types.get(p.name, p.type) for p in parameters]
        found[algorithm.name] = algorithm.specialised(given)
    return found


@cache
def merge_program() -> Program:
    """The algorithms of all kinds, and their kernels."""
    specs = [spec for kind in KINDS.values() for spec in kind]
    parts = {kind: _functions(kind) for kind in KINDS}
    return stock_program("merge", "Merging of similar objects", parts, specs, SOURCE)


@cache
def merge_numba(kind: str) -> str:
    """The algorithms of a kind for numba."""
    sources = (SOURCE, "programs/merging/program.py", "specs/cga3d.toml")
    return stock_numba(f"merge_{kind}", lambda: {f"{n}_{kind}": f for n, f in _functions(kind).items()}, sources)
