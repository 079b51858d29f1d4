"""Faults of mechanism files: messages name file, line, key and remedy."""

import pytest

from bladesmith.errors import InputError
from bladesmith.kinematics.io.reader import load_mechanism

from ...support.mechanisms.documents import CGA_PAIR, DELTA, FOUR, PAIR, written


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
         "joints[0] is refused: Prismatic('a', 'b') has one object; it is of two"),
        (CGA_PAIR + 'kind = "spherical"\nobjects = [{ kind = "point", xyz = "P" }, { kind = "point", xyz = "P" }]',
         "joints[0].objects are 2, which is not the number of objects of a spherical joint"),
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
    with pytest.raises(InputError, match="tip and root are of robots' files"):
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
