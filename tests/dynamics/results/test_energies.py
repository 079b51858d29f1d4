"""Kinetic and potential energy of trajectories, beside sums over bodies and springs in plain vectors."""

from __future__ import annotations

import numpy as np
import pytest

from bladesmith import dynamics

pytestmark = pytest.mark.compiles
GRAVITY, STIFFNESS, LENGTH = np.array([1.0, 0.0, -9.81]), 30.0, 0.4
MASSES, MOMENTS = {"a": 2.0, "b": 0.5}, {"a": (0.1, 0.2, 0.25), "b": (0.03, 0.02, 0.04)}
ENDS = {"a": np.array([0.1, 0.0, -0.2]), "b": np.array([0.0, 0.3, 0.1])}


@pytest.mark.parametrize("heights", [0.5, np.array([0.5, -1.0])], ids=["one", "batch"])
def test_energies_of_two_bodies_with_a_spring(heights: float | np.ndarray) -> None:
    start = np.stack(np.broadcast_arrays(0.0, 0.2, heights), -1)
    bodies = {
        "a": dynamics.RigidBody(MASSES["a"], MOMENTS["a"], start, velocity=(0, 1, 0), angular_velocity=(1, 2, -3)),
        "b": dynamics.RigidBody(MASSES["b"], MOMENTS["b"], (1, 0, 0), angular_velocity=(0, -4, 1)),
    }
    spring = dynamics.Spring(ENDS["a"], ENDS["b"], STIFFNESS, LENGTH, body="a", other="b")
    found = dynamics.Simulation(dynamics.System(bodies, []), [dynamics.Gravity(GRAVITY), spring]).run(
        0.5, times=np.linspace(0, 0.5, 6)
    )
    kinetic = potential = np.zeros(np.shape(heights) + (6,))
    for name, body in found.bodies.items():
        spin = (np.array(MOMENTS[name]) * body.angular_velocity**2).sum(-1)
        kinetic = kinetic + (MASSES[name] * (body.velocity**2).sum(-1) + spin) / 2
        potential = potential - MASSES[name] * body.position @ GRAVITY
    ends = [found[name].position + found[name].orientation @ ENDS[name] for name in ("a", "b")]
    potential = potential + STIFFNESS * (np.linalg.norm(ends[1] - ends[0], axis=-1) - LENGTH) ** 2 / 2
    assert found.kinetic_energy.shape == found.potential_energy.shape == kinetic.shape
    assert np.abs(found.kinetic_energy - kinetic).max() < 1e-12 * kinetic.max()
    assert np.abs(found.potential_energy - potential).max() < 1e-12 * np.abs(potential).max()
    assert np.ptp(kinetic, -1).min() > 0.1 and np.ptp(found.energy, -1).max() < 1e-8
    assert (found["b"].kinetic_energy == found.kinetic_energy).all()  # of all bodies, whichever is asked
