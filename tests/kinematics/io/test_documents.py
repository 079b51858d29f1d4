"""Mechanism files: what they describe against geometry written out here, joints, files of motions."""

import csv
import io
import json

import numpy as np
import pytest

import bladesmith as bs
from bladesmith.dynamics import couple, twist, wrench
from bladesmith.errors import InputError
from bladesmith.kinematics.io.reader import load_mechanism
from bladesmith.kinematics.plotting import glyphs
from bladesmith.kinematics.task import report
from bladesmith.kinematics.task.tool_path import ToolPath
from bladesmith.status import Status

from ...support.mechanisms.documents import DELTA, EXAMPLES, FOUR, PAIR, written

# -- the examples, against what geometry says ------------------------------------------------------------------


@pytest.mark.compiles
@pytest.mark.parametrize(
    ("name", "mobility", "rank", "redundant", "tool"),
    [
        ("delta", 9, 51, 0, "platform"),  # three motors, and six rods that spin
        ("four_bar", 1, 17, 3, "coupler"),
        ("stewart", 6, 72, 0, "plate"),
        ("arm", 6, 36, 0, "flange"),
        ("scara", 4, 20, 0, "gripper"),
    ],
)
def test_reports_have_what_is_known_of_each(setups, name, mobility, rank, redundant, tool):
    data = setups[name].report().data
    assert (data["mobility"], data["rank"], len(data["redundant"])) == (mobility, rank, redundant)
    assert len(data["free_motions"]) == mobility and sum(x["alone"] for x in data["free_motions"]) == 6 * (
        name == "delta"
    )
    assert data["tool"]["body"] == tool and data["rank"] + data["mobility"] == data["speeds"]
    assert data["residual"] < 1e-12 and data["jacobian"]["status"] == "OK" and not data["jacobian"]["lost"]
    assert json.loads(json.dumps(data, allow_nan=False)) == data


def linkage(angle):
    """Places of the four-bar's pins and tip: circles that intersect, and a triangle that goes along."""
    (a, b, c, d, tip) = (np.array(x) for x in ((0, 0), (0, 1), (3, 2.5), (3.5, 0), (1.2, 3.2)))
    coupler, rocker = np.linalg.norm(c - b), np.linalg.norm(c - d)
    turn = np.stack([np.cos(angle + np.pi / 2), np.sin(angle + np.pi / 2)], -1)
    pin = a + np.linalg.norm(b - a) * turn
    way = d - pin
    size = np.linalg.norm(way, axis=-1, keepdims=True)
    along = (size**2 + coupler**2 - rocker**2) / (2 * size)
    across = np.sqrt(coupler**2 - along**2)
    other = pin + (along * way + across * np.stack([-way[:, 1], way[:, 0]], -1)) / size
    base, now = c - b, other - pin
    cosine = (now @ base) / coupler**2
    sine = (base[0] * now[:, 1] - base[1] * now[:, 0]) / coupler**2
    arm = tip - b
    moved = np.stack([cosine * arm[0] - sine * arm[1], sine * arm[0] + cosine * arm[1]], -1)
    return pin + moved


@pytest.mark.compiles
def test_the_coupler_of_a_four_bar_goes_where_circles_meet(motions):
    motion = motions["four_bar"]
    angles = np.linspace(0, 2 * np.pi, 241)
    assert np.abs(motion.coordinates[:, 0] - angles).max() < 1e-14 and np.ptp(motion.speeds) < 1e-12
    assert (
        np.abs(motion.position[:, :2] - linkage(angles)).max() < 1e-10 and np.abs(motion.position[:, 2]).max() < 1e-10
    )
    step = 1e-5
    rates = (linkage(angles + step) - linkage(angles - step)) / (2 * step) * np.pi
    assert np.abs(motion.velocity[:, :2] - rates).max() < 1e-8


@pytest.mark.compiles
def test_legs_of_a_stewart_platform_are_as_long_as_their_ends_are_apart(setups, motions):
    joints, motion = setups["stewart"].report().data["joints"], motions["stewart"]
    begin = np.array([x["place"] for x in joints if x["kind"] == "universal"])
    end = np.array([x["place"] for x in joints if x["kind"] == "spherical"])
    legs = (end - begin)[None] + (motion.position - (0.0, 0.0, 1.1))[:, None]
    sizes = np.linalg.norm(legs, axis=-1)
    assert np.abs(motion.coordinates - (sizes - np.linalg.norm(end - begin, axis=-1))).max() < 1e-11
    assert np.abs(motion.speeds - np.einsum("nij,nj->ni", legs, motion.velocity) / sizes).max() < 1e-10
    circle = np.linalg.norm(motion.position - (0, 0, 1.1), axis=-1)
    assert np.abs(circle - 0.2).max() < 1e-12


