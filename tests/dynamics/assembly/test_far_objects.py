"""Points held on objects far from the origin: distances by vector algebra, beside what `violation` says."""

from __future__ import annotations

import numpy as np
import pytest

from bladesmith import cga3d as cga
from bladesmith import dynamics
from bladesmith import pga3d as pga
from bladesmith.dynamics.assembly.far_spheres import unknown_of

from ...support.dynamics.states import sized_body

GRAVITY = dynamics.Gravity((0, 0, -9.81))
TIP = np.array([0.1, 0.2, 0.3])
RADIUS = 2.0
TILTED = np.array([0.0, 0.6, 0.8])


def place(far):
    return far * np.array([1.0, 0.3, -0.2])


#: Of each object: what it is, where the point starts on it, and how far a point is off.
OBJECTS = {
    "sphere": (lambda c: cga.sphere(c, RADIUS), (0, 0, RADIUS), lambda d: abs(np.linalg.norm(d) - RADIUS)),
    "plane": (lambda c: cga.plane(TILTED, float(TILTED @ c)), (0, 0, 0), lambda d: abs(d @ TILTED)),
    "circle": (
        lambda c: cga.circle(c, (0, 0, 1), RADIUS), (RADIUS, 0, 0),
        lambda d: np.hypot(np.hypot(d[0], d[1]) - RADIUS, d[2]),
    ),
    "line": (lambda c: cga.line(c, (1, 0, 0)), (0, 0, 0), lambda d: np.hypot(d[1], d[2])),
}  # fmt: skip


def moved(kind, far, aside, world=None):
    """How far off the point is at most, and what `violation` says."""
    made, start, off = OBJECTS[kind]
    center = place(far)
    body = dynamics.RigidBody(1.0, (0.1, 0.2, 0.25), center + start - TIP + aside)
    held = dynamics.Incidence(cga.point(TIP), world or made(center))
    simulation = dynamics.Simulation(body, [dynamics.Gravity((0.5, 1.0, -9.81))], [held])
    found = simulation.run(0.3, times=[0.1, 0.3], project=bool(aside))
    tips = found.position + found.orientation @ TIP
    return max(off(tip - center) for tip in tips), found.violation.max()


@pytest.mark.parametrize("far", [1.0, 1e2, 1e4, 1e6])
@pytest.mark.parametrize("kind", OBJECTS)
def test_a_point_stays_on_what_holds_it(kind, far) -> None:
    """To the rounding of its place."""
    off, violation = moved(kind, far, 0.0)
    assert off < 4e-15 + 4e-16 * far
    assert violation < 1e-14 + (1e-15 * far**2 if kind == "sphere" else 0)


@pytest.mark.parametrize("far", [1.0, 1e2, 1e4, 1e6])
@pytest.mark.parametrize("shift", [1e-3, 3e-2])
def test_violation_sees_what_coefficients_do_not_tell(shift, far) -> None:
    """A sphere that the start is brought to, and one that is a function of time."""
    sphere = cga.sphere(place(far), RADIUS)
    for world in (None, lambda t: sphere):
        off, violation = moved("sphere", far, shift, world)
        assert off < violation + 4e-15 + 4e-16 * far
        assert violation < 1e-14 + 2e-15 * far**2


def test_violation_sees_spheres_that_go_far_later():
    """Coefficients of a sphere at 1e4 m tell its radius to 5e-9 m, those at the start to 1e-16."""

    def center(t):
        return np.array([1e4 * np.sin(t / 2) ** 2, 0, 0])

    def sphere(t):
        return cga.sphere(center(t), RADIUS)

    body = dynamics.RigidBody(1.0, (0.1, 0.2, 0.25), (0, 0, RADIUS))
    held = dynamics.Incidence(cga.point((0, 0, 0)), sphere)
    simulation = dynamics.Simulation(body, [dynamics.Gravity((0.5, 1.0, -9.81))], [held], "rk4")
    found = simulation.run(0.5, 0.02, times=[0.1, 0.3, 0.5])
    far = np.array([np.linalg.norm(center(t)) for t in found.time])
    off = [abs(np.linalg.norm(x - center(t)) - RADIUS) for x, t in zip(found.position, found.time, strict=True)]
    assert (off <= found.violation + 4e-15 + 4e-16 * far).all()
    assert (found.violation >= 1e-16 * far**2 / RADIUS)[1:].all() and found.violation[0] == 0
    assert (found.violation < 1e-14 + 2e-15 * far**2).all()


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("radius", [1e-12, 1e-9, 1e-4])
def test_a_sphere_that_is_smaller_than_its_rounding(radius):
    """Of 1e-4 m at 1e4 m nothing is known but that it is small: the start tells the radius."""
    sphere = cga.sphere((1e4, 0, 0), radius)
    known = unknown_of(sphere)
    assert radius < known < 2e-4  # the root of what the square of the distance is rounded by
    body = dynamics.RigidBody(1.0, (0.1, 0.2, 0.25), (1e4, 0, radius))
    found = dynamics.Simulation(body, [], [dynamics.Incidence(cga.point((0, 0, 0)), sphere)]).run(0.1)
    assert np.isfinite(found.position).all() and found.violation.max() < known


@pytest.mark.compiles
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


@pytest.mark.compiles
def test_a_bead_falls_far_along_a_line():
    """4905 km: rows of which nothing but rounding is left are no new ones."""
    line = dynamics.Incidence(cga.point((0, 0, 0)), cga.line((0, 0, 0), (0, 0, 1)))
    made = sized_body(angular_velocity=(0.3, 0.1, 1.0))
    found = dynamics.Simulation(made, [GRAVITY], [line]).run(1000.0, times=[30.0, 1000.0])
    np.testing.assert_allclose(found.position[:, 2], -9.81 / 2 * found.time**2, rtol=1e-12)
    assert (np.abs(found.position[1:, :2]) <= 1e-14 * np.abs(found.position[1:, 2:])).all()


def test_a_tiny_bead_flies_far_along_a_line():
    """Ten million times its own size."""
    line = dynamics.Incidence(cga.point((0, 0, 0)), cga.line((0, 0, 0), (0, 0, 1)))
    made = sized_body(1e-6, velocity=(0, 0, 1.0), angular_velocity=(3.0, 1.0, 10.0))
    found = dynamics.Simulation(made, [GRAVITY], [line]).run(2.0, times=[2.0])
    assert found.position[-1, 2] == pytest.approx(2.0 - 9.81 / 2 * 4.0, rel=1e-12)
    assert np.abs(found.position[-1, :2]).max() <= 1e-14
