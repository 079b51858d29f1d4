"""Results of long computations: each says in the same three attributes what became of it."""

from __future__ import annotations

import inspect
from typing import Any

import numpy as np
import pytest

from bladesmith import Status, cga3d, dynamics, kinematics, objects, reform, tracer

LINES = cga3d.line(np.eye(3), np.roll(np.eye(3), 1, 0))
BODY = dynamics.RigidBody(1.0, (1.0, 1.0, 1.0))
MODULES = (dynamics, kinematics, objects, reform, tracer)
MODEL = reform.Model(points=np.random.default_rng(0).normal(size=(6, 3)))


def clusters(iterations: int = 100) -> Any:
    return objects.kmeans(LINES, 2, max_iterations=iterations)


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
    found = objects.kmeans(cga3d.line(np.random.default_rng(1).normal(size=(40, 3)), (1, 0, 0)), 4, max_iterations=1)
    assert found.status == Status.NOT_CONVERGED and not found.converged and found.message == "the 1 iterations ran out"


def test_strict_is_off_by_default() -> None:
    """But for the two whose result, plain numbers, has no room for a status."""
    found = [(f"{m.__name__}.{name}", getattr(m, name)) for m in MODULES for name in m.__all__]
    found += [(f"{name}.{n}", x) for name, kind in found if isinstance(kind, type) for n, x in vars(kind).items()]
    parameters = {name: inspect.signature(x).parameters for name, x in found if inspect.isfunction(x)}
    strict = {name: x["strict"].default for name, x in parameters.items() if "strict" in x and "._" not in name}
    raising = {name for name, default in strict.items() if default is not False}
    assert len(strict) > 40
    assert raising == {f"bladesmith.kinematics.Mechanism.{name}" for name in ("jacobian", "solve")}
