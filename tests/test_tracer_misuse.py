"""The tracer in the wrong hands: one sentence tells what was given instead of what is needed, and nothing is drawn."""

from __future__ import annotations

import copy
import logging
import pickle
import re
import time
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from bladesmith import tracer
from bladesmith.cli.main import run
from bladesmith.codegen.programs.surface_kinds import FAMILIES, PLAIN, surface_kind
from bladesmith.codegen.templating import template_text
from bladesmith.errors import BladesmithError, InputError, SceneError
from bladesmith.status import Status
from bladesmith.tracer import memory, values
from bladesmith.tracer.rows import gathered

CAMERA = tracer.Camera.look_at((0, -8, 2), (0, 0, 1))
TUBE = [((0, 0, 0), (0, 0, 1), 1.0), ((0, 1, 2), (0, 0.5, 1), 0.6)]
BALL = tracer.Sphere((0, 0, 0), 1.0)
SCENE = tracer.Scene(CAMERA, [tracer.Light((4, -6, 8))], [BALL])
PICTURE = np.zeros((2, 2, 3))
#: What no argument of these takes.
ODD = [
    1j,
    object(),
    {"center": 1},
    {1, 2, 3},
    (i for i in range(3)),
    np.array([1, 2, 3], object),
    np.array(["a", "b", "c"]),
    np.ma.masked_array([1.0, 2.0, 3.0], [False, True, False]),
    [1.0, np.nan, 3.0],
    [None, None, None],
    [True, False, True],
    np.zeros((2, 3)),
    10**400,
    np.datetime64("2020-01-01"),
    len,
]
NUMBERS = {
    "center": lambda x: tracer.Sphere(x, 1.0),
    "radius": lambda x: tracer.Sphere((0, 0, 0), x),
    "normal": lambda x: tracer.Plane(x, 0.0),
    "offset": lambda x: tracer.Plane((0, 0, 1), x),
    "camera": lambda x: tracer.Camera.look_at(x, (0, 0, 1)),
    "motor": lambda x: tracer.Camera(x, 1.0, 1.0, 1.0),
    "angle": lambda x: tracer.Camera.look_at((0, -8, 2), (0, 0, 1), field_of_view=x),
    "light": tracer.Light,
    "horizon": lambda x: tracer.Scene(CAMERA, horizon=x),
    "reflections": lambda x: tracer.Scene(CAMERA, reflections=x),
    "color": lambda x: tracer.Material(color=x),
    "share": lambda x: tracer.Material(diffuse=x),
    "material": lambda x: tracer.Sphere((0, 0, 0), 1.0, material=x),
    "align": lambda x: tracer.EvolvedCircles(TUBE, align=x),
    "gaps": lambda x: tracer.EvolvedCircles(TUBE, gaps=x),
    "caps": lambda x: tracer.EvolvedCircles(TUBE).mesh(4, 4, caps=x),
    "rings": lambda x: BALL.mesh(x, 4),
    "shift": lambda x: BALL.mesh(4, 4).moved(1.0, x),
    "rays": lambda x: CAMERA.rays(4, x),
    "width": lambda x: SCENE.render(x, 4),
    "settings": lambda x: tracer.Scene(CAMERA, settings=x),
    "samples": lambda x: SCENE.render(4, 4, samples=x),
    "method": lambda x: SCENE.intersect((0, 0, 0), (0, 0, 1), method=x),
    "layers": lambda x: SCENE.layers(4, 4, [x]),
    "file": lambda x: tracer.save_image(x, PICTURE),
    "pixels": lambda x: tracer.save_image("a.png", x),
    "saved": lambda x: tracer.save_layers("a.png", x),
    "page": lambda x: tracer.view(SCENE, x),
    "names": lambda x: tracer.view(SCENE, names=x),
    "scene file": tracer.Scene.load,
}


