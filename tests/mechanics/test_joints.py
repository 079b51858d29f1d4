"""Joints against the freedoms that they leave, written out as six-vectors; near the origin, and far from it."""

import numpy as np
import pytest

from bladesmith import cga3d as cga
from bladesmith import kinematics as kin
from bladesmith import pga3d as pga

from ..support.effort import FULL
from ..support.kinematics import AXIS, columns, placements, shift, six, slide, turn, twist, velocity

pytestmark = pytest.mark.filterwarnings("error")
#: Placements of each joint; those that check themselves one by one have fewer, and all of them in long runs.
MANY, SOME = 1000, 1000 if FULL else 125
FAR = 1e4


def free_turns(p, frame):
    return [turn(axis, p) for axis in np.eye(3)]


#: Joint: how many placements, how it is made of names, a place and an orthonormal frame, and what it leaves.
JOINTS = {
    "spherical": (MANY, lambda b, p, f: kin.Spherical("base", b, cga.point(p)), free_turns),
    "spherical by a sphere": (MANY, lambda b, p, f: kin.Spherical("base", b, cga.sphere(p, 0.3)), free_turns),
    "cylindrical": (
        MANY,
        lambda b, p, f: kin.Cylindrical("base", b, cga.line(p, f[0])),
        lambda p, f: [turn(f[0], p), slide(f[0])],
    ),
    "planar": (
        MANY,
        lambda b, p, f: kin.Planar("base", b, cga.plane(f[0], p @ f[0])),
        lambda p, f: [turn(f[0], p), slide(f[1]), slide(f[2])],
    ),
    "revolute": (MANY, lambda b, p, f: kin.Revolute("base", b, cga.circle(p, f[0], 0.7)), lambda p, f: [turn(f[0], p)]),
    "revolute by a pair": (
        MANY,
        lambda b, p, f: kin.Revolute("base", b, cga.point_pair(p, p + 2 * f[0])),
        lambda p, f: [turn(f[0], p)],
    ),
    "two lines": (
        SOME,
        lambda b, p, f: kin.Prismatic("base", b, cga.line(p, f[0]), cga.line(p + f[1], f[0])),
        lambda p, f: [slide(f[0])],
    ),
    "two lines, one turned": (
        SOME,
        lambda b, p, f: kin.Prismatic("base", b, cga.line(p, f[0]), cga.line(p + f[1], -f[0])),
        lambda p, f: [slide(f[0])],
    ),
    "line and plane": (
        SOME,
        lambda b, p, f: kin.Prismatic("base", b, cga.line(p, f[0]), cga.plane(f[1], 0.3 + p @ f[1])),
        lambda p, f: [slide(f[0])],
    ),
    "line and direction": (
        SOME,
        lambda b, p, f: kin.Prismatic("base", b, cga.line(p, f[0]), cga.direction(f[1] + 0.5 * f[0])),
        lambda p, f: [slide(f[0])],
    ),
    "two planes": (
        SOME,
        lambda b, p, f: kin.Prismatic("base", b, cga.plane(f[1], p @ f[1]), cga.plane(f[2] - f[1], p @ (f[2] - f[1]))),
        lambda p, f: [slide(f[0])],
    ),
    "universal": (
        MANY,
        lambda b, p, f: kin.Universal("base", b, cga.circle(p, f[0], 0.7), cga.circle(p, f[1], 0.4)),
        lambda p, f: [turn(f[0], p), turn(f[1], p)],
    ),
    "spherical, pga": (MANY, lambda b, p, f: kin.Spherical("base", b, pga.point(p)), free_turns),
    "cylindrical, pga": (
        MANY,
        lambda b, p, f: kin.Cylindrical("base", b, pga.line(p, f[0])),
        lambda p, f: [turn(f[0], p), slide(f[0])],
    ),
    "planar, pga": (
        MANY,
        lambda b, p, f: kin.Planar("base", b, pga.plane(f[0], p @ f[0])),
        lambda p, f: [turn(f[0], p), slide(f[1]), slide(f[2])],
    ),
    "revolute, pga": (
        MANY,
        lambda b, p, f: kin.Revolute("base", b, pga.line(p, f[0]), pga.point(p + 0.4 * f[0])),
        lambda p, f: [turn(f[0], p)],
    ),
    "two lines, pga": (
        SOME,
        lambda b, p, f: kin.Prismatic("base", b, pga.line(p, f[0]), pga.line(p + f[1], f[0])),
        lambda p, f: [slide(f[0])],
    ),
    "line and plane, pga": (
        SOME,
        lambda b, p, f: kin.Prismatic("base", b, pga.line(p, f[0]), pga.plane(f[1], 0.3 + p @ f[1])),
        lambda p, f: [slide(f[0])],
    ),
    "two planes, pga": (
        SOME,
        lambda b, p, f: kin.Prismatic("base", b, pga.plane(f[1], p @ f[1]), pga.plane(f[2], p @ f[2])),
        lambda p, f: [slide(f[0])],
    ),
}


