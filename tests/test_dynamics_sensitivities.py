"""Gradients of trajectories: against central differences at 50 digits of Newton's and Euler's equations on vectors,
and against the simulations' own differences where there is no such reference.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache
from typing import Any

import mpmath
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import bladesmith as bs
from bladesmith import dynamics, kinematics
from bladesmith.calls import call
from bladesmith.codegen.errors import InputError

ALGEBRAS = [bs.cga3d, bs.pga3d]
DIGITS = 50
#: Step of the differences; their error is its square.
STEP = "1e-15"
BAR = 1e-8
Vector = list[Any]

# -- an independent integration at 50 digits ---------------------------------------------------------------


def cross(a: Vector, b: Vector) -> Vector:
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def turned(r: Vector, a: Vector) -> Vector:
    """R a, of a matrix row by row."""
    return [r[3 * i] * a[0] + r[3 * i + 1] * a[1] + r[3 * i + 2] * a[2] for i in range(3)]


def turned_back(r: Vector, a: Vector) -> Vector:
    return [r[i] * a[0] + r[i + 3] * a[1] + r[i + 6] * a[2] for i in range(3)]


def turning(r: Vector, w: Vector) -> Vector:
    """dR = R [w]x."""
    return [x for i in range(3) for x in cross(r[3 * i : 3 * i + 3], w)]


def extrapolated(rates: Callable[[Vector], Vector], y: Vector, duration: Any, steps: int, columns: int = 13) -> Vector:
    """Gragg's midpoint rule with extrapolation; the last two columns agree."""
    h = mpmath.mpf(duration) / steps
    for _ in range(steps):
        rows: list[list[Vector]] = []
        for j in range(columns):
            n = 2 * (j + 1)
            s = h / n
            before, now = y, [a + s * b for a, b in zip(y, rates(y), strict=True)]
            for _ in range(n - 1):
                before, now = now, [a + 2 * s * b for a, b in zip(before, rates(now), strict=True)]
            row = [[(a + b + s * c) / 2 for a, b, c in zip(before, now, rates(now), strict=True)]]
            for k in range(j):
                ratio = mpmath.mpf(j + 1) ** 2 / (j - k) ** 2 - 1
                row.append([a + (a - b) / ratio for a, b in zip(row[k], rows[-1][k], strict=True)])
            rows.append(row)
        y = rows[-1][-1]
        assert max(abs(a - b) for a, b in zip(y, rows[-1][-2], strict=True)) < mpmath.mpf("1e-24")
    return y


def numbers(values: Any) -> Vector:
    return [mpmath.mpf(float(v)) for v in np.ravel(values)]


def central(outcome: Callable[[dict[str, Vector]], Vector], given: dict[str, Any], along: dict[str, Any]) -> np.ndarray:
    """Derivative of an outcome where the given values move along a direction."""
    with mpmath.workdps(DIGITS):
        h, found = mpmath.mpf(STEP), []
        for sign in (1, -1):
            moved = {k: numbers(v) for k, v in given.items()}
            for k, d in along.items():
                moved[k] = [a + sign * h * b for a, b in zip(moved[k], numbers(d), strict=True)]
            found.append(outcome(moved))
        return np.array([float((a - b) / (2 * h)) for a, b in zip(*found, strict=True)])


def last(sensitivity: Any, direction: Any) -> np.ndarray:
    """Position, velocity and spin at the end along a direction of the parameter."""
    d = np.ravel(direction)
    parts = [sensitivity.position, sensitivity.velocity, sensitivity.angular_velocity]
    return np.concatenate([np.einsum("k,ki->i", d, x[-1]) for x in parts])


def assert_close(found: np.ndarray, expected: np.ndarray, bar: float = BAR) -> None:
    for f, e in zip(np.split(found, 3), np.split(expected, 3), strict=True):
        assert np.abs(f - e).max() <= bar * np.abs(e).max()


# -- a free body -------------------------------------------------------------------------------------------

FREE: dict[str, Any] = {
    "mass": 2.0, "inertia": (1.0, 2.0, 2.5), "velocity": (0.3, -0.2, 0.5), "angular_velocity": (0.4, 1.3, -0.6),
    "position": (1.0, 2.0, 3.0), "gravity": (0.3, 0.2, -9.81), "spring.stiffness": 30.0, "spring.length": 0.7,
    "spring.damping": 0.5, "spring.point": (0.2, 0.1, -0.4), "spring.anchor": (0.0, 1.0, 4.0),
}  # fmt: skip
TURN = Rotation.from_rotvec([0.5, 1.0, 0.3]).as_matrix()
DURATION = 0.5