@pytest.mark.parametrize("name", NUMBERS)
def test_what_is_no_argument_is_told_in_one_line(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for value in ODD:
        if name == "names" and isinstance(value, list):
            continue  # whatever three names are: there is one surface
        with pytest.raises(BladesmithError) as caught:
            NUMBERS[name](value)
        text = str(caught.value)
        assert "\n" not in text and len(text) < 300, text
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("done", [True, 1, [True], np.zeros((2, 2)), np.zeros((3, 2), bool), "done"])
def test_pixels_that_are_done_are_bools_of_the_picture(tmp_path, done):
    with pytest.raises(BladesmithError, match="done"):
        tracer.save_image(tmp_path / "a.png", PICTURE, done)
    assert not list(tmp_path.iterdir())


def test_layers_of_one_file_have_one_size(tmp_path):
    with pytest.raises(BladesmithError, match="depth has"):
        tracer.save_layers(tmp_path / "a.exr", {"color": PICTURE, "depth": np.zeros((3, 2))})
    for layers in ({}, PICTURE):
        with pytest.raises(BladesmithError, match="layers are"):
            tracer.save_layers(tmp_path / "a.png", layers)


def test_wrong_values_are_repeated_shortly():
    class Rude:
        def __repr__(self):
            raise RuntimeError

    assert values.shown(Rude()) == "Rude"
    assert values.shown(np.zeros((2, 3))).count("\n") == 0
    assert len(values.shown("x" * 1000)) < 70
    assert memory.readable(10**400).endswith("PB") and memory.readable(1500) == "1.5 kB"


def test_light_and_colors_have_a_limit():
    for make in (
        lambda: tracer.Material(color=(0, 0, 1e10)),
        lambda: tracer.Material(specular=1e10),
        lambda: tracer.Light((0, 0, 0), (1e10, 0, 0)),
        lambda: tracer.Scene(CAMERA, zenith=(1e300, 0, 0)),
    ):
        with pytest.raises(SceneError, match=r"1e\+09"):
            make()
    bright = {"color": (1e9,) * 3, "ambient": 1e9, "diffuse": 1e9, "specular": 1e9, "shininess": 1e300}
    scene = tracer.Scene(CAMERA, [tracer.Light((4, -6, 8), (1e9,) * 3)], [BALL.with_material(bright)])
    for dtype in (np.float64, np.float32):
        assert np.isfinite(scene.render(24, 18, dtype=dtype)).all()


@pytest.mark.parametrize(
    "text", ["[[lights]]\nposition = [0, 0, 5]\ncolor = [1, 1e20, 1]\n", "[sky]\nzenith = [1e20, 0, 0]\n"]
)
def test_limits_of_files_are_told_with_their_line(tmp_path, text, capsys):
    path = tmp_path / "scene.toml"
    path.write_text("[camera]\nposition = [0, -8, 2]\nlook_at = [0, 0, 0]\n" + text)
    assert run(["render", str(path), "-o", str(tmp_path / "a.png")]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert "scene.toml, line " in line and "colors go to 1e+09" in line


def test_what_is_made_is_not_changed():
    """Compiled drivers hold the numbers: a change would be ignored, and no one would know."""
    tube = tracer.EvolvedCircles(TUBE)
    for thing, name in (
        (SCENE, "camera"),
        (SCENE, "surfaces"),
        (CAMERA, "y_max"),
        (BALL, "radius"),
        (BALL, "material"),
        (tube, "gaps"),
        (SCENE.lights[0], "position"),
    ):
        before = getattr(thing, name)
        for same in (thing, copy.copy(thing), pickle.loads(pickle.dumps(thing))):
            with pytest.raises(SceneError, match=f"{name} is not changed once it is made"):
                setattr(same, name, 2.0)
        assert getattr(thing, name) is before
    for array in (BALL.center, SCENE.lights[0].position, BALL.material.color):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 5.0
    tube.name = "tube"  # no driver holds names
    assert tube.name == "tube"


def test_one_surface_with_several_looks_in_several_scenes():
    tube = tracer.EvolvedCircles(TUBE)
    flat = {"ambient": 1.0, "diffuse": 0.0, "specular": 0.0}
    red, blue = (tube.with_material({"color": color, **flat}) for color in ((1, 0, 0), (0, 0, 1)))
    assert type(red) is type(tube) and red.segments is tube.segments and tube.material.diffuse > 0
    pictures = [tracer.Scene(CAMERA, [], [surface]).render(24, 18) for surface in (red, blue)]
    hit = tracer.Scene(CAMERA, [], [red]).intersect(*CAMERA.rays(24, 18)).hit
    assert hit.any() and (pictures[0][hit] == (1, 0, 0)).all() and (pictures[1][hit] == (0, 0, 1)).all()
    with pytest.raises(SceneError, match="planes and discs"):
        tube.with_material({"checker": (0, 0, 0)})


def test_a_scene_file_says_once_what_was_turned_over(tmp_path, caplog):
    circle = "{{ center = [{}, 0, {}], normal = [0, 0, {}], radius = 1.0 }}".format
    surface = '[[surfaces]]\nkind = "evolved_circles"\nname = "tube {}"\ncontrols = [{}, {}]\n'.format
    body = "".join(surface(i, circle(i, 0, 1), circle(i, 2, 1 if i == 3 else -1)) for i in range(12))
    path = tmp_path / "scene.toml"
    path.write_text("[camera]\nposition = [0, -8, 2]\nlook_at = [0, 0, 0]\n" + body)
    with caplog.at_level(logging.WARNING, "bladesmith"):
        tracer.Scene.load(path)
    (line,) = caplog.messages
    assert "controls of 11 surfaces" in line and line.endswith("; ..") and "surfaces[3]" not in line
    assert "scene.toml: " in line and "surfaces[2] ('tube 2'): 1;" in line
    with caplog.at_level(logging.WARNING, "bladesmith"):
        tracer.EvolvedCircles([TUBE[0], ((0, 1, 2), (0, -0.5, -1), 0.6)])
    assert len(caplog.messages) == 2


# -- the commands --------------------------------------------------------------------------------------------


@pytest.fixture
def path(tmp_path):
    place = tmp_path / "scene.toml"
    ball = "[[surfaces]]\nkind = 'sphere'\ncenter = [0, 0, 0]\nradius = 1\n"
    place.write_text("[camera]\nposition = [0, -8, 2]\nlook_at = [0, 0, 0]\n" + ball)
    return place


def test_a_page_never_takes_the_place_of_its_scene(path, capsys):
    before = path.read_bytes()
    assert run(["view", str(path), "-o", str(path)]) == 2
    assert "the place of the scene file" in capsys.readouterr().err and path.read_bytes() == before


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["-o", "none/a.obj"], "InputError: none/a.obj: there is no folder none."),
        (["-o", "a.obj", "--extent", "nan"], "extent is nan"),
        (["-o", "a.obj", "--extent", "-1"], "extent is -1; it must be positive"),
        (["-o", "a.obj", "--rings", "99999999999"], "rings is 99999999999"),
        (["-o", "a.obj", "--surface", "1"], "there is no surface 1; the scene has 1, from 0"),
    ],
)
def test_wrong_options_of_meshes(path, options, message, capsys, monkeypatch):
    pytest.importorskip("trimesh")
    monkeypatch.chdir(path.parent)
    assert run(["mesh", str(path), *options]) != 0
    (line,) = capsys.readouterr().err.splitlines()
    assert message in line and [p.name for p in path.parent.iterdir()] == ["scene.toml"]


