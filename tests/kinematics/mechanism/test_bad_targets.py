"""What users may get wrong when they ask for poses; poses that are not found."""

import copy
import pickle

import numpy as np
import pytest

from bladesmith import Status, cga2d
from bladesmith import cga3d as cga
from bladesmith import kinematics as kin
from bladesmith.codegen.errors import BladesmithError, InputError, KindError, ShapeError

from ...support.kinematics import AXIS, hinge, twist
from ...support.mechanisms.poses import NAN, bar, held_by

pytestmark = pytest.mark.filterwarnings("error")

ASKED = {
    "a list to drive": (lambda m: m.solve_pose(["a"]), InputError, "a mapping"),
    "a word to drive": (lambda m: m.solve_pose("a"), InputError, "a mapping"),
    "an unknown joint": (lambda m: m.solve_pose({"x": 1}), InputError, "not a joint"),
    "a body to drive": (lambda m: m.solve_pose({"crank": 1}), InputError, "not a joint"),
    "a joint twice": (lambda m: m.solve_pose({"a": 1, m.joints[0]: 1}), InputError, "driven twice"),
    "a word for an angle": (lambda m: m.solve_pose({"a": "x"}), InputError, "real numbers"),
    "None for an angle": (lambda m: m.solve_pose({"a": None}), InputError, "real numbers"),
    "a complex angle": (lambda m: m.solve_pose({"a": 1j}), InputError, "real numbers"),
    "ragged angles": (lambda m: m.solve_pose({"a": [[1], [2, 3]]}), InputError, "ragged"),
    "a loop joint": (lambda m: m.solve_pose({m.joints[m.tree.loop_joints[0]]: 1}), InputError, "closes a loop"),
    "a list of targets": (lambda m: m.solve_pose(targets=["crank"]), InputError, "a mapping"),
    "the fixed body": (lambda m: m.solve_pose(targets={"ground": cga.translator((0, 0, 0))}), InputError, "is fixed"),
    "an unknown body": (
        lambda m: m.solve_pose(targets={"crnk": cga.translator((0, 0, 0))}),
        InputError,
        "did you mean",
    ),
    "a word for a motor": (lambda m: m.solve_pose(targets={"crank": "x"}), InputError, "a motor, or an array"),
    "a motor of no unit": (
        lambda m: m.solve_pose(targets={"crank": 2 * cga.translator((0, 0, 0))}),
        KindError,
        "motor",
    ),
    "a motor of the plane": (
        lambda m: m.solve_pose(targets={"crank": cga2d.translator((0, 0))}),
        BladesmithError,
        "cga2d",
    ),
    "a point of two": (lambda m: m.solve_pose(targets={"crank": ([0, 1], [0, 0, 1])}), ShapeError, "3. is needed"),
    "points": (
        lambda m: m.solve_pose(targets={"crank": (np.zeros((2, 3)), [0, 0, 1])}),
        InputError,
        r"\(3,\) is needed",
    ),
    "a place of two": (lambda m: m.solve_pose(targets={"crank": ([0, 1, 0], [0, 0])}), ShapeError, "3. is needed"),
    "a line for a place": (
        lambda m: m.solve_pose(targets={"crank": ([0, 1, 0], cga.line((0, 0, 0), AXIS))}),
        InputError,
        "is a line",
    ),
    "a word to start from": (lambda m: m.solve_pose({"a": 1}, start="x"), InputError, "a mapping"),
    "a start of another": (
        lambda m: m.solve_pose({"a": 1}, start=held_by("spherical").solve_pose({"j": [0, 0, 1]})),
        InputError,
        "of another mechanism",
    ),
    "batches that do not fit": (
        lambda m: m.solve_pose({"a": [1, 2]}, start={"crank": cga.translator(np.zeros((3, 3)))}),
        ShapeError,
        r"\(3,\).*\(2,\)",
    ),
    "a path of one": (lambda m: m.solve_pose({"a": 1}, path=True), ShapeError, "an axis of steps"),
    "threads by name": (lambda m: m.solve_pose({"a": 1}, threads="x"), InputError, "threads"),
    "no threads": (lambda m: m.solve_pose({"a": 1}, threads=0), InputError, "threads"),
    "coordinates of nothing": (lambda m: m.solve_pose({"a": 0.1}).coordinates("x"), InputError, "not a joint"),
    "a pose of nobody": (lambda m: m.solve_pose({"a": 0.1})["x"], InputError, "no body"),
    "many poses at once": (lambda m: m.at(m.solve_pose({"a": [0.1, 0.2]})), InputError, "one item"),
    "Jacobians at a word": (lambda m: m.jacobian("a", "crank", poses="x"), InputError, "a mapping"),
    "Jacobians without inputs": (lambda m: m.jacobian([], "crank", poses={}), InputError, "no inputs"),
    "Jacobians without outputs": (lambda m: m.jacobian("a", [], poses={}), InputError, "no outputs"),
    "the fixed body moves": (lambda m: m.jacobian("ground", "crank", poses={}), InputError, "is fixed"),
    "the fixed body is asked": (lambda m: m.jacobian("a", "ground", poses={}), InputError, "is fixed"),
    "an input twice": (lambda m: m.jacobian(["a", "a"], "crank", poses={}), InputError, "twice"),
    "three of a pair": (lambda m: m.jacobian(("crank", 1, 2), "crank", poses={}), InputError, "as a list"),
    "twists that are none": (
        lambda m: m.jacobian(("crank", NAN * twist(cga, np.ones(6))), "rocker", poses={}),
        InputError,
        "not finite",
    ),
    "an unknown method": (lambda m: m.jacobian("a", "crank", poses={}, method="magic"), InputError, "magic"),
    "a loop joint at many poses": (
        lambda m: m.jacobian(m.joints[m.tree.loop_joints[0]], "a", poses={}),
        InputError,
        r"cannot be an input at many poses.*use the body '\w+', or loop over mechanism\.at",
    ),
    "freedoms that vary at many poses": (
        lambda _: held_by("universal").jacobian("x", "j", poses={}),
        InputError,
        "change with the pose, and cannot be an output at many poses",
    ),
    "freedoms that vary": (
        lambda _: held_by("universal").solve_pose({"j": [0, 0]}),
        InputError,
        "change with the pose",
    ),
}