def free_end(p: dict[str, Vector]) -> Vector:
    """Newton and Euler with a damped spring."""

    def rates(y: Vector) -> Vector:
        x, r, v, w = y[:3], y[3:12], y[12:15], y[15:]
        arm = turned(r, p["spring.point"])
        gap = [a - b - c for a, b, c in zip(p["spring.anchor"], x, arm, strict=True)]
        speed = [-a - b for a, b in zip(v, turned(r, cross(w, p["spring.point"])), strict=True)]
        way = mpmath.sqrt(sum(a * a for a in gap))
        closing = sum(a * b for a, b in zip(gap, speed, strict=True)) / way
        size = (p["spring.stiffness"][0] * (way - p["spring.length"][0]) + p["spring.damping"][0] * closing) / way
        force = [size * a for a in gap]
        moment = turned_back(r, cross(arm, force))
        spin = cross([a * b for a, b in zip(p["inertia"], w, strict=True)], w)
        dw = [(a + b) / c for a, b, c in zip(moment, spin, p["inertia"], strict=True)]
        dv = [g + f / p["mass"][0] for g, f in zip(p["gravity"], force, strict=True)]
        return [*v, *turning(r, w), *dv, *dw]

    y = extrapolated(rates, [*p["position"], *numbers(TURN), *p["velocity"], *p["angular_velocity"]], DURATION, 7)
    return [*y[:3], *y[12:]]


def free_simulation(algebra: Any, given: dict[str, Any]) -> Any:
    body = dynamics.RigidBody(
        given["mass"], given["inertia"], given["position"], TURN, given["velocity"], given["angular_velocity"], algebra
    )
    spring = dynamics.Spring(*(given[f"spring.{n}"] for n in ("point", "anchor", "stiffness", "length", "damping")))
    return dynamics.Simulation(body, [dynamics.Gravity(given["gravity"]), spring])


def test_free_body_at_50_digits() -> None:
    runs = [free_simulation(a, FREE).run(DURATION, times=[DURATION], sensitivities=list(FREE)) for a in ALGEBRAS]
    rng = np.random.default_rng(5)
    for names in (["mass"], ["inertia"], ["velocity", "angular_velocity"], ["spring.stiffness"], list(FREE)):
        along = {name: rng.normal(size=np.shape(FREE[name])) for name in names}
        expected = central(free_end, FREE, along)
        for run in runs:
            assert_close(sum(last(run.sensitivities[n], d) for n, d in along.items()), expected)


# -- a heavy top, and a pendulum ---------------------------------------------------------------------------

ARM = np.array([0.1, -0.2, 0.9])
TOP: dict[str, Any] = {
    "mass": 1.5, "inertia": (0.4, 0.5, 0.3), "angular_velocity": (0.5, -0.3, 12.0), "gravity": (0.0, 0.0, -9.81),
}  # fmt: skip


def top_end(p: dict[str, Vector]) -> Vector:
    """A body that turns about the origin, its centre at ARM."""
    arm, m = numbers(ARM), p["mass"][0]
    square = sum(a * a for a in arm)
    tensor = mpmath.matrix(3)
    for i in range(3):
        for j in range(3):
            tensor[i, j] = m * ((square if i == j else 0) - arm[i] * arm[j]) + (p["inertia"][i] if i == j else 0)
    inverse = tensor**-1

    def times(a: Any, x: Vector) -> Vector:
        return [sum(a[i, j] * x[j] for j in range(3)) for i in range(3)]

    def rates(y: Vector) -> Vector:
        r, w = y[:9], y[9:]
        pull = cross(arm, [m * g for g in turned_back(r, p["gravity"])])
        return [*turning(r, w), *times(inverse, [a + b for a, b in zip(pull, cross(times(tensor, w), w), strict=True)])]

    y = extrapolated(rates, [*numbers(TURN), *p["angular_velocity"]], DURATION, 8)
    r, w = y[:9], y[9:]
    return [*turned(r, arm), *turned(r, cross(w, arm)), *w]


