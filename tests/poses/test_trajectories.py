"""Trajectories in files of TUM, against SciPy's quaternions and plain text."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from bladesmith import cga3d, poses
from bladesmith.errors import BladesmithError, InputError


def trajectory(n=6, seed=0):
    rng = np.random.default_rng(seed)
    turns, places = Rotation.random(n, random_state=seed), 10 * rng.normal(size=(n, 3))
    return 1.3e9 + np.sort(rng.uniform(0, 100, n)), turns, places


@pytest.mark.parametrize("made", ["poses", "list of poses", "motors of cga3d", "list of motors"])
def test_files_are_the_format_and_come_back(made, tmp_path):
    times, turns, places = trajectory()
    matrices = np.tile(np.eye(4), (len(times), 1, 1))
    matrices[:, :3, :3], matrices[:, :3, 3] = turns.as_matrix(), places
    x = poses.from_matrix(matrices) if "poses" in made else cga3d.motor_from_matrix(matrices)
    poses.save_tum(tmp_path / "x.tum", times, list(x) if "list" in made else x)
    rows = np.loadtxt(tmp_path / "x.tum")
    np.testing.assert_array_equal(rows[:, 0], times)
    np.testing.assert_allclose(rows[:, 1:4], places, atol=1e-13)
    np.testing.assert_allclose(Rotation.from_quat(rows[:, 4:]).as_matrix(), turns.as_matrix(), atol=1e-14)
    assert (rows[:, 7] >= 0).all()
    stamps, again = poses.load_tum(tmp_path / "x.tum")
    np.testing.assert_array_equal(stamps, times)
    np.testing.assert_allclose(again.to_matrix(), matrices, atol=1e-13)


def test_rounded_files_of_others_are_read(tmp_path):
    times, turns, places = trajectory(3, 1)
    rows = np.column_stack([times, places, turns.as_quat()])
    np.savetxt(tmp_path / "x.txt", rows, fmt="%.4f", header="ground truth\ntimestamp tx ty tz qx qy qz qw")
    stamps, found = poses.load_tum(tmp_path / "x.txt")
    np.testing.assert_allclose(stamps, times, atol=1e-4)
    np.testing.assert_allclose(found.to_matrix()[:, :3, :3], turns.as_matrix(), atol=3e-4)
    text = (tmp_path / "x.txt").read_text().split("\n", 2)[2]
    (tmp_path / "marked.txt").write_text(text, encoding="utf-8-sig")
    np.testing.assert_array_equal(poses.load_tum(tmp_path / "marked.txt")[0], stamps)
    (tmp_path / "empty.txt").write_text("# nothing\n\n")
    assert poses.load_tum(tmp_path / "empty.txt")[1].shape == (0,)
    poses.save_tum(tmp_path / "none.txt", [], [])
    assert poses.load_tum(tmp_path / "none.txt")[0].shape == (0,)


@pytest.mark.parametrize("line, message", [
    ("1 2 3", "line 3: '1 2 3' is not a pose; eight"), ("1 0 0 0 0 0 0 x", "line 3: .*not a pose"),
    ("1 0 0 0 0 0 0 0", "line 3: the quaternion .* length 0;"), ("1 0 0 0 0 0 1 1", "line 3: .* length 1.41"),
    ("1 0 0 nan 0 0 0 1", "line 3: .*finite"), ("1 0 0 0 0 0 0 1 9", "line 3: .*eight"),
])  # fmt: skip
def test_what_is_no_pose_has_its_line(line, message, tmp_path):
    (tmp_path / "x.tum").write_text(f"# a comment\n0 0 0 0 0 0 0 1\n{line}\n")
    with pytest.raises(InputError, match=message):
        poses.load_tum(tmp_path / "x.tum")


def test_what_cannot_be_written(tmp_path):
    x = poses.identity()
    for times, motors, message in (
        ([0, 1], [x], "2 times and poses of shape"), ([np.nan], [x], "times"), ([0], x, "1 times and poses of shape"),
        ([0], [3], "pose"), ([0], [cga3d.translator((np.nan, 0, 0))], "finite"), ([[0]], [x], "times"),
    ):  # fmt: skip
        with pytest.raises(BladesmithError, match=message):
            poses.save_tum(tmp_path / "x.tum", times, motors)
    assert not list(tmp_path.iterdir())
    with pytest.raises(InputError, match="cannot be read"):
        poses.load_tum(tmp_path / "none.tum")
