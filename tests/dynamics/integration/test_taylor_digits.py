"""Taylor coefficients by the text of the algorithms with 50 digits, beside those of elliptic functions."""

from __future__ import annotations

from typing import Any

import mpmath
import numpy as np
import pytest

from bladesmith import cga3d as cga
from bladesmith import pga3d as pga
from bladesmith.codegen.algorithms.dynamics.records import work_records
from bladesmith.codegen.programs.dynamics.dynamics import parts_with_series, simulation_algorithms_of
from bladesmith.dynamics import Gravity, Pin, RigidBody, Simulation

ORDER, DIGITS = 12, 50
#: Numbers that stay exact in floating point, from mass 1, length 1 and moment 1 on.
GRAVITY = 9.5


def pendulum_rate(t: Any) -> Any:
    """Rate of the angle of a pendulum that starts at rest at the horizontal: 2 asin(k cd(w t, k)), k^2 = 1/2."""
    mp = mpmath.mp
    w, k = mp.sqrt(mp.mpf(GRAVITY) / 2), mp.sqrt(mp.mpf(1) / 2)
    return -2 * k * w * mp.sqrt(1 - k * k) * mp.ellipfun("sd", w * t, k=k)


@pytest.mark.slow
@pytest.mark.parametrize("algebra", [cga, pga], ids=["cga3d", "pga3d"])
def test_coefficients_of_a_pendulum(algebra: Any) -> None:
    """Held by reactions: rates of the motor, gravity, rows of the hinge, multipliers and accelerations."""
    body = RigidBody(1.0, [1.0, 1.0, 1.0], position=[1, 0, 0], algebra=algebra)
    hinge = Pin(algebra.line([-1, 0, 0], [0, 1, 0]))
    loads = [Gravity([0, 0, -GRAVITY])]
    held = Simulation(body, loads, [hinge], integrator="taylor", stabilization="projection")
    run = held.run(0.1, times=[0.1])._run
    driver = run.driver
    needs = driver.assembly.needs("taylor", "exponential")
    work = work_records(parts_with_series(needs)[0])
    w, p = np.zeros(work.numbers.size), np.zeros(work.integers.size, np.int64)
    for fields, record, row in zip(driver._constants, (work.numbers, work.integers), (w, p), strict=True):
        for name, value in fields.items():
            first = record.offsets[name]
            row[first : first + np.size(value)] = 0 if name == "handle" else value
    (find_coefficients,) = simulation_algorithms_of(needs)[2]
    numbers, shared = driver.assembly.parameters[0], driver.arrays()[0]
    start = np.zeros((ORDER + 1, 14))
    start[0] = [*run.motors[0, 0].ravel(), *run.twists[0, 0].ravel()]
    with mpmath.workdps(DIGITS):
        *_, coefficients, status = find_coefficients.reference(
            numbers, numbers, shared["springs"], shared["constraints"], w, p, np.zeros(1, np.int64), 0.0, ORDER, 1.0,
            start, numbers=mpmath.mp,
        )  # fmt: skip
        assert status == 0
        expected = mpmath.mp.taylor(pendulum_rate, 0, ORDER)
        size = max(map(abs, expected))
        moving = [column for column in coefficients[:, 8:].T if abs(column[1]) > 1e-9]
        assert len(moving) == 2  # the angular velocity, and what it is at the center, a length of 1 off
        for column in moving:
            sign = 1 if column[1] < 0 else -1
            assert max(abs(sign * a - b) for a, b in zip(column, expected, strict=True)) < 1e-40 * size