def test_forearms_of_a_delta_keep_their_length_on_the_path(motions):
    motion, phi = motions["delta"], 2 * np.pi / 3 * np.arange(3)
    ways = np.stack([np.cos(phi), np.sin(phi), 0 * phi], -1)
    theta = motion.coordinates[..., None]
    elbows = (0.4 + 0.6 * np.cos(theta)) * ways + 0.6 * np.sin(theta) * np.array([0, 0, 1.0])
    wrists = motion.position[:, None] + 0.15 * ways
    assert np.abs(np.linalg.norm(elbows - wrists, axis=-1) - 1.2).max() < 1e-12
    assert np.abs(np.linalg.norm(motion.position - (0, 0, 1.2), axis=-1) - 0.35).max() < 1e-12
    # fourth-order differences of the angles themselves
    x, h = motion.coordinates, motion.time[1]
    rates = (x[:-4] - 8 * x[1:-3] + 8 * x[3:-1] - x[4:]) / (12 * h)
    assert np.abs(motion.speeds[2:-2] - rates).max() < 1e-4 * np.abs(rates).max()


@pytest.mark.parametrize("name", ["arm", "scara"])
def test_serial_robots_go_along_their_path(setups, motions, name):
    setup, motion = setups[name], motions[name]
    assert motion.is_reached.all() and np.abs(motion.speeds[[0, -1]]).max() < 1e-12  # it begins and ends at rest
    ends = {"arm": (0.25, 0.55, 0.45), "scara": (0.35, -0.2, 0.25)}
    assert np.abs(motion.position[-1] - ends[name]).max() < 1e-10
    if name == "arm":
        way = motion.position - motion.position[0]
        assert np.abs(np.cross(way, way[-1])).max() < 1e-10
    turns = setup.model.chain.forward(motion.coordinates)
    matrices = setup.model.chain.algebra.matrix(turns)[:, :3, :3]
    if name == "arm":
        assert np.abs(matrices - matrices[0]).max() < 1e-10
    x, h = motion.coordinates, motion.time[1]
    rates = (x[:-4] - 8 * x[1:-3] + 8 * x[3:-1] - x[4:]) / (12 * h)
    assert np.abs(motion.speeds[2:-2] - rates).max() < 1e-3 * np.abs(rates).max()


@pytest.mark.slow
def test_the_workspace_of_a_scara_is_that_of_two_arms_with_limits(setups):
    space = setups["scara"].workspace()
    x, y = np.meshgrid(space.x, space.y, indexing="ij")
    reached = np.zeros(x.shape, bool)
    cosine = (x**2 + y**2 - 0.3**2 - 0.25**2) / (2 * 0.3 * 0.25)
    for side in (1, -1):
        outer = side * np.arccos(np.clip(cosine, -1, 1))
        inner = np.arctan2(y, x) - np.arctan2(0.25 * np.sin(outer), 0.3 + 0.25 * np.cos(outer))
        inner = (inner + np.pi) % (2 * np.pi) - np.pi
        reached |= (np.abs(cosine) <= 1) & (np.abs(outer) <= 2.6) & (np.abs(inner) <= 2.4)
    assert (space.reachable[..., 0] == reached).mean() > 0.995 and reached.any() and not reached.all()
    assert (
        np.isfinite(space.condition[space.reachable]).mean() > 0.99
        and np.isnan(space.condition[~space.reachable]).all()
    )


JOINTS = {
    "spherical": ('point = "P"', '{ kind = "sphere", center = "P", radius = 0.2 }', 3),
    "revolute": (
        'point = "P"\naxis = [0, 2, 0]', '{ kind = "circle", center = "P", normal = [0, 1, 0], radius = 0.2 }', 1,
    ),
    "cylindrical": ('point = "P"\naxis = [0, 2, 0]', '{ kind = "line", point = "P", direction = [0, 1, 0] }', 2),
    "prismatic": (
        "axis = [0, 2, 0]",
        '{ kind = "line", point = "P", direction = [0, 1, 0] }, { kind = "plane", normal = [2, 0, 0], offset = 1 }', 1,
    ),
    "planar": ('point = "P"\nnormal = [0, 2, 0]', '{ kind = "plane", normal = [0, 2, 0], point = "P" }', 3),
    "universal": (
        'point = "P"\naxis_a = [0, 2, 0]\naxis_b = [1, 0, 0]',
        '{ kind = "circle", center = "P", normal = [0, 1, 0], radius = 1 }, '
        '{ kind = "circle", center = "P", normal = [1, 0, 0], radius = 1 }', 2,
    ),
}  # fmt: skip


