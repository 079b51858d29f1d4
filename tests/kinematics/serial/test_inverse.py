"""Coordinates of serial chains for poses to reach: near and far, at singular poses, out of reach, in batches."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import bladesmith as bs
from bladesmith.codegen.programs.chains import CLASSES
from bladesmith.dynamics import screw_coordinates, twist
from bladesmith.errors import AlgebraMismatchError, GradeError, InputError, Interrupted, ShapeError, SingularError
from bladesmith.kinematics.serial.axes import prismatic_axis, revolute_axis
from bladesmith.kinematics.serial.chain import Chain
from bladesmith.status import Status

from ...support.mechanisms.chains import ALGEBRAS, UP, arm, mixed

# -- inverse ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("algebra", ALGEBRAS, ids=lambda a: a.name)
@pytest.mark.parametrize(
    ("scale", "center"), [(1.0, (0, 0, 0)), (1.0, (6e3, -7e3, 4e3)), (1e-6, (0, 0, 0)), (1e3, (0, 0, 0))]
)
def test_inverse_reaches_poses(algebra, scale, center):
    chain = arm(algebra, scale, center)
    q = np.random.default_rng(0).uniform(-2, 2, (100, 6))
    targets = chain.forward(q)
    near = chain.inverse(targets, q + 0.05)
    assert (near.status == 0).all()
    exact = 1e-10 + 1e-14 * np.abs(center).max() / scale * 1e3  # where the axes themselves are rounded
    good = chain.singularity(q).singular_values[:, -1] > 1e-2
    assert good.sum() > 50
    assert np.abs(near.q - q)[good].max() < exact
    far = chain.inverse(targets)
    assert (far.status == 0).all()
    assert far.angle.max() < 2e-14 and far.distance.max() < 2e-14 * chain.length  # what rounding leaves
    turned_over = chain.inverse(algebra.wrap(targets.kind, -targets.values), q + 0.05)  # R and -R are one pose
    assert (turned_over.q == near.q).all()
    error = algebra.matrix(chain.forward(far.q)) - algebra.matrix(targets)
    assert np.abs(error[:, :3, :3]).max() < 1e-12
    assert np.abs(error[:, :3, 3]).max() < 1e-12 * (scale + np.abs(center).max())


@pytest.mark.parametrize("algebra", ALGEBRAS, ids=lambda a: a.name)
@pytest.mark.parametrize("nearest", [False, True])
def test_poses_have_the_same_bits_in_batches_of_any_size(algebra, nearest):
    """Near, far, singular, out of reach, not a number: on lanes, their paths part."""
    chain, rng = arm(algebra), np.random.default_rng(3)
    q = rng.uniform(-2.5, 2.5, (61, 6))
    q[::7, 2], q[::5, 4] = 0.0, 0.0
    values = chain.forward(q).values.copy()
    moved = algebra.translator([0.0, 0.0, 9.0]) * chain.forward(q[::11])
    values[::11] = moved.as_kind("motor").values
    values[13] = np.nan
    targets, starts = algebra.wrap(algebra.kind("motor"), values), q + rng.normal(scale=0.2, size=q.shape) * (q > 0.5)
    whole = chain.inverse(targets, starts, attempts=6, nearest=nearest)
    assert {int(s) for s in whole.status} >= {Status.OK, Status.INVALID}
    for size in (1, 5, 6, 13):
        for begin in range(0, len(q), size):
            part = slice(begin, begin + size)
            found = chain.inverse(targets[part], starts[part], attempts=6, nearest=nearest)
            for name in ("q", "status", "angle", "distance", "steps", "rank"):
                if hasattr(whole, name):
                    assert getattr(found, name).tobytes() == getattr(whole, name)[part].tobytes(), (name, size)


def test_targets_in_single_precision():
    chain = arm()
    targets = chain.forward(np.random.default_rng(8).uniform(-1, 1, (5, 6)))
    single = chain.inverse(targets.astype(np.float32), tolerance=1e-6)
    assert (single.status == 0).all()
    assert np.abs(chain.forward(single.q).values - targets.values).max() < 1e-5


def test_inverse_of_mixed_chains():
    for seed in range(4):
        chain, q = mixed(bs.cga3d, seed, count=7)
        q, status = chain.inverse(chain.forward(q), q + 0.1)
        assert np.isin(status, (0, 3)).all()


def test_inverse_stays_within_limits():
    limits = np.array([[-1, 1], [-1.5, 0.2], [0.1, 2.0], [-2, 2], [-1, 1], [0.2, 0.3]])
    chain = arm(limits=limits)
    q = np.random.default_rng(1).uniform(limits[:, 0], limits[:, 1], (60, 6))
    found = chain.inverse(chain.forward(q))
    reached = found.status == 0
    assert reached.mean() > 0.9
    assert (found.q[reached] >= limits[:, 0]).all() and (found.q[reached] <= limits[:, 1]).all()
    assert np.abs(chain.forward(found.q[reached]).values - chain.forward(q[reached]).values).max() < 1e-11
    outside = q.copy()
    outside[:, 5] += 2.5  # another roll than any that is allowed, with most others
    beyond = chain.inverse(chain.forward(outside), nearest=True)
    assert (beyond.q >= limits[:, 0]).all() and (beyond.q <= limits[:, 1]).all()
    resting = np.flatnonzero(beyond.status == bs.Status.NOT_CONVERGED)  # within all lengths: nothing is proved
    assert len(resting) > 20
    poses, goals = (bs.cga3d.matrix(chain.forward(x[resting])) for x in (beyond.q, outside))
    j = chain.jacobian(beyond.q[resting], point=np.zeros(3)) / np.repeat([1, chain.length], 3)[:, None]
    for x, now, goal, matrix in zip(beyond.q[resting], poses, goals, j, strict=True):
        turn = Rotation.from_matrix(goal[:3, :3] @ now[:3, :3].T).as_rotvec()
        missing = np.concatenate([turn, (goal[:3, 3] - now[:3, 3]) / chain.length])
        pull = missing @ matrix
        free = (x > limits[:, 0]) & (x < limits[:, 1])
        assert np.abs(pull[free]).max(initial=0) < 1e-3 * np.linalg.norm(missing)  # nothing more to gain
        assert (pull[x >= limits[:, 1]] > -1e-3).all() and (pull[x <= limits[:, 0]] < 1e-3).all()


def test_what_is_out_of_reach_says_so():
    chain = arm()
    far = bs.cga3d.translator([[5.0, 0, 0], [0.6, 0.2, 0.8]]).as_kind("motor")
    found = chain.inverse(far)
    assert found.status.tolist() == [bs.Status.UNREACHABLE, bs.Status.OK]
    assert np.isnan(found.q[0]).all() and found.steps[0] == 0
    nearest = chain.inverse(far, nearest=True)
    assert nearest.status[0] == bs.Status.UNREACHABLE
    place = bs.cga3d.matrix(chain.forward(nearest.q[0]))[:3, 3]
    assert 0 < nearest.distance[0] < 5 and np.isfinite(place).all()
    with pytest.raises(SingularError, match="item 0 is UNREACHABLE"):
        chain.inverse(far, strict=True)
    # within all lengths, and still nowhere: the wrist cannot be inside the base's hollow, turned so
    planar = Chain(revolute_axis([[0, 0, 0], [1, 0, 0]], UP), bs.cga3d.translator([1.5, 0, 0]))
    assert planar.inverse(bs.cga3d.translator([0.1, 0, 0])).status == bs.Status.UNREACHABLE
    assert planar.inverse(bs.cga3d.translator([1.2, 0, 0.3])).status == bs.Status.UNREACHABLE


def test_targets_that_are_not_unit():
    chain = arm()
    target = chain.forward(np.full(6, 0.4))
    scales = [1.0, 1 + 1e-12, -1.0, 1 + 1e-7, 2.0, 0.5, 1e-3, 1e3, 0.0]
    scaled = bs.cga3d.wrap(target.kind, np.outer(scales, target.values))
    found = chain.inverse(scaled, np.full(6, 0.3))
    assert found.status.tolist()[:3] == [0, 0, 0]
    assert found.status[3] == bs.Status.NOT_CONVERGED
    assert (found.status[4:] == bs.Status.INVALID).all() and np.isnan(found.q[3:]).all()
    with pytest.raises(SingularError, match="INVALID"):
        chain.inverse(scaled[4], np.full(6, 0.3), strict=True)


def test_targets_that_are_none():
    chain = arm()
    targets = chain.forward(np.full((3, 6), 0.4))
    data = targets.values.copy()
    data[1] = np.nan
    found = chain.inverse(bs.cga3d.wrap(targets.kind, data), 0.3 * np.ones((3, 6)))
    assert found.status.tolist() == [0, bs.Status.INVALID, 0]
    start = np.full((3, 6), 0.3)
    start[2, 0] = np.inf
    assert chain.inverse(targets, start).status.tolist() == [0, 0, bs.Status.INVALID]
    one = chain.inverse(targets[0], start[0])
    assert one.status is bs.Status.OK and one.q.shape == (6,)
    assert chain.inverse(targets[0], iterations=1, attempts=1).status == bs.Status.NOT_CONVERGED


def test_singular_poses_are_reached_and_named():
    chain = arm()
    q = np.array([0.3, -0.4, 0.9, 0.5, 0.0, 0.2])  # the wrist's first and last axes are one line
    found = chain.inverse(chain.forward(q), q + 0.02)
    assert found.status is bs.Status.NOT_UNIQUE
    assert np.abs(chain.forward(found.q).values - chain.forward(q).values).max() < 1e-11
    regular = q + [0, 0, 0, 0, 0.7, 0]
    assert chain.inverse(chain.forward(regular), regular + 0.02).status is bs.Status.OK


def test_four_joints_reach_what_they_can():
    places = [[0, 0, 0], [0.3, 0, 0], [0.55, 0, 0]]
    axes = [revolute_axis(p, UP) for p in places]
    scara = Chain([axes[0], axes[1], prismatic_axis([0, 0, -1]), axes[2]], bs.cga3d.translator([0.55, 0, -0.1]))
    assert scara.freedom == 4
    q = np.random.default_rng(2).uniform(-1.5, 1.5, (50, 4))
    found = scara.inverse(scara.forward(q), q + 0.1)
    assert np.isin(found.status, (0, 3)).all()
    assert np.abs(scara.forward(found.q).values - scara.forward(q).values).max() < 1e-12
    tilted = scara.forward(q[0]) * bs.cga3d.rotor([1, 0, 0], 0.1)
    assert scara.inverse(tilted.as_kind("motor"), q[0]).status is bs.Status.UNREACHABLE


def test_more_joints_than_needed():
    chain, q = mixed(bs.pga3d, 8, count=9)
    assert chain.freedom == 6
    found = chain.inverse(chain.forward(q))
    assert np.isin(found.status, (0, 3)).all()
    assert found.angle.max() < 1e-12 and found.distance.max() < 1e-12 * chain.length


# -- singular poses --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("algebra", ALGEBRAS, ids=lambda a: a.name)
def test_what_is_lost_at_singular_poses(algebra):
    chain = arm(algebra)
    q = np.array([[0.3, -0.4, 0.9, 0.5, 0.0, 0.2], [0.3, -0.4, 0.9, 0.5, 0.8, 0.2]])
    found = chain.singularity(q)
    assert found.rank.tolist() == [5, 6] and found.singular.tolist() == [True, False]
    assert found.manipulability[0] < 1e-15 < 1e-4 < found.manipulability[1]
    j = chain.jacobian(q)
    assert np.abs(j[0] @ found.null_rates[0]).max() < 1e-15
    assert np.abs(np.abs(found.null_rates[0][[3, 5]]) - np.sqrt(0.5)).max() < 1e-12
    # no joint rates give it, not even in part: one more column, and the rank is full
    lost = screw_coordinates(found.lost_twist)[0]
    assert np.linalg.matrix_rank(np.column_stack([j[0], lost]), 1e-9) == 6
    place = algebra.matrix(chain.forward(q[0]))[:3, 3]
    about = np.concatenate([lost[:3], (lost[3:] - np.cross(place, lost[:3])) / chain.length])
    own = chain.jacobian(q[0], point=np.zeros(3)) / np.repeat([1, chain.length], 3)[:, None]
    assert np.abs(about @ own).max() < 1e-14 and abs(np.linalg.norm(about) - 1) < 1e-12


def test_a_stretched_arm_cannot_move_outwards():
    stretched = Chain(revolute_axis([[0, 0, 0], [1, 0, 0]], UP), bs.cga3d.translator([2.0, 0, 0]))
    found = stretched.singularity([0.4, 0.0])
    assert found.rank == 2 and not found.singular  # two turns about parallel axes are never the same
    planar = Chain(revolute_axis([[0, 0, 0], [1, 0, 0], [2, 0, 0]], UP), bs.cga3d.translator([2.5, 0, 0]))
    found = planar.singularity([0.4, 0.0, 0.0])
    assert planar.freedom == 3 and found.rank == 2 and found.singular
    w, v = np.split(screw_coordinates(found.lost_twist), 2)
    along = np.array([np.cos(0.4), np.sin(0.4), 0])
    assert np.abs(w).max() < 1e-12
    assert abs(abs(v @ along) / np.linalg.norm(v) - 1) < 1e-12


# -- bad input ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("make", "error", "words"),
    [
        (lambda: Chain([]), InputError, "at least one joint"),
        (lambda: Chain(3), InputError, "revolute_axis"),
        (lambda: Chain([0 * revolute_axis([0, 0, 0], UP)]), InputError, "axis of joint_1 .joint 0. is zero"),
        (lambda: Chain([revolute_axis([0, 0, 0], UP), revolute_axis([0, 0, 0], [0, 0, 0])]), InputError, "joint_2"),
        (lambda: Chain([bs.cga3d.point([0, 0, 0])]), GradeError, "axis 0"),
        (lambda: Chain([bs.cga3d.circle([0, 0, 0], UP, 1.0)]), GradeError, "not a line"),
        (lambda: Chain([revolute_axis([0, 0, 0], UP), revolute_axis([0, 0, 0], UP, bs.pga3d)]), AlgebraMismatchError,
         "axis 1"),
        (lambda: arm(names=["a", "b"]), ShapeError, "2 names for 6"),
        (lambda: arm(names=["a"] * 6), InputError, "two joints are called 'a'"),
        (lambda: arm(limits=[[0, 1]] * 5), ShapeError, "limits"),
        (lambda: arm(limits=[[0, 1]] * 5 + [[2, 1]]), InputError, "joint_6"),
        (lambda: arm(limits=[[0, np.nan]] * 6), InputError, "joint_1"),
        (lambda: arm(length=0.0), InputError, "length"),
        (lambda: Chain(revolute_axis([0, 0, 0], UP)), ShapeError, "shape"),
        (lambda: Chain([revolute_axis([0, 0, 0], UP)], bs.cga2d.translator([0, 0])), AlgebraMismatchError, "tool"),
        (lambda: Chain([revolute_axis([0, 0, 0], UP)], target="opencl"), InputError, "one of c, numba, cuda"),
        (lambda: Chain([revolute_axis([0, 0, 0], UP)] * (CLASSES[-1] + 1)).forward(np.zeros(CLASSES[-1] + 1)),
         InputError, "longer than the longest"),
        (lambda: arm().forward([1, 2]), ShapeError, "q has shape"),
        (lambda: arm().forward(["a"] * 6), InputError, "q"),
        (lambda: arm().forward([np.nan] * 6, strict=True), SingularError, "INVALID"),
        (lambda: arm().jacobian(np.zeros(6), "base"), InputError, "frame"),
        (lambda: arm().jacobian([np.inf] * 6, strict=True), SingularError, "INVALID"),
        (lambda: arm().jacobian(np.zeros((2, 6)), point=np.zeros((3, 3))), ShapeError, "point"),
        (lambda: arm().velocity(np.zeros((2, 6)), np.zeros((3, 6))), ShapeError, "dq"),
        (lambda: arm().inverse(np.eye(3)), ShapeError, "targets"),
        (lambda: arm().inverse("home"), InputError, "the targets is .*a motor, or an array"),
        (lambda: arm().inverse(bs.cga3d.point([0, 0, 0])), GradeError, "not a motor"),
        (lambda: arm().inverse(arm().tool, attempts=0), InputError, "attempts"),
        (lambda: arm().inverse(arm().tool, iterations=1.5), InputError, "iterations"),
        (lambda: arm().inverse(arm().tool, iterations=2**70), InputError, "iterations"),
        (lambda: arm().inverse(arm().tool, attempts=2**40), InputError, "attempts"),
        (lambda: arm().inverse(arm().tool, tolerance=-1), InputError, "tolerance"),
        (lambda: revolute_axis([0, 0, 0], [0, 0, 0], strict=True), SingularError, "INVALID"),
    ],
)  # fmt: skip
def test_bad_input(make, error, words):
    with pytest.raises(error, match=words):
        make()


def test_coordinates_that_are_not_finite_are_marked():
    chain = arm()
    q = np.zeros((3, 6))
    q[1, 2] = np.inf
    poses = chain.forward(q)
    assert poses.status.tolist() == [0, bs.Status.INVALID, 0]
    assert np.isnan(poses.values[1]).all() and np.isfinite(poses.values[[0, 2]]).all()
    j, status = chain.jacobian(q, status=True)
    assert status.tolist() == [0, bs.Status.INVALID, 0] and np.isfinite(j[[0, 2]]).all()
    assert chain.velocity(q, q).status.tolist() == [0, bs.Status.INVALID, 0]
    found = chain.singularity(q)
    assert np.isnan(found.singular_values[1]).all() and np.isfinite(found.singular_values[[0, 2]]).all()
    bad = revolute_axis([[0, 0, 0], [0, 0, 0]], [[0, 0, 0], UP])
    assert bad.status.tolist() == [bs.Status.INVALID, 0] and np.isnan(bad.values[0]).all()
    assert (prismatic_axis(UP) - twist(0, UP)).values.max() == 0


# -- many targets ----------------------------------------------------------------------------------------------


def test_workers_of_an_executor_find_the_same_bits(monkeypatch):
    monkeypatch.setattr("bladesmith.kinematics.serial.inverse.TARGETS_PER_CALL", 8)
    chain = arm()
    targets = chain.forward(np.random.default_rng(3).uniform(-1, 1, (40, 6)))
    here, told = chain.inverse(targets), []
    with ThreadPoolExecutor(2) as pool:
        there = chain.inverse(targets, executor=pool, progress=told.append)
    for name in ("q", "status", "angle", "distance", "steps"):
        np.testing.assert_array_equal(getattr(here, name), getattr(there, name))
    assert [p.done for p in told] == [8, 16, 24, 32, 40] and told[0].unit == "targets"


def test_an_interrupt_keeps_the_targets_that_were_reached(monkeypatch):
    def stop(progress):
        raise KeyboardInterrupt

    chain = arm()
    targets = chain.forward(np.random.default_rng(4).uniform(-1, 1, (200, 6)))
    with pytest.raises(Interrupted) as caught:
        chain.inverse(targets, threads=1, progress=stop)
    q, status = caught.value.partial
    found, codes = chain.inverse(targets)
    done = np.isfinite(q).all(-1)
    assert 0 < done.sum() < 200 and (status[~done] == Status.NOT_CONVERGED).all()
    np.testing.assert_array_equal(q[done], found[done])
    np.testing.assert_array_equal(status[done], codes[done])


@pytest.mark.slow
def test_poses_of_an_arm_with_seven_joints_and_limits_are_found():
    """Of 10 000 none is missed, half of the attempts from zero come to rest at limits."""
    rows = [[0, -90, 0.36, 0], [0, 90, 0, 0], [0, 90, 0.42, 0], [0, -90, 0, 0], [0, -90, 0.4, 0], [0, 90, 0, 0],
            [0.08, 0, 0.126, 0]]  # fmt: skip
    limits = np.radians([[-170, 170], [-10, 120], [-170, 170], [-120, -5], [-170, 170], [0, 120], [-175, 175]])
    arm = Chain.from_dh(rows, angles="degrees", limits=limits)
    q = np.random.default_rng(3).uniform(*limits.T, (10000, 7))
    poses = arm.forward(q)
    first = np.asarray(arm.inverse(poses, attempts=1).status)
    assert (first == bs.Status.NOT_CONVERGED).sum() > 1000
    found = arm.inverse(poses)
    assert np.isin(found.status, (bs.Status.OK, bs.Status.NOT_UNIQUE)).all()
    assert (found.q >= limits[:, 0]).all() and (found.q <= limits[:, 1]).all()
    assert max(found.angle.max(), found.distance.max() / arm.length) < 2e-12


@pytest.mark.slow
def test_the_nearest_pose_is_the_least_of_many_minimizations():
    """Out of reach, within limits: beside SciPy's bounded minimization from 15 starts."""
    from scipy.optimize import minimize

    rows = [[0, -90, 0.3, 0], [0.5, 0, 0, 0], [0.4, 0, 0.1, 0]]
    arm = Chain.from_dh(rows, angles="degrees", limits=[[-1.5, 1.5], [-1.0, 0.4], [-2.0, -0.2]])
    rng = np.random.default_rng(5)
    goals = bs.cga3d.translator(rng.uniform(-1, 1, (4, 3)) * 1.2) * bs.cga3d.rotor(rng.normal(size=(4, 3)), 1.0)
    found = arm.inverse(goals.as_kind("motor"), nearest=True)
    matrices = bs.cga3d.matrix(goals)

    def cost(q, goal):
        pose = bs.cga3d.matrix(arm.forward(q))
        turn = pose[:3, :3].T @ goal[:3, :3]
        angle = np.arctan2(
            np.linalg.norm([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]]),
            np.trace(turn) - 1,
        )
        return angle**2 + ((pose[:3, 3] - goal[:3, 3]) ** 2).sum() / arm.length**2

    for i, goal in enumerate(matrices):
        starts = rng.uniform(*arm.limits.T, (15, 3))
        least = min(minimize(cost, q, goal, bounds=arm.limits, method="L-BFGS-B").fun for q in starts)
        assert found.status[i] != bs.Status.OK
        assert found.angle[i] ** 2 + (found.distance[i] / arm.length) ** 2 == pytest.approx(least, rel=1e-5)
        assert cost(found.q[i], goal) == pytest.approx(least, rel=1e-5)


