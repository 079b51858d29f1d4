"""Programs: the kernels of a scene, a model pair or a mechanism, and the driver around them.

A program is text. It depends on features (kinds of surface, loads, constraints), never on numbers:
those are arguments of the compiled driver, so that an animation compiles once.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from ..build import kernel_cache
from ..targets.c.source import ExtensionSource, Unit
from ..targets.templates import included_headers, render, template_text
from .kernel_spec import KernelSpec, cga3d, print_spec, print_specs, stock_algebra, trace_spec

__all__ = ["KernelSpec", "Part", "Program", "cga3d", "kernels_header", "program", "stock_algebra", "trace_spec"]


@dataclass(frozen=True)
class Part:
    """A translation unit of a program, reused by other programs.

    Parameters
    ----------
    name : str
        Identifier.
    specs : tuple of KernelSpec
        Its kernels: what it includes as ``kernels.h``.
    source : str
        The C text.
    options : tuple of str
        Of the compiler.
    headers : mapping of str to str
        Printed texts that it includes, besides its kernels.
    """

    name: str
    specs: tuple[KernelSpec, ...]
    source: str
    options: tuple[str, ...] = ()
    headers: Mapping[str, str] = field(default_factory=dict)

    def unit(self) -> Unit:
        """The same, ready to compile into the cache."""
        kernels = kernels_header(print_specs(self.specs))
        printed = {"kernels.h": kernels, **self.headers}
        headers = {**printed, **included_headers([self.source], printed)}
        return Unit(self.name, self.source, headers, self.options)


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
        Generated files of all of it in one text: kernels.c, kernels.h, kernels.cdef.
    options : tuple of str
        Of the compiler, after those of all programs.
    parts : tuple of Part
        What is compiled by itself where a compiler runs on demand, those that take longest first; the driver's text
        leaves it out under `PARTS_OPTION`.
    driver : tuple of KernelSpec
        The kernels of the rest.
    algorithms : tuple of str
        Files with the algorithms that it is made of, from the package's folder.
    """

    name: str
    kernels: tuple[str, ...]
    files: Mapping[str, str]
    options: tuple[str, ...] = ()
    parts: tuple[Part, ...] = ()
    driver: tuple[KernelSpec, ...] = ()
    algorithms: tuple[str, ...] = ()

    def formulas(self) -> set[str]:
        """The formulas of its kernels, as ``module.function``."""
        return {f"{d.formula.__module__.rpartition('.')[2]}.{d.formula.__name__}" for d in self.specs}

    @property
    def specs(self) -> tuple[KernelSpec, ...]:
        """All kernels' declarations."""
        return (*self.driver, *(d for part in self.parts for d in part.specs))

    def index(self) -> str:
        """JSON index of the kernels in the generated files; the kernel cache reads their text through it."""
        found = {}
        for each in self.specs:
            group = kernel_cache.group_of(each.formula.__module__, each.algebra)
            if group is not None:
                found[group, each.key] = tuple(print_spec(each))
        return kernel_cache.index(self.files["kernels.h"], found)

    @property
    def source(self) -> str:
        """The generated text and every line that it includes, for reading."""
        texts = {**self.files, **self._headers()}
        return "\n".join(f"/* ===== {name} ===== */\n{text}" for name, text in texts.items())

    def _headers(self) -> dict[str, str]:
        return included_headers([self.files["kernels.c"]], self.files)

    def extension(self) -> ExtensionSource:
        """The same, ready to compile into the cache."""
        headers = {**self._headers(), **{name: text for name, text in self.files.items() if name.endswith(".h")}}
        options = self.options
        if self.parts:
            headers["kernels.h"] = kernels_header(print_specs(self.driver))
            options = (*options, PARTS_OPTION)
        units = tuple(part.unit() for part in self.parts)
        return ExtensionSource(self.name, self.files["kernels.cdef"], self.files["kernels.c"], headers, options, units)


#: Leaves out of a driver what is compiled by itself.
PARTS_OPTION = "-DBS_SCENE_APART=1"


def kernels_header(texts: Mapping[str, str]) -> str:
    """Text of a header of printed kernels."""
    return render("kernels.h.j2", functions=[]) + "".join(texts.values())


def program(
    name: str,
    specs: Sequence[KernelSpec],
    template: str,
    cdef: str,
    values: Mapping[str, object],
    options: tuple[str, ...] = (),
    parts: tuple[Part, ...] = (),
    declarations: str = "",
    headers: Mapping[str, str] | None = None,
) -> Program:
    """Print the kernels as their formulas were written (no search of forms) and fill the driver's template.

    ``specs`` are those of the driver; those of parts come after them. ``cdef`` is a file of declarations, or empty;
    ``declarations`` are for cffi alone. ``headers``
    are texts that the driver includes: its algorithms.
    """
    texts = print_specs([*specs, *(d for part in parts for d in part.specs)])
    files = {
        "kernels.c": render(template, **values),
        "kernels.h": kernels_header(texts),
        **(headers or {}),
        "kernels.cdef": (template_text(cdef) if cdef else "const char *bs_source_hash(void);\n") + declarations,
    }
    return Program(name, tuple(texts), files, options, parts, tuple(specs))


#: Where an algorithm's text is in its C program.
FUNCTIONS = "algorithm_functions.h"


def extension_of(name: str, files: Mapping[str, str]) -> ExtensionSource:
    """The texts of `algorithms.algorithm_files`, ready to compile."""
    headers = {**included_headers([files["kernels.c"]], [FUNCTIONS]), FUNCTIONS: files[FUNCTIONS]}
    return ExtensionSource(name, files["kernels.cdef"], files["kernels.c"], headers)
