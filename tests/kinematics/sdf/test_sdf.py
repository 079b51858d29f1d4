"""Robots of SDF files: poses against matrices multiplied here, loops, followers, and files that are wrong."""

from pathlib import Path

import numpy as np
import pytest

import bladesmith as bs
from bladesmith import kinematics
from bladesmith.dynamics import screw_coordinates
from bladesmith.errors import InputError

from ...support.mechanisms.robots import real_robots

ALGEBRAS = [bs.cga3d, bs.pga3d]


@pytest.fixture
def load(tmp_path):
    def loaded(text, *arguments, version="1.9", **options):
        path = tmp_path / "robot.sdf"
        path.write_text(text if "<sdf" in text else f'<sdf version="{version}"><model name="m">{text}</model></sdf>')
        return kinematics.load_sdf(path, *arguments, **options)

    return loaded


def link(name, pose="", more=""):
    return f'<link name="{name}">{pose}{more}</link>'


def joint(name, kind, parent, child, inside="<axis><xyz>0 0 1</xyz></axis>", pose=""):
    return (
        f'<joint name="{name}" type="{kind}"><parent>{parent}</parent><child>{child}</child>{pose}{inside}</joint>'
    )  # fmt: skip


def at(text, **options):
    more = " ".join(f'{k}="{v}"' for k, v in options.items())
    return f"<pose {more}>{text}</pose>"


def axis(xyz, more="", frame=""):
    given = f' expressed_in="{frame}"' if frame else ""
    return f"<axis><xyz{given}>{xyz}</xyz>{more}</axis>"


def rotation(vector):
    """A rotation by a rotation vector (Rodrigues)."""
    angle = np.linalg.norm(vector)
    k = np.array([[0, -vector[2], vector[1]], [vector[2], 0, -vector[0]], [-vector[1], vector[0], 0]]) / (angle or 1.0)
    matrix = np.eye(4)
    matrix[:3, :3] += np.sin(angle) * k + (1 - np.cos(angle)) * k @ k
    return matrix


def place(x, y, z, roll=0.0, pitch=0.0, yaw=0.0):
    """Fixed axes x, y, z, then the translation."""
    matrix = rotation([0, 0, yaw]) @ rotation([0, pitch, 0]) @ rotation([roll, 0, 0])
    matrix[:3, 3] = x, y, z
    return matrix


#: a -- j --> b -- u --> c -- s --> d; frames and poses relative to each other.
CHAIN = (
    link("a", at("1 2 3 0.1 0.2 0.3"))
    + link("c", at("0 0 1 0 0 0.5", relative_to="b"))
    + link("b", at("0.5 0 0 0.4 0 0", relative_to="f"))
    + link("d", at("0 1 0 0 0 0", relative_to="u"))
    + '<frame name="f" attached_to="a"><pose>0 0 2 0 0.6 0</pose></frame>'
    + joint("j", "revolute", "a", "b", axis("0 2 0", "<limit><lower>-1</lower><upper>2</upper></limit>"),
            at("0.1 0 0 0 0 0.2"))
    + joint("u", "universal", "b", "c", axis("1 0 0") + axis("0 1 0").replace("axis>", "axis2>"), at("0 0 -0.3 0 0 0"))
    + joint("s", "screw", "c", "d",
            "<screw_thread_pitch>0.5</screw_thread_pitch>" + axis("1 1 0", frame="__model__"))
)  # fmt: skip


def expected(j, u0, u1, s):
    """Poses of the chain, from the first link's frame."""
    a = place(1, 2, 3, 0.1, 0.2, 0.3)
    f = a @ place(0, 0, 2, 0, 0.6, 0)
    b = f @ place(0.5, 0, 0, 0.4)
    c = b @ place(0, 0, 1, 0, 0, 0.5)
    u = c @ place(0, 0, -0.3)
    d = u @ place(0, 1, 0)
    frames = {"a": a, "b": b, "c": c, "d": d}

    def move(frame, motion, links):
        for name in links:
            frames[name] = frame @ motion @ np.linalg.inv(frame) @ frames[name]

    screw = place(*d[:3, 3])  # along the model's axes, from the outside to the inside
    along = np.array([1, 1, 0]) / np.sqrt(2)
    motion = rotation(s * along)
    motion[:3, 3] = 0.5 / (2 * np.pi) * s * along
    move(screw, motion, "d")
    move(u, rotation([u0, 0, 0]) @ rotation([0, u1, 0]), "cd")
    move(b @ place(0.1, 0, 0, 0, 0, 0.2), rotation([0, j, 0]), "bcd")
    return {name: np.linalg.inv(a) @ frame for name, frame in frames.items()}


