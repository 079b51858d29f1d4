"""Simulation files: what they mean, every fault with file, line and key; trajectories in files and in pictures."""

from __future__ import annotations

import csv
import json
import re
import sys
import warnings
import zipfile
from pathlib import Path

import numpy as np
import pytest

import bladesmith as bs
from bladesmith import dynamics
from bladesmith.dynamics import animation, page, plots
from bladesmith.dynamics.files import archive
from bladesmith.errors import BladesmithError, InputError, MissingExtraError, SimulationError

sys.path.insert(0, str(Path(__file__).parent))

from browser_support import Chromium, browser

ROOT = Path(__file__).resolve().parent.parent
EXAMPLES = sorted((ROOT / "examples" / "chapter6").glob("*.toml"))
HOSTILE = "A </script><img src=x onerror=alert(1)> $\\frac$ {{ 7 * 7 }} %s"

BODY = """
[body]
mass = 2.0
moments = [1.0, 2.0, 2.5]
points = { tip = [0.0, 0.0, 0.5] }
"""
RUN = """
[simulation]
duration = 0.1
"""
TRACED = """
[[traces]]
point = "tip"
color = "red"
"""


def read(tmp_path, text):
    path = tmp_path / "body.toml"
    path.write_text(text, encoding="utf-8")
    return dynamics.load_simulation(path)


def body_of(setup):
    (body,) = setup.simulation.bodies
    return body


@pytest.fixture(scope="module")
def swing(tmp_path_factory):
    """A pendulum pinned at its tip: the setup, and its trajectory."""
    text = BODY.replace("moments = [1.0, 2.0, 2.5]", 'shape = { kind = "box", size = [0.2, 0.3, 1.0] }')
    text += 'orientation = { axis = [1, 0, 0], degrees = 80 }\n[[loads]]\nkind = "gravity"\n'
    text += '[[constraints]]\nkind = "pin"\nobject = { kind = "point", xyz = "tip" }\n'
    setup = read(tmp_path_factory.mktemp("swing"), text + RUN.replace("0.1", "0.5\ninterval = 0.01") + TRACED)
    return setup, setup.run()


# -- what files mean -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda p: p.stem)
def test_examples_run_and_keep_their_energy(path):
    setup = dynamics.load_simulation(path)
    found = setup.run()
    assert found.status == "ok" and found.time[-1] == setup.duration
    record = dynamics.recorded(found, setup.sketch)
    assert np.ptp(record.energy) <= 1e-8 * max(1, np.abs(record.energy).max())
    assert record.violation.max() <= 1e-12
    assert len(setup.sketch.traces) >= 2 and setup.sketch.shapes


def test_the_files_of_the_docs_are_simulations(tmp_path):
    text = (ROOT / "docs" / "simulations.md").read_text(encoding="utf-8")
    blocks = re.findall(r"^```toml\n(.*?)^```", text, re.M | re.S)
    assert len(blocks) == 2
    for block in blocks:
        assert read(tmp_path, block).run(times=[0.01]).status == "ok"


def test_a_body_is_where_and_as_fast_as_its_file_says(tmp_path):
    text = """
    [body]
    mass = 2.0
    tensor = [[1.0, 0.1, 0.0], [0.1, 2.0, 0.0], [0.0, 0.0, 2.5]]
    center = [0.1, 0.2, 0.3]
    points = { tip = [1.0, 0.0, 0.0] }
    position = [1.0, 2.0, 3.0]
    position_point = "tip"
    orientation = { axis = [0, 0, 2], degrees = 90 }
    velocity = [4.0, 5.0, 6.0]
    velocity_point = [1.0, 0.0, 0.0]
    angular_velocity = [0.3, -0.2, 0.7]
    """
    body = body_of(read(tmp_path, text + RUN))
    turn = np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1.0]])
    arm = turn @ (np.array([1.0, 0, 0]) - [0.1, 0.2, 0.3])
    spin = turn @ [0.3, -0.2, 0.7]
    assert np.allclose(body.position + arm, [1, 2, 3], atol=1e-15)
    assert np.allclose(body.velocity + np.cross(spin, arm), [4, 5, 6], atol=1e-15)
    assert np.allclose(body.rotation, turn, atol=1e-15)
    assert np.allclose(body.axes @ np.diag(body.moments) @ body.axes.T, [[1, 0.1, 0], [0.1, 2, 0], [0, 0, 2.5]])


@pytest.mark.parametrize("way", ["axis = [0.0, 1.0, 0.0], angle = 0.5", "axis = [0, 3, 0], degrees = 28.64788975654116",
                                 "matrix = [[0.8775825618903728, 0, 0.479425538604203], [0, 1, 0], "
                                 "[-0.479425538604203, 0, 0.8775825618903728]]"])  # fmt: skip
