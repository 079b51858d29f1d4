"""Rotors between objects: the stable form beside the printed (2.4) with (2.11), and `clifford`'s."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib.util import find_spec
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..study import Case, Errors, Method, Study, swept
from . import precise
from .distance import precision_dtype

Array = NDArray[np.float64]
#: Each pair is computed this many times in one call, so that the time is the loop's and not the call's.
COPIES = 100


#: Values of the sweeps.
DISTANCES = tuple(10.0**k for k in range(9))
GAPS = tuple(10.0**k for k in range(-12, 1, 2))


@dataclass(frozen=True)
class Pairs:
    """Two objects per item, by the arguments of their constructor (``cga3d.circle``, ...)."""

    maker: str
    first: tuple[Array, ...]
    second: tuple[Array, ...]


def units(rng: np.random.Generator, count: int) -> Array:
    """Random directions."""
    v = rng.normal(size=(count, 3))
    return np.asarray(v / np.linalg.norm(v, axis=1, keepdims=True))


def circles(distance: float = 0.0, apart: float = 1.0) -> Any:
    """Pairs of circles near a place at a distance from the origin; the second is the first moved by ``apart``."""

    def make(rng: np.random.Generator, count: int) -> Pairs:
        place = distance * units(rng, count)
        center, normal, radius = rng.normal(size=(count, 3)), units(rng, count), rng.uniform(0.5, 2, count)
        second = (
            place + center + apart * rng.normal(size=(count, 3)),
            normal + apart * rng.normal(size=(count, 3)),
            radius * np.exp(apart * rng.normal(size=count) / 2),
        )
        return Pairs("circle", (place + center, normal, radius), second)

    return make


def on_a_sphere(off: float) -> Any:
    """Pairs of circles within ``off`` of a common sphere: the 4-vector of K nearly vanishes."""

    def make(rng: np.random.Generator, count: int) -> Pairs:
        def circle() -> tuple[Array, ...]:
            axis, angle = units(rng, count), rng.uniform(0.3, 1.4, count)
            return axis * np.cos(angle)[:, None], axis, np.sin(angle) + off * rng.normal(size=count)

        return Pairs("circle", circle(), circle())

    return make


def turned_lines(angle: float) -> Any:
    """Pairs of lines through a point, turned against each other by an angle."""

    def make(rng: np.random.Generator, count: int) -> Pairs:
        m = units(rng, count)
        across = np.cross(m, units(rng, count))
        across /= np.linalg.norm(across, axis=1, keepdims=True)
        point = rng.normal(size=(count, 3))
        return Pairs("line", (point, m), (point, np.cos(angle) * m + np.sin(angle) * across))

    return make


def reversed_lines(rng: np.random.Generator, count: int) -> Pairs:
    """A line and the same line the other way."""
    m, point = units(rng, count), rng.normal(size=(count, 3))
    return Pairs("line", (point, m), (point, -m))


def spheres(rng: np.random.Generator, count: int) -> Pairs:
    """Pairs of spheres of any position: nested, meeting, apart."""

    def sphere() -> tuple[Array, ...]:
        return 2 * rng.normal(size=(count, 3)), rng.uniform(0.5, 2, count)

    return Pairs("sphere", sphere(), sphere())


def built(p: Pairs, precision: str, copies: int = 1) -> tuple[Any, Any]:
    """Both batches as multivectors."""
    from ... import cga3d

    dtype = precision_dtype(precision)
    make = getattr(cga3d, p.maker)
    first, second = (
        make(*(np.concatenate([a] * copies).astype(dtype) for a in parts)) for parts in (p.first, p.second)
    )
    return first, second


def rows(x: Any, p: Pairs) -> Array:
    """Coefficients (count, 16) of the rotors of the first copy."""
    from ... import cga3d

    wide = x.as_kind(cga3d.kind("rotor_conformal").layout, check=False)
    return np.asarray(wide.values[: len(p.first[0])], float)


def stable(p: Pairs, precision: str) -> Array:
    """`objects.rotor_between`."""
    from ... import objects

    return rows(objects.rotor_between(*built(p, precision, COPIES)), p)


def printed(p: Pairs, precision: str) -> Array:
    """(2.4) with beta by (2.11), and (2.6), (2.7) where the 4-vector is zero; the sign of S corrected."""
    x1, x2 = built(p, precision, COPIES)
    gamma = -1.0 if p.maker in ("sphere", "plane") else 1.0
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


def with_clifford(p: Pairs, _: Any) -> Array:
    """`clifford.tools.g3c.rotor_between_objects`, one pair at a time."""
    from clifford.g3c import layout
    from clifford.tools.g3c import rotor_between_objects

    from ... import cga3d, from_clifford

    x1, x2 = (x.to_clifford(layout) for x in built(p, "float64"))
    with np.errstate(all="ignore"):
        found = [rotor_between_objects(a, b) for a, b in zip(x1, x2, strict=True)]
    return rows(from_clifford(found, algebra=cga3d), p)


def truth(p: Pairs) -> list[tuple[Any, Any, Any]]:
    """Both objects and the rotor with 50 digits, from the parameters; no rotor where it is not unique."""
    from ...codegen.formulas.rotors import plain_rotor

    def exact(parts: tuple[Array, ...], i: int) -> Any:
        return precise.made(p.maker, *(a[i] for a in parts))

    found = []
    for i in range(len(p.first[0])):
        x1, x2 = exact(p.first, i), exact(p.second, i)
        rotor = plain_rotor(x1, x2)
        # exactly opposite objects leave only the rounding of the 50 digits
        known = np.isfinite(precise.size(rotor)) and precise.size(x1 + x2) > 1e-12 * precise.size(x1)
        found.append((x1, x2, rotor if known else None))
    return found


def error(answer: Array, exact: list[tuple[Any, Any, Any]], _: Pairs) -> Errors:
    """The larger of two: how far R X1 ~R is from X2 or -X2, over max(1, |R|^2) and X2's size; and how far R is from
    the rotor of 50 digits, or its negative, over its size."""
    from ... import cga3d

    kind = cga3d.kind("rotor_conformal")
    found = []
    for row, (x1, x2, rotor) in zip(answer, exact, strict=True):
        if not np.isfinite(row).all():
            found.append(np.inf)
            continue
        r = precise.multivector(kind, row)
        moved = r * x1 * ~r
        off = min(precise.size(moved - x2), precise.size(moved + x2)) / precise.size(x2)
        off /= max(1.0, precise.size(r) ** 2)
        if rotor is not None:
            off = max(off, min(precise.size(r - rotor), precise.size(r + rotor)) / precise.size(rotor))
        found.append(off)
    return np.array(found)


def describe(p: Pairs, i: int) -> str:
    """Both objects, by their parameters."""
    first, second = (", ".join(str(a[i].tolist()) for a in parts) for parts in (p.first, p.second))
    return f"{p.maker}({first}) and {p.maker}({second})"


def answer(result: Array, p: Pairs, i: int) -> str:
    """What came out where no rotor is unique."""
    from ... import Status, objects

    status = objects.rotor_between(*built(p, "float64")).status
    return (
        f"R = {np.array2string(result[i], precision=4, suppress_small=True)}; bladesmith says {Status(status[i]).name}"
    )


Run = Callable[[Pairs, Any], Array]


def methods(ours: Run, as_printed: Run, theirs: Run) -> tuple[Method, ...]:
    """Ours, the printed form, and `clifford`'s where it is installed."""
    found: tuple[Method, ...] = (
        Method("bladesmith", ours, "precision", ("float32", "float64")),
        Method("printed", as_printed, "precision", ("float32", "float64")),
    )
    if find_spec("clifford") is not None:
        found += (Method("clifford", theirs, slow=True, copies=1),)
    return found