@pytest.mark.parametrize("kind", JOINTS)
def test_joints_by_places_and_by_objects_leave_the_same(kind, tmp_path):
    short, objects, mobility = JOINTS[kind]
    spaces = []
    for own in (short, f"objects = [{objects}]"):
        text = PAIR.format(algebra="cga3d") + f'kind = "{kind}"\n{own}\n'
        m = load_mechanism(written(tmp_path, text)).solve_pose().at(0)
        assert m.mobility() == mobility and glyphs.mechanism_sketch(m).marks[0].kind == kind
        assert np.abs(glyphs.mechanism_sketch(m).marks[0].position - (0.3, -0.2, 0.5)).max() < 1e-9 or kind in (
            "cylindrical",
            "prismatic",
            "planar",
        )
        spaces.append(m.allowed_twists("b").values)
    projectors = [x.T @ np.linalg.pinv(x.T) for x in spaces]
    assert np.abs(projectors[0] - projectors[1]).max() < 1e-9


@pytest.mark.parametrize("kind", [k for k in JOINTS if k != "universal"])
def test_joints_in_pga(kind, tmp_path):
    text = PAIR.format(algebra="pga3d") + f'kind = "{kind}"\n{JOINTS[kind][0]}\n'
    m = load_mechanism(written(tmp_path, text)).solve_pose().at(0)
    assert m.algebra is bs.pga3d and m.mobility() == JOINTS[kind][2]


def test_rigid_and_bilinear_joints_and_names_of_their_own(tmp_path):
    text = '[mechanism]\nbodies = ["a", "b", "c"]\n' + "".join(
        f'[[joints]]\na = "{a}"\nb = "{b}"\n{rest}\n'
        for a, b, rest in (
            ("a", "b", 'kind = "rigid"'),
            ("b", "c", 'kind = "bilinear"\nobjects = [{ kind = "point", xyz = [1, 0, 0] }, '
             '{ kind = "plane", normal = [0, 0, 1], offset = 0 }]'),
            ("b", "c", 'kind = "bilinear"\nobjects = [{ kind = "point", xyz = [0, 1, 0] }, '
             '{ kind = "plane", normal = [0, 0, 1], offset = 0 }]'),
        )
    )  # fmt: skip
    m = load_mechanism(written(tmp_path, text)).solve_pose().at(0)
    assert m.joint_names == ("a-b", "b-c", "b-c 2") and m.mobility() == 4


# -- files of motions, words -----------------------------------------------------------------------------------


def test_motions_are_read_back_to_the_last_bit(motions, tmp_path):
    motion = motions["scara"]
    motion.save(tmp_path / "m.npz")
    motion.save(tmp_path / "m.csv")
    with np.load(tmp_path / "m.npz", allow_pickle=False) as stored:
        header = json.loads(stored["bladesmith"].tobytes())
        for name in ("time", "coordinates", "speeds", "position", "velocity", "condition", "status"):
            assert np.array_equal(stored[name], getattr(motion, name), equal_nan=True)
    assert header["inputs"] == ["inner", "outer", "plunge", "spin"] and header["turning"] == [True, True, False, True]
    rows = list(csv.reader(io.StringIO((tmp_path / "m.csv").read_text())))
    assert (
        rows[0][:4] == ["t [s]", "inner [rad]", "outer [rad]", "plunge [m]"] and rows[0][7] == "speed of plunge [m/s]"
    )
    assert rows[0][9:] == ["x [m]", "y [m]", "z [m]", "vx [m/s]", "vy [m/s]", "vz [m/s]", "condition", "status"]
    numbers = np.array([[float(x) for x in row[:-1]] for row in rows[1:]])
    assert np.array_equal(numbers[:, 1:5], motion.coordinates) and np.array_equal(numbers[:, 12:15], motion.velocity)
    assert {row[-1] for row in rows[1:]} == {"OK"}
    with pytest.raises(InputError, match=".npz or .csv"):
        motion.save(tmp_path / "m.txt")


def test_what_is_not_reached_is_nan_with_a_status(tmp_path):
    text = DELTA + "[pose]\nposition = [0, 0, 1.2]\n[path]\nline = { end = [2.5, 0, 1.2] }\nsamples = 21\n"
    motion = load_mechanism(written(tmp_path, text)).motion()
    gone = ~motion.is_reached
    assert (
        gone.any() and not gone.all() and np.isnan(motion.speeds[gone]).all() and np.isnan(motion.position[gone]).all()
    )
    assert (motion.status[gone] == Status.UNREACHABLE).all() and gone.argmax() == (~gone).sum()


