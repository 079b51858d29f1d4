"""What users may get wrong in bodies, loads and constraints: each error says what, where and the remedy.

Simulations here are few, and share their compiled programs.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from bladesmith import cga2d, cga3d, dynamics, pga3d
from bladesmith.errors import (
    AlgebraMismatchError,
    ConstraintError,
    GradeError,
    InputError,
    SimulationError,
)

from ...support.dynamics.input import GRAVITY, PLANE, SHORT, TIP, WRENCH, ball, failing, refused, simulation

# -- what is accepted ------------------------------------------------------------------------------------------


@pytest.mark.compiles
def test_one_is_as_good_as_a_list_of_one() -> None:
    def half(time: float, motor: Any, twist: Any) -> float:
        return time - SHORT / 2

    event = dynamics.Event(half)
    pinned = simulation(GRAVITY, dynamics.Pin(TIP))
    assert pinned.loads == (GRAVITY,) and len(pinned.constraints) == 1
    assert simulation(None, None).loads == ()
    free = simulation(GRAVITY)
    ends = [free.run(SHORT, events=given).time[-1] for given in ([event], event, [half], half)]
    assert ends == [ends[0]] * 4 and abs(ends[0] - SHORT / 2) < 1e-12
    assert free.run(SHORT, events=None).ending == "ok"
    named = free.run(SHORT, sensitivities="mass")
    assert set(named.sensitivities) == {"mass"} and free.run(SHORT, sensitivities=None).ending == "ok"
    assert set(free.run(SHORT, sensitivities=["mass", "mass"]).sensitivities) == {"mass"}
    assert list(dynamics.System(ball()).bodies) == ["body_1"]
    assert simulation(dynamics.BodyWrench(0 * WRENCH)).run(SHORT).ending == "ok"  # a load that may be zero


def test_bodies_and_loads_keep_their_numbers() -> None:
    arrays = {"mass": np.ones(2), "inertia": np.tile([1.0, 2, 2.5], (2, 1)), "position": np.zeros((2, 3)),
              "velocity": np.ones((2, 3)), "angular_velocity": np.ones((2, 3))}  # fmt: skip
    body = dynamics.RigidBody(**arrays)
    point = np.array([1.0, 0, 0])
    spring, gravity = dynamics.Spring(point, point, 1.0), dynamics.Gravity(point)
    wrenches = [WRENCH]
    power = dynamics.VirtualPower(wrenches)
    for array in (*arrays.values(), point):
        array[:] = 7.0
    wrenches.clear()
    assert (body.mass == 1).all() and (body.moments == [1, 2, 2.5]).all() and (body.position == 0).all()
    assert (body.velocity == 1).all() and (body.angular_velocity == 1).all()
    assert spring.point[0] == spring.anchor[0] == gravity.acceleration[0] == 1 and len(power.wrenches) == 1
    for kept in (body.mass, body.moments, body.axes, body.position, body.velocity, spring.stiffness, spring.point):
        with pytest.raises(ValueError, match="read-only"):
            kept[...] = 2.0


# -- bodies ----------------------------------------------------------------------------------------------------

BODIES: list[tuple[dict[str, Any], str]] = [
    ({"mass": "heavy"}, "the mass is 'heavy'; real numbers are needed"),
    ({"mass": 1e-320}, "the mass is 1e-320; a positive number is needed"),
    ({"mass": [1.0, -2.0]}, "the mass[1] is -2.0; a positive number is needed"),
    ({"inertia": [1.0, 2.0]}, "the inertia has shape (2,)"),
    ({"position": [0.0, np.nan, 0.0]}, "position[1] is nan; a finite number is needed"),
    ({"velocity": [1.0, 2.0]}, "velocity has shape (2,); (..., 3) is needed"),
    ({"velocity": np.zeros((2, 2, 3))}, "bodies have shape (2, 2); one, or a batch (n,), is meant"),
    ({"velocity": np.zeros((3, 3)), "position": np.zeros((2, 3))}, "pose (2,), velocity (3,)"),
    ({"angular_velocity": None}, "angular_velocity is None; real numbers are needed"),
    ({"orientation": 2 * np.eye(3)}, "the orientation is not a rotation: its transpose times itself differs from 1"),
    ({"orientation": np.stack([np.eye(3), -np.eye(3)])}, "the orientation[1] is not a rotation: its determinant"),
    ({"orientation": np.zeros((3, 3))}, "differs from 1 by 1. Give a rotation matrix, or a motor"),
    (
        {"orientation": np.tile(np.eye(3), (2, 1, 1)), "position": np.zeros((3, 3))},
        "orientations (2,), positions",
    ),
    ({"orientation": TIP}, "the orientation is not a motor"),
    ({"orientation": 2 * cga3d.rotor([0, 0, 1], 0.3)}, "the orientation is not a motor"),
    (
        {"orientation": pga3d.rotor([0, 0, 1], 0.3)},
        "the orientation belongs to pga3d, the body to cga3d. Convert the rotor: "
        "cga.motor_from_matrix(poses.to_matrix(x))",
    ),
    (
        {"inertia": dynamics.rod(1.0, 0.1)},
        "the inertia is a Shape; moments or a tensor is needed. That of a shape is shape.inertia(mass)",
    ),
    ({"algebra": "pga"}, "algebra is 'pga'; bladesmith.cga3d or pga3d is needed"),
    ({"algebra": cga2d}, "cga2d has no screws of space"),
]


@pytest.mark.parametrize(("options", "says"), BODIES, ids=[says[:40] for _, says in BODIES])
def test_bodies(options: dict[str, Any], says: str) -> None:
    refused(lambda: dynamics.RigidBody(**{"mass": 1.0, "inertia": [1.0, 2.0, 2.5], **options}), says)


SYSTEMS = [
    (lambda: dynamics.System(3), "the bodies are 3; a list of them is needed"),
    (lambda: dynamics.System({3: ball()}), "a body's name is 3; a word is needed"),
    (lambda: dynamics.System([None]), "body_1 is None; a dynamics.RigidBody is needed"),
    (lambda: dynamics.System([ball()], 3), "the joints are 3"),
    (lambda: dynamics.System([ball()], [None]), "a joint is None"),
    (lambda: dynamics.System([ball()], fixed=[]), "fixed is []; a word is needed"),
    (lambda: dynamics.Simulation(ball), "the body is a function; a RigidBody or a System is needed"),
]


@pytest.mark.parametrize(("make", "says"), SYSTEMS, ids=[says[:40] for _, says in SYSTEMS])
def test_systems(make: Any, says: str) -> None:
    refused(make, says, InputError)


# -- loads -----------------------------------------------------------------------------------------------------

LOADS = [
    (lambda: dynamics.BodyWrench(WRENCH, body=None), "the body of the body wrench is None; the name or the number"),
    (lambda: dynamics.Damper(1.0, 1.0, body=None), "the damper's body is None"),
    (lambda: dynamics.Damper(1.0, 1.0, body=True), "the damper's body is True"),
    (lambda: dynamics.Spring(0, 0, 1.0, body=None), "the spring's body is None"),
    (lambda: dynamics.Spring(0, 0, 1.0, other=0.5), "the spring's other body is 0.5; the name or the number of a body"),
    (lambda: dynamics.Spring(0, 0, 1.0, other=0), "loads[0] (Spring) is between one body and itself: it moves"),
    (lambda: dynamics.Spring(0, 0, 1.0, other="body"), "Name another body with other=, or leave it out for the world"),
    (lambda: dynamics.Spring(0, [0, 0], 1.0), "the spring's anchor has shape (2,)"),
    (lambda: dynamics.QuadraticDrag(linear=-1.0), "the linear drag is -1.0; a number of at least 0 is needed"),
    (lambda: dynamics.QuadraticDrag(1.0, body=None), "the quadratic drag's body is None"),
    (lambda: dynamics.Damper(-1.0), "the angular damping is -1.0; a number of at least 0 is needed"),
    (lambda: dynamics.Damper(1.0, body=7), "loads[0] (Damper): there is no body 7; there are 1, from 0"),
    (lambda: dynamics.Damper(1.0, body="boddy"), "there is no body 'boddy'; there are: body. (did you mean 'body'?)"),
    (lambda: 3, "loads[0] is 3; a Gravity, BodyWrench, WorldWrench, Spring, Damper or QuadraticDrag is nee"),
    (lambda: dynamics.Gravity(9.81), "acceleration is 9.81; (..., 3) is needed. Give a vector, e.g. (0.0, 0.0, -9.81)"),
    (lambda: dynamics.Gravity, "loads[0] is the class Gravity; a Gravity"),
    (lambda: dynamics.Pin(TIP), "loads[0] is a Pin; a Gravity"),
    (
        lambda: dynamics.BodyWrench(np.zeros(6)),
        "the body wrench is array([0., 0...., 0., 0., 0.]); a multivector or a function of time",
    ),
    (lambda: dynamics.WorldWrench(np.nan * WRENCH), "the world wrench is not finite: its coefficient of e12 is nan"),
    (lambda: dynamics.WorldWrench(lambda t, motor: WRENCH), "the world wrench takes (t, motor); a function of time"),
]


@pytest.mark.parametrize(("make", "says"), LOADS, ids=[says[:40] for _, says in LOADS])
def test_loads(make: Any, says: str) -> None:
    refused(lambda: simulation([make()]), says)


@pytest.mark.parametrize("word", ["gravity", 3, {"a": GRAVITY}, dynamics.Gravity])
def test_what_is_no_list(word: Any) -> None:
    refused(lambda: simulation(word), "the loads are ", InputError)
    refused(lambda: simulation([], word), "the constraints are ", InputError)


# -- constraints -----------------------------------------------------------------------------------------------

CONSTRAINTS = [
    (lambda: dynamics.Pin(np.zeros(5)), "the body's object is array([0., 0., 0., 0., 0.]); a multivector is needed"),
    (lambda: dynamics.Pin((0, 0, 0.4)), "a multivector is needed. Make it a point: cga.point((0, 0, 0.4))"),  # type: ignore[arg-type]
    (
        lambda: TIP,
        "constraints[0] is a Multivector; a Pin, PinPath, PinLinear, Incidence or VirtualPower is needed. "
        "An object that stays is dynamics.Pin(point)",
    ),
    (lambda: dynamics.Pin(cga3d.scalar(2.0)), "the body's object is a scalar that no motion moves: it pins nothing"),
    (lambda: dynamics.Pin(cga3d.ni), "that no motion moves"),
    (lambda: dynamics.Pin(pga3d.scalar(2.0)), "that no motion moves"),
    (lambda: dynamics.Pin(TIP, PLANE), "the body's object is a point, the world's a plane: no motion makes them one"),
    (lambda: dynamics.Pin(TIP, pga3d.point([0.0, 0, 0.5])), "belongs to cga3d, the world's to pga3d"),
    (lambda: dynamics.Pin(TIP, body=None), "the body of Pin is None"),
    (lambda: dynamics.PinPath(TIP, lambda t, motor, twist: TIP), "the world's object takes (t, motor, twist)"),
    (lambda: dynamics.PinPath(lambda: TIP, TIP), "the body's object takes ()"),
    (lambda: dynamics.PinPath(TIP, cga3d.scalar(1.0)), "that no motion moves"),
    (lambda: dynamics.PinLinear(PLANE, PLANE), "the linear function is a Multivector; a function is needed"),
    (lambda: dynamics.PinLinear(lambda: PLANE, PLANE), "the linear function takes (); a function of one multivector"),
    (lambda: dynamics.PinLinear(abs, PLANE, np.zeros(3)), "the target has shape (3,); a multivector or one"),
    (lambda: dynamics.PinLinear(abs, PLANE, None), "the target is None"),
    (lambda: dynamics.PinLinear(abs, PLANE, np.nan), "the target is nan; a finite number is needed"),
    (lambda: dynamics.PinLinear(abs, PLANE, lambda t, u: 0), "the target takes (t, u); a value or a function of time"),
    (lambda: dynamics.Incidence(PLANE, PLANE), "the body's point is a plane; a point is needed"),
    (lambda: dynamics.Incidence(TIP, cga3d.scalar(1.0)), "that no motion moves"),
    (lambda: dynamics.VirtualPower(None), "the wrench is None; a multivector is needed"),
    (lambda: dynamics.VirtualPower([WRENCH, None]), "wrench 1 is None"),
    (lambda: dynamics.VirtualPower(()), "VirtualPower has no wrenches"),
    (lambda: dynamics.VirtualPower(WRENCH.reshape(1, 1)), "the wrenches have shape (1, 1)"),
    (lambda: dynamics.VirtualPower(lambda t, motor: WRENCH), "the function of the wrenches takes (t, motor)"),
    (lambda: dynamics.Pin(TIP, other=0), "constraints[0] (Pin) is between a body and itself"),
    (lambda: dynamics.Pin(TIP, other="arm"), "constraints[0] (Pin): there is no body 'arm'; there are: body"),
    (lambda: GRAVITY, "constraints[0] is a Gravity; a Pin, PinPath"),
]


def test_an_object_alone_is_no_constraint() -> None:
    refused(lambda: simulation([], TIP), "constraints[0] is a Multivector; a Pin", InputError)


@pytest.mark.parametrize(("make", "says"), CONSTRAINTS, ids=[says[:40] for _, says in CONSTRAINTS])
def test_constraints(make: Any, says: str) -> None:
    refused(lambda: simulation([], [make()]), says)


#: What is known when functions of users are asked for the first time.
ASKED = [
    (dynamics.PinPath(TIP, failing), "the world's object failed at time 0: ZeroDivisionError: oh"),
    (dynamics.PinPath(TIP, lambda t: None), "the world's object is None where its function should give a multivector"),
    (dynamics.PinPath(TIP, lambda t: (TIP, TIP)), "gives a tuple of 2; a value alone, or a tuple of 3"),
    (dynamics.PinPath(TIP, lambda t: ()), "gives a tuple of 0"),
    (dynamics.PinPath(TIP, lambda t: np.nan * TIP), "the world's object is not finite: its coefficient of e1 is nan"),
    (dynamics.PinPath(TIP, dict), "the world's object failed at time 0: TypeError"),
    (dynamics.PinLinear(lambda x: 0 * x, PLANE), "the function of PinLinear is zero for every plane: it holds nothing"),
    (dynamics.PinLinear(lambda x: PLANE ^ x, PLANE), "is zero for every plane"),
    (dynamics.PinLinear(lambda x: x * x * x, PLANE), "the function of PinLinear is not linear"),
    (dynamics.PinLinear(lambda x: x + PLANE, PLANE), "is not linear"),
    (dynamics.PinLinear(lambda x: 0.0, PLANE), "is 0.0; a multivector is needed"),
    (dynamics.PinLinear(lambda x: np.nan * x, PLANE), "the function of PinLinear is not finite"),
    (dynamics.PinLinear(lambda x: cga3d.point(np.eye(3)) ^ x, PLANE), "has shape (3,); one item is needed"),
    (dynamics.PinLinear(lambda x: pga3d.scalar(1.0), PLANE), "belongs to pga3d"),
    (dynamics.PinLinear(failing, PLANE), "the function of PinLinear failed: ZeroDivisionError: oh"),
    (dynamics.PinLinear(lambda x: TIP ^ x, PLANE, failing), "the target failed at time 0: ZeroDivisionError: oh"),
    (dynamics.PinLinear(lambda x: TIP ^ x, PLANE, lambda t: np.ones(3)), "the target has shape (3,)"),
    (dynamics.PinLinear(lambda x: TIP ^ x, PLANE, lambda t: (0, 0)), "gives a tuple of 2"),
    (
        dynamics.Incidence(TIP, lambda t: np.zeros(5)),
        "the world's object is array([0., 0., 0., 0., 0.]) where its function should give",
    ),
    (dynamics.VirtualPower(failing), "the wrenches failed at time 0: ZeroDivisionError: oh"),
    (
        dynamics.VirtualPower(lambda t: [WRENCH]),
        "the wrenches are [twist of cga3...e12 - 0.1 e2ni] where their function should give",
    ),
    (dynamics.VirtualPower(lambda t: (WRENCH,)), "gives a tuple of 1; a value alone, or a tuple of 2"),
]


@pytest.mark.parametrize(("constraint", "says"), ASKED, ids=[says[:40] for _, says in ASKED])
def test_functions_of_constraints(constraint: Any, says: str) -> None:
    error = refused(lambda: simulation([], constraint).run(SHORT, project=True), says)
    assert error.where == f"constraint 0 ({type(constraint).__name__})"
    refused(lambda: dynamics.allowed_twists(constraint, ball()), says)


@pytest.mark.compiles
def test_functions_of_loads_and_paths_that_fail_later() -> None:
    def wrench(time: float) -> Any:
        return None if time > SHORT / 2 else WRENCH

    free = simulation(dynamics.BodyWrench(wrench))
    error = refused(lambda: free.run(SHORT, strict=True), "the body wrench failed at time 0.00", SimulationError)
    assert "the body wrench is None; a multivector of cga3d is needed" in error.what and "Error:" not in error.what
    assert len(error.trajectory) >= 1  # type: ignore[attr-defined]


@pytest.mark.compiles
def test_allowed_twists() -> None:
    depends = dynamics.VirtualPower(lambda t, motor, twist: (WRENCH, 0 * WRENCH))
    says = "VirtualPower depends on the state, and no body is given. Give one, as in body=RigidBody"
    refused(lambda: dynamics.allowed_twists(depends), says, InputError)
    for known in ((depends, ball()), ([depends, dynamics.VirtualPower(WRENCH)],)):
        assert dynamics.allowed_twists(*known).shape == (5,)
    refused(lambda: dynamics.allowed_twists(None), "the constraint is None")
    refused(lambda: dynamics.allowed_twists([None]), "constraints[0] is None; a Pin")
    refused(lambda: dynamics.allowed_twists(dynamics.Pin), "the constraints are the class Pin")
    refused(lambda: dynamics.allowed_twists(dynamics.Pin(TIP), 3), "the body is 3; a RigidBody is needed")
    two = dynamics.RigidBody([1.0, 2.0], [1.0, 1.0, 1.0])
    refused(lambda: dynamics.allowed_twists(dynamics.Pin(TIP), two), "there are 2 bodies; the twists of one")


@pytest.mark.compiles
def test_starts_off_their_constraints_say_how_far() -> None:
    lower = cga3d.plane([0.0, 0, 1], 0.25)
    says = "constraint 0 (Incidence) is violated at the start, by "
    error = refused(lambda: simulation([], dynamics.Incidence(TIP, lower)).run(SHORT), says, ConstraintError)
    assert error.remedy is not None and "project=True" in error.remedy


def test_objects_of_another_algebra_are_told() -> None:
    refused(lambda: simulation([], dynamics.Pin(pga3d.point([0.0, 0, 1]))).run(SHORT), "pga3d", AlgebraMismatchError)
    refused(lambda: simulation(dynamics.BodyWrench(TIP)).run(SHORT), "the blades of a twist are", GradeError)
