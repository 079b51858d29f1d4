"""Rotors between objects: the stable form beside the printed (2.4) with (2.11), and `clifford`'s."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from .... import objects
from ....codegen.formulas.motions.rotors import plain_rotor
from ....status import Status
from ...harness.algebras import cga3d
from ...harness.study import Array, Case, Errors, Study, errors_by_item, sweep_cases
from ...harness.vectors import directions, unit
from . import precise
from .peers import clifford_results, methods

#: Each pair is computed this many times in one call, so that the time is the loop's and not the call's.
COPIES = 100
#: Values of the sweeps.
DISTANCES = tuple(10.0**k for k in range(9))
GAPS = tuple(10.0**k for k in range(-12, 1, 2))


@dataclass(frozen=True)
class Pairs:
    """Two objects per item, by the arguments of their constructor (``cga3d.circle``, ...)."""

    constructor: str
    first: tuple[Array, ...]
    second: tuple[Array, ...]

    def __len__(self) -> int:
        return len(self.first[0])

    def as_multivectors(self, precision: str = "float64", copies: int = 1) -> list[Any]:
        """Both batches."""
        make = getattr(cga3d, self.constructor)
        return [
            make(*(np.concatenate([a] * copies).astype(precision) for a in parts))
            for parts in (self.first, self.second)
        ]

    def exact(self) -> list[tuple[Any, Any]]:
        """Both objects of each item with 50 digits."""
        return [
            tuple(precise.construct(self.constructor, *(a[i] for a in parts)) for parts in (self.first, self.second))
            for i in range(len(self))
        ]  # fmt: skip

    def describe(self, i: int) -> str:
        """Both objects of an item, by their parameters."""
        parts = (", ".join(str(a[i].tolist()) for a in parts) for parts in (self.first, self.second))
        return " and ".join(f"{self.constructor}({text})" for text in parts)


def circles(rng: np.random.Generator, count: int, distance: float = 0.0, apart: float = 1.0) -> Pairs:
    """Pairs of circles near a position at a distance from the origin; the second is the first moved by ``apart``."""
    position = distance * directions(rng, count)
    center, normal, radius = rng.normal(size=(count, 3)), directions(rng, count), rng.uniform(0.5, 2, count)
    second = (
        position + center + apart * rng.normal(size=(count, 3)),
        normal + apart * rng.normal(size=(count, 3)),
        radius * np.exp(apart * rng.normal(size=count) / 2),
    )
    return Pairs("circle", (position + center, normal, radius), second)


def circles_on_sphere(rng: np.random.Generator, count: int, off: float) -> Pairs:
    """Pairs of circles within ``off`` of a common sphere: the 4-vector of K nearly vanishes."""

    def circle() -> tuple[Array, ...]:
        axis, angle = directions(rng, count), rng.uniform(0.3, 1.4, count)
        return axis * np.cos(angle)[:, None], axis, np.sin(angle) + off * rng.normal(size=count)

    return Pairs("circle", circle(), circle())


def rotated_lines(rng: np.random.Generator, count: int, angle: float) -> Pairs:
    """Pairs of lines through a point, at an angle to each other."""
    m = directions(rng, count)
    across = unit(np.cross(m, directions(rng, count)))
    point = rng.normal(size=(count, 3))
    return Pairs("line", (point, m), (point, np.cos(angle) * m + np.sin(angle) * across))


def reversed_lines(rng: np.random.Generator, count: int) -> Pairs:
    """Pairs of a line and its reverse."""
    m, point = directions(rng, count), rng.normal(size=(count, 3))
    return Pairs("line", (point, m), (point, -m))


def spheres(rng: np.random.Generator, count: int) -> Pairs:
    """Pairs of spheres of any position: nested, meeting, apart."""
    first, second = ((2 * rng.normal(size=(count, 3)), rng.uniform(0.5, 2, count)) for _ in range(2))
    return Pairs("sphere", first, second)


def rows(x: Any, p: Pairs) -> Array:
    """Coefficients (count, 16) of the rotors of the first copy."""
    wide = x.as_kind(cga3d.kind("rotor_conformal").layout, check=False)
    return np.asarray(wide.values[: len(p)], float)


def run_stable(p: Pairs, precision: str) -> Array:
    """`objects.rotor_between`."""
    return rows(objects.rotor_between(*p.as_multivectors(precision, COPIES)), p)


def run_printed(p: Pairs, precision: str) -> Array:
    """(2.4) with beta by (2.11), and (2.6), (2.7) where the 4-vector is zero; the sign of S corrected."""
    x1, x2 = p.as_multivectors(precision, COPIES)
    gamma = -1.0 if p.constructor in ("sphere", "plane") else 1.0
    k = 2 + gamma * (x1 * x2 + x2 * x1)
    k0, k4 = k["1"], k.grade(4)
    with np.errstate(all="ignore"):
        if not k4.values.any():
            sign = np.where(k0 > 0, 1.0, -1.0)
            return rows((1 + gamma * sign * (x2 * x1)) / np.sqrt(np.abs(2 + sign * (k0 - 2))), p)
        lambda_ = -(k4 * k4)["1"]
        root = np.sqrt(k0 * k0 + lambda_)
        beta = np.sqrt((root - k0) / (2 * lambda_))
        s = 1 / (2 * beta) - beta * k4
        return rows((s * (1 + gamma * (x2 * x1))) / root, p)


def run_clifford(p: Pairs, _: None) -> Array:
    """`clifford.tools.g3c.rotor_between_objects`, one pair at a time."""
    from clifford.tools.g3c import rotor_between_objects

    return rows(clifford_results(rotor_between_objects, *p.as_multivectors()), p)


def truth(p: Pairs) -> list[tuple[Any, Any, Any]]:
    """Both objects and the rotor with 50 digits, from the parameters; no rotor where it is not unique."""
    triples = []
    for x1, x2 in p.exact():
        rotor = plain_rotor(x1, x2)
        # exactly opposite objects leave only the rounding of the 50 digits
        is_unique = np.isfinite(precise.size(rotor)) and precise.size(x1 + x2) > 1e-12 * precise.size(x1)
        triples.append((x1, x2, rotor if is_unique else None))
    return triples


def error(answer: Array, exact: list[tuple[Any, Any, Any]], _: Pairs) -> Errors:
    """The larger of two: how far R X1 ~R is from X2 or -X2, over max(1, |R|^2) and X2's size; and how far R is from
    the rotor of 50 digits, or its negative, over its size."""
    kind = cga3d.kind("rotor_conformal")

    def item_error(row: Array, true: tuple[Any, Any, Any]) -> float:
        (x1, x2, rotor), r = true, precise.multivector(kind, row)
        moved = r * x1 * ~r
        off = min(precise.size(moved - x2), precise.size(moved + x2)) / precise.size(x2)
        off /= max(1.0, precise.size(r) ** 2)
        if rotor is None:
            return off
        return max(off, min(precise.size(r - rotor), precise.size(r + rotor)) / precise.size(rotor))

    return errors_by_item(item_error, answer, exact)


def answer(result: Array, p: Pairs, i: int) -> str:
    """Description of the result if no rotor is unique."""
    status = objects.rotor_between(*p.as_multivectors()).status
    name = Status(np.asarray(status)[i]).name
    return f"R = {np.array2string(result[i], precision=4, suppress_small=True)}; bladesmith says {name}"


STUDY = Study(
    name="rotors",
    title="The rotor that takes one object to another",
    methods=methods("printed", run_stable, run_printed, run_clifford),
    cases=(
        Case("circles of any position", circles),
        Case("spheres of any position", spheres),
        Case("circles 1e-6 apart", partial(circles, apart=1e-6), "extreme"),
        Case("circles 1e-8 off a common sphere", partial(circles_on_sphere, off=1e-8), "extreme"),
        Case("lines turned by pi - 1e-4", partial(rotated_lines, angle=np.pi - 1e-4), "extreme"),
        Case("circles 1e6 from the origin", partial(circles, distance=1e6), "stiff"),
        Case("a line and its reverse", reversed_lines, "singular"),
        *sweep_cases("distance from the origin", DISTANCES, circles),
        *sweep_cases("lines: pi less the angle", GAPS, lambda rng, count, v: rotated_lines(rng, count, np.pi - v)),
        *sweep_cases("circles: distance from a common sphere", GAPS, circles_on_sphere),
    ),
    reference=truth,
    error=error,
    describe=Pairs.describe,
    unit="of the rotor's size",
    count=100,
    answer=answer,
    copies=COPIES,
    source="thesis 2.4, (2.4) to (2.7)",
    notes="The error is the larger of the object's and the rotor's own. Close to a half turn, or to a common sphere "
    "where K0 < 0, the rotor itself is determined to the rounding unit over the missing angle or distance only: that "
    "is the inputs' own condition, of which single precision leaves nothing. Each time includes making the objects.",
)
