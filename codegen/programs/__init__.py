"""Programs: what a scene, a model pair or a mechanism needs, as a list of kernels and the driver around it.

A program is text. It depends on what there is (which kinds of surface, which features), never on numbers:
those are arguments of the compiled driver, so that an animation compiles once.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from ..build import ExtensionSource
from ..templating import included_headers, render, template_text
from ..units import Unit
from . import kept
from .kernels import Declared, cga3d, printed, printed_together, stock_algebra, traced

__all__ = ["Declared", "Part", "Program", "cga3d", "program", "stock_algebra", "traced"]


@dataclass(frozen=True)
class Part:
    """A part of a program that is compiled by itself, and kept for other programs.

    Parameters
    ----------
    name : str
        Identifier.
    declared : tuple of Declared
        Its kernels: what it includes as ``kernels.h``.
    source : str
        The C text.
    options : tuple of str
        Of the compiler.
    """

    name: str
    declared: tuple[Declared, ...]
    source: str
    options: tuple[str, ...] = ()

    def unit(self) -> Unit:
        """The same, ready to compile into the cache."""
        kernels = _kernels_header(printed_together(self.declared))
        headers = {"kernels.h": kernels, **included_headers([self.source], ["kernels.h"])}
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
    headers : tuple of str
        Files of ``templates/c`` that they include.
    options : tuple of str
        Of the compiler, after those of all programs.
    parts : tuple of Part
        What is compiled by itself where a compiler runs on demand, those that take longest first; the driver's text
        leaves it out under `PARTS_OPTION`.
    driver : tuple of Declared
        The kernels of the rest.
    """

    name: str
    kernels: tuple[str, ...]
    files: Mapping[str, str]
    headers: tuple[str, ...]
    options: tuple[str, ...] = ()
    parts: tuple[Part, ...] = ()
    driver: tuple[Declared, ...] = ()

    def index(self) -> str:
        """Which kernels its files hold, for others to take their text from: see kept.py."""
        found = {}
        for each in (*self.driver, *(d for part in self.parts for d in part.declared)):
            group = kept.group_of(each.formula.__module__, each.algebra)
            if group is not None:
                found[group, each.key] = tuple(printed(each))
        return kept.index(self.files["kernels.h"], found)

    @property
    def source(self) -> str:
        """The generated text and every line that it includes, for reading."""
        texts = {**self.files, **{name: template_text(f"c/{name}") for name in self.headers}}
        return "\n".join(f"/* ===== {name} ===== */\n{text}" for name, text in texts.items())

    def extension(self) -> ExtensionSource:
        """The same, ready to compile into the cache."""
        headers = {name: template_text(f"c/{name}") for name in self.headers}
        headers["kernels.h"] = self.files["kernels.h"]
        options = self.options
        if self.parts:
            headers["kernels.h"] = _kernels_header(printed_together(self.driver))
            options = (*options, PARTS_OPTION)
        units = tuple(part.unit() for part in self.parts)
        return ExtensionSource(self.name, self.files["kernels.cdef"], self.files["kernels.c"], headers, options, units)


#: Leaves out of a driver what is compiled by itself.
PARTS_OPTION = "-DBS_SCENE_APART=1"


def _kernels_header(texts: Mapping[str, str]) -> str:
    return render("c/kernels.h.j2", functions=[]) + "".join(texts.values())


def program(
    name: str,
    declared: Sequence[Declared],
    template: str,
    cdef: str,
    headers: Sequence[str],
    values: Mapping[str, object],
    options: tuple[str, ...] = (),
    parts: tuple[Part, ...] = (),
    declarations: str = "",
) -> Program:
    """Print the kernels as their formulas were written (no search of forms) and fill the driver's template.

    ``declared`` are those of the driver; those of parts come after them. ``declarations`` are for cffi alone.
    """
    texts = printed_together([*declared, *(d for part in parts for d in part.declared)])
    files = {
        "kernels.c": render(template, **values),
        "kernels.h": _kernels_header(texts),
        "kernels.cdef": template_text(cdef) + declarations,
    }
    return Program(name, tuple(texts), files, tuple(headers), options, parts, tuple(declared))
