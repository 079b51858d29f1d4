"""The interactive page: what is in the file, and what a real browser makes of it."""

from __future__ import annotations

import base64
import io
import json
import math
import re
import sys

import numpy as np
import pytest

from bladesmith import tracer
from bladesmith.cli import main
from bladesmith.curves import Bezier, KochanekBartels
from bladesmith.errors import InputError, MissingExtraError, SceneError
from bladesmith.tracer.surfaces.evolved import EvolvedCircles, EvolvedPointPairs
from bladesmith.tracer.surfaces.triangles import Facets
from bladesmith.tracer.viewer.page import view
from bladesmith.tracer.viewer.plotly_figure import MOST_TRACES

from ...support.browser import Chromium, browser

pytestmark = pytest.mark.peers

HOSTILE = "</script><img src=x onerror=document.body.dataset.hacked=1><b>%{x}&amp;"
TUBE = [((0.0, 0.0, 0.0), (0.0, 0.0, 1.0), 0.5), ((0.0, 1.0, 1.0), (0.0, 1.0, 1.0), 0.4)]

SCENE = """
[camera]
position = [0.0, -8.0, 2.0]
look_at = [0.0, 0.0, 0.0]

[[surfaces]]
kind = "sphere"
center = [1.5, 0.0, 0.5]
radius = 0.5
"""


def moved(controls, by):
    return [(np.asarray(first, float) + by, *rest) for first, *rest in controls]


def scene(by=(0.0, 0.0, 0.0), floor=True):
    by = np.asarray(by, float)
    pairs = [((2.0, 0.0, 0.0), (2.0, 0.0, 1.0)), ((2.5, 1.0, 0.0), (3.0, 0.0, 1.5)), ((4.0, 1.0, 0.5), (4.0, 2.0, 1.0))]
    corners = np.array([(-2, 0, 0), (-1, 0, 0), (-1.5, 1, 0), (-1.5, 0.4, 1)]) + by
    surfaces = [
        EvolvedCircles(Bezier(moved(TUBE, by)), material={"color": (0.7, 0.1, 0.05)}),
        EvolvedPointPairs(
            Bezier([(np.add(a, by), np.add(b, by)) for a, b in pairs]), material={"color": (0.1, 0.5, 0.2)}
        ),
        tracer.Sphere(by + (0.6, -1.0, 0.4), 0.4, material={"color": (0.1, 0.2, 0.8)}),
        Facets(corners, [[0, 1, 3], [1, 2, 3], [2, 0, 3]]),
        tracer.Disc(by + (1.0, 2.5, 1.0), (0, -1, 0.2), 0.8),
    ]
    if floor:
        surfaces.append(tracer.Plane((0, 0, 1), by[2] - 0.1, material={"checker": (0, 0, 0), "checker_size": 0.7}))
    camera = tracer.Camera.look_at(by + (1.2, -6.0, 2.5), by + (1.0, 0.5, 0.6), field_of_view=math.radians(35))
    return tracer.Scene(camera, [tracer.Light(by + (3, -4, 6)), tracer.Light(by + (90, 0, 0), (1, 0.2, 0.2))], surfaces)


def contents(page):
    """The figure in a page, its arrays decoded."""
    text = re.search(r'<script type="application/json" id="data">(.*?)</script>', page.html, re.S).group(1)

    def decoded(entry):
        if set(entry) >= {"dtype", "bdata"}:
            array = np.frombuffer(base64.b64decode(entry["bdata"]), "<" + entry["dtype"])
            return array.reshape([int(n) for n in entry["shape"].split(",")]) if "shape" in entry else array
        return entry

    return json.loads(text, object_hook=decoded)


def columns(trace, names="xyz"):
    return np.stack([np.asarray(trace[name], float) for name in names], -1)


# -- the file ------------------------------------------------------------------------------------------------


def test_a_page_holds_all_that_it_needs(tmp_path):
    page = view(scene(), tmp_path / "page.html", title="A title", vertices=4000)
    text = (tmp_path / "page.html").read_text(encoding="utf-8")
    assert text == page.html and [f.name for f in tmp_path.iterdir()] == ["page.html"]
    own = text.replace(max(re.findall(r"<script>(.*?)</script>", text, re.S), key=len), "")  # without plotly
    assert len(own) < 0.5e6
    assert not re.search(r"\b(src|href|action)\s*=|https?:|@import|url\(", own)
    assert "default-src &#39;none&#39;" in own and "connect-src" not in own
    size = len(text.encode())
    assert page.library > 1e6 and 0 < size - page.library - page.data < 10_000
    assert f"{size / 1e6:.1f} MB" in str(page) and "6 surfaces" in str(page)


