"""Algorithms of chains: the text with 50 digits against the compiled one, its derivative, and every instance."""

from __future__ import annotations

from collections.abc import Iterator

import mpmath as mp
import numpy as np
import pytest

import bladesmith as bs
from bladesmith.codegen import algorithm
from bladesmith.codegen.algorithms.chain_frames import JacobianFrame
from bladesmith.codegen.algorithms.chain_records import Frame, Goal, Joint, Search
from bladesmith.codegen.algorithms.chains import ChainAlgorithms, ChainKernels, chain_algorithms
from bladesmith.codegen.api import KernelFunction
from bladesmith.codegen.build import extension
from bladesmith.codegen.build.cpu_features import runs
from bladesmith.codegen.language import Int, IntVector, Matrix, Out, Real, Reals, Rows, Vector
from bladesmith.codegen.programs.chains import CLASSES, SHARED, algorithms_of, kernel_specs
from bladesmith.codegen.programs.kernel_spec import trace_spec
from bladesmith.codegen.targets.c.instances import BY_TAG, OF_KERNELS
from bladesmith.kinematics.serial import driver as chain_driver
from bladesmith.kinematics.serial.axes import prismatic_axis, revolute_axis, screw_axis
from bladesmith.kinematics.serial.chain import Chain
from bladesmith.kinematics.serial.driver import Driver

from ...support.build.numba_code import numba_text_as_python
from ...support.effort import FULL

pytestmark = pytest.mark.skipif(extension.compiler() is None, reason="no C compiler")
DIGITS = 50
ALGEBRAS = [bs.cga3d, bs.pga3d]
UP = (0.0, 0.0, 1.0)
NAMES = ("forward", "jacobian", "twists", "inverse")


@pytest.fixture(autouse=True)
def digits() -> Iterator[None]:
    with mp.workdps(DIGITS):
        yield


def mixed(algebra):
    """Four joints of all sorts."""
    axes = [
        revolute_axis([0.1, 0.2, 0.3], [0.1, 0.2, 1.0], algebra), prismatic_axis([1.0, 0.3, 0.2], algebra),
        screw_axis([0.5, 0.1, 0.4], [0.3, 1.0, 0.2], 0.4, algebra), revolute_axis([0.9, 0.2, 0.1], UP, algebra),
    ]  # fmt: skip
    return Chain(axes, algebra.translator([1.2, 0.1, 0.4]) * algebra.rotor([0.3, 0.2, 1.0], 0.8))


def six(algebra):
    """Six axes as those of common arms, three of them parallel."""
    positions = [[0, 0, 0.1], [0, 0.1, 0.1], [0.4, 0.1, 0.1], [0.8, 0.1, 0.1], [0.8, 0.2, 0.1], [0.8, 0.2, 0]]
    directions = [[0, 0, 1], [0, 1, 0], [0, 1, 0], [0, 1, 0], [0, 0, -1], [0, 1, 0]]
    return Chain(revolute_axis(positions, directions, algebra), algebra.translator([0.8, 0.3, 0.0]))


def seven(algebra):
    """Seven axes in turn, within limits."""
    positions = [[0, 0, 0.1 + 0.2 * j] for j in range(7)]
    directions = [[0, j % 2, (j + 1) % 2] for j in range(7)]
    return Chain(
        revolute_axis(positions, directions, algebra), algebra.translator([0, 0, 1.6]), limits=[[-2.5, 2.5]] * 7
    )


def slides(algebra):
    """Three translations and a wrist."""
    axes = [*(prismatic_axis(d, algebra) for d in np.eye(3)), *(revolute_axis(UP, d, algebra) for d in np.eye(3))]
    return Chain(axes, algebra.translator([0.1, 0.2, 1.3]))


CHAINS = {"mixed": mixed, "six": six, "seven": seven, "slides": slides}


class Whole:
    """The algorithms with results of fixed sizes, for chains of four joints."""

    def __init__(self, parts: ChainAlgorithms) -> None:
        forward, jacobian, twists, inverse = parts.forward, parts.jacobian, parts.twists, parts.inverse

        @algorithm
        def pose(joints: Rows[Joint], tool: Rows[Frame], base: Vector[3], x: Reals, motor: Out[Matrix[1, 8]]) -> None:
            """The motor of the tool."""
            forward(joints, tool, base, x, motor)

        @algorithm
        def matrix(
            joints: Rows[Joint], tool: Frame, base: Vector[3], frame: Int, point: Vector[3], x: Reals,
            columns: Out[Vector[24]],
        ) -> None:  # fmt: skip
            """The Jacobian."""
            jacobian(joints, tool, base, frame, point, x, columns)

        @algorithm
        def links(
            joints: Rows[Joint], base: Vector[3], x: Reals, dx: Reals, ddx: Reals,
            velocities: Out[Matrix[4, 6]], rates: Out[Matrix[4, 6]],
        ) -> None:  # fmt: skip
            """Twists of all links."""
            twists(joints, base, x, dx, ddx, velocities, rates)

        @algorithm
        def search(
            joints: Rows[Joint], tool: Frame, base: Vector[3], limits: Rows[2], restarts: Reals, poses: Rows[Goal],
            options: Search, motor: Vector[8], start: Reals, x: Out[Vector[4]], counts: Out[IntVector[3]],
        ) -> tuple[Real, Real]:  # fmt: skip
            """Coordinates, status, steps and rank; what remains."""
            status, angle, distance, steps, rank = inverse(
                joints, tool, base, limits, restarts, poses, options, 60, 0, motor, start, x
            )
            counts[:] = (status, steps, rank)
            return angle, distance

        self.pose, self.matrix, self.links, self.search = pose, matrix, links, search


