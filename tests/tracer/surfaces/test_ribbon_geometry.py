"""Surfaces between point pairs where plain geometry says what a ray meets."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from bladesmith import cga3d as cga
from bladesmith import tracer
from bladesmith.codegen.build.extension import compiler
from bladesmith.codegen.programs.tracer.scene import needs
from bladesmith.codegen.programs.tracer.surface_kinds import surface_kind
from bladesmith.curves import Bezier, KochanekBartels, RationalBezier
from bladesmith.status import Status
from bladesmith.tracer.rendering.program import engine_for
from bladesmith.tracer.surfaces.evolved import EvolvedPointPairs

from ...oracles import ribbons as rs
from ...support.tracer.ribbons import LINEAR, on_a_circle, random_pairs, rays_near, surface_of

pytestmark = pytest.mark.skipif(compiler() is None, reason="no C compiler")


@pytest.mark.parametrize("degree", [1, 2, 3])
def test_rays_to_points_of_the_surface_find_them(degree):
    """Brute force with end points from the curve itself: also proves that bounds cut nothing off."""
    random = np.random.default_rng(degree)
    pairs = [
        ((-1 + 0.3 * random.normal(), y, z), (1 + 0.3 * random.normal(), y + 0.4, z))
        for y, z in random.normal(size=(degree + 1, 2))
    ]
    surface, _ = surface_of(pairs)
    assert not surface.flipped.any()
    alphas, places = random.uniform(size=(2, 300))
    ends = Bezier(cga.point_pair(*np.swapaxes(np.array(pairs), 0, 1)))(alphas).parameters()
    targets = ends.a + places[:, None] * (ends.b - ends.a)
    directions = random.normal(size=(300, 3))
    found = surface.intersect(targets - 4 * directions, directions)
    assert found.count.min() >= 1
    miss = np.linalg.norm(found.point - targets[:, None], axis=-1)
    best = np.nanargmin(miss, axis=1)
    facing = np.abs(np.einsum("ijk,ik->ij", found.normal, directions)[np.arange(300), best])
    facing /= np.linalg.norm(directions, axis=1)  # a grazing ray loses digits by itself
    assert np.all(np.nanmin(miss, axis=1) < 1e-12 / np.maximum(facing, 1e-4))
    np.testing.assert_allclose(np.linalg.norm(found.normal[np.arange(300), best], axis=-1), 1.0, atol=1e-14)


def test_chords_of_a_circle_sweep_a_part_of_its_plane():
    random = np.random.default_rng(3)
    for _ in range(5):
        (first, second), normal = on_a_circle(random, 1)
        surface, _ = surface_of([first, second])
        origins, directions = rays_near(random, 400)
        found = surface.intersect(origins, directions)
        t = -(origins @ normal) / (directions @ normal)
        points = origins + t[:, None] * directions
        corners = [first[0], first[1], second[1], second[0]]  # chords side by side: the circle between them
        cuts = [
            np.cross(normal, b - a) @ (points - a).T for a, b in ((corners[0], corners[1]), (corners[2], corners[3]))
        ]
        inside = (np.sign(cuts[0]) == np.sign(cuts[1])) & (np.linalg.norm(points, axis=1) < 1)
        np.testing.assert_array_equal(found.count == 1, inside)
        np.testing.assert_allclose(found.point[inside, 0], points[inside], atol=1e-11)
        np.testing.assert_allclose(np.abs(found.normal[inside, 0] @ normal), 1.0, atol=1e-14)


def test_a_ray_in_the_plane_of_a_flat_ribbon_is_singular():
    random = np.random.default_rng(4)
    chords, normal = on_a_circle(random, 1)
    for pairs in (chords, [(a + 0.3 * (a - b), b) for a, b in chords]):  # of one circle, and only of one plane
        surface, _ = surface_of(pairs)
        u, v = (np.cross(normal, random.normal(size=3)) for _ in range(2))
        found = surface.intersect(4 * u, 0.1 * v - 4 * u)
        assert found.count == 0 and found.status == Status.SINGULAR
        assert surface.intersect(4 * u + 0.1 * normal, 0.1 * v - 4 * u).status == Status.OK


def test_pairs_that_share_a_corner_keep_their_normal_there():
    """A facet's corner (4.7.4): all carriers pass through it, and there is no motion there to make a normal of."""
    corner, b, c = (0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)
    surface, _ = surface_of([(corner, b), (corner, c)])
    found = surface.intersect([(0, 0, 2), (0.2, 0.2, 2), (-0.1, 0.2, 2)], [(0.0, 0.0, -1.0)])
    assert found.count.tolist() == [1, 1, 0]
    np.testing.assert_allclose(found.normal[:2, 0], [(0, 0, 1)] * 2, atol=1e-15)


