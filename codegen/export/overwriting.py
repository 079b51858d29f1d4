"""Files that are there already: the same export is written again, anything else is kept."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from ..errors import InputError

#: How the first sentence of an exported file ends, and the lines that say what it holds (`header.header_lines`).
_HEAD = re.compile(r"[^\n]*?\w+: \d+ functions? of geometric algebra, by bladesmith ")
_MARKS = re.compile(r"^[ /*!]+", re.MULTILINE)
_HELD = re.compile(r"^Source:(.*?)^Functions:(.*?)\.\n\n", re.MULTILINE | re.DOTALL)
_REMEDY = "Give this export another name (name=, --name), or overwrite the file (overwrite=True, --force)"


@dataclass(frozen=True)
class _Contents:
    """Source and functions that a file holds, as its first comment says; none for a file of definitions."""

    source: str
    functions: frozenset[str]


def check_overwritten(folder: Path, texts: Mapping[str, str]) -> None:
    """Raise where a file would be overwritten that is not this export's: other functions would be lost.

    Raises
    ------
    InputError
        If a file was not written by `export`, has another source, or functions that the new one has not.
    """
    for name, text in texts.items():
        path = folder / name
        if not path.is_file():  # not there, or a device
            continue
        old, new = path.read_text("utf-8", errors="replace"), _contents(text)
        held = _contents(old)
        if not old or held == new:
            continue
        if held is None or new is None:
            what = "exists, and is no file that bladesmith exported."
        elif held.source != new.source:
            what = f"exists, and holds another export: {_listed(held.functions)} of {held.source}."
        elif lost := held.functions - new.functions:
            what = f"exists, and holds functions that this export has not: {_listed(lost)}."
        else:
            continue
        raise InputError(what, where=str(path), remedy=_REMEDY)


def _listed(names: frozenset[str]) -> str:
    shown = sorted(names)[:4]
    return ", ".join(shown) + (f" and {len(names) - len(shown)} more" if len(names) > len(shown) else "")


def _contents(text: str) -> _Contents | None:
    """What a file holds; None if it was not exported."""
    if not _HEAD.match(text.replace("\n", " ", 1)):
        return None
    found = _HELD.search(re.sub(r"\n[ /*!]+(?=\n)", "\n", _MARKS.sub("", text)))
    source, functions = (" ".join(part.split()) for part in found.groups()) if found else ("", "")
    return _Contents(source, frozenset(functions.split(", ")))


__all__ = ["check_overwritten"]