@pytest.fixture(scope="module", params=ALGEBRAS, ids=lambda a: a.name)
def case(request):
    chain = mixed(request.param)
    return Whole(algorithms_of(request.param.name, CLASSES[0])), chain, chain.parameters


def error(found, precise):
    return max(abs(mp.mpf(float(f)) - p) for f, p in zip(np.ravel(found), np.ravel(precise), strict=True))


def test_poses_jacobians_and_twists_with_fifty_digits(case):
    whole, chain, p = case
    q, dq, ddq = np.random.default_rng(0).uniform(-2, 2, (3, 4))
    exact = whole.pose.reference(p.joints, p.tool[None], p.base, q, numbers=mp.mp)
    assert isinstance(exact[0, 0], mp.mpf) and error(chain.forward(q).values, exact) < 1e-14
    point = np.array([0.3, -0.2, 0.1])
    for frame, found in (
        (JacobianFrame.ORIGIN, chain.jacobian(q)), (JacobianFrame.POINT, chain.jacobian(q, point=point)),
        (JacobianFrame.TOOL, chain.jacobian(q, "tool", point)),
    ):  # fmt: skip
        columns = whole.matrix.reference(p.joints, p.tool, p.base, int(frame), point, q, numbers=mp.mp)
        assert error(found, columns) < 2e-14
    velocities, rates = whole.links.reference(p.joints, p.base, q, dq, ddq, numbers=mp.mp)
    assert error(chain.velocity(q, dq, all=True).values, velocities) < 2e-14
    assert error(chain.acceleration(q, dq, ddq, all=True).values, rates) < 1e-13


@pytest.mark.slow
def test_the_search_with_fifty_digits(case):
    whole, chain, p = case
    q = np.array([0.4, 0.3, -0.5, 0.6])
    start = q + 0.2
    goal = chain.forward(q)
    found = chain.inverse(goal, start=start, attempts=1)
    options = np.array([1e-12, chain.length, np.inf])
    limits = np.tile([-np.inf, np.inf], (4, 1))
    x, counts, angle, distance = whole.search.reference(
        p.joints, p.tool, p.base, limits, np.empty(0), np.empty((0, 7)), options, goal.values, start, numbers=mp.mp
    )
    assert counts.tolist() == [0, found.steps, 4]
    assert error(found.q, x) < 1e-14 and error(q, x) < 1e-14
    assert angle < 1e-13 and distance < 1e-13  # of the motor, which is rounded


@pytest.mark.compiles
@pytest.mark.parametrize("kind", list(CHAINS))
@pytest.mark.parametrize("algebra", ALGEBRAS, ids=lambda a: a.name)
def test_text_for_numba_has_the_bits_of_c(algebra, kind):
    chain_driver._loop.cache_clear()
    with numba_text_as_python():
        assert_same_bits(algebra, kind, 3)
    chain_driver._loop.cache_clear()


@pytest.mark.peers
@pytest.mark.compiles
@pytest.mark.skipif(not FULL, reason="no full bars: a quarter of a minute for text that runs as Python above")
@pytest.mark.parametrize("kind", list(CHAINS))
@pytest.mark.parametrize("algebra", ALGEBRAS, ids=lambda a: a.name)
def test_numba_has_the_bits_of_c(algebra, kind):
    pytest.importorskip("numba")
    assert_same_bits(algebra, kind, 60)


