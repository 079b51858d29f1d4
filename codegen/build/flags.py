"""How every C text of this project is compiled: one list for the installed extensions and for run time.

setup.py runs this file by its path, before anything is installed: only the standard library may come in.
"""

from __future__ import annotations

import hashlib
import re
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

C_FLAGS: tuple[str, ...] = (
    "-std=c11",
    "-O3",
    "-ffp-contract=off",  # the same bits on every instruction set
    "-fno-math-errno",
    "-fno-trapping-math",
    "-fwrapv",  # integers of algorithms wrap, as on every target
    "-fopenmp-simd",
)
"""For gcc and clang. Never -ffast-math (it breaks NaN tests), never -march=native (the build is shipped)."""

MSVC_FLAGS: tuple[str, ...] = ("/std:c11", "/O2", "/fp:precise")
"""The nearest that Microsoft's compiler has; it takes the scalar form of every kernel."""

WARNING_FLAGS: tuple[str, ...] = ("-Wall", "-Wextra", "-Werror")
"""Added by the tests: generated C is clean under them."""

HASH_MACRO = "BS_SOURCE_HASH"
"""Defined as a C string while an extension is compiled; `bs_source_hash()` in the generated C returns it."""

UNIT_FLAGS: tuple[str, ...] = ("-O1", "-ftree-slp-vectorize", "-fexpensive-optimizations")
"""Of units of kernels, after `C_FLAGS`: code as fast as -O3 makes it, in two thirds of the time. Without the second one
the root of a vector is taken lane by lane; without the third gcc leaves the upper halves of the vector registers in use
when a loop ends (no vzeroupper), and all code that has no AVX, such as most programs, runs at up to half its speed from
then on. Measured in docs/development/decisions/building.md."""

FULL_UNITS = frozenset(
    ("delta", "delta_frame", "exponentials", "invariant", "maps", "motions", "pose_maps", "poses", "rotors", "screws")
)
"""Modules of formulas that are compiled by `C_FLAGS` alone: where `UNIT_FLAGS` cost more than 5 % of some kernel's
speed (sines and series)."""

FIRST_MODULES: Mapping[str, frozenset[str]] = {
    "cga3d": frozenset(
        ("blades", "conformal", "exponentials", "invariant", "matrix_product", "motions", "products")
        + ("rotors", "versors")
    ),
    "pga3d": frozenset(("pose_maps", "poses")),
}
"""By algebra, the modules of formulas that are compiled at install, for the best instance of double precision that the
machine runs: what `bladesmith demo` and the examples of README.md call, and what poses are made and moved with. The
others, other algebras, programs and float32 are compiled at first use; everything is at install where
BLADESMITH_COMPILE=all."""

FIRST_PROGRAMS = frozenset(("calls", "general"))
"""The same of generated folders without modules of formulas."""

EXTENSION_FILES: tuple[str, ...] = ("kernels.cdef", "kernels.c")
"""What the extension of a generated folder starts from; its units start from `unit_file(module)`."""

_HASH_LENGTH = 16  # hexadecimal digits: 64 bits, enough to tell a stale build from a fresh one
_INCLUDE = re.compile(r'^[ \t]*#[ \t]*include[ \t]*"([^"]+)"', re.MULTILINE)


def unit_file(module: str) -> str:
    """Path in a generated folder of the C text of one module's kernels."""
    return f"kernels/{module}.c"


def unit_name(module: str, tag: str) -> str:
    """Name of a unit in C, without the prefix: see templates/c/kernels/table.h."""
    return f"{module}_{tag}"


def unit_options(module: str, instance: Any, made_of: str) -> tuple[str, ...]:
    """Options, after `C_FLAGS`, of one module's kernels for one instance, which say what they are compiled from."""
    defined = {
        "BS_BITS": instance.bits,
        "BS_BYTES": instance.bytes,
        "BS_TAG": instance.tag,
        HASH_MACRO: f'"{made_of}"',
    }
    return (*(f"-D{name}={value}" for name, value in defined.items()), *(() if module in FULL_UNITS else UNIT_FLAGS))


def source_hash(files: Mapping[str, str]) -> str:
    """The first 16 hexadecimal digits of SHA-256 over the names and texts, in order of name."""
    digest = hashlib.sha256()
    for name in sorted(files):
        digest.update(name.encode() + b"\0" + files[name].encode() + b"\0")
    return digest.hexdigest()[:_HASH_LENGTH]


def header_folders(headers: Path) -> list[Path]:
    """The folder, and all folders in it."""
    return [headers, *sorted(path for path in headers.rglob("*") if path.is_dir())]


def compiled_files(folder: Path, headers: Path, first: Iterable[str] = EXTENSION_FILES) -> dict[str, str]:
    """Everything that goes into the extension of one generated folder, or into a unit of it, by path.

    Parameters
    ----------
    folder
        `generated/<name>`: `kernels.c`, `kernels.cdef` and headers of its own.
    headers
        `templates/c`: its folders hold the headers that generated sources share. Those that are included count.
    first
        Where to start: the extension's own files, or `unit_file(module)`.
    """
    files: dict[str, str] = {}
    wanted = list(first)
    homes = (folder, *header_folders(headers))
    while wanted:
        name = wanted.pop()
        path = next((home / name for home in homes if (home / name).is_file()), None)
        if path is not None and name not in files:
            files[name] = path.read_text(encoding="utf-8")
            wanted += _INCLUDE.findall(files[name])
    return files
