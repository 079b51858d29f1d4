"""Taylor series: coefficients against mpmath at 50 digits, trajectories against elliptic functions and 30 digits."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache
from typing import Any

import mpmath
import numpy as np
import pytest

from bladesmith import cga3d as cga
from bladesmith import pga3d as pga
from bladesmith.calls import call
from bladesmith.codegen.build import ExtensionSource, load
from bladesmith.codegen.errors import InputError, TraceError
from bladesmith.codegen.formulas import flows, mechanics
from bladesmith.codegen.machine import has_wide_vectors
from bladesmith.codegen.multivector import absolute, atan2, cos, exp, log, select, sin, sqrt, stumpff1
from bladesmith.codegen.programs.kernels import Declared, traced
from bladesmith.codegen.rings import PrecisionRing
from bladesmith.codegen.taylor import HIGHEST_ORDER, WIDTHS, series_function
from bladesmith.codegen.templating import included_headers
from bladesmith.codegen.trace import Kernel, row
from bladesmith.dynamics import (
    BodyWrench,
    Damper,
    Gravity,
    Incidence,
    Pin,
    PinPath,
    RigidBody,
    Simulation,
    Spring,
    System,
    VirtualPower,
    WorldWrench,
)
from bladesmith.dynamics.methods import order_of

ORDER = 20
ALGEBRAS = ["cga3d", "pga3d"]
BY_NAME = {"cga3d": cga, "pga3d": pga}
WIDE = has_wide_vectors()
#: Of coefficients that are about one: rounding of the inputs and of convolutions.
ROUNDING = 1e-13

SOURCE = """
#include "platform.h"
#define BS_BITS 64
#define BS_BYTES 0
#define BS_TAG f64_scalar
#include "instance.h"
#include "elementary.h"
#include "series.h"
%(begin)s
%(text)s
%(declared)s
{
  double work[%(work)d];
  for (int k = 0; k <= order; k++) FN(%(name)s)(k, work, %(arguments)s);
}
%(end)s
#ifndef BS_SOURCE_HASH
#define BS_SOURCE_HASH ""
#endif
const char *bs_source_hash(void) { return BS_SOURCE_HASH; }
#include "instance_end.h"
"""


class Compiled:
    """A series function, compiled by itself."""

    def __init__(self, kernels: Sequence[Kernel], still: Sequence[str] = (), tag: str = "base") -> None:
        self.still = still
        self.made = made = series_function("series", kernels, still)
        declared = "void run(int order, " + ", ".join(
            [f"double *{o}" for o in made.outputs] + [f"const double *{i}" for i in made.inputs]
        )
        moving = {**made.outputs, **{i: n for i, n in made.inputs.items() if i not in still}}
        arguments = [f"{x} + {moving[x]} * k" if x in moving else x for x in (*made.outputs, *made.inputs)]
        wide = tag == "wide"
        source = SOURCE % {
            "text": made.texts[tag], "declared": declared + ")", "work": made.work + 1, "name": f"series_{tag}",
            "arguments": ", ".join(arguments), "begin": "BS_V3_BEGIN" * wide, "end": "BS_V3_END" * wide,
        }  # fmt: skip
        cdef = f"{declared}); const char *bs_source_hash(void);"
        self.module = load(ExtensionSource(f"series_{kernels[0].name}_{tag}", cdef, source, included_headers([source])))

    def __call__(self, order: int, given: dict[str, Any]) -> dict[str, Any]:
        """Coefficients (order + 1, size) of the outputs, from those of the inputs."""
        found = {o: np.full((order + 1, n), np.nan) for o, n in self.made.outputs.items()}
        arrays = [np.ascontiguousarray(given[i], float) for i in self.made.inputs]
        ffi = self.module.ffi
        self.module.lib.run(order, *[ffi.from_buffer("double[]", a) for a in (*found.values(), *arrays)])
        return found


def kernel(formula: Callable[..., Any], kinds: str, algebra: str = "cga3d") -> Kernel:
    return traced(Declared(formula, tuple(kinds.split(", ")), "", algebra))


def series_of(function: Callable[[Any], Sequence[Any]], ring: PrecisionRing, order: int = ORDER) -> Any:
    """Taylor coefficients (order + 1, size) of a function of time: differences over 2^-100, with digits to spare."""
    mp, bits = ring.context, 100
    with mp.workprec(bits * order + 200):
        step = mp.ldexp(1, -bits)
        rows = [[mp.mpf(x) for x in function(i * step)] for i in range(order + 1)]
        found = []
        for k in range(order + 1):
            found.append([float(x / (mp.factorial(k) * step**k)) for x in rows[0]])
            rows = [[b - a for a, b in zip(*pair, strict=True)] for pair in zip(rows, rows[1:], strict=False)]
    return np.array(found)


# -- every node -----------------------------------------------------------------------------------------------


def nodes_first(x, y, a):  # type: ignore[no-untyped-def]
    """Sums, products, squares, quotients, roots."""
    z = sqrt(x * x + y * y + 1)
    return row([x * y - 2 * z, a * x * (3 * y) + a, z / (2 + a * x), (x + y) * (x + y) * (x - 3), 1 / (1 + y * y)])


def nodes_second(x, y, a):  # type: ignore[no-untyped-def]
    """Elementary functions."""
    return row([sin(x * y) + a, cos(x * y) * y, exp(a * x), log(3 + x), atan2(x, 2 + y), sin(y), cos(a) * x])


def nodes_third(x, y, a):  # type: ignore[no-untyped-def]
    """Choices, as they are at the start."""
    inner = (x < y) & ~(y <= a * x)
    return row([
        select(x < y, x * y, y), select(y < x, x, y * y), absolute(x - 2) * y, select(inner, a * y, x),
        select(a > 0, x, y), select(x > 0, a, a * a), select(a < 0, a, x * 0 + 1), absolute(a) * x,
    ])  # fmt: skip


def nodes_without(x):  # type: ignore[no-untyped-def]
    """sin(sqrt(x))/sqrt(x)."""
    return row([stumpff1(x)])


@pytest.mark.parametrize("formula", [nodes_first, nodes_second, nodes_third])
@pytest.mark.parametrize("tag", ["wide" if WIDE else "base"])
def test_every_node(formula: Callable[..., Any], tag: str) -> None:
    ring = PrecisionRing()
    mp = ring.context
    made = kernel(formula, "number, number, number")
    a = mp.mpf(3) / 4

    def given(t: Any) -> list[Any]:
        return [mp.sin(t + mp.mpf(1) / 5) / (t / 3 + 1), mp.mpf(1) / 2 + mp.exp(-t) / 3]

    def wanted(t: Any) -> list[Any]:
        x, y = given(t)
        return made.reference(ring, [[x], [y], [a]])[0]

    columns = series_of(given, ring)
    found = Compiled([made], ("a",), tag)(ORDER, {"x": columns[:, :1], "y": columns[:, 1:], "a": [float(a)]})
    expected = series_of(wanted, ring)
    (values,) = found.values()
    assert np.abs(expected[1:]).max() > 0.1
    np.testing.assert_allclose(values, expected, rtol=0, atol=ROUNDING * max(1, np.abs(expected).max()))


def test_widths_agree_to_the_bit() -> None:
    made = kernel(mechanics.gyroscopic, "twist, numbers6")
    rng = np.random.default_rng(1)
    given = {"omega": rng.normal(size=(HIGHEST_ORDER + 1, 6)), "momentum": rng.normal(size=(HIGHEST_ORDER + 1, 6))}
    found = [Compiled([made], (), tag)(HIGHEST_ORDER, given) for tag in WIDTHS.values() if tag != "wide" or WIDE]
    for other in found[1:]:
        np.testing.assert_array_equal(other["gyroscopic"], found[0]["gyroscopic"])


def test_functions_without_recurrence_are_told() -> None:
    with pytest.raises(TraceError, match="stumpff.* no Taylor recurrence; take another integrator"):
        series_function("series", [kernel(nodes_without, "number")])


# -- the kernels of motion ------------------------------------------------------------------------------------

KERNELS = {
    "motor_rate": ("layout motor, twist", ()),
    "gyroscopic": ("twist, numbers6", ()),
    "pull": ("motor, position, position", ("center", "weight")),
    "carried": ("motor, twist", ("wrench",)),
    "drag": ("twist, position, number, number", ("center", "angular", "linear")),
    "spring": ("motor, twist, position, motor, twist, position, numbers3", ("own", "other", "numbers")),
    "rotor_rate": ("layout rotor, position", ()),
    "spin_rate": ("position, position, position", ("moments", "inverse")),
}


class Motion:
    """Analytic motions at any precision; motors are motors all the time."""

    def __init__(self, algebra: str, ring: PrecisionRing) -> None:
        self.ring, self.mp = ring, ring.context
        self._landed = kernel(flows.landed, "layout rotor, position, position, position", algebra)
        self._rng = np.random.default_rng(3)
        self._numbers: dict[str, Any] = {}
        self.motor = cache(self._motor)

    def numbers(self, name: str, size: int) -> list[Any]:
        if name not in self._numbers:
            self._numbers[name] = [self.mp.mpf(float(x)) for x in self._rng.uniform(0.5, 1.5, size)]
        return self._numbers[name]

    def moving(self, name: str, size: int, t: Any) -> list[Any]:
        rates = self.numbers(name, size)
        return [self.mp.sin(r * t + 3 * r) + (r - 1) * t for r in rates]

    def _motor(self, name: str, t: Any) -> list[Any]:
        parts = [self.moving(name + part, n, t) for part, n in (("q", 4), ("x", 3), ("v", 3), ("w", 3))]
        parts[0][0] += 3  # far from no rotor at all
        return self._landed.reference(self.ring, parts)[0]

    def argument(self, name: str, kind: Any, still: bool, t: Any) -> list[Any]:
        if kind.name.startswith("motor") or kind.blades == self._landed.outputs[0].kind.blades:
            return self.motor(name, t)
        return self.numbers(name, kind.size) if still else self.moving(name, kind.size, t)


@pytest.mark.parametrize("algebra", ALGEBRAS)
@pytest.mark.parametrize("name", KERNELS)
def test_coefficients_of_kernels(name: str, algebra: str) -> None:
    kinds, still = KERNELS[name]
    made = kernel(getattr(mechanics, name, None) or getattr(flows, name), kinds, algebra)
    order = ORDER if algebra == "cga3d" and name != "spring" else ORDER // 2  # PGA: the same text but for signs
    ring = PrecisionRing()
    motion = Motion(algebra, ring)
    places = [(i.name, i.kind, i.name in still) for i in made.inputs]

    def wanted(t: Any) -> list[Any]:
        results = made.reference(ring, [motion.argument(*place, t) for place in places])
        return [x for values in results for x in values]

    given = {}
    for place in places:
        columns = series_of(lambda t, place=place: motion.argument(*place, t), ring, order)
        given[place[0]] = columns[0] if place[2] else columns
    found = np.concatenate(list(Compiled([made], still)(order, given).values()), 1)
    expected = series_of(wanted, ring, order)
    scale = np.abs(expected).max(1, keepdims=True)
    assert (scale[:5] > 1e-3).all()
    np.testing.assert_array_less(np.abs(found - expected) / np.maximum(scale, 1), ROUNDING)


# -- trajectories ---------------------------------------------------------------------------------------------

TOLERANCES = [1e-6, 1e-9, 1e-12, 1e-14]
MP = mpmath.mp.clone()
MP.dps = 30


NO_GRAVITY = Gravity([0, 0, 0])  # one program serves all free bodies
SPIN, MOMENTS = (0.1, 2.0, 0.1), (1.0, 2.0, 3.0)


class FreeTop:
    """The free top by Jacobi's elliptic functions (Landau and Lifshitz, Mechanics, 37), for L^2 > 2 E I2."""

    def __init__(self) -> None:
        mp = MP
        self.moments = i1, i2, i3 = [mp.mpf(x) for x in MOMENTS]
        spin = [mp.mpf(x) for x in SPIN]
        energy = sum(i * w * w for i, w in zip(self.moments, spin, strict=True))
        square = sum((i * w) ** 2 for i, w in zip(self.moments, spin, strict=True))
        assert square > energy * i2
        above, below = energy * i3 - square, square - energy * i1
        self.amplitudes = (
            mp.sqrt(above / (i1 * (i3 - i1))),
            mp.sqrt(above / (i2 * (i3 - i2))),
            mp.sqrt(below / (i3 * (i3 - i1))),
        )
        self.rate = mp.sqrt((i3 - i2) * below / (i1 * i2 * i3))
        self.parameter = (i2 - i1) * above / ((i3 - i2) * below)
        self.begin = mp.ellipf(mp.asin(spin[1] / self.amplitudes[1]), self.parameter)
        self.length = mp.sqrt(square)

    @cache  # noqa: B019
    def spin(self, t: Any) -> list[Any]:
        """Along the body's axes."""
        u = self.begin + self.rate * t
        return [
            a * MP.ellipfun(f, u, m=self.parameter) for a, f in zip(self.amplitudes, ("cn", "sn", "dn"), strict=True)
        ]

    def turn(self, t: Any, precession: Any) -> Any:
        """Body to a frame whose third axis is along the angular momentum, by Euler's angles."""
        a, b, c = (i * w / self.length for i, w in zip(self.moments, self.spin(t), strict=True))
        tilt, roll = MP.acos(c), MP.atan2(a, b)

        def about_third(x: Any) -> Any:
            return MP.matrix([[MP.cos(x), -MP.sin(x), 0], [MP.sin(x), MP.cos(x), 0], [0, 0, 1]])

        lean = MP.matrix([[1, 0, 0], [0, MP.cos(tilt), -MP.sin(tilt)], [0, MP.sin(tilt), MP.cos(tilt)]])
        return about_third(precession) * lean * about_third(roll)

    def orientation(self, t: float) -> Any:
        """Body to world, the world's axes being the body's at the start: the precession is an integral."""

        def rate(time: Any) -> Any:
            w = self.spin(time)
            parts = [i * x * x for i, x in zip(self.moments, w, strict=True)]
            return self.length * (parts[0] + parts[1]) / (self.moments[0] * parts[0] + self.moments[1] * parts[1])

        precession = MP.quad(rate, MP.linspace(0, t, max(2, int(t) + 1)))
        turn = self.turn(MP.mpf(0), MP.mpf(0)).T * self.turn(MP.mpf(t), precession)
        return np.array(turn.tolist(), float)