@pytest.mark.parametrize("smooth", [True, False])
@pytest.mark.parametrize(
    ("kind", "numbers"),
    [
        ("line", {"start": None, "end": (1, 2, 3)}),
        ("circle", {"center": (0, 0, 1), "normal": (1, 2, 3), "radius": 0.5, "turns": -1.5}),
        ("circle", {"center": (0.1, 0.2, 0.3), "normal": (0, 0, 2), "radius": 0.5, "turns": 1}),  # home is on its axis
        ("points", {"points": [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 1)]}),
    ],
)
def test_velocities_of_ways_are_their_derivatives(kind, numbers, smooth):
    way = ToolPath(kind, numbers, 2.0, 401, smooth)
    places, rates = way.positions(np.array([0.1, 0.2, 0.3]))
    h = way.times[1]
    found = (places[:-4] - 8 * places[1:-3] + 8 * places[3:-1] - places[4:]) / (12 * h)
    assert np.abs(found - rates[2:-2]).max() < 1e-5 * max(1.0, np.abs(rates).max())
    if kind == "circle":
        away = places - np.array(numbers["center"], float)
        assert np.abs(np.linalg.norm(away, axis=1) - 0.5).max() < 1e-12
        assert np.abs(away @ np.array(numbers["normal"])).max() < 1e-12
    if smooth:
        assert np.abs(rates[[0, -1]]).max() < 1e-12
    else:
        assert kind == "points" or np.ptp(np.linalg.norm(rates, axis=1)) < 1e-12


def test_words():
    line = (0, 0, 2.0)
    assert report.motion_words(twist(line, (0, 0, 0))) == "turns about (0, 0, 1) through (0, 0, 0)"
    assert report.motion_words(twist(line, (0, -2, 0))) == "turns about (0, 0, 1) through (1, 0, 0)"
    assert (
        report.motion_words(twist(line, (0, -2, 1))) == "screws about (0, 0, 1) through (1, 0, 0), pitch 0.5 per radian"
    )
    assert report.motion_words(twist((0, 0, 0), (0, 3, 0))) == "slides along (0, 1, 0)"
    assert report.wrench_words(couple((0, 0, -3))) == "a couple about (0, 0, -1)"
    assert report.wrench_words(wrench((0, 0, 3), (1, 2, 0))) == "a force along (0, 0, 1) through (1, 2, 0)"
    assert "and a couple about it" in report.wrench_words(wrench((0, 0, 3), (1, 2, 0)) + couple((0, 0, 1)))


def test_joints_are_driven_without_a_tool(motions, tmp_path):
    motion = load_mechanism(written(tmp_path, FOUR.replace("tool = {", "# "))).motion()
    assert np.array_equal(motion.coordinates, motions["four_bar"].coordinates) and motion.is_reached.all()
    assert np.isnan(motion.position).all() and np.isnan(motion.velocity).all() and np.isfinite(motion.speeds).all()


@pytest.mark.compiles
def test_the_file_of_the_docs_is_a_slider_crank(tmp_path):
    page = (EXAMPLES.parent.parent / "docs" / "motion" / "mechanisms.md").read_text()
    text = page.split("```toml\n")[1].split("```")[0]
    setup = load_mechanism(written(tmp_path, text))
    motion = setup.motion()
    crank = np.linspace(np.radians(20), np.radians(120), 101)
    assert abs(motion.coordinates[0, 0] - crank[0]) < 1e-12 and abs(motion.coordinates[-1, 0] - crank[-1]) < 1e-12
    pin = motion.coordinates[:, 0] + np.pi / 2
    place = np.cos(pin) + np.sqrt(10 - np.sin(pin) ** 2)  # the coupler is as long as from (0, 1) to (3, 0)
    speed = -np.sin(pin) * (1 + np.cos(pin) / np.sqrt(10 - np.sin(pin) ** 2)) * motion.speeds[:, 0]
    assert np.abs(motion.position - np.stack([place, 0 * place, 0 * place], -1)).max() < 1e-11
    assert np.abs(motion.velocity[:, 0] - speed).max() < 1e-11 and np.abs(motion.velocity[:, 1:]).max() < 1e-11
    away = load_mechanism(written(tmp_path, text.replace("motor = 20", "motor = 280"))).report()
    assert away.data["outside_limits"] == ["motor"] and "outside their limits:" in away.text()