def test_traces_are_the_surfaces_their_controls_the_camera_and_the_lights():
    made = scene()
    page = view(made, vertices=6000)
    figure = contents(page)
    meshes = [t for t in figure["data"] if t["type"] == "mesh3d"]
    assert [t["name"] for t in meshes] == [
        "evolved circles [0]", "evolved point pairs [1]", "sphere [2]", "facets [3]", "disc [4]", "plane [5]",
    ]  # fmt: skip
    assert [t["name"] for t in figure["data"][6:]] == ["control objects", "camera", "lights"]
    assert page.traces == 9 and page.surfaces == 6
    assert page.vertices == sum(len(t["x"]) for t in meshes) < 6000
    for trace in meshes:
        faces = columns(trace, "ijk")
        assert faces.min() >= 0 and faces.max() < len(trace["x"])
    sphere = columns(meshes[2])
    np.testing.assert_allclose(np.linalg.norm(sphere - (0.6, -1.0, 0.4), axis=1), 0.4, rtol=1e-6)
    for i in (0, 1):  # on the evolved surfaces, with their parameter
        vertices, alpha = columns(meshes[i]), meshes[i]["customdata"]
        assert alpha.min() == 0 and alpha.max() == 1
        eye = made.camera.position
        inner = np.flatnonzero((alpha > 0.1) & (alpha < 0.9))[::7]
        found = made.surfaces[i].intersect(eye, vertices[inner] - eye)
        away = np.abs(np.nan_to_num(found.point, nan=np.inf) - vertices[inner, None]).max(-1)
        near = away.argmin(1)
        close = away.min(1) < 1e-5
        assert close.mean() > 0.7  # rays to free edges may pass them, by the rounding of the page
        got = np.take_along_axis(found.alpha, near[:, None], 1)[:, 0]
        np.testing.assert_allclose(got[close], alpha[inner][close], atol=1e-3)
    lights = figure["data"][8]
    np.testing.assert_allclose(columns(lights)[0], (3, -4, 6))
    assert "90, 0, 0" in lights["text"][1] and "drawn nearer" in lights["text"][1]


def test_control_objects_are_drawn():
    made = scene(floor=False)
    figure = contents(view(made, vertices=1000))
    points = columns(next(t for t in figure["data"] if t["name"] == "control objects"))
    lines = np.split(points, np.flatnonzero(np.isnan(points[:, 0])))
    lines = [line[np.isfinite(line[:, 0])] for line in lines]
    lines = [line for line in lines if len(line)]
    assert len(lines) == 5
    for line, (center, normal, radius) in zip(lines[:2], TUBE, strict=True):
        np.testing.assert_allclose(np.linalg.norm(line - center, axis=1), radius, rtol=1e-6)
        np.testing.assert_allclose((line - center) @ normal, 0, atol=1e-6)
        np.testing.assert_allclose(line[0], line[-1], atol=1e-7)
    np.testing.assert_allclose(lines[2], [(2, 0, 0), (2, 0, 1)])
    spline = EvolvedCircles(KochanekBartels([*TUBE, ((0.0, 2.0, 1.0), (0.0, 1.0, -0.2), 0.5)]))
    figure = contents(view(tracer.Scene(made.camera, [], [spline]), vertices=1000))
    assert np.isnan(figure["data"][1]["x"]).sum() == 3


def test_squares_are_where_the_picture_has_them():
    made = scene()
    plane = next(t for t in contents(view(made))["data"] if t["name"].startswith("plane"))
    middles = columns(plane)[columns(plane, "ijk").astype(int)].mean(1)
    near = np.linalg.norm(middles - (1, 0, -0.1), axis=1) < 3
    only = tracer.Scene(made.camera, made.lights, [made.surfaces[-1]])
    hits = only.intersect(middles + (0, 0, 1), (0, 0, -1))
    across = made.surfaces[-1].material.row(np.array([0, 0, 1.0]))[11:17].reshape(2, 3)
    odd = np.floor(hits.point @ across.T).sum(-1) % 2 == 1
    assert near.sum() > 50 and (np.array(plane["facecolor"]) == "rgb(0, 0, 0)")[near].tolist() == odd[near].tolist()