def test_a_long_preparation_is_explained(path, capsys, monkeypatch):
    from bladesmith.cli import render

    plain = tracer.Scene.layers

    def slow(self, width, *rest, **named):
        time.sleep(0.3 if width == 1 else 0.0)
        return plain(self, width, *rest, **named)

    monkeypatch.setattr(tracer.Scene, "layers", slow)
    monkeypatch.setattr(render, "PATIENCE", 0.05)
    arguments = ["render", str(path), "-o", str(path.parent / "a.png"), "--width", "8", "--height", "6"]
    assert run([*arguments, "--progress"]) == 0
    told = capsys.readouterr().err
    assert told.startswith(render.NOTICE) and "8 x 6 pixels in " in told
    assert float(told.split("after ")[1].split(" s of preparation")[0]) >= 0.3
    assert run([*arguments, "--quiet"]) == 0
    assert capsys.readouterr().err == ""


def test_sizes_are_refused_before_anything_is_compiled(path, monkeypatch, capsys):
    monkeypatch.setattr(tracer.Scene, "layers", lambda *_, **__: pytest.fail("compiled"))
    for wrong in (
        ["--width", "0"],
        ["--height", "1000000", "--width", "1000000"],
        ["--antialias", "65"],
        ["--samples", "1"],
    ):
        assert run(["render", str(path), "-o", str(path.parent / "a.png"), *wrong]) == 2
        assert capsys.readouterr().err.startswith("SceneError: ")


def test_an_interrupt_while_the_picture_is_written_is_told(path, monkeypatch, capsys):
    def stopped(*_, **__):
        raise KeyboardInterrupt

    target = path.parent / "a.png"
    monkeypatch.setattr("bladesmith.tracer.image._save", stopped)
    assert run(["render", str(path), "-o", str(target), "--width", "8", "--height", "6", "--quiet"]) == 1
    assert capsys.readouterr().err == f"interrupted while {target} was written; what is not there is lost\n"
    assert not target.exists()


class Odd:
    """What has a method `submit` and is no executor."""

    def __init__(self, found):
        self.found = found

    def submit(self, *_):
        if isinstance(self.found, Exception):
            raise self.found
        return self.found


@pytest.mark.parametrize("executor", [5, ThreadPoolExecutor, Odd(3), Odd(ValueError("no")), Odd(None)])
def test_what_is_no_executor_takes_no_work(executor):
    with pytest.raises(InputError, match="the executor takes no work"):
        SCENE.render(8, 6, executor=executor)


def test_a_surface_without_a_shape_is_refused():
    with pytest.raises(SceneError, match="no shape"):
        tracer.Surface(None)


class Faceted:
    """A surface that says how many rows it has, and holds one."""

    program_kind = "facet"

    def __init__(self, rows):
        self.parameters = np.broadcast_to(np.zeros(9), (rows, 9))


def test_more_rows_than_can_be_numbered():
    with pytest.raises(SceneError, match="4294967292 facets .* has 2147483646 at most"):
        gathered(None, [Faceted(2**31 - 2), Faceted(2**31 - 2)])


def test_there_is_room_for_every_kind_of_surface():
    kinds = {*PLAIN, *(f"{family}_{degree}" for family, (_, most) in FAMILIES.items() for degree in range(1, most + 1))}
    declared = re.search(r"surfaces\[(\d+)\]", template_text("c/scene_types.h"))
    assert all(surface_kind(name) for name in kinds) and len(kinds) <= int(declared.group(1))


def test_threads_are_checked_for_few_rays_too():
    scene = tracer.Scene(CAMERA, [], [BALL])
    for threads in (0, -1, "two"):
        with pytest.raises(BladesmithError, match="threads is"):
            scene.intersect((0, -5, 0), (0, 1, 0), threads=threads)


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
