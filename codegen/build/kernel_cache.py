"""Cache of printed kernels: entries shipped with the package, and entries in the user's cache directory.

An entry is valid only for the digest of the sources that it was generated from.
"""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Callable, Iterable, Mapping
from functools import cache
from importlib import resources
from typing import Any

from . import source_digest, text_cache

#: Besides a formula's own file: what traces and prints, and what is around a kernel's text.
_MACHINERY = (
    "trace/trace.py",
    "optimise/variants.py",
    "targets/c/printer.py",
    "programs/kernel_spec.py",
    "../templates/c/kernels/kernel.h.j2",
)
_PACKAGE = __package__.rpartition(".")[0]
#: In folders of generated/ with kernels of programs, the file that says which.
INDEX = "kernels.json"
_INDEX_FORMAT = 1
_DIGITS = 24
_KERNEL = re.compile(r"^(?=\n/\* \w+: )", re.MULTILINE)
_SYMBOL = re.compile(r"^BS_INLINE void FN\((\w+)\)", re.MULTILINE)


def key_of(formula: Callable[..., Any], kinds: Iterable[str], name: str, algebra: str) -> str:
    """A declaration in words."""
    return f"{algebra}: {name} = {formula.__module__.rpartition('.')[2]}.{formula.__qualname__}({', '.join(kinds)})"


@cache
def group_of(module: str, algebra: str) -> str | None:
    """Formulas of one module and everything that their text depends on; None where that cannot be told."""
    package, _, own = module.rpartition(f"{_PACKAGE}.")
    if package or not own:
        return None  # a formula of somebody else
    digest = source_digest.digest([own.replace(".", "/") + ".py", f"specs/{algebra}.toml", *_MACHINERY])
    return digest and f"{own.rpartition('.')[2]}_{digest[:_DIGITS]}"


def lookup(group: str, key: str) -> dict[str, str] | None:
    """Texts of a kernel and of those that it calls, by symbol."""
    shipped = _shipped_texts().get((group, key))
    if shipped is not None:
        return shipped
    _touch(group)
    try:
        found = json.loads(text_cache.read(group, _file(key)) or "")
        return dict(found["texts"]) if found["key"] == key else None
    except (ValueError, KeyError, TypeError, RecursionError):
        return None


def store(group: str, key: str, printed: Mapping[str, str]) -> None:
    """Store the texts of a kernel in the user's cache."""
    text_cache.write(group, {_file(key): json.dumps({"key": key, "texts": printed})})


@cache
def _forms() -> str | None:
    """Group of the selected forms of kernels that are made at run time; None where sources are not at hand."""
    digest = source_digest.digest(["optimise/variants.py"])
    return digest and f"forms_{digest[:_DIGITS]}"


def selected_form(fingerprint: str, select: Callable[[], Mapping[str, Any]]) -> Mapping[str, Any]:
    """The record of a kernel's selected form, from the user's cache; else it is selected now, and kept."""
    group = _forms()
    if group is None:
        return select()
    _touch(group)
    try:
        found: Mapping[str, Any] = json.loads(text_cache.read(group, f"{fingerprint}.json") or "")
    except (ValueError, RecursionError):
        found = select()
        text_cache.write(group, {f"{fingerprint}.json": json.dumps(found)})
    return found


def index(header: str, kernels: Mapping[tuple[str, str], Iterable[str]]) -> str:
    """Contents of the file that says which kernels a generated folder's header holds: symbols by group and key."""
    groups: dict[str, dict[str, list[str]]] = {}
    for (group, key), symbols in kernels.items():
        groups.setdefault(group, {})[key] = list(symbols)
    return json.dumps({"format": _INDEX_FORMAT, "header": _seal(header), "groups": groups}, indent=1) + "\n"


@cache
def _shipped_texts() -> dict[tuple[str, str], dict[str, str]]:
    """Texts shipped with the package, by group and key."""
    found: dict[tuple[str, str], dict[str, str]] = {}
    for folder in resources.files(f"{_PACKAGE.rpartition('.')[0]}.generated").iterdir():
        try:
            listed = json.loads(folder.joinpath(INDEX).read_text(encoding="utf-8"))
            header = folder.joinpath("kernels.h").read_text(encoding="utf-8")
            if listed["format"] != _INDEX_FORMAT or listed["header"] != _seal(header):
                continue
            pieces = {named[1]: text for text in _KERNEL.split(header) if (named := _SYMBOL.search(text))}
            for group, kernels in listed["groups"].items():
                for key, symbols in kernels.items():
                    found[group, key] = {symbol: pieces[symbol] for symbol in symbols}
        except (OSError, ValueError, KeyError, TypeError, AttributeError):
            continue  # not there, or not of one piece
    return found


@cache
def _touch(group: str) -> None:
    text_cache.touch(group)


def _seal(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()


def _file(key: str) -> str:
    return hashlib.sha256(key.encode()).hexdigest()[:_DIGITS] + ".json"
