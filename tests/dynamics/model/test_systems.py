"""Several bodies: against equations of motion in angles, written out by hand and integrated by SciPy."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import bladesmith as bs
from bladesmith import dynamics, kinematics
from bladesmith.errors import ConstraintError, InputError, SimulationError

CGA, PGA = bs.cga3d, bs.pga3d
G = 9.81
GRAVITY = dynamics.Gravity((0, 0, -G))
ALONG_X = np.array([[0, 0, 1.0], [0, 1, 0], [-1, 0, 0]])  # the body's third axis along x


def rod(mass, ends, algebra=CGA, thin=1e-2):
    """A rod between two points, its third axis along it."""
    ends = np.asarray(ends, float)
    way = ends[1] - ends[0]
    length = np.linalg.norm(way)
    third = way / length
    first = np.cross(third, [0, 0, 1.0] if abs(third[2]) < 0.9 else [1.0, 0, 0])
    first /= np.linalg.norm(first)
    axes = np.stack([first, np.cross(third, first), third], 1)
    moment = mass * length**2 / 12
    return dynamics.RigidBody(mass, [moment, moment, thin * moment], ends.mean(0), axes, algebra=algebra)


def hinge(a, b, place, axis, algebra=CGA):
    if algebra is CGA:
        return kinematics.Revolute(a, b, CGA.circle(place, axis, 1.0))
    return kinematics.Revolute(a, b, PGA.line(place, axis), PGA.point(place))


def reference(rates, start, duration):
    found = solve_ivp(rates, (0, duration), start, method="DOP853", rtol=1e-13, atol=1e-13)
    return found.y[:, -1]


@pytest.mark.compiles
@pytest.mark.parametrize("algebra", [CGA, PGA], ids=["cga", "pga"])
def test_double_pendulum(algebra):
    bodies = {
        "one": rod(1.0, [(0, 0, 0), (1, 0, 0)], algebra),
        "two": rod(2.0, [(1, 0, 0), (2, 0, 0)], algebra),
    }
    y = (0, 1, 0)
    system = dynamics.System(
        bodies, [hinge("base", "one", (0, 0, 0), y, algebra), hinge("one", "two", (1, 0, 0), y, algebra)]
    )
    found = dynamics.Simulation(system, [GRAVITY]).run(2.0, times=[1.0, 2.0])

    def rates(_, state):
        (a, b), w = state[:2], state[2:]
        mass = np.array([[1 / 3 + 2, np.cos(a - b)], [np.cos(a - b), 2 / 3]])
        force = [-np.sin(a - b) * w[1] ** 2 - 2.5 * G * np.sin(a), np.sin(a - b) * w[0] ** 2 - G * np.sin(b)]
        return [*w, *np.linalg.solve(mass, force)]

    a, b, *_ = reference(rates, [np.pi / 2, np.pi / 2, 0, 0], 2.0)
    assert np.allclose(found["one"].position[-1], [np.sin(a) / 2, 0, -np.cos(a) / 2], atol=1e-10)
    expected = [np.sin(a) + np.sin(b) / 2, 0, -np.cos(a) - np.cos(b) / 2]
    assert np.allclose(found["two"].position[-1], expected, atol=1e-10)
    assert np.ptp(found.energy) < 1e-9 and found.violation.max() < 1e-12


@pytest.mark.compiles
def test_a_four_bar_linkage_closes_its_loop():
    """A parallelogram: all four bars stay parallel in pairs, and it swings as a pendulum of one angle."""
    corners = [(0, 0, 0), (0, 0, -1), (2, 0, -1), (2, 0, 0)]
    tilt = 0.7
    below = np.array([np.sin(tilt), 0, -np.cos(tilt)])
    corners = [np.zeros(3), below, below + [2.0, 0, 0], np.array([2.0, 0, 0])]
    bodies = [rod(m, [corners[i], corners[i + 1]]) for i, m in enumerate((1.0, 3.0, 1.0))]
    joints = [
        hinge(a, b, corner, (0, 1, 0))
        for a, b, corner in zip(
            ["base", "body_1", "body_2", "body_3"], ["body_1", "body_2", "body_3", "base"], corners, strict=True
        )
    ]
    found = dynamics.Simulation(dynamics.System(bodies, joints), [GRAVITY]).run(1.5, times=[1.5])
    inertia, moment = 2 / 3 + 3.0, 1.0 + 3.0  # of both cranks and the coupler, about the pivots
    angle, _ = reference(lambda _, y: [y[1], -moment * G * np.sin(y[0]) / inertia], [tilt, 0], 1.5)
    assert np.allclose(found["body_2"].position[-1], [1 + np.sin(angle), 0, -np.cos(angle)], atol=1e-10)
    assert np.allclose(found["body_2"].orientation, found["body_2"].orientation[0], atol=1e-11)


def delta(theta, base=0.4, arm=0.6, forearm=1.2, platform=0.15, gap=0.05):
    """The Delta robot of the text at equal angles: three arms, six rods, a platform; and its joints."""
    bodies, joints = {}, []
    height = arm * np.sin(theta) - np.sqrt(forearm**2 - (base - platform + arm * np.cos(theta)) ** 2)
    for i, turn in enumerate(2 * np.pi * np.arange(3) / 3):
        s, up = np.array([np.cos(turn), np.sin(turn), 0]), np.array([0, 0, 1.0])
        axis = np.cross(s, up)
        shoulder, elbow = base * s, (base + arm * np.cos(theta)) * s + arm * np.sin(theta) * up
        bodies[f"arm_{i}"] = rod(1.0, [shoulder, elbow])
        joints.append(hinge("base", f"arm_{i}", shoulder, axis))
        wrist = platform * s + height * up
        for side in (-1, 1):
            name, ends = f"forearm_{i}_{side}", [x + side * gap * axis for x in (elbow, wrist)]
            bodies[name] = rod(0.3, ends)
            joints.append(kinematics.Spherical(f"arm_{i}", name, CGA.point(ends[0])))
            joints.append(kinematics.Spherical(name, "platform", CGA.point(ends[1])))
    bodies["platform"] = dynamics.RigidBody(2.0, [0.02, 0.02, 0.04], (0, 0, height))
    return dynamics.System(bodies, joints), height


@pytest.mark.compiles
def test_the_delta_robot_falls_as_its_one_angle_says():
    theta = 0.2
    system, height = delta(theta)
    found = dynamics.Simulation(system, [GRAVITY]).run(0.15, times=[0.15])

    def geometry(angle):
        reach = 0.25 + 0.6 * np.cos(angle)
        drop = np.sqrt(1.44 - reach**2)
        elbow = 0.6 * np.array([-np.sin(angle), np.cos(angle)])  # its velocity, per rate of the angle
        fall = np.array([0, 0.6 * np.cos(angle) - reach * 0.6 * np.sin(angle) / drop])
        inertia = 3 * 0.36 / 3 + 6 * 0.3 / 3 * (elbow @ elbow + elbow @ fall + fall @ fall) + 2 * fall @ fall
        z_elbow = 0.6 * np.sin(angle)
        potential = G * (3 * z_elbow / 2 + 6 * 0.3 * (z_elbow + z_elbow - drop) / 2 + 2 * (z_elbow - drop))
        return inertia, potential, z_elbow - drop

    def rates(_, y):
        h = 1e-5
        (lower, v_lower, _), (upper, v_upper, _) = geometry(y[0] - h), geometry(y[0] + h)
        slope, force = (upper - lower) / (2 * h), (v_upper - v_lower) / (2 * h)
        return [y[1], (-force - slope * y[1] ** 2 / 2) / geometry(y[0])[0]]

    angle, _ = reference(rates, [theta, 0], 0.15)
    platform = found["platform"]
    assert geometry(theta)[2] == pytest.approx(height)
    assert np.allclose(platform.position[-1], [0, 0, geometry(angle)[2]], atol=1e-8)  # differences by h: 1e-10
    assert np.allclose(platform.orientation[-1], np.eye(3), atol=1e-10)
    assert np.ptp(found.energy) < 1e-9 and found.violation.max() < 1e-11


@pytest.mark.compiles
def test_other_joints_hold():
    """A rod on a universal joint keeps two angles, a slider one way, a cylinder two."""
    body = rod(1.0, [(0, 0, 0), (1, 0, 0)])
    circles = CGA.circle((0, 0, 0), (0, 1, 0), 0.1), CGA.circle((0, 0, 0), (0, 0, 1), 0.1)
    joints = {
        2: kinematics.Universal("base", "rod", *circles),
        1: kinematics.Prismatic("base", "rod", CGA.line((0, 0, 0), (1, 0, -1)), CGA.plane((0, 1, 0), 0.0)),
        3: kinematics.Planar("base", "rod", CGA.plane((1, 0, 1.0), 0.0)),
    }
    for mobility, joint in joints.items():
        assert joint.mobility == mobility
        found = dynamics.Simulation(dynamics.System({"rod": body}, [joint]), [GRAVITY]).run(0.5, times=[0.5])
        assert found.violation.max() < 1e-12 and np.ptp(found.energy) < 1e-10, joint.label
        assert np.abs(found.position[-1] - found.position[0]).max() > 0.05
    way = 0.25 * G * 0.5**2  # down a slope of 45 degrees: half of g/sqrt(2), along (1, 0, -1)/sqrt(2)
    slide = dynamics.Simulation(dynamics.System({"rod": body}, [joints[1]]), [GRAVITY]).run(0.5, times=[0.5])
    assert np.allclose(slide.position[-1] - slide.position[0], [way, 0, -way], atol=1e-11)


@pytest.mark.compiles
def test_a_spring_between_bodies_pulls_both():
    left = dynamics.RigidBody(1.0, [0.1, 0.1, 0.1], (0, 0, 0))
    right = dynamics.RigidBody(3.0, [0.1, 0.1, 0.1], (2.0, 0, 0))
    spring = dynamics.Spring((0, 0, 0), (0, 0, 0), 12.0, 1.5, body="left", other="right")
    found = dynamics.Simulation(dynamics.System({"left": left, "right": right}), [spring]).run(0.7, times=[0.7])
    gap = 1.5 + 0.5 * np.cos(np.sqrt(12 / 0.75) * 0.7)
    assert found["right"].position[-1, 0] - found["left"].position[-1, 0] == pytest.approx(gap, abs=1e-11)
    assert np.ptp(found.energy) < 1e-11


def test_what_is_wrong_with_systems_is_told():
    body = rod(1.0, [(0, 0, 0), (1, 0, 0)])
    point = CGA.point((0, 0, 0))
    with pytest.raises(InputError, match="there is no body 'rood'.*'rod'"):
        dynamics.System({"rod": body}, [kinematics.Spherical("base", "rood", point)])
    with pytest.raises(InputError, match="a body and itself"):
        kinematics.Spherical("rod", "rod", point)
    with pytest.raises(InputError, match="a point .*is needed"):
        kinematics.Spherical("base", "rod", CGA.line((0, 0, 0), (1, 0, 0)))
    with pytest.raises(InputError, match="mobility of 2"):
        line = CGA.line((0, 0, 0), (1, 0, 0))
        kinematics.Prismatic("base", "rod", line, -line)
    with pytest.raises(InputError, match="0.5 apart"):
        kinematics.Universal(
            "base", "rod", CGA.circle((0, 0, 0), (1, 0, 0), 1.0), CGA.circle((0, 0, 0.5), (0, 0, 1), 1.0)
        )
    with pytest.raises(InputError, match="one algebra"):
        dynamics.System({"a": body, "b": rod(1.0, [(0, 0, 0), (1, 0, 0)], PGA)})
    with pytest.raises(InputError, match="at least one body"):
        dynamics.System({})


def test_a_mechanism_that_becomes_singular_says_when():
    """Four bars stretched on one line: two of them may fold either way."""
    bodies = [rod(1.0, [(i, 0, 0), (i + 1, 0, 0)]) for i in range(3)]
    names = ["base", "body_1", "body_2", "body_3", "base"]
    joints = [hinge(names[i], names[i + 1], (i, 0, 0), (0, 1, 0)) for i in range(4)]
    with pytest.raises(SimulationError, match="rank of the constraints changed.* at time") as caught:
        dynamics.Simulation(dynamics.System(bodies, joints), [GRAVITY], coordinates="maximal").run(1.0, strict=True)
    assert len(caught.value.trajectory) >= 1
    with pytest.raises(ConstraintError, match="constraint 1"):
        pinned = dynamics.Pin(CGA.point((0, 0, 0.4)), CGA.point((5.0, 0, 0)), body="one")
        joint = kinematics.Spherical("base", "one", CGA.point((0, 0, 0)))
        system = dynamics.System({"one": rod(1.0, [(0, 0, 0), (1, 0, 0)])}, [joint])
        dynamics.Simulation(system, [GRAVITY], [pinned]).run(1.0)


def test_a_trajectory_of_several_bodies_is_asked_for_one_of_them() -> None:
    bodies = {name: dynamics.RigidBody(1.0, (1.0, 1.0, 1.0), (i, 0, 0)) for i, name in enumerate(("frame", "flap"))}
    system = dynamics.System(bodies, [hinge("frame", "flap", (1, 0, 0), (0, 0, 1))])
    found = dynamics.Simulation(system, dynamics.Gravity()).run(0.1, times=[0.0, 0.1])
    for name in ("motor", "twist", "position", "orientation", "velocity", "angular_velocity", "momentum", "reaction"):
        with pytest.raises(InputError, match=r"2 bodies: frame, flap.*trajectory\['flap'\]\.position"):
            getattr(found, name)
        getattr(found["flap"], name)
    assert found.energy.shape == (2,) and found["flap"].position[0] == pytest.approx([1, 0, 0])
    one = dynamics.System({"flap": bodies["flap"]}, [kinematics.Spherical("base", "flap", CGA.point((0, 0, 0)))])
    assert dynamics.Simulation(one).run(0.1, times=[0.0, 0.1]).position.shape == (2, 3)
