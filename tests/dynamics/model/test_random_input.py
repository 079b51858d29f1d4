"""Random arguments of bodies, loads, constraints and runs: taken or refused, never anything else."""

from __future__ import annotations

import inspect
import warnings
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

from bladesmith import cga3d, dynamics, pga3d
from bladesmith.errors import (
    BladesmithError,
)

from ...support.dynamics.input import PLANE, SHORT, TIP, WRENCH, ball, failing, simulation


class Contrary:
    """No array, and no number."""

    def __array__(self, *given: Any, **named: Any) -> Any:
        raise TypeError("no")


JUNK: list[Any] = [
    None, "", "x", b"x", True, np.nan, np.inf, -1, 0, 1, 1e308, 5e-324, 10**400, 1j, [], [[]], {}, (), object(),
    Contrary(), int, np.zeros(0), np.zeros((0, 3)), np.ones((2, 3)), np.ones((2, 2, 3)), np.array(1.0),
    np.array([None, 1, 2]), np.array(["a"]), np.ma.masked_array([1.0, 2, 3], [0, 1, 0]), [1, 2, 3], [[1], [2, 3]],
    np.eye(3), np.full(3, np.nan), np.full(3, 1e200), np.datetime64("2020"), {1, 2}, range(3), len, failing,
    lambda *given: None, lambda t: TIP, lambda t, motor, twist: (WRENCH, WRENCH), cga3d, TIP, PLANE, WRENCH, 0 * TIP,
    np.nan * TIP, 1e200 * TIP, cga3d.scalar(1.0), cga3d.point(np.eye(3)), pga3d.point([0.0, 0, 1]),
    cga3d.point(np.zeros((0, 3))), cga3d.translator([1.0, 0, 0]),
]  # fmt: skip
GOOD: dict[Any, dict[str, Any]] = {
    dynamics.RigidBody: {"mass": 1.0, "inertia": [1.0, 2.0, 2.5]},
    dynamics.Gravity: {"acceleration": [0.0, 0, -9.81]},
    dynamics.BodyWrench: {"wrench": WRENCH},
    dynamics.WorldWrench: {"wrench": WRENCH},
    dynamics.Spring: {"point": 0, "anchor": [0.0, 0, 1], "stiffness": 1.0},
    dynamics.Damper: {},
    dynamics.QuadraticDrag: {},
    dynamics.Pin: {"body_object": TIP},
    dynamics.PinPath: {"body_object": TIP, "world_object": TIP},
    dynamics.PinLinear: {"function": lambda x: TIP ^ x, "world_object": PLANE},
    dynamics.Incidence: {"body_point": TIP, "world_object": PLANE},
    dynamics.VirtualPower: {"wrenches": WRENCH},
    dynamics.Event: {"function": lambda t, motor, twist: t},
    dynamics.System: {"bodies": [ball()]},
    dynamics.Simulation: {"body": ball()},
    dynamics.Sketch: {},
    dynamics.Trace: {"point": 0},
    dynamics.box: {"size": [1.0, 2, 3]},
    dynamics.cone: {"radius": 1.0, "height": 1.0},
    dynamics.sphere: {"radius": 1.0},
    dynamics.Inertia: {"mass": 1.0, "moments": [1.0, 2.0, 2.5]},
}


@pytest.mark.parametrize("make", GOOD, ids=lambda make: make.__name__)
def test_any_argument_is_taken_or_refused(make: Any) -> None:
    """Each argument in turn is something else: the package's error in one line, or an object; no warning."""
    make(**GOOD[make])
    taken = 0
    for name in inspect.signature(make).parameters:
        for value in JUNK:
            with warnings.catch_warnings():
                warnings.simplefilter("error")
                try:
                    make(**{**GOOD[make], name: value})
                    taken += 1
                except BladesmithError as error:
                    assert "\n" not in str(error), (name, error)
    assert taken < len(JUNK) * len(inspect.signature(make).parameters)


junk = st.sampled_from(JUNK)
SPRING = st.sampled_from(["point", "anchor", "stiffness", "length", "damping"])
OPTION = st.sampled_from(["times", "rtol", "atol", "threads", "strict", "progress"])


@pytest.mark.slow
@settings(max_examples=60, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
@given(st.dictionaries(SPRING, junk, max_size=2), st.dictionaries(OPTION, junk, max_size=1))
def test_runs_of_any_springs_are_finite_or_say_why(spring: dict[str, Any], options: dict[str, Any]) -> None:
    """Whatever was taken: states are finite, or the simulation does not call itself "ok"."""
    assume(not callable(options.get("progress")))  # what it raises is the user's own
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            load = dynamics.Spring(**{**GOOD[dynamics.Spring], **spring})
            found = simulation(load).run(SHORT, **options)
        except BladesmithError as error:
            assert "\n" not in str(error)
            return
    ok = np.atleast_1d(found.ending) == "ok"
    position = found.position.reshape(len(ok), -1, 3)
    assert np.isfinite(position[ok]).all()