@cache
def top_difference(name: str) -> tuple[np.ndarray, np.ndarray]:
    """A direction of a parameter, and the derivative along it."""
    d = np.random.default_rng(len(name)).normal(size=np.shape(TOP[name]))
    return d, central(top_end, TOP, {name: d})


def top_simulation(algebra: Any, **options: Any) -> Any:
    spin = np.array(TOP["angular_velocity"])
    body = dynamics.RigidBody(TOP["mass"], TOP["inertia"], TURN @ ARM, TURN, TURN @ np.cross(spin, ARM), spin, algebra)
    pin = dynamics.Pin(algebra.point(-ARM), algebra.point((0, 0, 0)))
    return dynamics.Simulation(body, [dynamics.Gravity(TOP["gravity"])], [pin], **options)


@pytest.mark.parametrize(
    ("algebra", "stabilization"), [(bs.cga3d, "auto"), (bs.pga3d, "auto"), (bs.cga3d, "projection")]
)
def test_heavy_top_at_50_digits(algebra: Any, stabilization: str) -> None:
    run = top_simulation(algebra, stabilization=stabilization).run(
        DURATION, times=[DURATION], sensitivities=[*TOP, "velocity"]
    )
    for name in TOP:
        d, expected = top_difference(name)
        found = last(run.sensitivities[name], d)
        if name == "angular_velocity":  # the centre moves with the spin
            found += last(run.sensitivities["velocity"], TURN @ np.cross(d, ARM))
        assert_close(found, expected)


HANG = {"mass": [1.5], "inertia": [0.4, 0.5, 0.3], "angle": [0.8]}
AXIS, LENGTH = np.array([0.6, 0.0, 0.8]), 1.25


def frame() -> np.ndarray:
    """Axes of a pendulum: along its arm, across, and the axis of turning, which is level."""
    return np.array([[0, 0, -1.0], [1, 0, 0], [0, -1, 0]]).T


def pendulum_end(p: dict[str, Vector]) -> Vector:
    """Position, velocity and spin: the angle's equation alone."""
    m, axis, arm = p["mass"][0], numbers(AXIS), mpmath.mpf(LENGTH)
    inertia = sum(i * a * a for i, a in zip(p["inertia"], axis, strict=True)) + m * arm**2
    rates = lambda y: [y[1], -m * mpmath.mpf(9.81) * arm / inertia * mpmath.sin(y[0])]  # noqa: E731
    angle, rate = extrapolated(rates, [p["angle"][0], mpmath.mpf(0)], DURATION, 4)
    c, s = arm * mpmath.cos(angle), arm * mpmath.sin(angle)
    return [s, mpmath.mpf(0), -c, rate * c, mpmath.mpf(0), rate * s, *(-rate * a for a in axis)]


def test_pendulum_at_50_digits() -> None:
    """About an axis that is askew in the body; the first angle is place and orientation together."""
    level, down = np.array([0, 1.0, 0]), np.array([0, 0, -1.0])
    hang = np.array([0.8, 0, -0.6])  # across the axis in the body
    body_axes = np.stack([hang, np.cross(AXIS, hang), AXIS], 1)
    at_rest = np.stack([down, np.cross(level, down), level], 1) @ body_axes.T
    turn = Rotation.from_rotvec(-HANG["angle"][0] * level).as_matrix() @ at_rest
    place = turn @ (LENGTH * hang)
    body = dynamics.RigidBody(HANG["mass"][0], HANG["inertia"], place, turn, algebra=bs.pga3d)
    ends = [bs.pga3d.point(x - LENGTH * hang) for x in (0 * AXIS, AXIS)]
    pins = [dynamics.Pin(x) for x in ends]
    names = ["mass", "inertia", "position", "orientation"]
    run = dynamics.Simulation(body, [dynamics.Gravity((0, 0, -9.81))], pins).run(
        DURATION, times=[DURATION], sensitivities=names
    )
    found = run.sensitivities
    for name, d in (("mass", [1.0]), ("inertia", [0.3, -0.2, 0.7])):
        assert_close(last(found[name], d), central(pendulum_end, HANG, {name: d}))
    swung = last(found["orientation"], -AXIS) + last(found["position"], np.cross(-level, place))
    assert_close(swung, central(pendulum_end, HANG, {"angle": [1.0]}))


# -- the simulations' own differences ----------------------------------------------------------------------

