"""Programs of algorithms: one algorithm, those that it calls, their kernels, and a loop over items."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

from .. import compiler
from ..build import source_digest, text_cache
from ..ir.graph import reachable
from ..ir.loops.nodes import Function, KernelSignature
from ..ir.loops.types import BOOL, INT, REAL, ArrayType, Parameter, Scalar
from ..optimise.variants import Variant
from ..targets.c.loops import c_functions, needs_elementary
from ..targets.c.printer import ELEMENTARY
from ..targets.c.source import ExtensionSource
from ..targets.loops import in_calling_order
from ..targets.numba.loops import elementary_functions, frame, numba_functions, numba_name
from ..targets.numba.rows import row_function
from ..targets.templates import included_headers, render
from . import Program, kernels_header
from .kernel_spec import KernelSpec, print_specs

#: Where an algorithm's text is in the C program.
_FUNCTIONS = "algorithm_functions.h"
_MAIN = "algorithm.c.j2"
#: What callers of a stock program's algorithms read: their parameters.
ENTRIES = "algorithms.json"
#: What texts that import it depend on, from the package's folder.
_ELEMENTARY_SOURCES = tuple(f"../templates/numba/{name}.py" for name in ("elementary", "elementary_constants", "rows"))
#: The same for texts of stock programs.
_TEXT_SOURCES = ("../templates/numba/algorithm.py.j2", *_ELEMENTARY_SOURCES)
_DIGITS = 24

_C_TYPES = {REAL: "S", INT: "ptrdiff_t", BOOL: "ptrdiff_t"}


def _c_item(function: Function) -> list[str]:
    """Statements that compute item i: arrays are parameters in their order, then returned numbers."""
    arguments, lines, after = [], [], []
    for k, p in enumerate(function.parameters):
        is_array = isinstance(p.type, ArrayType)
        scalar = p.type.scalar if isinstance(p.type, ArrayType) else p.type
        assert isinstance(scalar, Scalar)
        base = f"({_C_TYPES[scalar]} *)arrays[{k}]"
        arguments.append(f"{base} + i * strides[{k}]" if is_array else f"({base})[i * strides[{k}]]")
        if isinstance(p.type, ArrayType) and p.type.is_open:
            arguments.append(f"counts[{k}]")
    first = len(function.parameters)
    results = [f"(({_C_TYPES[t]} *)arrays[{k}])[i * strides[{k}]]" for k, t in enumerate(function.results, first)]
    if len(results) > 1:
        for k, (t, result) in enumerate(zip(function.results, results, strict=True)):
            lines.append(f"{'int' if t == BOOL else _C_TYPES[t]} result{k}_;")
            arguments.append(f"&result{k}_")
            after.append(f"{result} = result{k}_;")
    prefix = f"{results[0]} = " if len(results) == 1 else ""
    return [*lines, f"{prefix}FN({function.name})({', '.join(arguments)});", *after]


def _numba_item(function: Function) -> tuple[list[str], str]:
    """Names of the arrays, and the statement that computes item i."""
    names, arguments = [], []
    for k, p in enumerate(function.parameters):
        names.append(f"{p.name}_")
        if isinstance(p.type, ArrayType):
            arguments += [f"{p.name}_", f"i * strides[{k}]", *([f"counts[{k}]"] if p.type.is_open else [])]
        else:
            arguments.append(f"{p.name}_[i * strides[{k}]]" + (" != 0" if p.type == BOOL else ""))
    first = len(names)
    results = [f"result{k}_" for k in range(len(function.results))]
    for work, size in frame(function).items():
        arguments += [work, "0"] if size else []
    targets = ", ".join(f"{r}[i * strides[{first + k}]]" for k, r in enumerate(results))
    return [*names, *results], f"{targets}{' = ' if results else ''}{numba_name(function.name)}({', '.join(arguments)})"


def kernel_variants(functions: Iterable[Function]) -> list[Variant]:
    """Variants of all kernels of algorithms and of those that they call, and of their callees, callees first."""
    from ..targets.c.extension import in_dependency_order

    _, kernels = in_calling_order(functions)
    return in_dependency_order([_variant(k) for k in kernels])


def _variant(signature: KernelSignature) -> Variant:
    variant: Variant = signature.kernel.variant
    return variant


def _uses_elementary(functions: Sequence[Function]) -> bool:
    nodes = (n for v in kernel_variants(functions) for n in reachable(v.roots))
    return needs_elementary(functions) or any(n.op in ELEMENTARY for n in nodes)


def _declarations(names: Iterable[str]) -> str:
    arguments = (
        "(ptrdiff_t begin, ptrdiff_t end, void *const *arrays, const ptrdiff_t *strides, const ptrdiff_t *counts);"
    )
    return "".join(f"void {name}{arguments}\n" for name in names)


# -- one algorithm -------------------------------------------------------------------------------------------------


def algorithm_extension(function: Function) -> ExtensionSource:
    """C text of an algorithm and its loops over items in both precisions, ready to compile."""
    files = algorithm_files(function)
    headers = {**included_headers([files["kernels.c"]], [_FUNCTIONS]), _FUNCTIONS: files[_FUNCTIONS]}
    return ExtensionSource(f"algorithm_{function.name}", files["kernels.cdef"], files["kernels.c"], headers)


def algorithm_files(function: Function) -> dict[str, str]:
    """Texts of the C program: the driver, the functions that it includes, and declarations for cffi."""
    kernels = "".join(compiler.print_function(v) for v in kernel_variants([function]))
    driver = render(
        _MAIN, title=function.name, parts={"": {"bs_loop": _c_item(function)}}, precisions=(64, 32),
        headers=[_FUNCTIONS], elementary=_uses_elementary([function]), is_stock=False,
    )  # fmt: skip
    return {
        "kernels.c": driver,
        _FUNCTIONS: kernels + "\n" + c_functions([function]),
        "kernels.cdef": _declarations(f"bs_loop_{p}" for p in ("f64", "f32")),
    }


def algorithm_text(function: Function) -> str:
    """C text of an algorithm and what it calls, for reading."""
    return algorithm_files(function)[_FUNCTIONS].lstrip()


def algorithm_numba(function: Function) -> str:
    """Python text of an algorithm and its loop over items, for numba."""
    return _numba_text(function.name, {"loop_over_items_": function})


def _numba_text(title: str, functions: Mapping[str, Function]) -> str:
    """Python text of algorithms, what they call, and their loops over items by name."""
    variants = kernel_variants(functions.values())
    in_kernels = {n.op for v in variants for n in reachable(v.roots) if n.op in ELEMENTARY}
    used = sorted({*elementary_functions(functions.values()), *in_kernels})
    return render(
        "algorithm.py.j2",
        title=title,
        kernels=[row_function(v) for v in variants],
        text=numba_functions(functions.values()),
        loops=[_numba_loop(name, function) for name, function in functions.items()],
        elementary=used,
        digest=source_digest.digest(_ELEMENTARY_SOURCES) if used else "",
    )


def _numba_loop(name: str, function: Function) -> dict[str, Any]:
    arrays, call = _numba_item(function)
    return {"name": name, "arrays": arrays, "call": call, "work": frame(function)}


# -- stock programs ------------------------------------------------------------------------------------------------


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
    driver = render(
        _MAIN, title=title, precisions=(64,), headers=["kernels.h", _FUNCTIONS], elementary=_uses_elementary(roots),
        parts={part: {f"bs_{n}_{part}": _c_item(f) for n, f in named.items()} for part, named in parts.items()},
        is_stock=True,
    )  # fmt: skip
    files = {
        "kernels.c": driver,
        "kernels.h": kernels_header(texts),
        _FUNCTIONS: c_functions(roots),
        "kernels.cdef": "const char *bs_source_hash(void);\n" + _declarations(f"bs_{n}_f64" for n in functions),
        ENTRIES: _entries(parts),
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
    digest = source_digest.digest(("programs/algorithms.py", *sources, *_TEXT_SOURCES))
    group, file = digest and f"{name}_numba_{digest[:_DIGITS]}", f"{name}.py"
    text = text_cache.read(group, file) if group else None
    if text is None:
        text = _numba_text(name, functions())
        if group:
            text_cache.write(group, {file: text})
    elif group:
        text_cache.touch(group)
    return text


def _entries(parts: Mapping[str, Mapping[str, Function]]) -> str:
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
        return parameter.name, str(parameter.type.scalar), True
    return parameter.name, str(parameter.type), False
