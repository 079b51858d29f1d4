"""Results of long computations: each says in the same three attributes what became of it."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
import pytest

from bladesmith import Status, cga3d, dynamics, kinematics, objects, poses, reform, tracer
from bladesmith.errors import SingularError

LINES = cga3d.line(np.eye(3), np.roll(np.eye(3), 1, 0))
BODY = dynamics.RigidBody(1.0, (1.0, 1.0, 1.0))
MODULES = (dynamics, kinematics, objects, poses, reform, tracer)
MODEL = reform.Model(points=np.random.default_rng(0).normal(size=(6, 3)))


def clusters(iterations: int = 100) -> Any:
    return objects.kmeans(LINES, 2, iterations=iterations)


def fall(step: float = 0.01) -> Any:
    return dynamics.Simulation(BODY, [dynamics.Gravity((0, 0, -9.81))]).run(0.1, step)


RESULTS = {
    "clusters": clusters,
    "trajectory": fall,
    "record": lambda: dynamics.as_record(fall()),
    "registration": lambda: reform.register(MODEL, MODEL),
    "estimate": lambda: reform.estimate_rotor(MODEL, MODEL, details=True),
}


@pytest.mark.parametrize("name", RESULTS)
def test_status_message_and_converged_agree(name: str) -> None:
    found = RESULTS[name]()
    assert found.status == Status.OK and found.converged and found.message == ""


def test_what_did_not_converge_says_so() -> None:
    found = objects.kmeans(cga3d.line(np.random.default_rng(1).normal(size=(40, 3)), (1, 0, 0)), 4, iterations=1)
    assert found.status == Status.NOT_CONVERGED and not found.converged and found.message == "the 1 iterations ran out"


def test_strict_is_off_by_default() -> None:
    """But for the two whose result, plain numbers, has no room for a status, and what makes poses of users' numbers."""
    found = [(f"{m.__name__}.{name}", getattr(m, name)) for m in MODULES for name in m.__all__]
    found += [(f"{name}.{n}", x) for name, kind in found if isinstance(kind, type) for n, x in vars(kind).items()]
    parameters = {name: inspect.signature(x).parameters for name, x in found if inspect.isfunction(x)}
    strict = {name: x["strict"].default for name, x in parameters.items() if "strict" in x and "._" not in name}
    raising = {name for name, default in strict.items() if default is not False}
    assert len(strict) > 40
    makers = {f"bladesmith.poses.{name}" for name in poses.__all__ if name.startswith("from_")}
    assert len(makers) == 5
    assert raising == makers | {f"bladesmith.kinematics.Mechanism.{name}" for name in ("jacobian", "solve")}


GOOD, BAD = (0.3, -0.2, 0.9), (np.nan, 0.0, 0.9)
TWISTS = dynamics.twist([GOOD, BAD], GOOD)
TWIST, WRENCH = TWISTS[0], dynamics.wrench(GOOD, (1, 2, 3))
POSES = poses.from_rotation_vector([GOOD, BAD], strict=False)
MIXED_LINES = cga3d.line([GOOD, BAD], (1, 0, 0))
ROBOT = kinematics.DeltaRobot(0.4, 0.1, 0.5, 1.0)
CHAIN = kinematics.Chain([kinematics.revolute_axis(GOOD, (0, 0, 1)), kinematics.revolute_axis((1, 0, 0), (0, 1, 0))])
#: Functions that return plain arrays, here of two items; the second is not finite.
PLAIN: dict[str, Callable[..., Any]] = {
    "velocity_at": lambda **options: dynamics.velocity_at(TWISTS, (1, 2, 3), **options),
    "velocity_at, of the point": lambda **options: dynamics.velocity_at(WRENCH, [GOOD, BAD], **options),
    "moment_about": lambda **options: dynamics.moment_about(TWISTS, 0, **options),
    "power": lambda **options: dynamics.power(TWISTS, WRENCH, **options),
    "reciprocal": lambda **options: dynamics.reciprocal(WRENCH, TWISTS, **options),
    "killing_form": lambda **options: dynamics.killing_form(TWISTS, TWISTS, **options),
    "screw_coordinates": lambda **options: dynamics.screw_coordinates(TWISTS, "axis-last", **options),
    "energy": lambda **options: dynamics.Inertia(2.0, (1.0, 1.0, 1.0)).energy(TWISTS, **options),
    "norm": lambda **options: MIXED_LINES.norm(**options),
    "to_matrix": lambda **options: cga3d.translator([GOOD, BAD]).to_matrix(**options),
    "rotor_cost": lambda **options: objects.rotor_cost(objects.rotor_between(LINES[0], MIXED_LINES), **options),
    "cost_matrix": lambda **options: objects.cost_matrix(MIXED_LINES, LINES[0], **options),
    "sphere_weights": lambda **options: objects.sphere_weights(cga3d.sphere([[GOOD], [BAD]], 1.0), axis=1, **options),
    "inverse": lambda **options: ROBOT.inverse([GOOD, BAD], **options),
    "forward": lambda **options: ROBOT.forward([GOOD, BAD], **options),
    "forward_jacobian": lambda **options: ROBOT.forward_jacobian([GOOD, BAD], **options),
    "inverse_jacobian": lambda **options: ROBOT.inverse_jacobian([GOOD, BAD], method="screw", **options),
    **{
        name: partial(getattr(poses, name), POSES)
        for name in ("to_quaternion", "to_dual_quaternion", "to_rotation_vector", "position", "log", "adjoint")
    },
    "to_matrix, of a pose": lambda **options: poses.to_matrix(POSES, **options),
    "to_euler": lambda **options: poses.to_euler(POSES, "xyz", **options),
    "act": lambda **options: poses.act(POSES, (1, 2, 3), **options),
    "rotate": lambda **options: poses.rotate(POSES, (1, 2, 3), **options),
    "left_jacobian": lambda **options: poses.left_jacobian([GOOD * 2, BAD * 2], **options),
    "inverse_right_jacobian": lambda **options: poses.inverse_right_jacobian([GOOD * 2, BAD * 2], **options),
    "jacobian": lambda **options: CHAIN.jacobian([GOOD[:2], BAD[:2]], **options),
}