STUDY = Study(
    name="rotors",
    title="The rotor that takes one object to another",
    methods=methods(stable, printed, with_clifford),
    cases=(
        Case("circles of any position", circles(), "ordinary", describe),
        Case("spheres of any position", spheres, "ordinary", describe),
        Case("circles 1e-6 apart", circles(apart=1e-6), "extreme", describe),
        Case("circles 1e-8 off a common sphere", on_a_sphere(1e-8), "extreme", describe),
        Case("lines turned by pi - 1e-4", turned_lines(np.pi - 1e-4), "extreme", describe),
        Case("circles 1e6 from the origin", circles(distance=1e6), "stiff", describe),
        Case("a line and its reverse", reversed_lines, "singular", describe),
        *swept("distance from the origin", DISTANCES, circles, describe),
        *swept("lines: pi less the angle", GAPS, lambda v: turned_lines(np.pi - v), describe),
        *swept("circles: distance from a common sphere", GAPS, on_a_sphere, describe),
    ),
    reference=truth,
    error=error,
    unit="of the rotor's size",
    count=100,
    answer=answer,
    copies=COPIES,
    source="thesis 2.4, (2.4) to (2.7)",
    notes="The error is the larger of the object's and the rotor's own. Close to a half turn, or to a common sphere "
    "where K0 < 0, the rotor itself is determined to the rounding unit over the missing angle or distance only: that "
    "is the inputs' own condition, of which single precision leaves nothing. Each time includes making the objects.",
)
