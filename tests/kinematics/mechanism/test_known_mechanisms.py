"""Known mechanisms against what engineers have known of them: shafts, slider-cranks, platforms, spatial linkages."""

from functools import cache

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from bladesmith import Status
from bladesmith import cga3d as cga
from bladesmith import kinematics as kin
from bladesmith import pga3d as pga
from bladesmith.codegen.errors import ConstraintError, UndeterminedError

from ...support.kinematics import (
    ALGEBRAS,
    AXIS,
    MP,
    STEWART,
    bennett,
    columns,
    four_bar,
    line_joint,
    sarrus,
    six,
    slide,
    stewart,
    turn,
    twist,
    velocity,
)

pytestmark = pytest.mark.filterwarnings("error")


# -- a Cardan shaft ------------------------------------------------------------------------------------------------

BEND = 0.6
ARMS = np.array([0.0, 1.0, 0.0]), AXIS  # of the cross: each at right angles to its own shaft


@cache
def cardan():
    """Two shafts that meet at an angle; the first one's cross lies in the plane of both."""
    way = np.array([np.cos(BEND), np.sin(BEND), 0])
    m = kin.Mechanism(["frame", "in", "out"], "frame")
    m.add(kin.Revolute("frame", "in", cga.circle([-1, 0, 0], [1, 0, 0], 0.5)), "first")
    m.add(kin.Universal("in", "out", *(cga.circle([0, 0, 0], arm, 0.5) for arm in ARMS)), "cross")
    m.add(kin.Revolute("frame", "out", cga.circle(way, way, 0.5)), "second")
    return m


@pytest.mark.compiles
def test_a_cardan_shaft_runs_unevenly():
    """The arms of the cross stay at right angles: that alone says how the second shaft turns."""
    m, way = cardan(), np.array([np.cos(BEND), np.sin(BEND), 0])
    assert m.mobility() == 1 and len(m.self_stresses()) == 5 + 4 + 5 - (12 - 1)
    angle = np.linspace(-3, 3, 31)
    poses = m.solve_pose({"first": angle})
    assert not poses.status.any()
    found = np.array([Rotation.from_matrix(poses["out"][k].to_matrix()[:3, :3]).as_rotvec() @ way for k in range(31)])
    first = Rotation.from_rotvec(angle[:, None] * [1, 0, 0]).apply(ARMS[0])
    second = Rotation.from_rotvec(found[:, None] * way).apply(ARMS[1])
    np.testing.assert_allclose((first * second).sum(-1), 0, atol=1e-12)
    twists = m.jacobian("first", "out", poses=poses)[..., 0] @ np.linalg.inv(columns(cga)).T
    np.testing.assert_allclose(np.cross(twists[:, :3], way), 0, atol=1e-11)
    speeds = twists[:, :3] @ way
    np.testing.assert_allclose(speeds, _slope(angle, way), atol=1e-9)
    # as books have it, the angle counted from where the driving fork lies in the plane of the shafts
    book = np.cos(BEND) / (1 - (np.sin(BEND) * np.cos(angle)) ** 2)
    np.testing.assert_allclose(speeds, book, atol=1e-11)


def _slope(angles, way):
    """d(out)/d(in) of arms at right angles, by differences of 50 digits."""

    def turned(axis, v, angle):
        c, s = MP.cos(angle), MP.sin(angle)
        cross = [axis[1] * v[2] - axis[2] * v[1], axis[2] * v[0] - axis[0] * v[2], axis[0] * v[1] - axis[1] * v[0]]
        along = sum(a * b for a, b in zip(axis, v, strict=True))
        return [c * v[i] + s * cross[i] + (1 - c) * along * axis[i] for i in range(3)]

    def out(angle):  # p cos b + q sin b = 0, of the second arm turned by b
        arm = turned([MP.mpf(1), MP.mpf(0), MP.mpf(0)], [MP.mpf(v) for v in ARMS[0].tolist()], angle)
        w = [MP.mpf(v) for v in way.tolist()]
        u = [MP.mpf(v) for v in ARMS[1].tolist()]
        quarter = [w[1] * u[2] - w[2] * u[1], w[2] * u[0] - w[0] * u[2], w[0] * u[1] - w[1] * u[0]]
        p, q = (sum(a * b for a, b in zip(arm, v, strict=True)) for v in (u, quarter))
        return MP.atan2(-p, q)

    step = MP.mpf(10) ** -15
    gone = [out(MP.mpf(t) + step) - out(MP.mpf(t) - step) for t in angles.tolist()]
    return np.array([float((d - MP.pi * MP.nint(d / MP.pi)) / (2 * step)) for d in gone])


# -- slider and crank ----------------------------------------------------------------------------------------------


