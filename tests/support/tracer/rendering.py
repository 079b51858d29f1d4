"""What the tests of rendering as a service share: a small scene with a mirror and a tube, and what is wanted of it."""

from __future__ import annotations

import numpy as np

from bladesmith import tracer
from bladesmith.tracer.rendering.aov_layers import LAYERS

ALL = tuple(LAYERS)
SIZE = (60, 40)
SCENE = """
[camera]
position = [0.0, -8.0, 2.0]
look_at = [0.0, 0.0, 0.5]

[[lights]]
position = [4.0, -6.0, 8.0]

[[surfaces]]
kind = "sphere"
center = [1.5, 0.0, 0.5]
radius = 0.5

[[surfaces]]
kind = "plane"
normal = [0, 0, 1]
reflectivity = 0.2

[[surfaces]]
kind = "evolved_circles"
controls = [
    { center = [-1, 0, 0], normal = [0, 0, 1], radius = 1.0 },
    { center = [-1, 1, 2], normal = [0, 0.5, 1], radius = 0.6 },
]
"""


def written(folder):
    """The scene's file."""
    place = folder / "scene.toml"
    place.write_text(SCENE)
    return place


def all_layers(scene):
    return scene.layers(*SIZE, ALL)


def small_scene(folder):
    return tracer.Scene.load(written(folder))


def same(found, wanted):
    assert found.keys() == wanted.keys()
    for name, values in wanted.items():
        np.testing.assert_array_equal(found[name], values, err_msg=name)
        assert found[name].dtype == values.dtype
