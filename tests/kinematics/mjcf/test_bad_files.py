"""MJCF files that are wrong, hostile, or include others; and robots that cannot be written."""

import os
import time
import warnings

import numpy as np
import pytest

import bladesmith as bs
from bladesmith import kinematics
from bladesmith.errors import InputError

from ..robots.texts import joint, link, robot
from .models import ARM


def model(body, more=""):
    return f"<mujoco>{more}\n<worldbody>\n{body}</worldbody></mujoco>"


HINGE = '<joint name="j"/><geom size="1"/>'
BODY = f'<body name="a">{HINGE}</body>'
TWO = '<body name="a"><joint name="j"/><geom size="1"/></body><body name="b"><joint name="k"/><geom size="1"/></body>'
BOMB = '<!DOCTYPE m [<!ENTITY a "ha"><!ENTITY b "&a;&a;&a;&a;">]><mujoco model="&b;"><worldbody/></mujoco>'


def equality(inside):
    return f"<equality>{inside}</equality>"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (BOMB, "robot.xml:1: a document type is declared"),
        ("<mujoco><worldbody>", "this is not XML: no element found"),
        ("<robot/>", "this is not an MJCF: its root <robot>"),
        ("<mujoco>" + "<a>" * 20000 + "</a>" * 20000 + "</mujoco>", "nested deeper than 512"),
        (model(""), "there are no bodies"),
        (model("<mujoco/>"), "robot.xml:3: a tag is not known.*<mujoco>.*ignore="),
        ("<mujoco><wordbody/></mujoco>", "did you mean 'worldbody'"),
        (model('<body name="a"><composite/></body>'), "a tag is not known.*<composite>"),
        (model(BODY + BODY), "robot.xml:3: the name 'a' is taken already: <body"),
        (model(BODY + '<body name="b"><joint name="j"/></body>'), "the name 'j' is taken already: <joint"),
        (model('<body name=" "/>'), "the name of a body is empty"),
        (model('<body name="a"><joint type="revolute"/></body>'), "type='revolute' is not known"),
        (model('<body name="a"><joint axis="0 0 0"/></body>'), "the axis has no length in <joint>"),
        (model('<body name="a"><joint axis="0 0"/></body>'), "axis='0 0', where 3 finite numbers are needed"),
        (model('<body name="a"><joint axis="0 0 nan"/></body>'), "3 finite numbers"),
        (model('<body name="a"><joint range="2 1"/></body>'), "range='2 1': least, then greatest"),
        (model('<body name="a"><joint limited="true"/></body>'), "range='': least, then greatest"),
        (model('<body name="a" quat="0 0 0 0"/>'), "quat='0 0 0 0' has no direction in <body name='a'>"),
        (model('<body name="a" xyaxes="1 0 0 2 0 0"/>'), "are parallel in"),
        (model('<body name="a" zaxis="0 0 0"/>'), "zaxis='0 0 0' has no direction"),
        (model('<body name="a" euler="1 2"/>'), "3 finite numbers"),
        (model('<body name="a"><joint class="b"/></body>'), "no default class 'b', as in <joint"),
        (model('<body name="a"><body name="b"><freejoint/></body></body>'), "a free joint is alone in its body"),
        (model('<body name="a"><joint name="j"/><freejoint/></body>'), "a free joint is alone in its body"),
        (model('<body name="a"><freejoint align="true"/></body>'), "frame is moved to its inertia's.*<freejoint>"),
        (model('<body name="a"><joint type="free"/></body>', '<compiler alignfree="true"/>'), "align.* as for <joint>"),
        (model('<body name="a"><geom size="-1"/></body>'), "size='-1', where 1 positive numbers are needed"),
        (model('<body name="a"><geom type="box" size="1"/></body>'), "where 3 positive numbers"),
        (model('<body name="a"><geom type="cube" size="1"/></body>'), "type='cube' is not known"),
        (model('<body name="a"><geom type="capsule" fromto="0 0 0 0 0 0" size="1"/></body>'), "has no length"),
        (model('<body name="a"><inertial mass="1" pos="0 0 0"/></body>'), "one of diaginertia and fullinertia"),
        (model('<body name="a"><inertial diaginertia="1 1 1"/></body>'), "there is no mass or no pos"),
        (model(BODY, '<compiler angle="grad"/>'), "angle='grad' is not known"),
        (model(BODY, '<compiler eulerseq="xyw"/>'), "eulerseq='xyw', where three of xyzXYZ"),
        (model(BODY, '<compiler coordinate="global"/>'), "coordinate='global' is not known"),
        (model(BODY, "<default><default/></default>"), "there is no class in <default>"),
        (model(TWO, equality('<connect body1="a" body2="c" anchor="0 0 0"/>')), "there is no body 'c'.*<connect>"),
        (model(TWO, equality('<connect body1="a" body2="a" anchor="0 0 0"/>')), "'a' is joined to itself"),
        (model(TWO, equality('<weld site1="s" site2="t"/>')), "there is no site 's', as in <weld>"),
        (model(TWO, equality('<joint joint1="j" joint2="l"/>')), "no hinge or slide 'l'.*<joint>"),
        (model(TWO, equality('<joint joint1="j" joint2="k" polycoef="0 1 2 0 0"/>')), "'0 1 2 0 0' is not linear"),
        (model(TWO, equality('<joint joint1="j" joint2="k"/><joint joint1="j" joint2="k"/>')), "follows another alr"),
        (model(TWO, equality('<joint joint1="j" joint2="k"/><joint joint1="k" joint2="j"/>')), "in a circle"),
        (model(TWO, equality("<glue/>")), "a tag is not known.*<glue>"),
    ],
)  # fmt: skip
def test_files_that_are_wrong(load, text, words):
    with pytest.raises(InputError, match=words) as caught:
        load(text)
    assert "robot.xml" in str(caught.value)