@pytest.mark.parametrize("algebra", ["cga3d", "pga3d"])
def test_orientations_are_rotations(way, algebra, tmp_path):
    body = body_of(read(tmp_path, f'{BODY}orientation = {{ {way} }}{RUN}algebra = "{algebra}"'))
    c, s = np.cos(0.5), np.sin(0.5)
    assert np.allclose(body.rotation, [[c, 0, s], [0, 1, 0], [-s, 0, c]], atol=1e-14)
    assert body.algebra.name == algebra


def test_shapes_weigh_and_turn_as_brute_force_says(tmp_path):
    """Moments of a solid against sums over many points that fill it."""
    random = np.random.default_rng(0)
    points = random.uniform(-1, 1, (400_000, 3))
    inside = {
        "box = [0.9, 0.5, 1.4]": np.abs(points) <= np.array([0.45, 0.25, 0.7]),
        "sphere radius = 0.8": (points**2).sum(1) <= 0.64,
        "cylinder radius = 0.4, height = 1.5": ((points[:, :2] ** 2).sum(1) <= 0.16) & (np.abs(points[:, 2]) <= 0.75),
        "cone radius = 0.6, height = 1.2": (
            (np.hypot(points[:, 0], points[:, 1]) <= 0.6 * (0.9 - points[:, 2]) / 1.2) & (points[:, 2] >= -0.3)
        ),
    }
    made = [dynamics.box((0.9, 0.5, 1.4)), dynamics.sphere(0.8), dynamics.cylinder(0.4, 1.5), dynamics.cone(0.6, 1.2)]
    for (name, chosen), shape in zip(inside.items(), made, strict=True):
        own = points[chosen.all(1) if chosen.ndim == 2 else chosen]
        assert shape.volume == pytest.approx(8 * len(own) / len(points), rel=0.02), name
        tensor = (own**2).sum(1).mean() * np.eye(3) - own.T @ own / len(own)
        assert np.allclose(shape.gyration, tensor, atol=0.02 * np.trace(tensor)), name
        assert np.allclose(own.mean(0), 0, atol=0.01), name
        volume, center = _solid(shape)
        assert volume == pytest.approx(shape.volume, rel=0.03) and np.allclose(center, 0, atol=1e-12), name


def _solid(shape):
    """Volume and centre of what a shape's triangles enclose: they face outwards."""
    a, b, c = (shape.vertices[shape.faces[:, i]] for i in range(3))
    parts = np.einsum("ij,ij->i", a, np.cross(b, c)) / 6
    return parts.sum(), ((a + b + c) * parts[:, None]).sum(0) / 4 / parts.sum()


@pytest.mark.parametrize("axis", [(1, 0, 0), (0, -2, 0), (0.3, 0.4, -0.5)])
def test_shapes_turn_with_their_axis(axis):
    up, turned = dynamics.cone(0.6, 1.2), dynamics.cone(0.6, 1.2, axis)
    way = np.array(axis) / np.linalg.norm(axis)
    tip = turned.vertices[np.argmax(turned.vertices @ way)]
    assert np.allclose(tip, 0.9 * way, atol=1e-14)
    assert way @ turned.gyration @ way == pytest.approx(up.gyration[2, 2], rel=1e-13)
    assert np.allclose(np.linalg.eigvalsh(turned.gyration), np.linalg.eigvalsh(up.gyration))
    assert _solid(turned)[0] > 0


def test_a_mesh_gives_its_mass_and_centre(tmp_path):
    corners = dynamics.box((1.0, 2.0, 3.0))
    lines = [f"v {x + 10} {y} {z}" for x, y, z in corners.vertices]
    lines += ["f " + " ".join(str(i + 1) for i in face) for face in corners.faces]
    (tmp_path / "box.obj").write_text("\n".join(lines))
    shape = 'shape = { kind = "mesh", path = "box.obj", scale = 0.5 }'
    setup = read(tmp_path, f"[body]\ndensity = 8.0\n{shape}\npoints = {{ corner = [5.25, 0.5, 0.75] }}\n"
                           f'[[traces]]\npoint = "corner"{RUN}')  # fmt: skip
    body = body_of(setup)
    assert body.mass == pytest.approx(6.0) and np.allclose(body.moments, 6 / 12 * np.array([3.25, 2.5, 1.25]))
    assert np.allclose(setup.sketch.traces[0].point, [0.25, 0.5, 0.75])
    assert np.allclose(setup.sketch.shapes["body"].vertices, corners.vertices / 2)
    with pytest.raises(InputError, match=r"line \d+: body.center is that of the mesh; leave it out"):
        read(tmp_path, f"[body]\ndensity = 8.0\n{shape}\ncenter = [0, 0, 0]{RUN}")
    with pytest.raises(InputError, match=r"line 3: body.shape.path is refused: .*none.obj: there is no such file"):
        read(tmp_path, f"[body]\ndensity = 8.0\n{shape.replace('box', 'none')}{RUN}")


