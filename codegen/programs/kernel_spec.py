"""Kernels of programs: specified by formula and kinds, traced and printed as their formulas are written."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from functools import cache
from importlib import resources
from typing import TYPE_CHECKING, Any

from .. import compiler
from ..algebra.algebra import Algebra, Kind, numbers, scalar_argument
from ..algebra.blades import shortened_identifier
from ..algebra.loader import algebra_from_data
from ..build import kernel_cache
from ..errors import TraceError
from ..ir.loops.nodes import KernelSignature

if TYPE_CHECKING:
    from ..optimise.variants import Variant
    from ..trace.kernel import Formula, Kernel, Output


@cache
def stock_algebra(name: str) -> Algebra:
    """A stock algebra, from its spec alone: nothing generated is needed to generate programs."""
    package = __package__.rpartition(".")[0]
    text = resources.files(package).joinpath(f"specs/{name}.toml").read_text(encoding="utf-8")
    return algebra_from_data(tomllib.loads(text))


def cga3d() -> Algebra:
    """The algebra that the geometry of most programs is written in."""
    return stock_algebra("cga3d")


@dataclass(frozen=True)
class KernelSpec:
    """Specification of a kernel of a program: a formula, the kinds of its arguments by name, and its algebra.

    A formula on several kinds is several kernels of one program: each is given a name of its own. ``origin``: of a
    kernel of tangents the name of the one that it is made from, and the arguments that vary.
    """

    formula: Formula
    kinds: tuple[str, ...]
    named: str = ""
    algebra: str = "cga3d"
    origin: tuple[str, tuple[str, ...]] | None = None

    @property
    def name(self) -> str:
        """Name of the kernel: the given one, else that of its formula."""
        return self.named or self.formula.__name__

    @property
    def key(self) -> str:
        """The specification as text."""
        return kernel_cache.key_of(self.formula, self.kinds, self.name, self.algebra)

    # -- in algorithms -------------------------------------------------------------------------------------------------

    is_callable_in_algorithms = True

    @property
    def kernel_signature(self) -> KernelSignature:
        """What algorithms call, as the printed function has it: nothing is traced where that is in the kernel cache."""
        return _printed_signature(self)

    @property
    def outputs(self) -> tuple[Output, ...]:
        """What it returns."""
        return trace_spec(self).outputs

    def tangent_signature(self, varying: tuple[str, ...]) -> KernelSignature:
        """What derivatives of algorithms call: results and their tangents, from the inputs and directions of some."""
        return self.along(varying).kernel_signature

    def along(self, varying: tuple[str, ...]) -> KernelSpec:
        """The kernel of results and tangents where these arguments vary."""
        return _along(self, varying)

    @property
    def variant(self) -> Variant:
        """What is printed: the formula as written."""
        return compiler.as_written(trace_spec(self))

    def __call__(self, *arguments: Any) -> Any:
        """The formula on numbers, where an algorithm runs as Python."""
        return trace_spec(self).on_numbers_in_use(arguments)


@cache
def _along(spec: KernelSpec, varying: tuple[str, ...]) -> KernelSpec:
    from ..trace.derivatives import tangent_formula
    from ..trace.kernel import argument_names

    names = argument_names(spec.formula)
    formula = tangent_formula(spec.formula, spec.formula.__module__, [n for n in names if n not in varying])
    pairs = zip(names, spec.kinds, strict=True)
    directions = [_direction_kind(spec.algebra, kind) for name, kind in pairs if name in varying]
    name = shortened_identifier("_".join([spec.name, "along", *varying]))
    return KernelSpec(formula, (*spec.kinds, *directions), name, spec.algebra, (spec.name, varying))


def _direction_kind(algebra: str, name: str) -> str:
    """Kind of the directions in which an argument of a kind varies."""
    if name == "unit":
        return "position"
    is_free = name in ("position", "number") or name.startswith(("numbers", "layout "))
    return name if is_free or not _kind(algebra, name).constraints else f"layout {name}"


@cache
def _kind(algebra_name: str, name: str) -> Kind:
    """Kinds of arguments of programs: those of the algebra, and Euclidean vectors and rows of numbers."""
    algebra = stock_algebra(algebra_name)
    if name in ("position", "unit"):
        euclidean = tuple(algebra.parse_blade(blade)[0] for blade in ("e1", "e2", "e3"))
        return _euclidean(algebra, name, euclidean)
    if name == "number":
        return scalar_argument(algebra)
    if name.startswith("numbers"):
        return numbers(algebra, int(name.removeprefix("numbers")))
    if name.startswith("layout "):
        return algebra.kind(name.removeprefix("layout ")).layout
    return algebra.kind(name)


def _euclidean(algebra: Algebra, name: str, blades: tuple[int, ...]) -> Kind:
    """A position, about which nothing is known, or a unit vector."""
    if name == "position":
        return Kind(algebra, name, blades)
    return Kind(algebra, name, blades, ("x * x - 1",), "unit(e1, e2, e3)")


@cache
def trace_spec(spec: KernelSpec) -> Kernel:
    """The kernel of a specification, traced once in a process."""
    kinds = [_kind(spec.algebra, k) for k in spec.kinds]
    return compiler.trace_kernel(spec.formula, kinds, spec.name, algebra=stock_algebra(spec.algebra))


_without_cache: ContextVar[bool] = ContextVar("without_cache", default=False)


@cache
def _printed_signature(spec: KernelSpec) -> KernelSignature:
    from ..trace.kernel import argument_names, symbol_of

    symbol = symbol_of(stock_algebra(spec.algebra), spec.name)
    text = print_spec(spec)[symbol]
    head = text[text.index("FN(") :].split("\n", 1)[0]
    outputs = tuple((name, int(size)) for name, size in re.findall(r"BS_APART\(V, (\w+), (\d+)\)", head))
    if not outputs:
        return trace_spec(spec).signature(spec)
    sizes = [_kind(spec.algebra, kind).size for kind in spec.kinds]
    return KernelSignature(symbol, outputs, tuple(zip(argument_names(spec.formula), sizes, strict=True)), spec)


@contextmanager
def without_kernel_cache() -> Iterator[None]:
    """A context in which kernels are printed from their formulas, and the kernel cache is not read."""
    token = _without_cache.set(True)
    try:
        yield
    finally:
        _without_cache.reset(token)


def is_without_cache() -> bool:
    """Whether everything is printed anew: see `without_kernel_cache`."""
    return _without_cache.get()


def print_spec(spec: KernelSpec) -> dict[str, str]:
    """C functions of a specification's kernel and of those that it calls, callees first, by symbol."""
    return _print(spec) if is_without_cache() else _read_or_print(spec)


