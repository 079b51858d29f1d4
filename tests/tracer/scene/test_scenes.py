"""Scenes and what they are made of: names of surfaces, looks, and that nothing changes once it is made."""

from __future__ import annotations

import copy
import pickle

import pytest

from bladesmith import tracer
from bladesmith.errors import SceneError

from ...support.tracer.scenes import BALL, CAMERA, SCENE, TUBE


def test_hits_know_the_names_of_their_surfaces() -> None:
    named = tracer.Sphere((0, 0, 0), 1)
    named.name = "ball"
    scene = tracer.Scene(CAMERA, [], [tracer.Disc((5, 0, 0), (0, 1, 0), 1), named])
    hits = scene.intersect([[(0, -9, 0), (5, -9, 0)], [(0, -9, 0), (9, -9, 0)]], (0, 1, 0))
    assert scene.names().tolist() == ["disc [0]", "ball"]
    assert scene.names(hits.surface).tolist() == [["ball", "disc [0]"], ["ball", ""]]
    assert tracer.Scene(CAMERA).names().tolist() == []
    for wrong in ([2], [-2], [0.5], "ball"):
        with pytest.raises(SceneError, match="indices"):
            scene.names(wrong)


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
            with pytest.raises(SceneError, match=f"{name} cannot be changed after construction"):
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


def test_texts_say_what_things_are() -> None:
    camera = tracer.Camera.look_at((0, -8, 2), (0, 0, 0.5))
    plane = tracer.Plane((0, 0, 2), -0.0)
    tube = tracer.EvolvedPointPairs([((0, 0, 0), (0, 0, 1)), ((1, 0, 0), (1, 0, 1))])
    facets = tracer.Facets([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    texts = {
        "Camera(position=(0, -8, 2), focal_length=1, y_max=0.828427)": camera,
        "Light(position=(4, -6, 8), color=(1, 1, 1))": tracer.Light((4, -6, 8)),
        "Plane(normal=(0, 0, 1), offset=0)": plane,
        "Sphere(center=(1, 0, 0), radius=0.333333)": tracer.Sphere((1, 0, 0), 1 / 3),
        "EvolvedPointPairs(curve=<Bezier of 2 point_pairs, degree 1, on [0, 1]>)": tube,
        "<Facets: 3 vertices, 1 triangles>": facets,
        f"<Scene: 2 surfaces, 0 lights, {camera!r}>": tracer.Scene(camera, [], [plane, facets]),
    }
    assert {repr(x): x for x in texts.values()} == texts
