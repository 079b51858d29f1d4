"""Types of the values that only simulation files have: colors, and the names of integrators, charts, stabilizations."""

from __future__ import annotations

from typing import Annotated

from pydantic import AfterValidator

from ...mechanics.io.fields import one_of
from ..integration.integrators import INTEGRATORS, MAPS, STABILIZATIONS
from ..results.figure_spec import COLORS


def _color(text: str) -> str:
    hexadecimal = len(text) == 7 and text[0] == "#" and all(c in "0123456789abcdefABCDEF" for c in text[1:])
    return text if hexadecimal else one_of(text, [*COLORS, "#rrggbb"])


Color = Annotated[str, AfterValidator(_color)]
Integrator = Annotated[str, AfterValidator(lambda x: one_of(x, ("auto", *INTEGRATORS)))]
Chart = Annotated[str, AfterValidator(lambda x: one_of(x, MAPS))]
Stabilization = Annotated[str, AfterValidator(lambda x: one_of(x, STABILIZATIONS))]