@cache
def _read_or_print(spec: KernelSpec) -> dict[str, str]:
    group = kernel_cache.group_of(spec.formula.__module__, spec.algebra)
    if group is None:
        return _print(spec)
    texts = kernel_cache.lookup(group, spec.key)
    if texts is None:
        texts = _print(spec)
        kernel_cache.store(group, spec.key, texts)
    return texts


@cache
def _print(spec: KernelSpec) -> dict[str, str]:
    from ..targets.c.printer import symbol

    texts = {}
    for variant in _with_callees(compiler.as_written(trace_spec(spec))):
        texts[symbol(variant.kernel)] = compiler.print_function(variant)
        variant.kernel.release()
    return texts


def _with_callees(variant: Variant) -> list[Variant]:
    return [*(v for callee in variant.callees.values() for v in _with_callees(callee)), variant]


def print_specs(specs: Iterable[KernelSpec]) -> dict[str, str]:
    """C functions of several specifications, callees first, each once.

    Raises
    ------
    TraceError
        If two different kernels have one name.
    """
    texts: dict[str, str] = {}
    for spec in dict.fromkeys(specs):
        for symbol, text in print_spec(spec).items():
            if texts.setdefault(symbol, text) != text:
                raise TraceError(f"two different kernels are called {spec.name!r}; give one another name (named=...).")
    return texts