@pytest.mark.parametrize("algebra", ALGEBRAS, ids=lambda a: a.name)
def test_poses(load, algebra):
    found = load(CHAIN, algebra)
    assert found.root == "a" and found.joint_names == ("j", "u[0]", "u[1]", "s")
    assert load(CHAIN.replace("<lower>-1", "<lower>-inf")).limits[0].tolist() == [-np.inf, 2]
    assert found.limits[0].tolist() == [-1, 2] and np.isinf(found.limits[1:]).all()
    for q in ([0.0] * 4, [0.3, -0.5, 0.8, 1.1]):
        poses = found.poses(q)
        for name, frame in expected(*q).items():
            assert np.abs(algebra.matrix(poses[name]) - frame).max() < 1e-14
    q = [0.3, -0.5, 0.8, 1.1]
    mechanism = found.mechanism(q)
    assert mechanism.mobility() == 4 and not mechanism.couplings
    chain = found.chain("d")
    columns = chain.jacobian(q)
    for i, name in enumerate(("j", "u[0]", "u[1]", "s")):
        twist = mechanism.solve({**dict.fromkeys(("j", "u[0]", "u[1]", "s"), 0.0), name: 1.0})
        assert np.abs(screw_coordinates(twist["d"]) - columns[:, i]).max() < 1e-12


def test_units_formats_and_old_axes(load):
    text = link("a") + link("b", at("0 0 0 90 0 0", degrees="true")) + link(
        "c", at("1 2 3 0 0 1 1", rotation_format="quat_xyzw")
    )  # fmt: skip
    turn = axis("0 1 0", "<use_parent_model_frame>1</use_parent_model_frame>")
    text += joint("j", "revolute", "a", "b", turn) + joint("k", "continuous", "b", "c", turn)
    found = load(text, version="1.6")
    poses = {n: bs.cga3d.matrix(x) for n, x in found.poses().items()}
    assert np.abs(poses["b"] - place(0, 0, 0, np.pi / 2)).max() < 1e-15
    assert np.abs(poses["c"] - place(1, 2, 3, 0, 0, np.pi / 2)).max() < 1e-15
    moved = bs.cga3d.matrix(found.poses({"j": 0.5})["c"])
    assert np.abs(moved - rotation([0, 0.5, 0]) @ poses["c"]).max() < 1e-15
    older = load(text.replace("<use_parent_model_frame>1</use_parent_model_frame>", ""), version="1.4")
    assert np.abs(bs.cga3d.matrix(older.poses({"j": 0.5})["c"]) - moved).max() < 1e-15


def test_the_world_and_joints_that_point_to_it(load):
    text = link("a", at("1 0 0 0 0 0")) + link("b", at("2 0 0 0 0 0"))
    text += joint("j", "revolute", "a", "world") + joint("k", "prismatic", "b", "a", axis("1 0 0"))
    found = load(text)
    assert found.root == "world" and found.joints["j"].child == "a"
    pose = bs.cga3d.matrix(found.poses({"j": 0.4, "k": 0.1})["b"])
    # a joint turns its child against its parent: here the world, which stays
    truth = rotation([0, 0, -0.4]) @ place(2, 0, 0) @ place(-0.1, 0, 0)
    assert np.abs(pose - truth).max() < 1e-15


def four_bar():
    text = link("a") + link("b", at("0 0 1 0 0 0")) + link("c", at("2 0 1 0 0 0")) + link("d", at("2 0 0 0 0 0"))
    turn = axis("0 1 0")
    return text + "".join(
        joint(name, "revolute", parent, child, turn, at(pose, relative_to="__model__"))
        for name, parent, child, pose in (
            ("j", "a", "b", "0 0 0 0 0 0"), ("k", "b", "c", "0 0 1 0 0 0"), ("l", "d", "c", "2 0 1 0 0 0"),
            ("m", "a", "d", "2 0 0 0 0 0"),
        )
    )  # fmt: skip


def test_loops(load):
    found = load(four_bar())
    assert [loop.name for loop in found.loops] == ["l"] and found.joint_names == ("j", "k", "m")
    mechanism = found.mechanism()
    assert mechanism.mobility() == 1 and mechanism.residual() < 1e-12 and len(mechanism.self_stresses()) == 3
    speeds = mechanism.jacobian("j", ["m", "l"])
    assert np.abs(speeds[:, 0] - [1, -1]).max() < 1e-12  # a parallelogram: the coupler does not turn
    open_one = found.mechanism({"j": 0.1})
    with pytest.raises(bs.errors.ConstraintError, match="l: the geometry of its two bodies"):
        open_one.mobility()
    again = found.mechanism({"j": 0.1, "k": -0.1, "m": 0.1})
    assert again.mobility() == 1 and again.residual() < 1e-12
    with pytest.raises(InputError, match="'l' closes a loop: torques"):
        found.gravity_torques([0, 0, 0])