@pytest.mark.parametrize("end", [-1, 1])
def test_the_ends_belong_to_the_surface(end):
    random = np.random.default_rng(6)
    surface, oracle = surface_of(LINEAR)
    for alpha, place in ((0.0, 0.3), (1.0, -0.5), (0.4, end), (0.0, end), (1.0, end)):
        target, beside = (np.array([float(x) for x in oracle.place(alpha + d, place)]) for d in (0, 1e-6))
        normal = np.cross(beside - target, np.array(oracle.shape(alpha)[1], float))
        directions = normal / np.linalg.norm(normal) + 0.3 * random.normal(size=(40, 3))  # what grazes an end may miss
        found = surface.intersect(target - 3 * directions, directions)
        near = np.nanmin(np.linalg.norm(found.point - target, axis=-1), axis=1)
        assert np.all(found.count >= 1) and np.all(near < 1e-12)
        assert np.nanmin(found.alpha) >= 0 and np.nanmax(found.alpha) <= 1


@pytest.mark.parametrize("alpha", [0.0, 1e-9, 0.35, 0.8, 1 - 1e-9, 1.0])
def test_a_ray_along_a_carrier_meets_both_ends_of_its_segment(alpha):
    """Also at the ends of the curve, where the root that only touches may be just beyond."""
    random = np.random.default_rng(7)
    for pairs in (LINEAR, random_pairs(random, 1), random_pairs(random, 2)):
        surface, oracle = surface_of(pairs)
        middle, along, half = (np.array(x, float) for x in oracle.shape(alpha))
        found = surface.intersect(middle - 5 * along, along)
        own = found.t[np.abs(found.alpha - alpha) < 1e-12]
        np.testing.assert_allclose(own, [5 - half, 5 + half], atol=1e-12)
        beside = surface.intersect(middle - 5 * along + 0.2 * np.array([0, 1, 0.5]), along)
        assert np.all(np.isnan(beside.t) | (np.abs(beside.alpha - alpha) > 1e-3))


@pytest.mark.parametrize("degree", [1, 2])
@pytest.mark.parametrize("apart", [1e-10, 1e-9, 1e-8, 1e-6, 1e-4])
def test_rays_nearly_along_a_ruling_have_two_points(degree, apart):
    """Through points of two rulings next to each other: their roots agree to all digits, the points are far apart."""
    random = np.random.default_rng(degree)
    for _ in range(3):
        surface, oracle = surface_of(random_pairs(random, degree))
        for _ in range(3):
            alpha, places = rs.MP.mpf(random.uniform(0.1, 0.9)), random.uniform([-0.9, 0.1], [-0.1, 0.9])
            ends = [oracle.place(alpha + k * apart, s) for k, s in zip((-1, 1), places, strict=True)]
            origin = np.array([float(x) for x in ends[0]])
            step = [y - x for x, y in zip(*ends, strict=True)]
            direction = np.array([float(x) for x in step])
            found = surface.intersect(origin - direction, direction)
            for end in ends:
                miss = np.linalg.norm(found.point - np.array([float(x) for x in end]), axis=-1)
                assert np.nanmin(miss) < 1e-12 + 1e-13 / apart


@pytest.mark.parametrize(("flat", "apart"), [(1e-8, 1e-10), (3e-8, 1e-10), (1e-6, 3e-12)])
def test_points_next_to_a_ruling_of_a_nearly_flat_ribbon_are_neither_lost_nor_told_twice(flat, apart):
    """Where rounding hardly tells a ray from a ruling, nor the ruling's turn from its motion: last steps are noise."""
    random = np.random.default_rng(0)
    for _ in range(3):
        surface, oracle = surface_of(np.array(random_pairs(random, 1)) * (1.0, 1.0, flat))
        for _ in range(3):
            alpha, places = rs.MP.mpf(random.uniform(0.1, 0.9)), random.uniform([-0.9, 0.1], [-0.1, 0.9])
            ends = [oracle.place(alpha + k * apart, s) for k, s in zip((-1, 1), places, strict=True)]
            origin = np.array([float(x) for x in ends[0]])
            direction = np.array([float(y - x) for x, y in zip(*ends, strict=True)])
            found = surface.intersect(origin - direction, direction)
            assert np.sum(np.abs(found.alpha - float(alpha)) < 1e-6) == 2


@pytest.mark.parametrize("closed", [False, True])
def test_no_ray_is_lost_between_two_pieces(closed):
    """Rays aimed at joints: rounding must not put the root beyond the ends of both pieces."""
    random = np.random.default_rng(8)
    pairs = [((1.5 * i, -2.0, 0.0), (1.5 * i, 2.0, 0.0)) + random.normal(size=(2, 3)) for i in range(5)]
    surface = EvolvedPointPairs(KochanekBartels([tuple(map(tuple, p)) for p in pairs], closed=closed))
    joints = random.integers(1, 4, 2000)
    ends = surface.curve(joints.astype(float)).parameters()
    targets = ends.a + random.uniform(0.05, 0.95, (2000, 1)) * (ends.b - ends.a)
    directions = random.normal(size=(2000, 3))
    found = surface.intersect(targets - 2 * directions, directions)
    near = np.linalg.norm(found.point - targets[:, None], axis=-1) < 1e-7
    assert np.all(near.sum(axis=1) == 1)
    np.testing.assert_allclose(found.alpha[near], joints, atol=1e-9)


