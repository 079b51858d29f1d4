"""Robots from URDF files against matrices written out here, and files that are wrong."""

from math import cos, sin
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

import bladesmith as bs
from bladesmith.dynamics import screw_coordinates
from bladesmith.errors import InputError
from bladesmith.kinematics.urdf.reader import load_urdf, urdf_example

ALGEBRAS = [bs.cga3d, bs.pga3d]
ARM = [("base", "flange"), ("base", "wrist_1"), ("forearm", "flange"), ("flange", "base"), ("wrist_2", "upper_arm")]


def rotation(rpy):
    """Fixed axes: about x, then y, then z."""
    r, p, y = rpy
    x = np.array([[1, 0, 0], [0, cos(r), -sin(r)], [0, sin(r), cos(r)]])
    about_y = np.array([[cos(p), 0, sin(p)], [0, 1, 0], [-sin(p), 0, cos(p)]])
    z = np.array([[cos(y), -sin(y), 0], [sin(y), cos(y), 0], [0, 0, 1]])
    return z @ about_y @ x


def numbers(text):
    return np.array([float(x) for x in text.split()])


def matrices(path, q):
    """Poses (4, 4) of all links, read and multiplied without any of the project."""
    root = ElementTree.parse(path).getroot()
    joints = {j.find("child").get("link"): j for j in root.findall("joint")}
    found = {}

    def pose(link):
        if link in found:
            return found[link]
        joint = joints.get(link)
        if joint is None:
            return np.eye(4)
        own, origin = np.eye(4), joint.find("origin")
        if origin is not None:
            own[:3, :3] = rotation(numbers(origin.get("rpy", "0 0 0")))
            own[:3, 3] = numbers(origin.get("xyz", "0 0 0"))
        axis = joint.find("axis")
        u = numbers(axis.get("xyz")) if axis is not None else np.array([1.0, 0, 0])
        u, x = u / np.linalg.norm(u), q.get(joint.get("name"), 0.0)
        moved = np.eye(4)
        if joint.get("type") == "prismatic":
            moved[:3, 3] = x * u
        elif joint.get("type") in ("revolute", "continuous"):
            k = np.array([[0, -u[2], u[1]], [u[2], 0, -u[0]], [-u[1], u[0], 0]])
            moved[:3, :3] = np.eye(3) + sin(x) * k + (1 - cos(x)) * k @ k
        found[link] = pose(joint.find("parent").get("link")) @ own @ moved
        return found[link]

    return {link.get("name"): pose(link.get("name")) for link in root.findall("link")}


def robot(body, name="robot"):
    return f'<robot name="{name}">{body}</robot>'


def joint(name="j", kind="revolute", parent="a", child="b", inside='<axis xyz="0 0 1"/>'):
    return f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>{inside}</joint>'


TWO = '<link name="a"/><link name="b"/>'


@pytest.fixture
def load(tmp_path):
    def loaded(text, *arguments, **options):
        path = tmp_path / "robot.urdf"
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return load_urdf(path, *arguments, **options)

    return loaded


# -- what a file says ------------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("algebra", ALGEBRAS, ids=lambda a: a.name)
@pytest.mark.parametrize("name", ["arm", "scara"])
def test_poses_of_links(name, algebra):
    path = urdf_example(name)
    found = load_urdf(path, algebra)
    rng = np.random.default_rng(0)
    for _ in range(3):
        q = dict(zip(found.joint_names, rng.uniform(-2, 2, len(found.joint_names)), strict=True))
        truth = matrices(path, q)
        for given in (q, list(q.values())):
            poses = found.poses(given)
            assert list(poses) == list(found.links)
            for link, motor in poses.items():
                assert np.abs(algebra.matrix(motor) - truth[link]).max() < 1e-14


