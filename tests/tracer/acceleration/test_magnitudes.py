"""Rays with directions of any length and numbers of any size, in a tree."""

from __future__ import annotations

import numpy as np
import pytest

from bladesmith import tracer

from ...support.tracer.lattices import CAMERA, both


@pytest.mark.compiles
@pytest.mark.parametrize(
    ("dtype", "powers"), [(np.float64, (-1060, -500, 0, 40, 500, 1020)), (np.float32, (-140, -50, 0, 40, 120))]
)
def test_the_length_of_directions_does_not_matter(dtype, powers):
    random = np.random.default_rng(10)
    corners = np.array([(-1.0, -1, 0), (2, -1, 0), (-1, 2, 0)])
    facets = tracer.Facets((corners + random.normal(size=(30, 3, 3))).reshape(-1, 3), np.arange(90).reshape(-1, 3))
    many = [tracer.Disc(c, n, 0.5) for c, n in random.normal(size=(30, 2, 3))]
    origins = (4 * random.normal(size=(400, 3))).astype(dtype)
    directions = np.rint(1024 * (0.5 * random.normal(size=(400, 3)) - origins)).astype(dtype)
    for surfaces in ([facets], many, [tracer.Sphere((0, 0, 0), 1.0), tracer.Plane((0, 0, 1), -1.0)]):
        scene = tracer.Scene(CAMERA, [], surfaces)
        expected = scene.intersect(origins, directions)
        assert expected.hit.sum() > 50
        for power in powers:
            scaled = np.ldexp(directions, power - 14)
            whole = np.ldexp(scaled, 14 - power) == directions  # not those that lost digits among the least numbers
            hits = scene.intersect(origins, scaled)
            for name in ("t", "surface", "point", "normal", "status"):
                found, want = getattr(hits, name), getattr(expected, name)
                same = whole.all(axis=1)
                assert same.sum() > 50 or power < -1000 or power < -100 and dtype == np.float32
                np.testing.assert_array_equal(found[same], want[same], err_msg=name)
            for name in ("t", "point"):
                every = getattr(facets.intersect(origins[same], scaled[same]), name)
                np.testing.assert_array_equal(every, getattr(facets.intersect(origins[same], directions[same]), name))


@pytest.mark.compiles
@pytest.mark.parametrize("dtype", [np.float64, np.float32])
def test_what_is_farther_than_numbers_go_is_not_hit(dtype):
    huge = np.finfo(dtype).max / 2
    plane, rays = tracer.Plane((0, 0, 1), -2.0), (np.array([0, 0, huge], dtype), np.array([1, 1, -1e-5], dtype))
    hits = tracer.Scene(CAMERA, [], [plane]).intersect(*rays)
    directly = tracer.Scene(CAMERA, [], [plane, tracer.Disc((0, 0, 9), (0, 0, 1), 1.0)]).intersect(*rays)
    for found in (hits, directly):
        assert not found.hit and np.isnan(found.t) and np.isnan(found.point).all()
    assert plane.intersect(*rays).count == 0


def crowd(random, count, size, evolved):
    """Small surfaces close together, and for each a place on it, its size, a normal and two axes across."""
    made, frames = [], []
    for i in range(count):
        center, way = random.normal(size=3) * random.choice([1, 2 * size]), random.normal(size=(2, 3))
        normal = way[0] / np.linalg.norm(way[0])
        u = np.cross(normal, way[1])
        u /= np.linalg.norm(u)
        v, s = np.cross(normal, u), size * 10 ** random.uniform(-3, 0)
        if i % 5 == 0:
            made.append(tracer.Sphere(center, s))
        elif i % 5 == 1 or (i % 5 > 2 and not evolved):
            made.append(tracer.Disc(center, normal, s))
        elif i % 5 == 2:
            made.append(tracer.Facets(center + s * np.stack([u, v, -u - v]), [[0, 1, 2]]))
        elif i % 5 == 3:
            last = center + s * normal + 0.2 * s * u, normal + 0.2 * u, 0.7 * s
            made.append(tracer.EvolvedCircles([(center, normal, s), last]))
        else:
            ends = [center - s * u, center + s * u]
            moved = [ends[0] + s * (v + 0.1 * normal), ends[1] + s * (v - 0.2 * normal)]
            made.append(tracer.EvolvedPointPairs([ends, moved]))
        frames.append((center, [s] * 3, normal, u, v))
    return made, np.array(frames)


@pytest.mark.slow
@pytest.mark.parametrize(("dtype", "seed"), [(np.float64, 3), (np.float64, 31), (np.float32, 2), (np.float32, 5)])
def test_rays_from_a_million_sizes_away_that_graze(dtype, seed):
    """Nearly in the planes of discs, triangles and circles: what is hit, and where, hangs on rounding."""
    random = np.random.default_rng(seed)
    count = 2500
    for _ in range(16):
        made, frames = crowd(random, 60, 10 ** random.uniform(-3, 0), dtype == np.float64)
        center, size, normal, u, v = np.moveaxis(frames[random.integers(0, 60, count)], 1, 0)
        turn = random.uniform(0, 2 * np.pi, (count, 1))
        slope = 10 ** random.uniform(-17, 0, (count, 1)) * random.choice([-1, 0, 1], (count, 1))
        aside = random.choice([0, 0.3, 0.5, 1], (count, 1)) * random.random((count, 1)) ** 0.2
        along = np.where(random.random((count, 1)) < 0.4, u, np.cos(turn) * u + np.sin(turn) * v) + slope * normal
        targets = center + size * (
            random.choice([0, 1], (count, 1)) * random.uniform(-1, 1, (count, 1)) * u + aside * v
        )
        length = np.linalg.norm(along, axis=1, keepdims=True)
        origins = targets - along / length * 10 ** random.uniform(-2, 6, (count, 1))
        assert both(made, origins.astype(dtype), along.astype(dtype)).hit.mean() > 0.05