def test_followers_and_gears(load):
    follow = '<mimic joint="j"><multiplier>2</multiplier><offset>0.5</offset><reference>0.1</reference></mimic>'
    text = link("a") + link("b") + link("c") + link("d") + joint("j", "revolute", "a", "b")
    text += joint("k", "revolute", "a", "c", axis("0 0 1", follow)) + joint("l", "revolute", "a", "d", axis("0 0 -1"))
    gear = joint(
        "g", "gearbox", "b", "d",
        "<gearbox_reference_body>a</gearbox_reference_body><gearbox_ratio>3</gearbox_ratio>"
        + axis("0 0 1") + axis("0 0 1").replace("axis>", "axis2>"),
    )  # fmt: skip
    found = load(text + gear)
    assert found.joint_names == ("j",)
    assert (found.followers["k"].multiplier, found.followers["k"].offset) == (2, 0.5 - 0.2)
    assert found.followers["l"].multiplier == 3  # theta_2 = -3 theta_1, about the axis that this joint turns against
    assert found.mechanism().mobility() == 1
    assert load(text + gear, mimic="free").mechanism().mobility() == 3
    with pytest.raises(InputError, match="refused with mimic='error'"):
        load(text, mimic="error")
    with pytest.raises(InputError, match="no joint turns 'b' on 'c', as is needed by the gearbox <joint name='g'>"):
        load((text + gear).replace("body>a", "body>c"))


def test_inertias(load):
    inertial = (
        "<inertial><pose>1 2 3 0 0 1.5707963267948966</pose><mass>2</mass><inertia><ixx>1</ixx><iyy>2</iyy>"
        "<izz>2.5</izz><ixy>0.1</ixy></inertia></inertial>"
    )
    found = load(link("a") + link("b", more=inertial) + joint("j", "revolute", "a", "b"))
    inertia = found.inertias["b"]
    assert inertia.mass == 2 and inertia.center.tolist() == [1, 2, 3]
    assert np.abs(inertia.tensor_along_link - [[2, -0.1, 0], [-0.1, 1, 0], [0, 0, 2.5]]).max() < 1e-15
    assert list(found.system().bodies) == ["b"]
    with pytest.raises(InputError, match="'inf', where a finite number is needed, in <mass>"):
        load(link("a", more=inertial.replace("<mass>2", "<mass>inf")))
    with pytest.raises(InputError, match="inertias of collision shapes are not computed"):
        load(link("a", more=inertial.replace("<inertial>", '<inertial auto="true">')))


UNIVERSAL = joint("u", "universal", "a", "b", axis("1 0 0") + axis("0 1 0").replace("axis>", "axis2>"))


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (link("c") + joint("u[0]", "revolute", "b", "c"), r"'u\[0\]' is the name of another joint and of a part of"),
        (link("c") + joint("u[1]", "revolute", "b", "c"), r"'u\[1\]' is the name of another joint"),
        (link("u[cross]") + joint("k", "revolute", "b", "u[cross]"), r"'u\[cross\]' is the name of another link"),
    ],
)
def test_parts_of_joints_with_two_axes_have_names_of_their_own(load, text, words):
    with pytest.raises(InputError, match=words + ".*<joint name='u'>.*Rename"):
        load(link("a") + link("b") + UNIVERSAL + text)


def test_followers_whose_names_look_like_parts(load):
    follow = '<mimic joint="{}"><multiplier>2</multiplier></mimic>'
    text = link("a") + link("b") + link("c") + joint("j", "revolute", "a", "b")
    found = load(text + joint("k[0]", "revolute", "b", "c", axis("0 0 1", follow.format("j"))))
    assert found.followers["k[0]"].joint == "j"
    with pytest.raises(InputError, match=r"no joint 'z' to follow, as in <joint name='k\[0\]'>"):
        load(text + joint("k[0]", "revolute", "b", "c", axis("0 0 1", follow.format("z"))))
    found = load(text + UNIVERSAL.replace("<parent>a", "<parent>b").replace("<child>b", "<child>c").replace(
        "<xyz>1 0 0</xyz>", "<xyz>1 0 0</xyz>" + follow.format("j")))  # fmt: skip
    assert found.followers["u[0]"].joint == "j" and found.joint_names == ("j", "u[1]")


@pytest.mark.parametrize("version", ["1.\u00b2", "1.", "1." + "9" * 5000])
def test_versions_that_are_no_numbers(load, version):
    assert load(link("a") + link("b") + joint("j", "revolute", "a", "b"), version=version).joint_names == ("j",)


