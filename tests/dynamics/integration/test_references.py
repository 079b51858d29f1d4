"""Trajectories against tops of 30 digits (`oracles.tops`) and pendulums by elliptic functions; orders."""

from __future__ import annotations

from fractions import Fraction

import mpmath
import numpy as np
import pytest

from bladesmith import dynamics
from bladesmith.dynamics.integration.integrators import INTEGRATORS, MAPS
from bladesmith.dynamics.integration.tableaus import FIXED_SCHEMES, scheme_table

from ...oracles import tops
from ...support.checkout import CHECKOUT
from ...support.dynamics.states import ALGEBRAS
from ...support.effort import FULL

EACH_ALGEBRA = pytest.mark.parametrize("algebra", ALGEBRAS.values(), ids=ALGEBRAS)


def simulation(top, algebra, **options):
    """Of a top that is free, or pinned at the world's origin."""
    arm, spin = np.array(top.arm), np.array(top.spin)
    body = dynamics.RigidBody(
        top.mass, top.moments, arm, velocity=np.cross(spin, arm), angular_velocity=spin, algebra=algebra
    )
    loads = [dynamics.Gravity(top.gravity)] if any(top.gravity) else []
    pins = [dynamics.Pin(algebra.point(-arm))] if any(top.arm) else []
    return dynamics.Simulation(body, loads, pins, **options)


def error(found, name):
    """Of the turn at the end, of the place of the centre of mass as a share of its arm, and of the spin as a share."""
    turn, spin = tops.stored(name)
    arm = np.array(tops.TOPS[name].arm)
    off = np.abs(found.orientation[-1] - turn).max()
    rate = np.linalg.norm(found.angular_velocity[-1] - spin) / np.linalg.norm(spin)
    place = np.abs(found.position[-1] - turn @ arm).max() / max(np.linalg.norm(arm), 1e-300)
    return max(off, rate, place if arm.any() else 0.0)


def run(name, algebra, step=None, rtol=None, **options):
    top = tops.TOPS[name]
    return simulation(top, algebra, **options).run(top.time, step=step, rtol=rtol, times=[0.0, top.time])


# -- the references --------------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("name", tops.TOPS if FULL else ["cuboid"])
def test_stored_numbers_are_what_the_series_give(name):
    with mpmath.workdps(40):
        numbers = [mpmath.mpf(x) for x in tops.STORED[name].split()]
        turn, spin = tops.turned(tops.TOPS[name], parts=2)
        for found, kept in zip([*turn[0], *turn[1], *turn[2], *spin], numbers, strict=True):
            assert abs(found - kept) <= mpmath.mpf(10) ** -23 * max(1, abs(kept))


def test_the_series_of_the_cuboid_are_jacobis_functions():
    """Spin along the axes a1 cn, a2 sn, a3 dn of rate t + phase (Landau and Lifshitz 37)."""
    top = tops.TOPS["cuboid"]
    with mpmath.workdps(40):
        i1, i2, i3 = (mpmath.mpf(x) for x in top.moments)
        w = [mpmath.mpf(x) for x in top.spin]
        energy = i1 * w[0] ** 2 + i2 * w[1] ** 2 + i3 * w[2] ** 2
        square = (i1 * w[0]) ** 2 + (i2 * w[1]) ** 2 + (i3 * w[2]) ** 2
        assert square > energy * i2
        a1 = mpmath.sqrt((energy * i3 - square) / (i1 * (i3 - i1)))
        a2 = mpmath.sqrt((energy * i3 - square) / (i2 * (i3 - i2)))
        a3 = mpmath.sqrt((square - energy * i1) / (i3 * (i3 - i1)))
        rate = mpmath.sqrt((i3 - i2) * (square - energy * i1) / (i1 * i2 * i3))
        m = (i2 - i1) * (energy * i3 - square) / ((i3 - i2) * (square - energy * i1))
        u = mpmath.ellipf(mpmath.acos(w[0] / a1), m) + rate * top.time  # all spins are positive: the second one rises
        found = [a * mpmath.ellipfun(name, u, m=m) for a, name in ((a1, "cn"), (a2, "sn"), (a3, "dn"))]
        kept = [mpmath.mpf(x) for x in tops.STORED["cuboid"].split()[9:]]
        assert max(abs(x - y) for x, y in zip(found, kept, strict=True)) < mpmath.mpf(10) ** -20


