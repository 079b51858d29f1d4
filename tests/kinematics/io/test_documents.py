"""Mechanism files: what they describe against geometry written out here, and faults that name file, line and key."""

import csv
import io
import json
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import bladesmith as bs
from bladesmith.dynamics import couple, twist, wrench
from bladesmith.errors import InputError, SingularError
from bladesmith.kinematics.delta.robot import DeltaRobot
from bladesmith.kinematics.io.reader import load_mechanism
from bladesmith.kinematics.plotting import glyphs
from bladesmith.kinematics.task import report
from bladesmith.kinematics.task.tool_path import ToolPath
from bladesmith.status import Status

from ...support.checkout import CHECKOUT

EXAMPLES = CHECKOUT / "examples" / "kinematics"


@pytest.fixture(scope="module")
def setups():
    return {
        name: load_mechanism(EXAMPLES / f"{name}.toml") for name in ("delta", "four_bar", "stewart", "arm", "scara")
    }


class Motions(dict):
    """Motions of the examples by name, computed at the first use: each compiles a program."""

    def __init__(self, setups):
        self.setups = setups

    def __missing__(self, name):
        return self.setdefault(name, self.setups[name].motion())


@pytest.fixture(scope="module")
def motions(setups):
    return Motions(setups)


def written(tmp_path, text, name="robot.toml"):
    (tmp_path / name).write_text(text)
    return tmp_path / name


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


# -- poses -----------------------------------------------------------------------------------------------------

DELTA = """
[delta]
base_radius = 0.4
effector_radius = 0.15
upper_arm = 0.6
forearm = 1.2
"""


@pytest.mark.slow
def test_workers_sample_the_same_workspace(setups, monkeypatch):
    monkeypatch.setattr("bladesmith.kinematics.delta.workspace.POSITIONS_PER_CALL", 1000)
    for name in ("scara", "delta"):
        here, reports = setups[name].workspace(), []
        with ThreadPoolExecutor(2) as pool:
            there = setups[name].workspace(progress=reports.append, executor=pool)
        np.testing.assert_array_equal(here.condition, there.condition)
        assert len(reports) > 1 and reports[-1].done == there.reachable.size


def test_poses_by_joints_and_by_places_are_one(tmp_path):
    robot = DeltaRobot(0.4, 0.15, 0.6, 1.2)
    by_angles = load_mechanism(
        written(tmp_path, DELTA + "[pose]\njoints = { motor_1 = 20, motor_3 = 30 }\ndegrees = true\n")
    )
    found = by_angles.found()
    assert np.allclose(found.coordinates[0, [0, 2]], np.radians([20, 30]))
    there = ", ".join(repr(float(x)) for x in robot.forward(found.coordinates[0]))
    back = load_mechanism(written(tmp_path, DELTA + f"[pose]\nposition = [{there}]\n")).found()
    assert np.abs(back.coordinates - found.coordinates).max() < 1e-12
    assert abs(back.condition[0] - np.linalg.cond(robot.forward_jacobian(found.coordinates[0]))) < 1e-9


def test_a_delta_stands_where_it_is_best_if_nothing_is_said(tmp_path):
    found = load_mechanism(written(tmp_path, DELTA)).found()
    assert np.ptp(found.coordinates) < 1e-12 and np.abs(found.position[0, :2]).max() < 1e-12
    robot, axis = DeltaRobot(0.4, 0.15, 0.6, 1.2), np.zeros((500, 3))
    axis[:, 2] = np.linspace(0.01, 1.79, 500)
    theta, status = robot.inverse(axis, status=True)
    others = [np.linalg.cond(robot.forward_jacobian(x)) for x in theta[status == Status.OK]]
    assert found.condition[0] < 1.001 * min(others)


def test_what_cannot_be_reached_says_why(tmp_path):
    with pytest.raises(
        SingularError, match=r"robot.toml: no pose has the tool at \(1.4, 0, 1\): UNREACHABLE, arms 2, 3"
    ):
        load_mechanism(written(tmp_path, DELTA + "[pose]\nposition = [1.4, 0, 1]\n")).found()


def test_a_stretched_arm_is_singular_and_loses_the_direction_along_it(tmp_path):
    angle = np.radians(120)
    way = np.array([np.cos(angle), 0, np.sin(angle)])
    place = np.array([0.25, 0, 0]) + 1.8 * way
    text = f"[pose]\nposition = [{', '.join(map(repr, place.tolist()))}]\n"
    shown = load_mechanism(written(tmp_path, DELTA + text)).report()
    data = shown.data["jacobian"]
    assert data["status"] == "SINGULAR" and data["condition"] is None
    (lost,), (stuck,) = data["lost"], data["without_effect"]
    assert np.linalg.norm(np.cross(lost, way)) < 1e-6 * np.linalg.norm(lost)
    assert abs(stuck[0]) > 1 - 1e-6  # its own motor does not move the platform
    assert "infinite: the pose is singular" in shown.text() and "the tool cannot move:" in shown.text()


