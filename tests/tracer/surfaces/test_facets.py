"""Rays against triangles: which they meet, where, and smooth shading."""

from __future__ import annotations

from fractions import Fraction
from itertools import product

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

import bladesmith as bs
from bladesmith import cga3d, tracer
from bladesmith.tracer.surfaces.triangles import Facets

from ...support.tracer.facets import ONE, TRIANGLE, first, star

# -- which triangles a ray meets ---------------------------------------------------------------------------


def exact_sides(origin, direction, corners):
    """Signs of the volumes of (direction, p, q) for the edges p q, in rational arithmetic."""
    o, d = ([Fraction(float(x)) for x in v] for v in (origin, direction))
    a, b, c = ([Fraction(float(x)) - y for x, y in zip(corner, o, strict=True)] for corner in corners)

    def volume(p, q):
        return (
            d[0] * (p[1] * q[2] - p[2] * q[1]) + d[1] * (p[2] * q[0] - p[0] * q[2]) + d[2] * (p[0] * q[1] - p[1] * q[0])
        )

    return [volume(b, c), volume(c, a), volume(a, b)]


def test_small_whole_numbers_are_decided_exactly(rng):
    """Products of these are exact, so every hit, on edges and corners too, must be the one of exact arithmetic."""
    corners = rng.integers(-3, 4, (300, 3, 3)).astype(float)
    corners = corners[
        np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) > 0
    ]
    origin = np.array([1.0, -1.0, 2.0])
    directions = np.array([d for d in product(range(-2, 3), repeat=3) if any(d)], float)
    on_edges = 0
    for triangle in corners[:30]:
        surface = Facets(triangle, ONE)
        found = surface.intersect(origin, directions)
        for i, d in enumerate(directions):
            sides = exact_sides(origin, d, triangle)
            inside = (all(s >= 0 for s in sides) or all(s <= 0 for s in sides)) and sum(sides) != 0
            assert found.count[i] == int(inside), (triangle, d)
            on_edges += inside and 0 in sides
            if inside:
                total = sum(sides)
                place = [
                    sum(s * Fraction(float(v)) for s, v in zip(sides, triangle[:, k], strict=True)) / total
                    for k in range(3)
                ]
                assert np.allclose(found.point[i, 0], [float(x) for x in place], rtol=0, atol=1e-14)
    assert on_edges > 50


@pytest.mark.compiles
@pytest.mark.parametrize("dtype", [np.float64, np.float32])
def test_no_ray_leaves_a_closed_mesh(rng, dtype):
    """Aimed at random, at corners, along edges, and next to both by rounding units: 1e6 rays in all."""
    vertices, faces = star(rng)
    vertices = vertices.astype(dtype).astype(float)
    origin = np.array([0.05, -0.02, 0.03], dtype)
    edges = np.unique(np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), 1), axis=0)
    share = rng.uniform(size=(300, len(edges), 1))
    along = (vertices[edges[:, 0]] * share + vertices[edges[:, 1]] * (1 - share)).reshape(-1, 3)
    corners = np.repeat(vertices, 1000, axis=0)
    aimed = np.concatenate([along, corners]).astype(dtype) - origin
    ulps = rng.integers(-2, 3, aimed.shape) * np.finfo(dtype).eps
    directions = np.concatenate([aimed, aimed * (1 + ulps).astype(dtype), rng.normal(size=(400_000, 3)).astype(dtype)])
    wanted = 700_000 if dtype is np.float64 else 300_000
    directions = directions[rng.permutation(len(directions))[:wanted]]
    found = first(Facets(vertices, faces), origin, directions)
    assert found.hit.all()
    assert (found.status == bs.Status.OK).all()


def test_a_ray_meets_a_closed_mesh_evenly_often(rng):
    vertices, faces = star(rng)
    surface = Facets(vertices, faces)
    lines = surface.intersect(rng.normal(size=(2000, 3)), rng.normal(size=(2000, 3)))
    assert (lines.count % 2 == 0).all()
    assert (lines.count > 0).any()
    assert np.isnan(lines.alpha).all()
    assert ((np.diff(lines.t, axis=1) >= 0) | np.isnan(lines.t[:, 1:])).all()


