"""The tree over surfaces finds what asking each finds, bit for bit; statuses, ties, lines with many points."""

from __future__ import annotations

import pickle
from dataclasses import replace

import numpy as np
import pytest

from bladesmith import cga3d, tracer
from bladesmith.codegen.programs.tracer.scene import TREE_PAYS, TREE_PAYS_WIDE, needs
from bladesmith.codegen.programs.tracer.surface_kinds import in_order
from bladesmith.curves import KochanekBartels
from bladesmith.errors import InputError
from bladesmith.status import Status
from bladesmith.tracer.acceleration.bvh import PARTS, round_outward, tree_over
from bladesmith.tracer.rendering.hits import FEW_RAYS
from bladesmith.tracer.rendering.program import engine_for
from bladesmith.tracer.scene.render_options import ray_options

CAMERA = tracer.Camera.look_at((0.0, -8.0, 2.0), (0.0, 0.0, 0.5))
FIELDS = ("t", "surface", "status", "point", "normal", "alpha")
EMPTY = -(2**31)


def both(surfaces, origins, directions):
    """First hits with and without a tree; the same bits, or the test fails."""
    found = []
    for tree in (True, False):
        scene = tracer.Scene(CAMERA, [], surfaces)
        kinds = in_order({*scene.needs.kinds, "plane", "sphere", "disc"})  # few programs for all tests
        scene.__dict__["needs"] = replace(scene.needs, kinds=kinds, tree=tree, single=True, pictures=False)
        found.append(scene.intersect(origins, directions))
    for name in FIELDS:
        np.testing.assert_array_equal(getattr(found[0], name), getattr(found[1], name), err_msg=name)
    return found[0]


def lattice(random, count, scale, shift):
    """Spheres and discs on a lattice: equal distances, equal surfaces, boxes in one plane, rays along their sides."""
    corners = random.integers(-3, 4, (count, 3)) * scale + shift
    spheres = [
        tracer.Sphere(c, r * scale) for c, r in zip(corners, random.choice([0.2, 0.25, 0.5, 1.0], count), strict=True)
    ]
    normals = random.choice([0.0, 0.0, 1.0, 0.5], (count, 3))
    normals[~normals.any(axis=1)] = (0, 0, 1)
    corners = random.integers(-3, 4, (count, 3)) * scale + shift
    discs = [tracer.Disc(c, n, 0.3 * scale) for c, n in zip(corners, normals, strict=True)]
    return [*spheres, *discs, tracer.Plane((0, 0, 1), -3.0 * scale)]


def rays(random, count, scale, shift):
    """Some on the lattice and along its axes, some not."""
    origins = random.integers(-5, 6, (count, 3)) * scale + shift
    directions = random.integers(-1, 2, (count, 3)).astype(float)
    origins[::2] += random.normal(size=origins[::2].shape) * scale
    directions[::3] += random.normal(size=directions[::3].shape)
    directions[5::7] *= -0.0  # zero components of both signs, and no direction at all
    directions[5::7, 1] = -1.0
    return origins, directions


def tubes(random, count, scale=1.0, shift=0.0):
    made = []
    for center in random.uniform(-2, 2, (count, 3)):
        axis = random.normal(size=3)
        axis /= np.linalg.norm(axis)
        end = center + 0.4 * axis + 0.1 * random.normal(size=3)
        circles = [(center, axis, 0.2), (end, axis + 0.3 * random.normal(size=3), 0.15)]
        made.append(tracer.EvolvedCircles([(c * scale + shift, n, r * scale) for c, n, r in circles]))
    return made


@pytest.mark.compiles
@pytest.mark.parametrize("dtype", [np.float64, np.float32])
@pytest.mark.parametrize(("scale", "shift"), [(1.0, 0.0), (1.0, 1e3), (1e-6, 0.0), (1e6, 1e7)])
def test_the_tree_changes_no_bit(dtype, scale, shift):
    random = np.random.default_rng(1)
    surfaces = lattice(random, 150, scale, shift)
    origins, directions = rays(random, 4000, scale, shift)
    hits = both(surfaces, origins.astype(dtype), directions.astype(dtype))
    assert 0.2 < hits.hit.mean() < 0.95


@pytest.mark.parametrize("dtype", [np.float64, np.float32])
def test_the_tree_changes_no_bit_of_small_surfaces_among_large_ones(dtype):
    """Boxes of nodes have 32 bits of the whole: smaller surfaces are all asked."""
    random = np.random.default_rng(9)
    places = random.normal(size=(120, 3)) * 1e-7 + (1.0, 2.0, 3.0)
    small = [tracer.Disc(c, n, 1e-8) for c, n in zip(places, random.normal(size=(120, 3)), strict=True)]
    large = [tracer.Sphere((900.0 * i, 0, 5000), 500.0) for i in range(4)]
    origins = random.normal(size=(2000, 3)) * random.choice([1.0, 50.0], (2000, 1))
    directions = places[random.integers(0, 120, 2000)] + random.normal(size=(2000, 3)) * 5e-9 - origins
    hits = both([*small, *large], origins.astype(dtype), directions.astype(dtype))
    met = (hits.surface >= 0) & (hits.surface < 120)
    assert met.mean() > (0.5 if dtype == np.float64 else 0.0) and (hits.surface >= 120).any()


