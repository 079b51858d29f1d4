"""What users may get wrong about mechanisms: each answer says what, where and the remedy."""

import itertools

import numpy as np
import pytest

from bladesmith import cga3d as cga
from bladesmith import kinematics as kin
from bladesmith import pga3d as pga
from bladesmith.codegen.errors import (
    AlgebraMismatchError,
    BladesmithError,
    ConstraintError,
    InputError,
    KindError,
    ShapeError,
    UndeterminedError,
)

from ...support.kinematics import (
    AXIS,
    four_bar,
    hinge,
    slide,
    turn,
    twist,
)
from ...support.mechanisms.poses import BAR, NAN

pytestmark = pytest.mark.filterwarnings("error")

POINT = cga.point((1, 2, 3))
TWIST = twist(cga, turn(AXIS, [0, 0, 0]))


def some():
    return four_bar(BAR.places(0.8))


ASKED = {
    "no bodies": (lambda: kin.Mechanism([], "g"), InputError, "not in bodies"),
    "None": (lambda: kin.Mechanism(None, "g"), InputError, "not in bodies"),
    "a number": (lambda: kin.Mechanism(3, "g"), InputError, "a list of them"),
    "a mapping": (lambda: kin.Mechanism({"a": 1}, "a"), InputError, "a list of them"),
    "a body twice": (lambda: kin.Mechanism(["a", "b", "a"], "a"), InputError, "two bodies 'a'"),
    "a body of no name": (lambda: kin.Mechanism(["a", ""], "a"), InputError, "a word"),
    "a list to fix": (lambda: kin.Mechanism(["a", "b"], ["a"]), InputError, "not in bodies"),
    "a near miss": (lambda: kin.Mechanism(["ground", "b"], "grund"), InputError, "did you mean 'ground'"),
    "a word for a tolerance": (lambda: kin.Mechanism(["a"], "a", tolerance="x"), InputError, "tolerance"),
    "a tolerance above one": (
        lambda: kin.Mechanism(["a"], "a", tolerance=2),
        InputError,
        "greater than 0 and less than 1",
    ),
    "a word for joints": (lambda: kin.Mechanism(["a", "b"], "a", "ab"), InputError, "joints are 'ab'"),
    "a class for a joint": (lambda: kin.Mechanism(["a", "b"], "a", [kin.Revolute]), InputError, "the class Revolute"),
    "no joint at all": (lambda: kin.Mechanism(["a", "b"], "a", [kin.Joint()]), InputError, "as Revolute"),
    "a joint twice": (lambda: (lambda m: m.add(m.joints[0]))(some()), InputError, "already"),
    "a name twice": (
        lambda: some().add(kin.Spherical("crank", "rocker", POINT), "a"),
        InputError,
        "the name 'a' is taken",
    ),
    "a name of a body": (
        lambda: some().add(kin.Spherical("crank", "rocker", POINT), "crank"),
        InputError,
        "is taken",
    ),
    "a name of letters": (
        lambda: some().add(kin.Spherical("crank", "rocker", POINT), ["x"]),
        InputError,
        "a word is needed",
    ),
    "an empty name": (lambda: some().add(kin.Spherical("crank", "rocker", POINT), ""), InputError, "a word is needed"),
    "an unknown body": (
        lambda: some().add(kin.Spherical("crank", "roker", POINT)),
        InputError,
        "did you mean 'rocker'",
    ),
    "two algebras": (
        lambda: some().add(kin.Spherical("crank", "rocker", pga.point((0, 0, 0)))),
        InputError,
        "of pga3d",
    ),
    "no joints": (lambda: kin.Mechanism(["a", "b"], "a").mobility(), InputError, "no joints"),
    "the fixed body alone": (lambda: kin.Mechanism(["a"], "a").constraint_matrix(), InputError, "no joints"),
    "loose bodies": (
        lambda: kin.Mechanism(["a", "b", "c"], "a", [kin.Spherical("b", "c", POINT)]).mobility(),
        InputError,
        "no joints hold b, c",
    ),
    "twists of nobody": (lambda: some().allowed_twists("x"), InputError, "no body 'x'"),
    "no outputs": (lambda: some().jacobian("a", []), InputError, "no outputs"),
    "no inputs": (lambda: some().jacobian([], "crank"), UndeterminedError, "inputs are missing"),
    "unknown inputs": (lambda: some().jacobian("x", "crank"), InputError, "no body 'x'"),
    "a set": (lambda: some().jacobian({"a", "b"}, "crank"), InputError, "no order"),
    "a tuple of names": (lambda: some().jacobian("a", ("crank", "rocker")), InputError, "as a list"),
    "a pair of three": (lambda: some().jacobian("a", ("crank", (0, 0, 0), 1)), InputError, "as a list"),
    "a flat point": (lambda: some().jacobian("a", ("crank", (0, 0))), ShapeError, "3. is needed"),
    "a point that is none": (lambda: some().jacobian("a", ("crank", (0, 0, NAN))), InputError, "finite"),
    "a line for a point": (lambda: some().jacobian("a", ("crank", cga.line((0, 0, 0), AXIS))), InputError, "is a line"),
    "points": (lambda: some().jacobian("a", ("crank", np.zeros((2, 3)))), InputError, r"\(3,\) is needed"),
    "the fixed body as input": (lambda: some().jacobian("ground", "crank"), InputError, "is fixed"),
    "an input twice": (lambda: some().jacobian(["a", "a"], "crank"), InputError, "twice"),
    "a twist of another algebra": (
        lambda: some().jacobian(("crank", twist(pga, np.ones(6))), "rocker"),
        AlgebraMismatchError,
        "pga3d",
    ),
    "a point for a twist": (lambda: some().jacobian(("crank", POINT), "rocker"), KindError, "twist"),
    "a twist that is none": (lambda: some().jacobian(("crank", NAN * TWIST), "rocker"), InputError, "not finite"),
    "all twists of a crank": (lambda: some().jacobian("crank", "rocker"), ConstraintError, "violates the joint"),
    "a joint of another": (lambda: some().jacobian(some().joints[0], "crank"), InputError, "not a joint of this"),
    "a status of one": (lambda: some().jacobian("a", "crank", status=True), InputError, "goes with poses"),
    "an unknown method": (lambda: some().jacobian("a", "crank", method="magic"), InputError, "no method 'magic'"),
    "nothing known": (lambda: some().solve({}), InputError, "a mapping"),
    "a list known": (lambda: some().solve(["a"]), InputError, "a mapping"),
    "no speed": (lambda: some().solve({"a": None}), InputError, "None"),
    "no twist": (lambda: some().solve({"crank": None}), InputError, "None"),
    "a number for a twist": (lambda: some().solve({"crank": 1.0}), InputError, "a multivector"),
    "many twists": (lambda: some().solve({"crank": twist(cga, np.ones((3, 6)))}), InputError, "one speed or twist"),
    "two speeds": (lambda: some().solve({"a": [1, 2]}), InputError, "1 numbers"),
    "a complex speed": (lambda: some().solve({"a": 1j}), InputError, "real"),
    "a speed that is none": (lambda: some().solve({"a": NAN}), InputError, "finite"),
    "the fixed body known": (lambda: some().solve({"ground": TWIST}), InputError, "is fixed"),
    "a number known": (lambda: some().solve({1: TWIST}), InputError, "no body 1"),
    "no pose": (lambda: some().at(None), InputError, "a mapping"),
    "a list for a motor": (lambda: some().at({"crank": [1, 2]}), ShapeError, "4, 4"),
    "a batch of poses": (lambda: some().at({"crank": cga.translator(np.zeros((2, 3)))}), InputError, "one item"),
    "a pose that is none": (lambda: some().at({"crank": NAN * cga.translator((0, 0, 0))}), InputError, "not finite"),
    "a pose of zero": (lambda: some().at({"crank": 0 * cga.translator((0, 0, 0))}), KindError, "motor"),
    "a point for a pose": (lambda: some().at({"crank": POINT}), KindError, "motor"),
}


