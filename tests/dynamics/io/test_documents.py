"""What simulation files mean: bodies, shapes, loads, objects, joints, times."""

from __future__ import annotations

import re

import numpy as np
import pytest

import bladesmith as bs
from bladesmith import dynamics
from bladesmith.dynamics.integration.problem import start_of
from bladesmith.errors import InputError

from ...support.checkout import CHECKOUT
from ...support.dynamics.documents import BODY, EXAMPLES, GRAVITY, RUN, read
from ...support.dynamics.states import wide_driver


def body_of(setup):
    (body,) = setup.simulation.bodies
    return body


@pytest.mark.compiles
@pytest.mark.parametrize("path", EXAMPLES, ids=lambda p: p.stem)
def test_examples_run_and_keep_their_energy(path):
    setup = dynamics.load_simulation(path)
    found = setup.run()
    assert found.ending == "ok" and found.time[-1] == setup.duration
    record = dynamics.as_record(found, setup.sketch)
    assert np.ptp(record.energy) <= 1e-8 * max(1, np.abs(record.energy).max())
    assert record.violation.max() <= 1e-12
    assert len(setup.sketch.traces) >= 2 and setup.sketch.shapes


def test_the_files_of_the_docs_are_simulations(tmp_path):
    text = (CHECKOUT / "docs" / "motion" / "simulations.md").read_text(encoding="utf-8")
    blocks = re.findall(r"^```toml\n(.*?)^```", text, re.M | re.S)
    assert len(blocks) == 2
    for block in blocks:
        assert read(tmp_path, block).run(times=[0.01]).ending == "ok"


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
                                 "quaternion = [0.9689124217106447, 0, 0.24740395925452294, 0]",
                                 "quaternion = [-0.9689124217106447, 0.0, -0.24740395925452294, 0.0]",
                                 "matrix = [[0.8775825618903728, 0, 0.479425538604203], [0, 1, 0], "
                                 "[-0.479425538604203, 0, 0.8775825618903728]]"])  # fmt: skip
@pytest.mark.parametrize("algebra", ["cga3d", "pga3d"])
def test_orientations_are_rotations(way, algebra, tmp_path):
    body = body_of(read(tmp_path, f'{BODY}orientation = {{ {way} }}{RUN}algebra = "{algebra}"'))
    c, s = np.cos(0.5), np.sin(0.5)
    assert np.allclose(body.rotation, [[c, 0, s], [0, 1, 0], [-s, 0, c]], atol=1e-14)
    assert body.algebra.name == algebra


def test_the_unit_quaternion_is_no_rotation(tmp_path):
    for w in (1, -1):
        body = body_of(read(tmp_path, f"{BODY}orientation = {{ quaternion = [{w}, 0, 0, 0] }}{RUN}"))
        assert np.allclose(body.rotation, np.eye(3), atol=1e-15)


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
    [[loads]]
    kind = "quadratic_drag"
    linear = 0.4
    """
    gravity, world, body, spring, damper, drag = read(tmp_path, BODY + text + RUN).simulation.loads
    assert np.array_equal(gravity.acceleration, [0, 0, -2])
    force, moment = dynamics.wrench_parts(world.wrench)
    assert np.array_equal(force, [1, 0, 0]) and np.array_equal(moment, [0, 0.5, -3])
    force, moment = dynamics.wrench_parts(body.wrench)
    assert np.array_equal(force, [0, 1, 0]) and np.array_equal(moment, [-0.5, 0, 0])
    assert np.array_equal(spring.point, [0, 0, 0.5]) and np.array_equal(spring.anchor, [0, 0, 2])
    assert (spring.stiffness, spring.length, spring.damping) == (3.0, 0.5, 0.1)
    assert (damper.angular, damper.linear) == (0.2, 0.3)
    assert isinstance(drag, dynamics.QuadraticDrag) and (drag.angular, drag.linear) == (0.0, 0.4)


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
        with pytest.raises(InputError, match=rf"constraints\[0\].object is a {kind}, which pga3d does not have"):
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


@pytest.mark.compiles
@pytest.mark.parametrize("kind", JOINTS)
@pytest.mark.parametrize("algebra", ["cga3d", "pga3d"])
def test_joints_leave_their_mobility(kind, algebra, tmp_path):
    keys, mobility = JOINTS[kind]
    text = f'joints = [{{ kind = "{kind}", a = "base", b = "body", {keys} }}]\n{BODY}{RUN}algebra = "{algebra}"'
    if (kind, algebra) == ("universal", "pga3d"):
        with pytest.raises(InputError, match=r"joints\[0\] is universal, which pga3d does not have; use cga3d"):
            read(tmp_path, text)
        return
    simulation = read(tmp_path, text).simulation
    made = simulation._problem.prepare((1.0, 1e-3, None, None))[0]
    driver = wide_driver(made)
    motors, twists = start_of(made)
    rank = np.linalg.matrix_rank(driver.evaluate(0.0, motors[0], twists[0])["matrix"], tol=1e-9)
    assert rank == 6 - mobility


@pytest.mark.compiles
def test_loads_of_joints_are_those_of_their_classes(tmp_path):
    """Of a joint with two freedoms, by its name."""
    tables = {
        "joint_torque": "torque = 0.5, freedom = 1", "joint_spring": "stiffness = 3.0, rest = 0.2, damping = 0.1",
        "joint_damper": "damping = 0.4, freedom = 1", "joint_friction": "friction = 0.3, speed = 0.05",
        "joint_limit": "upper = 0.01, stiffness = 40.0, freedom = 1",
    }  # fmt: skip
    joint = '{ kind = "cylindrical", name = "rod", a = "base", b = "body", point = [0, 0, 1], axis = [1, 2, 0] }'
    loads = ", ".join(f'{{ kind = "{kind}", joint = "rod", {keys} }}' for kind, keys in tables.items())
    found = read(tmp_path, f"joints = [{joint}]\nloads = [{loads}]\n{BODY}{RUN}times = [0.05, 0.1]")
    expected = [
        dynamics.JointTorque(0, 0.5, 1), dynamics.JointSpring(0, 3.0, 0.2, 0.1), dynamics.JointDamper(0, 0.4, 1),
        dynamics.JointFriction(0, 0.3, 0.05), dynamics.JointLimit(0, -np.inf, 0.01, 40.0, freedom=1),
    ]  # fmt: skip
    assert [repr(load) for load in found.simulation.loads] == [repr(load) for load in expected]
    ends = [
        dynamics.Simulation(found.simulation.system, loads).run(0.1, times=[0.1]).coordinates("rod")[-1]
        for loads in (expected, expected[:1])
    ]
    assert np.array_equal(found.run().coordinates("rod")[-1], ends[0]) and np.abs(ends[0] - ends[1]).min() > 1e-6


def test_stored_times_and_options(tmp_path):
    setup = read(
        tmp_path,
        BODY + GRAVITY + RUN + 'interval = 0.03\nstep = 0.002\nrtol = 1e-6\nproject = true\nintegrator = "rk4"',
    )
    assert np.allclose(setup.times, [0, 0.03, 0.06, 0.09, 0.1], atol=1e-16) and setup.times[-1] == 0.1
    assert setup.options == {"step": 0.002, "rtol": 1e-6, "project": True}
    found = setup.run()
    assert found.integrator == "rk4" and np.array_equal(found.time, setup.times)
    assert np.array_equal(read(tmp_path, BODY + RUN + "times = [0.05, 0.1]").times, [0, 0.05, 0.1])
    assert len(read(tmp_path, BODY + RUN).times) == 1001
