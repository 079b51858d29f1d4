"""Drag between two bodies: against Newton and Euler in three-vectors, by SciPy; files, gradients, refusals."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import bladesmith as bs
from bladesmith import dynamics
from bladesmith.errors import InputError

ALGEBRAS = {"cga": bs.cga3d, "pga": bs.pga3d}
MASSES, MOMENTS = (1.0, 2.5), np.array([[0.4, 0.5, 0.6], [1.0, 1.3, 1.9]])
POINT, ANCHOR = np.array([0.2, 0.1, -0.3]), np.array([-0.1, 0.3, 0.2])
#: Moment and force per velocity, the same per square of it; stiffness, length and damping of a spring.
DRAG, SQUARES, SPRING = (0.7, 0.4), (0.3, 0.2), (20.0, 0.5, 1.5)


def start(seed=4):
    """Positions, velocities and angular velocities along the bodies' axes (2, 3)."""
    return np.random.default_rng(seed).normal(size=(3, 2, 3))


def bodies(algebra, mass=MASSES[0]):
    return {
        name: dynamics.RigidBody(m, moments, x, velocity=v, angular_velocity=w, algebra=algebra)
        for name, m, moments, x, v, w in zip("ab", (mass, MASSES[1]), MOMENTS, *start(), strict=True)
    }


def loads():
    return [
        dynamics.Damper(*DRAG, "a", "b"),
        dynamics.QuadraticDrag(*SQUARES, body="a", other="b"),
        dynamics.Damper(0.1, 0.2, "b"),
        dynamics.Spring(POINT, ANCHOR, *SPRING, body="a", other="b"),
    ]


def rates(_, state):
    """Newton and Euler for both bodies: positions, rotations, velocities, angular velocities along their axes."""
    x, turn, v, w = np.split(state, [6, 24, 30])
    x, turn, v, w = x.reshape(2, 3), turn.reshape(2, 3, 3), v.reshape(2, 3), w.reshape(2, 3)
    spin = np.einsum("bij,bj->bi", turn, w)
    arm = x[0] - x[1]
    turning, moving = spin[0] - spin[1], v[0] - v[1] - np.cross(spin[1], arm)
    force = -(DRAG[1] + SQUARES[1] * np.linalg.norm(moving)) * moving
    moment = -(DRAG[0] + SQUARES[0] * np.linalg.norm(turning)) * turning
    ends = [turn[0] @ POINT, turn[1] @ ANCHOR]
    gap = x[1] + ends[1] - x[0] - ends[0]
    length = np.linalg.norm(gap)
    closing = v[1] + np.cross(spin[1], ends[1]) - v[0] - np.cross(spin[0], ends[0])
    pull = (SPRING[0] * (length - SPRING[1]) + SPRING[2] * (closing @ gap) / length) * gap / length
    forces = np.array([force + pull, -force - pull - 0.2 * v[1]])
    moments = np.array([
        moment + np.cross(ends[0], pull), -moment - np.cross(arm, force) - np.cross(ends[1], pull) - 0.1 * spin[1],
    ])  # fmt: skip
    own = np.einsum("bji,bj->bi", turn, moments)
    crossed = np.stack([np.cross(np.eye(3), each).T for each in -w], 0)  # crossed @ u is w x u
    return np.concatenate([
        v.ravel(), (turn @ crossed).ravel(), (forces / np.array(MASSES)[:, None]).ravel(),
        ((own - np.cross(w, MOMENTS * w)) / MOMENTS).ravel(),
    ])  # fmt: skip