@cache
def slider(algebra="cga"):
    algebra = ALGEBRAS[algebra]
    m = kin.Mechanism(["frame", "crank", "rod", "piston"], "frame")
    end = np.array([0.5 * np.cos(0.4), 0.5 * np.sin(0.4), 0])
    pin = np.array([0.5 * np.cos(0.4) + np.sqrt(1.3**2 - end[1] ** 2), 0, 0])
    m.add(line_joint(algebra, "frame", "crank", [0, 0, 0], AXIS), "shaft")
    m.add(line_joint(algebra, "crank", "rod", end, AXIS), "end")
    m.add(line_joint(algebra, "rod", "piston", pin, AXIS), "pin")
    m.add(kin.Prismatic("frame", "piston", algebra.line(pin, [1, 0, 0]), algebra.plane(AXIS, 0)), "bore")
    return m, pin


@pytest.mark.compiles
@pytest.mark.parametrize("algebra", ALGEBRAS)
def test_a_slider_and_crank(algebra):
    m, pin = slider(algebra)
    assert m.mobility() == 1
    np.testing.assert_allclose(m.jacobian("shaft", "bore"), [[_piston(0.4)[1]]], rtol=1e-12)
    theta = np.linspace(0.4, 0.4 + 6.5, 40)
    poses = m.solve_pose({"shaft": theta - 0.4}, path=True)
    assert not poses.status.any()
    place = (poses["piston"] >> m.algebra.point(pin)).parameters().xyz
    np.testing.assert_allclose(place, _piston(theta)[0][:, None] * [1, 0, 0], atol=1e-13)
    speeds = m.jacobian("shaft", [("piston", pin)], poses=poses)[..., 0]
    np.testing.assert_allclose(speeds, _piston(theta)[1][:, None] * [1, 0, 0], atol=1e-12)


def _piston(theta, a=0.5, b=1.3):
    root = np.sqrt(b * b - (a * np.sin(theta)) ** 2)
    return a * np.cos(theta) + root, -a * np.sin(theta) - a * a * np.sin(theta) * np.cos(theta) / root


# -- a Stewart platform --------------------------------------------------------------------------------------------

LEGS = [f"leg_{i}" for i in range(6)]


@cache
def platform():
    return stewart(*STEWART)


def lengths(turned, moved):
    base, top = STEWART
    return np.linalg.norm(np.einsum("nij,kj->nki", turned, top) + moved[:, None] - base, axis=-1)


@cache
def platform_poses():
    rng = np.random.default_rng(8)
    vectors = 0.15 * rng.normal(size=(8, 3))
    turned, moved = Rotation.from_rotvec(vectors).as_matrix(), 0.15 * rng.normal(size=(8, 3))
    matrices = np.zeros((8, 4, 4))
    matrices[:, :3, :3], matrices[:, :3, 3], matrices[:, 3, 3] = turned, moved, 1
    motors = cga.motor_from_matrix(matrices)
    return turned, moved, motors, platform().solve_pose(targets={"top": motors})


@pytest.mark.compiles
def test_legs_of_a_stewart_platform():
    m, (turned, moved, _, poses) = platform(), platform_poses()
    start = lengths(np.eye(3)[None], np.zeros((1, 3)))[0]
    assert not poses.status.any() and poses.residual.max() < 1e-12
    for i, leg in enumerate(LEGS):
        sign = np.sign(m.jacobian("top", leg) @ columns(cga) @ slide(STEWART[1][i] - STEWART[0][i]))
        np.testing.assert_allclose(
            sign * poses.coordinates(leg)[:, 0], lengths(turned, moved)[:, i] - start[i], atol=1e-12
        )
    top = (poses["top"] >> cga.point(STEWART[1][0])).parameters().xyz
    np.testing.assert_allclose(top, turned @ STEWART[1][0] + moved, atol=1e-12)


def test_jacobians_of_a_stewart_platform():
    """Each leg's speed is that of its ball along it, for any twist of the top: written out."""
    m, (turned, moved, _, poses) = platform(), platform_poses()
    base, top = STEWART
    # at the start, by the mechanism itself
    ways = (top - base) / np.linalg.norm(top - base, axis=-1, keepdims=True)
    want = np.concatenate([np.cross(top, ways), ways], -1)
    found = m.jacobian("top", LEGS) @ columns(cga)
    np.testing.assert_allclose(np.abs(found), np.abs(want), atol=1e-11)
    signs = np.sign((found * want).sum(-1))
    np.testing.assert_allclose(found, signs[:, None] * want, atol=1e-11)
    forward = np.linalg.inv(columns(cga)) @ m.jacobian(LEGS, "top")
    np.testing.assert_allclose(forward @ found, np.eye(6), atol=1e-10)
    # at other poses, where all six legs are seen through the twists of their upper halves
    k = 3
    there = m.at({b: poses[b][k] for b in m.bodies})
    places = top @ turned[k].T + moved[k]
    ways = (places - base) / np.linalg.norm(places - base, axis=-1, keepdims=True)
    want = np.concatenate([np.cross(places, ways), ways], -1)
    np.testing.assert_allclose(there.jacobian("top", LEGS) @ columns(cga), signs[:, None] * want, atol=1e-10)
    singular = there.analysis(LEGS, "top")
    assert not singular.open.size and singular.residual.max() < 1e-10


