"""Lines at surfaces: rays in the plane of a disc and at other corners, reflections, normals and tangents.

Oracles: plain vectors in NumPy, and at 50 digits with mpmath; the printed formulas of the thesis.
"""

from __future__ import annotations

import math

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bladesmith import cga3d as cga
from bladesmith import tracer
from bladesmith.codegen.algebra.multivector import from_values
from bladesmith.codegen.formulas.objects.euclidean import cross, dot
from bladesmith.codegen.formulas.rays import rays
from bladesmith.codegen.programs import cga3d
from bladesmith.codegen.rings.protocol import PrecisionRing
from bladesmith.errors import SceneError, ShapeError, SingularError
from bladesmith.status import Status
from bladesmith.tracer.rendering.reflection import contact, normal_line, reflect, tangent_line
from bladesmith.tracer.surfaces.evolved import EvolvedCircles, EvolvedPointPairs
from bladesmith.tracer.surfaces.triangles import Facets

from ...support.tracer.scenes import TUBE, line_direction
from ...support.vectors import unit

RING = PrecisionRing(50)
mpf = RING.context.mpf
RIBBON = [((0.0, 0.0, 0.0), (1.0, 0.0, 0.0)), ((0.0, 1.0, 1.0), (0.5, 2.0, 1.0))]
DTYPES = (np.float64, np.float32)


def exact(x):
    return from_values(cga3d(), RING, (1, 2, 4), [mpf(float(v)) for v in x])


def scalar(x):
    return from_values(cga3d(), RING, (0,), [mpf(x)])


def coordinates(x):
    return np.array([x[name].scalar() for name in ("e1", "e2", "e3")])


# -- rays in the plane of a disc -----------------------------------------------------------------------------


def in_plane(center, normal, radius, foot, along, back):
    """A ray in a disc's plane that passes the centre at ``foot`` radii, from ``back`` radii before that point."""
    u = unit(np.cross(normal, (0.3, -0.5, 0.8)))
    v = np.cross(unit(normal), u)
    side, ahead = math.cos(along) * u + math.sin(along) * v, -math.sin(along) * u + math.cos(along) * v
    middle = np.asarray(center) + foot * radius * side
    return middle - back * radius * ahead, ahead, middle


@pytest.mark.parametrize("dtype", DTYPES)
def test_rays_in_the_plane_meet_the_rim(dtype):
    random = np.random.default_rng(1)
    eps = np.finfo(dtype).eps
    for scale in (1e-9, 1.0, 1e6):
        for _ in range(20):
            center, normal, radius = (
                random.normal(size=3) * scale,
                random.normal(size=3),
                random.uniform(0.3, 2) * scale,
            )
            disc = tracer.Disc(center, normal, radius)
            foot, back = random.uniform(0, 0.98), random.uniform(-3, 3)
            origin, ahead, middle = in_plane(center, normal, radius, foot, random.uniform(0, 6), back)
            found = disc.intersect(origin.astype(dtype), (ahead * 2).astype(dtype))
            assert found.count == 2 and found.status == Status.OK
            half = math.sqrt(1 - foot**2) * radius
            expected = back * radius + np.array([-half, half])
            slack = 200 * eps * (np.abs(origin).sum() + np.abs(center).sum() + radius) * radius / half
            np.testing.assert_allclose(found.t, expected, atol=slack)
            np.testing.assert_allclose(found.point, middle + np.outer([-half, half], ahead), atol=slack)
            np.testing.assert_allclose(np.abs(found.normal @ unit(normal)), 1, atol=10 * eps)


@pytest.mark.parametrize("dtype", DTYPES)
def test_a_tangent_in_the_plane_meets_the_rim_once_and_others_never(dtype):
    random = np.random.default_rng(2)
    for shift in (0.0, 50.0):
        for _ in range(20):
            center, normal, radius = random.normal(size=3) + shift, random.normal(size=3), random.uniform(0.3, 2)
            disc = tracer.Disc(center, normal, radius)
            for foot, count in ((1.0, 1), (1.01, 0), (1.7, 0)):
                origin, ahead, middle = in_plane(center, normal, radius, foot, random.uniform(0, 6), 2.0)
                found = disc.intersect(origin.astype(dtype), ahead.astype(dtype))
                assert found.count == count, (shift, foot)
                if count:
                    np.testing.assert_allclose(found.t[0], 2 * radius, atol=1e3 * np.finfo(dtype).eps * (1 + shift))
                    np.testing.assert_allclose(found.point[0], middle, atol=1e3 * np.finfo(dtype).eps * (1 + shift))