@cache
def free_top() -> FreeTop:
    return FreeTop()


def free_body(algebra: str) -> RigidBody:
    return RigidBody(
        2.0, MOMENTS, position=[3, 1, -2], velocity=[1, 0.5, 0], angular_velocity=SPIN, algebra=BY_NAME[algebra]
    )


@pytest.mark.parametrize("rtol", TOLERANCES)
@pytest.mark.parametrize("algebra", ALGEBRAS)
def test_free_top(algebra: str, rtol: float) -> None:
    """At the ends of steps, and as exactly between them; gravity bends the flight alone."""
    times = np.linspace(0, 20, 41)
    found = Simulation(free_body(algebra), [Gravity([0, 0, -9.81])], integrator="taylor").run(
        20, times=times, rtol=rtol
    )
    expected = np.array([[float(x) for x in free_top().spin(MP.mpf(float(t)))] for t in times])
    error = np.abs(found.angular_velocity - expected).max()
    assert error <= 300 * rtol + 1e-13
    assert rtol < 1e-10 or error > 1e-14  # the tolerance is what decides
    assert found.steps < 100
    way = np.array([3, 1, -2]) + times[:, None] * [1, 0.5, 0] - 9.81 / 2 * times[:, None] ** 2 * [0, 0, 1]
    np.testing.assert_allclose(found.position, way, rtol=1e-14, atol=1e-12)
    np.testing.assert_allclose(found.velocity, np.gradient(way, times, axis=0, edge_order=2), rtol=0, atol=1e-9)


