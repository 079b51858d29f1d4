"""Rotors as similarities x -> scale rotation x + translation, read from the images of n0 and n_inf."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.errors import InputError
from ...core.geometry.motors import motors_from
from ...core.multivector import Multivector
from ...core.registry import stock_algebra

Array = NDArray[np.float64]
#: Tolerance of rounding errors of a rotor: of R ~R - 1, and of zero coefficients of the images of basis vectors.
TOLERANCE = 1e-9
ROTOR = ("1", "e12", "e13", "e23")
REMEDY = "Give a motor of cga3d or pga3d, a matrix (4, 4), a dilator of cga3d, or a product of them"


def similarity(R: Any) -> tuple[float, Array, Array]:
    """Scale, rotation (3, 3) and translation (3,) of R x ~R; R is of cga3d, a motor of pga3d, or a matrix.

    Raises
    ------
    InputError, ShapeError, AlgebraMismatchError, GradeError, KindError
        If R is not a single unit versor that keeps n_inf, or no motion.
    """
    algebra: Any = stock_algebra("cga3d")
    R = motors_from(R, algebra, "R")
    if R.shape:
        raise InputError(f"R has shape {R.shape}; a model is moved by one rotor.", remedy="Choose one: R[i]")
    if not np.isfinite(R.values).all():
        raise InputError("R is not finite, or no rigid motion.", remedy=REMEDY)
    if any(grade % 2 for grade in R.grades):
        raise InputError(f"R has grades {R.grades}; a rotor is even.", remedy=REMEDY)
    size = float(np.abs(R.values).sum()) ** 2
    square = R * ~R
    if np.abs((square - 1).values).max() > TOLERANCE * max(size, 1.0):
        raise InputError("R is not a unit versor: R ~R is not 1.", remedy="Use .normalized()")
    infinity = _vector(R >> algebra.ni)
    if np.abs(infinity[:4]).max() > TOLERANCE * size or not infinity[4] > -TOLERANCE * size:
        raise InputError("R does not keep n_inf: flat objects would become round.", remedy=REMEDY)
    # beside those with n0 or n_inf its blades are those of the rotation, times cosh(log(scale)/2)
    turn = algebra.multivector({name: R[name] for name in ROTOR if name in map(str, R.blades)}).normalized("rotor")
    rotation = turn.to_matrix()[:3, :3]
    here, there = _vector(R >> algebra.no), _vector(~R >> algebra.no)  # images of the origin, forth and back
    if here[3] >= there[3]:  # the one of great weight keeps its digits: 1 / scale, or scale
        return float(1 / here[3]), rotation, here[:3] / here[3]
    return float(there[3]), rotation, -rotation @ there[:3]


def _vector(x: Multivector) -> Array:
    """Coefficients on e1 e2 e3 n0 n_inf."""
    blades = [str(blade) for blade in x.blades]
    found = np.zeros(5)
    for i, name in enumerate(("e1", "e2", "e3", "no", "ni")):
        if name in blades:
            found[i] = x[name]
    return found