def test_rays_beside_the_plane_miss_and_tilted_ones_cross_it_once():
    disc = tracer.Disc((0, 0, 0), (0, 0, 1), 1.0)
    assert disc.intersect((-3, 0, 1e-9), (1, 0, 0)).count == 0
    for tilt in (1e-3, 1e-6, 1e-9, 1e-12):
        for place in (-0.9, 0.0, 0.5):
            found = disc.intersect((-3.0, 0.2, (3 + place) * tilt), (1.0, 0.0, -tilt))
            assert found.count == 1
            assert found.point[0, 0] == pytest.approx(place, abs=1e-15 / tilt)
            assert abs(found.point[0, 2]) < 1e-15
        assert disc.intersect((-3.0, 0.2, 4.1 * tilt), (1.0, 0.0, -tilt)).count == 0
    for tilt in (1e-15, 1e-17, 0.0):  # within rounding of the plane
        found = disc.intersect((-3.0, 0.6, 3 * tilt), (1.0, 0.0, -tilt))
        np.testing.assert_allclose(found.t, [2.2, 3.8], rtol=1e-14)


def test_no_hit_is_lost_where_the_treatment_changes():
    """Over all slopes and heights about the rounding of the plane: what crosses well inside is always found."""
    disc = tracer.Disc((0, 0, 0), (0, 0, 1), 1.0)
    slope = (np.geomspace(1e-18, 1e-8, 300)[:, None] * np.array([1, -1])).reshape(-1, 1)
    place = np.linspace(-0.99, 0.99, 41)
    origins = np.stack(np.broadcast_arrays(0.0 * slope - 0.5, 0.05, -slope * (place + 0.5)), -1)
    directions = np.stack(np.broadcast_arrays(1.0, 0.0, slope), -1)
    assert (disc.intersect(origins, directions).count > 0).all()


def test_scenes_see_the_rim_and_shadows_do_not_end():
    scene = tracer.Scene(
        tracer.Camera.look_at((0, -5, 0), (0, 0, 0)),
        [tracer.Light((0, 0, 5))],
        [tracer.Disc((0, 0, 0), (0, 0, 1), 1.0, material={"color": (1, 0, 0)})],
    )
    hits = scene.intersect((0, -5, 0), [(0, 1, 0), (0.1, 1, 0), (0.5, 1, 0), (0, 1, -0.01)])
    assert hits.hit.tolist() == [True, True, False, False]
    np.testing.assert_allclose(hits.point[0], (0, -1, 0), atol=1e-15)
    assert np.isfinite(scene.render(33, 33)).all()


def test_the_meet_in_the_plane_at_fifty_digits():
    """4.4.1: <L C>_2 dualised in the plane is A ^ B where its square is positive; the tangent is A ^ t ^ ..."""
    center, normal, radius = exact((0.25, -1.5, 2.0)), exact((0.0, 0.6, 0.8)), scalar(1.25)
    normal = rays.unit(normal)
    u = rays.unit(exact((1, 0, 0)))
    v = cross(normal, u)
    disc = rays.circle(center, normal, radius)
    plane = rays.dual_plane(normal, dot(normal, center)).undual()
    for share, sign in ((0, 1), (0.5, 1), (1, 0), (1.5, -1)):
        origin = center + scalar(share) * radius * v - scalar(3) * u
        ray = rays.line(origin, u)
        pair = ((ray * disc).grade(2) * plane).grade(2)
        square = pair.scalar_product(pair).scalar()
        assert abs((ray & disc).scalar_product(ray & disc).scalar()) < 1e-40  # Y vanishes
        assert square * sign > 0 if sign else abs(square) < 1e-40
        t, first, last = (
            r.value if not r.is_row else r.values for r in rays.rim_hit(origin, u, center, normal, radius)
        )
        if sign > 0:
            a, b = rays.pair_points(pair)
            ends = sorted(map(tuple, (coordinates(a), coordinates(b))))
            got = sorted(map(tuple, (coordinates(first + center), coordinates(last + center))))
            assert max(abs(p - q) for x, y in zip(ends, got, strict=True) for p, q in zip(x, y, strict=True)) < 1e-40
            assert abs(t[0].scalar() - (3 - mpf(1.25) * mpmath.sqrt(1 - mpf(share) ** 2))) < 1e-15
        else:
            assert [bool(RING.context.isnan(x.scalar())) for x in t] == ([False, True] if sign == 0 else [True, True])