def assert_same_bits(algebra, kind, count):
    """Of so many poses."""
    chain = CHAINS[kind](algebra)
    other = Chain(chain.axes, chain.tool, limits=chain.limits, target="numba")
    q, dq, ddq = np.random.default_rng(5).uniform(-2, 2, (3, count, chain.count))
    for every in (False, True):
        assert chain.forward(q, every).values.tobytes() == other.forward(q, every).values.tobytes()
        a, b = (c.acceleration(q, dq, ddq, every).values for c in (chain, other))
        assert a.tobytes() == b.tobytes()
    point = np.array([0.3, 0.2, 0.1])
    for options in ({}, {"point": point}, {"frame": "tool", "point": np.tile(point, (count, 1))}):
        assert chain.jacobian(q, **options).tobytes() == other.jacobian(q, **options).tobytes()
    far = algebra.translator([30.0, 0.0, 0.0]) * chain.forward(q[:5])
    for targets, nearest in ((chain.forward(q), False), (far, True), (far, False)):
        a, b = (c.inverse(targets, attempts=4, nearest=nearest, threads=2) for c in (chain, other))
        for name in ("q", "status", "angle", "distance", "steps"):
            assert getattr(a, name).tobytes() == getattr(b, name).tobytes()


def differentiable_pose(algebra):
    """The pose of a chain by kernels that have derivatives."""
    kernels = {}
    for name, spec in kernel_specs(algebra.name).items():
        kinds = [i.kind for i in trace_spec(spec).inputs]
        kernels[name] = KernelFunction(spec.formula, kinds, None, spec.name, kinds[0].algebra, search=False)
    identity = tuple(float(not blade) for blade in algebra.kind("rotor").blades)
    return Whole(chain_algorithms(ChainKernels(**kernels), identity, CLASSES[0])).pose


@pytest.mark.compiles
def test_the_gradient_of_a_number_of_the_pose():
    """Against tangents along each of seven joints, and their records."""
    algebra, rng = bs.pga3d, np.random.default_rng(6)
    chain = Chain(revolute_axis(*rng.normal(size=(2, 7, 3)), algebra), algebra.translator([0.8, 0.3, 0.0]))
    pose, p = differentiable_pose(algebra), chain.parameters
    given = (p.joints, p.tool[None], p.base, rng.uniform(-2, 2, (9, 7)))
    weights = rng.normal(size=(9, 1, 8))
    d_joints, d_x = pose.vjp(*given, wrt=("joints", "x"))(weights)
    expected = [(pose.derivative("x")(*given, along)[1] * weights).sum((1, 2)) for along in np.eye(7)]
    assert np.abs(d_x - np.array(expected).T).max() < 1e-14 * np.abs(expected).max()
    along = rng.normal(size=p.joints.shape)
    expected = (pose.derivative("joints")(*given, along)[1] * weights).sum()
    assert abs((d_joints * along).sum() - expected) < 1e-12 * np.abs(d_joints * along).sum()


@pytest.mark.compiles
@pytest.mark.parametrize("algebra", ALGEBRAS, ids=lambda a: a.name)
def test_the_derivative_of_poses_is_the_jacobian(algebra):
    """From dM = -S M / 2, where S is the twist of a column."""
    chain = mixed(algebra)
    pose = differentiable_pose(algebra)
    p, q = chain.parameters, np.random.default_rng(2).uniform(-2, 2, (5, 4))
    motors = chain.forward(q)
    for j in range(4):
        found, rates = pose.derivative("x")(p.joints, p.tool[None], p.base, q, np.eye(4)[j])
        assert found[:, 0].tobytes() == motors.values.tobytes()
        twist = -2 * algebra.wrap(algebra.kind("motor"), np.ascontiguousarray(rates[:, 0])) * ~motors
        column = chain.jacobian(q)[:, :, j]
        expected = bs.dynamics.twist(column[:, :3], column[:, 3:], algebra=algebra)
        assert np.abs((twist.as_kind("twist", check=False) - expected).values).max() < 1e-13


@pytest.mark.compiles
@pytest.mark.parametrize("tag", ["f64_scalar", *(i.tag for i in OF_KERNELS if i.bits == 64 and runs(i))])
def test_every_instance_gives_the_same_bits(case, tag):
    _, chain, p = case
    driver, q = Driver(chain.algebra.name, p, instance=BY_TAG[tag]), np.random.default_rng(3).uniform(-2, 2, (103, 4))
    points = np.random.default_rng(4).normal(size=(103, 3))
    for every in (False, True):
        assert driver.forward(q, every, 1).tobytes() == chain.driver.forward(q, every, 1).tobytes()
        for found, expected in zip(
            driver.twists(q, q, q, every, 1), chain.driver.twists(q, q, q, every, 1), strict=True
        ):
            assert found.tobytes() == expected.tobytes()
    for frame in JacobianFrame:
        for at in (points, points[0]):
            assert driver.jacobian(q, frame, at, 1).tobytes() == chain.driver.jacobian(q, frame, at, 1).tobytes()


def test_what_items_share_are_parameters():
    for name, shared in SHARED.items():
        parameters = [p.name for p in getattr(algorithms_of("cga3d", CLASSES[0]), name).text.parameters]
        assert list(shared) == parameters[: len(shared)]
