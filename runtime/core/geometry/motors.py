"""Motors of space from what describes them: motors of another algebra, or matrices."""

from __future__ import annotations

from functools import lru_cache
from itertools import combinations
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from ...codegen.errors import AlgebraMismatchError
from ...common.validation import invalid, real_array
from ..multivector import Algebra, Multivector
from .euclidean import EuclideanAlgebra

#: Names of the null vector of translations: that of CGA, and that of PGA.
NULL_VECTORS = ("ni", "0")


def motors_from(x: Any, algebra: Algebra, name: str) -> Multivector:
    """Motors of an algebra from those of another, or from matrices; multivectors of its own are left as they are.

    Parameters
    ----------
    x : Multivector (...) or array (..., d + 1, d + 1)
        Motors, rotors or translators of CGA or PGA, which have the same numbers, signs aside. Matrices of no
        rigid motion are NaN, with status `INVALID`.
    algebra : Algebra
        CGA or PGA.
    name : str
        What it is, for messages.

    Raises
    ------
    InputError, ShapeError, AlgebraMismatchError, GradeError, KindError
    """
    target = cast(EuclideanAlgebra, algebra)
    size = target.space + 1
    if not isinstance(x, Multivector):
        if not hasattr(x, "__array__") and not isinstance(x, list | tuple):
            remedy = "Make it with translator and rotor, or with bladesmith.poses"
            raise invalid(x, name, f"a motor, or an array (..., {size}, {size}),", remedy=remedy)
        return target.motor_from_matrix(real_array(x, name, (..., size, size))).as_kind("motor")
    home = x.algebra
    if home is algebra:
        return x
    has_motors = isinstance(home, EuclideanAlgebra) and not set(NULL_VECTORS).isdisjoint(home.vectors)
    if not has_motors or cast(EuclideanAlgebra, home).space != target.space:
        what = f"{name} is a {x.kind.name} of {home.name}; a motor of {algebra.name} is needed."
        raise AlgebraMismatchError(
            what, remedy=f"Motors of cga{size - 1}d and of pga{size - 1}d are taken, and matrices"
        )
    motor = x.as_kind("motor")
    places, signs = _blades(cast(EuclideanAlgebra, home), target)
    return algebra.wrap(algebra.kind("motor"), motor._data[..., places] * signs.astype(motor.dtype), motor._status)


@lru_cache(maxsize=8)
def _blades(source: EuclideanAlgebra, target: EuclideanAlgebra) -> tuple[list[int], NDArray[np.float64]]:
    """For each blade of the target's motors its place among those of the source, and its sign.

    Motors do not tell the null vectors apart: both square to 0 and are orthogonal to the vectors of space.
    """
    null, own_null = (next(n for n in NULL_VECTORS if n in a.vectors) for a in (source, target))
    own = source.kind("motor").blades
    places, signs = [], []
    for blade in target.kind("motor").blades:
        names = [v for i, v in enumerate(target.vectors) if blade >> i & 1]
        order = [source.vectors.index(null if v == own_null else v) for v in names]
        places.append(own.index(sum(1 << i for i in order)))
        signs.append((-1.0) ** sum(a > b for a, b in combinations(order, 2)))
    return places, np.array(signs)


__all__ = ["motors_from"]
