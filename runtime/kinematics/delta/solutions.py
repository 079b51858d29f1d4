"""Inverse and forward kinematics of the Delta robot as values and codes (thesis 7.7.2)."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...common.validation import as_choice
from . import evaluation as calls
from .geometry import DeltaGeometry

Array = NDArray[Any]
#: Postures of an arm; the first has sign +1.
ELBOWS = ("outer", "inner")
#: Their signs where all arms have the same.
SIGNS = {name: calls.ALIKE[name == ELBOWS[0]] for name in ELBOWS}
#: Weights of the forearms' volume and of the distance along e3: see `codegen.formulas.delta.delta.side_of`.
ROOTS = {
    name: calls.fixed(weights)
    for name, weights in (("far", (0, 1.0)), ("near", (0, -1.0)), ("positive", (1.0, 0)), ("negative", (-1.0, 0)))
}


def inverse(
    geometry: DeltaGeometry, y: Array, elbows: Array, precise: bool = False, threads: int | None = None
) -> tuple[Array, Array]:
    """Angles (..., 3) and codes for positions (..., 3) and a sign for each elbow (3,)."""
    formula = "delta.inverse_precise" if precise else "delta.inverse"
    (theta,), codes = calls.evaluate(formula, [y, geometry.parameters, elbows], threads)
    assert codes is not None
    return theta, codes


def forward(
    geometry: DeltaGeometry, theta: Array, root: str, precise: bool = False, threads: int | None = None
) -> tuple[Array, Array]:
    """Positions (..., 3) and codes for angles (..., 3) and a name of `ROOTS`."""
    formula = "delta.forward_precise" if precise else "delta.forward"
    (y,), codes = calls.evaluate(formula, [theta, geometry.parameters, root_weights(root)], threads)
    assert codes is not None
    return y, codes


def arm_codes(geometry: DeltaGeometry, y: Array, elbows: Array) -> Array:
    """Codes (..., 3) of each arm at positions (..., 3)."""
    (codes,), _ = calls.evaluate("delta.arm_codes", [y, geometry.parameters, elbows])
    return codes.astype(np.uint8)


def jacobians(formula: str, operands: list[Array], threads: int | None) -> tuple[Array, Array]:
    """Matrices (..., 3, 3) and codes of a formula."""
    (values,), codes = calls.evaluate(formula, operands, threads)
    assert codes is not None
    return values.reshape(*values.shape[:-1], 3, 3), codes


def elbow_signs(elbow: Any) -> Array:
    """Signs (3,) of the elbows by a name of `ELBOWS`, or three."""
    return calls.signs(elbow, ELBOWS, "elbow")


def root_weights(root: str) -> Array:
    """Weights (2,) of a name of `ROOTS`."""
    return ROOTS[as_choice(root, "root", tuple(ROOTS))]


__all__ = ["ELBOWS", "ROOTS", "SIGNS", "arm_codes", "elbow_signs", "forward", "inverse", "jacobians", "root_weights"]