def test_more_points_than_a_few_on_one_line():
    """Forty parallel triangles: all of their points, in order."""
    heights = np.arange(40.0)
    vertices = (TRIANGLE[None] + heights[:, None, None] * [0, 0, 1]).reshape(-1, 3)
    found = Facets(vertices, np.arange(120).reshape(-1, 3)).intersect((0.2, 0.3, -1.0), (0, 0, 1.0))
    assert found.count == 40
    assert np.allclose(found.t[:40], heights + 1)


def test_edges_belong_to_both_neighbours_and_a_ray_in_the_plane_to_none():
    square = Facets([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]])
    assert square.intersect((0.5, 0.5, 1), (0, 0, -1)).count == 2
    assert square.intersect((0.5, 0.25, 1), (0, 0, -1)).count == 1
    assert square.intersect((-1, 0.25, 0), (1, 0, 0)).count == 0


def test_signs_are_those_of_the_point_pairs_of_the_thesis(rng):
    """4.7.4: alpha and beta, from P1 = A^C, P2 = A^B, P3 = C^B, between 0 and 1 where the triangle is met."""
    corners = rng.normal(size=(200, 3, 3))
    origin, directions = np.array([0.1, 0.2, -2.0]), rng.normal(size=(200, 3)) + [0, 0, 3]
    a, b, c = (cga3d.point(corners[:, i]) for i in range(3))
    ray = cga3d.line(np.broadcast_to(origin, (200, 3)), directions)

    def meet(x, y):
        pair = x ^ y
        return np.asarray((pair & ray).grade(0).values)[:, 0] / np.sqrt(np.abs(np.asarray((pair | pair).values)[:, 0]))

    p1, p2, p3 = meet(a, c), meet(a, b), meet(c, b)
    alpha, beta = p2 / (p2 - p1), p3 / (p3 - p2)
    inside = (alpha > 0) & (alpha < 1) & (beta > 0) & (beta < 1)
    met = np.array([Facets(t, ONE).intersect(origin, d).count for t, d in zip(corners, directions, strict=True)])
    assert np.array_equal(inside, met > 0)
    assert 10 < inside.sum() < 190


# -- where ---------------------------------------------------------------------------------------------


def exact_hit(origin, direction, corners):
    """t, in rational arithmetic, by the plane of the triangle."""
    o, d = ([Fraction(float(x)) for x in v] for v in (origin, direction))
    a, b, c = ([Fraction(float(x)) for x in v] for v in corners)
    u, v = ([y - x for x, y in zip(a, q, strict=True)] for q in (b, c))
    n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
    along = sum(x * y for x, y in zip(n, d, strict=True))
    return sum(x * (y - z) for x, y, z in zip(n, a, o, strict=True)) / along


@pytest.mark.parametrize("shift", [0.0, 1e6])
def test_points_against_exact_arithmetic(rng, shift):
    """Near the origin and 1e6 away: to rounding of the numbers that are given."""
    corners = rng.normal(size=(150, 3, 3)) + shift
    shares = rng.dirichlet([1, 1, 1], 150)
    target = np.einsum("ni,nij->nj", shares, corners)
    origins = target + rng.normal(size=(150, 3)) * 3
    directions = target - origins
    for triangle, o, d in zip(corners, origins, directions, strict=True):
        found = Facets(triangle, ONE).intersect(o, d)
        normal = np.cross(triangle[1] - triangle[0], triangle[2] - triangle[0])
        normal /= np.linalg.norm(normal)
        grazing = abs(normal @ d) / np.linalg.norm(d)
        if found.count == 0:  # aimed at an edge but for rounding
            assert min(abs(float(s)) for s in exact_sides(o, d, triangle)) < 1e-9 * max(1, shift)
            continue
        t = float(exact_hit(o, d, triangle)) * np.linalg.norm(d)
        size = np.abs(o).max() + np.abs(triangle).max()
        assert abs(found.t[0] - t) <= 16 * np.finfo(float).eps * size / grazing
        assert abs((found.point[0] - triangle[0]) @ normal) <= 4 * np.finfo(float).eps * size
        assert 1 - abs(found.normal[0] @ normal) <= 1e-12
        assert found.normal[0] @ d < 0


def test_a_grazing_ray_stays_within_the_triangle(rng):
    directions = np.stack([np.ones(200), rng.normal(size=200) * 0.1, -rng.uniform(0.6e-16, 0.9e-16, 200)], 1)
    found = Facets(TRIANGLE, ONE).intersect((-1.0, 0.2, 1e-16), directions)
    t = found.t[found.count > 0, 0]
    assert len(t) > 100
    assert ((t > 0.99) & (t < 2.2)).all()


