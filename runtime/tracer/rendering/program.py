"""Compiled scene programs, loaded or compiled on demand, and the preparation of surfaces' constants."""

from __future__ import annotations

import logging
from functools import cache, cached_property
from importlib import import_module
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.build.extension import compiler, load
from ...codegen.build.toolchain import REMEDY, REMEDY_OF_PROGRAMS, missing_compiler
from ...codegen.programs import Program
from ...codegen.programs.tracer.scene import EVERYTHING, SceneNeeds, scene_program
from ...codegen.programs.tracer.surface_kinds import surface_kind
from ...errors import CompilerMissingError, SceneError

Array = NDArray[Any]
_log = logging.getLogger("bladesmith")


class Engine:
    """A compiled scene program.

    Parameters
    ----------
    needs : SceneNeeds
        The key that it was compiled for.
    module : module
        The extension, with ``ffi`` and ``lib``.
    """

    def __init__(self, needs: SceneNeeds, module: Any) -> None:
        self.needs = needs
        self.module = module
        self.ffi = module.ffi
        self.lib = module.lib
        self.numbers = {name: i for i, name in enumerate(needs.kinds)}

    @cached_property
    def program(self) -> Program:
        """Source text and names of the kernels."""
        return scene_program(self.needs)

    @cached_property
    def meets_several(self) -> bool:
        """Test whether the program has a loop over packets of rays."""
        null = self.ffi.NULL
        return bool(self.needs.wide and self.lib.bs_scene_wide(null, 0, 0, 0, null, null))

    def prepare(self, kind: str, parameters: Array) -> Array:
        """Compute rows of constants (n, constants) from rows of surfaces' parameters (n, parameters)."""
        layout = surface_kind(kind)
        rows = np.ascontiguousarray(parameters, np.float64).reshape(-1, layout.parameters)
        constants = np.zeros((len(rows), layout.constants))
        if not len(rows):
            return constants
        buffer = self.ffi.from_buffer
        done = self.lib.bs_scene_prepare(
            self.numbers[kind],
            len(rows),
            buffer("double[]", rows),
            buffer("double[]", constants, require_writable=True),
        )
        if done < len(rows):
            raise SceneError(f"{kind}: the parameters {rows[done].tolist()} are not those of a surface.")
        return constants


@cache
def engine_for(needs: SceneNeeds) -> Engine:
    """Load or compile the program for these needs; without a compiler, the general one that the package ships.

    Raises
    ------
    CompilerMissingError
        Without a compiler: if the general program is not installed, or lacks a kind of surface.
    """
    if compiler() is None:  # printing what cannot be compiled would take seconds
        return _installed_engine(needs)
    program = scene_program(needs)
    try:
        module = load(program.extension())
    except CompilerMissingError:
        return _installed_engine(needs)
    engine = Engine(needs, module)
    engine.program = program  # a cached property: filled in
    return engine


def _installed_engine(needs: SceneNeeds) -> Engine:
    stock = _stock()
    if stock is None:
        raise missing_compiler("scenes are compiled at their first use", REMEDY_OF_PROGRAMS)
    lacking = [kind for kind in needs.kinds if kind not in EVERYTHING.kinds]
    if lacking:
        raise missing_compiler(
            f"surfaces of the kinds {', '.join(lacking)} are compiled at their first use",
            f"{REMEDY}; along curves of degree 1 to 3 surfaces need none",
        )
    _log.info("no compiler: scenes use the program that was compiled at install")
    return stock


@cache
def _stock() -> Engine | None:
    try:
        module = import_module("....generated.scene._kernels", __name__)
    except ImportError:
        return None
    return Engine(EVERYTHING, module)
