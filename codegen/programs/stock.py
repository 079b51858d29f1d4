"""Stock programs that are made of algorithms: generated text, and what callers know of it."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence

from ..build import source_digest, text_cache
from ..ir.loops.nodes import Function
from ..ir.loops.types import ArrayType, Parameter
from ..targets.c.loops import c_functions
from ..targets.templates import render
from . import FUNCTIONS, Program, kernels_header
from .algorithms import ELEMENTARY_SOURCES, c_item, loop_declarations, numba_text, uses_elementary
from .kernel_spec import KernelSpec, print_specs

#: What callers read: the parameters of each algorithm.
ENTRIES = "algorithms.json"
_TEXT_SOURCES = ("programs/stock.py", "../templates/numba/algorithm.py.j2", *ELEMENTARY_SOURCES)


def stock_program(
    name: str, title: str, parts: Mapping[str, Mapping[str, Function]], specs: Sequence[KernelSpec], source: str
) -> Program:
    """Algorithms in double precision as a C program for a generated folder.

    Parameters
    ----------
    name, title : str
    parts : mapping of str to mapping of str to Function
        By the names that callers know; a part is compiled by itself where it is needed first.
    specs : sequence of KernelSpec
        The kernels that they call.
    source : str
        The file with the algorithms, from the package's folder; those that it imports are found.
    """
    texts = print_specs(specs)
    functions = {f"{n}_{part}": f for part, named in parts.items() for n, f in named.items()}
    roots = list(functions.values())
    items = {part: {f"bs_{n}_{part}": c_item(f) for n, f in named.items()} for part, named in parts.items()}
    driver = render("algorithms.c.j2", title=title, parts=items, elementary=uses_elementary(roots))
    files = {
        "kernels.c": driver,
        "kernels.h": kernels_header(texts),
        FUNCTIONS: c_functions(roots),
        "kernels.cdef": "const char *bs_source_hash(void);\n" + loop_declarations(f"bs_{n}_f64" for n in functions),
        ENTRIES: entries(parts),
    }
    return Program(name, tuple(texts), files, driver=tuple(specs), algorithms=_algorithm_files(source))


def _algorithm_files(source: str) -> tuple[str, ...]:
    """A file with algorithms, and those of its folder and of `algorithms` that it imports."""
    homes = ("algorithms/", source.rpartition("/")[0] + "/")
    return tuple(sorted(file for file in source_digest.closure([source]) if file.startswith(homes)))


def stock_numba(name: str, functions: Callable[[], Mapping[str, Function]], sources: Sequence[str]) -> str:
    """Text of a part of a stock program for numba: made once for each state of the sources, and kept in the cache.

    Parameters
    ----------
    name : str
    functions : callable
        The algorithms of the part, by the names that callers know.
    sources : sequence of str
        Files that they are made of, from the package's folder; what these import counts too.
    """
    return kept_text(f"{name}_numba", lambda: numba_text(name, functions()), sources)


def kept_text(name: str, make: Callable[[], str], sources: Sequence[str]) -> str:
    """A text of a stock program: made once for each state of the sources, and kept in the cache; see `stock_numba`."""
    return text_cache.made_once(name, (*sources, *_TEXT_SOURCES), f"{name}.txt", make)


def entries(parts: Mapping[str, Mapping[str, Function]]) -> str:
    """JSON: of each function the part, the parameters (name, type of numbers, whether an array), types of results."""
    lines = [
        f" {json.dumps(f'{name}_{part}')}: "
        + json.dumps(
            {"part": part, "parameters": [_parameter(p) for p in f.parameters], "results": [str(t) for t in f.results]}
        )
        for part, named in parts.items()
        for name, f in named.items()
    ]
    return "{\n" + ",\n".join(lines) + "\n}\n"


def _parameter(parameter: Parameter) -> tuple[str, str, bool]:
    if isinstance(parameter.type, ArrayType):
        return parameter.name, parameter.type.storage, True
    return parameter.name, str(parameter.type), False
