"""Studies of exponential and logarithm on motions from 1e-16 to nearly 2 pi, with translation and dilation.

Beside the kernels stand what people write: the textbook's closed forms (acos, and a division by the angle), and the
functions of the package `clifford`, where it is installed.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from ...harness.algebras import cga3d
from ...harness.study import Array, Case, Errors, Study, errors_by_item, sweep_cases
from ...harness.vectors import directions
from . import precise
from .peers import clifford_results, methods

#: Each item is computed this many times in one call, so that the time is the loop's and not the call's.
COPIES = 100
#: Angles from 1e-16 to 1, and as much short of a full turn.
DECADES = tuple(10.0**k for k in range(-16, 1, 2))


@dataclass(frozen=True)
class Motions:
    """Bivectors (n, k) of a kind, and the rotors (n, m) that they are the logarithms of; both exact as they are."""

    bivectors: Array
    rotors: Array
    bivector_kind: str
    rotor_kind: str

    def operand(self, function: str) -> tuple[Array, str, str]:
        """Coefficients that exp or log is applied to, their kind, and the kind of the result."""
        if function == "exp":
            return self.bivectors, self.bivector_kind, self.rotor_kind
        return self.rotors, self.rotor_kind, self.bivector_kind


def motions(
    rng: np.random.Generator, count: int, angle: float | Callable[..., Array], translation: float, dilation: float = 0.0
) -> Motions:
    """Screw motions about random axes, with a dilation about a random point where it is not zero."""
    axis, position = directions(rng, count), rng.normal(size=(count, 3))
    angles = angle(rng, count) if callable(angle) else np.full(count, angle)
    generator = cga3d.line(position, axis).dual() * (-angles / 2)
    shift = cga3d.direction(axis * (translation * rng.uniform(0.5, 1, (count, 1)) / -2))
    if dilation:  # commutes with the rotation: the center is on the axis
        generator = generator + cga3d.flat_point(position) * (dilation * rng.uniform(0.5, 1, count) / 2)
    else:
        generator = generator + shift
    names = ("bivector", "rotor_conformal") if dilation else ("twist", "motor")
    bivector, rotor = (cga3d.kind(name) for name in names)
    rows = generator.as_kind(bivector, check=False).values
    exact = [precise.exponential(b) for b in precise.multivectors(bivector, rows)]
    return Motions(rows, precise.to_floats(rotor, exact), *names)


def any_angle(rng: np.random.Generator, count: int) -> Array:
    """Angles from 0 to 2 pi."""
    return rng.uniform(0, 2 * np.pi, count)


def tiny(rng: np.random.Generator, count: int) -> Array:
    """Angles from 1e-16 to 1e-4, evenly in their logarithm."""
    return np.asarray(10.0 ** rng.uniform(-16, -4, count))


def values(result: Any, kind: str, count: int) -> Array:
    """Coefficients of the first results, as of a kind."""
    return np.asarray(result.as_kind(cga3d.kind(kind).layout, check=False).values[:count], float)


def run_kernel(m: Motions, precision: str, *, function: str) -> Array:
    """`Multivector.exp` or `.log` in one precision."""
    rows, kind, result = m.operand(function)
    x = cga3d.wrap(cga3d.kind(kind), np.tile(rows, (COPIES, 1)).astype(precision))
    return values(getattr(x, function)(), result, len(rows))


def run_textbook(m: Motions, precision: str, *, function: str) -> Array | None:
    """A closed form for motors; None: it is not made for rotors with dilation."""
    if m.rotor_kind != "motor":
        return None
    rows, kind, result = m.operand(function)
    x = cga3d.wrap(cga3d.kind(kind).layout, np.tile(rows, (COPIES, 1)).astype(precision))
    with np.errstate(all="ignore"):
        return values((textbook_exp if function == "exp" else textbook_log)(x), result, len(rows))


def textbook_exp(b: Any) -> Any:
    """exp of a motor's bivector by its axis, as in textbooks: it divides by the angle."""
    square = b * b
    w, q = -square.grade(0)["1"], square.grade(4)
    phi = np.sqrt(w)
    sinc = np.sin(phi) / phi
    return np.cos(phi) + sinc * b + sinc / 2 * q + (sinc - np.cos(phi)) / (2 * w) * (q * b).grade(2)


def textbook_log(r: Any) -> Any:
    """log of a motor by acos of its scalar part, as in textbooks."""
    phi = np.arccos(np.clip(r["1"], -1, 1))
    sine = np.sin(phi)
    v, q = r.grade(2), r.grade(4)
    return phi / sine * v + (phi * np.cos(phi) - sine) / sine**3 * (q * v).grade(2)


def run_clifford(m: Motions, _: None, *, function: str) -> Array:
    """The functions of `clifford.tools.g3c`, one multivector at a time; their time is of one call each."""
    from clifford.tools.g3c.rotor_parameterisation import ga_exp, ga_log, general_logarithm

    rows, kind, result = m.operand(function)
    logarithm = general_logarithm if m.rotor_kind == "rotor_conformal" else ga_log
    found = clifford_results(ga_exp if function == "exp" else logarithm, cga3d.wrap(cga3d.kind(kind), rows))
    return values(found, result, len(rows))


def exp_error(answer: Array, exact: list[Any], m: Motions) -> Errors:
    """|exp(b) - truth| over the truth's largest coefficient (at least 1)."""
    kind = cga3d.kind(m.rotor_kind)
    return errors_by_item(lambda row, true: precise.difference(precise.multivector(kind, row), true), answer, exact)


def log_error(answer: Array, rotors: list[Any], m: Motions) -> Errors:
    """|exp(answer) - R| over R's largest coefficient (at least 1), exp with 50 digits: every logarithm counts."""
    kind = cga3d.kind(m.bivector_kind)

    def error(row: Array, rotor: Any) -> float:
        return precise.difference(precise.exponential(precise.multivector(kind, row)), rotor)

    return errors_by_item(error, answer, rotors)


def study(function: str, **options: Any) -> Study:
    """The study of a function, exp or log; options are those of `Study` that are its own."""
    runs = (partial(run, function=function) for run in (run_kernel, run_textbook, run_clifford))
    return Study(
        methods=methods("textbook", *runs),
        cases=(
            Case("any angle", partial(motions, angle=any_angle, translation=1.0)),
            Case("any angle, with dilation", partial(motions, angle=any_angle, translation=0.0, dilation=1.0)),
            Case("angles 1e-16 to 1e-4", partial(motions, angle=tiny, translation=1.0), "extreme"),
            Case("angle pi", partial(motions, angle=np.pi, translation=1.0), "extreme"),
            Case("angle 2 pi - 1e-6", partial(motions, angle=2 * np.pi - 1e-6, translation=0.0), "extreme"),
            Case("rotation 1e-6, translation 1e6", partial(motions, angle=1e-6, translation=1e6), "stiff"),
            Case("translation only", partial(motions, angle=0.0, translation=1.0), "singular"),
            *sweep_cases("angle", DECADES, partial(motions, translation=1.0)),
            *sweep_cases("2 pi less the angle", DECADES, lambda rng, count, v: motions(rng, count, 2 * np.pi - v, 0.0)),
        ),
        describe=lambda m, i: f"bivector {m.bivectors[i].tolist()}",
        unit="of the rotor's largest coefficient",
        count=100,
        answer=lambda result, m, i: f"{function} = {np.array2string(result[i], precision=6)}",
        copies=COPIES,
        **options,
    )