def test_the_pose_of_an_arm_may_be_turned(setups, tmp_path):
    arm = setups["arm"]
    home = arm.found()
    place = home.position[0] + (0.02, -0.03, 0.05)
    values = ", ".join(f"{n} = {x!r}" for n, x in zip(arm.model.inputs, home.coordinates[0].tolist(), strict=True))
    text = f"""
[urdf]
example = "arm"
[pose]
joints = {{ {values} }}
position = [{", ".join(map(repr, place.tolist()))}]
orientation = {{ axis = [0, 0, 1], degrees = 25 }}
"""
    moved = load_mechanism(written(tmp_path, text))
    assert moved.model.tool == "flange"  # behind all joints, and what is welded to them
    found = moved.found()
    before, after = (arm.model.chain.algebra.matrix(arm.model.chain.forward(x.coordinates[0])) for x in (home, found))
    c, s = np.cos(np.radians(25)), np.sin(np.radians(25))
    assert np.abs(after[:3, :3] - np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]) @ before[:3, :3]).max() < 1e-10
    assert np.abs(after[:3, 3] - place).max() < 1e-10


# -- joints ----------------------------------------------------------------------------------------------------

PAIR = (
    '[mechanism]\nbodies = ["a", "b"]\nalgebra = "{algebra}"\n[points]\nP = [0.3, -0.2, 0.5]\n'
    '[[joints]]\na = "a"\nb = "b"\n'
)
CGA_PAIR = PAIR.format(algebra="cga3d")
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
        m = load_mechanism(written(tmp_path, text)).found().at(0)
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
    m = load_mechanism(written(tmp_path, text)).found().at(0)
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
    m = load_mechanism(written(tmp_path, text)).found().at(0)
    assert m.joint_names == ("a-b", "b-c", "b-c 2") and m.mobility() == 4


# -- faults ----------------------------------------------------------------------------------------------------