def test_light_ends_keep_their_normals_in_single_precision():
    random = np.random.default_rng(9)
    pairs = [tuple(map(tuple, p)) for p in random_pairs(random, 3)]
    surface = EvolvedPointPairs(RationalBezier(pairs, [1e-4, 1.0, 1.0, 1e-4]), gaps=True)
    origins, directions = rays_near(random, 300)
    single = surface.intersect(origins.astype(np.float32), directions.astype(np.float32))
    double = surface.intersect(origins.astype(np.float32).astype(float), directions.astype(np.float32).astype(float))
    np.testing.assert_array_equal(single.count, double.count)
    same = double.count > 0
    assert same.sum() > 50
    cosine = np.einsum("ij,ij->i", single.normal[same, 0], double.normal[same, 0])
    assert np.isfinite(single.normal[single.count > 0, 0]).all() and np.all(1 - cosine < 1e-4)


@pytest.mark.parametrize("method", ["isolate", "companion", "sampled"])
def test_nothing_is_found_where_pairs_are_imaginary(method):
    """Opposed chords of one circle: real pairs only near the ends, (1 - t)^2 + t^2 > 2 c t (1 - t)."""
    (first, second), normal = on_a_circle(np.random.default_rng(12), 1)
    cross = [np.sum((p - q) ** 2) for p, q in zip((*first, *first), (second[1], second[0], *second), strict=True)]
    lengths = [np.sum((p[1] - p[0]) ** 2) for p in (first, second)]
    c = (cross[0] * cross[1] - cross[2] * cross[3]) / (lengths[0] * lengths[1])
    pairs = [first, second[::-1] if c > 0 else second]
    ribbon = EvolvedPointPairs([tuple(map(tuple, p)) for p in pairs], align=False, gaps=True)
    origins, directions = rays_near(np.random.default_rng(13), 4000)
    meets = [
        np.einsum("ij,ij->i", np.cross(p[0] - origins, directions), np.broadcast_to(p[1] - p[0], origins.shape)) / size
        for p, size in zip(pairs, lengths, strict=True)
    ]
    alpha = meets[0] / (meets[0] - meets[1])
    points = origins - ((origins @ normal) / (directions @ normal))[:, None] * directions
    real = (1 - alpha) ** 2 + alpha**2 - 2 * abs(c) * alpha * (1 - alpha) > 0
    inside = (np.linalg.norm(points, axis=1) < 1) & (alpha > 0) & (alpha < 1) & real
    assert inside.sum() > 50
    found = ribbon.intersect(origins, directions, method=method, samples=400)
    same = (found.count == 1) == inside
    assert same.all() if method == "isolate" else same.mean() > 0.97
    np.testing.assert_allclose(found.alpha[same & inside, 0], alpha[same & inside], atol=1e-4)


@cache
def prepared(pairs):
    surface = EvolvedPointPairs(pairs)
    engine = engine_for(needs([surface.program_kind], pictures=False))
    return surface_kind(surface.program_kind), engine.prepare(surface.program_kind, surface.parameters)[0]


def test_constants_know_unit_squares_and_common_circles():
    short = ((0.9, 0.4, -0.2), (0.9 + 3e-8, 0.4, -0.2 + 1e-8))
    kind, row = prepared((short, LINEAR[0]))
    assert row[kind.slice("norm")][0] == 1.0 and row[kind.slice("kappa")] != 0
    (first, second), _ = on_a_circle(np.random.default_rng(1), 1)
    kind, row = prepared((tuple(map(tuple, first)), tuple(map(tuple, second))))
    assert not row[kind.slice("kappa")].any() and not row[kind.slice("products")].any()


def test_far_away_the_surface_is_the_same():
    random = np.random.default_rng(9)
    shift = np.array([1e6, -2e6, 5e5])
    near, _ = surface_of(LINEAR)
    far, _ = surface_of([(np.add(a, shift), np.add(b, shift)) for a, b in LINEAR])
    origins, directions = rays_near(random, 400)
    moved = origins + shift
    a, b = near.intersect(moved - shift, directions), far.intersect(moved, directions)
    np.testing.assert_array_equal(a.count, b.count)
    np.testing.assert_allclose(a.alpha, b.alpha, atol=1e-8)
    np.testing.assert_allclose(b.point - shift, a.point, atol=2e-9)


def test_ribbons_in_a_scene_are_seen_from_the_side_of_the_camera():
    surface, _ = surface_of(LINEAR)
    camera = tracer.Camera.look_at((0, -6, 0.5), (0, 0, 0), field_of_view=0.5)
    scene = tracer.Scene(camera, [tracer.Light((4, -6, 8))], [surface, tracer.Sphere((0, 5, 0), 1.0)])
    hits = scene.intersect(*camera.rays(24, 16))
    seen = hits.surface == 0
    assert 0.1 < seen.mean() < 0.9
    _, directions = camera.rays(24, 16)
    assert np.all(np.einsum("...i,...i->...", hits.normal, np.broadcast_to(directions, hits.normal.shape))[seen] < 0)
