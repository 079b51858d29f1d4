"""Scenes that tests of the tracer share: a camera, a ball, a tube, a picture that nothing is drawn into."""

import numpy as np

from bladesmith import tracer

CAMERA = tracer.Camera.look_at((0, -8, 2), (0, 0, 1))
TUBE = [((0.0, 0.0, 0.0), (0.0, 0.0, 1.0), 1.0), ((0.0, 1.0, 2.0), (0.0, 0.5, 1.0), 0.6)]
BALL = tracer.Sphere((0, 0, 0), 1.0)
SCENE = tracer.Scene(CAMERA, [tracer.Light((4, -6, 8))], [BALL])
PICTURE = np.zeros((2, 2, 3))
BLACK = (0, 0, 0)


def dark(camera, lights, surfaces, **more):
    """A scene under a black sky."""
    return tracer.Scene(camera, lights, surfaces, horizon=BLACK, zenith=BLACK, **more)


def line_direction(line):
    return -np.stack([line[f"e{i}noni"] for i in (1, 2, 3)], -1)