# -- default settings ------------------------------------------------------------------------------------------


@EACH_ALGEBRA
@pytest.mark.parametrize(
    ("name", "bar", "step"),
    [
        ("cuboid", 1e-8, None),
        ("heavy top", 1e-9, None),
        ("lopsided top", 1e-9, None),
        ("spherical pendulum", 1e-9, None),
        ("fast cone", 1e-6, 1e-3),
        ("needle", 1e-5, 0.05),
        ("needle on a pin", 1e-5, 0.05),
    ],
)
def test_defaults_reach_the_references(algebra, name, bar, step):
    found = run(name, algebra, step)
    assert error(found, name) <= bar


@pytest.mark.compiles
def test_a_lopsided_body_that_spins_fast_takes_steps_that_adapt_themselves():
    """Flows are composed well where they nearly commute; at ten radians a step those of a lopsided body do not."""
    assert error(run("fast body", ALGEBRAS["pga"], integrator="adaptive"), "fast body") <= 1e-6
    assert error(run("fast body", ALGEBRAS["pga"], 1e-4), "fast body") <= 1e-6


HINGES = [("line", "cga"), ("circle", "cga"), ("two points", "pga"), ("path", "pga")]
MORE_HINGES = [("line", "pga"), ("two points", "cga"), ("path", "cga"), ("plane and point", "pga")]


@pytest.mark.parametrize(("held", "algebra"), HINGES + MORE_HINGES * FULL)
def test_pendulums_about_an_axis(held, algebra):
    """Large swings about a slanted axis; the world far from the origin."""
    algebra = ALGEBRAS[algebra]
    axis, down = np.array([2.0, 2.0, 1.0]) / 3, np.array([2.0, -1.0, -2.0]) / 3
    side = np.cross(axis, down)
    moments, mass, length, g, angle, time = np.array([0.3, 0.4, 0.5]), 2.0, 0.7, 9.81, 2.5, 5.0
    start = np.cos(angle) * down + np.sin(angle) * side
    pin = np.array([10.0, -20.0, 30.0])
    inertia = axis @ (moments * axis) + mass * length**2
    body = dynamics.RigidBody(mass, moments, pin + length * start, algebra=algebra)
    hinge = -length * start
    pins = {
        "line": lambda: [dynamics.Pin(algebra.line(hinge, axis))],
        "two points": lambda: [dynamics.Pin(algebra.point(hinge + k * axis)) for k in (-0.4, 0.3)],
        "circle": lambda: [dynamics.Pin(algebra.circle(hinge, axis, 0.3))],
        "plane and point": lambda: [
            dynamics.Pin(algebra.plane(axis, axis @ hinge)),
            dynamics.Pin(algebra.point(hinge)),
        ],
        "path": lambda: [
            dynamics.PinPath(algebra.point(hinge + k * axis), algebra.point(pin + k * axis)) for k in (-0.4, 0.3)
        ],
    }[held]()
    found = dynamics.Simulation(body, [dynamics.Gravity(g * down)], pins).run(time, times=[0.0, time])
    theta, rate = tops.pendulum(mass * g * length / inertia, angle, time)
    place = np.cos(theta) * down + np.sin(theta) * side
    way = rate * length * (-np.sin(theta) * down + np.cos(theta) * side)
    assert np.linalg.norm(found.position[-1] - pin - length * place) / length <= 1e-9
    assert np.linalg.norm(found.velocity[-1] - way) <= 1e-9 * np.sqrt(mass * g * length * length**2 / inertia)


# -- orders ----------------------------------------------------------------------------------------------------

ORDERS = [
    ("rk4", "exponential", 4),
    *((name, chart, scheme.order) for name, scheme in FIXED_SCHEMES.items() for chart in MAPS),
    ("cf4", "exponential", 4), ("midpoint", "exponential", 2), ("strang", "exponential", 2),
    ("blanes-moan", "exponential", 4), ("yoshida6", "exponential", 6),
]  # fmt: skip


