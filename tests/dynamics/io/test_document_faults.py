"""Simulation files with faults: every one is told with file, line and key, and none raises anything else."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

from bladesmith import dynamics
from bladesmith.errors import InputError

from ...support.dynamics.documents import BODY, EXAMPLES, GRAVITY, HOSTILE, RUN, read

PIN = '[[constraints]]\nkind = "pin"\n'
HINGE = '[[joints]]\nkind = "revolute"\nname = "elbow"\na = "base"\nb = "body"\npoint = [0, 0, 1]\naxis = [1, 0, 0]\n'
FAULTS = [
    ("", "simulation is missing"),
    (RUN, "has no body. Describe one under [body]"),
    (BODY + RUN + "\n[[bodies]]\nmass = 1.0\nmoments = [1, 1, 1]", "line 2: body and bodies are both there"),
    (BODY, "simulation is missing"),
    (BODY.replace("mass", "mas") + RUN, "line 3: body.mas is not a known key; did you mean 'mass'?"),
    (BODY.replace("mass = 2.0", "mass = -2.0") + RUN, "line 3: body.mass is -2.0; a mass is positive"),
    (BODY.replace("mass = 2.0", 'mass = "2"') + RUN, 'line 3: body.mass is "2"; a number is needed'),
    (BODY.replace("mass = 2.0", "mass = nan") + RUN, "line 3: body.mass is nan; numbers are finite"),
    (BODY.replace("mass = 2.0", "mass = 1e61") + RUN, "body.mass is 1e+61; a mass is at most 1e+60"),
    (BODY.replace("mass = 2.0", "") + RUN, "line 2: body: has neither mass nor density; one is needed"),
    (BODY.replace("mass = 2.0", "mass = 2.0\ndensity = 1.0") + RUN, "body: mass and density say the same thing"),
    (BODY.replace("mass = 2.0", "density = 1.0") + RUN, "body: a density goes with a shape alone"),
    (BODY.replace("moments = [1.0, 2.0, 2.5]", "") + RUN, "body: has neither moments nor tensor nor shape"),
    (BODY.replace("2.5]", "3.5]") + RUN, "line 4: body.moments is refused: the largest principal moment exceeds"),
    (BODY.replace("moments = [1.0, 2.0, 2.5]", "tensor = [[1, 0.2, 0], [0, 1, 0], [0, 0, 1]]") + RUN,
     "line 4: body.tensor is refused: the inertia is not symmetric"),
    (BODY.replace("moments = [1.0, 2.0, 2.5]", 'shape = { kind = "bx", size = [1, 1, 1] }') + RUN,
     "line 4: body.shape.kind is \"bx\"; did you mean 'box'?"),
    (BODY.replace("moments = [1.0, 2.0, 2.5]", 'shape = { kind = "box", radius = 1 }') + RUN,
     "body.shape.radius is not a key of 'box'; it is for 'sphere' and 'cylinder' and 'cone' and 'rod'"),
    (BODY.replace("moments = [1.0, 2.0, 2.5]", 'shape = { kind = "rod", length = 1, axis = [0, 0, 0] }') + RUN,
     "body.shape.axis is [0, 0, 0]; a direction is not zero"),
    (BODY + "orientation = { axis = [1, 0, 0] }" + RUN, "body.orientation: has neither angle nor degrees"),
    (BODY + "orientation = { degrees = 3 }" + RUN, "body.orientation: has neither matrix nor quaternion nor axis"),
    (BODY + "orientation = { quaternion = [1, 1, 0, 0] }" + RUN, "a quaternion w, x, y, z has the length 1"),
    (BODY + "orientation = { quaternion = [1, 0, 0, 0], degrees = 3 }" + RUN, "an angle goes with an axis"),
    (BODY + "orientation = { matrix = [[2, 0, 0], [0, 1, 0], [0, 0, 1]] }" + RUN,
     "line 6: body.orientation.matrix is refused: "),
    (BODY + 'position_point = "tap"' + RUN,
     "line 6: body.position_point is 'tap', which is not a point of body (did you mean 'tip'?); there are: tip"),
    (BODY + 'velocity_point = "up"' + RUN, "body.velocity_point is 'up', which is not a point of body; there are: tip"),
    (BODY + 'name = "base"' + RUN, "line 6: body.name is 'base', which is what joints call the world"),
    (BODY + 'name = "_x"' + RUN, 'body.name is "_x"; it begins with a letter or digit'),
    (BODY + 'name = "a\\nb"' + RUN, "it begins with a letter or digit, and has 60 printable letters"),
    (BODY + 'color = "blu"' + RUN, "line 6: body.color is \"blu\"; did you mean 'blue'?"),
    (BODY + 'color = "url(x)"' + RUN, 'body.color is "url(x)"; known: blue, red'),
    (BODY + "[[loads]]\nkind = \"gravty\"" + RUN, "line 7: loads[0].kind is \"gravty\"; did you mean 'gravity'?"),
    (BODY + "[[loads]]\nforce = [1, 0, 0]" + RUN, "line 6: loads[0] has no kind, which says what it is"),
    (BODY + '[[loads]]\nkind = "body_wrench"' + RUN, "loads[0]: has neither force nor couple; one is needed"),
    (BODY + HINGE + '[[loads]]\nkind = "joint_torque"\njoint = "elbo"\ntorque = 1' + RUN,
     "loads[0].joint is 'elbo', which is not a joint (did you mean 'elbow'?); there are: elbow"),
    (BODY + HINGE + HINGE + '[[loads]]\nkind = "joint_torque"\njoint = "elbow"\ntorque = 1' + RUN,
     "loads[0].joint is 'elbow', the name of several joints"),
    (BODY + HINGE + '[[loads]]\nkind = "joint_spring"\njoint = "elbow"' + RUN,
     "loads[0] has no stiffness, which is required"),
    (BODY + HINGE + '[[loads]]\nkind = "joint_damper"\njoint = "elbow"\ndamping = -1' + RUN,
     "loads[0] is refused: the damping of a JointDamper"),
    (BODY + HINGE + '[[loads]]\nkind = "joint_torque"\njoint = "elbow"\ntorque = nan' + RUN, "numbers are finite"),
    (BODY + HINGE + '[[loads]]\nkind = "joint_torque"\njoint = "elbow"\ntorque = 1\nfreedom = 1' + RUN,
     "has 1 freedoms, and none has the number 1"),
    (BODY + '[[loads]]\nkind = "world_wrench"\ncouple = [1, 0, 0]\npoint = [0, 0, 0]' + RUN,
     "loads[0]: a point goes with a force"),
    (BODY + '[[loads]]\nkind = "world_wrench"\nforce = [1, 0, 0]\npoint = "tip"' + RUN,
     "line 9: loads[0].point is 'tip', a name; of the world three numbers are needed"),
    (BODY + '[[loads]]\nkind = "spring"\npoint = "tip"\nanchor = [0, 0]\nstiffness = 1' + RUN,
     "line 9: loads[0].anchor is [0, 0]; three numbers, or the name of one of the body's points, are needed"),
    (BODY + '[[loads]]\nkind = "spring"\npoint = "tip"\nanchor = [0, 0, 0]\nstiffness = 1\nlength = -1' + RUN,
     "line 11: loads[0].length is -1; a length is at least 0"),
    (BODY + '[[loads]]\nkind = "damper"\nbody = "bdy"' + RUN,
     "line 8: loads[0].body is 'bdy', which is not a body (did you mean 'body'?); there are: body"),
    (BODY + PIN + RUN, "line 6: constraints[0] has no object, which is required"),
    (BODY + PIN + 'object = { kind = "point", xyz = "tp" }' + RUN,
     "line 8: constraints[0].object.xyz is 'tp', which is not a point of body (did you mean 'tip'?)"),
    (BODY + PIN + 'object = { kind = "point", xyz = "tip" }\nworld = { kind = "direction", v = [0, 0, 1] }' + RUN,
     "line 9: constraints[0].world is a direction, the object a point"),
    (BODY + PIN + 'object = { kind = "plane", normal = [0, 0, 1] }' + RUN,
     "constraints[0].object: has neither offset nor point; one is needed"),
    (BODY + PIN + 'object = { kind = "circle", center = "tip", normal = [0, 0, 1], radius = 0 }' + RUN,
     "constraints[0].object.radius is 0; a radius is positive"),
    (BODY + PIN + 'object = { kind = "point_pair", a = "tip", b = "tip" }' + RUN,
     "line 8: constraints[0].object is refused: "),
    (BODY + PIN + 'object = { kind = "point", xyz = "tip" }\nother = "body"' + RUN,
     "line 9: constraints[0].other is 'body', the same body"),
    (BODY + '[[constraints]]\nkind = "incidence"\npoint = "tip"\non = { kind = "point", xyz = [0, 0, 0] }' + RUN,
     "line 9: constraints[0].on.kind is \"point\"; known: line, circle, plane, sphere"),
    (BODY + '[[constraints]]\nkind = "virtual_power"\nwrenches = []' + RUN,
     "line 8: constraints[0].wrenches is []; it has 0 items where 1 are the least"),
    (BODY + '[[joints]]\nkind = "revolute"\na = "base"\nb = "bode"\npoint = [0, 0, 0]\naxis = [0, 0, 1]' + RUN,
     "line 9: joints[0].b is 'bode', which is not a body (did you mean 'body'?)"),
    (BODY + '[[joints]]\nkind = "revolute"\na = "base"\nb = "base"\npoint = [0, 0, 0]\naxis = [0, 0, 1]' + RUN,
     "line 9: joints[0].b is 'base', the same as a"),
    (BODY + '[[joints]]\nkind = "universal"\na = "base"\nb = "body"\npoint = [0, 0, 0]\n'
     "axis_a = [0, 0, 1]\naxis_b = [1, 0, 1]" + RUN, "line 6: joints[0] is refused: "),
    (BODY + RUN.replace("0.1", "0"), "line 8: simulation.duration is 0; a duration is positive"),
    (BODY + RUN + "interval = 1e-9", "line 9: simulation.interval is 1e-09: more than 5000000 states in 0.1. Store"),
    (BODY + RUN + "interval = 0.01\ntimes = [0.1]", "simulation: interval and times say the same thing"),
    (BODY + RUN + "times = [0.05, 0.05]", "line 9: simulation.times[1] is 0.05; times rise from 0 to the duration"),
    (BODY + RUN + "times = [0.2]", "line 9: simulation.times[0] is 0.2; times rise"),
    (BODY + RUN + 'integrator = "rk3"', "line 9: simulation.integrator is \"rk3\"; did you mean 'rk4'?"),
    (BODY + RUN + 'map = "log"', 'simulation.map is "log"; known: exponential, bortz, cayley, outer'),
    (BODY + RUN + 'stabilization = "projecton"', "did you mean 'projection'?"),
    (BODY + RUN + 'algebra = "cga"', "line 9: simulation.algebra is \"cga\"; did you mean 'cga3d'?"),
    (BODY + RUN + '[[traces]]\npoint = "tipp"', "line 10: traces[0].point is 'tipp', which is not a point of body"),
    (BODY + RUN + '[[traces]]\npoint = true', "traces[0].point is true; three numbers, or the name"),
    (BODY + RUN + "[picture]\nshown = [0.2]", "line 10: picture.shown[0] is 0.2, after the end at 0.1"),
    (BODY + RUN + "[picture]\nelevation = 91.0", "picture.elevation is 91.0; an elevation is at most 90"),
    (BODY + RUN + '[units]\nlength = "<b>"', 'line 10: units.length is "<b>"; a unit has 12 letters'),
    (BODY + BODY.replace("[body]", "[body]") + RUN, "annot declare ('body',) twice"),
    ("[[bodies]]\nmass = 1\nmoments = [1, 1, 1]\n[[bodies]]\nmass = 1\nmoments = [1, 1, 1]" + RUN,
     "line 4: bodies[1].name is 'body', the name of another body"),
    ('[[bodies]]\nname = "a"\nmass = 1\nmoments = [1, 1, 1]\n[[bodies]]\nname = "b"\nmass = 1\nmoments = [1, 1, 1]\n'
     '[[traces]]\npoint = [0, 0, 0]' + RUN, "line 9: traces[0] has no body, which is required: a, b"),
    ("x = " + "[" * 3000 + "]" * 3000, "nested too deeply"),
    ("x = 1" + "0" * 5000, "a whole number has thousands of digits"),
    ("[body", "expected ']'"),
]  # fmt: skip


@pytest.mark.parametrize(("text", "says"), FAULTS, ids=[says[-40:] for _, says in FAULTS])
def test_every_fault_is_told_with_file_line_and_key(text, says, tmp_path):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(InputError) as error:
            read(tmp_path, text)
    assert str(tmp_path / "body.toml") in str(error.value) and says in str(error.value)
    assert "\n" not in str(error.value) or "\\n" in text


def test_faults_of_files_that_are_none(tmp_path):
    with pytest.raises(InputError, match=r"none.toml: cannot be read: No such file"):
        dynamics.load_simulation(tmp_path / "none.toml")
    with pytest.raises(InputError, match="3 names none"):
        dynamics.load_simulation(3)
    with pytest.raises(InputError, match="null character"):
        dynamics.load_simulation("a\0b")
    (tmp_path / "body.toml").write_bytes(b"\xff\xfe")
    with pytest.raises(InputError, match=r"is not UTF-8 text \(byte 0\)"):
        dynamics.load_simulation(tmp_path / "body.toml")
    with pytest.raises(InputError, match=r"body.shape.path is refused"):
        read(tmp_path, '[body]\ndensity = 1.0\nshape = { kind = "mesh", path = "a\\u0000b.stl" }' + RUN)


@pytest.mark.compiles
def test_a_start_off_its_constraints_names_the_file(tmp_path):
    on = GRAVITY + '[[constraints]]\nkind = "incidence"\npoint = "tip"\n'
    on += 'on = { kind = "sphere", center = [0, 0, 0], radius = 1 }\n'
    with pytest.raises(InputError, match=r"body.toml: constraint 0 \(Incidence\) is violated at the start, by 0\.\d+"):
        read(tmp_path, BODY + on + RUN).run()
    found = read(tmp_path, BODY + on + RUN + "project = true").run()
    assert found.violation.max() < 1e-13
    with pytest.raises(InputError, match=r"body.toml: strang composes exact flows"):
        read(tmp_path, BODY + on + RUN + 'project = true\nintegrator = "strang"').run()


@pytest.mark.parametrize("seed", range(40))
def test_files_that_are_bent_at_random_give_an_error_or_a_simulation(seed, tmp_path):
    """Whatever a key holds: an InputError that names the file, or a simulation; no other exception, no warning."""
    random = np.random.default_rng(seed)
    values = ["0", "-1", "1e308", "-1e60", "1e-300", '"tip"', '""', "true", "[]", "[0, 0, 0]", "[1e60, 1e60, 1e60]",
              "{}", "[[1, 0, 0], [0, 1, 0], [0, 0, 1]]", "1979-05-27", f"'{HOSTILE}'", '{ kind = "plane" }',
              "[1, 2]"]  # fmt: skip
    lines = EXAMPLES[int(random.integers(len(EXAMPLES)))].read_text(encoding="utf-8").splitlines()
    for _ in range(int(random.integers(1, 4))):
        i = int(random.choice([i for i, line in enumerate(lines) if "=" in line]))
        key = lines[i].partition("=")[0]
        lines[i] = f"{key}= {values[int(random.integers(len(values)))]}"
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            read(tmp_path, "\n".join(lines))
        except InputError as error:
            assert "body.toml" in str(error)
