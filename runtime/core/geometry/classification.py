"""Names of geometric objects, item by item, from squares, flatness and grades.

Each test is relative to what rounding can leave of the sum that it evaluates (`kind_constraints.tolerance`): neither
weight nor distance from the origin decides. Items near the ends of the range of numbers are first brought to its
middle.
"""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.errors import AlgebraMismatchError
from ...dispatch.coefficients import embed, normalize_exponents
from ...dispatch.formulas import evaluate
from ...dispatch.multivector_data import check_multivector
from ..kind_constraints import tolerance

if TYPE_CHECKING:
    from ..multivector import Algebra, Multivector

Names = NDArray[np.object_]
NOT_A_BLADE = "not a blade"
#: Round, flat, imaginary, of radius zero, at infinity; and the sign of the square of real objects. By dimension of
#: the space and grade.
CONFORMAL = {
    (3, 2): (("point pair", "flat point", "imaginary point pair", "tangent vector", "direction"), 1),
    (3, 3): (("circle", "line", "imaginary circle", "tangent plane", "direction of planes"), 1),
    (3, 4): (("sphere", "plane", "imaginary sphere", "sphere of radius zero", "direction of space"), -1),
    (2, 2): (("point pair", "flat point", "imaginary point pair", "tangent vector", "direction"), 1),
    (2, 3): (("circle", "line", "imaginary circle", "circle of radius zero", "direction of the plane"), 1),
}
#: Kinds whose members are named without measuring, and what those of no curvature are.
KNOWN = ("point", "flat_point", "point_pair", "line", "circle", "plane", "sphere")
FLAT_LIMITS = {"point_pair": "flat point", "circle": "line", "sphere": "plane"}
ROUND, FLAT, IMAGINARY, TANGENT, IDEAL = range(5)
#: The square of a blade is at least this many times the rest of x x of the same weight, or it is noise: what is left
#: of the one has the errors of the other.
UNCERTAIN = 4


def conformal(algebra: Algebra, x: Multivector) -> str | NDArray[np.str_]:
    """Names of objects of CGA."""
    return _by_grade(algebra, x, _conformal_grade)


def projective(algebra: Algebra, x: Multivector) -> str | NDArray[np.str_]:
    """Names of objects of plane-based geometry."""
    return _by_grade(algebra, x, _projective_grade)


def _by_grade(algebra: Algebra, x: Multivector, named: Any) -> str | NDArray[np.str_]:
    check_multivector(x, "the argument of classify")
    if x.algebra is not algebra:
        raise AlgebraMismatchError(f"x belongs to {x.algebra.name}, not to {algebra.name}.")
    own = x.reshape(-1)
    flat = normalize_exponents(own)[0]
    if x.kind.name in KNOWN and x.kind.constraints:
        names = _names_by_kind(flat)
        names[~np.isfinite(flat._data).all(-1)] = "invalid"
        return _shaped(names, x)
    limit = tolerance(x.dtype)
    with np.errstate(all="ignore"):
        sizes = np.stack([np.abs(flat.grade(g)._data).sum(-1) for g in x.grades], -1)
        total = sizes.sum(-1)
        present = sizes > limit * total[:, None]
    names = np.full(flat.shape, NOT_A_BLADE, object)
    names[~np.isfinite(total)] = "invalid"
    names[total == 0] = "zero"
    single = np.isfinite(total) & (present.sum(-1) == 1)
    for i, g in enumerate(x.grades):
        mine = single & present[:, i]
        if mine.any():
            part = flat[mine].grade(g)
            names[mine] = named(algebra, part, g, limit)
    several = np.isfinite(total) & (present.sum(-1) > 1)
    if several.any() and all(g % 2 == 0 for g in x.grades):
        names[several] = _motions(algebra, own[several], flat[several])
    return _shaped(names, x)


def _shaped(names: Names, x: Multivector) -> str | NDArray[np.str_]:
    return names.reshape(x.shape).astype(str) if x.shape else str(names[0])


def _names_by_kind(x: Multivector) -> Names:
    """Objects of a constrained kind: what it says, or the flat object that satisfies its constraints too.

    The weight of n0 is that of the curvature, wherever the object is; noise of it is on the scale of a unit normal.
    """
    names = np.full(x.shape, x.kind.name.replace("_", " "), object)
    flat = FLAT_LIMITS.get(x.kind.name)
    if flat is not None:
        curved = (x ^ _infinity(x.algebra))._data
        is_flat = np.abs(curved).sum(-1) <= float(np.finfo(x.dtype).eps)
        names[is_flat] = flat
    return names


