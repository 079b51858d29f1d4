"""examples/dynamics/computed_torque.py: an arm under a controller, its torques beside Pinocchio's."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from bladesmith import kinematics

from ...support.scripts import script


def motion(duration: float = 0.5, **options: Any) -> dict[str, Any]:
    with script("examples/dynamics", "computed_torque") as example:
        return example.follow(kinematics.load_urdf(kinematics.urdf_example("arm")), duration, **options)  # type: ignore[no-any-return]


@pytest.mark.slow
def test_the_path_is_kept_as_torques_are_held_for_a_step() -> None:
    coarse, fine = (np.abs(motion(dt=dt)["error"]).max() for dt in (1e-3, 5e-4))
    assert coarse < 1e-3 and fine < 0.6 * coarse


@pytest.mark.slow
@pytest.mark.peers
def test_torques_are_those_of_pinocchio() -> None:
    pinocchio = pytest.importorskip("pinocchio")
    found = motion()
    model = pinocchio.buildModelFromUrdf(str(kinematics.urdf_example("arm")))
    data = model.createData()
    for row in range(0, len(found["time"]), 50):
        expected = pinocchio.rnea(model, data, found["q"][row], found["qd"][row], found["qdd"][row])
        assert np.abs(found["torque"][row] - expected).max() <= 1e-12 * np.abs(expected).max()
