"""`bladesmith doctor`: what this machine has, and what of it is in use. Reports, and repairs nothing."""

from __future__ import annotations

import ctypes
import json
import os
import platform
import sys
from collections.abc import Callable
from importlib import import_module, metadata, resources
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import click

from ..codegen.build import cache
from ..codegen.build.cpu_features import best_instances, processor_name
from ..codegen.build.extension import compiler, has_python_headers
from ..codegen.build.flags import C_FLAGS, compiled_files, source_hash, unit_file
from ..codegen.build.installed import linked_units
from ..codegen.errors import BladesmithError, MissingExtraError
from ..codegen.execute import nvrtc
from ..codegen.targets.c.instances import OF_KERNELS
from ..codegen.targets.capabilities import PROGRAMS, TARGETS, compiled_only
from ..codegen.version import __version__
from ..common.parallel import thread_count
from . import options
from .cache import readable

Facts = dict[str, str]

_PACKAGES = ("numpy", "cffi", "sympy", "jinja2", "click", "pydantic")
_NAME_LENGTH = 100  # bytes for a graphics processor's name; the driver cuts longer ones


@options.command("doctor --json", "algebra/targets")
@click.option("--json", "as_json", is_flag=True, help="For programs and bug reports.")
def command(as_json: bool) -> None:
    """Say what compiler, targets, caches and threads this machine has, and whether the kernels are fresh."""
    found = {title: _try_section(facts) for title, facts in SECTIONS.items()}
    if as_json:
        click.echo(json.dumps(found, indent=1))
        return
    width = max(len(label) for facts in found.values() for label in facts)
    for title, facts in found.items():
        click.echo(f"{title}:")
        for label, value in facts.items():
            click.echo(f"  {label:<{width}}  {value}")


def versions() -> Facts:
    """This package, the interpreter and what it is built on."""
    found = {"bladesmith": f"{__version__} in {resources.files(__package__.rpartition('.')[0])}"}
    found["python"] = f"{platform.python_version()} ({platform.python_implementation()}), {sys.executable}"
    found["system"] = platform.platform()
    return found | {name: _version(name) for name in _PACKAGES}


def processor() -> Facts:
    """The processor, and which instance of the kernels it runs."""
    return {
        "name": processor_name(),
        "threads": f"{thread_count()} of {os.cpu_count()} usable",
        **_instances(),
    }


def c_compiler() -> Facts:
    """The compiler that serves kernels made at run time."""
    chosen = compiler()
    if chosen is None:
        asked = os.environ.get("CC")
        why = f"CC={asked!r} does not run" if asked else "none found"
        remedy = "install gcc or clang, set CC to one, or: pip install ziglang"
        return {"compiler": f"{why}; {remedy}", "without it": _without_compiler()}
    return {
        "compiler": f"{' '.join(chosen.command)}: {chosen.summary}",
        "flags": " ".join(C_FLAGS),
        "Python.h": "found" if has_python_headers() else "missing: calls go through libffi, more slowly",
    }


def _without_compiler() -> str:
    missing = ", ".join(compiled_only())
    return (
        "kernels that were not compiled at install run by numba or NumPy, also those of your own; what is not "
        f"installed of these does not run: {missing}"
    )


def targets() -> Facts:
    """Availability of each target."""
    return {"C": "yes" if compiler() else "installed kernels only", "numba": _numba(), "CUDA": _cuda()}


def programs() -> Facts:
    """Table of what runs on which target, whether it is available or not."""
    return {name: "; ".join(f"{t.name}: {_extent(t.programs[name])}" for t in TARGETS) for name in PROGRAMS}


def _extent(text: str) -> str:
    """How much of a program a target runs, in words that stand alone."""
    return "yes, in float64 only" if text == "float64" else text


def kernel_cache() -> Facts:
    """The cache of compiled kernels."""
    found = cache.entries()
    root = cache.directory()
    return {
        "directory": f"{root} ({_access(root)})",
        "entries": f"{len(found)}, {readable(sum(entry.size for entry in found))}",
        "limit": readable(cache.LIMIT_BYTES),
    }


def algebras() -> Facts:
    """The stock algebras, and whether their compiled kernels are those of their sources."""
    package = __package__.partition(".")[0]
    generated = Path(str(resources.files(f"{package}.generated")))
    headers = Path(str(resources.files(f"{package}.templates"))) / "c"
    folders = [path for path in sorted(generated.iterdir()) if (path / "kernels.cdef").is_file()]
    if not folders:
        return {"none": "run: bladesmith generate"}
    return {**{folder.name: _freshness(folder, headers) for folder in folders}, "formulas": _formulas(generated)}


