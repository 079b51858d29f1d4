"""What a new user ran into: interrupts that libraries swallow, single precision at its ends, names, controls, files."""

from __future__ import annotations

import signal
import threading

import numpy as np
import pytest

from bladesmith import Status, interrupts, tracer
from bladesmith import cga3d as cga
from bladesmith.errors import SceneError
from bladesmith.tracer import evolved_tables, schema

CAMERA = tracer.Camera.look_at((0, -8, 2), (0, 0, 1))
RING = ((0.0, 0.0, 0.0), (0.0, 0.0, 1.0), 1.0)
OTHER = ((0.0, 1.0, 2.0), (0.0, 0.5, 1.0), 0.6)
HEAD = "[camera]\nposition = [0, -8, 2]\nlook_at = [0, 0, 0]\n"


# -- interrupts ---------------------------------------------------------------------------------------------


def test_an_interrupt_that_foreign_code_swallows_is_told_at_its_end() -> None:
    reached = False
    with pytest.raises(KeyboardInterrupt), interrupts.kept():
        try:
            signal.raise_signal(signal.SIGINT)
        except BaseException:  # as trimesh does around its imports
            pytest.fail("it should wait")
        reached = True
    assert reached
    with pytest.raises(KeyboardInterrupt):  # and the usual handler is back
        signal.raise_signal(signal.SIGINT)


def test_an_interrupt_wins_over_the_error_of_the_block() -> None:
    with pytest.raises(KeyboardInterrupt), interrupts.kept():
        signal.raise_signal(signal.SIGINT)
        raise ImportError("half of it")


def test_other_threads_and_processes_that_ignore_interrupts_are_left_alone() -> None:
    seen = []

    def work() -> None:
        with interrupts.kept():
            seen.append(True)

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert seen == [True]
    usual = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        with interrupts.kept():
            assert signal.getsignal(signal.SIGINT) is signal.SIG_IGN
    finally:
        signal.signal(signal.SIGINT, usual)


# -- single precision ---------------------------------------------------------------------------------------


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


# -- names --------------------------------------------------------------------------------------------------


def test_hits_know_the_names_of_their_surfaces() -> None:
    named = tracer.Sphere((0, 0, 0), 1)
    named.name = "ball"
    scene = tracer.Scene(CAMERA, [], [tracer.Disc((5, 0, 0), (0, 1, 0), 1), named])
    hits = scene.intersect([[(0, -9, 0), (5, -9, 0)], [(0, -9, 0), (9, -9, 0)]], (0, 1, 0))
    assert scene.names().tolist() == ["disc [0]", "ball"]
    assert scene.names(hits.surface).tolist() == [["ball", "disc [0]"], ["ball", ""]]
    assert tracer.Scene(CAMERA).names().tolist() == []
    for wrong in ([2], [-2], [0.5], "ball"):
        with pytest.raises(SceneError, match="places"):
            scene.names(wrong)


def test_meshes_of_scenes_keep_names() -> None:
    from bladesmith.tracer.meshing.scenes import scene_meshes

    surfaces = [tracer.Sphere((0, 0, 0), 1), tracer.Sphere((3, 0, 0), 1)]
    surfaces[1].name = "moon"
    names = [mesh.name for mesh, _ in scene_meshes(tracer.Scene(CAMERA, [], surfaces), None, 4, 4)]
    assert names == ["0 sphere", "1 moon"]


# -- controls -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("controls", "message"),
    [
        ({RING, OTHER}, "curve is a set"),
        ([({0, 1, 2}, (0, 0, 1), 1.0), OTHER], r"controls\[0\].center is {0, 1, 2}"),
        ([((0, 0, 0), (0, 0, 1), True), OTHER], r"controls\[0\].radius is True"),
        ([RING, ((0, 0, 0), (0, 0, 1), np.True_)], r"controls\[1\].radius"),
        ([(np.array([0, 0, 0], object), (0, 0, 1), 1.0), OTHER], r"controls\[0\].center"),
        ([(np.ma.array([0.0, 0, 0], mask=[0, 1, 0]), (0, 0, 1), 1.0), OTHER], r"controls\[0\].center"),
        (np.array([[np.zeros(3), np.ones(3), 1.0]] * 2, object), "array of type object"),
        (np.ma.array(np.ones((2, 10))), "masked numbers"),
        (np.ones((2, 10)) * 1j, "array of type complex128"),
        ([dict(zip(("center", "normal", "radius", "colour"), (*RING, 3), strict=True)), OTHER], "has 'colour'"),
        ([cga.point_pair((0, 0, 0), (1, 0, 0)), cga.point_pair((0, 0, 0), (1, 1, 0))], "is a point pair, no circle"),
        (cga.circle(np.zeros((2, 2, 3)), (0, 0, 1), 1.0), r"batch of shape \(2,\)"),
    ],
)
def test_what_is_no_row_of_circles_is_refused(controls: object, message: str) -> None:
    with pytest.raises(SceneError, match=message):
        tracer.EvolvedCircles(controls)


# -- files --------------------------------------------------------------------------------------------------


def test_curves_of_a_file_are_the_same_at_once_and_one_by_one(tmp_path) -> None:
    random, lines = np.random.default_rng(2), [HEAD]
    for i in range(30):
        count, (c, n) = 2 + i % 3, random.normal(size=(2, 5, 3)).tolist()
        if i % 2:
            rows = [f"{{ a = {c[k]}, b = {n[k]} }}" for k in range(count)]
        else:
            rows = [f"{{ center = {c[k]}, normal = {n[k]}, radius = {0.1 + k} }}" for k in range(count)]
        kind = "evolved_point_pairs" if i % 2 else "evolved_circles"
        align = str(i % 5 > 0).lower()
        lines.append(f"[[surfaces]]\nkind = '{kind}'\ngaps = true\nalign = {align}\ncontrols = [{', '.join(rows)}]\n")
    file = tmp_path / "scene.toml"
    file.write_text("\n".join(lines))
    document = schema.read_document(str(file), schema.SceneTable, SceneError)
    found = evolved_tables.read_beziers(document.contents.surfaces)
    assert len(found) == 30
    for i, table in enumerate(document.contents.surfaces):
        alone, together = table.surface(tmp_path), table.surface(tmp_path, found[i])
        assert np.array_equal(alone.parameters, together.parameters)
        assert np.array_equal(alone.flipped, together.flipped)
    assert any(segments.flipped.any() for segments in found.values())


def test_a_whole_number_of_thousands_of_digits(tmp_path) -> None:
    file = tmp_path / "scene.toml"
    file.write_text(HEAD + f"[render]\nwidth = {'9' * 5000}\n")
    with pytest.raises(SceneError, match=r"scene.toml: a whole number has thousands of digits"):
        tracer.Scene.load(file)


def test_quotation_marks_in_the_names_of_a_page() -> None:
    from bladesmith.tracer.view_figure import _text

    assert _text("""a "b" <i>&'c'""") == """a "b" &lt;i&gt;&amp;'c'"""
