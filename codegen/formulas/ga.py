"""Functions of multivectors for formulas: what `codegen.exp` and its sisters are for scalars.

Each picks the form for the blades at hand when the formula is traced, and returns the value alone: where there is none,
NaN. A formula that needs the status calls the form itself, from the folders of `codegen.formulas`.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from ..algebra import multivector as scalars
from ..algebra.multivector import Multivector
from ..errors import GradeError, TraceError, one_line
from .motions import interpolation, rotors
from .objects import blades
from .products import exponentials, invariant, inverses, versors


def _value(found: Any) -> Multivector:
    """The first result of a formula."""
    first: Any = found[0] if isinstance(found, tuple) else found
    return first if isinstance(first, Multivector) else first.value


def _is_scalar(x: Multivector) -> bool:
    if not isinstance(x, Multivector):
        raise TraceError(
            f"an argument is {one_line(x)}; functions of codegen.ga are for multivectors of formulas.",
            remedy="Outside of them call the methods, x.exp(), x.log(), ...",
        )
    return not set(x.terms) - {0}


def _check_conformal(x: Multivector, name: str) -> None:
    _is_scalar(x)  # for its refusal
    if "ni" not in x.algebra.vectors:
        raise GradeError(f"{name} in a formula is that of conformal geometry, and {x.algebra.name} is none.")


def exp(x: Multivector) -> Multivector:
    """exp of a scalar, or of a bivector: of motors in every algebra, of any in five dimensions; see `B.exp()`.

    Raises
    ------
    GradeError
        If x has other grades, or its algebra no closed form for it.
    """
    if _is_scalar(x):
        return scalars.exp(x)
    if x.grades != (2,):
        raise GradeError(f"exp in a formula is that of a scalar or of a bivector, and this has the grades {x.grades}.")
    if exponentials.is_motion(x) or not (x * x).grade(4).terms:
        return exponentials.exp_bivector(x)
    return invariant.exp_bivector(x)  # says where there is none


def log(r: Multivector) -> Multivector:
    """The bivector b with exp(b) = r, of a unit motor or rotor (see `R.log()`); of a scalar its logarithm."""
    if _is_scalar(r):
        return scalars.log(r)
    return _value(exponentials.log_motor(r) if exponentials.is_motor(r) else invariant.log_rotor(r))


def sqrt(r: Multivector) -> Multivector:
    """exp(log(r)/2) of a unit motor or rotor; of a scalar its root."""
    if _is_scalar(r):
        return scalars.sqrt(r)
    return _value(exponentials.sqrt_motor(r) if exponentials.is_motor(r) else invariant.sqrt_rotor(r))


def inverse(x: Multivector) -> Multivector:
    """The y with x y = 1, by Shirokov's recursion; for blades and versors `versor_inverse` costs less."""
    return scalars.reciprocal(x) if _is_scalar(x) else _value(inverses.shirokov(x))


def versor_inverse(x: Multivector) -> Multivector:
    """~x/<x ~x>_0: the inverse of blades and of products of vectors."""
    return _value(versors.versor_inverse(x))


def norm(x: Multivector) -> Multivector:
    """``sqrt |<x ~x>_0|``."""
    return versors.norm(x)


def normalize(x: Multivector) -> Multivector:
    """x over its norm."""
    return _value(versors.normalise(x))


def nearest(x: Multivector) -> Multivector:
    """The nearest unit motor, line, plane or sphere: x (x ~x)^(-1/2)."""
    return _value(versors.normalise_flat(x))


def project(x: Multivector) -> Multivector:
    """The unit blade that a multivector of one grade stands for, such as a sum of circles (thesis 3.5)."""
    if len(x.grades) > 1:
        raise GradeError(f"project in a formula is that of one grade, and this has the grades {x.grades}.")
    return blades.project_to_blade(x)


def rotor_between(x: Multivector, y: Multivector) -> Multivector:
    """The rotor R with R x ~R = y, of unit objects of one kind of conformal geometry (thesis 2.4).

    Spheres, and circles in the plane, that face away from each other so that no rotor takes x to y, go to -y.

    Raises
    ------
    GradeError
        If the algebra is no conformal one.
    """
    _check_conformal(x, "rotor_between")
    return _value(rotors.rotor_between(x, y))


def interpolate(x: Multivector, y: Multivector, alpha: Multivector) -> Multivector:
    """The object between two of one kind: x where alpha is 1, y where it is 0 (thesis 3.5).

    Raises
    ------
    GradeError
        If the algebra is no conformal one.
    """
    _check_conformal(x, "interpolate")
    return _value(interpolation.interpolate(x, y, alpha))


def reflect(x: Multivector, mirror: Multivector) -> Multivector:
    """x reflected, or inverted, in a blade (thesis 1.3.4)."""
    return _value(versors.reflect(x, mirror))


def canonicalize_sign(r: Multivector) -> Multivector:
    """r or -r: <r>_0 >= 0, or the first coefficient that is not zero is positive."""
    return rotors.canonicalize_sign(r)


#: All of them, by name: what docs/algebra/kernels.md lists.
FUNCTIONS: dict[str, Callable[..., Multivector]] = {
    f.__name__: f
    for f in (
        exp, log, sqrt, inverse, versor_inverse, norm, normalize, nearest, project, rotor_between, interpolate, reflect,
        canonicalize_sign,
    )
}  # fmt: skip
__all__ = [*FUNCTIONS, "FUNCTIONS"]