def _try_section(facts: Callable[[], Facts]) -> Facts:
    """Facts of a section; a failure is reported as one, and the other sections still run."""
    try:
        return facts()
    except Exception as error:
        return {"failed": f"{type(error).__name__}: {error}"}


SECTIONS: dict[str, Callable[[], Facts]] = {
    "versions": versions,
    "processor": processor,
    "compiler": c_compiler,
    "targets": targets,
    "programs": programs,
    "cache": kernel_cache,
    "algebras": algebras,
}


def _version(name: str) -> str:
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return "not installed"


def _extension(name: str) -> Any:
    """The compiled module of a generated folder, or None."""
    try:
        return import_module(f"{__package__.partition('.')[0]}.generated.{name}._kernels")
    except ImportError:
        return None


def _text(module: Any, pointer: Any) -> str:
    return str(module.ffi.string(pointer).decode())


def _instances() -> Facts:
    """The instruction sets in use: of each precision the last instance that the processor takes."""
    in_use = ", ".join(i.tag for precision in ("f64", "f32") for i in best_instances(precision))
    return {"instances": f"{in_use} (of {', '.join(i.tag for i in OF_KERNELS)})"}


def _numba() -> str:
    found = find_spec("numba") is not None
    return f"yes, numba {_version('numba')}" if found else "no: pip install 'bladesmith[numba]'"


def _cuda() -> str:
    """Without touching a device: the compiler and the driver are libraries."""
    try:
        major, minor = nvrtc.version()
    except MissingExtraError:
        return "no: pip install 'bladesmith[cuda]'"
    devices = _devices()
    run = f"runs on {', '.join(devices)}" if devices else "no device here: compiles, does not run"
    return f"NVRTC {major}.{minor}; {run}"


def _devices() -> list[str]:
    """Names of the graphics processors, as the driver gives them."""
    try:
        driver = ctypes.CDLL("nvcuda.dll" if os.name == "nt" else "libcuda.so.1")
        if driver.cuInit(0) != 0:
            return []
        count = ctypes.c_int()
        driver.cuDeviceGetCount(ctypes.byref(count))
    except (OSError, AttributeError):
        return []
    names = []
    for i in range(count.value):
        name = ctypes.create_string_buffer(_NAME_LENGTH)
        if driver.cuDeviceGetName(name, _NAME_LENGTH, i) == 0:
            names.append(name.value.decode(errors="replace"))
    return names


def _access(root: Path) -> str:
    """Test whether the directory, or the one that it would be made in, can be written."""
    return "writable" if cache.is_writable(root) else "not writable: kernels go to a temporary directory"


def _formulas(generated: Path) -> str:
    """State of the generated texts: current, or older than the formulas."""
    from ..codegen.generator import outdated_modules

    try:
        stale = outdated_modules(generated)
    except BladesmithError as error:
        return f"cannot be read: {error}"
    if not stale:
        return "none is newer than the generated texts"
    return f"NEWER than the generated texts: {', '.join(stale)}. Run: bladesmith generate --update"


def _freshness(folder: Path, headers: Path) -> str:
    module = _extension(folder.name)
    if module is None:
        return "compiled at first use, which needs a compiler"
    if not hasattr(module.lib, "bs_source_hash"):
        return "compiled"
    count = f"{module.lib.bs_kernel_count()} kernels, " if hasattr(module.lib, "bs_kernel_count") else ""
    if _text(module, module.lib.bs_source_hash()) != source_hash(compiled_files(folder, headers)):
        return f"{count}STALE: compiled from other sources; install again"
    texts = {path.stem for path in folder.glob("kernels/*.c")}
    if not texts:
        return f"{count}compiled from these sources"
    found: dict[str, list[str]] = {}
    stale = set()
    for formulas, instance, made_of in linked_units(module):
        if made_of == source_hash(compiled_files(folder, headers, [unit_file(formulas)])):
            found.setdefault(instance, []).append(formulas)
        else:
            stale.add(formulas)
    compiled = [f"{', '.join(sorted(names))} ({instance})" for instance, names in found.items()]
    parts = [f"installed: {'; '.join(compiled)}", "The others are compiled at first use"] if compiled else []
    if stale:
        parts.append(f"STALE, compiled anew at first use: {', '.join(sorted(stale))}")
    return f"{count}{'. '.join(parts) or 'all compiled at first use'}"
