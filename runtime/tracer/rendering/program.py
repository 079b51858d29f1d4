"""Compiled scene programs: found or made for what a scene needs; rows of constants are made here."""

from __future__ import annotations

import logging
from functools import cache, cached_property
from importlib import import_module
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..codegen.build import load
from ..codegen.programs import Program
from ..codegen.programs.scene import EVERYTHING, SceneNeeds, scene_program
from ..codegen.programs.surface_kinds import surface_kind
from ..errors import CompilerMissingError, SceneError

Array = NDArray[Any]
_log = logging.getLogger("bladesmith")


class Engine:
    """One compiled program.

    Parameters
    ----------
    needs : SceneNeeds
        What it was made for.
    module : module
        With ``ffi`` and ``lib``.
    """

    def __init__(self, needs: SceneNeeds, module: Any) -> None:
        self.needs = needs
        self.module = module
        self.ffi = module.ffi
        self.lib = module.lib
        self.numbers = {name: i for i, name in enumerate(needs.kinds)}

    @cached_property
    def program(self) -> Program:
        """Its text and the names of its kernels."""
        return scene_program(self.needs)

    @cached_property
    def meets_several(self) -> bool:
        """Whether it has a loop that meets several rays at once."""
        null = self.ffi.NULL
        return bool(self.needs.wide and self.lib.bs_scene_wide(null, 0, 0, 0, null, null))

    def prepare(self, kind: str, parameters: Array) -> Array:
        """Rows of constants (n, constants) from rows of surfaces' parameters (n, parameters)."""
        known = surface_kind(kind)
        rows = np.ascontiguousarray(parameters, np.float64).reshape(-1, known.parameters)
        constants = np.zeros((len(rows), known.constants))
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
            raise SceneError(f"{kind}: the parameters {rows[done].tolist()} make no surface.")
        return constants


@cache
def engine_for(needs: SceneNeeds) -> Engine:
    """The program for these needs; without a compiler, the one for everything that the package carries."""
    program = scene_program(needs)
    try:
        module = load(program.extension())
    except CompilerMissingError:
        stock = _stock()
        if stock is None:
            raise
        _log.info("no compiler: scenes use the program that was compiled at install")
        return stock
    engine = Engine(needs, module)
    engine.program = program  # a cached property: filled in
    return engine


@cache
def _stock() -> Engine | None:
    try:
        module = import_module("...generated.scene._kernels", __name__)
    except ImportError:
        return None
    return Engine(EVERYTHING, module)
