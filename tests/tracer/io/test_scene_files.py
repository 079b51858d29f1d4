"""Scene files: every kind of surface and curve, and what hostile ones are told."""

from __future__ import annotations

import logging
import math
import re
from pathlib import Path
from textwrap import dedent

import numpy as np
import pytest

from bladesmith import cga3d as cga
from bladesmith import curves, tracer
from bladesmith.cli.main import run
from bladesmith.errors import SceneError
from bladesmith.tracer.io import evolved_tables, reader
from bladesmith.tracer.surfaces.evolved import EvolvedPointPairs
from bladesmith.tracer.surfaces.triangles import Facets, Mesh

from ...support.checkout import CHECKOUT
from ...support.tracer.scenes import TUBE

HEAD = "[camera]\nposition = [0.0, -8.0, 2.0]\nlook_at = [0.0, 0.0, 0.0]\n"
FIRST = "{ center = [0, 0, 0], normal = [0, 0, 1], radius = 1.0 }"
SECOND = "{ center = [0, 1, 2], normal = [0, 0.5, 1], radius = 0.6 }"
THIRD = "{ center = [1, 1, 3], normal = [0.5, 0.5, 1], radius = 0.8 }"
CIRCLES = [((0, 0, 0), (0, 0, 1), 1.0), ((0, 1, 2), (0, 0.5, 1), 0.6), ((1, 1, 3), (0.5, 0.5, 1), 0.8)]
PAIRS = "{ a = [0, 0, 0], b = [0, 0, 1] }, { a = [1, 0, 0], b = [1, 0.2, 1] }, { a = [2, 0, 0.1], b = [2, 0.3, 1] }"
POINTS = [((0, 0, 0), (0, 0, 1)), ((1, 0, 0), (1, 0.2, 1)), ((2, 0, 0.1), (2, 0.3, 1))]


@pytest.fixture
def load(tmp_path: Path):
    def load_(text: str, head: str = HEAD) -> tracer.Scene:
        path = tmp_path / "scene.toml"
        path.write_text(head + dedent(text), encoding="utf-8")
        return tracer.Scene.load(path)

    return load_


def surface(kind: str, body: str) -> str:
    return f'[[surfaces]]\nkind = "{kind}"\n' + dedent(body)


# -- what files say ------------------------------------------------------------------------------------------


def test_plain_surfaces_and_their_names(load):
    scene = load(
        surface("plane", "normal = [0, 0, 2]\noffset = 4\nname = 'floor'\n")
        + surface("sphere", "center = [0, 0, 1]\nradius = 2\n")
        + surface("disc", "center = [0, 0, 1]\nnormal = [0, 0, 3]\nradius = 2\n")
        + surface("circle", "center = [0, 0, 1]\nnormal = [0, 0, 3]\nradius = 2\n")
    )
    plane, sphere, disc, circle = scene.surfaces
    assert plane.name == "floor" and plane.offset == 2 and sphere.name is None
    assert isinstance(disc, tracer.Disc) and isinstance(circle, tracer.Disc)
    np.testing.assert_array_equal(disc.parameters, circle.parameters)


def test_facets(load):
    scene = load(
        surface("facets", "vertices = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]\n")
        + surface("facets", """
            vertices = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]]
            faces = [[0, 1, 2], [1, 3, 2]]
            normals = [[0, 0, 1], [0, 0, 1], [0, 0, 1], [0, 0.1, 1]]
            """)
    )  # fmt: skip
    one, two = scene.surfaces
    assert isinstance(one, Facets) and len(one) == 1 and len(two) == 2
    assert one.program_kind == "facet" and two.program_kind == "smooth_facet"


def test_meshes_are_found_beside_the_scene(load, tmp_path):
    pytest.importorskip("trimesh")
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "one.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    scene = load(surface("mesh", 'path = "parts/one.obj"\nscale = 0.5\nsmooth = true\n'))
    (mesh,) = scene.surfaces
    assert isinstance(mesh, Mesh) and mesh.vertices.max() == 0.5 and mesh.normals is not None


