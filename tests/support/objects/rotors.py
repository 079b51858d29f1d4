"""Objects that rotors are found between: at any scale, opposite to each other; what a rotor does to them."""

from __future__ import annotations

from typing import Any

import numpy as np

from bladesmith import Status
from bladesmith import cga3d as cga

COUNT = 100_000
#: What is left of R ~R - 1: the objects' own is of the size of their largest products, which may be 1000.
UNIT = 1e-11
MIXTURES = [
    ("point_pair", "point_pair"),
    ("point_pair", "flat_point"),
    ("line", "line"),
    ("circle", "circle"),
    ("line", "circle"),
    ("circle", "line"),
    ("plane", "plane"),
    ("sphere", "sphere"),
    ("plane", "sphere"),
    ("sphere", "plane"),
]
KINDS = ("point_pair", "line", "circle", "plane", "sphere")
GRADES = {"point_pair": 2, "flat_point": 2, "line": 3, "circle": 3, "plane": 4, "sphere": 4}
NAMES = {2: "bivector", 3: "trivector", 4: "quadvector"}


def placed(kind: str, center: Any, axis: Any, radius: Any, dtype: Any = float) -> Any:
    """An object from a place, a direction and a size."""
    c, m, r = (np.asarray(v, dtype) for v in (center, axis, radius))
    m = m / np.linalg.norm(m, axis=-1, keepdims=True)
    made = {
        "point_pair": lambda: cga.point_pair(c - m * r[..., None], c + m * r[..., None]),
        "flat_point": lambda: cga.flat_point(c),
        "line": lambda: cga.line(c, m),
        "circle": lambda: cga.circle(c, m, r),
        "plane": lambda: cga.plane(m, np.asarray((c * m).sum(-1), dtype)),
        "sphere": lambda: cga.sphere(c, r),
    }[kind]()
    assert made.dtype == np.dtype(dtype)
    return made


def parameters(rng: np.random.Generator, count: int, spread: bool = False) -> tuple[Any, Any, Any]:
    """Random places, directions and sizes; ``spread``: scales from 1e-3 to 1e3."""
    scale = 10 ** rng.uniform(-3, 3, count) if spread else np.ones(count)
    return rng.normal(size=(count, 3)) * scale[:, None], rng.normal(size=(count, 3)), rng.uniform(0.1, 3, count) * scale


def random_objects(kind: str, rng: np.random.Generator, count: int, spread: bool = False, dtype: Any = float) -> Any:
    return placed(kind, *parameters(rng, count, spread), dtype)


def coefficients(x: Any, grade: int = 0) -> Any:
    """Of one grade, on all blades of it, in double precision; where blades allow several, that of objects."""
    g = grade or max(x.grades)  # the sandwich of a plane may have a scalar part by its blades
    return x.grade(g).as_kind(NAMES[g], check=False).values.astype(float)


def negative(x: Any) -> Any:
    return (-x).as_kind(x.kind)


def square(x: Any) -> Any:
    return (x.values.astype(float) ** 2).sum(-1)


def largest(x: Any) -> Any:
    return np.abs(coefficients(x)).max(-1)


def target(r: Any, y: Any) -> Any:
    """Coefficients that R x ~R should have: a sphere that is not unique goes to its negative."""
    flips = (np.asarray(r.status) == Status.NOT_UNIQUE) & (y.grades == (4,)) & (r.kind.name != "motor")
    return np.where(np.asarray(flips)[..., None], -coefficients(y), coefficients(y))


def assert_takes(r: Any, x: Any, y: Any, tolerance: float = 1e-13, relative: bool = False) -> None:
    """R x ~R = y to tolerance * max(1, |R|^2), over the objects' size where ``relative``; R is unit, <R>_0 >= 0."""
    assert np.isfinite(r.values).all()
    size = np.maximum(1, square(r))
    error = np.abs(coefficients(r >> x) - target(r, y)).max(-1)
    if relative:
        error = error / np.maximum(1, np.maximum(largest(x), largest(y)))
    assert np.max(error / size, initial=0) <= tolerance
    assert np.max(np.abs((r * ~r - 1.0).values).max(-1) / size, initial=0) <= UNIT / 1e-13 * tolerance
    assert (r["1"] >= 0).all()