@pytest.mark.parametrize("algebra", ALGEBRAS, ids=lambda a: a.name)
@pytest.mark.parametrize(("root", "tip"), ARM)
def test_chains_between_links(root, tip, algebra):
    path = urdf_example("arm")
    found = load_urdf(path, algebra)
    chain = found.chain(tip, root)
    rng = np.random.default_rng(1)
    q = rng.uniform(-2, 2, (5, len(chain)))
    poses, links = algebra.matrix(chain.forward(q)), algebra.matrix(chain.forward(q, all=True))
    for x, pose, frames in zip(q, poses, links, strict=True):
        truth = matrices(path, dict(zip(chain.names, x, strict=True)))
        base = np.linalg.inv(truth[root])
        assert np.abs(pose - base @ truth[tip]).max() < 1e-14
        behind = [found.joints[name].child if root == "base" else None for name in chain.names]
        for link, frame in zip(behind, frames, strict=True):
            assert link is None or np.abs(frame - base @ truth[link]).max() < 1e-14
    assert set(chain.names) <= set(found.joint_names)
    assert chain.limits.tolist() == [found.joints[name].limits.tolist() for name in chain.names]


def test_reversed_chains_have_frames_too():
    found = load_urdf(urdf_example("arm"))
    chain = found.chain("base", "flange")
    assert chain.names == tuple(reversed(found.joint_names))
    q = np.linspace(0.2, 1.2, 6)
    truth = matrices(urdf_example("arm"), dict(zip(chain.names, q, strict=True)))
    base = np.linalg.inv(truth["flange"])
    for name, frame in zip(chain.names, bs.cga3d.matrix(chain.forward(q, all=True)), strict=True):
        assert np.abs(frame - base @ truth[found.joints[name].parent]).max() < 1e-14


def test_limits_and_names_of_the_scara():
    found = load_urdf(urdf_example("scara"))
    chain = found.chain("gripper")
    assert chain.names == ("inner", "outer", "plunge", "spin")
    assert chain.limits.tolist() == [[-2.4, 2.4], [-2.6, 2.6], [0, 0.2], [-np.inf, np.inf]]
    assert found.root == "base" and found.name == "scara" and chain.freedom == 4
    q = np.array([[0.3, -0.8, 0.1, 2.0], [-1.0, 1.5, 0.15, -0.4]])
    solved, status = chain.inverse(chain.forward(q))
    assert (status == 0).all()
    assert np.abs(chain.forward(solved).values - chain.forward(q).values).max() < 1e-12
    assert found.chain("spindle", "outer_arm").names == ("plunge",)


@pytest.mark.parametrize("algebra", ALGEBRAS, ids=lambda a: a.name)
def test_mechanisms_move_as_their_chains_do(algebra):
    for name, tip in (("arm", "flange"), ("scara", "gripper")):
        found = load_urdf(urdf_example(name), algebra)
        chain = found.chain(tip)
        q = np.random.default_rng(3).uniform(0.02, 0.19, len(chain))
        mechanism = found.mechanism(q)
        assert mechanism.bodies == found.links and mechanism.fixed == "base"
        assert mechanism.mobility() == len(chain) and mechanism.residual() < 1e-9
        speeds = np.arange(1.0, len(chain) + 1)
        twists = mechanism.solve(dict(zip(chain.names, speeds, strict=True)))
        assert np.abs(screw_coordinates(twists[tip]) - chain.jacobian(q) @ speeds).max() < 1e-9


@pytest.mark.parametrize("algebra", ALGEBRAS, ids=lambda a: a.name)
def test_bodies_and_systems(algebra):
    path = urdf_example("arm")
    found = load_urdf(path, algebra)
    q = dict.fromkeys(found.joint_names, 0.4)
    truth, bodies = matrices(path, q), found.bodies(q)
    root = ElementTree.parse(path).getroot()
    for link in root.findall("link"):
        inertial = link.find("inertial")
        if inertial is None or link.get("name") == "base":
            assert link.get("name") not in bodies
            continue
        body, origin = bodies[link.get("name")], inertial.find("origin")
        own = np.eye(4)
        own[:3, :3], own[:3, 3] = rotation(numbers(origin.get("rpy"))), numbers(origin.get("xyz"))
        frame = truth[link.get("name")] @ own
        assert body.mass == float(inertial.find("mass").get("value"))
        assert np.abs(body.position - frame[:3, 3]).max() < 1e-14
        i = {k: float(v) for k, v in inertial.find("inertia").attrib.items()}
        tensor = np.array(
            [[i["ixx"], i["ixy"], i["ixz"]], [i["ixy"], i["iyy"], i["iyz"]], [i["ixz"], i["iyz"], i["izz"]]]
        )
        world = body.rotation @ body.axes @ np.diag(body.moments) @ (body.rotation @ body.axes).T
        assert np.abs(world - frame[:3, :3] @ tensor @ frame[:3, :3].T).max() < 1e-15
    system = found.system(q)
    assert system.fixed == "base" and len(system.bodies) == 6 and len(system.joints) == 6