@pytest.mark.parametrize("by", [(0, 0, 0), (1e6, -2e6, 3e5)], ids=["near", "far"])
def test_the_first_view_is_the_cameras(by):
    made = scene(by)
    figure = contents(view(made, vertices=1000))
    axes = figure["layout"]["scene"]
    ranges = np.array([axes[f"{name}axis"]["range"] for name in "xyz"])
    ratio = np.array([axes["aspectratio"][name] for name in "xyz"])
    unit = (ranges[:, 1] - ranges[:, 0]) / ratio
    np.testing.assert_allclose(unit, unit[0], rtol=1e-12)  # equal scales
    origin = np.zeros(3)
    if by[0]:
        origin = np.array([float(axes[f"{name}axis"]["title"]["text"].removeprefix(f"{name} - ")) for name in "xyz"])
        sphere = columns(next(t for t in figure["data"] if t["name"] == "sphere [2]")) + origin
        np.testing.assert_allclose(np.linalg.norm(sphere - by - (0.6, -1.0, 0.4), axis=1), 0.4, rtol=1e-5)
        assert f"x = {origin[0]:.0f} + " in figure["data"][0]["hovertemplate"]
    camera = axes["camera"]
    assert camera == figure["views"]["camera"]
    eye, center = (np.array([camera[key][name] for name in "xyz"]) for key in ("eye", "center"))
    np.testing.assert_allclose(eye * unit + ranges.mean(1) + origin, made.camera.position, atol=1e-6)
    forward = (center - eye) / np.linalg.norm(center - eye)
    np.testing.assert_allclose(forward, made.camera.rays(1, 1)[1][0, 0], atol=1e-8)
    assert figure["views"]["angle"] == pytest.approx(math.radians(35))


def test_names_and_titles_are_text_and_nothing_else():
    made = scene(floor=False)
    page = view(made, title=HOSTILE, names=[HOSTILE, None, "x" * 500, "", "a & b"], vertices=1000)
    own = page.html.replace(max(re.findall(r"<script>(.*?)</script>", page.html, re.S), key=len), "")
    assert "<img" not in own and len(re.findall("</script", own)) == 3
    names = [t["name"] for t in contents(page)["data"][:5]]
    assert names[0].startswith("&lt;/script&gt;") and len(names[2]) == 48 and names[4] == "a &amp; b"
    assert names[1] == "evolved point pairs [1]" and names[3] == "facets [3]"


def test_names_come_from_the_scene_file(tmp_path):
    (tmp_path / "scene.toml").write_text(SCENE + f"name = {json.dumps(HOSTILE)}\n")
    page = view(tracer.Scene.load(tmp_path / "scene.toml"))
    assert contents(page)["data"][0]["name"].startswith("&lt;/script&gt;&lt;img src=x")
    assert "<img" not in page.html.replace(max(re.findall(r"<script>(.*?)</script>", page.html, re.S), key=len), "")


def test_many_surfaces_share_a_budget():
    random = np.random.default_rng(1)
    camera = tracer.Camera.look_at((0, -30, 12), (0, 0, 0))
    spheres = [
        tracer.Sphere(c, 0.1, material={"color": random.uniform(size=3)}) for c in random.normal(size=(1500, 3)) * 5
    ]
    few, many = (tracer.Scene(camera, [], spheres[:n]) for n in (MOST_TRACES, 1500))
    assert view(few).traces == MOST_TRACES + 1  # and the camera
    page = view(many, vertices=60_000)
    assert page.traces == 2 and 20_000 < page.vertices <= 60_000
    assert view(many, vertices=1).vertices == 1500 * 29
    joined = contents(page)["data"][0]
    assert joined["name"] == "sphere (1500)"
    owner = joined["customdata"][:, 0].astype(int)
    centers = np.array([s.center for s in spheres])
    np.testing.assert_allclose(np.linalg.norm(columns(joined) - centers[owner], axis=1), 0.1, rtol=1e-4)
    assert len(joined["vertexcolor"]) == page.vertices and len(np.unique(joined["vertexcolor"], axis=0)) > 1000


def test_scenes_without_bodies_and_surfaces_without_a_mesh():
    camera = tracer.Camera.look_at((0, -8, 2), (0, 0, 0))
    assert view(tracer.Scene(camera)).surfaces == 0
    assert view(tracer.Scene(camera, [], [tracer.Plane((0, 0, 1), 0.0)])).vertices == 4
    opening = EvolvedCircles([((-1, 0, 0), (0, 0, 1), 1.0), ((1, 0, 0), (0, 0, -1), 1.0)], align=False)
    page = view(tracer.Scene(camera, [], [tracer.Sphere((0, 0, 0), 1.0), opening]))
    assert len(page.missing) == 1 and page.missing[0].startswith("surfaces[1] is not shown: ")
    assert page.missing[0][:24] in page.html and page.traces == 2


