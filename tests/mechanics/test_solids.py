"""Masses, centres and tensors of solids given as meshes: in closed form and against `trimesh`."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from bladesmith import cga3d as cga
from bladesmith import dynamics
from bladesmith import pga3d as pga
from bladesmith.errors import InputError
from bladesmith.interchange.meshes import Mesh

from ..support.formulas import EPS

ALGEBRAS = [cga, pga]

CUBE = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], float)
SIDES = np.array(
    [
        [0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1],
        [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3],
    ]
)  # fmt: skip


@pytest.mark.parametrize("size, away", [(1.0, 0.0), (1e-6, 0.0), (1.0, 1e4), (1e4, 0.0)])
def test_a_cuboid(size: float, away: float) -> None:
    a, b, c = sides = size * np.array([1.0, 2.0, 3.0])
    found = dynamics.mass_properties((CUBE * sides + away, SIDES), density=5.0)
    mass = 5 * a * b * c
    room = 1e-14 + 100 * EPS * away / size
    assert np.isclose(found.mass, mass, rtol=room) and np.allclose(
        found.center, away + sides / 2, rtol=1e-15, atol=room * size
    )
    expected = mass / 12 * np.diag([b * b + c * c, a * a + c * c, a * a + b * b])
    assert np.allclose(found.tensor, expected, rtol=0, atol=room * expected.max())


@pytest.mark.parametrize("algebra", ALGEBRAS)
def test_solids_against_trimesh_and_in_motion(algebra: Any) -> None:
    trimesh = pytest.importorskip("trimesh")
    shape = trimesh.creation.torus(2.0, 0.5)
    shape.apply_transform(trimesh.transformations.rotation_matrix(0.7, (1, 2, 3), (0.5, 0, 1)))
    shape.apply_translation((3, -2, 1))
    q = dynamics.Inertia.from_mesh((shape.vertices, shape.faces), mass=4.0, algebra=algebra)
    per_mass = shape.moment_inertia / shape.volume
    assert np.allclose(q.center, shape.center_mass, atol=1e-12) and np.allclose(q.tensor, 4 * per_mass, atol=1e-10)
    assert q.mass == 4 and "mass 4" in repr(q)
    assert repr(dynamics.RigidBody(4, (1, 2, 2.5))) == "<RigidBody: mass 4, moments (1, 2, 2.5), at (0, 0, 0), cga3d>"
    assert repr(dynamics.RigidBody([4, 5], (1, 2, 2.5))) == "<RigidBody: 2 bodies in cga3d>"
    outer, inner = CUBE * 4 - 2, CUBE * 2 - 1
    shell = dynamics.mass_properties((np.concatenate([outer, inner]), np.concatenate([SIDES, SIDES[:, ::-1] + 8])))
    assert np.isclose(shell.mass, 56) and np.allclose(shell.tensor, np.eye(3) * (64 * 32 - 8 * 8) / 12)


def test_meshes_that_are_no_solids() -> None:
    repeated = (CUBE[SIDES].reshape(-1, 3), np.arange(36).reshape(12, 3))  # as STL has it: corners at one place are one
    assert np.isclose(dynamics.mass_properties(Mesh(*repeated)).mass, 1)
    with pytest.raises(InputError, match="not closed: 3 edges"):
        dynamics.mass_properties((CUBE, SIDES[1:]))
    with pytest.raises(InputError, match="inconsistent at 3 edges"):
        dynamics.mass_properties((CUBE, np.concatenate([SIDES[:1, ::-1], SIDES[1:]])))
    with pytest.raises(InputError, match="face inwards: they enclose the volume -1"):
        dynamics.mass_properties((CUBE, SIDES[:, ::-1]))
    with pytest.raises(InputError, match="no volume"):
        dynamics.mass_properties((CUBE * (1, 1, 0), SIDES))
    with pytest.raises(InputError, match="both given"):
        dynamics.mass_properties((CUBE, SIDES), density=1.0, mass=1.0)
    with pytest.raises(InputError, match="density is -1"):
        dynamics.mass_properties((CUBE, SIDES), density=-1.0)
    with pytest.raises(InputError, match="no triangles"):
        dynamics.mass_properties((CUBE, np.zeros((0, 3), int)))
    with pytest.raises(InputError, match="Mesh, a path or"):
        dynamics.mass_properties(3)
    with pytest.raises(InputError, match="vertices.0, 0. is nan"):
        dynamics.mass_properties((np.where(CUBE == 0, np.nan, CUBE), SIDES))