def test_every_type_of_joint(load):
    text = robot(
        '<link name="a"/><link name="b"/><link name="c"/><link name="d"/><link name="e"/><link name="f"/>'
        + joint("r", "continuous", "a", "b", '<origin xyz="1 0 0"/><axis xyz="0 3 0"/>')
        + joint("p", "prismatic", "b", "c", '<axis xyz="0 0 -2"/><limit lower="-1" upper="2" effort="1" velocity="1"/>')
        + joint("x", "fixed", "c", "d", '<origin rpy="0.1 0.2 0.3" xyz="1 2 3"/>')
        + joint("l", "planar", "a", "e", '<axis xyz="0 0 1"/>')
        + joint("o", "floating", "d", "f", "")
    )
    for algebra in ALGEBRAS:
        found = load(text, algebra)
        assert found.joint_names == ("r", "p")
        assert found.joints["p"].axis.tolist() == [0, 0, -1] and found.limits.tolist() == [[-np.inf, np.inf], [-1, 2]]
        with pytest.raises(InputError, match="'o' is floating: nothing holds 'f'"):
            found.mechanism()
        mechanism = found.mechanism({"r": 0.3, "p": 0.5}, root="a")
        assert mechanism.bodies == ("a", "b", "c", "d", "e") and mechanism.mobility() == 1 + 1 + 3
        assert found.mechanism(root="f").bodies == ("f",)
        truth = matrices(Path(found.path), {"r": 0.3, "p": 0.5})
        pose = algebra.matrix(found.chain("d").forward([0.3, 0.5]))
        assert np.abs(pose - truth["d"]).max() < 1e-14
    with pytest.raises(InputError, match="'l' is planar"):
        found.chain("e")
    with pytest.raises(InputError, match="'o' is floating"):
        found.chain("f")
    with pytest.raises(InputError, match="no joint moves between 'c' and 'd'"):
        found.chain("d", "c")
    with pytest.raises(InputError, match=r"no link 'g'.*there are: a, b"):
        found.chain("g")
    with pytest.raises(InputError, match="not a moving joint"):
        found.poses({"x": 1.0})
    with pytest.raises(InputError, match="q has shape"):
        found.poses([1.0])


def test_looks_and_transmissions_are_passed_over_in_silence(load, capfd, recwarn):
    text = robot(
        '<material name="red"><color rgba="1 0 0"/></material>'
        '<link name="a"><visual><geometry><mesh filename="http://nowhere.example/none.stl"/></geometry></visual>'
        '<collision><geometry><mesh filename="package://x/none.stl"/></geometry></collision></link><link name="b"/>'
        + joint(inside='<axis xyz="0 0 1"/><dynamics damping="x"/><safety_controller k_velocity="1"/>')
        + '<transmission name="t"><type>any</type></transmission><gazebo reference="a"/><ros2_control name="c"/>'
    )
    assert load(text).joint_names == ("j",)
    assert capfd.readouterr() == ("", "") and not recwarn.list


def test_inertia_without_a_body(load):
    text = robot(
        '<link name="a"/><link name="b"/><link name="c"><inertial><mass value="1"/>'
        '<inertia ixx="1" iyy="1" izz="1"/></inertial></link>' + joint() + joint("k", parent="b", child="c")
    )
    with pytest.raises(InputError, match=r"name='b'> moves by <joint name='j'>, carries others, and has no mass"):
        load(text).system()
    impossible = text.replace('izz="1"', 'izz="5"')
    with pytest.raises(InputError, match=r"robot.urdf: .*name='c'.*a principal moment of 5, which exceeds.*others, 2"):
        load(impossible).bodies()


