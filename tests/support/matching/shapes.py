"""Meshes to make models of: thirty shapes, some of them symmetric or nearly so; the same with noise, elsewhere, cut."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import trimesh

from bladesmith import cga3d
from bladesmith.interchange.meshes import Mesh

from ..registration import rotation

Array = np.ndarray
ALONG, AROUND = 24, 12


def tube(bend: float = 0.0, skew: float = 0.0, taper: float = 0.0) -> Mesh:
    """A tube as a robot's leg is one: all but symmetric about its axis, and end for end."""
    t = np.linspace(0, 1, ALONG)[:, None]
    a = np.linspace(0, 2 * np.pi, AROUND, endpoint=False)
    radius = 0.25 + 0.05 * np.sin(np.pi * t) + taper * t
    y = bend * np.sin(np.pi * t) + skew * t**3 + radius * np.cos(a)
    x, y, z = np.broadcast_arrays(3 * t, y, radius * np.sin(a))
    corner = np.arange(ALONG * AROUND).reshape(ALONG, AROUND)
    beside = np.roll(corner, -1, axis=1)
    lower, upper = (part.reshape(-1, 1) for part in (corner[:-1], corner[1:]))
    right, far = (part.reshape(-1, 1) for part in (beside[:-1], beside[1:]))
    faces = np.concatenate([np.hstack([lower, right, upper]), np.hstack([right, far, upper])])
    return Mesh(np.stack([x, y, z], -1).reshape(-1, 3), faces)


TUBES = {
    "tapered": {"taper": 0.05}, "bent and tapered": {"bend": 0.3, "taper": 0.03}, "skew": {"bend": 0.2, "skew": 0.1},
    "bent and skew": {"bend": 0.5, "skew": 0.3, "taper": 0.02}, "bent": {"bend": 0.4},
}  # fmt: skip


def shapes() -> Iterator[tuple[str, Mesh]]:
    """Thirty of them, with names."""
    random = np.random.default_rng(7)
    make = trimesh.creation
    solids = {
        "box": make.box((1, 2, 3)), "cube": make.box((1, 1, 1)), "hexagonal prism": make.cylinder(0.5, 2, sections=6),
        "cylinder": make.cylinder(0.5, 2, sections=24), "cone": make.cone(0.6, 1.5, sections=16),
        "annulus": make.annulus(0.4, 0.7, 1.0, sections=20), "torus": make.torus(1, 0.3, 16, 10),
        "icosahedron": make.icosphere(0),
    }  # fmt: skip
    for i in range(6):
        solids[f"hull {i}"] = trimesh.convex.convex_hull(random.normal(size=(12 + 6 * i, 3)))
    for i in range(7):
        blocks = [make.box(random.uniform(0.3, 1.2, 3)) for _ in range(3 + i)]
        solids[f"blocks {i}"] = trimesh.util.concatenate(
            [block.apply_translation(random.uniform(-1, 1, 3)) for block in blocks]
        )
    for i in range(4):
        ball = make.icosphere(2)
        waves = np.sin(1.5 * ball.vertices @ random.normal(size=(3, 4)) + random.uniform(0, 6, 4))
        solids[f"blob {i}"] = trimesh.Trimesh(ball.vertices * (1 + 0.25 * waves.mean(1))[:, None], ball.faces)
    for name, solid in solids.items():
        yield name, Mesh(np.array(solid.vertices), np.array(solid.faces))
    for name, bends in TUBES.items():
        yield name, tube(**bends)


def remade(mesh: Mesh, noise: float, seed: int, cut: float = 0.0) -> tuple[Mesh, Array, Array]:
    """The mesh elsewhere, with errors in shares of its size, without a part on one side; the turn and the shift."""
    random = np.random.default_rng(seed)
    turn, shift = rotation(random.normal(size=3), random.uniform(0, np.pi)), size(mesh) * random.normal(size=3)
    place = mesh.vertices + noise * size(mesh) * random.normal(size=mesh.vertices.shape)
    side = mesh.vertices[mesh.faces].mean(1) @ random.normal(size=3)
    faces = mesh.faces[side <= np.quantile(side, 1 - cut)]
    used, inverse = np.unique(faces, return_inverse=True)
    return Mesh(place[used] @ turn.T + shift, inverse.reshape(faces.shape)), turn, shift


def size(mesh: Mesh) -> float:
    return float(np.ptp(mesh.vertices, axis=0).max())


def error(motor: Any, mesh: Mesh, turn: Array, shift: Array) -> float:
    """How far a motor lays the corners from their places, or from the surface where it is symmetric, in its sizes."""
    found = np.asarray((motor >> cga3d.point(mesh.vertices @ turn.T + shift)).parameters().xyz)
    own = np.linalg.norm(found - mesh.vertices, axis=1).max()
    triangles = np.tile(mesh.vertices[mesh.faces], (len(found), 1, 1))
    corners = np.repeat(found, len(mesh.faces), axis=0)
    away = np.linalg.norm(trimesh.triangles.closest_point(triangles, corners) - corners, axis=1)
    return float(min(own, away.reshape(len(found), -1).min(1).max()) / size(mesh))