def test_orientation_of_the_free_top() -> None:
    times = [0.0, 2.3, 5.0]
    expected = np.array([free_top().orientation(t) for t in times])
    for algebra in ALGEBRAS:
        found = Simulation(free_body(algebra), [NO_GRAVITY], integrator="taylor").run(5, times=times, rtol=1e-13)
        np.testing.assert_allclose(found.orientation, expected, rtol=0, atol=1e-12)


HEAVY = {"mass": 1.0, "moments": (1.5, 2.0, 1.8), "center": (0.1, 0.1, 0.4), "gravity": 9.81, "spin": (1.0, 2.0, 0.5)}
HEAVY_TIME = 1.0


@cache
def heavy_top() -> Any:
    """Spin and quaternion (w, x, y, z) of the heavy top at its end, to 30 digits; moments are about the pin."""
    i1, i2, i3 = (MP.mpf(x) for x in HEAVY["moments"])
    c1, c2, c3 = (MP.mpf(x) for x in HEAVY["center"])
    weight = MP.mpf(HEAVY["mass"]) * MP.mpf(HEAVY["gravity"])

    def rates(t: Any, y: list[Any]) -> list[Any]:
        w1, w2, w3, a, b, c, d = y
        f1, f2, f3 = (-weight * x for x in (2 * (b * d - a * c), 2 * (c * d + a * b), a * a - b * b - c * c + d * d))
        return [
            (c2 * f3 - c3 * f2 + (i2 - i3) * w2 * w3) / i1,
            (c3 * f1 - c1 * f3 + (i3 - i1) * w3 * w1) / i2,
            (c1 * f2 - c2 * f1 + (i1 - i2) * w1 * w2) / i3,
            (-b * w1 - c * w2 - d * w3) / 2, (a * w1 + c * w3 - d * w2) / 2,
            (a * w2 + d * w1 - b * w3) / 2, (a * w3 + b * w2 - c * w1) / 2,
        ]  # fmt: skip

    start = [*(MP.mpf(x) for x in HEAVY["spin"]), MP.mpf(1), MP.mpf(0), MP.mpf(0), MP.mpf(0)]
    return np.array([float(x) for x in MP.odefun(rates, 0, start)(HEAVY_TIME)])