@pytest.mark.parametrize("name", ASKED)
def test_what_is_asked_wrongly_is_answered(name):
    call, error, why = ASKED[name]
    with pytest.raises(error, match=why) as caught:
        call(bar())
    assert isinstance(caught.value, BladesmithError) and "\n" not in str(caught.value)


@pytest.mark.filterwarnings("error")
def test_poses_that_are_not_found_are_no_numbers() -> None:
    up, bars = (0, 0, 1), kin.Mechanism(["frame", "left", "coupler", "right"], "frame")  # Watt's linkage
    ends = [("frame", "left", (0, 0, 0)), ("left", "coupler", (2, 0, 0)), ("coupler", "right", (2, 1, 0))]
    for a, b, at in [*ends, ("frame", "right", (4, 1, 0))]:
        bars.add(hinge(a, b, at, up))
    found = bars.solve_pose({bars.joints[0]: [0.0, 0.3, 3.0, 0.2]})
    assert found.status.tolist() == [Status.OK, Status.OK, Status.UNREACHABLE, Status.OK]
    none = np.isnan(found["coupler"].values)
    assert none[2].all() and not none[[0, 1, 3]].any() and np.isnan(found.coordinates(bars.joints[3])[2]).all()
    rates, status = bars.jacobian(bars.joints[0], "coupler", poses=found, status=True)
    assert np.isnan(rates[2]).all() and status[2] == Status.UNREACHABLE and not status[[0, 1, 3]].any()
    with pytest.raises(BladesmithError, match="item 2 is UNREACHABLE.*strict=False"):
        bars.jacobian(bars.joints[0], "coupler", poses=found)
    assert np.isnan(bars.jacobian(bars.joints[0], "coupler", poses=found, strict=False)[2]).all()
    for other in (pickle.loads(pickle.dumps(found)), copy.deepcopy(found)):
        assert np.array_equal(other["left"].values, found["left"].values, equal_nan=True)
        again = other.mechanism.at({name: other[name][1] for name in other.mechanism.moving})
        assert again.mobility() == 1 and again.residual() < 1e-10
        assert pickle.loads(pickle.dumps(again)).mobility() == 1
