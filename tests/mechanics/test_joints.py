"""Joints against the freedoms that they leave, written out as six-vectors; near the origin, and far from it."""

import os

import numpy as np
import pytest

import bladesmith as bs
from bladesmith import cga3d as cga
from bladesmith import kinematics as kin
from bladesmith import pga3d as pga
from bladesmith.codegen.errors import (
    AlgebraMismatchError,
    BladesmithError,
    ConstraintError,
    GradeError,
    InputError,
    ShapeError,
)

from ..support.kinematics import AXIS, columns, placements, shift, six, slide, turn, twist, velocity

pytestmark = pytest.mark.filterwarnings("error")

FULL = os.environ.get("BLADESMITH_FULL_BARS", "") not in ("", "0")
#: Placements of each joint; those that check themselves one by one have fewer, and all of them in long runs.
MANY, SOME = 1000, 1000 if FULL else 125
FAR = 1e4
NAN = float("nan")


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


# -- any bilinear map ----------------------------------------------------------------------------------------------

P, Q = np.array([0.3, -0.4, 0.7]), np.array([1.0, 2.0, -0.5])
U, W = np.array([0.6, 0.0, 0.8]), np.array([0.0, 1.0, 0.0])


def on_plane(p, n):
    """A point stays in a plane: all twists that do not move it along the normal."""
    return np.concatenate([np.cross(p, n), n])[None]


#: x, y, product, H, the rows that it forbids on the twist of y's body against x's.
BILINEAR = {
    "a point on a plane": (cga.plane(U, P @ U), cga.point(P), "outer", 0, on_plane(P, U)),
    "a point on a plane, pga": (pga.plane(U, P @ U), pga.point(P), "outer", 0, on_plane(P, U)),
    "a point at a height": (cga.plane(U, 0), cga.point(P), lambda x, y: x ^ y, None, on_plane(P, U)),
    "a plane on a point": (cga.point(P), cga.plane(U, P @ U), "outer", 0, on_plane(P, U)),
    "a point on a line": (
        cga.line(P - 2 * U, U),
        cga.point(P),
        "outer",
        0,
        np.concatenate([on_plane(P, W), on_plane(P, np.cross(U, W))]),
    ),
    "a rod": (cga.point(Q), cga.point(P), "inner", None, on_plane(P, P - Q)),
    "a point on a sphere": (cga.sphere(Q, np.linalg.norm(P - Q)), cga.point(P), "outer", 0, on_plane(P, P - Q)),
    "an angle of planes": (
        cga.plane(U, 0.2),
        cga.plane(W + 0.3 * U, 1.0),
        "inner",
        None,
        np.concatenate([np.cross(U, W), np.zeros(3)])[None],
    ),
    "an angle of planes, pga": (
        pga.plane(U, 0.2),
        pga.plane(W + 0.3 * U, 1.0),
        "inner",
        None,
        np.concatenate([np.cross(U, W), np.zeros(3)])[None],
    ),
    "centres and right angles": (
        cga.circle(P, U, 1),
        cga.circle(P, W, 1),
        "anticommutator",
        0,
        on_plane(P, np.cross(U, W)),
    ),
}


@pytest.mark.parametrize("name", BILINEAR)
def test_bilinear_joints(name):
    x, y, product, h, rows = BILINEAR[name]
    joint = kin.Bilinear("g", "x", x, y, product, H=h)
    m = kin.Mechanism(["g", "x"], "g", joint)
    forbidden = m.constraint_matrix().toarray() @ columns(m.algebra)
    if name == "centres and right angles":  # the thesis's universal joint: one sphere and no more than a right angle
        assert m.mobility() == 4
        return
    assert m.mobility() == 6 - len(rows)
    left = np.linalg.svd(rows)[2][len(rows) :]
    assert np.abs(forbidden @ left.T).max() < 1e-12
    assert np.linalg.matrix_rank(forbidden) == len(rows)