def test_what_is_wrong_is_said(tmp_path, monkeypatch):
    made = tracer.Scene(tracer.Camera.look_at((0, -8, 2), (0, 0, 0)))
    for call, error, message in (
        (lambda: view("scene"), SceneError, "a Scene is needed"),
        (lambda: view(made, names=["a"]), SceneError, "names are 1"),
        (lambda: view(made, vertices=0), SceneError, "vertices is 0"),
        (lambda: view(made, tmp_path / "none" / "page.html"), InputError, "page.html"),
        (lambda: view(made, tmp_path), InputError, "written"),
    ):
        with pytest.raises(error, match=message):
            call()
    assert list(tmp_path.iterdir()) == []
    monkeypatch.setitem(sys.modules, "plotly.offline", None)
    with pytest.raises(MissingExtraError, match="view"):
        view(made)


def test_the_command(tmp_path, monkeypatch, capsys):
    monkeypatch.setitem(main.COMMANDS, "view", "")
    monkeypatch.chdir(tmp_path)
    (tmp_path / "one.toml").write_text(SCENE)
    assert main.run(["view", "one.toml", "-o", "one.html", "--vertices", "500"]) == 0
    told = capsys.readouterr().err
    assert told.count("\n") == 1 and told.startswith("one.html: ") and "1 surface with" in told
    text = (tmp_path / "one.html").read_text(encoding="utf-8")
    assert "<title>one</title>" in text
    assert main.run(["view", "one.toml", "--quiet", "--title", "Mine"]) == 0
    assert capsys.readouterr() == ("", "") and "<title>Mine</title>" in (tmp_path / "page.html").read_text()
    (tmp_path / "bad.toml").write_text(SCENE.replace("0.5\n", "-0.5\n"))
    before = (tmp_path / "one.html").stat().st_mtime_ns
    for arguments, word in (
        (["view", "none.toml"], "none.toml"),
        (["view", "bad.toml", "-o", "one.html"], "radius"),
        (["view", "one.toml", "-o", "away/one.html"], "no folder"),
        (["view", "one.toml", "-o", "one.png"], "pages are written as .html or .htm, not .png"),
        (["view", "one.toml", "--vertices", "0"], "vertices"),
    ):
        assert main.run(arguments) == 2
        last = capsys.readouterr().err.strip().splitlines()[-1]
        assert word in last, last
    assert (tmp_path / "one.html").stat().st_mtime_ns == before
    assert main.run(["view", "--help"]) == 0
    assert "Example: bladesmith view scene.toml -o page.html" in capsys.readouterr().out


# -- in a browser --------------------------------------------------------------------------------------------


SIZE = 720, 480


@pytest.fixture(scope="module")
def chromium():
    if browser() is None:
        pytest.skip("no Chromium is installed to look at pages with")
    with Chromium(*SIZE) as opened:
        yield opened


def pixels(picture):
    from PIL import Image

    return np.asarray(Image.open(io.BytesIO(picture)).convert("RGB")).astype(int)


@pytest.fixture(scope="module", params=[(0, 0, 0), (1e6, -2e6, 3e5)], ids=["near", "far"])
def opened(request, chromium, tmp_path_factory):
    """A page in the browser, with hostile names: its path, the first picture, what the tracer hits at its pixels."""
    made = scene(request.param, floor=False)
    path = tmp_path_factory.mktemp("page") / "page.html"
    view(made, path, title=HOSTILE, names=[HOSTILE, None, "blue & round", None, None], vertices=9000)
    chromium.open(path)
    return path, pixels(chromium.picture()), made.intersect(*made.camera.rays(*SIZE))


