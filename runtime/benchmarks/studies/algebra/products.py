"""The geometric product of two motors, against the distance from the origin of the axes of their rotations."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from functools import partial

import numpy as np

from ....codegen.algebra.multivector import from_values
from ....codegen.rings.protocol import RationalRing
from ...harness.algebras import cga3d
from ...harness.study import PRECISIONS, Array, Case, Errors, Method, Study, errors_by_item, on_copies
from .distance import distance_vectors

#: Each product is computed this many times in one call, so that the time is the loop's and not the call's.
COPIES = 20


@dataclass(frozen=True)
class Pairs:
    """Coefficients of two motors each, on the null basis, exact as they are."""

    first: Array
    second: Array


def pairs(rng: np.random.Generator, count: int, distance: float) -> Pairs:
    """Pairs of rotations about axes near a position at a distance."""
    position = distance_vectors(rng, count, distance)
    motors = [
        cga3d.rotor(
            rng.normal(size=(count, 3)), rng.uniform(-3, 3, count), point=position + rng.normal(size=(count, 3))
        )
        for _ in range(2)
    ]
    # single precision holds them exactly too, so that every method starts from the same motors
    return Pairs(*(m.values.astype(np.float32).astype(np.float64) for m in motors))


def truth(inputs: Pairs) -> list[list[Fraction]]:
    """Exact products, in rational arithmetic on the blade table."""
    kind, ring, rows = cga3d.kind("motor"), RationalRing(), []
    for a, b in zip(inputs.first, inputs.second, strict=True):
        x, y = (from_values(cga3d, ring, kind.blades, [Fraction(float(v)) for v in m]) for m in (a, b))
        rows.append(kind.values(x * y))
    return rows


def error(answer: Array, exact: list[list[Fraction]], _: Pairs) -> Errors:
    """Largest coefficient error: half a displacement, in body sizes."""
    return errors_by_item(
        lambda row, true: float(max(abs(Fraction(float(v)) - t) for v, t in zip(row, true, strict=True))), answer, exact
    )


def null_basis(inputs: Pairs, precision: str) -> Array:
    """The compiled product of motors."""
    a, b = (cga3d.wrap(cga3d.kind("motor"), m.astype(precision)) for m in (inputs.first, inputs.second))
    return np.asarray((a * b).values, float)


def orthonormal_basis(inputs: Pairs, precision: str) -> Array:
    """The product on e1 e2 e3 e+ e-, read back on the null basis."""
    motor = cga3d.kind("motor")
    a, b = (cga3d.wrap(motor, m).to_basis("orthonormal").astype(precision) for m in (inputs.first, inputs.second))
    product = a * b
    # a motor's e_i n_inf is e_i e+ + e_i e-: its coefficient is that of e_i e+ (e4) as well as that of e_i e- (e5)
    names = [cga3d.blade_name(blade).replace("ni", "4") for blade in motor.blades]
    return np.stack([np.asarray(product[name], float) for name in names], -1)


STUDY = Study(
    name="products",
    title="The geometric product of two motors, against the distance from the origin",
    methods=(
        Method("null basis", on_copies(null_basis, COPIES), "precision", PRECISIONS),
        Method("orthonormal basis", on_copies(orthonormal_basis, COPIES), "precision", PRECISIONS),
    ),
    cases=(
        Case("distance 1", partial(pairs, distance=1.0)),
        Case("distance 1e3", partial(pairs, distance=1e3), "stiff"),
        Case("distance 1e6", partial(pairs, distance=1e6), "extreme"),
    ),
    reference=truth,
    error=error,
    describe=lambda inputs, i: f"motors {inputs.first[i].tolist()} and {inputs.second[i].tolist()}",
    unit="in body sizes",
    count=1000,
    copies=COPIES,
    source="thesis 1.2.2",
    notes="On the null basis a translation is one coefficient; on the orthonormal one it is two, whose products "
    "cancel: 48 products of coefficients instead of 144. "
    "Each time includes the conversions of the inputs and of the result.",
)
