"""All points of a line, and several rays at once."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

from bladesmith import cga3d, tracer
from bladesmith.codegen.execute import ranges
from bladesmith.curves import KochanekBartels
from bladesmith.errors import InputError
from bladesmith.tracer.rendering.hits import FEW_RAYS
from bladesmith.tracer.scene.render_options import ray_options

from ...support.tracer.lattices import CAMERA, FIELDS

# -- all points of a line --------------------------------------------------------------------------------------


def test_all_points_of_a_line_on_many_rows():
    """A stack of triangles: a line through all of them has as many points, whatever room there was at first."""
    if not hasattr(tracer, "Facets"):
        pytest.importorskip("bladesmith.tracer.surfaces.triangles")
    from bladesmith.tracer.surfaces.triangles import Facets

    count = 500
    corners = np.array([(-1.0, -1, 0), (2, -1, 0), (-1, 2, 0)])
    vertices = (corners + np.array([0, 0, 1.0]) * np.arange(count)[:, None, None]).reshape(-1, 3)
    faces = np.arange(3 * count).reshape(-1, 3)
    order = np.random.default_rng(7).permutation(count)
    stack = Facets(vertices, faces[order])
    found = stack.intersect([(0.1, 0.2, -3), (9.0, 9, -3), (0.1, 0.2, 9.5)], [(0, 0, 2), (0, 0, 1), (0, 0, -1)])
    assert found.count.tolist() == [count, 0, count] and found.t.shape == (3, count)
    np.testing.assert_allclose(found.t[0], 3.0 + np.arange(count), rtol=1e-13)
    np.testing.assert_array_equal(found.row[0], np.argsort(order))
    assert np.all(np.diff(found.t[2]) > 0) and np.isnan(found.t[1]).all() and np.all(found.row[1] == -1)
    hits = tracer.Scene(CAMERA, [], [stack]).intersect((0.1, 0.2, -3), (0, 0, 2))
    assert hits.t == pytest.approx(3.0)


def test_a_point_on_the_joint_of_two_pieces_counts_once():
    circles = [((0, 0, z), (0, 0, 1), 1.0) for z in (0.0, 1.0, 2.0, 3.0)]
    tube = tracer.EvolvedCircles(KochanekBartels([cga3d.circle(*c) for c in circles]))
    assert len(tube.parameters) == 3
    origins = [(-5.0, 0.1, 1.0), (-5.0, 0.1, 0.5), (-5.0, 0.1, 2.0)]
    assert tube.intersect(origins, [(1, 0, 0)] * 3).count.tolist() == [2, 2, 2]


# -- several rays at once --------------------------------------------------------------------------------------


@pytest.mark.compiles
@pytest.mark.parametrize("dtype", [np.float64, np.float32])
@pytest.mark.parametrize("count", [1, 2, 3, 7, 8, 9, 500])
def test_several_rays_at_once_meet_what_each_meets(dtype, count):
    """t, surface and status are found at first; the rest is found again, ray by ray, and has to be the same."""
    random = np.random.default_rng(count)
    surfaces = [tracer.Plane((0, 0, 1), -1.0), tracer.Sphere((0, 0, 0), 1.0), tracer.Sphere((0, 0, 0), 1.0)]
    for order in (surfaces, surfaces[::-1]):
        scene = tracer.Scene(CAMERA, [], order)
        assert scene.needs.wide
        origins, directions = random.integers(-3, 4, (2, count, 3)).astype(dtype)
        origins[::5] = np.nan
        directions[1::7, 1] = np.inf
        hits = scene.intersect(origins, directions)
        directly = scene._bound_scene(ray_options("isolate", 64, np.dtype(dtype))).first(origins, directions)
        for name in FIELDS:
            np.testing.assert_array_equal(getattr(hits, name), directly[name], err_msg=name)
        assert np.array_equal(hits.hit, hits.surface >= 0)
        assert not np.any(hits.surface == max(order.index(same) for same in surfaces[1:]))
    one = scene.intersect(origins[-1], directions[-1])
    assert one.t.shape == () and one.point.shape == (3,)


CHANGES = {
    "along the plane": lambda o, d: np.add(o, [1.0, 2.0, 0.0], out=o),
    "mirrored": lambda o, d: (np.multiply(o, [-1, -1, 1], out=o), np.multiply(d, [-1, -1, 1], out=d)),
    "origins mirrored": lambda o, d: np.multiply(o, [-1, 1, 1], out=o),
    "exchanged": lambda o, d: o.__setitem__((slice(None), [0, 1]), o[:, [1, 0]]),
    "rays exchanged": lambda o, d: (o.__setitem__([5, 6], o[[6, 5]]), d.__setitem__([5, 6], d[[6, 5]])),
    "one bit": lambda o, d: o.__setitem__((4000, 0), np.nextafter(o[4000, 0], o.dtype.type(np.inf))),
    "the sign of a zero": lambda o, d: d.__setitem__((9000, 0), -d[9000, 0]),
}


@pytest.mark.parametrize("dtype", [np.float64, np.float32])
@pytest.mark.parametrize("name", CHANGES)
def test_rays_that_are_changed_before_points_are_asked_for_are_noticed(name, dtype):
    """Also where distances and surfaces stay the same: points and normals would be others without a word."""
    scene = tracer.Scene(CAMERA, [], [tracer.Plane((0, 0, 1), 0.0)])
    random = np.random.default_rng(8)
    few = 10
    for count in (few, FEW_RAYS + 1, 10_007):
        origins, directions = random.integers(-3, 4, (2, 10_007, 3)).astype(dtype)
        origins[:, 2], directions[:, 2] = 5, -1
        directions[9000, 0] = 0.0
        expected = scene.intersect(origins, directions).point[:count]
        again = pickle.loads(pickle.dumps(scene.intersect(origins[:count], directions[:count])))
        hits = scene.intersect(origins[:count], directions[:count])
        before = origins[:count].tobytes() + directions[:count].tobytes()
        CHANGES[name](origins, directions)
        np.testing.assert_array_equal(again.point, expected)
        if count > few and origins[:count].tobytes() + directions[:count].tobytes() != before:
            with pytest.raises(InputError, match="changed"):
                _ = hits.point
        else:
            np.testing.assert_array_equal(hits.point, expected)
        assert "t=" in repr(hits)


@pytest.mark.parametrize("threads", [1, 2])
def test_a_change_is_noticed_wherever_it_is_among_many_rays(threads):
    """Several checksums are made by one call."""
    scene = tracer.Scene(CAMERA, [], [tracer.Plane((0, 0, 1), 0.0)])
    count = 20 * FEW_RAYS + 3
    origins, directions = np.tile([0.0, 0.0, 5.0], (count, 1)), np.tile([0.0, 0.5, -1.0], (count, 1))
    assert len(scene.intersect(origins, directions, threads=threads).point) == count
    for place in (0, FEW_RAYS, 7 * FEW_RAYS - 1, 16 * FEW_RAYS, count - 1):
        hits = scene.intersect(origins, directions, threads=threads)
        origins[place, 0] += 1.0
        with pytest.raises(InputError, match="changed"):
            _ = hits.point


@pytest.mark.parametrize("count", [100, FEW_RAYS, 5 * FEW_RAYS + 3])
def test_rays_that_took_long_are_not_taken_for_changed(monkeypatch, count):
    """However long a call took, ranges begin where checksums do."""
    scene = tracer.Scene(CAMERA, [], [tracer.Plane((0, 0, 1), 0.0)])
    origins, directions = np.random.default_rng(3).normal(size=(2, count, 3))
    for threads in (1, 2):
        with monkeypatch.context() as patch:
            patch.setattr(ranges, "LONGEST", 1e-9)
            hits = scene.intersect(origins, directions, threads=threads)
        assert hits.point.shape == (count, 3)


def test_rays_without_points_are_asked_in_any_shape_and_number_of_threads():
    scene = tracer.Scene(CAMERA, [], [tracer.Plane((0, 0, 1), 0.0)])
    directions = np.random.default_rng(9).normal(size=(90, 3, 100))
    for origin in (np.array([0.0, 0, 5]), np.full((90, 100, 3), 5.0)):
        hits = scene.intersect(origin, directions.transpose(0, 2, 1), threads=2)
        assert hits.point.shape == (90, 100, 3)
        np.testing.assert_allclose(hits.point[hits.hit][:, 2], 0.0, atol=1e-12)
