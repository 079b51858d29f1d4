"""The C sources of an extension module: kernels in dependency order, for a list of instances."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from ..build import ExtensionSource
from ..errors import TraceError
from ..simplify import chosen_form
from ..templating import render, template_text
from ..trace import Kernel
from .c import c_function, symbol
from .instances import BASELINE, PORTABLE, SCALAR, WIDE, Instance

__all__ = [
    "BASELINE",
    "PORTABLE",
    "SCALAR",
    "WIDE",
    "Instance",
    "extension_source",
    "in_dependency_order",
    "kernel_files",
]


def _same(first: Kernel, second: Kernel) -> bool:
    """Whether two kernels are one, perhaps traced twice: the same formula on the same kinds."""
    if first is second:
        return True
    kinds = [[(i.name, i.kind) for i in k.inputs] for k in (first, second)]
    return first.formula is second.formula and kinds[0] == kinds[1]


def in_dependency_order(kernels: Iterable[Kernel]) -> list[Kernel]:
    """Kernels and those that they call, callees first, each once.

    Raises
    ------
    TraceError
        If two different kernels have one name.
    """
    order: dict[str, Kernel] = {}

    def visit(kernel: Kernel) -> None:
        known = order.get(symbol(kernel))
        if known is not None and not _same(known, kernel):
            raise TraceError(f"two different kernels are called {kernel.name!r}; give one another name (name=...).")
        if known is None:
            for callee in kernel.called:
                visit(callee)
            order[symbol(kernel)] = kernel

    for kernel in kernels:
        visit(kernel)
    return list(order.values())


def kernel_files(title: str, kernels: Sequence[Kernel], instances: Sequence[Instance] = PORTABLE) -> dict[str, str]:
    """Generated files of an extension of kernels: kernels.c, kernels.h, batch.h, kernels.cdef."""
    functions = [c_function(chosen_form(k)) for k in in_dependency_order(kernels)]
    batched = [symbol(k) for k in kernels]
    values = {
        "title": title,
        "functions": functions,
        "batched": batched,
        "count": len(batched),
        "prefix": "bs",
        "instances": instances,
        "elementary": any(f.elementary for f in functions),
        "statuses": any(p.is_status for f in functions for p in f.outputs),
    }
    return {
        "kernels.c": render("c/kernels.c.j2", **values),
        "kernels.h": render("c/kernels.h.j2", **values),
        "batch.h": render("c/batch.h.j2", **values),
        "kernels.cdef": template_text("c/kernels.cdef"),
    }


#: Headers of templates/c that every extension of kernels includes; elementary.h comes with the functions in it.
HEADERS = ("platform.h", "instance.h", "instance_end.h", "rows.h")


def extension_source(name: str, kernels: Sequence[Kernel], instances: Sequence[Instance]) -> ExtensionSource:
    """The same, ready to compile into the cache."""
    files = kernel_files(name, kernels, instances)
    used = [*HEADERS, "elementary.h"] if '"elementary.h"' in files["kernels.c"] else HEADERS
    headers = {h: template_text(f"c/{h}") for h in used}
    headers.update({"kernels.h": files["kernels.h"], "batch.h": files["batch.h"]})
    return ExtensionSource(name, files["kernels.cdef"], files["kernels.c"], headers)
