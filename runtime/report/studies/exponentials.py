"""Motions for the studies of exponential and logarithm: from 1e-16 to nearly 2 pi, with translation and dilation.

Beside the kernels stand what people write: the textbook's closed forms (acos, and a division by the angle), and the
functions of the package `clifford`, where it is installed.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib.util import find_spec
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..study import Case, Errors, Method, swept
from . import precise
from .distance import precision_dtype

Array = NDArray[np.float64]
#: Each item is computed this many times in one call, so that the time is the loop's and not the call's.
COPIES = 100


@dataclass(frozen=True)
class Motions:
    """Bivectors (n, k) of a kind, and the rotors (n, m) that they are the logarithms of; both exact as they are."""

    bivectors: Array
    rotors: Array
    bivector_kind: str
    rotor_kind: str


def motions(angle: Callable[[np.random.Generator, int], Array], translation: float, dilation: float = 0.0) -> Any:
    """Maker of screw motions about random axes, with a dilation about a random point where it is not zero."""

    def make(rng: np.random.Generator, count: int) -> Motions:
        from ... import cga3d

        axis = rng.normal(size=(count, 3))
        axis /= np.linalg.norm(axis, axis=1, keepdims=True)
        place = rng.normal(size=(count, 3))
        turn = cga3d.line(place, axis).dual() * (-angle(rng, count) / 2)
        moved = cga3d.direction(axis * (translation * rng.uniform(0.5, 1, (count, 1)) / -2))
        generator = turn + moved
        if dilation:
            about = cga3d.flat_point(place) * (dilation * rng.uniform(0.5, 1, count) / 2)
            generator = turn + about  # they commute: the centre is on the axis
        names = ("bivector", "rotor_conformal") if dilation else ("twist", "motor")
        bivector, rotor = (cga3d.kind(name) for name in names)
        rows = generator.as_kind(bivector, check=False).values
        exact = [precise.exponential(b) for b in precise.multivectors(bivector, rows)]
        return Motions(rows, precise.rounded(rotor, exact), *names)

    return make


def fixed(angle: float) -> Callable[[np.random.Generator, int], Array]:
    """The same angle for all."""
    return lambda rng, count: np.full(count, angle)


def any_angle(rng: np.random.Generator, count: int) -> Array:
    """Angles from 0 to 2 pi."""
    return rng.uniform(0, 2 * np.pi, count)


def tiny(rng: np.random.Generator, count: int) -> Array:
    """Angles from 1e-16 to 1e-4, evenly in their logarithm."""
    return np.asarray(10.0 ** rng.uniform(-16, -4, count))


#: Angles from 1e-16 to 1, and as much short of a full turn.
DECADES = tuple(10.0**k for k in range(-16, 1, 2))


def item(m: Motions, i: int) -> str:
    """The bivector of one motion."""
    return f"bivector {m.bivectors[i].tolist()}"


CASES = (
    Case("any angle", motions(any_angle, 1.0), "ordinary"),
    Case("any angle, with dilation", motions(any_angle, 0.0, 1.0), "ordinary"),
    Case("angles 1e-16 to 1e-4", motions(tiny, 1.0), "extreme"),
    Case("angle pi", motions(fixed(np.pi), 1.0), "extreme"),
    Case("angle 2 pi - 1e-6", motions(fixed(2 * np.pi - 1e-6), 0.0), "extreme"),
    Case("rotation 1e-6, translation 1e6", motions(fixed(1e-6), 1e6), "stiff"),
    Case("translation only", motions(fixed(0.0), 1.0), "singular"),
    *swept("angle", DECADES, lambda v: motions(fixed(v), 1.0), item),
    *swept("2 pi less the angle", DECADES, lambda v: motions(fixed(2 * np.pi - v), 0.0), item),
)


def kernels(function: str) -> Callable[[Motions, str], Array]:
    """`Multivector.exp` or `.log` in one precision."""

    def run(m: Motions, precision: str) -> Array:
        from ... import cga3d

        rows, name = (m.bivectors, m.bivector_kind) if function == "exp" else (m.rotors, m.rotor_kind)
        wanted = cga3d.kind(m.rotor_kind if function == "exp" else m.bivector_kind)
        x = cga3d.wrap(cga3d.kind(name), np.tile(rows, (COPIES, 1)).astype(precision_dtype(precision)))
        result = x.exp() if function == "exp" else x.log()
        return np.asarray(result.as_kind(wanted, check=False).values[: len(rows)], float)

    return run


def textbook_exp(m: Motions, precision: str) -> Array | None:
    """exp of a motor's bivector by its axis, as in textbooks: it divides by the angle."""
    from ... import cga3d

    def run(b: Any) -> Any:
        square = b * b
        w, q = -square.grade(0)["1"], square.grade(4)
        with np.errstate(all="ignore"):
            phi = np.sqrt(w)
            sinc = np.sin(phi) / phi
            return np.cos(phi) + sinc * b + sinc / 2 * q + (sinc - np.cos(phi)) / (2 * w) * (q * b).grade(2)

    return _on_motors(m.bivectors, "twist", "motor", m, precision, run, cga3d)