def test_a_flat_stewart_platform_is_open():
    """Base and top alike and parallel: legs of equal lengths let it turn and sink."""
    base = STEWART[0]
    m = stewart(base, base + [0, 0, 1.5])
    found = m.analysis(LEGS, "top")
    assert found.open.shape[1] >= 1
    for twist_ in found.open.T @ np.linalg.inv(columns(cga)).T:
        speeds = velocity(twist_, base + [0, 0, 1.5])
        np.testing.assert_allclose(speeds[:, 2], 0, atol=1e-9)  # no ball moves along its leg
    with pytest.raises((UndeterminedError, ConstraintError)):
        m.jacobian(LEGS, "top")


# -- linkages that should not move, and do -------------------------------------------------------------------------


@pytest.mark.compiles
@pytest.mark.parametrize("algebra", ALGEBRAS)
def test_a_bennett_linkage_moves(algebra):
    """Four hinges in space, by counts of mobility -2; half angles keep their product of tangents."""
    places, axes, _ = bennett()
    m = four_bar(places, ALGEBRAS[algebra], axes)
    assert 6 * 3 - 5 * 4 == -2 and m.mobility() == 1 and len(m.self_stresses()) == 3
    slope = m.jacobian("a", "b")[0, 0]
    step = 1e-6
    ends = [_bennett_angle(0.9 + s * step) for s in (1, -1)]
    np.testing.assert_allclose(abs(slope), abs(ends[0] - ends[1]) / (2 * step), rtol=1e-8)
    gone = np.linspace(0, 2, 9)
    poses = m.solve_pose({"a": gone}, path=True)
    assert not poses.status.any()
    turned = np.exp(1j * poses.coordinates("b")[:, 0])
    ways = [np.array([_bennett_angle(0.9 + s * t) for t in gone]) - _bennett_angle(0.9) for s in (1, -1)]
    fits = [np.abs(turned - np.exp(1j * s * way)).max() for way in ways for s in (1, -1)]
    assert min(fits) < 1e-11  # one of them, as angles are counted


def _bennett_angle(theta, a=1.0, b=1.7, alpha=0.6):
    beta = np.arcsin(b * np.sin(alpha) / a)
    return 2 * np.arctan(np.sin((beta + alpha) / 2) / np.sin((beta - alpha) / 2) / np.tan(theta / 2))


def test_a_sarrus_linkage_goes_straight():
    m = sarrus()
    assert m.mobility() == 1
    allowed = six(m.allowed_twists("top"))
    np.testing.assert_allclose(np.abs(allowed / np.linalg.norm(allowed)), [slide(AXIS)], atol=1e-12)
    up = m.solve({"top": twist(cga, slide(AXIS))})
    np.testing.assert_allclose(six(up["base"]), 0, atol=0)
    # half a rod's height above its lower hinge: its turning speed is that of the top over twice its reach
    half = np.sqrt(0.8**2 - 0.5**2)
    np.testing.assert_allclose(np.linalg.norm(six(up["low_0"])[:3]), 1 / (2 * half), rtol=1e-10)


@pytest.mark.compiles
def test_a_rod_between_planes_of_two_algebras():
    """A ladder: one end on the wall, one on the floor, by points that stay on planes."""
    foot, head = np.array([3.0, 0, 0]), np.array([0.0, 0, 4.0])
    for algebra in (cga, pga):
        m = kin.Mechanism(["house", "ladder"], "house")
        m.add(kin.Bilinear("house", "ladder", algebra.plane([0, 0, 1], 0), algebra.point(foot)), "floor")
        m.add(kin.Bilinear("house", "ladder", algebra.plane([1, 0, 0], 0), algebra.point(head)), "wall")
        m.add(kin.Bilinear("house", "ladder", algebra.plane([0, 1, 0], 0), algebra.point(foot)), "track of the foot")
        m.add(kin.Bilinear("house", "ladder", algebra.plane([0, 1, 0], 0), algebra.point(head)), "track of the head")
        assert m.mobility() == 2  # it slides, and spins about itself
        allowed = six(m.allowed_twists("ladder"))
        want = np.array([turn(head - foot, foot), turn([0, 1, 0], [3, 0, 4])])  # the second, where both normals meet
        np.testing.assert_allclose(want @ np.linalg.pinv(allowed) @ allowed, want, atol=1e-11)
        poses = m.solve_pose(targets={"ladder": (foot, [[4.0, 0, 0], [5.5, 0, 0]])})
        assert poses.status.tolist() == [Status.OK, Status.NOT_CONVERGED]
        place = (poses["ladder"] >> algebra.point(head)).parameters().xyz[0]
        np.testing.assert_allclose(np.abs(place), [0, 0, 3], atol=1e-12)
        slides = m.solve({"ladder": twist(algebra, turn([0, 1, 0], [3, 0, 4]))})
        np.testing.assert_allclose(velocity(six(slides["ladder"]), foot) @ AXIS, 0, atol=1e-12)
