"""Poses of all links of robots, compiled, in batches: against matrices multiplied link by link, and 50 digits."""

import mpmath as mp
import numpy as np
import pytest

import bladesmith as bs
from bladesmith import kinematics
from bladesmith.codegen import algorithm
from bladesmith.codegen.algorithms.chain_records import Frame, Joint
from bladesmith.codegen.build import extension
from bladesmith.codegen.language import Ints, Matrix, Out, Reals, Rows, Vector
from bladesmith.codegen.programs.trees import pose_algorithm_of
from bladesmith.errors import InputError, ShapeError, SingularError
from bladesmith.kinematics.robots.description import BY_MOTOR, displacement
from bladesmith.kinematics.trees.poses import PoseDriver
from bladesmith.status import Status

from .texts import joint, link, robot

ALGEBRAS = [bs.cga3d, bs.pga3d]
ORIGIN = '<origin xyz="0.3 0.1 0.2" rpy="0.3 -0.2 0.5"/>'
#: Two branches, welded links, a follower, children before parents.
TREE = robot(
    "".join(link(x) for x in "abcdefgh")
    + joint("w", "fixed", "d", "h", ORIGIN) + joint("l", "continuous", "b", "d", ORIGIN + '<axis xyz="1 0 2"/>')
    + joint("j", "revolute", "a", "b", ORIGIN + '<axis xyz="0 1 1"/>')
    + joint("k", "prismatic", "b", "c", ORIGIN + '<axis xyz="1 0 0"/><mimic joint="j" multiplier="-2" offset="0.5"/>')
    + joint("v", "fixed", "a", "e", ORIGIN) + joint("m", "revolute", "e", "f", ORIGIN + '<axis xyz="0 0 -1"/>')
    + joint("n", "continuous", "c", "g", ORIGIN + '<axis xyz="1 1 1"/><mimic joint="k" multiplier="3"/>')
)  # fmt: skip


def truth(found, values, motors=None):
    """Poses (4, 4) by products of matrices."""
    frames, rest = {found.root: np.eye(4)}, list(found.joints.values())
    while rest:
        for one in [x for x in rest if x.parent in frames]:
            rest.remove(one)
            x = values.get(one.name, 0.0)
            moved = np.eye(4)
            if one.type in BY_MOTOR:
                moved = np.eye(4) if one.name not in motors else motors[one.name]
            elif one.type != "fixed":
                moved = displacement(one, x)
            frames[one.child] = frames[one.parent] @ one.origin @ moved
    return frames


def by_hand(j, l, m):  # noqa: E741
    return {"j": j, "l": l, "m": m, "k": 0.5 - 2 * j, "n": 3 * (0.5 - 2 * j)}


@pytest.mark.parametrize("algebra", ALGEBRAS, ids=lambda a: a.name)
def test_batches_of_trees(load, algebra):
    found = load(TREE, algebra)
    assert found.joint_names == ("l", "j", "m")
    q = np.random.default_rng(0).uniform(-3, 3, (2, 150, 3))
    poses = found.poses(q)
    assert list(poses) == list(found.links) and all(x.shape == (2, 150) for x in poses.values())
    matrices = {name: algebra.matrix(x) for name, x in poses.items()}
    for i in range(0, 300, 7):
        x = q.reshape(-1, 3)[i]
        for name, frame in truth(found, by_hand(x[1], x[0], x[2])).items():
            assert np.abs(matrices[name].reshape(-1, 4, 4)[i] - frame).max() < 1e-14
    one = found.poses(q[1, 3])
    assert all(np.array_equal(one[name].values, poses[name][1, 3].values) for name in found.links)
    named = found.poses({"j": q[..., 1], "m": q[:, :1, 2]})
    x = q[1, 5]
    for name, frame in truth(found, by_hand(x[1], 0.0, q[1, 0, 2])).items():
        assert np.abs(algebra.matrix(named[name][1, 5]) - frame).max() < 1e-14
    threaded = found.poses(np.tile(q, (1, 60, 1)), threads=2)
    assert all(np.array_equal(threaded[n].values[:, :150], poses[n].values) for n in found.links)


@pytest.mark.parametrize("algebra", ALGEBRAS, ids=lambda a: a.name)
def test_joints_that_take_motors(load, algebra):
    text = robot(
        "".join(link(x) for x in "abcde") + joint("j", "revolute", "a", "b", ORIGIN + '<axis xyz="0 1 1"/>')
        + joint("o", "floating", "b", "c", ORIGIN) + joint("k", "prismatic", "c", "d", ORIGIN + '<axis xyz="1 0 0"/>')
        + joint("p", "planar", "d", "e", ORIGIN + '<axis xyz="1 0 0"/>')
    )  # fmt: skip
    found = load(text, algebra)
    rng = np.random.default_rng(1)
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = turn * np.linalg.det(turn), rng.normal(size=3)
    motor = algebra.motor_from_matrix(matrix)
    x = rng.uniform(-2, 2, 6)
    poses = found.poses({"j": x, "k": 0.4, "o": motor})
    for i in range(6):
        for name, frame in truth(found, {"j": x[i], "k": 0.4}, {"o": matrix}).items():
            assert np.abs(algebra.matrix(poses[name])[i] - frame).max() < 1e-14
    assert found.poses()["e"].shape == ()
    with pytest.raises(InputError, match=r"q\['o'\]"):
        found.poses({"o": 3.0})


