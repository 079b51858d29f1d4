"""Programs of algorithms: one algorithm, those that it calls, their kernels, and a loop over items."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import Any

from .. import compiler
from ..build import source_digest
from ..ir.graph import reachable
from ..ir.loops.nodes import Function, KernelSignature
from ..ir.loops.types import BOOL, ArrayType, Scalar
from ..optimise.variants import Variant
from ..targets.c.instances import ONE_BY_ONE, Instance
from ..targets.c.lanes.items import lanes_item
from ..targets.c.lanes.printer import lanes_text
from ..targets.c.lanes.varying import Lanes
from ..targets.c.loops import c_functions, needs_elementary
from ..targets.c.names import c_function_name, stored_type
from ..targets.c.printer import ELEMENTARY
from ..targets.c.source import ExtensionSource
from ..targets.cuda.printer import loops_source
from ..targets.loops import counted, in_calling_order
from ..targets.numba.loops import elementary_functions, frame, imported_functions, numba_functions, numba_name
from ..targets.numba.rows import row_function
from ..targets.templates import render
from . import FUNCTIONS, extension_of

_MAIN = "algorithm.c.j2"
#: What texts that import it depend on, from the package's folder.
ELEMENTARY_SOURCES = (
    *(f"elementary/{name}.py" for name in ("functions", "far_angles", "constants", "machine")),
    "../templates/numba/rows.py",
)


def c_item(function: Function) -> list[str]:
    """Statements that compute item i: arrays are parameters in their order, then returned numbers."""
    arguments, lines, after = [], [], []
    for k, p in enumerate(function.parameters):
        is_array = isinstance(p.type, ArrayType)
        assert isinstance(p.type, (ArrayType, Scalar))
        base = f"({stored_type(p.type)} *)arrays[{k}]"
        arguments.append(f"{base} + i * strides[{k}]" if is_array else f"({base})[i * strides[{k}]]")
        if p.name in counted(function):
            arguments.append(f"counts[{k}]")
    first = len(function.parameters)
    results = [f"(({stored_type(t)} *)arrays[{k}])[i * strides[{k}]]" for k, t in enumerate(function.results, first)]
    if len(results) > 1:
        for k, (t, result) in enumerate(zip(function.results, results, strict=True)):
            lines.append(f"{'int' if t == BOOL else stored_type(t)} result{k}_;")
            arguments.append(f"&result{k}_")
            after.append(f"{result} = result{k}_;")
    prefix = f"{results[0]} = " if len(results) == 1 else ""
    return [*lines, f"{prefix}FN({c_function_name(function.name)})({', '.join(arguments)});", *after]


def _numba_item(function: Function) -> tuple[list[str], str]:
    """Names of the arrays, and the statement that computes item i."""
    names, arguments = [], []
    for k, p in enumerate(function.parameters):
        name = f"{p.name}_items_"
        names.append(name)
        if isinstance(p.type, ArrayType):
            arguments += [name, f"i * strides[{k}]", *([f"counts[{k}]"] if p.name in counted(function) else [])]
        else:
            arguments.append(f"{name}[i * strides[{k}]]" + (" != 0" if p.type == BOOL else ""))
    first = len(names)
    results = [f"returned{k}_" for k in range(len(function.results))]
    for work, size in frame(function).items():
        arguments += [work, "I(0)"] if size else []
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


def uses_elementary(functions: Sequence[Function]) -> bool:
    """Whether elementary.h is to be included."""
    nodes = (n for v in kernel_variants(functions) for n in reachable(v.roots))
    return needs_elementary(functions) or any(n.op in ELEMENTARY for n in nodes)


def loop_declarations(names: Iterable[str]) -> str:
    """Declarations of loops over items, for cffi."""
    arguments = (
        "(void *const *arrays, const ptrdiff_t *strides, const ptrdiff_t *counts, ptrdiff_t begin, ptrdiff_t end);"
    )
    return "".join(f"void {name}{arguments}\n" for name in names)


def algorithm_extension(
    function: Function, instances: Sequence[Instance] = ONE_BY_ONE, shared: Collection[str] | None = None,
    still: Mapping[str, Collection[int]] | None = None,
) -> ExtensionSource:  # fmt: skip
    """C text of an algorithm and its loops over items, ready to compile.

    Parameters
    ----------
    function : Function
    instances : sequence of Instance
        Precisions and vector widths: default both precisions, one item after the other.
    shared : collection of str, optional
        Parameters that all items share. Where they are named, several items are computed at once, as many as a vector
        of the instance has lanes; default: one.
    still : mapping of str to collection of int, optional
        Elements that all items share of other parameters, which nothing changes: whole fields of records.

    Raises
    ------
    AlgorithmError
        If items of which several are computed at once may take different paths.
    """
    return extension_of(f"algorithm_{function.name}", algorithm_files(function, instances, shared, still=still))


def algorithm_files(
    function: Function, instances: Sequence[Instance] = ONE_BY_ONE, shared: Collection[str] | None = None,
    scratch: Collection[str] = (), still: Mapping[str, Collection[int]] | None = None,
) -> dict[str, str]:  # fmt: skip
    """Texts of the C program of `algorithm_extension`: driver, functions that it includes, declarations for cffi.

    Where items share parameters, arrays of ``scratch`` are memory that a call brings along; see `lanes_item`.
    """
    variants = kernel_variants([function])
    elementary = uses_elementary([function])
    kernels = "".join(compiler.print_function(v) for v in variants)
    arrays, item, text = None, c_item(function), ""
    if shared is not None:
        lanes = Lanes(function, shared, still)
        text = lanes_text(lanes)
        arrays, item = lanes_item(lanes, scratch)
    values = {"instances": instances, "arrays": arrays, "item": item, "elementary": elementary}
    return {
        "kernels.c": render(_MAIN, function=function, **values),
        FUNCTIONS: kernels + "\n" + (text or c_functions([function])),
        "kernels.cdef": loop_declarations(f"bs_loop_{i.tag}" for i in instances),
    }


def algorithm_text(function: Function) -> str:
    """C text of an algorithm and what it calls, for reading."""
    return algorithm_files(function)[FUNCTIONS].lstrip()


def algorithm_cuda(function: Function, instances: Sequence[Instance] = ONE_BY_ONE) -> dict[str, str]:
    """Files of an algorithm in CUDA, with a launcher for each precision; see `targets.cuda.printer.loops_source`."""
    most = len(function.parameters) + len(function.results)
    return loops_source(algorithm_files(function, instances), {f"bs_loop_{i.tag}": most for i in instances})


def algorithm_numba(function: Function) -> str:
    """Python text of an algorithm and its loop over items, for numba."""
    return numba_text(function.name, {"loop_over_items_": function})


def numba_text(title: str, functions: Mapping[str, Function]) -> str:
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
        imported=imported_functions(functions.values()),
        digest=source_digest.digest(ELEMENTARY_SOURCES) if used else "",
    )


def _numba_loop(name: str, function: Function) -> dict[str, Any]:
    arrays, call = _numba_item(function)
    return {"name": name, "arrays": arrays, "call": call, "work": frame(function)}