def test_loads_act_where_they_say(tmp_path):
    text = """
    [[loads]]
    kind = "gravity"
    acceleration = [0.0, 0.0, -2.0]
    [[loads]]
    kind = "world_wrench"
    force = [1.0, 0.0, 0.0]
    point = [0.0, 3.0, 0.0]
    couple = [0.0, 0.5, 0.0]
    [[loads]]
    kind = "body_wrench"
    force = [0.0, 1.0, 0.0]
    point = "tip"
    [[loads]]
    kind = "spring"
    point = "tip"
    anchor = [0.0, 0.0, 2.0]
    stiffness = 3.0
    length = 0.5
    damping = 0.1
    [[loads]]
    kind = "damper"
    angular = 0.2
    linear = 0.3
    """
    gravity, world, body, spring, damper = read(tmp_path, BODY + text + RUN).simulation.loads
    assert np.array_equal(gravity.acceleration, [0, 0, -2])
    force, moment = dynamics.wrench_parts(world.wrench)
    assert np.array_equal(force, [1, 0, 0]) and np.array_equal(moment, [0, 0.5, -3])
    force, moment = dynamics.wrench_parts(body.wrench)
    assert np.array_equal(force, [0, 1, 0]) and np.array_equal(moment, [-0.5, 0, 0])
    assert np.array_equal(spring.point, [0, 0, 0.5]) and np.array_equal(spring.anchor, [0, 0, 2])
    assert (spring.stiffness, spring.length, spring.damping) == (3.0, 0.5, 0.1)
    assert (damper.angular, damper.linear) == (0.2, 0.3)


OBJECTS = {
    "point": ('xyz = "tip"', lambda a: a.point((0, 0, 0.4))),
    "flat_point": ("xyz = [1, 2, 3]", lambda a: a.flat_point((1, 2, 2.9))),
    "point_pair": ('a = "tip", b = [1, 0, 0.1]', lambda a: a.point_pair((0, 0, 0.4), (1, 0, 0))),
    "direction": ("v = [0, 0, 2]", lambda a: a.direction((0, 0, 2))),
    "line": ("point = [1, 0, 0.1], direction = [0, 2, 0]", lambda a: a.line((1, 0, 0), (0, 2, 0))),
    "circle": ("center = [0, 0, 0.1], normal = [1, 0, 1], radius = 2",
               lambda a: a.circle((0, 0, 0), (1, 0, 1), 2.0)),
    "plane": ("normal = [0, 0, 2], offset = 1.0", lambda a: a.plane((0, 0, 1), 0.4)),
    "sphere": ("center = [0, 0, 0.1], radius = 2", lambda a: a.sphere((0, 0, 0), 2.0)),
}  # fmt: skip


@pytest.mark.parametrize("kind", OBJECTS)
@pytest.mark.parametrize("algebra", ["cga3d", "pga3d"])
def test_objects_are_those_of_the_body(kind, algebra, tmp_path):
    keys, wanted = OBJECTS[kind]
    pin = f'[[constraints]]\nkind = "pin"\nobject = {{ kind = "{kind}", {keys} }}'
    text = f'{BODY}center = [0, 0, 0.1]\n{pin}\n{RUN}algebra = "{algebra}"'
    home = getattr(bs, algebra)
    if algebra == "pga3d" and kind not in ("point", "direction", "line", "plane"):
        with pytest.raises(InputError, match=rf"constraints\[0\].object is a {kind}, which pga3d has not"):
            read(tmp_path, text)
        return
    (found,) = read(tmp_path, text).simulation.constraints
    assert found.body_object.isclose(wanted(home)) and found.world_object is None


def test_planes_go_through_their_point_however_long_the_normal(tmp_path):
    on = '[[constraints]]\nkind = "incidence"\npoint = "tip"\non = {{ kind = "plane", normal = [0, 0, 3], {} }}'
    for where in ("point = [5, 6, 0.5]", "offset = 1.5"):
        (found,) = read(tmp_path, BODY + on.format(where) + RUN).simulation.constraints
        assert found.world_object.isclose(bs.cga3d.plane((0, 0, 1), 0.5))


JOINTS = {
    "spherical": ("point = [0, 0, 1]", 3), "revolute": ("point = [0, 0, 1], axis = [1, 0, 0]", 1),
    "cylindrical": ("point = [0, 0, 1], axis = [1, 2, 0]", 2), "prismatic": ("axis = [1, 2, 3]", 1),
    "planar": ("point = [0, 0, 1], normal = [1, 0, 2]", 3),
    "universal": ("point = [0, 0, 1], axis_a = [1, 0, 0], axis_b = [0, 1, 0]", 2),
}  # fmt: skip


