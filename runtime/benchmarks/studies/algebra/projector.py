"""Projection of a blend of two objects to the blade manifold: the stable form beside the printed one."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..study import Case, Errors, Study, swept
from . import precise
from .rotors import (
    COPIES,
    DISTANCES,
    GAPS,
    Pairs,
    built,
    circles,
    describe,
    methods,
    on_a_sphere,
    reversed_lines,
    spheres,
    units,
)

Array = NDArray[np.float64]


def opposed(rng: np.random.Generator, count: int) -> Pairs:
    """Circles of opposite orientation, tilted: the scalar part of Sigma is often negative."""
    pair = circles()(rng, count)
    center, normal, radius = pair.first
    tilt = -normal + 0.3 * units(rng, count)
    return Pairs("circle", pair.first, (center + 1.5 * units(rng, count), tilt, radius * rng.uniform(0.5, 1.5, count)))


def rows(x: Any, p: Pairs) -> Array:
    """Coefficients of the first copy on all blades of the grade."""
    from ... import cga3d

    wide = cga3d.kind("quadvector" if p.maker in ("sphere", "plane") else "trivector")
    return np.asarray(x.as_kind(wide, check=False).values[: len(p.first[0])], float)


def stable(p: Pairs, precision: str) -> Array:
    """`objects.interpolate` half way."""
    from ... import objects

    return rows(objects.interpolate(*built(p, precision, COPIES), alpha=0.5), p)


def printed(p: Pairs, precision: str) -> Array:
    """(3.4) to (3.7) as printed, with the upper sign of the root and the tilde in Sigma."""
    x1, x2 = built(p, precision, COPIES)
    x = 0.5 * x1 + 0.5 * x2
    sigma = -(x * ~x)
    s0, s4 = sigma["1"], sigma.grade(4)
    with np.errstate(all="ignore"):
        norm = np.sqrt(s0 * s0 - (s4 * s4)["1"])
        root = (norm + sigma) / (np.sqrt(2.0).astype(norm.dtype) * np.sqrt(s0 + norm))  # k S^-
        other = root.grade(0) - root.grade(4)  # k S
        return rows((other / (other * root)["1"] * x).grade(*x.grades), p)


def with_clifford(p: Pairs, _: Any) -> Array:
    """`clifford.tools.g3c.average_objects`, one pair at a time."""
    from clifford.g3c import layout
    from clifford.tools.g3c import average_objects

    from ... import cga3d, from_clifford

    x1, x2 = (x.to_clifford(layout) for x in built(p, "float64"))
    with np.errstate(all="ignore"):
        found = [average_objects([a, b], check_grades=False) for a, b in zip(x1, x2, strict=True)]
    return rows(from_clifford(found, algebra=cga3d), p)


def truth(p: Pairs) -> list[Any]:
    """The projected blend with 50 digits, from the parameters; None where it is no real object."""
    from ...codegen.formulas.blades import project_to_blade

    def exact(parts: tuple[Array, ...], i: int) -> Any:
        return precise.made(p.maker, *(a[i] for a in parts))

    found = []
    for i in range(len(p.first[0])):
        blade = project_to_blade((exact(p.first, i) + exact(p.second, i)) / 2)
        found.append(blade if np.isfinite(precise.size(blade)) else None)
    return found


def error(found: Array, exact: list[Any], p: Pairs) -> Errors:
    """Largest coefficient error over the blade's size; an object where there is none is a false answer."""
    from ... import cga3d

    kind = cga3d.kind("quadvector" if p.maker in ("sphere", "plane") else "trivector")
    errors = []
    for row, true in zip(found, exact, strict=True):
        finite = bool(np.isfinite(row).all())
        if true is None or not finite:
            errors.append(np.inf if finite or true is not None else 0.0)
        else:
            errors.append(precise.size(precise.multivector(kind, row) - true) / precise.size(true))
    return np.array(errors)


def in_words(result: Array, p: Pairs, i: int) -> str:
    """What came out at a singular input."""
    from ... import Status, objects

    status = objects.interpolate(*built(p, "float64"), alpha=0.5).status
    return f"{np.array2string(result[i], precision=4, suppress_small=True)}; bladesmith says {Status(status[i]).name}"


STUDY = Study(
    name="projector",
    title="The projection of a blend to the blade manifold",
    methods=methods(stable, printed, with_clifford),
    cases=(
        Case("circles of any position", circles(), "ordinary", describe),
        Case("spheres, some imaginary", spheres, "ordinary", describe),
        Case("circles of opposite orientation", opposed, "extreme", describe),
        Case("circles 1e-8 off a common sphere", on_a_sphere(1e-8), "extreme", describe),
        Case("circles 1e6 from the origin", circles(distance=1e6), "stiff", describe),
        Case("a line and its reverse", reversed_lines, "singular", describe),
        *swept("distance from the origin", DISTANCES, circles, describe),
        *swept("circles: distance from a common sphere", GAPS, on_a_sphere, describe),
    ),
    reference=truth,
    error=error,
    unit="of the blade's largest coefficient",
    count=100,
    answer=in_words,
    copies=COPIES,
    source="thesis 3.5, (3.4) to (3.7)",
    notes="An object given where the interpolant is imaginary counts as lost. Each time includes making the objects.",
)