CURVES = [
    ("", lambda c: curves.Bezier(c)),
    ('curve = "bezier"', lambda c: curves.Bezier(c)),
    ('curve = "rational_bezier"\nweights = [1, 2, 0.5]', lambda c: curves.RationalBezier(c, [1, 2, 0.5])),
    ('curve = "kochanek_bartels"', lambda c: curves.KochanekBartels(c)),
    (
        'curve = "kochanek_bartels"\ntension = 0.2\nbias = [0.1, 0, 0.3]\ncontinuity = -0.1\nclosed = true',
        lambda c: curves.KochanekBartels(c, 0.2, [0.1, 0, 0.3], -0.1, True),
    ),
    ('curve = "interpolating"', lambda c: curves.Interpolating(c)),
    (
        'curve = "interpolating"\nknots = [0, 1, 3]\ndegree = 3\nends = "natural"',
        lambda c: curves.Interpolating(c, [0, 1, 3], ends="natural"),
    ),
    ('curve = "interpolating"\ndegree = 1', lambda c: curves.Interpolating(c, degree=1)),
]


@pytest.mark.parametrize(("keys", "make"), CURVES)
def test_curves_of_circles_and_point_pairs(load, keys, make):
    text = surface("evolved_circles", f"{keys}\nalign = false\ncontrols = [{FIRST}, {SECOND}, {THIRD}]\n")
    text += surface("evolved_point_pairs", f"{keys}\nalign = false\ncontrols = [{PAIRS}]\n")
    tube, ribbon = load(text).surfaces
    assert isinstance(tube, tracer.EvolvedCircles) and isinstance(ribbon, EvolvedPointPairs)
    for found, given in ((tube, CIRCLES), (ribbon, POINTS)):
        wanted = type(found)(make(given), align=False)
        assert found.program_kind == wanted.program_kind
        np.testing.assert_array_equal(found.parameters, wanted.parameters)


def test_hermite_tangents_are_differences_of_objects(load):
    tangents = f"[{{ from = {FIRST}, to = {THIRD}, scale = 2 }}, {{ from = {SECOND}, to = {FIRST} }}]"
    body = f'curve = "hermite"\nalign = false\ncontrols = [{FIRST}, {SECOND}]\ntangents = {tangents}\n'
    (tube,) = load(surface("evolved_circles", body)).surfaces
    x, y, z = (cga.circle(*c) for c in CIRCLES)
    wanted = tracer.EvolvedCircles(curves.Hermite(x, 2 * (z - x), y, x - y), align=False)
    np.testing.assert_allclose(tube.parameters, wanted.parameters, atol=1e-13 * np.abs(wanted.parameters).max())
    pairs = PAIRS.replace("}, {", "}; {").split("; ")
    tangents = f"[{{ from = {pairs[0]}, to = {pairs[2]}, scale = -1 }}, {{ from = {pairs[0]}, to = {pairs[1]} }}]"
    body = f'curve = "hermite"\ncontrols = [{pairs[0]}, {pairs[1]}]\ntangents = {tangents}\n'
    (ribbon,) = load(surface("evolved_point_pairs", body)).surfaces
    assert ribbon.program_kind == "evolved_point_pairs_3"


def test_flips_and_gaps(load, caplog):
    opposed = "{ center = [0, 0, 0], normal = [0, 0, -1], radius = 0.5 }"
    body = f"controls = [{FIRST}, {opposed}]\n"
    with caplog.at_level(logging.WARNING, "bladesmith"):
        (turned,) = load(surface("evolved_circles", body)).surfaces
    assert turned.flipped.tolist() == [False, True] and "orientation reversed" in caplog.text
    with pytest.raises(
        SceneError, match=r"scene.toml, line 4: surfaces\[0\] has imaginary circles for alpha from 0.333"
    ):
        load(surface("evolved_circles", body + "align = false\n"))
    (open_,) = load(surface("evolved_circles", body + "align = false\ngaps = true\n")).surfaces
    assert open_.gaps and not open_.flipped.any()


