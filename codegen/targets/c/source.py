"""C texts of an extension module, as printers and programs hand them over to the build stage."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field

from ...errors import SpecError

_HEADER = re.compile(r"\w[\w.-]*")


@dataclass(frozen=True)
class Unit:
    """One C text.

    Parameters
    ----------
    name
        An identifier, the beginning of its files' names.
    source
        The text.
    headers
        File name -> text of what `source` includes.
    options
        Of the compiler, after those of all texts.
    declarations
        If given, cffi's wrapper around them follows the source: the unit that makes a module of an extension.
    kept
        Whether other extensions may have it too.
    """

    name: str
    source: str
    headers: Mapping[str, str] = field(default_factory=dict)
    options: tuple[str, ...] = ()
    declarations: str = ""
    kept: bool = True

    def __post_init__(self) -> None:
        if not (self.name.isidentifier() and self.name.isascii()):
            raise SpecError(f"{self.name!r} cannot name an extension", remedy="Use letters, digits and _.")
        for header in self.headers:
            if not _HEADER.fullmatch(header):
                raise SpecError(f"{header!r} cannot name a header", where=f"extension {self.name}")

    def parts(self) -> list[object]:
        """Everything that its text depends on, for keys."""
        return [self.name, self.source, sorted(self.headers.items()), self.options, self.declarations]


@dataclass(frozen=True)
class ExtensionSource:
    """Everything that a compiled module is made of.

    Parameters
    ----------
    name
        An identifier, the beginning of the module's name.
    cdef
        Declarations, as cffi reads them, of functions with external linkage.
    source
        The C text.
    headers
        File name -> text of what `source` includes.
    options
        Options of the compiler after `C_FLAGS`, such as `-march=native`.
    units
        What `source` is linked to, those that take longest first. An extension with units has `cdef` compiled as C,
        too, behind the standard headers of sizes.
    """

    name: str
    cdef: str
    source: str
    headers: Mapping[str, str] = field(default_factory=dict)
    options: tuple[str, ...] = ()
    units: tuple[Unit, ...] = ()

    def __post_init__(self) -> None:
        self.main()

    def main(self) -> Unit:
        """The source as a unit. Raises SpecError where a name cannot be one."""
        return Unit(self.name, self.source, self.headers, self.options, kept=False)