# -- corners of planes and spheres ---------------------------------------------------------------------------


@pytest.mark.parametrize("dtype", DTYPES)
@pytest.mark.parametrize("radius", [1e-12, 1e-3, 1e12])
def test_spheres_and_discs_of_all_sizes(dtype, radius):
    eps = np.finfo(dtype).eps
    rays_ = np.array([(-3, 0, 0), (-3, 0.5, 0), (0, 0, 0), (1, 0, 0), (0, 0.1, 0)]) * radius
    directions = np.array([(1, 0, 0), (2, 0, 0), (0, 0, 1), (-1, 0, 0), (1e-4, 1e-4, 0)])
    sphere = tracer.Sphere((0, 0, 0), radius).intersect(rays_.astype(dtype), directions.astype(dtype))
    assert sphere.count.tolist() == [2] * 5
    root = math.sqrt(0.75)
    near = math.sqrt(0.995)
    expected = [(2, 4), (3 - root, 3 + root), (-1, 1), (0, 2), (-near - 0.1 / 2**0.5, near - 0.1 / 2**0.5)]
    np.testing.assert_allclose(sphere.t / radius, expected, atol=20 * eps)
    np.testing.assert_allclose(np.linalg.norm(sphere.point / radius, axis=-1), 1, atol=20 * eps)
    disc = tracer.Disc((0, 0, 0), (0, 0, 1), radius)
    starts = np.array([(0.5, 0.5, -2), (1.01, 0, 3), (0.3, 0, 0), (0.999, 0, 1)]) * radius
    found = disc.intersect(starts.astype(dtype), np.array([(0, 0, 1), (0, 0, -1), (0, 1, 1), (0, 0, -3)], dtype))
    assert found.count.tolist() == [1, 0, 1, 1]
    np.testing.assert_allclose(found.t[[0, 2, 3], 0] / radius, [2, 0, 1], atol=10 * eps)


def test_rays_that_start_on_surfaces_and_inside_of_them():
    sphere = tracer.Sphere((1, 2, 3), 2.0)
    inside = sphere.intersect((1.5, 2, 3), unit(np.random.default_rng(3).normal(size=(50, 3))))
    assert (inside.t[:, 0] < 0).all() and (inside.t[:, 1] > 0).all()
    toward = np.einsum("ij,ij->i", inside.normal[:, 1], inside.point[:, 1] - sphere.center)
    assert (toward < 0).all()  # seen from inside
    scene = tracer.Scene(tracer.Camera.look_at((1.5, 2, 3), (1, 2, 3)), [], [sphere])
    assert scene.intersect((1.5, 2, 3), (1, 0, 0)).t == pytest.approx(1.5)
    on = sphere.intersect((3, 2, 3), [(1, 0, 0), (-1, 0, 0), (0, 1, 0)])
    np.testing.assert_allclose(on.t, [(-4, 0), (0, 4), (0, 0)], atol=1e-15)
    plane = tracer.Plane((0, 0, 1), 2.0)
    assert plane.intersect((5, 5, 2), (1, 2, 3)).t[0] == 0
    assert plane.intersect((5, 5, 2), (1, 2, 0)).count == 0  # in the plane: no single point
    far = plane.intersect((0, 0, 3), (1, 0, -1e-9))
    assert far.t[0] == pytest.approx(1e9, rel=1e-12)


