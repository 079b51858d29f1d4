"""Triangles, closed meshes, and their first hits."""

from __future__ import annotations

import numpy as np
import trimesh

from bladesmith import tracer

TRIANGLE = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
ONE = np.array([[0, 1, 2]])


def first(surface, origins, directions, **options):
    camera = tracer.Camera.look_at((0, -5, 0), (0, 0, 0))
    return tracer.Scene(camera, [], [surface]).intersect(origins, directions, **options)


def star(rng, subdivisions=2):
    """A closed mesh that is not convex, with triangles of all shapes, and a place inside."""
    ball = trimesh.creation.icosphere(subdivisions=subdivisions)
    return ball.vertices * np.exp(rng.normal(0, 0.3, (len(ball.vertices), 1))), np.array(ball.faces)