def test_options(load):
    text = model(TWO, equality('<joint joint1="j" joint2="k" polycoef="0 1 2 0 0"/>'))
    assert load(text, mimic="free").joint_names == ("j", "k")
    with pytest.raises(InputError, match="refused with mimic='error'"):
        load(text, mimic="error")
    assert load(model(BODY + "<other/>"), ignore=["other"]).joint_names == ("j",)
    for wrong in ({"mimic": "copy"}, {"ignore": "other"}, {"impossible": "never"}):
        with pytest.raises(InputError, match=next(iter(wrong))):
            load(model(BODY), **wrong)
    with pytest.warns(UserWarning, match=r"robot.xml:3: quat='0 0 0 2' is 2 long .* order is w, x, y, z") as caught:
        load(model('<body name="a" quat="0 0 0 2"><body name="b" quat="1 2 3 4"/></body>'))
    assert len(caught) == 1
    with pytest.warns(UserWarning, match="<tendon> is not read"):
        load(model(BODY, equality('<tendon tendon1="t"/>')))


@pytest.mark.parametrize("loader", [kinematics.load_mjcf, kinematics.load_sdf, kinematics.load_urdf])
def test_what_is_ignored_is_a_list_of_texts(tmp_path, loader):
    (tmp_path / "robot.x").write_text("<other/>")
    for wrong in (5, None, "tag", b"tag", ["tag", 3], [None]):
        with pytest.raises(InputError, match="^ignore is .*; a list of tags is needed"):
            loader(tmp_path / "robot.x", ignore=wrong)
    with pytest.raises(InputError, match="its root <other>") as caught:  # the file is found, and named
        loader(os.fsencode(tmp_path / "robot.x"), ignore={"tag"})
    assert f"{tmp_path / 'robot.x'}:1" in str(caught.value) and "b'" not in str(caught.value)


