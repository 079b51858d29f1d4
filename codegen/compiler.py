"""The stages of the compiler: one function each, in the order in which a kernel passes them.

1. **Trace**: `trace_kernel`, package `trace` over `ir`, `algebra` and `rings`.

   Input: a formula (a Python function in GA notation) and the kinds of its arguments.
   Output: a `Kernel`, the expression graph of the formula with proved kinds of results.

2. **Optimise**: `optimise_kernel`, or `as_written` where nothing is searched; package `optimise`.

   Input: a kernel, and the record of an earlier selection where there is one.
   Output: a `Variant`, the nodes that are printed: proved equal to the formula, and as accurate.

3. **Print**: `print_function`, `print_unit`, `print_source`; package `targets` and the templates.

   Input: variants. Nothing is searched, and the text does not depend on the machine.
   Output: the text of one function, of a translation unit, or of a module for one target.

4. **Build**: `build_kernel`, package `build`.

   Input: a variant, and a precision.
   Output: the kernel compiled for this machine, from the cache where it was compiled before.

5. **Execute**: `bind_library`, `bind_numba`, `bind_cuda`; package `execute`.

   Input: a library, or a text that is compiled when it is first called.
   Output: a function from arrays to arrays.

`api` runs all stages when a declared kernel is first called, `generator` the first three for all kernels of a spec, and
`programs` the first three for the kernels of a driver, as written. A stage imports its package when it is first run:
declaring a kernel loads neither SymPy nor a compiler.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, MutableMapping, Sequence
from contextlib import suppress
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from .algebra.algebra import Algebra, Kind
from .errors import InputError, SpecError
from .execute.bound_kernels import AddedKernel, BoundKernel, Library, LoopError
from .trace.declared_formula import DeclaredFormula
from .trace.kernel import Formula, Kernel, Output, interface
from .trace.trace import trace

if TYPE_CHECKING:
    from .execute.cuda_driver import CudaKernel, Device
    from .execute.numba_jit import NumbaKernel
    from .optimise.factor.record import Record
    from .optimise.variants import Variant
    from .targets.c.instances import Instance

#: A kernel as a function of arrays, and what it returns.
Compiled = tuple[BoundKernel, tuple[Output, ...]]
#: Languages that kernels are printed in.
LANGUAGES = ("c", "numba", "cuda")


# -- 1. trace ----------------------------------------------------------------------------------------------


def trace_kernel(
    formula: Formula,
    kinds: Sequence[Kind],
    name: str | None = None,
    returns: Kind | None = None,
    algebra: Algebra | None = None,
    arguments: Sequence[str] | None = None,
    layouts: Sequence[Kind] = (),
) -> Kernel:
    """Run a formula on symbolic members of kinds; see `trace.trace`."""
    return trace(formula, kinds, name, returns, algebra, arguments=arguments, layouts=layouts)


# -- 2. optimise -------------------------------------------------------------------------------------------


def optimise_kernel(
    kernel: Kernel,
    record: Record | None = None,
    quick: bool = False,
    selected: MutableMapping[Kernel, Variant] | None = None,
) -> Variant:
    """Select the variant of a kernel that is printed; see `optimise.variants.select_variant`."""
    from .optimise.variants import select_variant

    return select_variant(kernel, record, quick, selected)


def optimise_quickly(kernel: Kernel) -> Variant:
    """`optimise_kernel` for who waits for the kernel: a quick search, or none where its form is in the cache."""
    from .build.kernel_cache import selected_form
    from .optimise.variants import select_variant

    selected: dict[Kernel, Variant] = {}
    found: list[Variant] = []

    def select() -> Mapping[str, Any]:
        found.append(select_variant(kernel, quick=True, selected=selected))
        return found[0].record()

    record = selected_form(kernel.fingerprint, select)
    if not found:
        with suppress(SpecError):  # of a kernel with the same digest
            return select_variant(kernel, record, selected=selected)
        select()
    return found[0]


def as_written(kernel: Kernel) -> Variant:
    """The kernel as its formula was written: no search."""
    from .optimise.variants import as_written as written

    return written(kernel)


# -- 3. print ----------------------------------------------------------------------------------------------


def print_function(variant: Variant) -> str:
    """C text of one kernel's function, without those that it calls."""
    from .targets.c.printer import c_function
    from .targets.templates import render

    return render("kernel.h.j2", f=c_function(variant))


def print_unit(title: str, module: str, variants: Sequence[Variant]) -> str:
    """C text of a translation unit: the kernels of one module, and those that they call, for any instance."""
    from .targets.c.extension import unit_text

    return unit_text(title, module, variants)


def print_source(variants: Sequence[Variant], language: str = "c", title: str = "") -> str:
    """Text of kernels, and of those that they call, in one of `LANGUAGES`.

    Raises
    ------
    InputError
        If there is no such language.
    """
    if language == "c":
        from .targets.c.extension import bodies_text

        return bodies_text(variants)
    if language == "numba":
        from .targets.numba.printer import numba_source

        return numba_source(variants, title)
    if language == "cuda":
        from .targets.cuda.printer import cuda_source, self_contained

        return self_contained(cuda_source(variants, title))
    raise InputError(f"there is no target {language!r}; choose c, numba or cuda.")


