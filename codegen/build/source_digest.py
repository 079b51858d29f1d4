"""Digest of the source files that the printed text of a formula depends on.

Imports are followed through this package, also those inside functions: what could change the text changes the digest.
"""

from __future__ import annotations

import hashlib
import os
import re
from collections.abc import Callable, Iterable
from functools import cache
from pathlib import Path

from ..start_time import LOADED
from ..version import __version__

ROOT = Path(__file__).resolve().parent.parent
_FROM = re.compile(r"^[ \t]*from[ \t]+(\.+)([\w.]*)[ \t]+import[ \t]*(\([^)]*\)|[^\n]*)", re.MULTILINE)
_NAME = re.compile(r"(\w+)(?:[ \t]+as[ \t]+\w+)?")
_COMMENT = re.compile(r"#[^\n]*")


def digest(files: Iterable[str]) -> str | None:
    """Digest of files of this package, and of every module that they import and that printed texts depend on.

    Parameters
    ----------
    files : iterable of str
        Paths from the package's folder, such as ``formulas/rays/rays.py``.

    Returns
    -------
    str or None
        None where the sources are not at hand, or younger than what this process runs.
    """
    try:
        found = closure(files, lambda name: not affects_text(name))
        if any((ROOT / name).stat().st_mtime >= LOADED for name in found):
            return None
        parts = [f"{name} {_digest_of(name)}" for name in sorted(found)]
    except (OSError, UnicodeDecodeError):
        return None
    return hashlib.sha256("\n".join(parts).encode()).hexdigest()


@cache
def stamp() -> str | None:
    """Names, sizes and times of all files of the compiler and of its templates: it changes when any of them does.

    Nothing is read: Python tells by the same two that its own compiled files are old. None where there are no such
    files, or one is younger than what this process runs.
    """
    found = []
    try:
        waiting = [str(ROOT), str(ROOT.parent / "templates")]
        while waiting:
            with os.scandir(waiting.pop()) as entries:
                for entry in entries:
                    if entry.is_dir():
                        waiting += [entry.path] if entry.name != "__pycache__" else []
                    else:
                        status = entry.stat()
                        if status.st_mtime >= LOADED:
                            return None
                        found.append((entry.path, status.st_size, status.st_mtime_ns))
    except OSError:
        return None
    return hashlib.sha256(repr((__version__, sorted(found))).encode()).hexdigest()


def affects_text(name: str) -> bool:
    """Return whether printed texts depend on a file: the stages after printing leave them as they are."""
    return not name.startswith(("build/", "execute/"))


def closure(files: Iterable[str], without: Callable[[str], bool] = lambda name: False) -> set[str]:
    """The files, and what they import from this package, directly or not; ``without`` some, and what only these do."""
    found: set[str] = set()
    waiting = list(files)
    while waiting:
        name = waiting.pop()
        if name not in found and not without(name):
            found.add(name)
            waiting += _direct_imports(name)
    return found


@cache
def text_of(name: str) -> str:
    """Text of a file, by its path from the package's folder."""
    return (ROOT / name).read_text(encoding="utf-8")


@cache
def _digest_of(name: str) -> str:
    return hashlib.sha256(text_of(name).encode()).hexdigest()


@cache
def _direct_imports(name: str) -> frozenset[str]:
    """Files that a file imports, by relative imports: there are no others within the package."""
    if not name.endswith(".py"):
        return frozenset()
    package = name.split("/")[:-1]
    found: set[str] = set()
    for dots, module, names in _FROM.findall(text_of(name)):
        if len(dots) - 1 > len(package):
            continue  # outside this package
        base = [*package[: len(package) - len(dots) + 1], *(part for part in module.split(".") if part)]
        places = [base, *([*base, n] for n in _NAME.findall(_COMMENT.sub("", names)))]
        found |= {file for place in places for file in ("/".join(place) + ".py", "/".join([*place, "__init__.py"]))}
    return frozenset(found & _all_files())


@cache
def _all_files() -> frozenset[str]:
    return frozenset(path.relative_to(ROOT).as_posix() for path in ROOT.rglob("*.py"))
