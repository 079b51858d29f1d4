"""What is no joint: each says why."""

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

from ..support.kinematics import AXIS
from ..support.mechanisms.joints import P, U

pytestmark = pytest.mark.filterwarnings("error")

NAN = float("nan")

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
    "no second object": (lambda: kin.Prismatic("a", "b", LINE, None), "has one object; it is of two"),
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
    "nothing": (lambda: kin.Revolute("a", "b", None), "has no point. Give point= and axis="),
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