def test_armature_is_left_out_with_a_warning(load):
    with pytest.warns(UserWarning, match="armature is not read.* joints: 'j', 'body_2_joint'") as caught:
        load(model(BODY.replace('"j"', '"j" armature="0.5"') + '<body><joint class="c"/></body>',
                   '<default><default class="c"><joint armature="1"/></default></default>'))  # fmt: skip
    assert len(caught) == 1
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        load(model(BODY.replace('"j"', '"j" armature="0"')))


def test_made_up_names_leave_names_of_the_file_alone(load):
    found = load(model(
        '<body name="arm"/><body name="b"><joint name="arm_weld"/></body><body/><body name="body_3"/>'
        '<body name="a"><joint name="j"/><joint/></body><body name="a/j"><joint name="a_joint_2"/></body>'
    ))  # fmt: skip
    assert found.links == ("world", "arm", "b", "body_3_", "body_3", "a/j_", "a", "a/j")
    assert found.joint_names == ("arm_weld", "j", "a_joint_2_", "a_joint_2")
    assert found.joints["arm_weld_"].child == "arm" and found.joints["a_joint_2"].child == "a/j"


@pytest.mark.parametrize("size", [1e-12, 1.0, 1e200, 1e308])
def test_vectors_of_any_length(load, size):
    hinge, row = f'<joint name="j" axis="{size} 0 0"/>', f"{size} 0 0"
    found = load(model(f'<body name="a">{hinge}</body>'))
    assert found.joints["j"].axis.tolist() == [1, 0, 0]
    for place, turn in (
        (f'axisangle="{row} 90"', [[1, 0, 0], [0, 0, -1], [0, 1, 0]]),
        (f'xyaxes="0 {size} 0 {size} {size} 0"', [[0, 1, 0], [1, 0, 0], [0, 0, -1]]),
        (f'zaxis="{row}"', [[0, 0, 1], [0, 1, 0], [-1, 0, 0]]),
        (f'quat="{size} {row}"', [[0, 0, 1], [1, 0, 0], [0, 1, 0]]),
    ):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of quaternions that are not normalized
            text = model(f'<body name="a" {place}><joint name="j"/></body>')
            origin = load(text.replace(f"{size} {row}", f"{size} {size} {size} {size}")).joints["j"].origin
        assert np.abs(origin[:3, :3] - turn).max() < 1e-15


def test_includes(load, tmp_path):
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "arm.xml").write_text(
        '<mujocoinclude><body name="c"><joint name="l"/></body><include file="parts/leg.xml"/></mujocoinclude>'
    )
    (tmp_path / "parts" / "leg.xml").write_text('<mujocoinclude><body name="d"/></mujocoinclude>')
    (tmp_path / "again.xml").write_text('<mujoco><worldbody><include file="again.xml"/></worldbody></mujoco>')
    (tmp_path / "bad.xml").write_text("<mujocoinclude>\n<body/")
    found = load(model(BODY + '<include file="parts/arm.xml"/><body name="e"/>'))
    assert found.links == ("world", "a", "c", "d", "e") and found.joint_names == ("j", "l")
    for name, words in (
        ("../other.xml", "'../other.xml' is not in the model's folder, as in <include>"),
        ("/etc/hostname", "is not in the model's folder"), ("", "file='' is not in the model's folder"),
        ("robot.xml", "'robot.xml' is included a second time, or by itself"), ("none.xml", "cannot be read: No such"),
        ("again.xml", "'again.xml' is included a second time, or by itself"), ("bad.xml", "bad.xml:2: this is not XML"),
    ):  # fmt: skip
        with pytest.raises(InputError, match=words):
            load(model(f'<include file="{name}"/>'))
    with pytest.raises(InputError, match="a second time"):
        load(model('<include file="parts/leg.xml"/><include file="parts/leg.xml"/>'))