@pytest.mark.parametrize("name", ASKED)
def test_what_is_asked_wrongly_is_answered(name):
    call, error, why = ASKED[name]
    with pytest.raises(error, match=why) as caught:
        call()
    assert isinstance(caught.value, BladesmithError) and "\n" not in str(caught.value)


def test_bodies_that_are_one():
    m = kin.Mechanism(["g", "x", "y"], "g", [kin.Rigid("g", "x"), kin.Rigid("x", "y")])
    assert m.mobility() == 0 and m.free_motions() == [] == m.self_stresses() and m.rank() == 12
    assert m.allowed_twists("y").shape == (0,) and m.jacobian([], "y").shape == (6, 0)
    found = m.analysis(("y", twist(cga, slide(np.eye(3)))), "x")
    np.testing.assert_allclose(found.residual, 1)  # nothing of it is allowed
    with pytest.raises(ConstraintError, match="violate the joint constraints"):
        m.solve({"x": TWIST})


def test_what_is_unusual_and_right():
    m = some()
    assert kin.Mechanism("alone", "alone").residual() == 0.0
    assert m.jacobian((x for x in ["a"]), np.array(["crank", "rocker"])).shape == (12, 1)
    assert m.jacobian({"crank": TWIST}, "rocker").shape == (6, 1)
    assert m.jacobian("a", "ground").tolist() == [[0]] * 6
    assert m.allowed_twists("ground").shape == (0,)
    for order in itertools.permutations(range(4), 4):
        again = kin.Mechanism(m.bodies[::-1], "ground", [m.joints[i] for i in order])
        np.testing.assert_allclose(again.jacobian(m.joints[0], m.joints[3]), m.jacobian("a", "d"), rtol=1e-10)
    double = some()
    double.add(kin.Revolute("ground", "crank", cga.circle((0, 0, 1), AXIS, 2)), "again")  # one hinge by two pins
    assert double.mobility() == 1 and len(double.self_stresses()) == 8


def test_joints_without_a_name_are_found_by_what_joint_names_says() -> None:
    mechanism = kin.Mechanism(bodies=["base", "arm"], fixed="base")
    joint = mechanism.add(hinge("base", "arm", (1, 0, 0), (0, 0, 1)))
    (name,) = mechanism.joint_names
    assert np.array_equal(mechanism.jacobian(name, "arm"), mechanism.jacobian(joint, "arm"))
    assert np.array_equal(mechanism.solve({name: 2.0})["arm"].values, 2.0 * mechanism.allowed_twists("arm").values[0])
    mechanism.add(hinge("base", "arm", (1, 0, 1), (0, 0, 1)))
    with pytest.raises(InputError, match="2 joints are"):
        mechanism.jacobian(name, "arm")
