"""Programs: what a scene, a model pair or a mechanism needs, as a list of kernels and the driver around it.

A program is text. It depends on what there is (which kinds of surface, which features), never on numbers:
those are arguments of the compiled driver, so that an animation compiles once.
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib import resources

from ..algebra import Algebra
from ..build import ExtensionSource
from ..catalogue import algebra_from_data
from ..kinds import Kind, numbers, scalar_argument
from ..simplify import staged
from ..targets.c import c_function, symbol
from ..targets.extension import in_dependency_order
from ..templating import render, template_text
from ..trace import Formula, Kernel, trace


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
    return algebra.kind(name)


def _euclidean(algebra: Algebra, name: str, blades: tuple[int, ...]) -> Kind:
    """A position, about which nothing is known, or a unit vector."""
    if name == "position":
        return Kind(algebra, name, blades)
    return Kind(algebra, name, blades, ("x * x - 1",), "unit(e1, e2, e3)")


@cache
def traced(declared: Declared) -> Kernel:
    """The kernel of a declaration, traced once in a process."""
    kinds = [_kind(declared.algebra, k) for k in declared.kinds]
    return trace(declared.formula, kinds, declared.name, algebra=stock_algebra(declared.algebra))


@dataclass(frozen=True, eq=False)
class Program:
    """Kernels and a driver, ready to compile or to be written into a generated folder.

    Attributes
    ----------
    name : str
        Identifier.
    kernels : tuple of str
        Names of the kernels that it holds, in the order of the source.
    files : mapping of str to str
        Generated files: kernels.c, kernels.h, kernels.cdef.
    headers : tuple of str
        Files of ``templates/c`` that they include.
    options : tuple of str
        Of the compiler, after those of all programs.
    """

    name: str
    kernels: tuple[str, ...]
    files: Mapping[str, str]
    headers: tuple[str, ...]
    options: tuple[str, ...] = ()

    @property
    def source(self) -> str:
        """The generated text and every line that it includes, for reading."""
        texts = {**self.files, **{name: template_text(f"c/{name}") for name in self.headers}}
        return "\n".join(f"/* ===== {name} ===== */\n{text}" for name, text in texts.items())

    def extension(self) -> ExtensionSource:
        """The same, ready to compile into the cache."""
        headers = {name: template_text(f"c/{name}") for name in self.headers}
        headers["kernels.h"] = self.files["kernels.h"]
        return ExtensionSource(self.name, self.files["kernels.cdef"], self.files["kernels.c"], headers, self.options)


def program(
    name: str,
    declared: Sequence[Declared],
    template: str,
    cdef: str,
    headers: Sequence[str],
    values: Mapping[str, object],
    options: tuple[str, ...] = (),
) -> Program:
    """Print the kernels as their formulas were written (no search of forms) and fill the driver's template."""
    kernels = in_dependency_order(traced(d) for d in dict.fromkeys(declared))
    functions = [c_function(staged(k)) for k in kernels]
    files = {
        "kernels.c": render(template, functions=functions, **values),
        "kernels.h": render("c/kernels.h.j2", functions=functions),
        "kernels.cdef": template_text(cdef),
    }
    return Program(name, tuple(symbol(k) for k in kernels), files, tuple(headers), options)
