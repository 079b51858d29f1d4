"""Projection of a blend of two objects to the blade manifold: the stable form beside the printed one."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from .... import objects
from ....codegen.formulas.objects.blades import project_to_blade
from ....status import Status
from ...harness.algebras import cga3d
from ...harness.study import Array, Case, Errors, Study, sweep_cases
from ...harness.vectors import directions
from . import precise
from .peers import clifford_results, methods
from .rotors import COPIES, DISTANCES, GAPS, Pairs, circles, circles_on_sphere, reversed_lines, spheres


def opposite_circles(rng: np.random.Generator, count: int) -> Pairs:
    """Circles of opposite orientation, tilted: the scalar part of Sigma is often negative."""
    first = circles(rng, count).first
    center, normal, radius = first
    tilt = -normal + 0.3 * directions(rng, count)
    second = (center + 1.5 * directions(rng, count), tilt, radius * rng.uniform(0.5, 1.5, count))
    return Pairs("circle", first, second)


def blade_kind(p: Pairs) -> Any:
    """Kind of all blades of the objects' grade."""
    return cga3d.kind("quadvector" if p.constructor in ("sphere", "plane") else "trivector")


def rows(x: Any, p: Pairs) -> Array:
    """Coefficients of the first copy on all blades of the grade."""
    return np.asarray(x.as_kind(blade_kind(p), check=False).values[: len(p)], float)


def run_stable(p: Pairs, precision: str) -> Array:
    """`objects.interpolate` half way."""
    return rows(objects.interpolate(*p.as_multivectors(precision, COPIES), alpha=0.5), p)


def run_printed(p: Pairs, precision: str) -> Array:
    """(3.4) to (3.7) as printed, with the upper sign of the root and the tilde in Sigma."""
    x1, x2 = p.as_multivectors(precision, COPIES)
    x = 0.5 * x1 + 0.5 * x2
    sigma = -(x * ~x)
    s0, s4 = sigma["1"], sigma.grade(4)
    with np.errstate(all="ignore"):
        norm = np.sqrt(s0 * s0 - (s4 * s4)["1"])
        root = (norm + sigma) / (np.sqrt(2.0).astype(norm.dtype) * np.sqrt(s0 + norm))  # k S^-
        other = root.grade(0) - root.grade(4)  # k S
        return rows((other / (other * root)["1"] * x).grade(*x.grades), p)


def run_clifford(p: Pairs, _: None) -> Array:
    """`clifford.tools.g3c.average_objects`, one pair at a time."""
    from clifford.tools.g3c import average_objects

    return rows(clifford_results(lambda x, y: average_objects([x, y], check_grades=False), *p.as_multivectors()), p)


def truth(p: Pairs) -> list[Any]:
    """The projected blend with 50 digits, from the parameters; None where it is no real object."""
    blades = (project_to_blade((x1 + x2) / 2) for x1, x2 in p.exact())
    return [blade if np.isfinite(precise.size(blade)) else None for blade in blades]


def error(answer: Array, exact: list[Any], p: Pairs) -> Errors:
    """Largest coefficient error over the blade's size; an object where there is none is a false answer."""
    kind, errors = blade_kind(p), []
    for row, true in zip(answer, exact, strict=True):
        finite = bool(np.isfinite(row).all())
        if true is None or not finite:
            errors.append(np.inf if finite or true is not None else 0.0)
        else:
            errors.append(precise.size(precise.multivector(kind, row) - true) / precise.size(true))
    return np.array(errors)


def answer(result: Array, p: Pairs, i: int) -> str:
    """Description of the result at a singular input."""
    status = objects.interpolate(*p.as_multivectors(), alpha=0.5).status
    name = Status(np.asarray(status)[i]).name
    return f"{np.array2string(result[i], precision=4, suppress_small=True)}; bladesmith says {name}"


STUDY = Study(
    name="projector",
    title="The projection of a blend to the blade manifold",
    methods=methods("printed", run_stable, run_printed, run_clifford),
    cases=(
        Case("circles of any position", circles),
        Case("spheres, some imaginary", spheres),
        Case("circles of opposite orientation", opposite_circles, "extreme"),
        Case("circles 1e-8 off a common sphere", partial(circles_on_sphere, off=1e-8), "extreme"),
        Case("circles 1e6 from the origin", partial(circles, distance=1e6), "stiff"),
        Case("a line and its reverse", reversed_lines, "singular"),
        *sweep_cases("distance from the origin", DISTANCES, circles),
        *sweep_cases("circles: distance from a common sphere", GAPS, circles_on_sphere),
    ),
    reference=truth,
    error=error,
    describe=Pairs.describe,
    unit="of the blade's largest coefficient",
    count=100,
    answer=answer,
    copies=COPIES,
    source="thesis 3.5, (3.4) to (3.7)",
    notes="An object given where the interpolant is imaginary counts as lost. Each time includes making the objects.",
)