def heavy_body(algebra: str) -> tuple[RigidBody, Pin]:
    """The pin is the world's origin; moments about it become those about the centre."""
    c, mass, spin = np.array(HEAVY["center"]), HEAVY["mass"], np.array(HEAVY["spin"])
    inertia = np.diag(HEAVY["moments"]) - mass * (c @ c * np.eye(3) - np.outer(c, c))
    used = BY_NAME[algebra]
    body = RigidBody(mass, inertia, position=c, velocity=np.cross(spin, c), angular_velocity=spin, algebra=used)
    return body, Pin(used.point(-c))


@pytest.mark.parametrize("rtol", TOLERANCES)
@pytest.mark.parametrize("algebra", ALGEBRAS)
def test_heavy_top(algebra: str, rtol: float) -> None:
    body, pin = heavy_body(algebra)
    gravity = Gravity([0, 0, -HEAVY["gravity"]])
    found = Simulation(body, [gravity], [pin], integrator="taylor").run(HEAVY_TIME, times=[HEAVY_TIME], rtol=rtol)
    spin, (a, b, c, d) = heavy_top()[:3], heavy_top()[3:]
    turn = np.array([
        [a * a + b * b - c * c - d * d, 2 * (b * c - a * d), 2 * (b * d + a * c)],
        [2 * (b * c + a * d), a * a - b * b + c * c - d * d, 2 * (c * d - a * b)],
        [2 * (b * d - a * c), 2 * (c * d + a * b), a * a - b * b - c * c + d * d],
    ])  # fmt: skip
    assert np.abs(found.angular_velocity[-1] - spin).max() <= 100 * rtol + 2e-14
    assert np.abs(found.orientation[-1] - turn).max() <= 100 * rtol + 2e-14
    np.testing.assert_allclose(found.position[-1], turn @ HEAVY["center"], rtol=0, atol=100 * rtol + 2e-14)


