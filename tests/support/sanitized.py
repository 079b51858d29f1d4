"""Run by project/test_sanitizers.py in a process of its own, under sanitizers: all drivers, with bad rays, objects,
coordinates and numbers among good ones.

Nothing is asserted about results, which other tests do: every access to memory, shift and conversion is watched.
"""

import os

os.environ.pop("LD_PRELOAD", None)  # this process has the libraries; the compiler must not

import sys

import numpy as np

import bladesmith as bs
from bladesmith import cga3d, codegen, curves, dynamics, kinematics, tracer
from bladesmith.codegen.build.extension import generated_extension, load
from bladesmith.codegen.build.installed import bundled_folder, headers
from bladesmith.codegen.execute.pairs import all_pairs, nearest
from bladesmith.codegen.formulas.products.exponentials import log_motor
from bladesmith.codegen.programs.merging.kinds import KINDS as MERGED
from bladesmith.codegen.programs.registration.registration import KINDS
from bladesmith.codegen.programs.tracer.scene import needs
from bladesmith.codegen.targets.c.source import ExtensionSource
from bladesmith.dispatch import product_tables, stock_algorithms
from bladesmith.kinematics.mechanism.poses.jacobians import METHODS
from bladesmith.objects.clustering.agglomerative_driver import Greedy
from bladesmith.registration.backends import algorithms as reform_algorithms
from bladesmith.registration.backends import model_rows as reform_sides
from bladesmith.registration.backends.driver import Driver
from bladesmith.registration.backends.scene import Scene
from bladesmith.tracer.rendering.driver import BoundScene
from bladesmith.tracer.rendering.hits import first_hits
from bladesmith.tracer.rendering.program import engine_for
from bladesmith.tracer.rendering.surface_tables import build_surface_tables

RAYS = 150
#: What becomes infinite, nothing, or no number on the way, in either precision.
EXTREME = (0.0, -0.0, 1.0, -1.0, np.nan, np.inf, -np.inf, 1e308, -1e308, 5e-324, 1e-300, 1e38, 1e-45, 1e20, 0.5)
#: Those of which models are made: what is not finite has no place, and coordinates are bounded.
BOUNDED = tuple(x for x in EXTREME if not abs(x) > 1e30)
LAYERS = ("color", "normal", "depth", "alpha", "cost")
CAMERA = tracer.Camera.look_at((0, -9, 2), (0, 0, 0))


def circles(count, random):
    return [
        (random.normal(size=3) + (i, 0, 0), random.normal(size=3) + (0, 0, 3), random.uniform(0.4, 2))
        for i in range(count)
    ]


def pairs(count, random):
    return [(random.normal(size=3) * 0.3 + (i, 0, -1), random.normal(size=3) * 0.3 + (i, 0, 1)) for i in range(count)]


def rays(random, dtype):
    """Rays to the scene, from far away, along axes, through corners, and such as no scene is made for."""
    start, aim = 4 * random.normal(size=(RAYS, 3)), random.normal(size=(RAYS, 3))
    along = np.eye(3)[random.integers(0, 3, RAYS)] * random.choice([-1, 1], (RAYS, 1))
    extreme = [random.choice(EXTREME, (RAYS, 3)) for _ in range(3)]
    origins = [start, 1e6 * start, start, np.round(start), extreme[0], start, extreme[1]]
    directions = [aim - start, aim - 1e6 * start, along, np.round(aim - start), aim, extreme[2], extreme[2]]
    with np.errstate(all="ignore"):
        return np.concatenate(origins).astype(dtype), np.concatenate(directions).astype(dtype)


def plain(random):
    """Surfaces of every kind that is no curve's; mirrors, checkers."""
    mirror = {"color": (0.8, 0.5, 0.2), "reflectivity": 0.4}
    corners, faces = 2 * random.normal(size=(4, 3)), [[0, 1, 2], [1, 2, 3]]
    return [
        tracer.Plane((0, 0, 1), -2, material={**mirror, "checker": (0, 0, 0)}),
        tracer.Disc(2 * random.normal(size=3), random.normal(size=3), 0.7, material=mirror),
        tracer.Facets(corners, faces, material=mirror),
        tracer.Facets(corners, faces, normals=np.tile((0.0, 0, 1), (4, 1))),
        *(tracer.Sphere(2 * random.normal(size=3), 0.5, material=mirror) for _ in range(8)),
    ]


def between_knots(make, controls, random):
    """A surface of pieces that begin and end with sums that are no objects, cut by gaps."""
    surface = make(curves.Interpolating(controls(5, random), [0, 1, 3, 3.5, 7], degree=2), gaps=True)
    assert surface.segments.free
    return surface