def test_products_by_name_are_functions():
    line, point, circle = cga.line(Q, U), cga.point(P), cga.circle(P, W, 0.7)
    names = {
        "outer": (lambda x, y: x ^ y, line, point),
        "inner": (lambda x, y: x | y, circle, cga.circle(Q, U, 0.4)),
        "anticommutator": (lambda x, y: (x * y + y * x) / 2, circle, cga.plane(U, 0.3)),
        "meet": (lambda x, y: x.meet(y), cga.plane(W, 0.1), cga.plane(U, 0.3)),
    }
    for name, (function, x, y) in names.items():
        own = [
            kin.Mechanism(["g", "x"], "g", kin.Bilinear("g", "x", x, y, product, H=None))
            for product in (name, function)
        ]
        assert own[0].mobility() == own[1].mobility() < 6
        spaces = [np.linalg.pinv(c) @ c for c in (m.constraint_matrix().toarray() for m in own)]
        np.testing.assert_allclose(*spaces, atol=1e-10)


def test_meet_of_a_sphere_and_a_plane():
    sphere, plane = cga.sphere(Q, 2.0), cga.plane(U, Q @ U + 0.5)
    m = kin.Mechanism(["g", "x"], "g", kin.Bilinear("g", "x", sphere, plane, "meet", H=None))
    rows = m.constraint_matrix().toarray() @ columns(cga)
    free = [turn(U, Q), slide(W), slide(np.cross(U, W))]  # of the plane: in itself; the circle stays in the first body
    assert m.mobility() == 3 and np.abs(rows @ np.array(free).T).max() < 1e-12


# -- what is no joint ----------------------------------------------------------------------------------------------