@pytest.mark.parametrize("kind", JOINTS)
@pytest.mark.parametrize("algebra", ["cga3d", "pga3d"])
def test_joints_leave_their_mobility(kind, algebra, tmp_path):
    keys, mobility = JOINTS[kind]
    text = f'joints = [{{ kind = "{kind}", a = "base", b = "body", {keys} }}]\n{BODY}{RUN}algebra = "{algebra}"'
    if (kind, algebra) == ("universal", "pga3d"):
        with pytest.raises(InputError, match=r"joints\[0\] is universal, which pga3d has not; use cga3d"):
            read(tmp_path, text)
        return
    simulation = read(tmp_path, text).simulation
    made = simulation._prepared(1.0, 1e-3, None, None)[0]
    driver = simulation._driver(made, simulation._prepared(1.0, 1e-3, None, None)[1])
    motors, twists = dynamics.simulation.start_of(made)
    rank = np.linalg.matrix_rank(driver.look(0.0, motors[0], twists[0])["matrix"], tol=1e-9)
    assert rank == 6 - mobility


def test_stored_times_and_options(tmp_path):
    setup = read(
        tmp_path, BODY + RUN + 'interval = 0.03\nstep = 0.002\nrtol = 1e-6\nproject = true\nintegrator = "rk4"'
    )
    assert np.allclose(setup.times, [0, 0.03, 0.06, 0.09, 0.1], atol=1e-16) and setup.times[-1] == 0.1
    assert setup.options == {"step": 0.002, "rtol": 1e-6, "project": True}
    found = setup.run()
    assert found.integrator == "rk4" and np.array_equal(found.time, setup.times)
    assert np.array_equal(read(tmp_path, BODY + RUN + "times = [0.05, 0.1]").times, [0, 0.05, 0.1])
    assert len(read(tmp_path, BODY + RUN).times) == 1001


# -- faults ----------------------------------------------------------------------------------------------------

PIN = '[[constraints]]\nkind = "pin"\n'
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
    (BODY + "orientation = { degrees = 3 }" + RUN, "body.orientation: has neither matrix nor axis"),
    (BODY + "orientation = { matrix = [[2, 0, 0], [0, 1, 0], [0, 0, 1]] }" + RUN,
     "line 6: body.orientation.matrix is refused: "),
    (BODY + 'position_point = "tap"' + RUN,
     "line 6: body.position_point is 'tap', which is no point of body (did you mean 'tip'?); there are: tip, center"),
    (BODY + 'velocity_point = "up"' + RUN, "body.velocity_point is 'up', which is no point of body; there are: tip"),
    (BODY + 'name = "base"' + RUN, "line 6: body.name is 'base', which is what joints call the world"),
    (BODY + 'name = "_x"' + RUN, 'body.name is "_x"; it begins with a letter or digit'),
    (BODY + 'name = "a\\nb"' + RUN, "it begins with a letter or digit, and has 60 printable letters"),
    (BODY + 'color = "blu"' + RUN, "line 6: body.color is \"blu\"; did you mean 'blue'?"),
    (BODY + 'color = "url(x)"' + RUN, 'body.color is "url(x)"; known: blue, red'),
    (BODY + "[[loads]]\nkind = \"gravty\"" + RUN, "line 7: loads[0].kind is \"gravty\"; did you mean 'gravity'?"),
    (BODY + "[[loads]]\nforce = [1, 0, 0]" + RUN, "line 6: loads[0] has no kind, which says what it is"),
    (BODY + '[[loads]]\nkind = "body_wrench"' + RUN, "loads[0]: has neither force nor couple; one is needed"),
    (BODY + '[[loads]]\nkind = "world_wrench"\ncouple = [1, 0, 0]\npoint = [0, 0, 0]' + RUN,
     "loads[0]: a point goes with a force"),
    (BODY + '[[loads]]\nkind = "world_wrench"\nforce = [1, 0, 0]\npoint = "tip"' + RUN,
     "line 9: loads[0].point is 'tip', a name; of the world three numbers are needed"),
    (BODY + '[[loads]]\nkind = "spring"\npoint = "tip"\nanchor = [0, 0]\nstiffness = 1' + RUN,
     "line 9: loads[0].anchor is [0, 0]; three numbers, or the name of one of the body's points, are needed"),
    (BODY + '[[loads]]\nkind = "spring"\npoint = "tip"\nanchor = [0, 0, 0]\nstiffness = 1\nlength = -1' + RUN,
     "line 11: loads[0].length is -1; a length is at least 0"),
    (BODY + '[[loads]]\nkind = "damper"\nbody = "bdy"' + RUN,
     "line 8: loads[0].body is 'bdy', which is no body (did you mean 'body'?); there are: body"),
    (BODY + PIN + RUN, "line 6: constraints[0] has no object, which is required"),
    (BODY + PIN + 'object = { kind = "point", xyz = "tp" }' + RUN,
     "line 8: constraints[0].object.xyz is 'tp', which is no point of body (did you mean 'tip'?)"),
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
     "line 9: joints[0].b is 'bode', which is no body (did you mean 'body'?)"),
    (BODY + '[[joints]]\nkind = "revolute"\na = "base"\nb = "base"\npoint = [0, 0, 0]\naxis = [0, 0, 1]' + RUN,
     "line 9: joints[0].b is 'base', the same as a"),
    (BODY + '[[joints]]\nkind = "universal"\na = "base"\nb = "body"\npoint = [0, 0, 0]\n'
     "axis_a = [0, 0, 1]\naxis_b = [1, 0, 1]" + RUN, "line 6: joints[0] is refused: "),
    (BODY + RUN.replace("0.1", "0"), "line 8: simulation.duration is 0; a duration is positive"),
    (BODY + RUN + "interval = 1e-9", "line 9: simulation.interval is 1e-09: more than 5000000 states in 0.1. Store"),
    (BODY + RUN + "interval = 0.01\ntimes = [0.1]", "simulation: interval and times say the same thing"),
    (BODY + RUN + "times = [0.05, 0.05]", "line 9: simulation.times[1] is 0.05; times rise from 0 to the duration"),
    (BODY + RUN + "times = [0.2]", "line 9: simulation.times[0] is 0.2; times rise"),
    (BODY + RUN + 'integrator = "rk5"', "line 9: simulation.integrator is \"rk5\"; did you mean 'rk4'?"),
    (BODY + RUN + 'map = "log"', 'simulation.map is "log"; known: exponential, bortz, cayley, outer'),
    (BODY + RUN + 'stabilization = "projecton"', "did you mean 'projection'?"),
    (BODY + RUN + 'algebra = "cga"', "line 9: simulation.algebra is \"cga\"; did you mean 'cga3d'?"),
    (BODY + RUN + '[[traces]]\npoint = "tipp"', "line 10: traces[0].point is 'tipp', which is no point of body"),
    (BODY + RUN + '[[traces]]\npoint = true', "traces[0].point is true; three numbers, or the name"),
    (BODY + RUN + "[picture]\nshown = [0.2]", "line 10: picture.shown[0] is 0.2, after the end at 0.1"),
    (BODY + RUN + "[picture]\nelevation = 91.0", "picture.elevation is 91.0; an elevation is at most 90"),
    (BODY + RUN + '[units]\nlength = "<b>"', 'line 10: units.length is "<b>"; a unit has 12 letters'),
    (BODY + BODY.replace("[body]", "[body]") + RUN, "annot declare ('body',) twice"),
    ("[[bodies]]\nmass = 1\nmoments = [1, 1, 1]\n[[bodies]]\nmass = 1\nmoments = [1, 1, 1]" + RUN,
     "line 4: bodies[1].name is 'body', as of another body"),
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