@pytest.mark.compiles
@pytest.mark.parametrize(("integrator", "chart", "order"), ORDERS)
def test_orders_of_convergence(integrator, chart, order):
    """A quarter of the step, an error 4^order times less: it may miss that by half an order."""
    algebra = ALGEBRAS["pga"]
    step = 0.008 if order < 5 else 0.02 if order < 6 else 0.05
    errors = [error(run("lopsided top", algebra, h, integrator=integrator, map=chart), "lopsided top")
              for h in (step, step / 4)]  # fmt: skip
    assert errors[1] < 1e-4
    assert abs(np.log(errors[0] / errors[1]) / np.log(4) - order) < 0.5, errors


def order_conditions(a, b, order):
    """Errors of the conditions of all rooted trees up to an order, of exact numbers (Butcher 2016, 301)."""
    stages = range(len(b))
    trees = {1: [()]}  # a tree is the tuple of the subtrees of its root

    def weight(tree):
        """Of each stage the sum of the tree above it, and the density of the tree."""
        sums, size, density = [Fraction(1) for _ in stages], 1, 1
        for branch in tree:
            inner, n, own = weight(branch)
            row = [sum((x * inner[j] for j, x in enumerate(a[i])), Fraction(0)) for i in stages]
            sums = [x * y for x, y in zip(sums, row, strict=True)]
            size, density = size + n, density * own
        return sums, size, density * size

    for n in range(2, order + 1):
        trees[n] = [t for t in {tuple(sorted(c)) for k in range(1, n) for c in combinations_of(trees, k, n - 1)}]
    for n in range(1, order + 1):
        for tree in trees[n]:
            sums, _, density = weight(tree)
            yield sum((x * y for x, y in zip(b, sums, strict=True)), Fraction(0)) - Fraction(1, density)


def combinations_of(trees, count, size):
    """Forests of so many trees and nodes."""
    if count == 0:
        return [()] if size == 0 else []
    return [
        (tree, *rest)
        for n in range(1, size - count + 2)
        for tree in trees.get(n, ())
        for rest in combinations_of(trees, count - 1, size - n)
    ]


@pytest.mark.parametrize("name", FIXED_SCHEMES)
def test_schemes_fulfil_the_conditions_of_their_order_exactly(name):
    a, b = FIXED_SCHEMES[name].fractions
    order = FIXED_SCHEMES[name].order
    errors = list(order_conditions(a, b, order))
    assert len(errors) == {4: 8, 5: 17, 6: 37}[order] and not any(errors)
    assert any(order_conditions(a, b, order + 1))


def test_documents_name_all_integrators():
    text = (CHECKOUT / "docs" / "motion" / "integrators.md").read_text(encoding="utf-8")
    assert scheme_table() in text
    assert not [name for name in INTEGRATORS if f"`{name}`" not in text]


@pytest.mark.compiles
@pytest.mark.parametrize("chart", ["exponential", "bortz", "cayley", "outer"])
def test_steps_that_adapt_themselves_keep_to_the_tolerance(chart):
    algebra, name = ALGEBRAS["pga"], "lopsided top"
    for rtol in (1e-6, 1e-9, 1e-12):
        found = run(name, algebra, rtol=rtol, integrator="adaptive", map=chart)
        assert error(found, name) < 300 * rtol + 1e-12


def test_dense_output_is_as_good_as_the_steps():
    algebra, top = ALGEBRAS["pga"], tops.TOPS["lopsided top"]
    times = np.linspace(0, top.time, 1001)
    made = simulation(top, algebra, integrator="adaptive")
    dense = made.run(top.time, times=times)
    exact = simulation(top, algebra, integrator="yoshida6").run(top.time, step=1e-3, times=times)
    assert dense.steps < 500
    assert np.abs(dense.orientation - exact.orientation).max() < 1e-9
    assert np.abs(dense.angular_velocity - exact.angular_velocity).max() < 1e-8
