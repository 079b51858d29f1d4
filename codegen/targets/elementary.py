"""The text of the elementary functions as functions of the loop IR, in one precision, for all who print it."""

from __future__ import annotations

from collections.abc import Iterable
from types import SimpleNamespace
from typing import Any

from ..elementary import functions
from ..elementary.constants import DOUBLE, TWO_OVER_PI, Constants
from ..ir.loops.algorithm import inlined
from ..ir.loops.language import IntVector, Real, Static
from ..ir.loops.nodes import Function
from ..ir.loops.types import BOOL, REAL, Parameter
from ..rings.protocol import STUMPFF

#: The functions that others call, and with them what these call.
NAMES = ("sin", "cos", "exp", "log", "sinh", "cosh", "atan2", "stumpff", *STUMPFF)
#: Reduces very large angles, where there are some: each target has a text of its own, around `far_reduction`.
FAR_OR_NEAR = "far_or_near"


def elementary_functions(names: Iterable[str], c: Constants) -> list[Function]:
    """Some of `NAMES` with the constants of a precision."""
    algorithms = _algorithms(c)
    return [getattr(algorithms, name).specialised([REAL] * (2 if name == "atan2" else 1)) for name in names]


def far_reduction() -> Function:
    """What reduces one very large angle, in float64: takes it, and `TWO_OVER_PI`."""
    function: Function = _algorithms(DOUBLE).reduce_far.specialised([REAL, IntVector[len(TWO_OVER_PI)].type])
    return function


def _algorithms(c: Constants) -> SimpleNamespace:
    """The text as algorithms of one precision: its constants are static values."""

    def constants(x: Any) -> Any:
        return c

    constants.static_value = _static(c)  # type: ignore[attr-defined]
    inputs = (Parameter("x", REAL), Parameter("far", BOOL), *(Parameter(n, REAL) for n in ("high", "low", "quadrant")))
    written = Function(FAR_OR_NEAR, "", inputs, (REAL,) * 3, ())
    lanes = SimpleNamespace(
        is_callable_in_algorithms=True, name=written.name, text=SimpleNamespace(parameters=inputs),
        specialised=lambda *_: written,
    )  # fmt: skip
    words = IntVector[len(TWO_OVER_PI)]
    meanings = {"Real": Real, "Static": Static, "Words": words, "constants": constants, "far_or_near": lanes}
    return functions.compiled(inlined, meanings)


class _Labelled(tuple[float, ...]):
    """A polynomial, whose name is seen in those of functions."""

    label = ""


class _Static(Constants):
    label = ""


def _static(c: Constants) -> _Static:
    values: dict[str, Any] = {}
    for name, value in c._asdict().items():
        if isinstance(value, tuple):
            values[name] = _Labelled(float(v) for v in value)
            values[name].label = name
        else:
            values[name] = float(value)
    return _Static(**values)
