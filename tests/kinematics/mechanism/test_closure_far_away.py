"""Loops that close by their geometry, near the origin and far away: mobility, rates and poses."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from bladesmith import cga3d as cga
from bladesmith import kinematics

from ...support.kinematics import hinge

FAR = [(0.0, 0.0, 0.0), (1e4, -3e3, 2e3), (0.0, 1e4, 0.0)]


def bennett(away: NDArray[np.float64]) -> kinematics.Mechanism:
    """Bennett's loop by Denavit-Hartenberg: opposite links alike, sin(twist) / length the same for all."""
    lengths, twists = np.array([1.0, 1.5, 1.0, 1.5]), np.arcsin(np.array([1.0, 1.5, 1.0, 1.5]) * np.sin(0.6))
    first = 0.7
    second = 2 * np.arctan(
        np.sin((twists[1] + twists[0]) / 2) / np.sin((twists[1] - twists[0]) / 2) / np.tan(first / 2)
    )
    names, joints, pose = ["frame", "one", "two", "three"], [], np.eye(4)
    angles = (first, second, -first, -second)
    for i, (t, a, s) in enumerate(zip(angles, lengths, twists, strict=True)):
        joints.append(hinge(names[i - 1], names[i], away + pose[:3, 3], pose[:3, 2]))
        c, s, ct, st = np.cos(t), np.sin(t), np.cos(s), np.sin(s)
        pose = pose @ [[c, -s * ct, s * st, a * c], [s, c * ct, -c * st, a * s], [0, st, ct, 0], [0, 0, 0, 1]]
    assert np.abs(pose - np.eye(4)).max() < 1e-14
    return kinematics.Mechanism(names, "frame", joints)


@pytest.mark.parametrize("away", FAR)
def test_loops_that_close_by_their_geometry_keep_their_mobility_far_away(away: tuple[float, float, float]) -> None:
    place = np.array(away)
    assert bennett(place).mobility() == 1
    axes = [np.array(x) / np.linalg.norm(x) for x in ((0, 0, 1), (1, 0.2, 1), (1, 1, 0.3), (0.1, 1, 0.2))]
    ends = [("frame", "a"), ("a", "b"), ("b", "c"), ("frame", "c")]
    ball = kinematics.Mechanism(
        ["frame", "a", "b", "c"], "frame", [hinge(*e, place + x, x) for e, x in zip(ends, axes, strict=True)]
    )
    ratio = np.linalg.solve(np.column_stack([axes[1], axes[2], -axes[3]]), -axes[0])[2]
    assert ball.mobility() == 1 and len(ball.self_stresses()) == 3
    assert abs(ball.jacobian(*(ball.joints[i] for i in (0, 3)))[0, 0] / ratio - 1) < 1e-5
    loose = hinge("frame", "c", place + axes[3], axes[3] + (0, 0, 1e-4))  # no longer through the middle
    tight = kinematics.Mechanism(["frame", "a", "b", "c"], "frame", [*ball.joints[:3], loose])
    assert tight.mobility() == 0


@pytest.mark.parametrize("away", FAR)
def test_a_cardan_shaft_is_followed_around_far_away(away: tuple[float, float, float]) -> None:
    bend, place = 0.4, np.array(away)
    along, out, arm = np.array([1.0, 0, 0]), np.array([np.cos(bend), np.sin(bend), 0]), np.array([0, 0, 1.0])
    cross = kinematics.Universal("in", "out", cga.circle(place, arm, 1.0), cga.circle(place, np.cross(out, arm), 1.0))
    shaft = kinematics.Mechanism(["frame", "in", "out"], "frame")
    first = shaft.add(hinge("frame", "in", place - along, along))
    shaft.add(cross)
    last = shaft.add(hinge("frame", "out", place + out, out))
    assert shaft.mobility() == 1
    turns = np.linspace(0, 2 * np.pi, 25)
    found = shaft.solve_pose({first: turns}, path=True)
    expected = np.arctan2(np.sin(turns) * np.cos(bend), np.cos(turns))
    off = np.angle(np.exp(1j * (found.coordinates(last)[:, 0] - expected)))
    assert not found.status.any()
    assert np.abs(off).max() < (1e-6 if place.any() else 1e-12)
    assert abs(shaft.jacobian(first, last)[0, 0] - np.cos(bend)) < (1e-6 if place.any() else 1e-12)
