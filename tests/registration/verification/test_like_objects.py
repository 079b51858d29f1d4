"""Edges of one prism, or facets of one surface, are matched together or not at all: they are not independent evidence.

Models are made anew from a mesh with noise, of which a part may be missing, and registered with the model of the mesh.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.spatial import KDTree

from bladesmith import cga3d
from bladesmith.interchange.meshes import Mesh
from bladesmith.registration import Model, model_from_mesh, register
from bladesmith.registration.search.problem import RegistrationProblem
from bladesmith.registration.verification.significance import BackgroundModel, log_gap_probability, log_nfa

from ...support.effort import FULL
from ...support.registration import rotation, scene

ALONG, AROUND = 24, 12


def tube(bend: float = 0.0, skew: float = 0.0, taper: float = 0.0) -> Mesh:
    """A tube as a robot's leg is one: all but symmetric about its axis, and end for end."""
    t = np.linspace(0, 1, ALONG)[:, None]
    a = np.linspace(0, 2 * np.pi, AROUND, endpoint=False)
    radius = 0.25 + 0.05 * np.sin(np.pi * t) + taper * t
    x, y, z = np.broadcast_arrays(
        3 * t, bend * np.sin(np.pi * t) + skew * t**3 + radius * np.cos(a), radius * np.sin(a)
    )
    corner = np.arange(ALONG * AROUND).reshape(ALONG, AROUND)
    beside = np.roll(corner, -1, axis=1)
    lower, upper = (part.reshape(-1, 1) for part in (corner[:-1], corner[1:]))
    right, far = (part.reshape(-1, 1) for part in (beside[:-1], beside[1:]))
    faces = np.concatenate([np.hstack([lower, right, upper]), np.hstack([right, far, upper])])
    return Mesh(np.stack([x, y, z], -1).reshape(-1, 3), faces)


def remade(mesh: Mesh, noise: float, seed: int, cut: float = 0.0) -> tuple[Mesh, Any, Any]:
    """The mesh elsewhere, with errors in shares of its size, without a part on one side; the turn and the shift."""
    random = np.random.default_rng(seed)
    size = float(np.ptp(mesh.vertices, axis=0).max())
    turn, shift = rotation(random.normal(size=3), random.uniform(0, np.pi)), size * random.normal(size=3)
    place = mesh.vertices + noise * size * random.normal(size=mesh.vertices.shape)
    side = mesh.vertices[mesh.faces].mean(1) @ random.normal(size=3)
    faces = mesh.faces[side <= np.quantile(side, 1 - cut)]
    used, inverse = np.unique(faces, return_inverse=True)
    return Mesh(place[used] @ turn.T + shift, inverse.reshape(faces.shape)), turn, shift


def distance(motor: Any, mesh: Mesh, turn: Any, shift: Any) -> float:
    """The largest distance of a corner from a corner of the mesh, in its sizes: symmetric poses serve as well."""
    found = (motor >> cga3d.point(mesh.vertices @ turn.T + shift)).parameters().xyz
    own = np.linalg.norm(np.asarray(found) - mesh.vertices, axis=1).max()
    other = KDTree(mesh.vertices).query(np.asarray(found))[0].max()
    return float(min(own, other) / np.ptp(mesh.vertices, axis=0).max())


#: Of each, seeds for which poses turned end for end, or slid by a ring of facets, were claimed once.
CASES = [
    ("tapered", {"taper": 0.05}, 1e-3, 0.0, (2, 6, 8)), ("tapered and cut", {"taper": 0.05}, 1e-3, 0.3, (3, 6)),
    ("skew", {"bend": 0.5, "skew": 0.3, "taper": 0.02}, 1e-2, 0.0, (6,)), ("bent", {"bend": 0.4}, 1e-2, 0.3, (1, 9)),
]  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize(("shape", "noise", "cut", "some"), [c[1:] for c in CASES], ids=[c[0] for c in CASES])
def test_what_is_claimed_of_nearly_symmetric_tubes_is_right(shape: Any, noise: float, cut: float, some: Any) -> None:
    mesh = tube(**shape)
    for seed in range(40) if FULL else some:
        copy, turn, shift = remade(mesh, noise, seed, cut)
        found = register(model_from_mesh(copy), model_from_mesh(mesh), threads=1)
        if found.converged:
            assert min(distance(m, mesh, turn, shift) for m in (found.motor, *found.ambiguous)) < 0.05, seed
        else:
            assert found.message


@pytest.mark.slow
def test_without_noise_tubes_are_found() -> None:
    for shape in ({"taper": 0.05}, {"bend": 0.5, "skew": 0.3, "taper": 0.02}):
        mesh = tube(**shape)
        copy, turn, shift = remade(mesh, 0.0, 0)
        found = register(model_from_mesh(copy), model_from_mesh(mesh), threads=1)
        assert found.converged and min(distance(m, mesh, turn, shift) for m in (found.motor, *found.ambiguous)) < 1e-6


def background(query: Model, reference: Model) -> BackgroundModel:
    return RegistrationProblem(query, reference, threads=1).ranking(2).background


def test_matches_of_edges_of_one_prism_count_less() -> None:
    mesh = tube(taper=0.05)
    edges = background(model_from_mesh(remade(mesh, 1e-3, 0)[0]), model_from_mesh(mesh))
    assert edges.has_like_objects and edges.dispersion(0.1) > 10 > 2 > edges.dispersion(1e-4)
    assert edges.power < 3 and edges.probability(0.05) > edges.rate * 0.2**3
    for spec in ({"lines": 20}, {"lines": 10, "planes": 10}, {"lines": 300}):
        query, reference, *_ = scene(spec, 1, noise=1e-2)
        others = background(query, reference)
        assert not others.has_like_objects and others.dispersion(0.25) == 1.0


def test_matches_that_count_as_one() -> None:
    """Ten times as many matches, ten of which count as one, say what a tenth of them does."""
    assert log_nfa(80, 100, 0.01, 1000, 10.0) == pytest.approx(log_nfa(8, 10, 0.01, 1000))
    assert log_gap_probability(80, 20, 1000, 0.01, 10.0) == pytest.approx(log_gap_probability(80, 20, 1000, 0.01) / 10)