def a_tree_of_everything(random):
    tube = tracer.EvolvedCircles(circles(2, random), gaps=True)
    ribbon = tracer.EvolvedPointPairs(pairs(2, random), gaps=True)
    surfaces = [*plain(random), tube, ribbon]
    lamps = [tracer.Light((4, -6, 8)), tracer.Light((0, 0, -2)), tracer.Light(surfaces[-3].parameters[0, :3])]
    scene = tracer.Scene(CAMERA, lamps, surfaces, reflections=4)
    assert scene.needs.tree
    for grid, threads in ((1, 1), (2, 2)):
        scene.layers(9, 7, LAYERS, antialias=grid, threads=threads)
    origins, directions = rays(random, np.float64)
    scene.intersect(origins, directions, threads=2)
    scene.intersect(origins[3], directions)


def several_rays_at_once(random):
    balls = [tracer.Plane((0, 0, 1), -2), *(tracer.Sphere(random.normal(size=3), 0.5) for _ in range(3))]
    origins, directions = rays(random, np.float64)
    engine = engine_for(needs(["plane", "sphere"], pictures=False))
    assert engine.meets_several
    bound = BoundScene(engine, build_surface_tables(engine, balls), np.float64)
    for count in (0, 1, 3, 4, 5, 7, 8, 9, len(origins)):
        first_hits(bound, origins[:count], directions[:count], 1).normal  # noqa: B018 (asks for the rest)
    first_hits(bound, np.tile(origins, (5, 1)), directions[0], 2).normal  # noqa: B018


def all_points(random):
    """Of a line on many pieces: more than there is room for at first, some of them twice."""
    tube = between_knots(tracer.EvolvedCircles, circles, random)
    found = tube.intersect(*rays(random, np.float64), threads=1)
    assert found.count.max() > 2


def a_registration(random):
    """Lines, circles and spheres: none of a kind, one, many; with coefficients such as no object has."""
    reform_algorithms.installed_program = lambda name: None  # that one was made without sanitizers
    kinds = ("line", "circle", "sphere")
    numbers = np.array([KINDS.index(kind) for kind in kinds])
    for counts in ((0, 1, 9), (1, 0, 1), (30, 30, 30)):
        for others in ((9, 0, 1), (30, 30, 30)):
            sides = [registered(kinds, n, random) for n in (counts, others)]
            rows = np.concatenate([np.arange(n) for n in counts])
            scene = Scene(*sides, np.repeat(numbers, counts), rows, 2)
            motors = np.concatenate([np.eye(8)[:1], random.normal(size=(4, 8)), random.choice(EXTREME, (9, 8))])
            for weights, limit, least in (((0.75, 0.25, 0.75), 0.1, 0.1), ((0.0, 1e300, 1.0), np.inf, 0.0)):
                scene.set_criterion(reform_sides.MatchCriterion(weights, limit, least))
                scene.refine(motors, 3)
                scene.match(motors[-1])
                common = np.flatnonzero(np.minimum(counts, others))
                if len(common):
                    stages(scene, kinds, np.array([counts, others]), random.choice(common, (40, 3)), motors, random)

    frames(Driver(kinds, 2), kinds, random)


