"""Fastest motions along paths of joints: known cases, limits, and that some limit is met nearly always."""

from __future__ import annotations

import numpy as np
import pytest

from bladesmith import kinematics
from bladesmith.errors import InputError, ShapeError


@pytest.mark.parametrize(
    ("way", "speed", "push", "duration"),
    [
        (2.0, 1.0, 2.0, 2.5), (0.1, 1.0, 2.0, 2 * np.sqrt(0.05)), (-3.0, 10.0, 1e-3, 2 * np.sqrt(3e3)),
        (1e-6, 1.0, 1.0, 2e-3),
    ],
)  # fmt: skip
def test_one_joint_takes_the_time_of_a_trapezoid(way, speed, push, duration):
    path = kinematics.time_optimal([[0.5], [0.5 + way]], speed, push)
    assert path.duration == pytest.approx(duration, rel=1e-9)
    assert path(0.0) == 0.5 and path(path.duration) == pytest.approx(0.5 + way, rel=1e-14)
    assert path.speeds([0.0, path.duration]) == pytest.approx(0, abs=1e-7 * speed)
    assert path(2 * duration) == pytest.approx(0.5 + way) and path.speeds(-1.0) == 0


def test_the_slowest_joint_decides_on_a_straight_line():
    """Joints are synchronized: the second takes 1/0.2 + 0.2/1.5 by itself, where 3 is more than it may use."""
    path = kinematics.time_optimal([[0.0, 0.0], [2.0, 1.0]], [1.0, 0.2], [2.0, 1.5])
    assert path.duration == pytest.approx(1 / 0.2 + 0.2 / 1.0, rel=1e-9)  # accelerations of 1: the first has 2


@pytest.mark.parametrize(("points", "joints"), [(3, 1), (5, 2), (12, 6), (30, 7)])
def test_limits_are_kept_and_met(points, joints):
    rng = np.random.default_rng(points)
    q = np.cumsum(rng.normal(size=(points, joints)), 0)
    speeds, pushes = rng.uniform(0.5, 2, joints), rng.uniform(1, 6, joints)
    path = kinematics.time_optimal(q, speeds, pushes)
    t = np.linspace(0, path.duration, 20001)
    fast, hard = np.abs(path.speeds(t)) / speeds, np.abs(path.accelerations(t)) / pushes
    assert fast.max() < 1 + 1e-4 and hard.max() < 1 + 1e-4
    met = np.maximum(fast, hard).max(-1)
    assert np.percentile(met, 10) > 0.93 and np.median(met) > 0.98
    # derivatives belong together, and the path passes the points
    h = 1e-6
    inside = t[100:-100:37]
    slope = (path(inside + h) - path(inside - h)) / (2 * h)
    assert np.abs(slope - path.speeds(inside)).max() < 1e-5
    nearest = np.abs(path(t)[:, None] - q).max(-1).min(0)
    assert nearest.max() < 2e-3
    back = kinematics.time_optimal(q[::-1], speeds, pushes)
    assert back.duration == pytest.approx(path.duration, rel=3e-3)
    finer = kinematics.time_optimal(q, speeds, pushes, samples=4000)
    assert finer.duration < path.duration < 1.03 * finer.duration


def test_units_scale():
    """Lengths by 1e-6 and times by 1e3: the same motion."""
    q = np.random.default_rng(2).uniform(-1, 1, (6, 3))
    path = kinematics.time_optimal(q, 1.0, 3.0)
    small = kinematics.time_optimal(1e-6 * q, 1e-9, 3e-12)
    assert small.duration == pytest.approx(1e3 * path.duration, rel=1e-9)


def test_bad_input():
    line = [[0.0, 0], [1, 1]]
    with pytest.raises(InputError, match="points 1 and 2 are equal"):
        kinematics.time_optimal([[0.0], [1], [1], [2]], 1, 1)
    with pytest.raises(ShapeError, match="two or more"):
        kinematics.time_optimal([[0.0, 1]], 1, 1)
    with pytest.raises(ShapeError, match=r"speeds have shape \(3,\)"):
        kinematics.time_optimal(line, [1, 1, 1], 1)
    for speeds, pushes in ((0, 1), (1, -1), (np.inf, 1), (1, np.nan)):
        with pytest.raises(InputError):
            kinematics.time_optimal(line, speeds, pushes)
    with pytest.raises(InputError, match="points"):
        kinematics.time_optimal([[0.0], [np.nan]], 1, 1)
    with pytest.raises(InputError, match="samples"):
        kinematics.time_optimal(line, 1, 1, samples=1)
    with pytest.raises(InputError, match="longer than numbers are"):
        kinematics.time_optimal([[0.0, 0.0], [1e300, 1.0]], 1.0, 1.0)
    with pytest.raises(InputError, match="times are not finite"):
        kinematics.time_optimal(line, 1, 1)(np.nan)


@pytest.mark.parametrize("way", [1e-30, 1e-10, 1e-9])
def test_short_paths_are_as_long_ones(way):
    path = kinematics.time_optimal([[0.0], [way]], 1.0, 2.0)
    assert path.duration == pytest.approx(2 * np.sqrt(way / 2), rel=1e-9)