def test_joints_that_follow_others(load):
    text = robot(
        '<link name="a"/><link name="b"/><link name="c"/>' + joint()
        + joint("k", parent="a", child="c", inside='<axis xyz="0 0 1"/><mimic joint="j" multiplier="-1"/>')
    )  # fmt: skip
    with pytest.raises(InputError, match=r"robot.urdf:1: .*mimic.*name='k'.*mimic='follow'"):
        load(text, mimic="error")
    assert load(text, mimic="free").joint_names == ("j", "k")
    assert load(text).joint_names == ("j",)


# -- files that are wrong ----------------------------------------------------------------------------------------

BOMB = (
    '<?xml version="1.0"?><!DOCTYPE robot [<!ENTITY a "ha"><!ENTITY b "&a;&a;&a;&a;"><!ENTITY c "&b;&b;&b;&b;">]>'
    '<robot name="&c;"><link name="a"/></robot>'
)
OUTSIDE = '<!DOCTYPE robot [<!ENTITY x SYSTEM "file:///etc/hostname">]><robot name="r"><link name="&x;"/></robot>'
REMOTE = '<!DOCTYPE robot SYSTEM "http://nowhere.example/robot.dtd"><robot name="r"><link name="a"/></robot>'


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (BOMB, "robot.urdf:1: a document type is declared"),
        (OUTSIDE, "a document type is declared"),
        (REMOTE, "a document type is declared"),
        ("", "this is not XML: no element found"),
        ("solid cube\n", "this is not XML: syntax error"),
        ("<robot>\n<link name='a'>\n</robot>", "robot.urdf:3: this is not XML: mismatched tag"),
        (b"\xff\xfe\x00", "this is not XML"),
        ("<sdf version='1.9'/>", "this is not a URDF: its root <sdf>"),
        (robot(""), "there are no links"),
        (robot('<link name="a"/>\n<link name="a"/>'), "robot.urdf:2: a name is taken already: <link name='a'>"),
        (robot("<link/>"), "there is no name in <link>"),
        (robot('<link name=" "/>'), "there is no name in <link"),
        (robot(TWO + '<link name="c"/>' + joint() + joint(child="c")), "taken already: <joint"),
        (robot(TWO), "the links 'a' and 'b' are not connected"),
        (robot(TWO + joint(parent="z")), r"there is no link 'z', as in <joint name='j'>"),
        (robot('<link name="arm"/><link name="b"/>' + joint(parent="amr")), r"did you mean 'arm'"),
        (robot(TWO + joint(child="a")), "joined to itself"),
        (robot(TWO + joint() + joint("k", parent="b", child="a")), "is its own ancestor"),
        (robot(TWO + joint() + joint("k")), "the link 'b' has two parents"),
        (robot('<link name="a"/><link name="b"/><link name="c"/>' + joint(parent="b", child="c")
               + joint("k", parent="c", child="b")), "own ancestor"),
        (robot(TWO + joint().replace('<parent link="a"/>', "")), "there is no <parent link=...> in <joint name='j'>"),
        (robot(TWO + joint().replace('<child link="b"/>', "")), "there is no <child link=...> in"),
        (robot(TWO + joint().replace('<child link="b"/>', "<child/>")), "there is no 'link' in <child>"),
        (robot(TWO + joint(kind="hinge")), "'hinge' is not a type of joint"),
        (robot(TWO + joint(kind="revolut")), "did you mean 'revolute'"),
        (robot(TWO + joint().replace('type="revolute"', "")), "None is not a type of joint"),
        (robot(TWO + joint(inside='<axis xyz="0 0 0"/>')), "the axis has no length in <joint name='j'>"),
        (robot(TWO + joint(inside='<axis xyz="0 0 nan"/>')), "3 finite numbers are needed, in <axis>"),
        (robot(TWO + joint(inside='<axis xyz="0 1"/>')), "3 finite numbers"),
        (robot(TWO + joint(inside='<axis xyz="up"/>')), "3 finite numbers"),
        (robot(TWO + joint(inside="<axis/>")), "there is no 'xyz' in <axis>"),
        (robot(TWO + joint(inside='<origin xyz="0 0 inf"/>')), "3 finite numbers are needed, in <origin>"),
        (robot(TWO + joint(inside='<origin quat_xyzw="0 0 0 1"/>')), "quat_xyzw='0 0 0 1' is not known"),
        (robot(TWO + joint(inside='<origin xyz="0 0 0"/><origin xyz="0 0 1"/>')), "there is a second <origin>"),
        (robot(TWO + joint(inside='<limit lower="a" upper="1"/>')), "a finite number is needed, in <limit>"),
        (robot(TWO + joint(inside='<limit lower="2" upper="1"/>')), "the limits are 2 and 1"),
        (robot(TWO + joint(inside="<axes/>")), r"a tag is not known \(did you mean 'axis'\?\).*ignore=\['axes'\]"),
        (robot(TWO + joint() + "<loop/>"), "may change how the robot moves: <loop>"),
        ('<robot name="r" xmlns:xacro="http://ros.org/xacro"><xacro:include filename="x"/></robot>', "a xacro"),
        (robot('<link name="a"><inertial><mass value="1"/></inertial></link>'), "there is no <inertia> in <inertial>"),
        (robot('<link name="a"><inertial><mass value="heavy"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link>'),
         "value='heavy', where a finite number is needed, in <mass>"),
    ],
)  # fmt: skip
def test_files_that_are_wrong(load, text, words):
    with pytest.raises(InputError, match=words) as caught:
        load(text)
    assert "robot.urdf" in str(caught.value)