def test_cameras_by_motor(load):
    by_places = tracer.Camera.look_at((0, -8, 2), (0, 0, 0), field_of_view=math.radians(45))
    motor = ", ".join(repr(float(x)) for x in by_places.motor)
    lens = f"focal_length = 2.0\nx_max = 3.0\ny_max = {4 * math.tan(math.radians(22.5))!r}\n"
    scene = load("", head=f"[camera]\nmotor = [{motor}]\n{lens}")
    origins, directions = scene.camera.rays(3, 3)
    others = load("").camera.rays(3, 3)
    np.testing.assert_allclose(origins, others[0], atol=1e-14)
    np.testing.assert_allclose(directions[:, 1], others[1][:, 1], atol=1e-14)
    assert scene.camera.x_max == 3 and scene.camera.focal_length == 2


def test_the_rest_of_a_file(load):
    scene = load("""
        [render]
        width = 30
        height = 20
        antialias = 2
        reflections = 7
        [sky]
        zenith = [0, 0, 1]
        [[lights]]
        position = [1, 2, 3]
        [[lights]]
        position = [1, 2, 4]
        color = [0.5, 0, 0]
        """)
    assert scene.settings == {"width": 30, "height": 20, "antialias": 2} and scene.reflections == 7
    assert [light.position[2] for light in scene.lights] == [3, 4]


# -- what is refused -----------------------------------------------------------------------------------------


def circles(keys: str, *controls: str) -> str:
    return surface("evolved_circles", f"{keys}\ncontrols = [{', '.join(controls or (FIRST, SECOND))}]\n")


def facets(*keys: str) -> str:
    return surface("facets", "\n".join(keys) + "\n")


def odd(entry: str) -> str:
    return circles("", FIRST, f"{{ {entry} }}")