@pytest.mark.parametrize("dtype", [np.float64, np.float32])
def test_the_tree_changes_no_bit_of_rays_from_far_away(dtype):
    random = np.random.default_rng(2)
    surfaces = lattice(random, 100, 1.0, 0.0)
    targets = random.normal(size=(3000, 3)) * 2
    directions = random.normal(size=(3000, 3))
    origins = targets - directions * random.choice([1e2, 1e4, 1e6], (3000, 1))
    assert both(surfaces, origins.astype(dtype), directions.astype(dtype)).hit.any()


@pytest.mark.compiles
def test_evolved_surfaces_in_a_tree():
    random = np.random.default_rng(3)
    surfaces = [*tubes(random, 25), *lattice(random, 10, 0.5, 0.0)]
    opening = [((-1, 0, 0), (0, 0, 1), 1.0), ((1, 0, 0), (0, 0, -1), 1.0)]  # into a line: unbounded
    surfaces.insert(0, tracer.EvolvedCircles(opening, align=False, gaps=True))
    origins = random.normal(size=(1500, 3)) * 4
    directions = random.uniform(-2, 2, (1500, 3)) - origins
    for dtype in (np.float64, np.float32):
        hits = both(surfaces, origins.astype(dtype), directions.astype(dtype))
        assert np.isfinite(hits.alpha).sum() > 50 and (hits.surface == 0).any()


def test_of_equally_near_surfaces_the_lowest_number_wins():
    random = np.random.default_rng(4)
    same = [tracer.Sphere((0, 0, 0), 1.0) for _ in range(30)]
    flat = [tracer.Disc((0, 0, 1), (0, 0, 1), 0.5) for _ in range(30)]
    filler = [tracer.Sphere(c, 0.1) for c in random.normal(size=(30, 3)) * 9 + 40]
    for order in ([*filler, *same], [*filler, *flat, *same], [*same, *filler, *flat]):
        hits = both(order, (0, 0, 5), (0, 0, -1))
        nearest = [i for i, s in enumerate(order) if s in same or s in flat]
        assert hits.surface == nearest[0]
    plane = tracer.Plane((0, 0, 1), 1.0)
    for order, winner in (([*filler, plane, *same], 30), ([*filler, same[0], plane], 30)):
        assert both(order, (0.0, 0.0, 5), (0, 0, -1)).surface == winner


def test_bad_rays_and_no_rays():
    surfaces = [tracer.Sphere((i, 0, 0), 0.3) for i in range(TREE_PAYS + 5)]
    assert both(surfaces, np.zeros((0, 3)), (0, 0, 1)).t.shape == (0,)
    hits = both(surfaces, [(0, 0, 5), (np.nan, 0, 5), (0, 0, 5), (0, np.inf, 0)], [(0, 0, -1)] * 2 + [(0, 0, 0)] * 2)
    assert hits.status.tolist() == [Status.OK, Status.INVALID, Status.INVALID, Status.INVALID]


def test_a_status_is_kept_unless_its_surface_begins_behind_the_hit():
    """A tube of coplanar circles: a ray in their plane meets all of them."""
    flat = [((0, 0, 0), (0, 0, 1), 1.0), ((1, 0, 0), (0, 0, 1), 1.5)]
    ring = tracer.EvolvedCircles(flat)
    front, back = tracer.Sphere((0, -9, 0), 1.0), tracer.Sphere((0, 9, 0), 1.0)
    filler = [tracer.Sphere((50 + i, 0, 0), 0.1) for i in range(TREE_PAYS)]
    along, past = ((0, -20, 0), (0, 1, 0)), ((0.1, -3, 0), (0, 1, 0))
    for order in ([ring, front, back, *filler], [front, back, *filler, ring]):
        assert both(order, *past).status == Status.SINGULAR
        assert both(order, *past).surface == order.index(back)
        hidden = both(order, *along)
        assert hidden.status == Status.OK and hidden.surface == order.index(front)


def test_scenes_get_a_tree_when_it_pays():
    for most, make in (
        (TREE_PAYS, lambda i: tracer.Disc((i, 0, 0), (0, 0, 1), 0.3)),
        (TREE_PAYS_WIDE, lambda i: tracer.Sphere((i, 0, 0), 0.3)),
    ):
        few = [make(i) for i in range(most - 1)]
        assert not tracer.Scene(CAMERA, [], few).needs.tree
        assert tracer.Scene(CAMERA, [], [*few, few[0]]).needs.tree
        assert not any("box" in name for name in tracer.Scene(CAMERA, [], few).kernels)


# -- the tree itself -----------------------------------------------------------------------------------------


