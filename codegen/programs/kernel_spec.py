"""Kernels that programs are made of: declared by formula and kinds, traced and printed as they were written."""

from __future__ import annotations

import tomllib
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from functools import cache
from importlib import resources
from typing import TYPE_CHECKING

from ..algebra import Algebra
from ..catalogue import algebra_from_data
from ..errors import TraceError
from ..kinds import Kind, numbers, scalar_argument
from . import kept

if TYPE_CHECKING:
    from ..trace import Formula, Kernel


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
class Declared:
    """A kernel that a program needs: a formula, the kinds of its arguments by name, and its algebra.

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
        """All of it in words."""
        return kept.key_of(self.formula, self.kinds, self.name, self.algebra)


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
def traced(declared: Declared) -> Kernel:
    """The kernel of a declaration, traced once in a process."""
    from ..trace import trace

    kinds = [_kind(declared.algebra, k) for k in declared.kinds]
    return trace(declared.formula, kinds, declared.name, algebra=stock_algebra(declared.algebra))


_anew: ContextVar[bool] = ContextVar("anew", default=False)


@contextmanager
def printed_anew() -> Iterator[None]:
    """A context in which kernels are made from their formulas, whatever is kept of them."""
    token = _anew.set(True)
    try:
        yield
    finally:
        _anew.reset(token)


def printed(declared: Declared) -> dict[str, str]:
    """C functions of a declaration's kernel and of those that it calls, callees first, by symbol."""
    return _printed(declared) if _anew.get() else _found_or_printed(declared)


@cache
def _found_or_printed(declared: Declared) -> dict[str, str]:
    group = kept.group_of(declared.formula.__module__, declared.algebra)
    if group is None:
        return _printed(declared)
    texts = kept.find(group, declared.key)
    if texts is None:
        texts = _printed(declared)
        kept.keep(group, declared.key, texts)
    return texts


@cache
def _printed(declared: Declared) -> dict[str, str]:
    from ..simplify import staged
    from ..targets.c import c_function, symbol
    from ..templating import render

    kernel = traced(declared)
    return {symbol(k): render("c/kernel.h.j2", f=c_function(staged(k))) for k in _with_callees(kernel)}


def _with_callees(kernel: Kernel) -> list[Kernel]:
    return [*(k for callee in kernel.called for k in _with_callees(callee)), kernel]


def printed_together(declared: Iterable[Declared]) -> dict[str, str]:
    """C functions of several declarations, callees first, each once.

    Raises
    ------
    TraceError
        If two different kernels have one name.
    """
    texts: dict[str, str] = {}
    for each in dict.fromkeys(declared):
        for symbol, text in printed(each).items():
            if texts.setdefault(symbol, text) != text:
                raise TraceError(f"two different kernels are called {each.name!r}; give one another name (named=...).")
    return texts