def test_tags_may_be_ignored_by_name(load):
    text = robot(TWO + joint(inside='<axis xyz="0 0 1"/><spring/>') + "<loop/>")
    assert load(text, ignore=["loop", "spring"]).joint_names == ("j",)
    with pytest.raises(InputError, match="a list of tags"):
        load(text, ignore="loop")


def test_paths_that_are_none(tmp_path):
    with pytest.raises(InputError, match=r"missing.urdf: the file cannot be read: No such file"):
        load_urdf(tmp_path / "missing.urdf")
    with pytest.raises(InputError, match="plain file"):
        load_urdf(tmp_path)
    with pytest.raises(InputError, match="3 names none"):
        load_urdf(3)
    with pytest.raises(InputError, match="robot"):
        urdf_example("tank")
    with pytest.raises(InputError, match="mimic"):
        load_urdf(urdf_example("arm"), mimic="copy")


@pytest.mark.compiles
def test_deep_and_long_texts(load):
    deep = robot('<link name="a">' + "<x>" * 20000 + "</x>" * 20000 + "</link>")
    with pytest.raises(InputError, match="robot.urdf:1: elements are nested deeper than 512, as <x> is"):
        load(deep)
    links = "".join(f'<link name="l{i}"/>' for i in range(301))
    joints = "".join(
        joint(f"j{i}", "revolute", f"l{i}", f"l{i + 1}", '<origin xyz="0.1 0 0"/><axis xyz="0 0 1"/>')
        for i in range(300)
    )
    found = load(robot(links + joints))
    chain = found.chain("l300")
    assert len(chain) == 300
    pose = bs.cga3d.matrix(chain.forward(np.full(300, 2 * np.pi / 300)))
    assert np.abs(pose[:3, :3] - np.eye(3)).max() < 1e-13 and np.abs(pose[:3, 3]).max() < 1e-12


def test_a_robot_answers_as_its_mechanism_does():
    robot = load_urdf(urdf_example("arm"))
    made = robot.mechanism()
    assert robot.mobility() == made.mobility() == 6 and robot.residual() == 0
    names = list(robot.joint_names)
    assert np.array_equal(robot.jacobian(names, robot.links[-1]), made.jacobian(names, robot.links[-1]))
    with pytest.raises(AttributeError):
        robot.mobilty  # noqa: B018


@pytest.mark.parametrize("size", ["1e-320", "1e-200", "1e200", "1e308"])
def test_axes_of_any_length(load, size):
    found = load(robot(TWO + joint(inside=f'<axis xyz="{size} 0 -{size}"/>')))
    assert np.abs(found.joints["j"].axis - [0.5**0.5, 0, -(0.5**0.5)]).max() < 1e-15
