"""The tree over surfaces finds what asking each finds, bit for bit; statuses, ties; the tree itself."""

from __future__ import annotations

import numpy as np
import pytest

from bladesmith import tracer
from bladesmith.codegen.programs.tracer.records import SCENE
from bladesmith.codegen.programs.tracer.scene import TREE_PAYS, TREE_PAYS_WIDE, needs
from bladesmith.status import Status
from bladesmith.tracer.acceleration.bvh import NODE, PARTS, round_outward, tree_over
from bladesmith.tracer.rendering.program import engine_for
from bladesmith.tracer.rendering.scene_arrays import scene_arrays
from bladesmith.tracer.rendering.surface_tables import SurfaceTable, SurfaceTables

from ...support.tracer.lattices import CAMERA, both, lattice, rays

EMPTY = -(2**31)


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
    nodes = tree.packed.view(NODE)[1:]
    table = SurfaceTable(np.zeros((len(boxes), 4)), np.zeros(len(boxes), np.int32), boxes)
    integers, _ = scene_arrays(["sphere"], SurfaceTables(sphere=table), tree, np.float64, {}, {}, is_c=True)
    begin = SCENE.view(integers[: SCENE.size]).tree_at
    assert integers[int(begin) :].ctypes.data % 64 == 0 and nodes.itemsize == 128
    assert integers[int(begin) :].tobytes() == tree.packed.tobytes()
    there = tree.parts != EMPTY
    exact = ((tree.boxes - np.tile(tree.center, 2)[:, None]) * tree.unit).transpose(0, 2, 1)[there]
    found = nodes["boxes"].transpose(0, 2, 1)
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