#: Weights of central differences of order 8.
WEIGHTS = (4 / 5, -1 / 5, 4 / 105, -1 / 280)


def difference(state: Callable[[float], Sequence[np.ndarray]], h: float) -> list[np.ndarray]:
    total: list[Any] = []
    for k, weight in enumerate(WEIGHTS, 1):
        ahead, behind = state(k * h), state(-k * h)
        parts = [weight / h * (a - b) for a, b in zip(ahead, behind, strict=True)]
        total = parts if not total else [a + b for a, b in zip(total, parts, strict=True)]
    return total


START: dict[str, Any] = {
    "mass": 2.0, "inertia": np.array([1.0, 2.0, 2.5]), "position": np.array([1.0, 2.0, 3.0]),
    "orientation": np.zeros(3), "velocity": np.zeros(3), "angular_velocity": np.array([0.4, 1.3, -0.6]),
    "gravity": np.array([0.3, 0.2, -9.81]), "damper.angular": 0.1, "damper.linear": 0.2, "spring.stiffness": 20.0,
    "spring.length": 0.5, "spring.damping": 0.3, "spring.point": np.array([0.2, 0.1, -0.4]),
    "spring.anchor": np.array([0.0, 1.0, 4.0]), "body_wrench": np.array([0.1, 0.2, 0.3, 0.4, 0.5, 0.6]),
    "world_wrench": np.array([0.3, 0.1, 0.2, 0.6, 0.4, 0.5]),
}  # fmt: skip
TIMES = np.array([0.0, 0.4, 0.8])
POINT = np.array([0.2, 0.1, 1.0])
PLACE = TURN @ POINT + START["position"]


def everything(algebra: Any, p: dict[str, Any], constraints: Sequence[Any]) -> Any:
    turn = TURN @ Rotation.from_rotvec(p["orientation"]).as_matrix()
    velocity = TURN @ np.cross(START["angular_velocity"], -POINT) + p["velocity"]
    body = dynamics.RigidBody(p["mass"], p["inertia"], p["position"], turn, velocity, p["angular_velocity"], algebra)
    wrenches = [algebra.wrap(algebra.kind("twist"), p[f"{x}_wrench"]) for x in ("body", "world")]
    loads = [
        dynamics.Gravity(p["gravity"]), dynamics.BodyWrench(wrenches[0]), dynamics.WorldWrench(wrenches[1]),
        dynamics.Damper(p["damper.angular"], p["damper.linear"]),
        dynamics.Spring(*(p[f"spring.{n}"] for n in ("point", "anchor", "stiffness", "length", "damping"))),
    ]  # fmt: skip
    return dynamics.Simulation(body, loads, constraints)


def states(run: Any) -> list[np.ndarray]:
    return [run.position, run.velocity, run.angular_velocity, run.energy]


def path(algebra: Any) -> Callable[[float], Any]:
    """A point that moves off, smoothly enough not to change the start."""
    first, second, third = (algebra.point(PLACE + x) for x in ([0, 0, 0], [0.1, 0.2, -0.1], [-0.1, -0.2, 0.1]))
    if algebra is bs.pga3d:
        slope = (second - third) / 2
        return lambda t: (first + t**3 * slope, 3 * t**2 * slope, 6 * t * slope)
    slope, bend = (second - third) / 2, (second + third - 2 * first) / 2
    return lambda t: (
        first + t**3 * slope + t**6 * bend, 3 * t**2 * slope + 6 * t**5 * bend, 6 * t * slope + 30 * t**4 * bend,
    )  # fmt: skip