def test_the_rim_belongs_to_the_disc():
    random = np.random.default_rng(4)
    disc = tracer.Disc(cga.circle((1.0, 0.0, 2.0), (0.0, 0.6, 0.8), 0.7))
    u, v = np.array([1.0, 0, 0]), np.array([0, 0.8, -0.6])
    angle = random.uniform(0, 2 * np.pi, 200)[:, None]
    rim = np.cos(angle) * u + np.sin(angle) * v
    origins = random.normal(size=(200, 3)) * 3
    for share, hit in ((1 - 1e-12, True), (1 + 1e-12, False)):
        points = disc.center + 0.7 * share * rim
        found = disc.intersect(origins, points - origins)
        steep = np.abs(unit(points - origins) @ disc.normal) > 0.1
        assert steep.sum() > 150
        assert ((found.count > 0) == hit)[steep].all()
    assert tracer.Disc((0, 0, 0), (0, 0, 1), 1.0).intersect((0.6, 0.8, 3), (0, 0, -1)).count == 1


# -- reflections, normals, tangents --------------------------------------------------------------------------


def every_surface(shift=(0.0, 0.0, 0.0)):
    at = np.asarray(shift, float)
    corners = np.array([(-2, -2, 0), (2, -2, 0.3), (2, 2, -0.2), (-2, 2, 0.4)]) + at
    return {
        "plane": tracer.Plane((0.1, 0.2, 1.0), 0.3 + at @ (0.1, 0.2, 1.0)),
        "disc": tracer.Disc(at + (0, 0, 0.1), (0.2, 0.1, -1), 5.0),
        "sphere": tracer.Sphere(at, 1.0),
        "facets": Facets(corners, [[0, 1, 2], [0, 2, 3]]),
        "circles": EvolvedCircles([(at + c, n, r) for c, n, r in TUBE]),
        "pairs": EvolvedPointPairs([(at + a, at + b) for a, b in RIBBON]),
    }


def hits_on(surface, shift, count=40, seed=14):
    random = np.random.default_rng(seed)
    origins = random.normal(size=(count, 3)) * 0.2 + (0.5, 0.3, 4) + shift
    directions = unit(random.normal(size=(count, 3)) * 0.3 + (0.2, 0.3, 0.2) + shift - origins)
    found = surface.intersect(origins, directions)
    some = found.count > 0
    assert some.sum() > 8
    return origins[some], directions[some], found.point[some, 0], found.normal[some, 0]


@pytest.mark.parametrize("shift", [(0, 0, 0), (1e6, -1e6, 5e5)], ids=["near", "far"])
@pytest.mark.parametrize("name", every_surface())
def test_lines_at_hits_are_those_of_plain_vectors(name, shift):
    surface = every_surface(shift)[name]
    origins, directions, points, normals = hits_on(surface, np.array(shift))
    lines, hits = cga.line(origins, directions), cga.point(points)
    along = np.einsum("ij,ij->i", directions, normals)[:, None] * normals
    rounding = 1e-12 + 3e-16 * np.abs(shift).sum()  # of points, in units of the surfaces' size
    for function, expected, worse in (
        (reflect, directions - 2 * along, 4),
        (normal_line, normals, 2),
        (tangent_line, directions - along, 4 / np.linalg.norm(directions - along, axis=1).min()),
    ):
        found = function(lines, hits, surface)
        assert found.status is None or (found.status == Status.OK).all(), function
        point, direction = found.parameters()
        np.testing.assert_allclose(direction, unit(expected), atol=worse * rounding)
        gap = points - point
        gap -= np.einsum("ij,ij->i", gap, direction)[:, None] * direction
        assert np.abs(gap).max() <= 1e-14 + 1e-15 * np.abs(shift).sum() * worse


def test_normals_and_tangents_are_difference_and_sum():
    """N ~ L' - L and L_T ~ L' + L, as printed, on the objects themselves."""
    for surface in every_surface().values():
        origins, directions, points, _ = hits_on(surface, np.zeros(3))
        lines, hits = cga.line(origins, directions), cga.point(points)
        mirrored = reflect(lines, hits, surface)
        for made, printed in (
            (normal_line(lines, hits, surface), mirrored - lines),
            (tangent_line(lines, hits, surface), mirrored + lines),
        ):
            size = np.linalg.norm(line_direction(printed), axis=-1)
            np.testing.assert_allclose(made.values, printed.values / size[:, None], atol=1e-12 / size.min())


