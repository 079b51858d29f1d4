"""Surfaces evolved along curves: orientation of their circles, all classes of curves, seams between pieces."""

from __future__ import annotations

import numpy as np
import pytest

from bladesmith import tracer
from bladesmith.codegen.rings.protocol import NumericRing
from bladesmith.core.registry import stock_algebra
from bladesmith.curves import Bezier, Interpolating, KochanekBartels, RationalBezier

from ....support.tracer.evolved import Geometry, answers_of_both_precisions, random_surfaces
from ....support.tracer.scenes import TUBE


def test_opposed_circles_are_turned_over_and_it_is_said(caplog):
    circles = [((0, 0, 0), (0, 0, 1), 1.0), ((0, 0, 0.5), (0, 0, -1), 1.0)]
    with caplog.at_level("WARNING", "bladesmith"):
        surface = tracer.EvolvedCircles(Bezier(circles), align=True)
    assert surface.flipped.tolist() == [False, True] and "orientation reversed" in caplog.text
    assert not tracer.EvolvedCircles(Bezier(TUBE), align=True).flipped.any()


def test_surfaces_follow_the_curve_through_their_controls():
    """Opposed or not, with and without align: one default for both."""
    random = np.random.default_rng(8)
    t = np.linspace(0, 1, 21)
    for _ in range(20):
        circles = [(3 * k * np.eye(3)[2] + random.normal(size=3), random.normal(size=3), 1.0) for k in range(4)]
        for options in ({}, {"align": False}, {"align": True}):
            for make in (Bezier, KochanekBartels, lambda x, **o: RationalBezier(x, [1, 2, 2, 1], **o)):
                curve = make(circles, **options)
                for followed in (curve, *([circles] if make is Bezier else [])):
                    surface = tracer.EvolvedCircles(followed, gaps=True, **options)
                    assert np.array_equal(surface.flipped, curve.flipped)
                    at = t * curve.segments
                    assert np.array_equal(surface.curve(at).status, curve(at).status)
                    assert np.array_equal(surface.curve(at).values, curve(at).values, equal_nan=True)


def test_files_turn_opposing_controls_over_unless_they_say_otherwise(tmp_path):
    text = """
[camera]
position = [0.0, -8.0, 2.0]
look_at = [0.0, 0.0, 0.0]

[[surfaces]]
kind = "evolved_circles"
controls = [
    { center = [0, 0, 0], normal = [0, 0, 1], radius = 1.0 },
    { center = [0, 0, 2], normal = [0, 0, -1], radius = 1.0 },
]
"""
    for option, turned in (("", True), ("align = true\n", True), ("align = false\ngaps = true\n", False)):
        path = tmp_path / "scene.toml"
        path.write_text(text + option)
        assert tracer.Scene.load(path).surfaces[0].flipped.tolist() == [False, turned]


def test_opposition_is_the_sign_of_the_scalar_part():
    for surface in random_surfaces(40, seed=31):
        first, second = Geometry(surface, NumericRing()).circles
        assert (first * second).grade(0).scalar() >= 0


def tube_controls(random, count):
    axis = np.array([0.2, -0.1, 1.0])
    return [
        (0.8 * k * axis + 0.25 * random.normal(size=3), axis + 0.25 * random.normal(size=3), random.uniform(0.5, 1.0))
        for k in range(count)
    ]


CURVES = {
    "kochanek_bartels": lambda c: KochanekBartels(c),
    "rational": lambda c: RationalBezier(c, weights=[1.0, 2.0, 0.5, 1.0]),
    "interpolating": lambda c: Interpolating(c, [0, 1, 2, 3]),
    "quadratic": lambda c: Interpolating(c[:3], [0, 0.5, 1], degree=2),
    "coefficients": lambda c: [np.ravel(stock_algebra("cga3d").circle(*x).values) for x in c],
}


@pytest.mark.parametrize("name", CURVES)
def test_curves_of_every_class(name):
    """Changes of sign of (L v C)^2 by the public algebra on the public curve, where no two roots are close."""
    random = np.random.default_rng(17)
    surface = tracer.EvolvedCircles(CURVES[name](tube_controls(random, 4)))
    curve, cga = surface.curve, stock_algebra("cga3d")
    start, end = (curve.breaks[0], curve.breaks[-1]) if hasattr(curve, "breaks") else (0.0, 1.0)
    alphas = np.linspace(start, end, 1501)
    circles = curve(alphas)
    origins = random.normal(size=(60, 3)) * 3 + (0, 0, 1)
    directions = random.normal(size=(60, 3)) * 0.6 + (0, 0, 1) - origins
    found = surface.intersect(origins, directions)
    seen = 0
    for i in range(60):
        meet = cga.line(origins[i], directions[i]) & circles
        f = (meet * meet).grade(0).values.ravel()
        changes = alphas[:-1][(f[:-1] < 0) != (f[1:] < 0)]
        alpha = np.sort(found.alpha[i, : found.count[i]])
        if len(alpha) > 1 and np.diff(alpha).min() < 2 * (alphas[1] - alphas[0]):
            continue
        assert len(alpha) == len(changes), (i, alpha, changes)
        assert np.all((alpha >= changes - 1e-12) & (alpha <= changes + alphas[1] - alphas[0] + 1e-12))
        seen += len(alpha)
    assert seen > 40
    some = ~np.isnan(found.alpha)
    held = curve(found.alpha[some])
    residual = np.linalg.norm((cga.point(found.point[some]) ^ held).values, axis=-1)
    reach = 1 + np.sum(found.point[some] ** 2, axis=-1)
    assert np.all(residual < 1e-12 * reach * np.linalg.norm(held.values, axis=-1))
    single, double = answers_of_both_precisions(surface.intersect, origins, directions)
    np.testing.assert_array_equal(single.count, double.count)


