"""Packages whose public names are imported when they are first used.

The stub `__init__.pyi` beside a package's `__init__.py` is the one list of its names: editors and type checkers read it
as it stands, and here it says where each name is. (The package lazy_loader does the same, but only for names that are
defined inside the package.)
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any


def lazy_names(package: str, file: str, more: tuple[str, ...] = ()) -> tuple[Callable[[str], Any], Callable[[], Any]]:
    """``__getattr__``, which knows ``__all__`` as well, and ``__dir__`` of a package; its stub is read at first use.

    Parameters
    ----------
    package, file : str
        Its ``__name__`` and ``__file__``.
    more : tuple of str
        Public names that the package finds by itself.
    """
    homes: dict[str, tuple[str, str]] = {}

    def names() -> list[str]:
        if not homes:
            homes.update(_imports(Path(file).with_suffix(".pyi").read_text(encoding="utf-8")))
        return [*sorted(homes), *more]

    def find(name: str) -> Any:
        if name == "__all__":
            value: Any = names()
        elif name not in names() or name not in homes:
            raise AttributeError(f"module {package!r} has no attribute {name!r}{_suggest(name, names())}")
        else:
            module, original = homes[name]
            home = import_module(module, package) if module.strip(".") else None
            if home is not None and hasattr(home, original):
                value = getattr(home, original)
            else:  # a module of the package, or of one below it
                value = import_module(f"{module}{original}" if home is None else f"{module}.{original}", package)
        setattr(sys.modules[package], name, value)
        return value

    return find, names


def _suggest(name: str, known: list[str]) -> str:
    """The nearest public name in brackets; names of protocols, which are asked for often, are not misspelt."""
    if name.startswith("_"):
        return ""
    from .errors import suggest

    return suggest(name, known)


def _imports(stub: str) -> dict[str, tuple[str, str]]:
    """Names that a stub imports by ``from module import name as alias``: module and name, by alias.

    By hand: to load `ast`, or to compile a pattern, takes longer than all the rest of importing the package.
    """
    found = {}
    module = ""
    for line in stub.splitlines():
        words = line.replace("(", " ").replace(")", " ").replace(",", " ").split()
        if words[:1] == ["from"]:
            module, words = words[1], words[3:]
        elif not line.startswith(" "):
            words = []  # an annotation, or the end of a list
        while words:
            name, alias = words[0], words[2] if words[1:2] == ["as"] else words[0]
            found[alias] = (module, name)
            words = words[3 if words[1:2] == ["as"] else 1 :]
    return found
