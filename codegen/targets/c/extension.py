"""The C sources of an extension module: kernels in dependency order, for a list of instances."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from ...errors import TraceError
from ...optimise.variants import Variant
from ...trace.kernel import Kernel
from ..templates import included_headers, render, template_text
from .instances import BASELINE, OF_KERNELS, PORTABLE, SCALAR, WIDE, Instance
from .printer import c_function, symbol
from .source import ExtensionSource

__all__ = [
    "BASELINE",
    "PORTABLE",
    "SCALAR",
    "WIDE",
    "Instance",
    "bodies_text",
    "extension_source",
    "in_dependency_order",
    "main_files",
    "unit_text",
]

#: What the extension that calls kernels which are made at run time has besides.
_ADDED = """int bs_add_kernel(const void *unit);
void bs_fold(ptrdiff_t count, ptrdiff_t size, ptrdiff_t step, double *sums, double *errors);
unsigned char bs_join(unsigned char code, const unsigned char *codes, ptrdiff_t n);
void bs_run_sums(int kernel, int single, ptrdiff_t begin, ptrdiff_t end, ptrdiff_t n, ptrdiff_t length, ptrdiff_t tile,
    ptrdiff_t width, int count, const ptrdiff_t *sizes, const ptrdiff_t *rows, void *const *tiles, void *const *lanes,
    void *const *sums, int operands, const void *const *ins, const ptrdiff_t *strides);
typedef struct {
  void *loop; int shared; ptrdiff_t size; void *arrays[14]; const ptrdiff_t *strides, *counts;
} bs_row_call;
int bs_call_row(const bs_row_call *call, const void *row, void *result);
"""


def _same(first: Kernel, second: Kernel) -> bool:
    """Return whether two kernels are one, perhaps traced twice: the same formula on the same kinds."""
    if first is second:
        return True
    kinds = [[(i.name, i.kind) for i in k.inputs] for k in (first, second)]
    return first.formula is second.formula and kinds[0] == kinds[1]


def in_dependency_order(variants: Iterable[Variant]) -> list[Variant]:
    """Variants and those of the kernels that they call, callees first, each once.

    Raises
    ------
    TraceError
        If two different kernels have one name.
    """
    order: dict[str, Variant] = {}

    def visit(variant: Variant) -> None:
        kernel = variant.kernel
        earlier = order.get(symbol(kernel))
        if earlier is not None and not _same(earlier.kernel, kernel):
            raise TraceError(f"two different kernels are called {kernel.name!r}; give one another name (name=...).")
        if earlier is None:
            for callee in kernel.callees:
                visit(variant.callees[callee])
            order[symbol(kernel)] = variant

    for variant in variants:
        visit(variant)
    return list(order.values())


def calls_files(instances: Sequence[Instance] = OF_KERNELS) -> dict[str, str]:
    """Generated files of the extension that calls kernels which are made at run time: kernels.c and kernels.cdef."""
    return {
        "kernels.c": render("calls.c.j2", instances=instances),
        "kernels.cdef": _ADDED + template_text("calls.cdef"),
    }


def _declarations() -> str:
    return template_text("kernels.cdef") + template_text("calls.cdef")


def main_files(title: str, symbols: Mapping[str, Sequence[str]]) -> dict[str, str]:
    """kernels.c and kernels.cdef of a folder of kernels, whose names are given by module."""
    return {
        "kernels.c": _main_text(title, symbols, OF_KERNELS, ()),
        "kernels.cdef": _declarations(),
    }


def bodies_text(variants: Sequence[Variant]) -> str:
    """C text of the kernels' bodies and of those that they call, for one instance."""
    functions = [c_function(v) for v in in_dependency_order(variants)]
    return render("kernels.h.j2", functions=functions)


def unit_text(title: str, module: str, variants: Sequence[Variant]) -> str:
    """C text of the kernels of one module and of their callees: one translation unit, for any instance."""
    functions = [c_function(v) for v in in_dependency_order(variants)]
    return render(
        "unit.c.j2",
        title=title,
        module=module,
        functions=functions,
        batched=[symbol(v.kernel) for v in variants],
        elementary=any(f.elementary for f in functions),
        statuses=any(p.is_status for f in functions for p in f.outputs),
    )


def kernel_source(variant: Variant, instance: Instance) -> ExtensionSource:
    """A kernel for one instance, ready to compile into the cache: a unit for the extension of `calls_files`."""
    name = symbol(variant.kernel)
    text = render("kernel_unit.c.j2", i=instance, kernel=name)
    unit = unit_text(name, name, [variant])
    return ExtensionSource(name, "", text, {f"{name}.c": unit, **included_headers([text, unit], [f"{name}.c"])})


def extension_source(name: str, variants: Sequence[Variant], instances: Sequence[Instance]) -> ExtensionSource:
    """An extension of these kernels in one text, ready to compile into the cache."""
    unit = unit_text(name, name, variants)
    main = _main_text(name, {name: [symbol(v.kernel) for v in variants]}, instances, instances)
    headers = {f"{name}.c": unit, **included_headers([unit, main], [f"{name}.c"])}
    return ExtensionSource(name, _declarations(), main, headers)


def _main_text(
    title: str, symbols: Mapping[str, Sequence[str]], instances: Sequence[Instance], inlined: Sequence[Instance]
) -> str:
    return render(
        "kernels.c.j2",
        title=title,
        modules=symbols,
        count=sum(map(len, symbols.values())),
        instances=instances,
        inlined=inlined,
    )