def test_many_includes_end(load, tmp_path):
    for i in range(300):
        (tmp_path / f"{i}.xml").write_text(f'<mujocoinclude><include file="{i + 1}.xml"/></mujocoinclude>')
    begin = time.perf_counter()
    with pytest.raises(InputError, match="more than 256 files are included"):
        load(model('<include file="0.xml"/>'))
    assert time.perf_counter() - begin < 5


def test_links_of_several_joints_are_named(load):
    found = load(ARM)
    assert found.root == "world" and found.links[:4] == ("world", "trunk/turn", "trunk/lift", "trunk")
    assert found.joints["free"].type == "floating" and found.joints["ball"].type == "ball"
    assert "body_3_joint" not in found.joints and found.joints["body_6_joint"].type == "prismatic"
    with pytest.raises(InputError, match=r"'free' is floating: nothing holds 'loose'.*mechanism\(root='loose'\)"):
        found.mechanism()
    assert found.mechanism(root="world").mobility() == 4 + 3 and found.mechanism(root="loose").mobility() == 1


def test_bodies_without_mass(load):
    found = load(model('<body name="a"><joint name="j"/><geom type="mesh" mesh="m"/></body>'.replace("mesh=", "mesh=")))
    assert found.mechanism().mobility() == 1
    with pytest.raises(InputError, match="no link that moves has a mass"):
        found.system()


def test_robots_that_cannot_be_written(tmp_path):
    def load(text):
        (tmp_path / "robot.urdf").write_text(text)
        return kinematics.load_urdf(tmp_path / "robot.urdf")

    out = tmp_path / "out.xml"
    bad = load(robot(link("a") + link("b", 1.0, (1.0, 1.0, 3.0)) + joint()))
    floating = load(robot(link("a") + link("b", 1.0) + joint(kind="floating", inside="")))
    world = load(robot(link("a") + link("world", 1.0) + joint(child="world")))
    for found, words in (
        (bad, "robot.urdf: .*exceeds the sum"), (floating, "'j' floats relative to 'a'"), (world, "is called 'world'"),
    ):  # fmt: skip
        with pytest.raises(InputError, match=words):
            kinematics.save_mjcf(found, out)
        assert not out.exists()
    with pytest.raises(InputError, match="robots are written as .xml or .mjcf"):
        kinematics.save_mjcf(bad, tmp_path / "out.urdf")
    with pytest.raises(InputError, match="a Robot"):
        kinematics.save_mjcf(3, out)
    bad.impossible = "nearest"
    with pytest.warns(UserWarning, match="the nearest ones are taken: <link name='b'>"):
        kinematics.save_mjcf(bad, out)
    light = load(robot(link("a") + link("b") + joint()))
    with pytest.warns(UserWarning, match="1e-09 kg and 1e-12 kg m.2 at least.*: b") as caught:
        kinematics.save_mjcf(light, out)
    assert caught[0].filename == __file__ and "boundmass" in out.read_text()


def test_types_of_joints_are_written(tmp_path):
    text = robot(
        link("world") + "".join(link(x, 1.0) for x in "bcde") + joint("f", "floating", "world", "b", "")
        + joint("p", "planar", "b", "c", '<axis xyz="0 1 1"/>')
        + joint("s", "prismatic", "c", "d", '<axis xyz="1 0 0"/>')
        + joint("w", "fixed", "d", "e", '<origin xyz="1 2 3"/>')
    )  # fmt: skip
    (tmp_path / "robot.urdf").write_text(text)
    found = kinematics.load_urdf(tmp_path / "robot.urdf", bs.pga3d)
    kinematics.save_mjcf(found, tmp_path / "out.mjcf")
    again = kinematics.load_mjcf(tmp_path / "out.mjcf")
    assert again.joint_names == ("p_x", "p_y", "p", "s") and again.joints["f"].type == "floating"
    part = again.mechanism(root="b")
    assert part.mobility() == 4 == found.mechanism(root="b").mobility()