def textbook_log(m: Motions, precision: str) -> Array | None:
    """log of a motor by acos of its scalar part, as in textbooks."""
    from ... import cga3d

    def run(r: Any) -> Any:
        with np.errstate(all="ignore"):
            phi = np.arccos(np.clip(r["1"], -1, 1))
            sine = np.sin(phi)
            v, q = r.grade(2), r.grade(4)
            return phi / sine * v + (phi * np.cos(phi) - sine) / sine**3 * (q * v).grade(2)

    return _on_motors(m.rotors, "motor", "twist", m, precision, run, cga3d)


def _on_motors(
    rows: Array, given: str, wanted: str, m: Motions, precision: str, run: Any, algebra: Any
) -> Array | None:
    """Run a closed form for motors; None: it is not made for rotors with dilation."""
    if m.rotor_kind != "motor":
        return None
    x = algebra.wrap(algebra.kind(given).layout, np.tile(rows, (COPIES, 1)).astype(precision_dtype(precision)))
    kind = algebra.kind(wanted)
    return np.asarray(run(x).as_kind(kind.layout, check=False).values[: len(rows)], float)


def with_clifford(function: str) -> Callable[[Motions, Any], Array]:
    """The functions of `clifford.tools.g3c`, one multivector at a time; their time is of one call each."""

    def run(m: Motions, _: Any) -> Array:
        from clifford.g3c import layout
        from clifford.tools.g3c.rotor_parameterisation import ga_exp, ga_log, general_logarithm

        from ... import cga3d, from_clifford

        rows, name = (m.bivectors, m.bivector_kind) if function == "exp" else (m.rotors, m.rotor_kind)
        wanted = cga3d.kind(m.rotor_kind if function == "exp" else m.bivector_kind)
        general = general_logarithm if m.rotor_kind == "rotor_conformal" else ga_log
        call = ga_exp if function == "exp" else general
        given = cga3d.wrap(cga3d.kind(name), rows).to_clifford(layout)
        with np.errstate(all="ignore"):
            found = [_attempt(call, x, layout) for x in given]
        back = from_clifford(found, algebra=cga3d)
        return np.asarray(back.as_kind(wanted.layout, check=False).values, float)

    return run


def _attempt(call: Callable[[Any], Any], x: Any, layout: Any) -> Any:
    """Where it raises, it has no answer."""
    try:
        return call(x)
    except (ArithmeticError, ValueError, TypeError, np.linalg.LinAlgError):
        return layout.MultiVector(np.full(layout.gaDims, np.nan))


def methods(function: str, textbook: Callable[[Motions, str], Array | None]) -> tuple[Method, ...]:
    """Ours and theirs; `clifford` where it is installed, in full runs (it compiles for some seconds)."""
    found: tuple[Method, ...] = (
        Method("bladesmith", kernels(function), "precision", ("float32", "float64")),
        Method("textbook", textbook, "precision", ("float32", "float64")),
    )
    if find_spec("clifford") is not None:
        found += (Method("clifford", with_clifford(function), slow=True, copies=1),)
    return found


def in_words(status_of: str) -> Callable[[Array, Motions, int], str]:
    """What came out at a singular input."""
    return lambda result, m, i: f"{status_of} = {np.array2string(result[i], precision=6)}"


def exp_error(answer: Array, exact: list[Any], m: Motions) -> Errors:
    """|exp(b) - truth| over the truth's largest coefficient (at least 1)."""
    from ... import cga3d

    kind = cga3d.kind(m.rotor_kind)
    return _per_item(answer, exact, lambda row, true: precise.difference(precise.multivector(kind, row), true))


def log_error(answer: Array, rotors: list[Any], m: Motions) -> Errors:
    """|exp(answer) - R| over R's largest coefficient (at least 1), exp with 50 digits: every logarithm counts."""
    from ... import cga3d

    kind = cga3d.kind(m.bivector_kind)
    return _per_item(
        answer, rotors, lambda row, r: precise.difference(precise.exponential(precise.multivector(kind, row)), r)
    )


def _per_item(answer: Array, truth: list[Any], error: Callable[[Any, Any], float]) -> Errors:
    """The error of each item; infinite where the answer is not finite."""
    return np.array(
        [error(row, true) if np.isfinite(row).all() else np.inf for row, true in zip(answer, truth, strict=True)]
    )