@lru_cache(maxsize=4)
def _infinity(algebra: Algebra) -> Multivector:
    return algebra.basis_blade("ni")


def _conformal_grade(algebra: Algebra, x: Multivector, g: int, limit: float) -> Names:
    if g in (0, algebra.dimension):
        return np.full(x.shape, "scalar" if g == 0 else "pseudoscalar", object)
    measured = evaluate(algebra, "classification.invariants", x).value
    square, square_size, others, others_size, middle, flat, incidence, size = np.moveaxis(measured, -1, 0)
    sign = np.where(np.abs(square) <= limit * square_size, 0, np.sign(square)).astype(int)
    is_flat = flat > 0
    if g == 1:
        return _vectors(x, sign, incidence <= limit * size, limit)
    words, real = CONFORMAL[algebra.dimension - 2, g]
    choice = np.full(x.shape, ROUND)
    choice[is_flat] = FLAT
    choice[sign == -real] = IMAGINARY
    choice[sign == 0] = TANGENT
    choice[(sign == 0) & is_flat] = IDEAL
    names: Names = np.array(words, object)[choice]
    names[(others > limit * others_size) | (sign != 0) & (UNCERTAIN * middle > np.abs(square))] = NOT_A_BLADE
    return names


def _vectors(x: Multivector, sign: NDArray[np.int_], is_dual_flat: NDArray[np.bool_], limit: float) -> Names:
    """Points, and the duals of what space has: a vector is always a blade."""
    names = np.where(sign > 0, "dual sphere", np.where(sign < 0, "imaginary dual sphere", "point")).astype(object)
    names[is_dual_flat] = "dual plane"
    names[is_dual_flat & (sign == 0)] = "point at infinity"
    if x.algebra.dimension == 4:
        names = np.array([str(n).replace("sphere", "circle").replace("plane", "line") for n in names], object)
    return names


def _projective_grade(algebra: Algebra, x: Multivector, g: int, limit: float) -> Names:
    words = {
        0: ("scalar", "scalar"),
        1: ("plane", "plane at infinity"),
        2: ("line", "line at infinity"),
        3: ("point", "direction"),
        4: ("pseudoscalar", "pseudoscalar"),
    }[g]
    ideal = np.array([blade & 1 for blade in x._type.blades], bool)
    size = np.abs(x._data).sum(-1)
    at_infinity = np.abs(x._data[:, ~ideal]).sum(-1) <= limit * size
    names = np.where(at_infinity, words[1], words[0]).astype(object)
    if g == 2:
        defect = np.abs((x ^ x)._data).sum(-1)
        with np.errstate(all="ignore"):
            direction, moment = (np.abs(x._data[:, columns]).sum(-1) for columns in (~ideal, ideal))
            # moments of lines through the origin are errors: those of a unit length
            terms = 2 * direction * np.maximum(moment, direction)
        names[defect > limit * terms] = NOT_A_BLADE
    return names


def _motions(algebra: Algebra, x: Multivector, level: Multivector) -> Names:
    """Versors among even multivectors: the smallest kind of motion that holds the item, as it is or over its norm."""
    names = np.full(x.shape, NOT_A_BLADE, object)
    kinds = [k for k in algebra.kinds.values() if k.constraints and k.blades[0] == 0]
    from ..kind_constraints import satisfies_constraints

    with np.errstate(all="ignore"):
        norm = np.sqrt(np.abs(level.scalar_product(~level)["1"]))
        unit = level._make(level._type.unconstrained, level._data / norm[:, None], level.shape)
    size = np.abs(level._data).sum(-1)
    for kind in sorted(kinds, key=lambda k: -k.size):
        rest = [i for i, blade in enumerate(x._type.blades) if blade not in set(kind.blades)]
        inside = np.abs(level._data[:, rest]).sum(-1) <= tolerance(x.dtype) * size
        if inside.any():
            mine = inside.copy()
            # the norm of large dilators is noise: what is a versor as it stands needs none
            mine[inside] = satisfies_constraints(kind, embed(x[inside], kind)) | satisfies_constraints(
                kind, embed(unit[inside], kind)
            )
            names[mine] = kind.name.replace("_", " ")
    return names
