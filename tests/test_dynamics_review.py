"""What new users met: paths that repeat themselves or end, bodies on lines far away, interrupts between two lines."""

import numpy as np
import pytest

from bladesmith import cga3d as cga
from bladesmith import dynamics
from bladesmith import pga3d as pga
from bladesmith.codegen.errors import InputError
from bladesmith.dynamics import functions

GRAVITY = dynamics.Gravity((0, 0, -9.81))


@pytest.mark.parametrize("behind", range(functions.PLACES))
def test_weights_are_exact_on_polynomials(behind):
    places = np.arange(functions.PLACES) - behind
    first, second = functions.weights(behind)
    for power in range(functions.PLACES):
        values = places.astype(float) ** power
        size = np.abs(second * values).max() + 1
        assert abs(first @ values - (power == 1)) < 1e-14 * size
        assert abs(second @ values - 2 * (power == 2)) < 1e-14 * size


@pytest.mark.parametrize("bounded", [False, True])
@pytest.mark.parametrize("rate, duration, off", [(1, 1, 1e-10), (4 * np.pi, 1, 1e-9), (20 * np.pi, 30, 1e-8),
                                                 (2e3, 1, 1e-8), (1e6, 1e-3, 1e-6)])  # fmt: skip
def test_derivatives_of_what_repeats_itself(rate, duration, off, bounded):
    def place(t):
        if bounded and not 0 <= t <= duration:
            raise InputError("the table ends")
        return np.array([np.cos(rate * t), np.sin(rate * t), 1.0])

    found = functions.Differences(place, (0.0, float(duration)))
    for t in np.linspace(0, duration, 9):
        value, first, second = found(t)
        assert np.abs(first / rate - [-value[1], value[0], 0]).max() < off
        assert np.abs(second / rate**2 + [value[0], value[1], 0]).max() < off


def test_failures_inside_are_told():
    def place(t):
        if t > 0.4:
            raise InputError("no more")
        return np.ones(2)

    with pytest.raises(InputError, match="no more"):
        functions.Differences(place, (0.0, 1.0))


def test_a_crank_of_two_turns_a_second():
    w = 4 * np.pi  # half a second is a period: steps of one and of half a second see a path that stands still

    def crank(t):
        if not 0 <= t <= 1:
            raise ValueError("outside of the table")
        return cga.point((np.cos(w * t), np.sin(w * t), 0))

    body = dynamics.RigidBody(1.3, [0.1, 0.2, 0.25], (1, 0, 0), velocity=(0, w, 0))
    found = dynamics.Simulation(body, (), dynamics.PinPath(cga.point((0, 0, 0)), crank)).run(1.0, times=[0.3, 1.0])
    angle = w * found.time
    assert np.allclose(found.velocity, w * np.stack([-np.sin(angle), np.cos(angle), 0 * angle], -1), atol=1e-7 * w)
    force, _ = dynamics.wrench_parts(found.reaction)
    towards = -1.3 * w**2 * np.stack([np.cos(angle), np.sin(angle), 0 * angle], -1)
    assert np.abs(force - towards).max() < 1e-8 * 1.3 * w**2


@pytest.mark.parametrize("size, far", [(1.0, 1e4), (0.1, 1e4), (1e-3, 1e4), (1e-6, 1.0), (1e-6, 1e4)])
@pytest.mark.parametrize("shape", ["line", "circle", "line of pga"])
def test_points_on_lines_far_away(shape, size, far):
    algebra = pga if "pga" in shape else cga
    rng = np.random.default_rng(3)
    place, along, arm = far * rng.normal(size=3), rng.normal(size=3), size * rng.normal(size=3)
    along /= np.linalg.norm(along)
    across = np.cross(along, (1, 0, 0)) / np.linalg.norm(np.cross(along, (1, 0, 0)))
    rail = cga.circle(place - size * across, along, size) if shape == "circle" else algebra.line(place, along)
    mass = 1000 * size**3
    body = dynamics.RigidBody(mass, mass * size**2 * np.array([0.1, 0.2, 0.25]), place - arm, algebra=algebra)
    held = dynamics.Incidence(algebra.point(arm), rail)
    duration = np.sqrt(size)  # the same motion at all sizes
    found = dynamics.Simulation(body, GRAVITY, held).run(duration, times=[duration])
    near = dynamics.RigidBody(mass, body.moments, -arm, algebra=algebra)
    rail = cga.circle(-size * across, along, size) if shape == "circle" else algebra.line((0, 0, 0), along)
    there = dynamics.Simulation(near, GRAVITY, dynamics.Incidence(algebra.point(arm), rail)).run(
        duration, times=[duration]
    )
    rounding = 1e-9 + 1e2 * np.finfo(float).eps * (far / size) ** (2 if shape == "circle" else 1)
    assert np.abs(found.orientation - there.orientation).max() < rounding


def test_an_interrupt_before_the_first_line_of_a_function(monkeypatch):
    asked = []
    plain = functions.Called.call

    def interrupted(self, *given):
        asked.append(1)
        if len(asked) == 500:
            raise KeyboardInterrupt  # as it comes where nothing is caught yet
        return plain(self, *given)

    monkeypatch.setattr(functions.Called, "call", interrupted)
    push = dynamics.wrench((0, 0, 1), 0)
    body = dynamics.RigidBody(1.0, [0.1, 0.2, 0.25], angular_velocity=(1, 5, 1))
    found = dynamics.Simulation(body, dynamics.WorldWrench(lambda t: push), (), "rk4").run(10.0, step=0.01)
    assert found.message == "interrupted" and found.status == "stopped" and 1 < len(found) < 1001
    assert np.isfinite(found.position).all() and len(asked) == 500