@pytest.mark.parametrize("name", PLAIN)
def test_plain_arrays_come_with_statuses_where_they_are_requested(name: str) -> None:
    values, codes = PLAIN[name](status=True)
    np.testing.assert_array_equal(values, PLAIN[name]())
    assert np.isfinite(values[0]).all() and np.isnan(values[1]).any()
    assert codes.shape == (2,) if name != "sphere_weights" else codes.shape == (2, 1)
    assert codes.ravel().tolist() == [Status.OK, Status.INVALID]
    with pytest.raises(SingularError, match=rf"^{name.partition(',')[0]}: item .*1.* is INVALID\.$"):
        PLAIN[name](strict=True)


STRICT: dict[str, Callable[..., Any]] = {
    "twist_parts": lambda **options: dynamics.twist_parts(TWISTS, **options),
    "wrench_parts": lambda **options: dynamics.wrench_parts(TWISTS, **options),
    "screw_cross": lambda **options: dynamics.screw_cross(TWIST, TWISTS, **options),
    "resultant": lambda **options: dynamics.resultant([TWIST, TWISTS], **options),
    "equilibrium": lambda **options: dynamics.equilibrium([TWIST, TWISTS], **options),
    "force_along": lambda **options: dynamics.force_along(MIXED_LINES, **options),
    "line_of_wrench": lambda **options: dynamics.line_of_wrench(TWISTS, **options),
    "ideal_line": lambda **options: dynamics.ideal_line([GOOD, BAD], **options),
    "wrench_of_vector": lambda **options: dynamics.wrench_of_vector(cga3d.e1, cga3d.point([GOOD, BAD]), **options),
    "momentum": lambda **options: dynamics.Inertia(2.0, (1.0, 1.0, 1.0))(TWISTS, **options),
    "momentum_rate": lambda **options: dynamics.Inertia(2.0, (1.0, 1.0, 1.0)).momentum_rate(TWISTS, **options),
    "exp": lambda **options: TWISTS.exp(**options),
}


@pytest.mark.parametrize("name", STRICT)
def test_functions_with_statuses_raise_with_strict(name: str) -> None:
    assert np.asarray(STRICT[name]().status).tolist() == [Status.OK, Status.INVALID]
    with pytest.raises(SingularError, match=rf"^{name}: item 1 is INVALID\.$"):
        STRICT[name](strict=True)


def test_a_single_item_has_a_status_of_its_own() -> None:
    twist = TWISTS[1]
    assert dynamics.power(twist, WRENCH, status=True)[1] is Status.INVALID
    assert dynamics.power(TWISTS[0], WRENCH, status=True)[1] is Status.OK
    with pytest.raises(SingularError, match="power: it is INVALID"):
        dynamics.power(twist, WRENCH, strict=True)


def test_what_an_operand_says_of_itself_stays() -> None:
    """What had no unit scale is SINGULAR, and so is its norm, although what is not finite is INVALID."""
    rotor = cga3d.multivector({"e12": 0.0}).normalized()
    assert rotor.status == Status.SINGULAR
    assert rotor.norm(status=True)[1] is Status.SINGULAR


def test_spheres_whose_sum_is_zero_have_no_weights() -> None:
    spheres = cga3d.sphere([(0, 0, 0), (1, 0, 0)], [1.0, 2.0])
    assert objects.sphere_weights(spheres, [2, -1], status=True)[1].tolist() == [Status.SINGULAR] * 2


def test_functions_with_a_status_have_strict_too() -> None:
    found = [getattr(m, name) for m in (cga3d, *MODULES) for name in getattr(m, "__all__", dir(m))]
    found += [x for kind in found if isinstance(kind, type) for n, x in vars(kind).items() if n != "__init__"]
    found += list(vars(type(LINES)).values())
    options = {x.__qualname__: inspect.signature(x).parameters for x in found if inspect.isfunction(x)}
    with_status = {name for name, parameters in options.items() if "status" in parameters}
    assert len(with_status) > 14
    assert {name for name in with_status if "strict" not in options[name]} == set()