LINE, CIRCLE = cga.line((0, 0, 0), AXIS), cga.circle((0, 0, 0), AXIS, 1)
WRONG = {
    "coinciding lines": (lambda: kin.Prismatic("a", "b", LINE, LINE), "mobility of 2"),
    "coinciding lines, one turned": (
        lambda: kin.Prismatic("a", "b", LINE, cga.line((0, 0, 5), -AXIS)),
        "mobility of 2",
    ),
    "skew lines": (lambda: kin.Prismatic("a", "b", LINE, cga.line((1, 0, 0), [0, 1, 0])), "mobility of 0"),
    "parallel planes": (lambda: kin.Prismatic("a", "b", cga.plane(AXIS, 0), cga.plane(AXIS, 1)), "mobility of 3"),
    "parallel planes, pga": (lambda: kin.Prismatic("a", "b", pga.plane(AXIS, 0), pga.plane(-AXIS, 1)), "mobility of 3"),
    "a plane across the line": (lambda: kin.Prismatic("a", "b", LINE, cga.plane(AXIS, 1)), "not a translation"),
    "an oblique plane": (lambda: kin.Prismatic("a", "b", LINE, cga.plane([0, 1, 1], 1)), "mobility of 0"),
    "a parallel direction": (lambda: kin.Prismatic("a", "b", LINE, cga.direction(AXIS)), "mobility of 2"),
    "two directions": (lambda: kin.Prismatic("a", "b", cga.direction(AXIS), cga.direction([1, 0, 0])), "mobility of 3"),
    "two points": (lambda: kin.Prismatic("a", "b", cga.point((0, 0, 0)), cga.point((0, 0, 1))), "not a translation"),
    "no second object": (lambda: kin.Prismatic("a", "b", LINE, None), "one multivector"),
    "zero": (lambda: kin.Prismatic("a", "b", 0 * LINE, cga.plane([1, 0, 0], 0)), "is zero"),
    "planes that lean": (
        lambda: kin.Universal("a", "b", CIRCLE, cga.circle((0, 0, 0), [1, 0, 1], 1)),
        "not at right angles",
    ),
    "centres apart": (lambda: kin.Universal("a", "b", CIRCLE, cga.circle((1, 0, 0), [1, 0, 0], 1)), "1 apart"),
    "a point for a circle": (lambda: kin.Universal("a", "b", CIRCLE, cga.point((1, 0, 0))), "a circle is needed"),
    "a line for a circle": (lambda: kin.Universal("a", "b", CIRCLE, LINE), "no center"),
    "circles of pga": (
        lambda: kin.Universal("a", "b", pga.line((0, 0, 0), AXIS), pga.line((0, 0, 0), U)),
        "a circle is needed",
    ),
    "two algebras": (lambda: kin.Universal("a", "b", CIRCLE, pga.line((0, 0, 0), AXIS)), "one algebra"),
    "strings": (lambda: kin.Universal("a", "b", "x", "y"), "one multivector"),
    "nothing": (lambda: kin.Revolute("a", "b", None), "one multivector"),
    "an array": (lambda: kin.Revolute("a", "b", np.zeros(10)), "one multivector"),
    "a batch": (lambda: kin.Revolute("a", "b", cga.circle(np.zeros((1, 3)), AXIS, 1)), r"has shape \(1,\)"),
    "no number": (lambda: kin.Revolute("a", "b", cga.circle((0, 0, NAN), AXIS, 1)), "not finite"),
    "complex numbers": (lambda: kin.Revolute("a", "b", cga.wrap(CIRCLE.kind, CIRCLE.values * 1j)), "complex"),
    "what is too far": (lambda: kin.Spherical("a", "b", pga.point([1e200, 0, 0])), "beyond 1e\\+100"),
    "a zero circle": (lambda: kin.Revolute("a", "b", 0 * CIRCLE), "is zero"),
    "a point for an axis": (
        lambda: kin.Revolute("a", "b", cga.point([0, 0, 0])),
        "is a point; a circle or a point_pair",
    ),
    "a line alone in pga": (lambda: kin.Revolute("a", "b", pga.line((0, 0, 0), AXIS)), "a line and a point on it"),
    "a point of another algebra": (
        lambda: kin.Revolute("a", "b", pga.line((0, 0, 0), AXIS), cga.point((0, 0, 0))),
        "one algebra",
    ),
    "another point alone": (
        lambda: kin.Revolute("a", "b", CIRCLE, other_point=cga.point((0, 0, 0))),
        "without a point",
    ),
    "another kind": (lambda: kin.Spherical("a", "b", cga.point((0, 0, 0)), other=CIRCLE), "is a circle"),
    "a sphere for a plane": (lambda: kin.Planar("a", "b", cga.sphere((0, 0, 0), 1)), "is a sphere; a plane is needed"),
    "one body": (lambda: kin.Spherical("a", "a", cga.point((0, 0, 0))), "itself"),
    "a body without a name": (lambda: kin.Spherical("a", "", cga.point((0, 0, 0))), "the name of a joint"),
    "a body by number": (lambda: kin.Spherical(0, 1, cga.point((0, 0, 0))), "the name of a joint"),
    "a place of two": (lambda: kin.Rigid("a", "b", (1, 2)), r"shape \(2,\)"),
    "a place of letters": (lambda: kin.Rigid("a", "b", "xyz"), "real numbers"),
    "no algebra": (lambda: kin.Rigid("a", "b", (0, 0, 0), "cga"), "'cga'"),
    "geometry of elsewhere": (
        lambda: kin.Spherical("a", "b", bs.algebra(3, 0, 0).multivector({"e1": 1.0})),
        "cga3d or pga3d",
    ),
    "no product": (lambda: kin.Bilinear("a", "b", cga.point(P), CIRCLE, "outr"), "did you mean 'outer'"),
    "a number for a product": (lambda: kin.Bilinear("a", "b", cga.point(P), CIRCLE, 3), "3 is not a product"),
    "objects of two algebras": (lambda: kin.Bilinear("a", "b", cga.point(P), pga.point(P)), "one algebra"),
    "a word for H": (lambda: kin.Bilinear("a", "b", cga.point(P), CIRCLE, H="x"), "H is 'x'"),
    "H that is no number": (lambda: kin.Bilinear("a", "b", cga.point(P), CIRCLE, H=NAN), "H is nan"),
    "H of several": (lambda: kin.Bilinear("a", "b", cga.point(P), CIRCLE, H=[1, 2]), r"H has shape \(2,\)"),
    "H of another algebra": (lambda: kin.Bilinear("a", "b", cga.point(P), CIRCLE, H=pga.point(P)), "to pga3d"),
    "a function that is not linear": (
        lambda: kin.Bilinear("a", "b", cga.point(P), CIRCLE, lambda x, y: x * y * y),
        "not linear",
    ),
    "a function of one": (lambda: kin.Bilinear("a", "b", cga.point(P), CIRCLE, lambda x: x), "raises TypeError"),
    "a function without a result": (
        lambda: kin.Bilinear("a", "b", cga.point(P), CIRCLE, lambda x, y: None),
        "its product is None",
    ),
    "a function that is zero": (
        lambda: kin.Bilinear("a", "b", cga.point(P), CIRCLE, lambda x, y: 0 * (x ^ y)),
        "holds nothing",
    ),
}


