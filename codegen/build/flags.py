"""How every C text of this project is compiled: one list for the installed extensions and for run time.

setup.py runs this file by its path, before anything is installed: only the standard library may come in.
"""

from __future__ import annotations

import hashlib
import re
from collections.abc import Mapping
from pathlib import Path

C_FLAGS: tuple[str, ...] = (
    "-std=c11",
    "-O3",
    "-ffp-contract=off",  # the same bits on every instruction set
    "-fno-math-errno",
    "-fno-trapping-math",
    "-fopenmp-simd",
)
"""For gcc and clang. Never -ffast-math (it breaks NaN tests), never -march=native (the build is shipped)."""

MSVC_FLAGS: tuple[str, ...] = ("/std:c11", "/O2", "/fp:precise")
"""The nearest that Microsoft's compiler has; it takes the scalar form of every kernel."""

WARNING_FLAGS: tuple[str, ...] = ("-Wall", "-Wextra", "-Werror")
"""Added by the tests: generated C is clean under them."""

HASH_MACRO = "BS_SOURCE_HASH"
"""Defined as a C string while an extension is compiled; `bs_source_hash()` in the generated C returns it."""

_HASH_LENGTH = 16  # hexadecimal digits: 64 bits, enough to tell a stale build from a fresh one
_INCLUDE = re.compile(r'^[ \t]*#[ \t]*include[ \t]*"([^"]+)"', re.MULTILINE)


def source_hash(files: Mapping[str, str]) -> str:
    """The first 16 hexadecimal digits of SHA-256 over the names and texts, in order of name."""
    digest = hashlib.sha256()
    for name in sorted(files):
        digest.update(name.encode() + b"\0" + files[name].encode() + b"\0")
    return digest.hexdigest()[:_HASH_LENGTH]


def compiled_files(folder: Path, headers: Path) -> dict[str, str]:
    """Everything that goes into the extension of one generated folder, by file name.

    Parameters
    ----------
    folder
        `generated/<name>`: `kernels.c`, `kernels.cdef` and headers of its own.
    headers
        `templates/c`: the headers that all generated sources share. Those that are included count.
    """
    files: dict[str, str] = {}
    wanted = ["kernels.cdef", "kernels.c"]
    while wanted:
        name = wanted.pop()
        path = next((home / name for home in (folder, headers) if (home / name).is_file()), None)
        if path is not None and name not in files:
            files[name] = path.read_text(encoding="utf-8")
            wanted += _INCLUDE.findall(files[name])
    return files
