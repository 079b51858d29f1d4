"""Surfaces and rays on a lattice, and first hits with and without a tree."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from bladesmith import tracer
from bladesmith.codegen.programs.tracer.surface_kinds import in_order

CAMERA = tracer.Camera.look_at((0.0, -8.0, 2.0), (0.0, 0.0, 0.5))
FIELDS = ("t", "surface", "status", "point", "normal", "alpha")


def both(surfaces, origins, directions):
    """First hits with and without a tree; the same bits, or the test fails."""
    found = []
    for tree in (True, False):
        scene = tracer.Scene(CAMERA, [], surfaces)
        kinds = in_order({*scene.needs.kinds, "plane", "sphere", "disc"})  # few programs for all tests
        scene.__dict__["needs"] = replace(scene.needs, kinds=kinds, tree=tree, single=True, pictures=False)
        found.append(scene.intersect(origins, directions))
    for name in FIELDS:
        np.testing.assert_array_equal(getattr(found[0], name), getattr(found[1], name), err_msg=name)
    return found[0]


def lattice(random, count, scale, shift):
    """Spheres and discs on a lattice: equal distances, equal surfaces, boxes in one plane, rays along their sides."""
    corners = random.integers(-3, 4, (count, 3)) * scale + shift
    spheres = [
        tracer.Sphere(c, r * scale) for c, r in zip(corners, random.choice([0.2, 0.25, 0.5, 1.0], count), strict=True)
    ]
    normals = random.choice([0.0, 0.0, 1.0, 0.5], (count, 3))
    normals[~normals.any(axis=1)] = (0, 0, 1)
    corners = random.integers(-3, 4, (count, 3)) * scale + shift
    discs = [tracer.Disc(c, n, 0.3 * scale) for c, n in zip(corners, normals, strict=True)]
    return [*spheres, *discs, tracer.Plane((0, 0, 1), -3.0 * scale)]


def rays(random, count, scale, shift):
    """Some on the lattice and along its axes, some not."""
    origins = random.integers(-5, 6, (count, 3)) * scale + shift
    directions = random.integers(-1, 2, (count, 3)).astype(float)
    origins[::2] += random.normal(size=origins[::2].shape) * scale
    directions[::3] += random.normal(size=directions[::3].shape)
    directions[5::7] *= -0.0  # zero components of both signs, and no direction at all
    directions[5::7, 1] = -1.0
    return origins, directions