@pytest.mark.peers
def test_embree_agrees(rng):
    from trimesh.ray.ray_pyembree import RayMeshIntersector

    vertices, faces = star(rng, 3)
    mesh = trimesh.Trimesh(vertices, faces, process=False)
    origins = rng.normal(size=(20_000, 3)) * 3
    directions = rng.normal(size=(20_000, 3)) * 0.5 - origins
    theirs = RayMeshIntersector(mesh).intersects_first(origins, directions)
    ours = first(Facets(vertices, faces), origins, directions)
    assert np.mean(ours.hit != (theirs >= 0)) < 1e-3  # theirs counts in single precision
    both = ours.hit & (theirs >= 0)
    normals = mesh.face_normals[theirs[both]]
    start = vertices[faces[theirs[both], 0]]
    cosine = np.einsum("ij,ij->i", directions[both], normals)
    t = np.einsum("ij,ij->i", start - origins[both], normals) / cosine * np.linalg.norm(directions[both], axis=1)
    error = np.abs(ours.t[both] - t)
    assert np.quantile(error, 0.99) < 1e-12


@given(
    hnp.arrays(float, (3, 3), elements=st.floats(-10, 10)),
    hnp.arrays(float, 3, elements=st.floats(-10, 10)),
    st.tuples(st.floats(0.01, 1), st.floats(0.01, 1), st.floats(0.01, 1)),
)
@settings(max_examples=50, deadline=None)
def test_a_ray_to_a_place_inside_meets_it(corners, origin, weights):
    area = np.linalg.norm(np.cross(corners[1] - corners[0], corners[2] - corners[0]))
    target = np.average(corners, axis=0, weights=weights)
    normal = np.cross(corners[1] - corners[0], corners[2] - corners[0])
    if area < 1e-3 or abs(normal @ (target - origin)) < 1e-3:
        return
    found = Facets(corners, ONE).intersect(origin, target - origin)
    assert found.count == 1
    assert np.allclose(found.point[0], target, rtol=0, atol=1e-9)


# -- smooth shading ------------------------------------------------------------------------------------------


def test_smooth_normals_are_means_and_look_to_the_ray(rng):
    normals = np.array([[0.3, 0, 1], [0, 0.3, 2], [0, 0, 3.0]])
    surface = Facets(TRIANGLE, ONE, normals=normals)
    shares = np.array([0.2, 0.3, 0.5])
    found = surface.intersect(shares @ TRIANGLE + [0, 0, 1], (0, 0, -1))
    mean = shares @ (normals / np.linalg.norm(normals, axis=1, keepdims=True))
    assert np.allclose(found.normal[0], mean / np.linalg.norm(mean), atol=1e-15)
    below = surface.intersect(shares @ TRIANGLE - [0, 0, 1], (0, 0, 1))
    assert np.allclose(below.normal[0], -found.normal[0], atol=1e-15)


def test_smooth_normals_near_outlines_do_not_look_away(rng):
    tilted = np.array([[0.9, 0, 0.3]] * 3)
    surface = Facets(TRIANGLE, ONE, normals=tilted)
    direction = np.array([1.0, 0, -0.05])  # from above, but the mean normal looks away
    found = surface.intersect(np.array([0.3, 0.3, 0.0]) - direction, direction)
    assert found.normal[0] @ direction < 0
    assert found.normal[0] @ [0, 0, 1.0] > 0


@pytest.mark.compiles
def test_a_smooth_mesh_of_a_sphere_is_shaded_like_one():
    ball = trimesh.creation.icosphere(subdivisions=4)
    surface = Facets(ball.vertices, ball.faces, normals=ball.vertices)
    origin = np.array([0.0, -3.0, 0.0])
    directions = np.array([[0.2, 1, 0.1], [0, 1, 0.2], [-0.1, 1, -0.15]])
    ours, exact = first(surface, origin, directions), first(tracer.Sphere((0, 0, 0), 1.0), origin, directions)
    assert np.allclose(ours.normal, exact.normal, atol=3e-3)
    flat = first(Facets(ball.vertices, ball.faces), origin, directions)
    assert np.abs(flat.normal - exact.normal).max() > 1e-2