@pytest.mark.slow
@pytest.mark.parametrize("far", [0.0, FAR])
@pytest.mark.parametrize("name", JOINTS)
def test_what_a_joint_leaves(name, far):
    """As many bodies as placements, each on the base: rows and freedoms of all at once."""
    count, make, freedoms = JOINTS[name]
    places, frames = placements(np.random.default_rng(7), count, far)
    names = [f"b{i}" for i in range(count)]
    joints = [make(b, p, f) for b, p, f in zip(names, places, frames, strict=True)]
    m = kin.Mechanism(["base", *names], "base", joints)
    free = np.array([freedoms(p, f) for p, f in zip(places, frames, strict=True)])  # (n, f, 6)
    f = free.shape[1]
    assert m.mobility() == count * f
    matrix, kinds = m.constraint_matrix(), columns(m.algebra)
    assert matrix.shape == (count * (6 - f), 6 * count)
    rows = np.stack([matrix[(6 - f) * i : (6 - f) * (i + 1), 6 * i : 6 * i + 6].toarray() for i in range(count)])
    near = rows @ kinds @ np.linalg.inv(np.stack([shift(p) for p in places]))  # on twists seen from each joint's place
    values = np.linalg.svd(near, compute_uv=False)
    assert (values[:, -1] > 1e-3 * values[:, 0]).all()  # what is asked for is asked for once
    own = np.stack([v @ shift(p).T for v, p in zip(free, places, strict=True)])
    bar = 1e-11 if not far else 1e-6  # coefficients of far objects hold 1e8 eps of what is near them
    assert np.abs(near @ np.swapaxes(own, -1, -2)).max() < bar
    # coordinates: unit speeds of each, in turn, of all joints at once
    for k in range(f):
        speeds = np.eye(f)[k] if f > 1 else 1.0
        found = m.solve(dict.fromkeys(joints, speeds))
        twists = np.stack([six(found[b]) @ shift(p).T for b, p in zip(names, places, strict=True)])
        turning = np.linalg.norm(twists[:, :3], axis=-1)
        sliding = np.linalg.norm(twists[:, 3:], axis=-1)
        kind = np.where(np.abs(own[:, k, :3]).max(-1) > 0.5, turning, sliding)
        np.testing.assert_allclose(kind, 1, atol=bar)
        mix = np.einsum("nij,nj->ni", np.linalg.pinv(np.swapaxes(own, -1, -2)), twists)
        assert np.abs(np.einsum("nki,nk->ni", own, mix) - twists).max() < bar
        if name.split(",")[0] not in ("planar", "universal", "two planes", "two lines"):  # whose axes are not given
            np.testing.assert_allclose(twists, own[:, k], atol=bar)