# -- axes that meet --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("algebra", ALGEBRAS, ids=lambda a: a.name)
def test_axes_that_meet_in_a_point_have_no_distance(algebra):
    """Rounding of where they are is no unit of length, and poses are not out of its reach."""
    motor = algebra.translator((0.1, -0.2, 0.3)) * algebra.rotor((1, 2, 3), 0.7)
    axes = [motor >> revolute_axis((0, 0, 0), axis, algebra) for axis in ((0, 0, 1), (0.1, 1, 0), (1, 0.2, 0.1))]
    chain = Chain(axes, tool=motor)
    assert chain.length == 1
    found = chain.inverse(chain.forward(np.random.default_rng(0).uniform(-1, 1, (1000, 3))))
    assert (found.status == 0).all() and found.angle.max() < 1e-14


def test_what_is_ok_is_within_the_tolerance_at_limits():
    """The last step goes down to rounding, and does not leave what was reached."""
    motor = bs.cga3d.translator((0.1, -0.2, 0.3)) * bs.cga3d.rotor((1, 2, 3), 0.7)
    axes = [motor >> axis for axis in (prismatic_axis((1, 2, 3)), revolute_axis((0, 0, 0), (1, 2, 3)))]
    rng = np.random.default_rng(1)
    q = np.column_stack([rng.uniform(-1, 2, 1000), np.where(rng.random(1000) < 0.5, -1.0, 2.0)])
    for length in (None, 1e-15):
        chain = Chain(axes, tool=motor, limits=[(-1, 2), (-1, 2)], length=length)
        found = chain.inverse(chain.forward(q))
        good = found.status == 0
        assert found.angle[good].max(initial=0) < 1e-9
        assert good.all() or length is not None
