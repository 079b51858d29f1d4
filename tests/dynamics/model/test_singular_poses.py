"""Poses where a mechanism has more freedoms than elsewhere: motions go through them, and say so."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from ...support.scripts import script

G = 9.81


def expected(count: int, times: Any) -> tuple[Any, Any]:
    """Angles of the cranks from upright, whose one freedom is that of a pendulum, and their energy at the start."""
    inertia, lever = (count + 1) / 3 + count, (count + 1) / 2 + count
    found = solve_ivp(
        lambda t, y: [y[1], G * lever / inertia * np.sin(y[0])], (0, times[-1]), [0, 1.0], method="DOP853",
        t_eval=times, rtol=1e-12, atol=1e-13,
    )  # fmt: skip
    return found.y[0], inertia / 2 + lever * G


@pytest.mark.parametrize(
    ("count", "options", "run", "off"),
    [
        (1, {}, {}, 1e-5),
        pytest.param(3, {}, {}, 1e-5, marks=pytest.mark.slow),
        pytest.param(1, {"integrator": "adaptive"}, {}, 1e-5, marks=pytest.mark.slow),
        pytest.param(1, {"integrator": "adaptive"}, {"rtol": 1e-6}, 1e-3, marks=pytest.mark.slow),
        pytest.param(1, {"integrator": "rk4"}, {"step": 2e-3}, 1e-3, marks=pytest.mark.slow),
    ],
)
def test_parallelograms_go_on_through_poses_where_they_lie_flat(count: int, options: Any, run: Any, off: float) -> None:
    with script("examples/dynamics", "published_problems") as problems:
        simulation = problems.parallelograms(count, **options)
    times = np.linspace(0, 5, 101)
    motion = simulation.run(5.0, times=times, strict=True, **run)
    angle, energy = expected(count, times)
    tip = 2 * motion["crank 0"].position
    assert np.abs(tip[:, 0] - np.sin(angle)).max() <= off and np.abs(tip[:, 1] - np.cos(angle)).max() <= off
    assert np.abs(motion.energy - energy).max() <= off * energy
    # next to a flat pose a row counts as redundant, and what a long step left of its error stays: 3e-8 in the worst of
    # 300 starts that differ in the ninth digit, 1e-9 in all but two
    assert motion.violation.max() <= 1e-7 and np.median(motion.violation) <= 1e-12
    apart = motion[f"crank {count}"].position - motion["crank 0"].position
    assert np.abs(apart - [count, 0, 0]).max() <= 1e-6  # none has crossed
    if not np.isnan(motion.singular_time):
        flat = np.cos(np.interp(motion.singular_time, times, np.unwrap(angle)))
        assert abs(flat) < 0.1
    else:
        assert options.get("integrator") not in (None, "adaptive")


def test_a_pendulum_is_never_singular() -> None:
    with script("examples/dynamics", "published_problems") as problems:
        motion = problems.pendulum().run(1.0)
    assert np.isnan(motion.singular_time)