def pendulum_angle(rate: Any, times: Any) -> Any:
    """Of a pendulum that is let go at the horizontal: sin(angle/2) = k sn(K - t rate), k^2 = 1/2."""
    quarter, half = MP.ellipk(0.5), MP.sqrt(0.5)
    sines = [half * MP.ellipfun("sn", quarter - rate * MP.mpf(float(t)), m=0.5) for t in times]
    return np.array([float(2 * MP.asin(x)) for x in sines])


def test_pendulum_from_rest_at_the_horizontal() -> None:
    """Of the angle's coefficients three in four vanish."""
    mass, length, gravity = 1.5, 0.8, 9.81
    body = RigidBody(mass, [0.1, 0.2, 0.3], position=[length, 0, 0])
    hinge = Pin(cga.line([-length, 0, 0], [0, 1, 0]))
    times = np.linspace(0, 3, 13)
    rate = MP.sqrt(MP.mpf(mass) * MP.mpf(length) * MP.mpf(gravity) / (MP.mpf(0.2) + MP.mpf(mass) * MP.mpf(length) ** 2))
    angle = pendulum_angle(rate, times)
    expected = length * np.array([np.sin(angle), 0 * angle, -np.cos(angle)]).T
    for rtol in (1e-7, 1e-10, 1e-13):
        found = Simulation(body, [Gravity([0, 0, -gravity])], [hinge], integrator="taylor").run(
            3, times=times, rtol=rtol
        )
        assert np.abs(found.position - expected).max() <= 100 * rtol
        assert found.steps < 200