def test_the_printed_reflections_at_fifty_digits():
    """(4.7), (4.8) and plain vectors in spheres, near and far, from outside and from inside."""
    random = np.random.default_rng(5)
    mp = RING.context
    for distance in (0.0, 1.0, 1e6):
        for _ in range(4):
            center, radius = random.normal(size=3) * distance, random.uniform(0.3, 3.0)
            out = random.normal(size=3)
            normal = rays.unit(exact(out))
            hit = exact(center) + scalar(radius) * normal
            for direction in (random.normal(size=3), out, np.cross(out, (1, 2, 3)), -out):
                m = rays.unit(exact(direction))
                sphere = (rays.dual_sphere(exact(center), scalar(radius) ** 2) / scalar(radius)).undual()
                ray = rays.line(hit, m)
                inverted = rays.reflect_in_sphere(ray, sphere, rays.point(hit))
                plane = rays.tangent_plane(sphere, rays.point(hit)).grade(4)
                mirrored = rays.reflect_in_plane(ray, plane).grade(3)
                expected = m - 2 * dot(m, normal) * normal
                lines = [inverted.grade(3), mirrored, rays.line(hit, expected)]
                size = [mp.sqrt(dot(d, d).scalar()) for d in map(rays.line_direction, lines)]
                rows = [[c.scalar() / s for c in x.coefficients()] for x, s in zip(lines, size, strict=True)]
                values = [dict(zip(x.terms, row, strict=True)) for x, row in zip(lines, rows, strict=True)]
                blades = set().union(*values)
                largest = max(abs(v) for v in values[2].values())
                for other in values[:2]:
                    assert max(abs(other.get(b, 0) - values[2].get(b, 0)) for b in blades) < mpf(10) ** -38 * largest


def test_lines_that_graze_and_lines_along_the_normal():
    sphere = tracer.Sphere((0, 0, 0), 1.0)
    top = cga.point((0, 0, 1))
    grazing, straight = cga.line((0, 0, 1), (1, 0, 0)), cga.line((0, 0, 1), (0, 0, -1))
    assert reflect(grazing, top, sphere).isclose(grazing)
    assert tangent_line(grazing, top, sphere).isclose(grazing)
    normal = normal_line(grazing, top, sphere)
    assert normal.status == Status.NOT_UNIQUE
    np.testing.assert_allclose(np.abs(normal.parameters().direction), (0, 0, 1), atol=1e-15)
    assert reflect(straight, top, sphere).isclose(cga.line((0, 0, 1), (0, 0, 1)))
    assert normal_line(straight, top, sphere).isclose(cga.line((0, 0, 1), (0, 0, 1)))
    none = tangent_line(straight, top, sphere)
    assert none.status == Status.SINGULAR and np.isnan(none.values).all()
    with pytest.raises(SingularError, match="tangent_line"):
        tangent_line(straight, top, sphere, strict=True)


@pytest.mark.parametrize("name", ["circles", "pairs", "facets"])
def test_lines_that_only_touch_find_the_normal_all_the_same(name):
    """Lines in the tangent plane: their meet is a double root, which rounding moves or loses."""
    surface = every_surface()[name]
    _, directions, points, normals = hits_on(surface, np.zeros(3))
    touching = unit(np.cross(normals, directions))
    lines, hits = cga.line(points, touching), cga.point(points)
    mirrored = reflect(lines, hits, surface)
    assert mirrored.status is None or (mirrored.status == Status.OK).all()
    np.testing.assert_allclose(mirrored.parameters().direction, touching, atol=1e-11)
    found = normal_line(lines, hits, surface)
    assert (found.status == Status.NOT_UNIQUE).all()
    turn = np.einsum("ij,ij->i", found.parameters().direction, normals)
    np.testing.assert_allclose(np.abs(turn), 1, atol=1e-11)


@pytest.mark.parametrize("name", every_surface())
def test_points_off_the_surface_or_off_the_line_are_told(name):
    surface = every_surface()[name]
    _, directions, points, normals = hits_on(surface, np.zeros(3))
    for function in (reflect, normal_line, tangent_line):
        for moved in (1e-6 * normals, 1e-4 * normals, 0.05 * normals):
            off = points + moved
            found = function(cga.line(off, directions), cga.point(off), surface)
            assert (found.status == Status.INVALID).all() and np.isnan(found.values).all()
            aside = function(cga.line(off, directions), cga.point(points), surface)
            steep = np.linalg.norm(np.cross(unit(moved), directions), axis=1) > 1e-2
            assert (aside.status[steep] == Status.INVALID).all()
        close = points + 1e-11 * normals
        assert (function(cga.line(close, directions), cga.point(close), surface).status != Status.INVALID).all()
        off = points + 1e-4 * normals
        lenient = function(cga.line(off, directions), cga.point(off), surface, tolerance=1e-3)
        assert (lenient.status != Status.INVALID).all()