def test_twists_are_what_they_are_called():
    """A point that goes with a body a little, by its motor: w counter-clockwise, v at the origin."""
    rng = np.random.default_rng(1)
    for algebra in (cga, pga):
        for _ in range(5):
            value, place, h = rng.normal(size=6), rng.normal(size=3), 1e-5
            ends = [
                ((-s * h / 2 * twist(algebra, value)).exp() >> algebra.point(place)).parameters().xyz for s in (1, -1)
            ]
            np.testing.assert_allclose((ends[0] - ends[1]) / (2 * h), velocity(value, place), atol=1e-8)
            np.testing.assert_allclose(six(twist(algebra, value)), value, atol=0)


def test_a_joint_turns_as_it_is_drawn():
    """Positive about the circle's normal, from the first point of a pair to the second, along a line; one way for
    either order of bodies."""
    for geometry in (
        cga.circle((1, 2, 3), -AXIS, 1),
        cga.point_pair((1, 2, 3), (1, 2, 1)),
        3 * cga.circle((1, 2, 3), -AXIS, 1),
    ):
        for a, b, sign in (("g", "x", 1), ("x", "g", -1)):
            joint = kin.Revolute(a, b, geometry)
            m = kin.Mechanism(["g", "x"], "g", joint)
            np.testing.assert_allclose(six(m.solve({joint: 2.0})["x"]), sign * 2 * turn(-AXIS, [1, 2, 3]), atol=1e-12)
    for line in (cga.line((1, 2, 3), AXIS), pga.line((1, 2, 3), AXIS), -2 * cga.line((1, 2, 3), -AXIS)):
        joint = kin.Cylindrical("g", "x", line)
        found = six(kin.Mechanism(["g", "x"], "g", joint).solve({joint: [2, 3]})["x"])
        np.testing.assert_allclose(found, 2 * turn(AXIS, [1, 2, 3]) + 3 * slide(AXIS), atol=1e-12)
    joint = kin.Spherical("g", "x", cga.point((1, 2, 3)))
    found = six(kin.Mechanism(["g", "x"], "g", joint).solve({joint: [2, 3, 5]})["x"])
    np.testing.assert_allclose(found, turn([2, 3, 5], [1, 2, 3]), atol=1e-12)
    crossed = kin.Prismatic("g", "x", cga.plane([1, 0, 0], 1), cga.plane([0, 1, 0], 2))
    found = six(kin.Mechanism(["g", "x"], "g", crossed).solve({crossed: 2})["x"])
    np.testing.assert_allclose(found, 2 * slide(AXIS), atol=1e-12)


def test_a_screw_has_an_axis_to_share():
    value = turn([0, 3, 4], [1, 2, 3]) + 0.7 * slide(np.array([0, 3, 4]))
    for algebra in (cga, pga):
        joint = kin.Cylindrical("g", "x", twist(algebra, value))
        found = kin.Mechanism(["g", "x"], "g", joint).solve({joint: [1, 0]})["x"]
        np.testing.assert_allclose(six(found), turn([0, 0.6, 0.8], [1, 2, 3]), atol=1e-12)


def test_rigid_joints_leave_nothing():
    rng = np.random.default_rng(3)
    for algebra in (None, cga, pga):
        place = FAR * rng.normal(size=3)
        m = kin.Mechanism(["g", "x"], "g", kin.Rigid("g", "x", place, algebra))
        assert m.mobility() == 0 and m.constraint_matrix().shape == (6, 6)
        assert np.abs(six(m.solve({"x": 0 * twist(m.algebra, np.ones(6))})["x"])).max() == 0


def test_single_precision_is_geometry_too():
    place, axis = np.float32([1.5, 2, 3]), np.float32([0, 0, 1])
    joints = {
        kin.Revolute("g", "x", cga.circle(place, axis, np.float32(0.5))): 1,
        kin.Spherical("g", "x", cga.point(place)): 3,
        kin.Cylindrical("g", "x", cga.line(place, axis)): 2,
    }
    for joint, left in joints.items():
        assert kin.Mechanism(["g", "x"], "g", joint).mobility() == left
