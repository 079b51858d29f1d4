"""Programs that the package carries, compiled when it was installed, and taken while they are up to date."""

from __future__ import annotations

import logging
from functools import cache
from importlib import import_module, resources
from pathlib import Path
from typing import Any

from .codegen.flags import compiled_files, source_hash

_log = logging.getLogger("bladesmith")


def headers() -> Path:
    """The folder of the headers that all generated sources share."""
    return Path(str(resources.files(f"{__package__}.templates"))) / "c"


def bundled(name: str) -> Path:
    """The package's own folder of generated files of that name."""
    return Path(str(resources.files(f"{__package__}.generated"))) / name


def is_fresh(module: Any, folder: Path) -> bool:
    """Whether a compiled module was made of what a generated folder and the headers hold now.

    One that does not say what it was made of counts as fresh.
    """
    compiled = module.ffi.string(module.lib.bs_source_hash()).decode()
    return not compiled or compiled == source_hash(compiled_files(folder, headers()))


@cache
def installed_program(name: str) -> Any:
    """The compiled module of ``generated/<name>``; None where there is none, or one that is older than its sources."""
    try:
        module = import_module(f".generated.{name}._kernels", __package__)
    except ImportError:
        return None
    if is_fresh(module, bundled(name)):
        return module
    _log.info("the installed program %s is older than its sources; what is needed of it is compiled now.", name)
    return None