@pytest.mark.browser
def test_a_browser_draws_it_without_complaint_or_network(opened, chromium):
    path, picture, _ = opened
    assert chromium.value("document.body.dataset.state") == "ready"
    assert chromium.value("document.body.dataset.traces") == "8"
    assert chromium.value("document.querySelector('canvas').getContext('webgl') !== undefined")
    assert chromium.value("[...document.querySelectorAll('#scene canvas')].some(c => c.width > 300)")
    assert chromium.value("document.body.dataset.hacked === undefined && !document.querySelector('img')")
    assert chromium.value("document.title").startswith("</script><img src=x")
    assert chromium.complaints() == []
    assert chromium.requests() == [path.resolve().as_uri()]
    assert len(np.unique(picture.reshape(-1, 3), axis=0)) > 500
    legend = chromium.value("[...document.querySelectorAll('.legendtext')].map(t => t.textContent)")
    assert legend[0] == HOSTILE[:47] + "\u2026" and legend[2] == "blue & round" and len(legend) == 8


@pytest.mark.browser
def test_what_the_browser_draws_is_where_the_rays_hit(opened, chromium):
    """The first picture against the tracer: the same pixels are covered, and the sphere is blue."""
    _, picture, hits = opened
    width, height = SIZE
    pale = np.median(picture[:40, :40].reshape(-1, 3), axis=0)
    drawn = np.abs(picture - pale).max(-1) > 24
    free = np.ones((height, width), bool)
    legend = "document.querySelector('.legend .bg').getBoundingClientRect()"
    left, bottom = (int(chromium.value(f"{legend}.{side}")) for side in ("left", "bottom"))
    free[:40], free[-50:], free[: bottom + 2, left - 2 :] = False, False, False  # title, buttons, legend
    edges = np.zeros((height, width), bool)
    for axis in (0, 1):
        for step in range(-5, 6):
            edges |= np.roll(hits.surface, step, axis) != hits.surface
    compared = free & ~edges
    assert compared.mean() > 0.3 and (hits.hit & compared).sum() > 5000
    assert (drawn == hits.hit)[compared].mean() > 0.99  # the lines of the camera and of controls are drawn too
    blue = picture[compared & (hits.surface == 2)]
    assert len(blue) > 200 and (blue[:, 2] > blue[:, 0] + 40).mean() > 0.98


@pytest.mark.browser
def test_what_is_under_the_mouse_is_told(opened, chromium):
    hits = opened[2]
    rows, columns_ = np.nonzero(hits.surface == 0)
    row, column = int(np.median(rows)), int(np.median(columns_))
    chromium.point(column, row)
    told = chromium.wait("[...document.querySelectorAll('.hovertext text')].map(t => t.textContent).join(' | ')")
    assert told.startswith(HOSTILE[:47]) and "evolved circles" in told
    alpha = float(told.split("alpha = ")[1])
    assert alpha == pytest.approx(hits.alpha[row, column], abs=0.1)
    found = [
        sum(float(part.replace("\u2212", "-")) for part in text.split(" + "))
        for text in re.findall(r"[xyz] = ([-\u2212\d.e+ ]+?)(?=[xyz] =|alpha)", told)
    ]
    np.testing.assert_allclose(found, hits.point[row, column], atol=0.2)
    assert chromium.complaints() == []


@pytest.mark.browser
def test_buttons_and_the_legend_work(opened, chromium):
    first = opened[1]
    chromium.click("#overview")
    chromium.value("new Promise(done => setTimeout(done, 300))")
    over = pixels(chromium.picture())
    assert (np.abs(over - first).max(-1) > 24).mean() > 0.05
    chromium.click("#axes")
    chromium.wait("document.getElementById('axes').getAttribute('aria-pressed') === 'true'")
    assert chromium.value("document.getElementById('scene')._fullLayout.scene.xaxis.visible")
    chromium.click("#axes")
    chromium.click("#camera")
    chromium.value("new Promise(done => setTimeout(done, 300))")
    chromium.point(5, SIZE[1] / 2)
    chromium.value("new Promise(done => setTimeout(done, 300))")
    again = pixels(chromium.picture())
    assert (np.abs(again - first).max(-1) > 24).mean() < 0.01
    assert chromium.value("document.getElementById('scene')._fullLayout.scene._scene.glplot.fovy") == pytest.approx(
        math.radians(35)
    )
    place = chromium.value(
        "(() => { const r = document.querySelectorAll('.legendtoggle')[2].getBoundingClientRect();"
        " return [r.x + r.width / 2, r.y + r.height / 2]; })()"
    )
    for kind in ("mousePressed", "mouseReleased"):
        chromium.call("Input.dispatchMouseEvent", type=kind, x=place[0], y=place[1], button="left", clickCount=1)
    chromium.wait("document.getElementById('scene').data[2].visible === 'legendonly'")
    assert chromium.complaints() == []
