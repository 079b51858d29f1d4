"""The extension that calls what is compiled at run time: kernels that are added to it, loops of algorithms."""

from __future__ import annotations

from typing import Any

from .extension import generated_extension, load
from .installed import bundled_folder, headers, installed_program

#: Its generated folder.
CALLS = "calls"


def calls_extension() -> Any:
    """The extension, compiled at install or now.

    Raises
    ------
    CompilerMissingError
        If it was not compiled at install, and there is no compiler.
    """
    return installed_program(CALLS) or load(generated_extension(bundled_folder(CALLS), headers()))
