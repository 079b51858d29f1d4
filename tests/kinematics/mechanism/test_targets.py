"""Poses and Jacobians of mechanisms are the same bits in C and by numba, and for every class of sizes."""

import numpy as np
import pytest

from bladesmith import cga3d as cga
from bladesmith import errors, pga3d
from bladesmith import kinematics as kin
from bladesmith.codegen.programs.mechanisms.program import CLASSES, class_of
from bladesmith.kinematics.mechanism import driver, loop_calls
from bladesmith.kinematics.mechanism.poses.jacobians import METHODS

from ...support.build.numba_code import numba_text_as_python
from ...support.effort import FULL
from ...support.kinematics import STEWART, FourBar, four_bar, stewart


def bars(target, algebra=pga3d):
    """For numba in the algebra whose text is half as long; CGA's is compiled with all bars, by `test_ziglang.py`."""
    made = four_bar(FourBar().places(0.8), algebra)
    m = kin.Mechanism(made.bodies, made.fixed, target=target)
    for joint, name in zip(made.joints, made.joint_names, strict=True):
        m.add(joint, name)
    return m


def results(m):
    angles = np.array([0.1, 1.0, -2.0, np.nan, 1e5, np.inf])
    poses = m.solve_pose({"a": angles})
    path = m.solve_pose({"a": angles}, path=True)
    back = m.solve_pose(targets={"rocker": poses["rocker"], "coupler": ((1.0, 0.0, 0.0), np.ones((6, 3)))})
    found = [x for p in (poses, path, back) for x in (p.own, p.residual, np.asarray(p.status))]
    for method in METHODS:
        for inputs, outputs in (("a", ["c", "coupler"]), ("rocker", ["a", "coupler"])):
            found.append(m.jacobian(inputs, outputs, poses=poses, method=method, strict=False))
    return found


@pytest.mark.compiles
@pytest.mark.parametrize("algebra", [cga, pga3d], ids=["cga3d", "pga3d"])
def test_text_for_numba_has_the_bits_of_c(algebra):
    loop_calls.mechanism_loop.cache_clear()
    with numba_text_as_python():
        for one, other in zip(results(bars("c", algebra)), results(bars("numba", algebra)), strict=True):
            assert one.tobytes() == other.tobytes()
    loop_calls.mechanism_loop.cache_clear()


@pytest.mark.compiles
@pytest.mark.peers
@pytest.mark.skipif(not FULL, reason="no full bars: half a minute for text that runs as Python above")
def test_numba_has_the_bits_of_c():
    pytest.importorskip("numba")
    for one, other in zip(results(bars("c")), results(bars("numba")), strict=True):
        assert one.tobytes() == other.tobytes()


@pytest.mark.compiles
@pytest.mark.parametrize("algebra", [cga, pga3d], ids=["cga3d", "pga3d"])
def test_rooms_change_no_bit(algebra, monkeypatch):
    legs = {f"leg_{i}": np.array([0.1, -0.05 * i]) for i in range(6)}

    def run():
        m = stewart(*STEWART, algebra)
        poses = m.solve_pose(legs)
        assert not np.asarray(poses.status).any()
        found = [m.jacobian(list(legs), "top", poses=poses, method=method, strict=False) for method in METHODS]
        return [poses.own, poses.residual, *found]

    small = run()
    original = driver.mechanism_tables

    def roomy(needs):
        tables = original(needs)
        assert tables.room < CLASSES[2]
        object.__setattr__(tables, "room", CLASSES[2])  # where zeros of rows are skipped
        return tables

    monkeypatch.setattr(driver, "mechanism_tables", roomy)
    for one, other in zip(small, run(), strict=True):
        assert one.tobytes() == other.tobytes()


def test_classes():
    assert class_of(0) == CLASSES[0] and class_of(33) == CLASSES[1] and class_of(CLASSES[-1]) == CLASSES[-1]
    with pytest.raises(errors.InputError, match="9000 rows or columns"):
        class_of(9000)


def test_targets_are_named():
    with pytest.raises(errors.InputError, match="target"):
        kin.Mechanism(["a", "b"], "a", target="fortran")
    assert kin.Mechanism(["a", "b"], "a", target="numba").target == "numba"
