"""The geometric product of two motors, against the distance from the origin of the place that they turn about."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..study import Case, Errors, Method, Study
from .distance import precision_dtype

Array = NDArray[np.float64]


#: Each product is computed this many times in one call, so that the time is the loop's and not the call's.
COPIES = 20


@dataclass(frozen=True)
class Pairs:
    """Coefficients of two motors each, on the null basis, exact as they are."""

    first: Array
    second: Array


def pairs(distance: float) -> Any:
    """Maker of pairs of rotations about axes near a place at a distance."""

    def make(rng: np.random.Generator, count: int) -> Pairs:
        from ... import cga3d

        away = rng.normal(size=(count, 3))
        place = distance * away / np.linalg.norm(away, axis=1, keepdims=True)
        motors = [
            cga3d.rotor(
                rng.normal(size=(count, 3)), rng.uniform(-3, 3, count), point=place + rng.normal(size=(count, 3))
            )
            for _ in range(2)
        ]
        # single precision holds them exactly too, so that every method starts from the same motors
        return Pairs(*(m.values.astype(np.float32).astype(np.float64) for m in motors))

    return make


def truth(inputs: Pairs) -> list[list[Fraction]]:
    """Exact products, in rational arithmetic on the blade table."""
    from ... import cga3d
    from ...codegen.multivector import from_values
    from ...codegen.rings import RationalRing

    kind, ring, rows = cga3d.kind("motor"), RationalRing(), []
    for a, b in zip(inputs.first, inputs.second, strict=True):
        x, y = (from_values(cga3d, ring, kind.blades, [Fraction(float(v)) for v in m]) for m in (a, b))
        rows.append(kind.values(x * y))
    return rows


def error(answer: Array, exact: list[list[Fraction]], _: Pairs) -> Errors:
    """Largest coefficient error: half a displacement, in body sizes."""
    return np.array(
        [
            float(max(abs(Fraction(float(v)) - t) for v, t in zip(row, true, strict=True)))
            if np.all(np.isfinite(row))
            else np.inf
            for row, true in zip(answer, exact, strict=True)
        ]
    )


def repeated(method: Callable[[Pairs, str], Array]) -> Callable[[Pairs, str], Array]:
    """The method on COPIES copies of the motors; the products of the first."""

    def run(inputs: Pairs, precision: str) -> Array:
        copies = Pairs(*(np.tile(a, (COPIES, 1)) for a in (inputs.first, inputs.second)))
        return method(copies, precision)[: len(inputs.first)]

    return run


def null_basis(inputs: Pairs, precision: str) -> Array:
    """The compiled product of motors."""
    from ... import cga3d

    dtype = precision_dtype(precision)
    a, b = (cga3d.wrap(cga3d.kind("motor"), m.astype(dtype)) for m in (inputs.first, inputs.second))
    return np.asarray((a * b).values, float)


def orthonormal_basis(inputs: Pairs, precision: str) -> Array:
    """The product on e1 e2 e3 e+ e-, read back on the null basis."""
    from ... import cga3d

    dtype = precision_dtype(precision)
    motor = cga3d.kind("motor")
    a, b = (cga3d.wrap(motor, m).to_basis("orthonormal").astype(dtype) for m in (inputs.first, inputs.second))
    product = a * b
    # a motor's e_i n_inf is e_i e+ + e_i e-: its coefficient is that of e_i e+ (e4) as well as that of e_i e- (e5)
    names = [cga3d.blade_name(blade).replace("ni", "4") for blade in motor.blades]
    return np.stack([np.asarray(product[name], float) for name in names], -1)


def describe(inputs: Pairs, i: int) -> str:
    """Both motors, in full."""
    return f"motors {inputs.first[i].tolist()} and {inputs.second[i].tolist()}"


STUDY = Study(
    name="products",
    title="The geometric product of two motors, against the distance from the origin",
    methods=(
        Method("null basis", repeated(null_basis), "precision", ("float32", "float64")),
        Method("orthonormal basis", repeated(orthonormal_basis), "precision", ("float32", "float64")),
    ),
    cases=(
        Case("distance 1", pairs(1.0), "ordinary", describe),
        Case("distance 1e3", pairs(1e3), "stiff", describe),
        Case("distance 1e6", pairs(1e6), "extreme", describe),
    ),
    reference=truth,
    error=error,
    unit="in body sizes",
    count=1000,
    copies=COPIES,
    source="thesis 1.2.2",
    notes="On the null basis a translation is one coefficient; on the orthonormal one it is two, whose products "
    "cancel: 48 products of coefficients instead of 144. "
    "Each time includes the conversions of the inputs and of the result.",
)