@pytest.mark.parametrize("size", [1e-12, 1e200, 1e308])
def test_vectors_of_any_length(load, size):
    pose = at(f"0 0 0 {size} 0 0 {size}", rotation_format="quat_xyzw")
    found = load(link("a") + link("b", pose) + joint("j", "revolute", "a", "b", axis(f"{size} {size} 0")))
    assert np.abs(found.joints["j"].axis - [0.5**0.5, 0.5**0.5, 0]).max() < 1e-15
    assert np.abs(found.joints["j"].origin[:3, :3] - [[1, 0, 0], [0, 0, -1], [0, 1, 0]]).max() < 1e-15


BOMB = '<!DOCTYPE s [<!ENTITY a "ha"><!ENTITY b "&a;&a;">]><sdf><model name="&b;"><link name="a"/></model></sdf>'
TWO = link("a") + link("b")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (BOMB, "robot.sdf:1: a document type is declared"),
        ("<sdf><model", "this is not XML"),
        ("<robot><sdf/></robot>", "this is not an SDF: its root <robot>"),
        ("<sdf>" + "<a>" * 9000 + "</a>" * 9000 + "</sdf>", "nested deeper"),
        ("<sdf/>", "there is no <model>"),
        ('<sdf><model name="m"><model name="n"/></model></sdf>', "there is a second model: <model name='n'>"),
        ("<plugin/>", "there are no links"),
        (link("a") + "<include/>", "a tag is not known.*<include>.*ignore="),
        (link("a") + link("a"), "a name is taken already: <link name='a'>"),
        (link("world"), "a name is taken already"),
        (TWO + joint("a", "fixed", "a", "b"), "a link has the same name as <joint name='a'>"),
        (TWO, "no joints connect it to 'a': <link name='b'>"),
        (TWO + joint("j", "hinge", "a", "b"), "'hinge' is not a type of joint"),
        (TWO + joint("j", "revolute", "a", "c"), "there is no link 'c', as in <joint name='j'>"),
        (TWO + joint("j", "revolute", "a", "a"), "joined to itself"),
        (TWO + joint("j", "revolute", "a", ""), "there is no <child> in <joint name='j'>"),
        (TWO + joint("j", "revolute", "a", "b", ""), "there is no <axis> in <joint name='j'>"),
        (TWO + joint("j", "universal", "a", "b"), "there is no <axis2> in"),
        (TWO + joint("j", "revolute", "a", "b", axis("0 0 0")), "the axis of joint 'j' has no length in <xyz>"),
        (TWO + joint("j", "revolute", "a", "b", axis("0 0")), "3 finite numbers are needed, in <xyz>"),
        (TWO + joint("j", "revolute", "a", "b", axis("0 0 1", frame="f")), "there is no frame 'f', as in <xyz>"),
        (TWO + joint("j", "revolute", "a", "b", axis("0 0 1", "<limit><lower>2</lower><upper>1</upper></limit>")),
         "the limits are 2 and 1"),
        (TWO + joint("j", "screw", "a", "b", axis("0 0 1") + "<thread_pitch>0</thread_pitch>"), "thread_pitch is zero"),
        (link("a", at("0 0 0")) , "'0 0 0', where 6 finite numbers are needed, in <pose>"),
        (link("a", at("0 0 0 0 0 0", relative_to="b")) + link("b", at("0 0 0 0 0 0", relative_to="a"))
         + joint("j", "fixed", "a", "b"), "poses are relative to each other in a circle"),
        (link("a", at("0 0 0 0 0 0 0", rotation_format="quat_xyzw")), "a quaternion is zero in <pose>"),
        (TWO + joint("j", "revolute", "a", "b", axis("0 0 1", '<mimic joint="z"/>')), "no joint 'z' to follow"),
        ('<sdf><model name="m" canonical_link="z">' + link("a") + "</model></sdf>", "there is no link 'z'"),
    ],
)  # fmt: skip
def test_files_that_are_wrong(load, text, words):
    with pytest.raises(InputError, match=words) as caught:
        load(text)
    assert "robot.sdf" in str(caught.value)


@pytest.mark.peers
@pytest.mark.skipif(not real_robots(), reason="no package example-robot-data")
def test_cassie():
    """A legged robot with loops, as its maker describes it: ten motors, behind gears, and six springs."""
    folder = next(p for p in Path(next(iter(real_robots().values()))).parents if p.name == "robots")
    found = kinematics.load_sdf(folder / "cassie_description" / "robots" / "cassie.sdf")
    assert len(found.links) == 35 and len(found.loops) == 6 and len(found.followers) == 10
    mechanism = found.mechanism()
    assert mechanism.mobility() == 10 and mechanism.residual() < 1e-9
    for name in ("cassie_simple", "cassie_reduced", "cassie_v2", "cassie_wo_gearbox_spring"):
        other = kinematics.load_sdf(folder / "cassie_description" / "robots" / f"{name}.sdf")
        q = np.zeros(len(other.joint_names))
        assert len(other.loops) == 4 and len(other.system(q).joints) >= 26
