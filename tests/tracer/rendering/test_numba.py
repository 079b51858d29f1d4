"""Scenes by numba: the bits of C, in pictures and in what rays meet, through the tree and without."""

from __future__ import annotations

import pickle
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from bladesmith import tracer
from bladesmith.codegen.build.extension import compiler
from bladesmith.codegen.status import Status
from bladesmith.errors import SceneError
from bladesmith.tracer.rendering import program
from bladesmith.tracer.surfaces import base

from ...support.build.numba_code import numba_text_as_python
from ...support.effort import FULL

compiles = [
    pytest.mark.compiles,
    pytest.mark.slow,
    pytest.mark.skipif(compiler() is None, reason="no C compiler"),
]
needs_both = [*compiles, pytest.mark.peers]
CAMERA = tracer.Camera.look_at((0.3, -8.0, 2.0), (0.0, 0.0, 0.5))
LIGHTS = [tracer.Light((4, -6, 8)), tracer.Light((-4, -3, 5), color=(0.4, 0.5, 0.9))]
#: `cost` is left out: C enters boxes that are a little larger.
LAYERS = ("color", "normal", "depth", "alpha")
#: Coordinates of rays that are none, or so long or short that their squares are no numbers.
SPECIAL = np.array([0.0, -0.0, 1.0, -1.0, np.inf, -np.inf, np.nan, 1e-310, 1e300, 5e-324, 1e-160, 1e160])


def few() -> list[tracer.Surface]:
    """Mirrors, a checkered floor, two spheres in one place."""
    return [
        tracer.Sphere((0, 0, 1), 0.9, material=tracer.Material(reflectivity=0.5)),
        tracer.Sphere((0, 0, 1), 0.9),
        tracer.Plane((0, 0, 1), -0.2, material=tracer.Material(reflectivity=0.3, checker=(0.1, 0.2, 0.1))),
        tracer.Disc((1.5, 0, 1), (0.2, -1, 0.3), 0.7, material=tracer.Material(reflectivity=1.0)),
    ]