# -- loads ----------------------------------------------------------------------------------------------------


def all_loads(algebra: str, **given: Any) -> list[Any]:
    """One of each load, two springs: those that are not given do nothing. One program serves them all."""
    used = BY_NAME[algebra]
    zero = np.zeros(3)
    wrench = call(used, "mechanics.screw_of", *(used.vector(x, "w") for x in given.get("wrench", (zero, zero)))).value
    return [
        Gravity(given.get("gravity", zero)), Damper(*given.get("drag", (0, 0))),
        BodyWrench(wrench), WorldWrench(wrench),
        *(Spring(*x) for x in given.get("springs", [(zero, zero, 0.0)] * 2)),
    ]  # fmt: skip


def test_loads_by_closed_forms() -> None:
    times = np.linspace(0, 2, 9)
    off, velocity, t = np.array([0.5, 2, 3]), np.array([0.5, 0, -1]), times[:, None]
    body = RigidBody(2.0, [1, 1, 1], position=[1, 2, 3], velocity=velocity)
    loads = all_loads("cga3d", springs=[([0, 0, 0], [0.5, 0, 0], 12.0), ([0, 0, 0], [0.5, 0, 0], 6.0)])
    found = Simulation(body, loads, integrator="taylor").run(2, times=times, rtol=1e-12)
    expected = [0.5, 0, 0] + off * np.cos(3 * t) + velocity * np.sin(3 * t) / 3
    np.testing.assert_allclose(found.position, expected, rtol=0, atol=1e-11)
    body = RigidBody(2.0, [1, 2, 3], velocity=velocity, angular_velocity=[0, 0, 4])
    found = Simulation(body, all_loads("cga3d", drag=(1.5, 3.0)), integrator="taylor").run(2, times=times, rtol=1e-12)
    np.testing.assert_allclose(found.velocity, velocity * np.exp(-1.5 * t), rtol=0, atol=1e-11)
    np.testing.assert_allclose(found.angular_velocity, [0, 0, 4] * np.exp(-0.5 * t), rtol=0, atol=1e-11)


@cache
def loaded(algebra: str, integrator: str) -> Any:
    """A batch, off its axes, with everything at once."""
    body = RigidBody(
        np.array([2.0, 3.0, 4.0]), [[2, 0.1, 0], [0.1, 2.5, 0.2], [0, 0.2, 3]], position=[1, 2, 3],
        velocity=[0.5, 0, -1], angular_velocity=[1, -2, 3], algebra=BY_NAME[algebra],
    )  # fmt: skip
    springs = [([0.1, 0.2, 0.3], [2, 2, 4], 30.0, 0.5, 0.4), ([-0.1, 0.2, 0.3], [0, 2, 4], 20.0)]
    wrench = ([1, 2, -1], [0.3, 0, 0.5])
    loads = all_loads(algebra, gravity=[0, 0, -9.81], wrench=wrench, drag=(0.1, 0.2), springs=springs)
    return Simulation(body, loads, integrator=integrator).run(1, times=np.linspace(0, 1, 8), rtol=1e-12)