FOUR = (EXAMPLES / "four_bar.toml").read_text()


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "robot.toml: describes no robot. Give a table [delta], [urdf] or [mechanism]"),
        ("[delta", "robot.toml, line 1, column 7: expected ']'"),
        (DELTA.replace("0.4", "-0.4"), "line 3: delta.base_radius is -0.4"),
        (DELTA.replace("forearm", "forarm"), "delta.forarm is not a known key; did you mean 'forearm'?"),
        (DELTA.replace("1.2", "0.01").replace("0.6", "0.01"),
         "line 5: delta.upper_arm and forearm are 0.02 long"),
        (DELTA + '[urdf]\npath = "x.urdf"', "line 7: urdf and delta are both there; a file describes one robot"),
        (DELTA + "[pose]\njoints = { motor_4 = 1 }",
         "pose.joints.motor_4 is 'motor_4', which is not an actuated joint"),
        (DELTA + "[pose]\nposition = 'home'",
         "line 8: pose.position is 'home', which is not a point; there are: none"),
        (DELTA + "[pose]\norientation = { axis = [0, 0, 1], degrees = 3 }", "pose.orientation goes with a position"),
        (DELTA + "[workspace]\nbox = [[0, 1], [1, 0], [0, 1]]",
         "line 8: workspace.box[1] goes from 1 to 0; the least is first"),
        (DELTA + "[workspace]\nsamples = 0", "samples are from 1 to 2001 along a side"),
        (DELTA + "[path]\nduration = 2", "path: has neither line nor circle nor points nor joints; one is needed"),
        (DELTA + "[path]\nline = { end = [0, 0, 1] }\njoints = { motor_1 = [0, 1] }",
         "line and joints say the same thing"),
        (DELTA + "[path]\npoints = [[0, 0, 1], [0, 0, 1]]", "path.points[1] equals path.points[0]"),
        ('[urdf]\npath = "none.urdf"', "line 2: urdf.path is refused: "),
        ('[urdf]\nexample = "arms"', 'urdf.example is "arms"; did you mean'),
        ('[urdf]\nexample = "arm"\ntip = "flangs"',
         "line 3: urdf.tip is 'flangs', which is not a link (did you mean 'flange'?)"),
        ('[mechanism]\nbodies = ["a", "b"]', "line 1: mechanism has no joints"),
        ('[mechanism]\nbodies = ["a", "b", "a"]', "mechanism.bodies[2] is 'a', a duplicate body name"),
        ('[mechanism]\nbodies = ["a", "b"]\nfixed = "c"', "line 3: mechanism.fixed is 'c', which is not a body"),
        (FOUR.replace('inputs = ["motor"]', 'inputs = ["moter"]'),
         "line 6: mechanism.inputs[0] is 'moter', which is not a joint (did you mean 'motor'?)"),
        (FOUR.replace('body = "coupler"', 'body = "frame"'),
         "mechanism.tool.body is 'frame', which is not a moving body"),
        (FOUR.replace('point = "tip"', 'point = "top"'),
         "mechanism.tool.point is 'top', which is not a point (did you mean 'tip'?)"),
        (FOUR.replace('name = "crank pin"', 'name = "motor"'),
         "joints[1].name is 'motor', a duplicate name"),
        (FOUR.replace('b = "crank"', 'b = "krank"', 1),
         "joints[0].b is 'krank', which is not a body (did you mean 'crank'?)"),
        (FOUR.replace('b = "crank"', 'b = "frame"', 1), "joints[0].b is 'frame', the same as a"),
        (FOUR.replace('point = "A"\n', ""), "joints[0]: has neither point nor objects; one is needed"),
        (FOUR.replace('point = "A"\n', 'point = "A"\nobjects = []\n'), "objects and point and axis are alternatives"),
        (FOUR.replace('"circle", center = "D", normal = [0, 0, 1], radius = 0.5', '"direction", v = [0, 0, 1]'),
         "joints[3] is refused: Revolute('frame', 'rocker')"),
        (FOUR.replace('body = "coupler", ', 'body = "coupler", points = 3, '),
         "mechanism.tool.points is not a known key"),
        (FOUR.replace("joints = { motor = [0, 360] }", "joints = { hinge = [0, 360] }"),
         "path.joints.hinge is 'hinge', which is not an actuated joint"),
        (FOUR.replace("[points]", "limits = { motor = [1, 0] }\n[points]"), "mechanism.limits.motor goes from 1 to 0"),
        (FOUR.replace('b = "rocker"\nobj', 'b = "coupler"\nobj').replace('b = "rocker"\npoint', 'b = "crank"\npoint'),
         "joints is refused: no joints hold rocker to 'frame'"),
        (PAIR.format(algebra="pga3d") + 'kind = "universal"\npoint = "P"\naxis_a = [1, 0, 0]\naxis_b = [0, 1, 0]',
         "joints[0] is universal, which pga3d does not have"),
        (CGA_PAIR + 'kind = "prismatic"\nobjects = [{ kind = "line", point = "P", direction = [0, 1, 0] }]',
         "joints[0].objects are 1, which is not the number of objects of a prismatic joint"),
        (CGA_PAIR + 'kind = "prismatic"\nobjects = [{ kind = "line", point = "P", direction = [0, 1, 0] }, '
         '{ kind = "direction", v = [0, 1, 0] }]', "joints[0] is refused: Prismatic('a', 'b')"),
        (CGA_PAIR + 'kind = "rigid"\nobjects = []', "a rigid joint has no objects"),
        (CGA_PAIR + 'kind = "bilinear"', "joints[0]: has no objects; it is between two"),
        (CGA_PAIR + 'kind = "ball"\npoint = "P"', 'joints[0].kind is "ball"; known: spherical'),
    ],
)  # fmt: skip
def test_faults_say_file_line_key_and_remedy(text, says, tmp_path):
    path = written(tmp_path, text)
    with pytest.raises(InputError) as caught:
        load_mechanism(path)
    assert says in str(caught.value) and str(path) in str(caught.value), str(caught.value)


def test_what_is_no_file(tmp_path):
    with pytest.raises(InputError, match="names none"):
        load_mechanism(3)
    with pytest.raises(InputError, match="null character"):
        load_mechanism("a\0b.toml")
    with pytest.raises(InputError, match="cannot be read"):
        load_mechanism(tmp_path / "none.toml")
    with pytest.raises(InputError, match="tip and root are of URDF files"):
        load_mechanism(written(tmp_path, DELTA), tip="platform")


def test_a_mechanism_without_inputs_or_tool_is_reported_and_asks_for_them(tmp_path):
    text = CGA_PAIR + 'kind = "spherical"\npoint = "P"\n'
    setup = load_mechanism(written(tmp_path, text))
    assert setup.report().data["mobility"] == 3 and "jacobian" not in setup.report().data
    for asked in (setup.workspace, setup.motion):
        with pytest.raises(InputError):
            asked()
    with pytest.raises(InputError, match="an input has one"):
        load_mechanism(written(tmp_path, text.replace("[points]", 'inputs = ["a-b"]\n[points]')))


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
    page = (EXAMPLES.parent.parent / "docs" / "mechanisms.md").read_text()
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
