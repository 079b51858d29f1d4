"""What notebooks show: mathematics, and a small picture of what has one."""

from __future__ import annotations

import base64
import io
import subprocess
import sys
from typing import Any

import numpy as np
import pytest

import bladesmith as bs
from bladesmith import cga3d as cga
from bladesmith import common, curves, dynamics, kinematics, plot, reform
from bladesmith import pga3d as pga

DRAWN = {
    "point": cga.point((1, 2, 3)),
    "line": pga.line((0, 0, 1), (1, 0, 0)),
    "circle": cga.circle((0, 0, 0), (0, 0, 1), 1.0),
    "plane": cga.plane((0, 0, 1), 1.0),
    "sphere": cga.sphere((0, 0, 0), 2.0),
    "point pair": cga.point_pair((0, 0, 0), (1, 0, 0)),
    "dual sphere": cga.sphere((0, 0, 0), 1.0).dual(),
    "batch": cga.sphere(np.arange(12.0).reshape(2, 2, 3), 0.5),
    "many": cga.point(np.random.default_rng(0).normal(size=(5000, 3))),
    "some are no objects": cga.sphere([(0, 0, 0), (0, 0, np.nan)], 1.0),
    "curve": curves.Bezier(cga.circle([(0, 0, 0), (0, 0, 2)], (0, 0, 1), [1.0, 2.0])),
    "model": reform.Model(points=np.eye(3)),
}
NOT_DRAWN = {
    "scalar": cga.scalar(2.0),
    "not a blade": cga.e12 + cga.e3 * cga.no,
    "imaginary": cga.multivector({"no": 1.0, "ni": 1.0}),
    "not finite": cga.e1 * np.nan,
    "empty": cga.point(np.zeros((0, 3))),
    "no geometry": bs.algebra(3).e1,
    "a batch without geometry": bs.algebra(3).e1 * np.ones(3),
}


def is_drawn(bundle: dict[str, str]) -> bool:
    """Whether the picture has colors, or ink: the box of coordinates is gray."""
    image = pytest.importorskip("PIL.Image")
    pixels = np.asarray(image.open(io.BytesIO(base64.b64decode(bundle["image/png"]))).convert("RGB"), float)
    return bool(((np.ptp(pixels, axis=-1) > 60) | (pixels.max(-1) < 70)).any())


@pytest.mark.parametrize("name", DRAWN)
def test_objects_have_a_picture(name: str) -> None:
    bundle = DRAWN[name]._repr_mimebundle_()
    assert is_drawn(bundle) and len(bundle["image/png"]) < 150_000
    text = bundle["text/markdown"]
    assert bundle["image/png"] in text and text.startswith(("$", "`<"))


@pytest.mark.parametrize("name", NOT_DRAWN)
def test_what_is_no_object_shows_its_mathematics_alone(name: str) -> None:
    assert NOT_DRAWN[name]._repr_mimebundle_() == {}
    assert NOT_DRAWN[name]._repr_latex_().startswith("$")


def test_only_what_is_asked_for_is_drawn(monkeypatch: pytest.MonkeyPatch) -> None:
    x = DRAWN["circle"]
    assert set(x._repr_mimebundle_(include={"image/png", "text/plain"})) == {"image/png"}
    assert set(x._repr_mimebundle_(exclude={"image/png"})) == {"text/markdown"}
    monkeypatch.setattr(common.rich_display, "painter", lambda _: pytest.fail("drawn"))
    assert x._repr_mimebundle_(include={"text/plain"}) == {}


@pytest.mark.parametrize("failure", [RuntimeError("broken"), bs.errors.MissingExtraError("plot", "Drawing"), None])
def test_a_picture_that_fails_breaks_no_repr(failure: Exception | None, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(thing: Any) -> Any:
        if failure is None:
            return plot  # no figure
        raise failure

    monkeypatch.setattr(common.rich_display, "painter", fail)
    assert DRAWN["circle"]._repr_mimebundle_() == {}


def test_batches_show_their_shape_and_their_ends() -> None:
    text = cga.point(np.arange(60.0).reshape(4, 5, 3))._repr_latex_()
    assert r"\text{point of cga3d, shape (4, 5)}" in text and text.count(r"\\") == 7 and text.count(r"\vdots") == 1
    assert r"\mathbf{e}_{2} + 59 \mathbf{e}_{3}" in text
    pairs = cga.point_pair(np.zeros((2, 3)), np.eye(3)[:2])
    assert r"\text{point\_pair of cga3d, shape (2,)}" in pairs._repr_latex_()


def test_statuses_are_shown() -> None:
    flat = cga.line((0, 0, 0), (0, 0, 1)) & cga.line((0, 0, 1), (1, 0, 0))
    x = (flat * 0).normalized()
    assert x.status != 0 and rf"\text{{({bs.Status(int(x.status)).name})}}" in x._repr_latex_()


@pytest.mark.slow
def test_motions_mechanisms_and_trajectories_have_a_picture() -> None:
    rod = dynamics.RigidBody(1.0, dynamics.rod(1.0).inertia(1.0), (0.5, 0, 0))
    swing = dynamics.Simulation(rod, dynamics.Gravity()).run(1.0, step=0.1)
    arm = kinematics.load_urdf(kinematics.urdf_example("arm")).mechanism()
    for thing in (swing, arm, cga.translator((1, 2, 3))):
        assert is_drawn(thing._repr_mimebundle_())


@pytest.mark.peers
def test_terminals_and_plain_text_load_no_pictures() -> None:
    code = (
        "import sys; from bladesmith import cga3d as cga\n"
        "from IPython.terminal.interactiveshell import TerminalInteractiveShell as Shell\n"
        "found, _ = Shell.instance().display_formatter.format(cga.circle((0, 0, 0), (0, 0, 1), 1.0))\n"
        "assert set(found) == {'text/plain'} and 'matplotlib.figure' not in sys.modules, found\n"
    )
    pytest.importorskip("IPython")
    subprocess.run([sys.executable, "-c", code], check=True)
