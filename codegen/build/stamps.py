"""Digests of the sources of generated files, stored beside them, so that only changed modules are generated again.

A generated algebra has one group of files for each module of formulas. Its stamp is a digest of the formulas, of what
they reach, and of the spec; the code that traces and prints has another, and the files themselves have seals.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from ..targets.templates import template_text
from .formula_digest import formula_digest, machinery_digest

#: Name of the file in a generated folder.
STAMPS = "sources.json"
FORMAT = 1
#: Code and templates that every generated text depends on.
PRINTERS = ("generator.py", "targets/c/extension.py", "targets/numba/printer.py")
TEMPLATES = ("unit.c.j2", "kernel.h.j2", "kernels.c.j2", "calls.h.j2", "kernels.cdef", "calls.cdef", "kernels.py.j2")
_DIGITS = 16


@dataclass(frozen=True)
class Stamps:
    """Digests of the sources of a generated folder.

    Parameters
    ----------
    modules
        For each module of formulas, or each formula of a program, a digest of the formulas and of the spec.
    printers
        Digest of the code and the templates that trace and print.
    """

    modules: Mapping[str, str]
    printers: str = ""

    def text(self, files: Mapping[str, str]) -> str:
        """Contents of the file, with seals of all other files."""
        seals = {name: _digest(text) for name, text in files.items()}
        return json.dumps({"format": FORMAT, **asdict(self), "seals": seals}, indent=1) + "\n"


def module_stamp(algebra: Mapping[str, Any], declared: Iterable[tuple[str, ...]], formulas: Iterable[str]) -> str:
    """Stamp of a module: from the algebra's data, the declarations of its kernels, and their formulas' names."""
    parts = [algebra, list(declared), [formula_digest(name) for name in dict.fromkeys(formulas)]]
    return _digest(json.dumps(parts))


def printers_stamp() -> str:
    """Stamp of the code and the templates that every text of an algebra depends on."""
    return _digest(machinery_digest(*PRINTERS) + "".join(template_text(name) for name in TEMPLATES))


def read_stamps(files: Mapping[str, str]) -> Stamps:
    """Stamps of generated files; empty ones if a file is not as it was written."""
    try:
        data = json.loads(files.get(STAMPS, ""))
        if data["format"] == FORMAT and all(_digest(files[name]) == seal for name, seal in data["seals"].items()):
            return Stamps(dict(data["modules"]), str(data["printers"]))
    except (ValueError, KeyError, TypeError, AttributeError):
        pass
    return Stamps({})


def generated_files(folder: Path) -> dict[str, str]:
    """The generated texts in a folder, by path; none where there is no such folder."""
    return {
        path.relative_to(folder).as_posix(): path.read_text(encoding="utf-8", errors="replace")  # seals tell damage
        for path in sorted(folder.rglob("*"))
        if path.suffix in (".c", ".h", ".cdef", ".py", ".json", ".md") and "__pycache__" not in path.parts
    }


def _digest(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()[:_DIGITS]
