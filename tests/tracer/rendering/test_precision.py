"""Rays at the ends of single and of double precision: no point is lost, and what is no number has a status."""

from __future__ import annotations

import numpy as np
import pytest

from bladesmith import Status, tracer

from ...support.tracer.scenes import CAMERA


def shapes(size: float) -> dict[str, tracer.Surface]:
    corners = size * np.array([[-1, -1, 0], [1, -1, 0], [0, 1, 0.2]])
    return {
        "plane": tracer.Plane((0, 0, 1), 0.1 * size),
        "sphere": tracer.Sphere((0.1 * size, 0, 0), size),
        "disc": tracer.Disc((0, 0, 0.1 * size), (0.1, 0, 1), size),
        "facets": tracer.Facets(corners, [[0, 1, 2]]),
        "tube": tracer.EvolvedCircles([((0, 0, 0), (0, 0, 1), size), ((0, 0.2 * size, size), (0, 0.1, 1), 0.8 * size)]),
    }


def rays(count: int = 100) -> tuple[np.ndarray, np.ndarray]:
    random = np.random.default_rng(5)
    origins, targets = 3 * random.normal(size=(count, 3)), 0.4 * random.normal(size=(count, 3))
    return origins, targets - origins


@pytest.mark.compiles
@pytest.mark.parametrize("exponent", [-37, -20, -12, -8, 11, 19, 30, 37])
@pytest.mark.parametrize("name", ["plane", "sphere", "disc", "facets", "tube"])
def test_single_precision_loses_no_point_at_any_size(name: str, exponent: int) -> None:
    """Against the same scene of size 1 in double precision."""
    origins, directions = rays()
    size = 10.0**exponent
    expected = shapes(1.0)[name].intersect(origins, directions)
    surface = shapes(size)[name]
    found = surface.intersect((size * origins).astype(np.float32), directions.astype(np.float32))
    assert found.t.dtype == found.point.dtype == np.float32
    assert (found.count == expected.count).all()
    assert (found.status == Status.OK).all()
    there = np.isfinite(expected.t)
    assert there.any()
    assert np.allclose(found.t[there] / size, expected.t[there], rtol=1e-4, atol=1e-4)
    if name != "sphere":
        return  # the first hits of a scene go the same way for all
    scene = tracer.Scene(CAMERA, [], [surface])
    first = scene.intersect((size * origins).astype(np.float32), directions.astype(np.float32))
    nearest = np.where(expected.t > 0, expected.t, np.inf).min(axis=-1)
    assert (first.hit == np.isfinite(nearest)).all()
    assert np.allclose(first.t[first.hit] / size, nearest[first.hit], rtol=1e-4, atol=1e-4)


def test_a_point_beyond_single_precision_has_a_status_though_its_distance_is_finite() -> None:
    plane = tracer.Plane((0, 0, 1), 0)
    origin, direction = np.array([3e38, 0, 1], np.float32), np.array([1, 0, -0.9e-38], np.float32)
    lines = plane.intersect(origin, direction)
    assert lines.status == Status.INVALID
    assert lines.count == 0
    assert np.isnan(lines.point).all()
    hits = tracer.Scene(CAMERA, [], [plane]).intersect(origin, direction)
    assert hits.status == Status.INVALID
    assert not hits.hit
    assert hits.surface == -1
    assert np.isnan(hits.t)
    assert np.isnan(hits.point).all()


def test_pictures_in_single_precision_of_large_scenes() -> None:
    def picture(size: float, dtype: type) -> np.ndarray:
        camera = tracer.Camera.look_at((0, -4 * size, 0), (0, 0, 0))
        scene = tracer.Scene(camera, [tracer.Light((0, -9 * size, 9 * size))], [tracer.Sphere((0, 0, 0), size)])
        return scene.render(12, 8, dtype=dtype)

    large = picture(1e25, np.float32)
    assert large.dtype == np.float32
    assert np.allclose(large, picture(1.0, np.float64), atol=1e-5)


@pytest.mark.parametrize("surfaces", [[], [tracer.Disc((0, 0, 5), (0, 0, 1), 1)]])
def test_a_point_beyond_double_precision_has_a_status(surfaces):
    """A plane is met 1e308 from an origin at 1.7e308: the point is no number. With and without vectors."""
    plane = tracer.Plane((0, 0, 1), 0)
    origins, directions = (
        np.array([[1.7e308, 0, 1], [0, 0, 1], [1e308, 0, 0]]),
        np.array([[1, 0, -1e-308], [0, 0, -1], [0, 0, 1]]),
    )
    lines = plane.intersect(origins, directions)
    assert lines.status.tolist() == [Status.INVALID, Status.OK, Status.OK] and lines.count.tolist() == [0, 1, 1]
    assert np.isnan(lines.point[0]).all()
    hits = tracer.Scene(CAMERA, [], [plane, *surfaces]).intersect(origins, directions)
    assert hits.status.tolist() == [Status.INVALID, Status.OK, Status.OK] and hits.surface.tolist() == [-1, 0, -1]
    assert np.isnan(hits.t[0]) and np.isnan(hits.point[0]).all() and hits.t[1] == 1