@pytest.mark.parametrize("name", WRONG)
def test_what_is_no_joint_says_why(name):
    make, why = WRONG[name]
    with pytest.raises((InputError, ShapeError, GradeError, AlgebraMismatchError), match=why) as caught:
        make()
    assert "\n" not in str(caught.value)


DEGENERATE = {
    "a line as a circle": (lambda: kin.Revolute("a", "b", LINE), "mobility of 2, not of 1"),
    "a circle of no size": (lambda: kin.Revolute("a", "b", cga.circle((0, 0, 0), AXIS, 0)), "not finite|mobility"),
    "one point twice": (lambda: kin.Revolute("a", "b", cga.point_pair((0, 0, 0), (0, 0, 0))), "not finite|mobility"),
    "no blade": (lambda: kin.Revolute("a", "b", cga.wrap(CIRCLE.kind, np.arange(1.0, 11))), "mobility of 0, not of 1"),
    "a point off the axis": (
        lambda: kin.Revolute("a", "b", pga.line((0, 0, 0), AXIS), pga.point((1, 0, 0))),
        "mobility of 0, not of 1",
    ),
    "the point at infinity": (
        lambda: kin.Spherical("a", "b", cga.multivector({"ni": 1.0}).as_kind("point", check=False)),
        "mobility of 6",
    ),
    "a bilinear map that does not hold": (
        lambda: kin.Bilinear("a", "b", cga.plane(AXIS, 0), cga.point((0, 0, 1))),
        "apart",
    ),
    "two circles that are not one": (
        lambda: kin.Revolute("a", "b", CIRCLE, other=cga.circle((0.1, 0, 0), AXIS, 1)),
        "is 0.1 apart",
    ),
}


@pytest.mark.parametrize("name", DEGENERATE)
def test_geometry_that_is_no_joint_says_so_when_it_is_used(name):
    make, why = DEGENERATE[name]
    with pytest.raises((InputError, ConstraintError), match=why) as caught:
        kin.Mechanism(["a", "b"], "a", make()).mobility()
    assert isinstance(caught.value, BladesmithError)


@pytest.mark.parametrize("distance", [3.0, 3e-3, 3e3])
def test_a_condition_may_have_a_number_for_its_value(distance: float) -> None:
    ends = cga.point((1, 0, 0)), cga.point((1 + distance, 0, 0))  # a rod: X . Y = -d^2 / 2
    for value in (-(distance**2) / 2, cga.multivector({"": -(distance**2) / 2}), None):
        rod = kin.Bilinear("a", "b", *ends, product="inner", H=value)
        assert kin.Mechanism(["a", "b"], "a", [rod]).mobility() == 5
    wrong = kin.Mechanism(["a", "b"], "a", [kin.Bilinear("a", "b", *ends, "inner", H=distance**2)])
    with pytest.raises(ConstraintError, match="apart"):
        wrong.mobility()