CIRCLE = cga.circle((0.3, -0.2, 1.0), (1.0, 2.0, 0.5), 1.3)
LINE = cga.line((0.3, 1.0, 2.0), (1.0, 0.4, -2.0))
PLANE = cga.plane((1.0, 2.0, 3.0), 1.5)
SPHERE = cga.sphere((1.0, 0.5, -0.2), 0.7)
PAIR = cga.point_pair((1.0, 2.0, 0.0), (0.0, 0.5, 1.0))
FLAT_POINT = cga.flat_point((1.0, 2.0, 3.0))
TURNED = {
    "pair reversed": (PAIR, negative(PAIR)),
    "line reversed": (LINE, negative(LINE)),
    "circle reversed": (CIRCLE, negative(CIRCLE)),
    "plane reversed": (PLANE, negative(PLANE)),
    "flat point reversed": (FLAT_POINT, (-FLAT_POINT).as_kind("bivector")),
    "flat point far away reversed": (
        cga.flat_point((1.0, 2.0, 300.0)),
        (-cga.flat_point((1.0, 2.0, 300.0))).as_kind("bivector"),
    ),
    "flat point reversed, elsewhere": (FLAT_POINT, (-cga.flat_point((1.0, 0.0, 3.0))).as_kind("bivector")),
    "opposite lines apart": (LINE, cga.line((1.0, 1.0, 1.0), (-1.0, -0.4, 2.0))),
    "opposite planes apart": (PLANE, cga.plane((-1.0, -2.0, -3.0), 4.0)),
    "opposite planes that coincide": (cga.plane((0, 0, 1.0), 2.0), cga.plane((0, 0, -1.0), -2.0)),
    "circle and its axis": (cga.circle((0, 0, 0.0), (0, 0, 1.0), 1.0), cga.line((0, 0, 0.0), (0, 0, 1.0))),
    "another circle and its axis": (CIRCLE, cga.line((0.3, -0.2, 1.0), (1.0, 2.0, 0.5))),
    "axis and circle": (cga.line((0.3, -0.2, 1.0), (1.0, 2.0, 0.5)), CIRCLE),
    "opposite coaxial circles": (CIRCLE, cga.circle((1.3, 1.8, 1.5), (-1.0, -2.0, -0.5), 2.0)),
    "opposite concentric circles": (CIRCLE, cga.circle((0.3, -0.2, 1.0), (-1.0, -2.0, -0.5), 2.0)),
    "opposite concentric pairs": (PAIR, cga.point_pair((-0.5, -0.25, 1.5), (1.5, 2.75, -0.5))),
    "pairs head to tail": (cga.point_pair((0, 0, 0.0), (1.0, 0, 0)), cga.point_pair((1.0, 0, 0), (2.0, 3.0, 0))),
    "pair to its end and infinity": (PAIR, cga.flat_point((0.0, 0.5, 1.0))),
    "tangent circles side by side": (cga.circle((0, 0, 0.0), (0, 0, 1), 1.0), cga.circle((3.0, 0, 0), (0, 0, 1), 2.0)),
    "circle and a tangent": (cga.line((1.0, 0, 0), (0, -1.0, 0)), cga.circle((0, 0, 0.0), (0, 0, 1.0), 1.0)),
    "circle and a line beside it": (cga.line((3.0, 0, 0), (0, -1.0, 0)), cga.circle((0, 0, 0.0), (0, 0, 1.0), 1.0)),
}
FLIPPED = {
    "sphere inside out": (SPHERE, negative(SPHERE)),
    "spheres apart": (cga.sphere((0, 0, 0.0), 1.0), cga.sphere((10.0, 0, 0), 2.0)),
    "spheres tangent from outside": (cga.sphere((0, 0, 0.0), 1.0), cga.sphere((3.0, 0, 0), 2.0)),
    "concentric, one inside out": (cga.sphere((0, 0, 0.0), 1.0), negative(cga.sphere((0, 0, 0.0), 2.0))),
    "plane that leaves its tangent sphere": (cga.plane((0, 0, 1.0), 1.0), cga.sphere((0, 0, 0.0), 1.0)),
}