@pytest.mark.compiles
@pytest.mark.parametrize("algebra", ALGEBRAS.values(), ids=ALGEBRAS)
def test_two_bodies_that_brake_each_other(algebra):
    x, v, w = start()
    turn = np.tile(np.eye(3), (2, 1, 1))
    begin = np.concatenate([each.ravel() for each in (x, turn, v, w)])
    expected = solve_ivp(rates, (0, 2), begin, method="DOP853", rtol=1e-13, atol=1e-13).y[:, -1]
    found = dynamics.Simulation(dynamics.System(bodies(algebra)), loads()).run(2.0, times=[2.0])
    assert found.integrator == "adaptive"  # no series
    mine = [[found[name].__getattribute__(what)[-1] for name in "ab"] for what in (
        "position", "orientation", "velocity", "angular_velocity")]  # fmt: skip
    assert np.abs(np.concatenate([np.ravel(each) for each in mine]) - expected).max() < 1e-10


@pytest.mark.compiles
def test_what_turns_as_one_is_not_braked_and_momentum_stays():
    """Two bodies of one rigid motion feel nothing; whatever they feel, momenta add up to what they were."""
    spin, apart = np.array([0.3, -0.8, 0.5]), np.array([1.0, 2.0, -0.5])
    pair = {
        "a": dynamics.RigidBody(1.0, (1, 1, 1), (0, 0, 0), angular_velocity=spin),
        "b": dynamics.RigidBody(2.0, (1, 1, 1), apart, velocity=np.cross(spin, apart), angular_velocity=spin),
    }
    short = dynamics.Simulation(dynamics.System(pair), [dynamics.Damper(5.0, 7.0, "a", "b")]).run(1e-6, times=[1e-6])
    change = short["a"].velocity[1] - short["a"].velocity[0]
    assert np.abs(change).max() < 1e-10  # of second order; a damper to the world would take 7e-6 of it
    system = dynamics.System(bodies(bs.pga3d))
    braked = dynamics.Simulation(system, [dynamics.Damper(5.0, 7.0, "b", "a")]).run(3.0, times=[1.0, 3.0])
    momentum = dynamics.screw_coordinates(braked["a"].momentum + braked["b"].momentum)
    assert np.ptp(momentum, 0).max() < 1e-11 and (np.diff(braked.energy) < 0).all()


@pytest.mark.compiles
def test_gradients_see_it():
    def end(mass):
        system = dynamics.System(bodies(bs.cga3d, mass))
        return dynamics.Simulation(system, loads()).run(0.5, times=[0.5])["b"].position[-1]

    system = dynamics.System(bodies(bs.cga3d))
    run = dynamics.Simulation(system, loads()).run(0.5, times=[0.5], sensitivities=["a.mass"])
    h = 1e-4
    difference = (end(1 + h) - end(1 - h)) / (2 * h)
    assert np.allclose(run["b"].sensitivities["a.mass"].position[-1, 0], difference, atol=1e-8)


def test_bad_input():
    pair = dynamics.System(bodies(bs.cga3d))
    for load, says in (
        (dynamics.Damper(1.0, body="a", other="a"), "is between one body and itself"),
        (dynamics.QuadraticDrag(1.0, body="a", other="c"), "there is no body 'c'"),
    ):
        with pytest.raises(InputError, match=says):
            dynamics.Simulation(pair, [load])
    with pytest.raises(InputError, match="the damper's other body is 0.5"):
        dynamics.Damper(1.0, other=0.5)
    with pytest.raises(InputError, match="dampers between bodies have none"):
        dynamics.Simulation(pair, [dynamics.Damper(1.0, body="a", other="b")], integrator="taylor").run(1.0)


def test_files_name_the_other_body(tmp_path):
    text = """
    [[bodies]]
    name = "a"
    mass = 1.0
    moments = [1.0, 1.0, 1.0]
    [[bodies]]
    name = "b"
    mass = 1.0
    moments = [1.0, 1.0, 1.0]
    position = [1.0, 0.0, 0.0]
    [[loads]]
    kind = "damper"
    body = "a"
    other = "b"
    linear = 0.5
    [simulation]
    duration = 1.0
    """
    (tmp_path / "pair.toml").write_text(text)
    (damper,) = dynamics.load_simulation(tmp_path / "pair.toml").simulation.loads
    assert (damper.body, damper.other, damper.linear) == ("a", "b", 0.5)
