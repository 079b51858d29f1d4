"""Scene programs by what they need, loaded or compiled on demand."""

from __future__ import annotations

import logging
from dataclasses import replace
from functools import cache
from importlib import import_module
from importlib.util import find_spec

from ...codegen.build.extension import compiler, load
from ...codegen.build.toolchain import REMEDY_OF_PROGRAMS, missing_compiler
from ...codegen.programs.tracer.algorithms import numba_program
from ...codegen.programs.tracer.scene import EVERYTHING, scene_program
from ...codegen.programs.tracer.scene_needs import SceneNeeds
from ...errors import CompilerMissingError
from .cuda_engine import cuda_engine
from .engines import CEngine, Engine, NumbaEngine

_log = logging.getLogger("bladesmith")


@cache
def engine_for(needs: SceneNeeds) -> Engine:
    """Load or compile the program for these needs.

    Without a compiler: the general one that the package ships; where that is not installed, or lacks a kind of surface,
    numba's.

    Raises
    ------
    CompilerMissingError
        Without any of them.
    """
    if compiler() is None:  # printing what cannot be compiled would take seconds
        return _installed_engine(needs)
    program = scene_program(needs)
    try:
        module = load(program.extension())
    except CompilerMissingError:
        return _installed_engine(needs)
    engine = CEngine(needs, module)
    engine.program = program  # a cached property: filled in
    return engine


def _installed_engine(needs: SceneNeeds) -> Engine:
    stock = _stock()
    if stock is not None and stock.needs.covers(needs):
        _log.info("no compiler: scenes use the program that was compiled at install")
        return stock
    if find_spec("numba") is not None:
        _log.warning("scenes run by numba: %s.", missing_compiler().what)
        return numba_engine(needs)
    lacking = [kind for kind in needs.kinds if kind not in EVERYTHING.kinds]
    if stock is not None and lacking:
        raise missing_compiler(
            f"surfaces of the kinds {', '.join(lacking)} are compiled at their first use",
            f"{REMEDY_OF_PROGRAMS}; along curves of degree 1 to 3 surfaces need neither",
        )
    raise missing_compiler("scenes are compiled at their first use", REMEDY_OF_PROGRAMS)


@cache
def numba_engine(needs: SceneNeeds) -> Engine:
    """The program for these needs by numba, in double precision, with all layers: what is not called is not compiled.

    Raises
    ------
    MissingExtraError
        If numba is not installed.
    """
    own = replace(needs, single=False, layers=needs.pictures)
    if own != needs:
        return numba_engine(own)
    return NumbaEngine(own, *numba_program(own))


def engine_of(needs: SceneNeeds, target: str) -> Engine:
    """The program for these needs that runs on a target: c, numba or cuda."""
    if target == "numba":
        return numba_engine(needs)
    engine = engine_for(needs)
    return engine if target == "c" else cuda_engine(needs, engine)


@cache
def _stock() -> CEngine | None:
    try:
        module = import_module("....generated.scene._kernels", __name__)
    except ImportError:
        return None
    return CEngine(EVERYTHING, module)