DIFFERENCES = f"[{{ from = {FIRST}, to = {SECOND} }}, {{ from = {FIRST}, to = {SECOND} }}]"
NAMES = [
    ("[[surfaces]]\n", "line 4: surfaces[0] has no kind"),
    (surface("circel", ""), "line 5: surfaces[0].kind is \"circel\"; did you mean 'circle'?"),
    (surface("sphere", "center = [0, 0, 0]\nradius = 1\nname = ''\n"), "line 8: surfaces[0].name"),
    (surface("sphere", "center = [0, 0, 0]\nradius = 1\nname = 3\n"), "line 8: surfaces[0].name is 3; text"),
    (circles("", FIRST), "surfaces[0].controls", "has 1 items where 2 are the least"),
    (circles("", FIRST, FIRST), "line 4: surfaces[0] is refused: the 2 controls are all the same circle"),
    (circles("", *[FIRST, SECOND] * 6), "surfaces[0].controls are 12", "up to degree 8, not 11", "kochanek_bartels"),
    (circles("curve = 'spline'"), "line 6: surfaces[0].curve is \"spline\"", "known: bezier, rational_bezier"),
    (circles("weights = [1, 2]"), "line 6: surfaces[0].weights is a key of curve = 'rational_bezier'", "is 'bezier'"),
    (circles("curve = 'rational_bezier'"), "line 4: surfaces[0].weights is missing"),
    (circles("curve = 'rational_bezier'\nweights = [1]"), "line 7: surfaces[0].weights has shape (1,)"),
    (circles("curve = 'rational_bezier'\nweights = [1, -2]"), "line 7: surfaces[0].weights[1] is -2"),
    (circles("curve = 'rational_bezier'\nweights = [1, 1e-90]"), "line 7: surfaces[0].weights[1] is 1e-90, less than"),
    (circles("curve = 'hermite'"), "surfaces[0].tangents is missing; curve = 'hermite' needs it"),
    (circles("curve = 'hermite'\ntangents = []"), "surfaces[0].tangents are 0; a Hermite curve has 2"),
    (circles(f"curve = 'hermite'\ntangents = {DIFFERENCES}", FIRST, SECOND, THIRD), "surfaces[0].controls are 3;"),
    (circles(f"curve = 'hermite'\ntangents = [{{ from = {FIRST} }}]"), "surfaces[0].tangents[0] has no to"),
    (circles("curve = 'kochanek_bartels'\ntension = [1, 2, 3]"), "line 7: surfaces[0].tension has shape (3,)"),
    (circles("curve = 'kochanek_bartels'\nbias = 'x'"), "line 7: surfaces[0].bias is \"x\"; a number is needed"),
    (circles("curve = 'kochanek_bartels'\nclosed = 1"), "surfaces[0].closed is 1; true or false is needed"),
    (circles("curve = 'interpolating'\nknots = [1, 0]"), "line 7: surfaces[0].knots[1] is 0, which does not exceed"),
    (circles("curve = 'interpolating'\ndegree = 4"), "line 7: surfaces[0].degree is 4; a degree is at most 3"),
    (circles("curve = 'interpolating'\nends = 'open'"), "surfaces[0].ends is \"open\"; known: not-a-knot, natural"),
    (odd("center = [0, 0, 1], normal = [0, 0, 0], radius = 1"), "line 7: surfaces[0].controls[1].normal", "be zero"),
    (odd("center = [0, 0, 1], normal = [0, 0, 1], radius = 0"), "surfaces[0].controls[1].radius is 0; a radius is"),
    (odd("center = [0, nan, 1], normal = [0, 0, 1], radius = 1"), "surfaces[0].controls[1].center[1] is nan"),
    (odd("center = [0, 1e200, 1], normal = [0, 0, 1], radius = 1"), "controls[1].center", "coordinates go to 1e+90"),
    (odd("a = [0, 0, 1], b = [0, 0, 2]"), "surfaces[0].controls[1].a is not a known key"),
    (odd("center = [0, 0, 0], normal = [0, 0, -1], radius = 1.0"), "one object"),
    (odd("center = [0, 0, 0], normal = [0, 0, 1], radius = 1e-30"), "sizes too different"),
    (surface("evolved_point_pairs", f"controls = [{PAIRS}, {{ a = [1, 0, 0], b = [1, 0, 0] }}]\n"),
     "line 6: surfaces[0].controls[3].b", "two end points"),
    (surface("plane", "normal = [0, 0, 0]\n"), "line 6: surfaces[0].normal", "must not be zero"),
    (facets("vertices = [[0, 0, 0], [1, 0, 0]]"), "surfaces[0].vertices", "3 are the least"),
    (facets("vertices = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 1]]"), "vertices are 4", "faces are needed"),
    (facets("vertices = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]", "faces = [[0, 1, 3]]"), "line 7: surfaces[0].faces[0]"),
    (facets("vertices = [[0, 0, 0], [1, 0, 0], [2, 0, 0]]"), "surfaces[0].faces[0]", "without an area"),
    (surface("mesh", "path = 'none.obj'\n"), "line 6: surfaces[0].path is 'none.obj': there is no such file"),
    (surface("mesh", "path = '.'\n"), "line 6: surfaces[0].path is '.'"),
    (surface("mesh", "path = 'scene.toml'\n"), "line 6: surfaces[0].path is 'scene.toml'", ".obj"),
    (surface("mesh", 'path = "\\u0000"\n'), "line 6: surfaces[0].path has a null character"),
    (surface("mesh", "path = 'none.obj'\nscale = 0\n"), "line 7: surfaces[0].scale is 0; a scale is positive"),
]  # fmt: skip


@pytest.mark.parametrize(("text", "parts"), [(text, parts) for text, *parts in NAMES])
def test_faults_are_told_with_line_and_key(load, text, parts):
    if "mesh" in text:
        pytest.importorskip("trimesh")
    with pytest.raises(SceneError) as caught:
        load(text + ("align = false\n" if "one object" in parts else ""))
    assert all(part in str(caught.value) for part in parts), str(caught.value)
    assert "scene.toml" in str(caught.value) and "\n" not in str(caught.value)


