"""Points on the joints of pieces of curves: each once, of the lower piece, whatever the order pieces are asked in."""

from __future__ import annotations

import numpy as np
import pytest

from bladesmith import tracer
from bladesmith.codegen.programs.scene import TREE_PAYS
from bladesmith.curves import KochanekBartels

PIECES = TREE_PAYS + 2


@pytest.mark.parametrize("closed", [False, True])
def test_points_on_joints_count_once_in_a_tree(closed):
    """Rays through points of the controls, along the curve and against it: a tree asks the nearer piece first."""
    angle = 2 * np.pi * np.arange(PIECES) / PIECES
    center = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    axis = np.stack([-np.sin(angle), np.cos(angle), 0 * angle], axis=1)
    surface = tracer.EvolvedCircles(
        KochanekBartels([(tuple(5 * c), tuple(a), 1.0) for c, a in zip(center, axis, strict=True)], closed=closed)
    )
    assert len(surface.parameters) >= TREE_PAYS
    for place in range(1, PIECES - 1):
        for turn in np.linspace(0.3, 6, 7):
            aim = 5 * center[place] + np.cos(turn) * center[place] + np.sin(turn) * np.array([0, 0, 1.0])
            for way in (axis[place] + 0.7 * center[place] + (0, 0, 0.2), (0.5, 0.9, 0.4)):
                origins, directions = aim - 3 * np.stack([way, -np.array(way)]), np.stack([way, -np.array(way)])
                found = surface.intersect(origins, directions)
                assert (np.isfinite(found.t).sum(axis=-1) == found.count).all()
                assert found.count[0] == found.count[1]
                for i in range(2):
                    points, rows = found.point[i, : found.count[i]], found.row[i, : found.count[i]]
                    near = np.linalg.norm(points - aim, axis=1) < 1e-5
                    assert near.sum() == 1 and rows[near] == place - 1
                    np.testing.assert_allclose(found.alpha[i, : found.count[i]][near], place, atol=1e-5)