def frames(driver, kinds, random):
    """Middles of one object, of many, and of such as have no place; what is seen from there; the way back."""
    for n in (1, 2, 40):
        side = registered(kinds, (n, n, n), random)
        elements = np.concatenate(list(side.elements.values()))
        spoilt = random.choice(EXTREME, elements.shape)
        for given in (elements, spoilt, np.zeros_like(elements), np.full_like(elements, np.nan)):
            for place in (0, len(given) // 2, len(given) - 1):
                rule = reform_sides.CenterRule(8, place, 3.0, 1e-12, 1e-6)
                origin = driver.robust_center(np.repeat([KINDS.index(kind) for kind in kinds], n), given, rule)
        for kind, rows in side.rows.items():
            driver.to_frame(kind, rows, origin)
            near = reform_sides.MatchCriterion((1.0, 1.0, 1.0), 1.0)
            driver.squared_distances(kind, side.elements[kind][:, None], side.elements[kind], near)
        driver.motors_to_world(random.choice(EXTREME, (n, 8)), origin, origin)
        driver.twists_to_world(random.choice(EXTREME, (n, 6)), origin)


def registered(kinds, counts, random):
    """Objects as the driver reads them, every other one spoilt."""
    rows = {}
    for kind, n in zip(kinds, counts, strict=True):
        places, along = random.normal(size=(2, n, 3))
        made = {"line": (places, along), "circle": (places, along, np.ones(n)), "sphere": (places, np.ones(n))}[kind]
        rows[kind] = np.array(getattr(cga3d, kind)(*made)._data)
        rows[kind][1::2] = random.choice(BOUNDED, rows[kind][1::2].shape)
    driver = Driver(kinds, 1)
    return reform_sides.ModelData(rows, {kind: driver.elements(kind, x) for kind, x in rows.items()})


def stages(scene, kinds, counts, chosen, motors, random):
    """What goes by pairs of objects: of these kinds, by their places in a list."""
    numbers = np.array([KINDS.index(kind) for kind in kinds])[chosen]
    query, reference = ((random.random(chosen.shape) * n[chosen]).astype(np.int32) for n in counts)
    numbers[::5, 2] = -1
    scene.samples(numbers, query, reference, random.choice([-1.0, 1.0], chosen.shape), np.inf)
    scene.conditioning(numbers, query)
    one = chosen[:, 0] == chosen[0, 0]
    first, second = query[one, 0], reference[one, 0]
    partners = np.where(random.random(len(first)) < 0.5, -1, random.integers(0, len(first), len(first)))
    for motor in motors:
        scene.rates(kinds[chosen[0, 0]], motor, first, second)
        scene.direct(motor, (numbers[one, 0], first, second, partners, np.ones(len(first))), 9, 1e-13)


def some_chains(random):
    """Numbers of joints that fill the room for them and less, all numbers of poses that lanes may be left with."""
    for count in (1, 6, 16, 17):
        positions, directions = random.normal(size=(2, count, 3))
        chain = kinematics.Chain(kinematics.revolute_axis(positions, directions))
        for n in (1, 2, 3, 4, 9):
            q = random.normal(size=(n, count))
            q[::2] = random.choice([*BOUNDED, np.nan], q[::2].shape)
            for every in (False, True):
                chain.forward(q, every)
                chain.acceleration(q, q, q, every)
            chain.jacobian(q)
            chain.jacobian(q, "tool", random.normal(size=(n, 3)))
        chain.inverse(chain.forward(q), attempts=2, iterations=9)


def merging(random):
    """Of all kinds: copies, pairs that are near each other, and what is no object; none, one, and many."""
    stock_algorithms.installed_program = lambda name: None  # that one was made without sanitizers
    for kind in MERGED:
        size = cga3d.kind(kind).size
        for count in (0, 1, 2, 300):
            rows = random.normal(size=(count, size))
            rows[::7] = random.choice(EXTREME, rows[::7].shape)
            rows[1::3] = rows[:1]
            for align in (False, True):
                greedy = Greedy(kind, rows, np.ones(count), random.choice([0.1, 10.0, np.inf]), align)
                greedy.find(1)
                while greedy.step(50):
                    pass


def some_mechanisms(random):
    """A four-bar linkage: coordinates such as it has and none, along a path, and both kinds of Jacobians."""
    places = np.array([[0, 0, 0], [0, 1, 0], [2, 1.5, 0], [2.5, 0, 0]])
    bodies = ["base", "crank", "coupler", "rocker"]
    ends = zip(bodies, [*bodies[1:], bodies[0]], places, strict=True)
    joints = [kinematics.Revolute(a, b, cga3d.circle(p, (0, 0, 1), 0.2)) for a, b, p in ends]
    bars = kinematics.Mechanism(bodies, "base")
    for name, joint in zip("abcd", joints, strict=True):
        bars.add(joint, name)
    angles = np.append(random.uniform(-4, 4, 9), [np.nan, np.inf, 1e300, 0.0])
    poses = bars.solve_pose({"a": angles})
    bars.solve_pose({"a": angles}, path=True)
    bars.solve_pose(targets={"rocker": poses["rocker"], "coupler": ((1.0, 0.0, 0.0), np.ones((len(angles), 3)))})
    for method in METHODS:
        bars.jacobian("a", ["c", "coupler"], poses=poses, method=method, strict=False)


def simulations(random):
    """Two rods with loads, one turning body, and one on a pin: methods of all sorts, gradients, steps too long."""
    rod, turn = [1 / 12, 1 / 12, 1e-3], np.array([[0, 0, 1.0], [0, 1, 0], [-1, 0, 0]])
    loads = [dynamics.Gravity((0, 0, -9.81)), dynamics.Damper(angular=0.1, linear=0.2)]
    rods = {name: dynamics.RigidBody(1.0, rod, (x, 0, 0), turn) for name, x in (("upper", 0.5), ("lower", 1.5))}
    axes = [cga3d.circle((x, 0, 0), (0, 1, 0), 1.0) for x in (0, 1)]
    hinges = [kinematics.Revolute(a, b, x) for a, b, x in zip(("base", "upper"), rods, axes, strict=True)]
    top = dynamics.RigidBody(1.0, [0.1, 0.1, 0.02], (0, 0, 1), angular_velocity=random.normal(size=3))
    pin = dynamics.Pin(cga3d.point((0, 0, -1.0)))
    for integrator in ("rk4", "taylor"):
        dynamics.Simulation(dynamics.System(rods, hinges), loads, integrator=integrator).run(0.05)
    dynamics.Simulation(dynamics.System(rods, hinges), loads[:1]).run(0.02, sensitivities=["gravity"])
    dynamics.Simulation(top, loads, integrator="adaptive").run(0.2, sensitivities=["mass"])
    dynamics.Simulation(top, loads[:1], [pin], integrator="rk4").run(1000.0, step=100.0, project=True)


def products_by_table(random):
    """All numbers of items that blocks may be left with, one operand for all of them, and both precisions."""
    library = load(generated_extension(bundled_folder("general"), headers()))
    library.lib.bs_initialize()
    for instance in range(library.lib.bs_instance_count()):
        if not library.lib.bs_use_instance(instance):
            continue
        for signature in ((2, 0, 0), (2, 1, 1), (4, 1, 0)):
            blades = tuple(range(1 << sum(signature)))
            table = product_tables.product_table(bs.algebra(*signature), "geometric", blades, blades[1::2])
            struct, kept = table_struct(library.ffi, table)
            for single, dtype in ((0, np.float64), (1, np.float32)):
                for count in (1, 2, 7, 8, 9, 16, 33):
                    a, b = (random.choice(EXTREME, (count, n)).astype(dtype) for n in table.sizes)
                    out = np.empty((count, len(table.blades)), dtype)
                    for stride_a, stride_b in ((a.shape[1], b.shape[1]), (0, b.shape[1]), (a.shape[1], 0)):
                        passed = [library.ffi.from_buffer(x) for x in (out, a, b)]
                        library.lib.bs_multiply(
                            struct, single, 0, count, passed[0], passed[1], stride_a, passed[2], stride_b
                        )
            assert kept


def table_struct(ffi, table):
    """The C view of a table, and what keeps its memory alive."""
    indices = [ffi.from_buffer("int32_t[]", x) for x in (table.starts, table.left, table.right)]
    kept = [*indices, ffi.from_buffer("double[]", table.weights)]
    return ffi.new("bs_product *", [len(table.blades), *table.sizes, *kept]), kept


@codegen.kernel(cga3d.kind("motor"), cga3d.kind("circle"))
def moved(m, x):
    return m * x * ~m


logarithm = codegen.kernel(cga3d.kind("motor"))(log_motor)


@codegen.kernel(cga3d.kind("point"), cga3d.kind("point"))
def nearness(x, y):
    return (x | y).grade(0)


def some_kernels(random):
    """All numbers of items that vectors may be left with, one operand for all, both precisions, and all pairs."""
    for kernel in (moved, logarithm, nearness):
        for dtype in (np.float64, np.float32):
            for count in (0, 1, 2, 3, 4, 5, 8, 9, 33):
                rows = [random.choice(EXTREME, (count, kind.size)).astype(dtype) for kind in kernel.kinds]
                kernel(*rows)
                kernel(*(row[0] if k and count else row for k, row in enumerate(rows)))
    points = random.choice(EXTREME, (300, 5))
    for count in (1, 7, 300):
        run = nearness.bound("c", [points, points])
        all_pairs(run, points[:count], points)
        nearest(run, points[:count], points)


def a_mistake(random):
    """What must be found, or nothing would be."""
    text = "int wrong(int n) { int numbers[4] = {1, 2, 3, 4}; return numbers[n]; }"
    load(ExtensionSource("wrong", "int wrong(int n);", text)).lib.wrong(4)


PARTS = {
    part.__name__: part
    for part in (
        a_tree_of_everything, several_rays_at_once, all_points, a_registration, some_chains, merging, some_mechanisms,
        simulations, products_by_table, some_kernels, a_mistake,
    )
}  # fmt: skip

if __name__ == "__main__":
    for name in sys.argv[1:]:
        PARTS[name](np.random.default_rng(8))
        print("done", name, flush=True)