def test_a_start_off_its_constraints_names_the_file(tmp_path):
    on = (
        '[[constraints]]\nkind = "incidence"\npoint = "tip"\non = { kind = "sphere", center = [0, 0, 0], radius = 1 }\n'
    )
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


# -- trajectories in files -------------------------------------------------------------------------------------


def same(a, b):
    for key in ("time", "position", "orientation", "velocity", "angular_velocity", "energy", "violation"):
        assert np.asarray(getattr(a, key)).tobytes() == np.asarray(getattr(b, key)).tobytes(), key
    for key in ("motor", "momentum", "reaction"):
        assert getattr(a, key).isclose(getattr(b, key)).all(), key
    for key in ("status", "integrator", "message", "steps"):
        assert getattr(a, key) == getattr(b, key), key


def test_a_trajectory_comes_back_to_the_last_bit(swing, tmp_path):
    setup, found = swing
    found.save(tmp_path / "a.npz", setup.sketch)
    again = dynamics.load_trajectory(tmp_path / "a.npz")
    same(again, found)
    assert again.motor.values.tobytes() == found.motor.as_kind("motor").values.tobytes()
    assert again.sketch.traces[0].label == "tip" and again.sketch.units == setup.sketch.units
    (own,), (kept,) = setup.sketch.shapes.values(), again.sketch.shapes.values()
    for part in ("vertices", "faces", "gyration", "edges"):
        assert np.array_equal(getattr(own, part), getattr(kept, part))
    assert all(x.isclose(y) for x, y in zip(setup.sketch.objects, again.sketch.objects, strict=True))
    again.save(tmp_path / "b.npz")
    same(dynamics.load_trajectory(tmp_path / "b.npz"), found)
    with np.load(tmp_path / "a.npz", allow_pickle=False) as arrays:
        tip = found.orientation @ [0, 0, 0.5] + found.position
        assert np.allclose(arrays["traces"][0], tip, atol=1e-15)
        assert np.array_equal(arrays["reaction"], found.reaction.values)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a.npz", "b.npz"]


