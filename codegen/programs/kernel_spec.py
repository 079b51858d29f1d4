"""Kernels of programs: specified by formula and kinds, traced and printed as their formulas are written."""

from __future__ import annotations

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
from ..algebra.loader import algebra_from_data
from ..build import kernel_cache
from ..errors import TraceError
from ..ir.loops.nodes import KernelSignature

if TYPE_CHECKING:
    from ..optimise.variants import Variant
    from ..trace.kernel import Formula, Kernel


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

    A formula on several kinds is several kernels of one program: each is given a name of its own.
    """

    formula: Formula
    kinds: tuple[str, ...]
    named: str = ""
    algebra: str = "cga3d"

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
        """What algorithms call."""
        return trace_spec(self).signature(self)

    @property
    def variant(self) -> Variant:
        """What is printed: the formula as written."""
        return compiler.as_written(trace_spec(self))

    def __call__(self, *arguments: Any) -> Any:
        """The formula on numbers, where an algorithm runs as Python."""
        return trace_spec(self).on_numbers_in_use(arguments)


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


@contextmanager
def without_kernel_cache() -> Iterator[None]:
    """A context in which kernels are printed from their formulas, and the kernel cache is not read."""
    token = _without_cache.set(True)
    try:
        yield
    finally:
        _without_cache.reset(token)


def print_spec(spec: KernelSpec) -> dict[str, str]:
    """C functions of a specification's kernel and of those that it calls, callees first, by symbol."""
    return _print(spec) if _without_cache.get() else _read_or_print(spec)


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