@pytest.mark.parametrize("algebra", ALGEBRAS)
def test_all_loads_as_the_adaptive_integrator_has_them(algebra: str) -> None:
    found, other = loaded(algebra, "taylor"), loaded("cga3d", "adaptive")
    np.testing.assert_allclose(found.position, other.position, rtol=0, atol=1e-10)
    np.testing.assert_allclose(found.orientation, other.orientation, rtol=0, atol=1e-10)
    np.testing.assert_allclose(found.angular_velocity, other.angular_velocity, rtol=0, atol=1e-10)
    assert (found.steps < other.steps).all()


# -- constraints: reactions are series, too -------------------------------------------------------------------


def test_heavy_top_by_projection() -> None:
    """The same motion, held by reactions instead of by its subspace."""
    body, pin = heavy_body("cga3d")
    gravity = Gravity([0, 0, -HEAVY["gravity"]])
    held = Simulation(body, [gravity], [pin], integrator="taylor", stabilization="projection")
    for rtol in (1e-6, 1e-9, 1e-12):
        found = held.run(HEAVY_TIME, times=[0.5, HEAVY_TIME], rtol=rtol)
        assert np.abs(found.angular_velocity[-1] - heavy_top()[:3]).max() <= 100 * rtol
        assert found.violation.max() <= 1e-14
    other = Simulation(body, [gravity], [pin], integrator="taylor").run(HEAVY_TIME, times=[0.5, HEAVY_TIME], rtol=1e-12)
    np.testing.assert_allclose(found.position, other.position, rtol=0, atol=1e-11)
    np.testing.assert_allclose(found.reaction.values, other.reaction.values, rtol=0, atol=1e-10)


def test_point_on_a_sphere_swings_as_a_pendulum_does() -> None:
    """A row of a matrix on a point's coefficients; by elliptic functions."""
    length, gravity, times = 0.8, 9.81, np.linspace(0, 2, 9)
    body = RigidBody(1.5, [0.1, 0.2, 0.3], position=[length, 0, 0], angular_velocity=[0, 0, 2])
    sphere = Incidence(cga.point([0, 0, 0]), cga.sphere([0, 0, 0], length))
    found = Simulation(body, [Gravity([0, 0, -gravity])], [sphere], integrator="taylor").run(2, times=times, rtol=1e-11)
    angle = pendulum_angle(MP.sqrt(MP.mpf(gravity) / MP.mpf(length)), times)
    expected = length * np.array([np.sin(angle), 0 * angle, -np.cos(angle)]).T
    np.testing.assert_allclose(found.position, expected, rtol=0, atol=1e-9)
    np.testing.assert_allclose(found.angular_velocity, np.tile([0, 0, 2.0], (9, 1)), rtol=0, atol=1e-9)
    assert found.violation.max() < 1e-12


@cache
def double_pendulum(time: float) -> list[float]:
    """Angles of a planar double pendulum from the horizontal, by Lagrange's equations."""
    mp = mpmath.mp.clone()
    mp.dps = 18  # 30 would take seconds
    first, second, joint, weights = (
        mp.mpf("1.7"),
        mp.mpf("0.45"),
        mp.mpf("0.5"),
        (2 * mp.mpf("9.81"), mp.mpf("9.81") / 2),
    )

    def rates(t: Any, y: list[Any]) -> list[Any]:
        a, b, da, db = y
        c, s = joint * mp.cos(a - b), joint * mp.sin(a - b)
        one, two = -s * db * db - weights[0] * mp.sin(a), s * da * da - weights[1] * mp.sin(b)
        size = first * second - c * c
        return [da, db, (second * one - c * two) / size, (first * two - c * one) / size]

    return [float(x) for x in mp.odefun(rates, 0, [mp.pi / 2, mp.pi / 2, 0, 0])(time)[:2]]