CONSTRAINTS: dict[str, Callable[[], tuple[Any, list[Any]]]] = {
    "free": lambda: (bs.pga3d, []),
    "pin where it is": lambda: (bs.cga3d, [dynamics.Pin(bs.cga3d.point(POINT))]),
    "pin": lambda: (bs.pga3d, [dynamics.Pin(bs.pga3d.point(POINT), bs.pga3d.point(PLACE))]),
    "path": lambda: (bs.cga3d, [dynamics.PinPath(bs.cga3d.point(POINT), path(bs.cga3d))]),
    "plane, twice": lambda: (
        bs.pga3d, [dynamics.Incidence(bs.pga3d.point(POINT), bs.pga3d.plane((0, 0, 1), PLACE[2]))] * 2
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", CONSTRAINTS)
def test_all_parameters_together(case: str) -> None:
    """The gradient along a direction of all parameters at once."""
    algebra, constraints = CONSTRAINTS[case]()
    start = START
    rng = np.random.default_rng(7)
    along = {name: rng.normal(size=np.shape(value)) * (0.1 + np.abs(value).max()) for name, value in start.items()}
    run = everything(algebra, start, constraints).run(TIMES[-1], times=TIMES, sensitivities=list(start))

    def moved(e: float) -> list[np.ndarray]:
        p = {name: value + e * along[name] for name, value in start.items()}
        return states(everything(algebra, p, constraints).run(TIMES[-1], times=TIMES, project=bool(constraints)))

    total: list[Any] = [0.0] * 4
    for name, d in along.items():
        s, d = run.sensitivities[name], np.ravel(d)
        for i, x in enumerate((s.position, s.velocity, s.angular_velocity)):
            total[i] = total[i] + np.einsum("k,tki->ti", d, x)
        total[3] = total[3] + s.energy @ d
    for found, expected in zip(total, difference(moved, 2e-3), strict=True):
        assert np.abs(found - expected).max() <= 1e-8 * np.abs(expected).max()


def double_pendulum(algebra: Any, mass: float, stiffness: float) -> Any:
    bodies = {
        "upper": dynamics.RigidBody(mass, (0.15, 0.2, 0.3), (0, 0.5, 0), algebra=algebra),
        "lower": dynamics.RigidBody(2.0, (0.3, 0.2, 0.25), (0, 1.4, 0.2), algebra=algebra),
    }
    joints = [
        kinematics.Spherical("base", "upper", algebra.point((0, 0, 0))),
        kinematics.Spherical("upper", "lower", algebra.point((0, 1, 0))),
    ]
    spring = dynamics.Spring((0.1, 0, 0.2), (0, 0.1, 0.1), stiffness, 0.3, 0.4, body="upper", other="lower")
    return dynamics.Simulation(dynamics.System(bodies, joints), [dynamics.Gravity((0, 0, -9.81)), spring])


def test_systems() -> None:
    run = double_pendulum(bs.pga3d, 1.0, 5.0).run(
        TIMES[-1], times=TIMES, sensitivities=["upper.mass", "spring[0].stiffness"]
    )

    def moved(e: float) -> list[np.ndarray]:
        return states(double_pendulum(bs.pga3d, 1 + e, 5 + 2 * e).run(TIMES[-1], times=TIMES).bodies["lower"])

    mass, stiffness = (run.bodies["lower"].sensitivities[n] for n in ("upper.mass", "spring[0].stiffness"))
    for name, expected in zip(
        ("position", "velocity", "angular_velocity", "energy"), difference(moved, 5e-3), strict=True
    ):
        found = (getattr(mass, name) + 2 * getattr(stiffness, name))[:, 0]
        assert np.abs(found - expected).max() <= 1e-8 * np.abs(expected).max()


# -- shapes, kinds of loads, errors ------------------------------------------------------------------------


def test_batches() -> None:
    """Each simulation has its own; shapes as documented."""
    body = dynamics.RigidBody([1.0, 2.0, 3.0], FREE["inertia"], velocity=(1, 2, 3), angular_velocity=(0.4, 1.3, -0.6))
    names = ["mass", "inertia", "orientation[1]"]
    runs = dynamics.Simulation(body).run(1.0, times=[0.5, 1.0], sensitivities=names)
    s = runs.sensitivities["inertia"]
    assert s.position.shape == s.orientation.shape == s.velocity.shape == (3, 3, 3, 3)
    assert s.motor.shape == (3, 3, 3) and s.energy.shape == (3, 3, 3)
    assert runs.sensitivities["orientation[1]"].motor.shape == (3, 3, 1)
    for i, mass in enumerate(body.mass):
        one = dynamics.RigidBody(mass, FREE["inertia"], velocity=(1, 2, 3), angular_velocity=(0.4, 1.3, -0.6))
        alone = dynamics.Simulation(one).run(1.0, times=[0.5, 1.0], sensitivities=names)
        for name in names:
            for part in ("position", "velocity", "angular_velocity", "energy"):
                x, y = (getattr(r.sensitivities[name], part) for r in (runs, alone))
                np.testing.assert_allclose(x[i], y, rtol=1e-10, atol=1e-12)


def test_functions_of_time() -> None:
    """Loads that change with time pass; those that depend on the state do not."""

    def simulation(mass: float, *loads: Any) -> Any:
        body = dynamics.RigidBody(
            mass, FREE["inertia"], (1, 2, 3), velocity=(0.3, 0, 0.1), angular_velocity=(0.4, 0.3, -0.6)
        )
        return dynamics.Simulation(body, loads)

    push = dynamics.WorldWrench(lambda t: np.cos(2 * t) * dynamics.wrench((1, -2, 0.3), (0, 0.1, 3)))
    own = dynamics.BodyWrench(lambda t: np.sin(3 * t) * dynamics.wrench((1, 2, 3), (0, 0.1, 0)))
    run = simulation(2.0, push, own).run(0.2, times=TIMES / 4, sensitivities=["mass"])
    expected = difference(lambda e: states(simulation(2 + e, push, own).run(0.2, times=TIMES / 4))[:3], 2e-2)
    s = run.sensitivities["mass"]
    for found, other in zip((s.position, s.velocity, s.angular_velocity), expected, strict=True):
        assert np.abs(found[:, 0] - other).max() <= 1e-8 * np.abs(other).max()
    drag = dynamics.BodyWrench(lambda t, motor, twist: -0.1 * dynamics.wrench((1, 0, 0), 0))
    with pytest.raises(InputError, match="functions of the state"):
        simulation(2.0, drag).run(0.1, sensitivities=["mass"])


def test_tangents_of_motors() -> None:
    """The twist delta moves the pose: dR = -R delta/2."""
    body = lambda w: dynamics.RigidBody(1.0, (1, 2, 3), angular_velocity=(w, 1.0, 0.3), velocity=(1, 2, 3))  # noqa: E731
    run = dynamics.Simulation(body(0.2)).run(1.0, times=[1.0], sensitivities=["angular_velocity[0]"])
    rate = -(run.motor[-1] * run.sensitivities["angular_velocity[0]"].motor[-1, 0]).values / 2
    (expected,) = difference(
        lambda e: [dynamics.Simulation(body(0.2 + e)).run(1.0, times=[1.0], rtol=1e-13).motor[-1].values], 5e-3
    )
    assert np.abs(rate[: len(expected)] - expected).max() < 1e-8


def test_bilinear_tangents() -> None:
    """Of a product the tangent is what its two factors add."""
    algebra, rng = bs.cga3d, np.random.default_rng(3)
    a, b, da, db = (algebra.wrap(algebra.kind("twist"), rng.normal(size=(5, 6))) for _ in range(4))
    value, tangent = call(algebra, "motion_tangents.bracket", a, b, da, db).values
    bracket = lambda x, y: call(algebra, "mechanics.bracket", x, y).value  # noqa: E731
    np.testing.assert_allclose(value.values, bracket(a, b).values)
    np.testing.assert_allclose(tangent.values, (bracket(da, b) + bracket(a, db)).values)


@pytest.mark.parametrize(
    ("names", "told"),
    [
        (["masss"], "did you mean 'mass'"), (["inertia[3]"], "3 components"), (["spring[1].length"], "did you mean"),
        (["damper.linear"], "There are: mass"), ([3], "by name"), (["gravity"], "no parameter"),
    ],
)  # fmt: skip
def test_unknown_parameters(names: list[Any], told: str) -> None:
    body = dynamics.RigidBody(1.0, (1, 1, 1))
    with pytest.raises(InputError, match=told.replace("[", r"\[")):
        dynamics.Simulation(body, [dynamics.Spring(0, (0, 0, 1), 3.0)]).run(1.0, sensitivities=names)


def test_refused() -> None:
    body = dynamics.RigidBody(1.0, (1, 1, 1))
    with pytest.raises(InputError, match="carries no sensitivities.*adaptive"):
        dynamics.Simulation(body, integrator="rk4").run(1.0, sensitivities=["mass"])
    with pytest.raises(InputError, match="project"):
        dynamics.Simulation(body).run(1.0, sensitivities=["mass"], project=True)
    run = dynamics.Simulation(body).run(1.0, times=[1.0], sensitivities=["mass"])
    with pytest.raises(InputError, match="did you mean 'mass'"):
        run.sensitivities["mas"]