def check_tree(tree, boxes):
    """Every item once, within the boxes of all nodes above it; no level deeper than the driver has room for."""
    seen, waiting = [], [(0, np.array([-np.inf] * 3 + [np.inf] * 3), 1)]
    deepest = 0
    while waiting:
        node, outer, level = waiting.pop()
        deepest = max(deepest, level)
        for c in range(PARTS):
            part, box = tree.parts[node, c], tree.boxes[node, :, c]
            if part == EMPTY:
                continue
            assert np.all(box[:3] >= outer[:3]) and np.all(box[3:] <= outer[3:])
            if part >= 0:
                waiting.append((part, box, level + 1))
            else:
                np.testing.assert_array_equal(box, boxes[~part])
                seen.append(~part)
    assert sorted(seen) == list(range(len(boxes)))
    assert deepest <= 48
    return deepest


def check_nodes(tree, boxes):
    """Boxes of 32 bits hold the others and are hardly larger; where there is no part, nothing is inside."""
    np.testing.assert_array_equal(tree.whole, [*boxes[:, :3].min(axis=0), *boxes[:, 3:].max(axis=0)])
    assert tree.nodes.ctypes.data % 64 == 0 and tree.nodes.itemsize == 128
    there = tree.parts != EMPTY
    exact = ((tree.boxes - np.tile(tree.center, 2)[:, None]) * tree.unit).transpose(0, 2, 1)[there]
    found = tree.nodes["boxes"].transpose(0, 2, 1)
    assert np.all(found[there][:, :3] <= exact[:, :3]) and np.all(found[there][:, 3:] >= exact[:, 3:])
    np.testing.assert_allclose(found[there], exact, rtol=2**-23, atol=1e-44)
    assert np.all(found[~there] == [np.inf] * 3 + [-np.inf] * 3)
    half = np.abs(exact).max()
    assert 0.5 <= half <= 1 or half == 0


def boxes_of(low, size):
    return np.concatenate([low, low + size], axis=1)


@pytest.mark.parametrize(
    ("name", "make"),
    [
        ("spread", lambda random: boxes_of(random.normal(size=(3000, 3)), random.uniform(0, 0.1, (3000, 3)))),
        ("one place", lambda random: np.zeros((500, 6))),
        ("nested", lambda random: np.arange(1, 400)[:, None] * np.array([[-1.0] * 3 + [1.0] * 3])),
        ("powers", lambda random: boxes_of(2.0 ** -np.arange(600)[:, None] * np.ones(3), np.zeros((600, 3)))),
        ("huge", lambda random: boxes_of(random.normal(size=(200, 3)) * 1e300, np.full((200, 3), 1e299))),
        ("one", lambda random: boxes_of(random.normal(size=(1, 3)), np.ones((1, 3)))),
        ("five", lambda random: boxes_of(random.normal(size=(5, 3)), np.ones((5, 3)))),
    ],
)
def test_trees_hold_every_item_once(name, make):
    boxes = make(np.random.default_rng(5))
    engine = engine_for(needs(["sphere"], pictures=False, rows=TREE_PAYS_WIDE))
    tree = tree_over(engine, [boxes])
    deepest = check_tree(tree, boxes)
    assert name != "spread" or deepest <= 16
    again = tree_over(engine, [boxes])
    np.testing.assert_array_equal(again.parts, tree.parts)
    check_nodes(tree, boxes)


def test_unbounded_rows_are_loose():
    engine = engine_for(needs(["sphere"], pictures=False, rows=TREE_PAYS_WIDE))
    boxes = boxes_of(np.zeros((4, 3)), np.ones((4, 3)))
    boxes[1, 3:] = np.inf
    boxes[2] = np.nan
    tree = tree_over(engine, [np.zeros((0, 6)), boxes])
    assert tree.unbounded == 2 and tree.items.tolist() == [[1, 0], [1, 3], [1, 1], [1, 2]]
    empty = tree_over(engine, [])
    assert empty.parts.shape == (0, PARTS) and empty.unbounded == 0


def test_boxes_of_less_precision_hold_the_others():
    random = np.random.default_rng(6)
    sides = random.normal(size=(500, 2, 3, 4)) * 10.0 ** random.integers(-3, 7, (500, 1, 1, 1))
    boxes = np.sort(sides, axis=1).reshape(500, 6, 4)
    single = round_outward(boxes, np.float32)
    assert single.dtype == np.float32
    assert np.all(single[:, :3] <= boxes[:, :3]) and np.all(single[:, 3:] >= boxes[:, 3:])
    np.testing.assert_allclose(single, boxes, rtol=3e-7)


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


def test_rays_without_points_are_asked_in_any_shape_and_number_of_threads():
    scene = tracer.Scene(CAMERA, [], [tracer.Plane((0, 0, 1), 0.0)])
    directions = np.random.default_rng(9).normal(size=(90, 3, 100))
    for origin in (np.array([0.0, 0, 5]), np.full((90, 100, 3), 5.0)):
        hits = scene.intersect(origin, directions.transpose(0, 2, 1), threads=2)
        assert hits.point.shape == (90, 100, 3)
        np.testing.assert_allclose(hits.point[hits.hit][:, 2], 0.0, atol=1e-12)


# -- directions of any length, numbers of any size ---------------------------------------------------------------


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