def many() -> list[tracer.Surface]:
    """Flat and smooth triangles beside them: a tree."""
    u, v = np.meshgrid(np.linspace(0.3, 2.8, 7), np.linspace(0, 2 * np.pi, 12, endpoint=False), indexing="ij")
    round_ = np.stack([np.sin(u) * np.cos(v), np.sin(u) * np.sin(v), np.cos(u)], -1).reshape(-1, 3)
    corners = [12 * i + j for i in range(6) for j in range(12)]
    faces = np.array([[a, a + 12, a // 12 * 12 + (a + 1) % 12] for a in corners])
    smooth = tracer.Material(reflectivity=0.2)
    return [*few(), tracer.Facets(round_ * 0.6 + [-2, 0, 1], faces),
            tracer.Facets(round_ * 0.5 + [2, 2, 1], faces, normals=round_, material=smooth)]  # fmt: skip


def swept() -> list[tracer.Surface]:
    """A tube, a ribbon and a flat one, one of which a ray finds no single point on."""
    return [
        tracer.EvolvedCircles([((0, 0, 0), (0, 0, 1), 1.0), ((0, 1, 2), (0, 0.5, 1), 0.6)]),
        tracer.EvolvedPointPairs([((-2, 0, 0), (-1, 0.5, 0)), ((-2, 0, 2), (-1.5, 1, 2))]),
        tracer.EvolvedPointPairs([((1, 0, 0), (2, 0, 0)), ((1, 0, 1), (2, 0, 1))]),
    ]


#: Those that numba compiles, for half a minute and more each: the text of all of them runs as Python.
SCENES = (few, many, swept) if FULL else (few,)


def rays(random: np.random.Generator, count: int) -> tuple[np.ndarray, np.ndarray]:
    origins, directions = 3 * random.normal(size=(2, count, 3))
    directions[: count // 4] = np.round(directions[: count // 4])  # along axes and in the planes of sides
    for array in (origins[count // 2 :], directions[count // 2 :]):
        array[:] = np.where(random.random(array.shape) < 0.2, random.choice(SPECIAL, array.shape), array)
    return origins, directions


def same(found, expected) -> None:
    assert found.dtype == expected.dtype and np.array_equal(found, expected, equal_nan=found.dtype.kind == "f")


def assert_same_pictures_and_hits(surfaces, width: int, count: int) -> None:
    """Of a picture so wide, and of so many rays."""
    scene = tracer.Scene(CAMERA, LIGHTS, surfaces(), reflections=4)
    assert scene.needs.tree == (surfaces is many)
    size = width, 3 * width // 4
    found = scene.layers(*size, LAYERS, antialias=2, target="numba", threads=2)
    expected = scene.layers(*size, LAYERS, antialias=2)
    for name in LAYERS:
        same(found[name], expected[name])
    assert len(np.unique(expected["depth"])) > (0.1 if surfaces is swept else 0.3) * width * size[1]
    origins, directions = rays(np.random.default_rng(4), count)
    with np.errstate(all="ignore"):
        ours, theirs = (scene.intersect(origins, directions, target=target) for target in ("numba", "c"))
    for name in ("t", "surface", "status", "point", "normal", "alpha", "hit"):
        same(getattr(ours, name), getattr(theirs, name))
    hidden = 0 if surfaces is swept else 1  # of two spheres in one place
    assert count / 20 < theirs.hit.sum() < count and len(np.unique(theirs.surface)) == 1 + len(scene.surfaces) - hidden
    assert surfaces is not swept or {Status.OK, Status.SINGULAR, Status.INVALID} <= set(theirs.status.tolist())
    same(scene.intersect(origins[0], directions[0], target="numba").t, theirs.t[0])  # one ray
    single = scene.render(*size, dtype=np.float32, target="numba")  # computed in double precision
    same(single, scene.render(*size, target="numba").astype(np.float32))


@pytest.mark.parametrize("surfaces", [pytest.param(each, marks=needs_both) for each in SCENES])
def test_pictures_and_hits_have_the_bits_of_c(surfaces) -> None:
    assert_same_pictures_and_hits(surfaces, 48, 6000)


@pytest.mark.parametrize("surfaces", [pytest.param(each, marks=compiles) for each in (many, swept)])
def test_pictures_and_hits_of_the_text_run_as_python(surfaces) -> None:
    program.numba_engine.cache_clear()
    with numba_text_as_python():
        assert_same_pictures_and_hits(surfaces, 8, 2400)
        compare_all_points(surfaces()[1 if surfaces is swept else 4], 300)
    program.numba_engine.cache_clear()


@pytest.mark.parametrize("surfaces", [pytest.param(many if FULL else few, marks=needs_both)])
def test_nothing_compiled_and_no_compiler(surfaces, monkeypatch, caplog) -> None:
    scene = tracer.Scene(CAMERA, LIGHTS, surfaces(), reflections=4)
    expected = scene.render(16, 12)
    surface = -2 if FULL else 0
    points = scene.surfaces[surface].intersect(*rays(np.random.default_rng(5), 400))
    monkeypatch.setattr(program, "compiler", lambda: None)
    monkeypatch.setattr(program, "_stock", lambda: None)
    program.engine_for.cache_clear()
    try:
        again = tracer.Scene(CAMERA, LIGHTS, surfaces(), reflections=4)
        with ThreadPoolExecutor(2) as pool:
            same(again.render(16, 12, executor=pool), expected)
        same(pickle.loads(pickle.dumps(again)).render(16, 12, dtype=np.float32), expected.astype(np.float32))
        found = again.surfaces[surface].intersect(*rays(np.random.default_rng(5), 400))
        for name in ("t", "count", "row", "status", "point", "normal", "alpha"):
            same(getattr(found, name), getattr(points, name))
        assert points.count.max() > 1
    finally:
        program.engine_for.cache_clear()
    assert any(r.getMessage().startswith("scenes run by numba: ") for r in caplog.records)


@pytest.mark.skipif(not FULL, reason="no full bars: half a minute of numba for text that runs as Python above")
@pytest.mark.parametrize("surfaces", [pytest.param(swept, marks=needs_both)])
def test_all_points_of_surfaces_along_curves(surfaces) -> None:
    compare_all_points(surfaces()[1], 3000)


def compare_all_points(surface: tracer.Surface, count: int) -> None:
    """What so many rays meet of a surface has the bits of C."""
    given = rays(np.random.default_rng(6), count)
    expected = surface.intersect(*given)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(base, "engine_for", program.numba_engine)
        found = surface.intersect(*given)
    for name in ("t", "count", "row", "status", "point", "normal", "alpha"):
        same(getattr(found, name), getattr(expected, name))
    assert expected.count.max() > 1


def test_a_target_that_is_none() -> None:
    scene = tracer.Scene(CAMERA, LIGHTS, few())
    with pytest.raises(SceneError, match="target is 'nvidia'.*numba"):
        scene.intersect([0, -9, 0], [0, 1, 0], target="nvidia")