# -- 4. build ----------------------------------------------------------------------------------------------


def build_kernel(variant: Variant, precision: str = "f64") -> AddedKernel:
    """Compile a kernel for this machine, through the cache, as a unit of the extension that calls such kernels.

    Parameters
    ----------
    variant : Variant
    precision : {"f64", "f32"}
    """
    from .build.cpu_features import best_instances
    from .targets.c.instances import BASELINE

    (best,), plain = best_instances(precision), next(i for i in BASELINE if i.tag.startswith(precision))
    try:
        return _add_kernel(variant, best)
    except LoopError:  # what is compiled asks the processor in its own way, and may know less of it than NumPy
        if best == plain:
            raise
        return _add_kernel(variant, plain)


def _add_kernel(variant: Variant, instance: Instance) -> AddedKernel:
    from .build.calls import calls_extension
    from .build.extension import load_unit, unit_stem
    from .build.flags import UNIT_FLAGS
    from .targets.c.extension import kernel_source

    source = kernel_source(variant, instance)
    if "elementary.h" not in source.headers:  # sines and series gain by more than these options
        source = replace(source, options=UNIT_FLAGS)
    return AddedKernel(calls_extension(), source.name, load_unit(source), unit_stem(source))


# -- 5. execute --------------------------------------------------------------------------------------------


def bind_library(library: Library | AddedKernel, kernel: Kernel, symbol: str) -> BoundKernel:
    """A kernel of a compiled library, as a function of arrays."""
    return BoundKernel(library, symbol, *interface(kernel))


def bind_numba(variant: Variant, compiled: bool = True) -> NumbaKernel:
    """A kernel as a function of arrays, from its numba text.

    Parameters
    ----------
    variant : Variant
    compiled : bool
        False: run the text as it is, on whole columns; right without numba, and slower.

    Raises
    ------
    MissingExtraError
        If ``compiled`` and numba is not installed.
    """
    from .execute.numba_jit import NumbaKernel, NumbaLibrary
    from .targets.c.printer import symbol

    library = NumbaLibrary(print_source([variant], "numba"), compiled)
    return NumbaKernel(library, symbol(variant.kernel), *interface(variant.kernel))


def bind_cuda(variant: Variant, device: Device | None = None) -> CudaKernel:
    """A kernel as a function of arrays, compiled for a GPU of this machine.

    Parameters
    ----------
    variant : Variant
    device : Device, optional
        Default: the first GPU.

    Raises
    ------
    MissingExtraError
        If NVRTC is not installed.
    DeviceError
        If there is no GPU.
    """
    from .execute.cuda_driver import CudaKernel, CudaModule
    from .execute.cuda_driver import Device as FirstDevice
    from .execute.nvrtc import compile_source, device_arch
    from .targets.c.printer import symbol
    from .targets.cuda.printer import cuda_source

    device = device or FirstDevice()
    image = compile_source(cuda_source([variant]), device_arch(device.capability)).image
    return CudaKernel(CudaModule(device, image), symbol(variant.kernel), *interface(variant.kernel))


# -- all of them -------------------------------------------------------------------------------------------


def compile_kernel(variant: Variant, precision: str = "f64") -> BoundKernel:
    """Print, build and bind one kernel in C."""
    library = build_kernel(variant, precision)
    return bind_library(library, variant.kernel, library.symbol)


def compile_declared(declared: DeclaredFormula, select: Callable[[], Variant], precision: str) -> Compiled:
    """A declared kernel in C, with its outputs: as another process left it in the cache, else `compile_kernel`.

    Parameters
    ----------
    declared : DeclaredFormula
    select : callable
        Traces it and selects the variant that is printed: not called where the kernel is in the cache.
    precision : {"f64", "f32"}
    """
    from .build.built_kernels import Place
    from .build.calls import calls_extension
    from .build.extension import unit_in_cache

    place = Place(declared, precision)
    found = place.read()
    unit = found and unit_in_cache(found.unit)
    if found and unit:
        with suppress(LoopError):
            added = AddedKernel(calls_extension(), found.symbol, unit, found.unit)
            return BoundKernel(added, found.symbol, *interface(found)), found.outputs
    variant = select()
    library = build_kernel(variant, precision)
    place.write(library.symbol, library.unit, variant.kernel.outputs)
    return bind_library(library, variant.kernel, library.symbol), variant.kernel.outputs


def bind_kernel(variant: Variant, target: str, precision: str = "f64") -> Any:
    """A kernel as a function of arrays on "c", "numba", "cuda", or "numpy" (the numba text on columns).

    Raises
    ------
    InputError
        If there is no such target.
    """
    if target == "c":
        return compile_kernel(variant, precision)
    if target in ("numba", "numpy"):
        return bind_numba(variant, compiled=target == "numba")
    if target == "cuda":
        return bind_cuda(variant)
    raise InputError(f"there is no target {target!r}; choose c, numba, cuda or numpy.")