def test_the_distance_that_is_told_is_the_distance():
    random = np.random.default_rng(8)
    positions = random.normal(size=(60, 3))
    directions = unit(random.normal(size=(60, 3)))
    for name, expected in {
        "plane": lambda x: np.abs(x @ (0.1, 0.2, 1.0) - 0.3) / math.sqrt(1.05),
        "sphere": lambda x: np.abs(np.linalg.norm(x, axis=1) - 1),
    }.items():
        distance, normal = contact(every_surface()[name], positions, directions, 1e-9)
        np.testing.assert_allclose(distance, expected(positions), atol=1e-14)
        np.testing.assert_allclose(np.linalg.norm(normal, axis=1), 1, atol=1e-14)
    disc = tracer.Disc((0, 0, 0), (0, 0, 1), 1.0)
    distance, _ = disc.contact(np.array([(0.5, 0, 0), (0.5, 0, -2), (4, 0, 4), (0, 1, 0)]))
    np.testing.assert_allclose(distance, [0, 2, 5, 0], atol=1e-15)


def test_batches_shapes_precision_and_wrong_arguments():
    sphere = tracer.Sphere((0, 0, 0), 1.0)
    lines = cga.line((0, 0, 1), np.array([(1, 0, -1), (0, 1, -1), (0, 0, -1)]))
    found = reflect(lines, cga.point((0, 0, 1)), sphere)
    assert found.shape == (3,)
    np.testing.assert_allclose(found.parameters().direction, unit([(1, 0, 1), (0, 1, 1), (0, 0, 1)]), atol=1e-15)
    assert reflect(lines[:, None], cga.point(np.tile([(0.0, 0, 1)], (2, 1))), sphere).shape == (3, 2)
    assert reflect(cga.line((0, 0, 1), np.zeros((0, 3))), cga.point((0, 0, 1)), sphere).shape == (0,)
    tube = every_surface()["circles"]
    assert reflect(cga.line((0, 0, 1), np.zeros((0, 3))), cga.point((0, 0, 1)), tube).shape == (0,)
    single = reflect(lines.astype(np.float32), cga.point((0, 0, 1)).astype(np.float32), sphere)
    assert single.dtype == np.float32 and np.abs(single.values - found.values).max() < 1e-6
    bad = reflect(cga.line((0, 0, 1), (np.nan, 0, 1)), cga.point((0, 0, 1)), sphere)
    assert bad.status == Status.INVALID
    with pytest.raises(ShapeError):
        reflect(lines, cga.point(np.zeros((2, 3))), sphere)
    with pytest.raises(SceneError, match="tolerance"):
        reflect(lines, cga.point((0, 0, 1)), sphere, tolerance=-1.0)
    with pytest.raises(SceneError, match="a line is needed"):
        normal_line(cga.circle((0, 0, 0), (0, 0, 1), 1.0), cga.point((0, 0, 1)), sphere)


@given(st.floats(-1, 1), st.floats(0, 6.28), st.floats(-0.99, 0.99), st.floats(0, 6.28))
def test_reflecting_twice_is_nothing(height, turn, up, around):
    def on_sphere(z, angle):
        across = math.sqrt(1 - z * z)
        return np.array([across * math.cos(angle), across * math.sin(angle), z])

    point, direction = on_sphere(height, turn), on_sphere(up, around)
    sphere, x = tracer.Sphere((0, 0, 0), 1.0), cga.point(point)
    line = cga.line(point, direction)
    there = reflect(line, x, sphere)
    assert there.status is None or there.status == Status.OK
    assert np.abs(reflect(there, x, sphere).values - line.values).max() < 1e-13
    normal = normal_line(line, x, sphere)
    cosine = normal.parameters().direction @ there.parameters().direction
    assert cosine >= -1e-9  # the light leaves on the side that it came from
