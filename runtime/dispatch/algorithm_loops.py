"""Loops of algorithms that are compiled at their first use, in C, by numba or for a GPU: the same bits."""

from __future__ import annotations

import logging
from collections.abc import Callable
from importlib.util import find_spec
from typing import TYPE_CHECKING

from ..codegen.errors import CompilerMissingError

if TYPE_CHECKING:
    from ..codegen.execute.items import Loop
    from ..codegen.ir.loops.nodes import Function
    from ..codegen.targets.c.source import ExtensionSource

_log = logging.getLogger("bladesmith")
#: Where algorithms can run.
TARGETS = ("c", "numba", "cuda")


def compiled_loop(
    name: str, what: str, reason: str, target: str, extension: Callable[[], tuple[ExtensionSource, str]],
    function: Callable[[], Function],
) -> Loop:  # fmt: skip
    """The loop of an algorithm over items; by numba where there is no compiler.

    Parameters
    ----------
    name : str
        Of the printed module.
    what, reason : str
        For messages: "poses of mechanisms", "mechanisms are compiled at their first use".
    target : str
        Of `TARGETS`.
    extension, function : callable
        Give the C text and the tag of its loop; the IR.

    Raises
    ------
    CompilerMissingError
        If there is neither a compiler nor numba.
    DeviceError
        If the target is "cuda" and there is no GPU.
    """
    if target == "cuda":
        return _cuda_loop(function())
    from ..codegen.build.extension import load, required_compiler
    from ..codegen.execute.items import CLoop, NumbaLoop

    has_numba = find_spec("numba") is not None
    if target == "c":
        try:
            required_compiler("" if has_numba else reason)
            source, tag = extension()
            return CLoop(load(source), tag)
        except CompilerMissingError as error:
            if not has_numba:
                raise
            _log.warning("%s runs by numba: %s.", what, error.what)
    from ..codegen.programs.algorithms import algorithm_numba

    return NumbaLoop(name, algorithm_numba(function()), function())


def _cuda_loop(function: Function) -> Loop:
    from ..codegen.execute.cuda_driver import first_gpu
    from ..codegen.execute.cuda_items import algorithm_loop
    from ..codegen.programs.algorithms import algorithm_cuda
    from ..codegen.targets.c.instances import ONE_BY_ONE

    double = ONE_BY_ONE[:1]
    return algorithm_loop(first_gpu(), algorithm_cuda(function, double), function, double[0].tag)