def test_a_table_holds_the_same_numbers(swing, tmp_path):
    setup, found = swing
    found.save(tmp_path / "a.csv", setup.sketch)
    with open(tmp_path / "a.csv", newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    column = lambda *names: np.array([[float(row[name]) for name in names] for row in rows])  # noqa: E731
    assert np.array_equal(column("t [s]")[:, 0], found.time)
    assert np.array_equal(column("x [m]", "y [m]", "z [m]"), found.position)
    assert np.array_equal(column(*(f"r{i}{j}" for i in "123" for j in "123")), found.orientation.reshape(-1, 9))
    assert np.array_equal(column("w1 [rad/s]", "w2 [rad/s]", "w3 [rad/s]"), found.angular_velocity)
    assert np.array_equal(column("energy [J]")[:, 0], found.energy)
    reaction = dynamics.wrench_parts(found.reaction)
    assert np.array_equal(column("fx [N]", "fy [N]", "fz [N]"), reaction.force)
    assert np.array_equal(column("mx [N m]", "my [N m]", "mz [N m]"), reaction.moment)
    assert np.allclose(column("tip x [m]", "tip y [m]", "tip z [m]"), found.orientation @ [0, 0, 0.5] + found.position)


def test_several_bodies_and_batches_come_back(tmp_path):
    setup = dynamics.load_simulation(ROOT / "examples" / "chapter6" / "double_pendulum.toml")
    found = setup.run(times=[0.1, 0.2])
    found.save(tmp_path / "two.npz", setup.sketch)
    again = dynamics.load_trajectory(tmp_path / "two.npz")
    assert list(again.bodies) == ["upper", "lower"]
    for name in again.bodies:
        same(again.bodies[name], found.bodies[name])
    found.save(tmp_path / "two.csv")
    rows = (tmp_path / "two.csv").read_text().splitlines()
    assert (
        rows[0].startswith("body,t [s],") and [row.split(",")[0] for row in rows[1:]] == ["upper"] * 3 + ["lower"] * 3
    )

    body = dynamics.RigidBody([1.0, 2.0, 3.0], (1, 2, 2.5), velocity=(1, 0, 0), algebra=bs.pga3d)
    many = dynamics.Simulation(body).run(0.1, times=[0.05, 0.1])
    dynamics.save(many, tmp_path / "many.npz")
    again = dynamics.load_trajectory(tmp_path / "many.npz")
    assert again.batch == (3,) and np.array_equal(again.position, many.position) and list(again.status) == ["ok"] * 3
    assert again.motor.algebra is bs.pga3d
    assert np.array_equal(again[1].position, many.position[1])
    dynamics.save(many, tmp_path / "many.csv")
    assert len((tmp_path / "many.csv").read_text().splitlines()) == 10
    for refused in (plots.plot, dynamics.picture):
        with pytest.raises(InputError, match="these are 3 simulations; a picture shows one"):
            refused(many)
    with pytest.raises(InputError, match="none has the number 3"):
        again[3]


def test_files_that_are_no_trajectories_are_refused(swing, tmp_path):
    setup, found = swing
    good = archive(dynamics.recorded(found, setup.sketch))
    path = tmp_path / "x.npz"

    def with_arrays(**arrays):
        path.write_bytes(good)
        with np.load(path) as stored:
            kept = {name: stored[name] for name in stored.files}
        header = json.loads(kept["bladesmith"].tobytes())
        for key, value in arrays.pop("header", {}).items():
            header[key] = value
        kept["bladesmith"] = np.frombuffer(json.dumps(header).encode(), np.uint8)
        np.savez(path, **{k: v for k, v in {**kept, **arrays}.items() if v is not None})

    cases = {
        "energy is an array": lambda: with_arrays(energy=np.zeros(3)),
        "it has no motor": lambda: with_arrays(motor=None),
        "its format is 'trajectory', version 9": lambda: with_arrays(header={"version": 9}),
        "its header is damaged": lambda: with_arrays(header={"algebra": "os.system"}),
        "on other blades": lambda: with_arrays(header={"blades": {"motor": ["1"], "twist": []}}),
        "name vertices that are not there": lambda: with_arrays(**{"shape.0.faces": np.array([[0, 1, 999]])}),
        "is no colour": lambda: with_arrays(header={"colors": {"body": "url(x)"}}),
        "is no file that": lambda: path.write_bytes(good[: len(good) // 2]),
        "is no file that trajectory.save": lambda: np.savez(path, time=np.array([object()], dtype=object)),
    }
    for says, make in cases.items():
        make()
        with pytest.raises(InputError) as error:
            dynamics.load_trajectory(path)
        assert says in str(error.value) and str(path) in str(error.value)
    with pytest.raises(InputError, match="cannot be read: No such file"):
        dynamics.load_trajectory(tmp_path / "none.npz")
    assert zipfile.is_zipfile(path)


def test_what_cannot_be_written_leaves_what_was_there(swing, tmp_path, monkeypatch):
    setup, found = swing
    path = tmp_path / "a.npz"
    found.save(path)
    before = path.read_bytes()

    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "write_bytes", full)
    with pytest.raises(InputError, match=r"a.npz: cannot be written: No space left on device"):
        found.save(path)
    monkeypatch.undo()
    assert path.read_bytes() == before and [p.name for p in tmp_path.iterdir()] == ["a.npz"]
    for name, says in (("a.txt", "trajectories are written as .npz or .csv"), ("no/a.npz", "No such file")):
        with pytest.raises(InputError, match=re.escape(says)):
            found.save(tmp_path / name)
    with pytest.raises(InputError, match="a list is no trajectory"):
        dynamics.save([], path)
    with pytest.raises(InputError, match="the sketch names the body 'arm'; there are: body"):
        found.save(path, dynamics.Sketch(traces=[dynamics.Trace((0, 0, 0), body="arm")]))


def test_the_trajectory_so_far_of_a_failure_is_one(tmp_path):
    body = dynamics.RigidBody(1.0, (1, 1, 1))

    def wrench(time):
        return dynamics.wrench((np.nan if time > 0.5 else 1.0, 0, 0), 0)

    with pytest.raises(SimulationError) as error:
        dynamics.Simulation(body, [dynamics.WorldWrench(wrench)]).run(1.0, step=0.01)
    record = dynamics.recorded(error.value.trajectory)
    assert 10 < len(record) < 60 and np.isfinite(record.position).all()
    record.save(tmp_path / "so_far.npz")
    same(dynamics.load_trajectory(tmp_path / "so_far.npz"), record)


# -- pictures --------------------------------------------------------------------------------------------------


def test_curves_show_the_numbers(swing):
    setup, found = swing
    figure = found.plot(sketch=setup.sketch)
    axes = {ax.get_title(loc="left").partition(" [")[0].partition(",")[0]: ax for ax in figure.axes if ax.get_visible()}
    assert list(axes) == ["centre of mass", "velocity", "angular velocity", "force of the constraints",
                          "their moment about the centre", "energy", "violation of the constraints"]  # fmt: skip
    for line, column in zip(axes["centre of mass"].lines, found.position.T, strict=True):
        assert np.array_equal(line.get_ydata(), column)
    moment = dynamics.wrench_parts(found.reaction).moment - np.cross(
        found.position, dynamics.wrench_parts(found.reaction).force
    )
    for line, column in zip(axes["their moment about the centre"].lines, moment.T, strict=True):
        assert np.allclose(line.get_ydata(), column, atol=1e-12)
    free = dynamics.Simulation(dynamics.RigidBody(1.0, (1, 1, 1), velocity=(1, 0, 0))).run(0.1, step=0.05)
    assert len([ax for ax in free.plot().axes if ax.get_visible()]) == 4
    assert len(found.plot(show=["energy"]).axes) == 1
    with pytest.raises(InputError, match="show has 'speed'; there are: position"):
        found.plot(show=["speed"])


def test_pictures_show_paths_bodies_and_what_holds_them(swing, tmp_path):
    setup, found = swing
    ax = found.picture(tmp_path / "a.png", sketch=setup.sketch, shown=[0, 0.25, 0.5])
    segments = [np.asarray(s) for c in ax.collections if type(c).__name__ == "Line3DCollection" for s in c._segments3d]
    tip = found.orientation @ [0, 0, 0.5] + found.position
    assert any(s.shape == tip.shape and np.allclose(s, tip) for s in segments)
    assert sum(type(c).__name__ == "Poly3DCollection" for c in ax.collections) == 3
    assert (tmp_path / "a.png").read_bytes()[1:4] == b"PNG" and [p.name for p in tmp_path.iterdir()] == ["a.png"]
    with pytest.raises(InputError, match="'xyz' is no format of pictures"):
        found.picture(tmp_path / "a.xyz")
    with pytest.raises(InputError, match="cannot be written: No such file"):
        found.picture(tmp_path / "no" / "a.png")


def test_labels_are_text_and_no_formula(swing, tmp_path):
    _, found = swing
    sketch = dynamics.Sketch(traces=[dynamics.Trace((0, 0, 0), HOSTILE)], title=HOSTILE)
    found.picture(tmp_path / "a.png", sketch=sketch)
    found.plot(tmp_path / "b.png", sketch=sketch, show=["energy"])
    text = page.page_text(dynamics.recorded(found, sketch), 1.0, (20, 30))
    assert "<img" not in text and text.count("</script") == 2
    data = json.loads(re.search(r'<script type="application/json" id="data">(.*?)</script>', text, re.S).group(1))
    assert data["traces"][0]["label"] == HOSTILE


def test_films_have_the_pictures_they_should(swing, tmp_path):
    from PIL import Image

    setup, found = swing
    told = []
    options = {"sketch": setup.sketch, "rate": 10, "speed": 0.5, "size": (161, 120)}
    found.animate(tmp_path / "a.gif", **options, progress=lambda done, total: told.append((done, total)))
    film = Image.open(tmp_path / "a.gif")
    assert film.n_frames == 11 and film.info["duration"] == 100 and film.size == (160, 120)
    assert told == [(i, 11) for i in range(1, 12)]
    read_frames = pytest.importorskip("imageio_ffmpeg").read_frames
    found.animate(tmp_path / "a.mp4", **options)
    reader = read_frames(str(tmp_path / "a.mp4"))
    assert next(reader)["source_size"] == (160, 120) and sum(1 for _ in reader) == 11
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a.gif", "a.mp4"]


def test_frames_are_the_stored_states_nearest_in_time(swing):
    record = dynamics.recorded(swing[1])
    numbers = animation.frame_numbers(record, 0.33, 25.0)
    times = np.arange(len(numbers)) * 0.33 / 25.0
    assert times[-1] <= 0.5 < times[-1] + 0.33 / 25
    assert np.abs(record.time[numbers] - times).max() <= 0.005 + 1e-12
    with pytest.raises(InputError, match="Raise the speed"):
        animation.frame_numbers(record, 1e-9, 25.0)


def test_an_interrupted_film_leaves_nothing(swing, tmp_path):
    def interrupt(done, total):
        raise KeyboardInterrupt

    for name in ("a.gif", "a.mp4"):
        with pytest.raises(KeyboardInterrupt):
            swing[1].animate(tmp_path / name, rate=5, size=(64, 64), progress=interrupt)
    assert not list(tmp_path.iterdir())


def test_what_is_missing_is_named(swing, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    with pytest.raises(MissingExtraError, match=r"pip install 'bladesmith\[video\]'"):
        swing[1].animate(tmp_path / "a.mp4")
    for name, says in (("a.avi", "films are .gif, .mp4, pages .html"), ("a\0.gif", "films are")):
        with pytest.raises(InputError, match=re.escape(says)):
            swing[1].animate(tmp_path / name)
    with pytest.raises(InputError, match="speed is 0; one positive number"):
        swing[1].animate(tmp_path / "a.html", speed=0)


@pytest.mark.skipif(browser() is None, reason="no Chromium")
def test_a_page_plays_without_a_network(swing, tmp_path):
    setup, found = swing
    found.animate(tmp_path / "a.html", sketch=setup.sketch)
    with Chromium(500, 400) as seen:
        seen.open(tmp_path / "a.html")
        assert seen.value("document.body.dataset.state") == "ready"
        assert seen.value("window.bladesmith.states") == len(found)
        seen.value("window.bladesmith.show(0.25)")
        assert seen.value("document.getElementById('clock').textContent").startswith("t = 0.25")
        first = seen.picture()
        seen.value("window.bladesmith.show(0.5)")
        assert seen.picture() != first
        seen.click("#home")
        seen.click("#play")
        seen.wait("document.getElementById('play').textContent == 'Play'")
        assert not seen.complaints() and seen.requests() == [(tmp_path / "a.html").as_uri()]


def test_a_mesh_with_many_triangles_is_drawn_with_fewer():
    angles = np.linspace(0, 2 * np.pi, 200, endpoint=False)
    places = np.array(
        [[np.cos(a) * (3 + np.cos(b)), np.sin(a) * (3 + np.cos(b)), np.sin(b)] for a in angles for b in angles]
    )
    here = np.arange(len(places)).reshape(200, 200)
    right, up, both = np.roll(here, -1, 0), np.roll(here, -1, 1), np.roll(here, (-1, -1), (0, 1))
    faces = np.concatenate([np.stack([here, right, up], -1), np.stack([right, both, up], -1)]).reshape(-1, 3)
    shape = dynamics.Shape(places, faces, 1.0, np.eye(3), np.zeros((0, 2), int))
    vertices, fewer, _ = page._drawable(shape)
    assert 500 < len(fewer) <= page.MOST_FACES < len(faces)
    assert fewer.max() < len(vertices) and np.allclose(np.ptp(vertices, axis=0), np.ptp(places, axis=0), rtol=0.05)


def test_bad_sketches_are_refused():
    for make, says in (
        (lambda: dynamics.Trace((0, 0)), "ends in 3"),
        (lambda: dynamics.Trace((0, 0, 0), color="blau"), "is no colour (did you mean 'blue'?)"),
        (lambda: dynamics.Sketch(shapes=3), "TypeError"),
        (lambda: dynamics.Sketch({"body": 3}), "the shape of body is a int"),
        (lambda: dynamics.cone(0, 1), "the radius is 0"),
        (lambda: dynamics.cylinder(1, 1, (0, 0, 0)), "the axis is zero"),
    ):
        with pytest.raises((BladesmithError, TypeError)) as error:
            make()
        assert says in f"{type(error.value).__name__}: {error.value}"