def ring_of(kind, count):
    """A closed curve of circles or of point pairs around the origin, of unequal ones."""
    turns = 2 * np.pi * np.arange(count) / count
    middles = np.stack([3 * np.cos(turns), 3 * np.sin(turns), 0.3 * np.sin(2 * turns + 1)], axis=-1)
    out = middles / np.linalg.norm(middles, axis=-1, keepdims=True)
    if kind == "circle":
        axes = np.cross((0.0, 0.1, 1.0), out)
        controls = [(tuple(c), tuple(n), 0.8 + 0.1 * i) for i, (c, n) in enumerate(zip(middles, axes, strict=True))]
        return tracer.EvolvedCircles(KochanekBartels(controls, closed=True))
    pairs = [(tuple(c - 0.8 * n), tuple(c + (0.7, 0.1, 0.4) * n)) for c, n in zip(middles, out, strict=True)]
    return tracer.EvolvedPointPairs(KochanekBartels(pairs, closed=True))


def points_of_controls(surface, places, random):
    """Points of the objects at joints of a curve, by their parameters."""
    held = [surface.curve(np.array([float(p)])).parameters() for p in range(max(places) + 1)]
    if isinstance(surface, tracer.EvolvedPointPairs):
        shares = random.uniform(0.05, 0.95, (len(places), 1))
        return np.array([held[p].a[0] for p in places]) * shares + np.array([held[p].b[0] for p in places]) * (
            1 - shares
        )
    targets = []
    for place, angle in zip(places, random.uniform(0, 2 * np.pi, len(places)), strict=True):
        center, normal, radius = held[place].center[0], held[place].normal[0], held[place].radius[0]
        across = np.cross(normal, np.eye(3)[np.argmin(np.abs(normal))])
        across /= np.linalg.norm(across)
        targets.append(center + radius * (np.cos(angle) * across + np.sin(angle) * np.cross(normal, across)))
    return np.array(targets)


@pytest.mark.parametrize("seed", range(2))
def test_no_ray_is_lost_between_two_pieces(seed):
    """Rays aimed at joints: rounding must not put the root beyond the ends of both pieces, nor count it twice."""
    random = np.random.default_rng([seed, 4])
    centers = random.normal(size=(5, 3)) + 1.5 * np.arange(5)[:, None] * (1, 0, 0)
    normals = 0.3 * random.normal(size=(5, 3)) + (1, 0, 0)
    radii = random.uniform(0.3, 1.5, 5)
    controls = [(tuple(c), tuple(n), float(r)) for c, n, r in zip(centers, normals, radii, strict=True)]
    surface = tracer.EvolvedCircles(Interpolating(controls, np.arange(5.0), 3), gaps=True)
    joints = np.repeat([1, 2, 3], 2000 // 3)
    targets = points_of_controls(surface, joints, random)
    directions = random.normal(size=targets.shape)
    found = surface.intersect(targets - 2 * directions, directions)
    near = np.linalg.norm(found.point - targets[:, None], axis=-1) < 1e-6
    assert np.all(near.sum(axis=1) == 1)
    np.testing.assert_allclose(found.alpha[near], joints, atol=1e-7)


@pytest.mark.compiles
@pytest.mark.parametrize("kind", ["circle", "point_pair"])
@pytest.mark.parametrize("count", [3, 4])
def test_points_at_the_seam_of_a_closed_curve_count_once(kind, count):
    random = np.random.default_rng([count, 5])
    surface = ring_of(kind, count)
    targets = points_of_controls(surface, [0] * 300, random)
    directions = random.normal(size=targets.shape)
    found = surface.intersect(targets - 2 * directions, directions)
    near = np.linalg.norm(found.point - targets[:, None], axis=-1) < 1e-6
    assert np.all(near.sum(axis=1) == 1)
    period = surface.segments.starts[-1] + surface.segments.lengths[-1]
    np.testing.assert_allclose(np.minimum(found.alpha[near], period - found.alpha[near]), 0, atol=1e-7)
