"""Programs compiled when the package was installed, used while they are up to date."""

from __future__ import annotations

import logging
from functools import cache
from importlib import import_module, resources
from pathlib import Path
from typing import Any

from .flags import compiled_files, source_hash

_PACKAGE = __package__.partition(".codegen")[0]
_log = logging.getLogger("bladesmith")


def headers() -> Path:
    """The folder of the headers that all generated sources share."""
    return Path(str(resources.files(f"{_PACKAGE}.templates"))) / "c"


def bundled_folder(name: str) -> Path:
    """The package's own folder of generated files of that name."""
    return Path(str(resources.files(f"{_PACKAGE}.generated"))) / name


def is_fresh(module: Any, folder: Path) -> bool:
    """Test whether a compiled module was made of the present texts of a generated folder and the headers.

    One that does not say what it was made of counts as fresh.
    """
    compiled = module.ffi.string(module.lib.bs_source_hash()).decode()
    return not compiled or compiled == source_hash(compiled_files(folder, headers()))


def linked_units(module: Any) -> dict[tuple[str, str, str], Any]:
    """Units of kernels that an extension was linked to at install: module of formulas, instance, hash of their text."""
    lib: Any = getattr(module, "lib", None)
    if not hasattr(lib, "bs_linked_unit"):
        return {}
    parts = (lib.bs_unit_module, lib.bs_unit_instance, lib.bs_unit_hash)
    found = {}
    for i in range(lib.bs_unit_count()):
        formulas, instance, made_of = (str(module.ffi.string(part(i)).decode()) for part in parts)
        found[formulas, instance, made_of] = lib.bs_linked_unit(i)
    return found


@cache
def installed_program(name: str) -> Any:
    """The compiled module of ``generated/<name>``; None if it is missing or older than its sources."""
    try:
        module = import_module(f"{_PACKAGE}.generated.{name}._kernels")
    except ImportError:
        return None
    if is_fresh(module, bundled_folder(name)):
        return module
    _log.info("the installed program %s is older than its sources; what is needed of it is compiled now.", name)
    return None