def test_joint_between_bodies() -> None:
    """Masses 2 and 1, moments 0.2 about their centres at half of a length of 1; redundant rows in each hinge."""
    bodies = {
        "upper": RigidBody(2.0, [0.1, 0.2, 0.25], position=[0.5, 0, 0]),
        "lower": RigidBody(1.0, [0.1, 0.2, 0.25], position=[1.5, 0, 0]),
    }
    near, far = cga.line([-0.5, 0, 0], [0, 1, 0]), cga.line([0.5, 0, 0], [0, 1, 0])
    hinges = [Pin(near, body="upper"), Pin(far, near, body="upper", other="lower")]
    held = Simulation(System(bodies), [Gravity([0, 0, -9.81])], hinges, integrator="taylor")
    for rtol in (1e-7, 1e-12):
        found = held.run(0.4, times=[0.3, 0.4], rtol=rtol)
        a, b = double_pendulum(0.4)
        upper, lower = (found.bodies[name].position[-1] for name in ("upper", "lower"))
        assert np.abs(upper - 0.5 * np.array([np.sin(a), 0, -np.cos(a)])).max() <= 100 * rtol
        assert np.abs(lower - 2 * upper - 0.5 * np.array([np.sin(b), 0, -np.cos(b)])).max() <= 100 * rtol
        assert found.violation.max() <= 1e-13


def test_constraint_on_velocities() -> None:
    """A wrench without power on the motion, through the centre of mass at first: by the adaptive integrator."""
    body = RigidBody(1.5, [0.2, 0.3, 0.4], angular_velocity=[1, 2, -1], velocity=[0, 1, 0])
    wrench = call(cga, "mechanics.screw_of", cga.vector([1, 0, 0], "f"), cga.vector([0, 0, 0], "m")).value
    found, other = (
        Simulation(body, [Gravity([1, 2, -9.81])], [VirtualPower(wrench)], integrator=name).run(
            0.5, times=[0.2, 0.5], rtol=1e-12
        )
        for name in ("taylor", "adaptive")
    )
    np.testing.assert_allclose(found.position, other.position, rtol=0, atol=1e-11)
    np.testing.assert_allclose(found.angular_velocity, other.angular_velocity, rtol=0, atol=1e-10)
    np.testing.assert_allclose(found.reaction.values, other.reaction.values, rtol=0, atol=1e-9)
    assert found.steps < other.steps


# -- what it does at the edge ---------------------------------------------------------------------------------


def test_extreme_scales_of_time() -> None:
    """The units of the coefficients follow the motion, up to 1e9 turns a second and down to one in a thousand years."""
    for rate in (1e9, 1e-10):
        body = RigidBody(2.0, MOMENTS, angular_velocity=rate * np.array(SPIN))
        times = np.linspace(0, 20, 5) / rate
        found = Simulation(body, [NO_GRAVITY], integrator="taylor").run(20 / rate, times=times, rtol=1e-12)
        expected = np.array([[float(x) for x in free_top().spin(MP.mpf(float(t * rate)))] for t in times])
        np.testing.assert_allclose(found.angular_velocity / rate, expected, rtol=0, atol=1e-9)
    still = Simulation(RigidBody(2.0, MOMENTS), [NO_GRAVITY], integrator="taylor").run(5, times=[5.0])
    assert still.steps == 1
    np.testing.assert_array_equal(still.position[-1], [0, 0, 0])


def test_a_long_run_after_a_short_scale() -> None:
    """A body that hardly moves at first: the first units would be far too long for the spring."""
    body = RigidBody(1.0, [1, 1, 1], position=[1e-9, 0, 0])
    loads = all_loads("cga3d", springs=[([0, 0, 0], [0, 0, 0], 1e4), ([0, 0, 0], [0, 0, 0], 0.0)])
    found = Simulation(body, loads, integrator="taylor").run(1, times=[1.0], rtol=1e-12)
    np.testing.assert_allclose(found.position[-1], [1e-9 * np.cos(100), 0, 0], rtol=0, atol=1e-12)


def test_orders_and_what_has_no_series() -> None:
    assert [order_of(x) for x in (1e-3, 1e-9, 1e-12, 1e-16)] == [5, 12, 15, 20]
    body = RigidBody(2.0, MOMENTS, angular_velocity=SPIN)
    pushed = Simulation(body, [BodyWrench(lambda t: cga.line([0, 0, 0], [1, 0, 0]))], integrator="taylor")
    with pytest.raises(InputError, match="functions of users have none. Use integrator='adaptive'"):
        pushed.run(1)
    held = Simulation(body, [], [PinPath(cga.point([0, 0, 0]), lambda t: cga.point([t, 0, 0]))], integrator="taylor")
    with pytest.raises(InputError, match="Use integrator='adaptive'"):
        held.run(1)
