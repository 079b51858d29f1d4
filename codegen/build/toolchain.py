"""The C compiler of this machine: finding one, running it, and saying what it refused.

`CC` is respected; what is compiled is not known here. Where the system has none, the package `ziglang` is one: clang,
the linker and the headers of libc, all installed by pip.
"""

from __future__ import annotations

import errno
import os
import re
import shlex
import shutil
import subprocess
from dataclasses import dataclass
from functools import lru_cache
from importlib.util import find_spec
from pathlib import Path

from ..errors import CompileError, CompilerMissingError
from . import cache

REMEDY = "Install gcc or clang (or set CC to one), or: pip install ziglang"
#: Of programs that a wheel may hold.
REMEDY_OF_PROGRAMS = f"{REMEDY}, or install with BLADESMITH_COMPILE=all where there is one"
#: Of kernels that are declared: no other program has targets.
REMEDY_OF_KERNELS = f"{REMEDY}, or use target='numba'"

_CANDIDATES = ("gcc", "clang", "cc")  # gcc first: the speeds in the documents are its
#: Of ziglang's compiler, which else looks for undefined behaviour, and makes code for this very processor.
_ZIG_OPTIONS = ("cc", "-fno-sanitize=undefined", "-mcpu=baseline")
_ZIG_CACHES = ("ZIG_GLOBAL_CACHE_DIR", "ZIG_LOCAL_CACHE_DIR")
_VERSION_TIMEOUT = 20.0  # seconds; a compiler that does not answer by then is not usable
_ERROR_LINES = 3


@dataclass(frozen=True)
class CompilerInfo:
    """A C compiler that runs on this machine."""

    command: tuple[str, ...]
    version: str

    @property
    def summary(self) -> str:
        """First line of what it says about itself."""
        return self.version.splitlines()[0]


def compiler() -> CompilerInfo | None:
    """The C compiler: `CC` when that is set, else the first of gcc, clang, cc and the package ziglang that runs."""
    return _find_compiler(os.environ.get("CC", ""), os.environ.get("PATH", ""))


def required_compiler(what: str = "", remedy: str = "") -> CompilerInfo:
    """The C compiler, or an error that names the remedy.

    Parameters
    ----------
    what, remedy
        What it is needed for, and what helps, as `missing_compiler` says them.

    Raises
    ------
    CompilerMissingError
        If there is none, or `CC` does not run.
    """
    found = compiler()
    if found is None:
        raise missing_compiler(what, remedy)
    return found


def missing_compiler(what: str = "", remedy: str = "") -> CompilerMissingError:
    """The error where there is none.

    Parameters
    ----------
    what
        What it is needed for, a sentence such as "chains are compiled at their first use". Default: a declared kernel.
    remedy
        Default: install one.
    """
    chosen = os.environ.get("CC", "").strip()
    missing = f"the C compiler CC={chosen!r} does not run" if chosen else "no C compiler was found"
    if not what:
        return CompilerMissingError(missing, remedy=remedy or REMEDY_OF_KERNELS)
    return CompilerMissingError(f"{missing}; {what}", remedy=remedy or REMEDY)


def execute(
    command: list[str], folder: Path | None = None, timeout: float | None = None
) -> subprocess.CompletedProcess[str]:
    """Run a command to its end, with its output as text."""
    libraries = str(cache.folder_of(cache.ZIG))  # zig keeps its libc in one, and would have it in the home directory
    environment = {**dict.fromkeys(_ZIG_CACHES, libraries), **os.environ, "LC_ALL": "C"}  # errors are found by words
    return subprocess.run(
        command, cwd=folder, timeout=timeout, env=environment, capture_output=True, text=True, errors="replace"
    )


def run_compiler(command: list[str], folder: Path, where: str, source: Path) -> None:
    """Run the compiler in a folder; `where` and `source` say what it compiles.

    Raises
    ------
    CompilerMissingError
        If it does not run.
    CompileError
        If it refuses the source.
    OSError
        If there is no room for what it writes.
    """
    try:
        done = execute(command, folder=folder)
    except OSError as error:  # it answered --version, and is gone
        raise CompilerMissingError(f"{command[0]} does not run: {error.strerror}", remedy=REMEDY) from None
    if done.returncode == 0:
        return
    output = done.stderr or done.stdout
    for number in (errno.ENOSPC, errno.EDQUOT):
        if os.strerror(number) in output:  # not the source's fault: another directory may do
            raise OSError(number, os.strerror(number), str(folder))
    raise CompileError(_first_errors(output), where=where, source=source)


def _first_errors(output: str) -> str:
    lines = [line.strip() for line in output.splitlines() if line.strip()]
    # collect2, and clang, only say that the linker failed
    lines = [line for line in lines if not re.match("collect2:|.*linker command failed", line)] or lines
    errors = [line for line in lines if "error:" in line] or lines
    return " | ".join(errors[:_ERROR_LINES]) or "the compiler failed and said nothing"


@lru_cache(maxsize=8)
def _find_compiler(chosen: str, path: str) -> CompilerInfo | None:
    for name, *options in [_split(chosen)] if chosen.strip() else [[name] for name in _CANDIDATES]:
        program = shutil.which(name, path=path)
        if program and (version := _version_of((program, *options))):
            return CompilerInfo((program, *options), version)
    return None if chosen.strip() else _ziglang()


def _ziglang() -> CompilerInfo | None:
    """The compiler of the package ziglang, where that is installed."""
    package = find_spec("ziglang")
    if package is None or not package.origin:
        return None
    command = (str(Path(package.origin).with_name("zig.exe" if os.name == "nt" else "zig")), *_ZIG_OPTIONS)
    version = _version_of(command)
    return CompilerInfo(command, f"ziglang: {version}") if version else None


def _split(command: str) -> list[str]:
    try:
        return shlex.split(command)
    except ValueError:  # an unbalanced quotation mark: not a command line, then perhaps a path
        return [command]


def _version_of(command: tuple[str, ...]) -> str | None:
    """Version that the compiler reports; options come along, because `ccache gcc` is one command."""
    try:
        done = execute([*command, "--version"], timeout=_VERSION_TIMEOUT)
    except (OSError, subprocess.TimeoutExpired):
        return None
    return done.stdout.strip() or None if done.returncode == 0 else None