def test_coordinates_that_are_wrong(load):
    found = load(TREE)
    with pytest.raises(ShapeError, match=r"q has shape \(2,\); it ends in 3.*l, j, m; there is none for m"):
        found.poses([0.1, 0.2])
    with pytest.raises(ShapeError, match=r"q has shape \(\); it ends in 3"):
        found.poses(0.1)
    with pytest.raises(InputError, match="'i' is not a moving joint"):
        found.poses({"i": 0.1})
    with pytest.raises(InputError, match="one pose is needed"):
        found.mechanism(np.zeros((2, 3)))
    q = np.zeros((3, 3))
    q[1, 2] = np.nan
    poses = found.poses(q)
    assert poses["f"].status.tolist() == [0, Status.INVALID, 0] and np.isnan(poses["f"].values[1]).all()
    with pytest.raises(SingularError, match="item 1 is INVALID"):
        found.poses(q, strict=True)


def test_robots_without_moving_joints(load):
    found = load(robot(link("a") + link("b") + joint("w", "fixed", inside=ORIGIN)))
    poses = found.poses(np.zeros((4, 0)))
    assert poses["b"].shape == (4,)
    assert np.abs(bs.cga3d.matrix(found.poses()["b"]) - found.joints["w"].origin).max() < 1e-15
    assert load(robot(link("a"))).poses()["a"].shape == ()


@pytest.mark.compiles
@pytest.mark.parametrize("algebra", ALGEBRAS, ids=lambda a: a.name)
def test_every_target_has_the_same_bits_and_the_text_fifty_digits(load, algebra):
    parts = load(TREE, algebra)._link_poses._parts
    parameters = parts[0][-1]._driver.parameters
    q = np.random.default_rng(2).uniform(-2, 2, (9, 3))
    found = np.swapaxes(np.stack(parts[0][-1].poses(q, 1)), 0, 1)
    if extension.compiler() is not None:
        numba = PoseDriver(algebra.name, parameters, "numba").poses(q, 1)
        assert np.array_equal(found, np.swapaxes(np.stack(numba), 0, 1))
    inner, p = pose_algorithm_of(algebra.name, 16), parameters

    @algorithm
    def poses(
        joints: Rows[Joint], parents: Ints, coordinates: Ints, frames: Rows[Frame], carriers: Ints, base: Vector[3],
        x: Reals, motors: Out[Matrix[8, 8]],
    ) -> None:  # fmt: skip
        """All poses of one item."""
        inner(joints, parents, coordinates, frames, carriers, base, x, motors)

    with mp.workdps(50):
        exact = poses.reference(p.joints, p.parents, p.coordinates, p.frames, p.carriers, p.base, q[4], numbers=mp.mp)
        digits = np.array([float(x) for x in np.ravel(exact)]).reshape(8, 8)
    assert np.abs(found[4] - digits).max() < 1e-14


def test_chains_whose_joints_share_a_coordinate(load):
    text = robot(
        "".join(link(x) for x in "abcd") + joint("j", "revolute", "a", "b", ORIGIN + '<axis xyz="0 1 1"/>')
        + joint("k", "revolute", "b", "c", ORIGIN + '<axis xyz="1 0 0"/><mimic joint="j" multiplier="-2" offset="1"/>')
        + joint("m", "prismatic", "c", "d", ORIGIN + '<axis xyz="1 0 0"/>')
    )  # fmt: skip
    found = load(text)
    chain, whole = found.chain("d"), load(text, mimic="free").chain("d")
    assert (chain.names, chain.count, chain.joint_count) == (("j", "m"), 2, 3)
    q, qd = np.random.default_rng(4).uniform(-2, 2, (2, 5, 2))
    every = np.column_stack([q[:, 0], 1 - 2 * q[:, 0], q[:, 1]])
    speeds = np.column_stack([qd[:, 0], -2 * qd[:, 0], qd[:, 1]])
    for one, other in (
        (chain.forward(q), whole.forward(every)), (chain.forward(q, all=True), whole.forward(every, all=True)),
        (chain.velocity(q, qd), whole.velocity(every, speeds)),
        (chain.acceleration(q, qd, qd), whole.acceleration(every, speeds, speeds)),
    ):  # fmt: skip
        assert one.shape == other.shape and np.abs(one.values - other.values).max() < 1e-13
    matrix = whole.jacobian(every)
    expected = np.stack([matrix[..., 0] - 2 * matrix[..., 1], matrix[..., 2]], -1)
    assert np.abs(chain.jacobian(q) - expected).max() < 1e-13
    assert chain.freedom == 2 and chain.singularity(q).rank.tolist() == [2] * 5
    with pytest.raises(InputError, match="share coordinates.*solve_pose"):
        chain.inverse(chain.forward(q))
    with pytest.raises(InputError, match="'k' follows 'j', which may move other links"):
        chain.gravity_torques(q)
    seven = [kinematics.revolute_axis([i, 0, 0], [0, i % 2, 1]) for i in range(7)]
    shared = kinematics.Chain(seven, coordinates=[0, 1, 2, 3, 4, 5, 5])
    with pytest.raises(InputError, match="those of six axes, and this chain has 7"):
        shared.all_solutions(shared.forward(np.zeros(6)))
    axes = [kinematics.revolute_axis([0, 0, 0], [0, 0, 1])] * 2
    for wrong in ([0], [0, 2], [0.5, 0.5], "ab"):
        with pytest.raises(InputError, match="one index is needed for each of 2 joints"):
            kinematics.Chain(axes, coordinates=wrong)