CAMERAS = [
    ("position = [0, 0, 0]", "camera.look_at is missing"),
    ("look_at = [0, 0, 0]", "camera.position is missing"),
    ("position = [0, 0, 0]\nlook_at = [0, 0, 0]", "line 3: camera.look_at is the camera's own position"),
    ("position = [0, 0, 0]\nlook_at = [0, 0, 1]", "camera.up is parallel to the viewing direction"),
    ("position = [0, 0, 0]\nlook_at = [0, 1, 0]\nx_max = 1", "line 4: camera.x_max belongs to the other definition"),
    ("motor = [1, 0, 0, 0, 0, 0, 0, 0]", "camera.y_max is missing"),
    ("motor = [1, 0, 0, 0, 0, 0, 0, 0]\ny_max = 1\nup = [0, 0, 1]", "line 4: camera.up belongs to the other"),
    ("motor = [2, 0, 0, 0, 0, 0, 0, 0]\ny_max = 1", "line 2: camera.motor is not normalized"),
    ("motor = [1, 0, 0]\ny_max = 1", "line 2: camera.motor has 3 where 8 numbers are needed"),
]


@pytest.mark.parametrize(("text", "message"), CAMERAS)
def test_faults_of_cameras(load, text, message):
    with pytest.raises(SceneError) as caught:
        load("", head=f"[camera]\n{text}\n")
    assert message in str(caught.value)


@pytest.mark.parametrize("depth", [150, 250, 5000])
def test_deep_nesting_is_refused(load, depth):
    with pytest.raises(SceneError, match="nested too deeply|is not a known key"):
        load("x = " + "[" * depth + "]" * depth)


def test_a_spline_of_many_controls(load):
    controls = ", ".join(
        f"{{ center = [{i}, 0, {math.sin(i):.3f}], normal = [1, 0, 0], radius = 0.5 }}" for i in range(300)
    )
    (tube,) = load(circles("curve = 'kochanek_bartels'", controls)).surfaces
    assert len(tube.parameters) == 299


def test_messages_name_surfaces(load):
    opposed = "{ center = [0, 0, 0], normal = [0, 0, -1], radius = 0.5 }"
    floor = surface("plane", "normal = [0, 0, 1]\n")
    with pytest.raises(SceneError, match=r"line 7: surfaces\[1\] \('cup'\) has imaginary circles"):
        load(floor + circles("name = 'cup'\nalign = false", FIRST, opposed))


def test_the_scenes_of_the_docs(load):
    page = (CHECKOUT / "docs" / "geometry" / "scenes.md").read_text(encoding="utf-8")
    first, second = re.findall(r"^```toml\n(.*?)^```", page, re.MULTILINE | re.DOTALL)
    assert [s.kind for s in load(first, head="").surfaces] == ["sphere", "evolved_circles"]
    assert load(second).surfaces[0].program_kind == "evolved_circles_3"


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
    document = reader.read_document(str(file), reader.SceneTable, SceneError)
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


@pytest.mark.parametrize(
    "text", ["[[lights]]\nposition = [0, 0, 5]\ncolor = [1, 1e20, 1]\n", "[sky]\nzenith = [1e20, 0, 0]\n"]
)
def test_limits_of_files_are_told_with_their_line(tmp_path, text, capsys):
    path = tmp_path / "scene.toml"
    path.write_text("[camera]\nposition = [0, -8, 2]\nlook_at = [0, 0, 0]\n" + text)
    assert run(["render", str(path), "-o", str(tmp_path / "a.png")]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert "scene.toml, line " in line and "colors go to 1e+09" in line


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
        tracer.EvolvedCircles([TUBE[0], ((0, 1, 2), (0, -0.5, -1), 0.6)], align=True)
    assert len(caplog.messages) == 2
