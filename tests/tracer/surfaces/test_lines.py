"""Lines at hits: reflections, normals and tangents, against plain vectors and 50 digits."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bladesmith import cga3d as cga
from bladesmith import tracer
from bladesmith.codegen.formulas.objects.euclidean import dot
from bladesmith.codegen.formulas.rays import rays
from bladesmith.errors import SceneError, ShapeError, SingularError
from bladesmith.status import Status
from bladesmith.tracer.rendering.reflection import contact, normal_line, reflect, tangent_line
from bladesmith.tracer.surfaces.evolved import EvolvedCircles, EvolvedPointPairs
from bladesmith.tracer.surfaces.triangles import Facets

from ...support.tracer.exact_lines import RING, exact, mpf, scalar
from ...support.tracer.scenes import TUBE, line_direction
from ...support.vectors import unit

RIBBON = [((0.0, 0.0, 0.0), (1.0, 0.0, 0.0)), ((0.0, 1.0, 1.0), (0.5, 2.0, 1.0))]


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
