"""Series functions of simulations: kernels of a body's motion, of springs and of constraints, on rows of the state.

What a kernel takes from the state varies; what it takes from a record, or from the numbers of a simulation, does not.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from ...algorithms.dynamics.records import Body, Parts, Spring
from ...algorithms.dynamics.series import MotionSeries, series_shapes
from ...algorithms.series.functions import Argument, SeriesFunction, Term, series_function
from ...formulas.mechanics import mechanics, pins
from ...formulas.motions import flows
from .. import KernelSpec, stock_algebra, trace_spec
from .config import DynamicsConfig
from .loads import BODY_LOADS

#: Rows of the state: numbers of each.
_STATE = {"motor": 8, "twist": 6, "other_motor": 8, "other_twist": 6, "momentum": 6, "rotor": 4, "spin": 3}


def with_series(needs: DynamicsConfig, parts: Parts, of_items: bool = False) -> tuple[Parts, MotionSeries]:
    """Series functions of a kind of simulation, and its parts with what they keep; perhaps for several at once."""
    series = (_turning if needs.in_flight else _motion)(needs, of_items)
    return parts._replace(series=series_shapes(parts, series, needs.springs, needs.constraints)), series


def rotor_part(algebra_name: str) -> tuple[bool, ...]:
    """Whether a coefficient of a motor is of its rotor."""
    algebra = stock_algebra(algebra_name)
    null = 1 << next(algebra.vectors.index(v) for v in ("ni", "0") if v in algebra.vectors)
    return tuple(not blade & null for blade in algebra.kind("motor").blades)


class _Terms:
    """Kernels as terms of a series function of an algebra."""

    def __init__(self, algebra: str, of_items: bool, **still: int) -> None:
        self.algebra, self.of_items, self.still = algebra, of_items, still
        self.rows = {**_STATE, **still}
        self.terms: list[Term] = []

    def add(self, formula: Callable[..., Any], kinds: str, arguments: str, results: str) -> None:
        """A kernel; an argument is a row, or a field of the record of that name: ``body.center``, ``body.laws[1]``."""
        kernel = trace_spec(KernelSpec(formula, tuple(kinds.split(", ")), "", self.algebra))
        found = tuple(self._argument(each) for each in arguments.split(", "))
        self.terms.append(Term(kernel, found, tuple(results.split(", "))))

    def _argument(self, text: str) -> Argument:
        row, _, field = text.partition(".")
        name, _, index = field.partition("[")
        record = {"body": Body, "spring": Spring}.get(row)
        offset = record.extent(name)[0] if record is not None else 0
        return Argument(row, offset + int(index.removesuffix("]") or 0), row not in self.still)

    def function(self, name: str, rows: str) -> SeriesFunction:
        """All of them, on some rows."""
        return series_function(name, self.terms, {row: self.rows[row] for row in rows.split(", ")}, self.of_items)


def _turning(needs: DynamicsConfig, of_items: bool) -> MotionSeries:
    """The turning of a body by itself, free or about a point."""
    terms = _Terms(needs.algebra, of_items, inverse=3, body=Body.size)
    terms.add(flows.rotor_rate, "layout rotor, position", "rotor, spin", "rotor_rate")
    terms.add(flows.spin_rate, "position, position, position", "spin, body.moments, inverse", "spin_rate")
    if needs.mode == "subspace" and "gravity" in needs.loads:
        kinds = "layout rotor, position, position, position"
        terms.add(flows.lever_rate, kinds, "rotor, body.center, body.weight, inverse", "spin_rate")
    return MotionSeries(terms.function("motion_series", "rotor, spin, inverse, body"))


def _motion(needs: DynamicsConfig, of_items: bool) -> MotionSeries:
    """A motor's rate, the wrenches on its body, and what constraints add."""
    terms = _Terms(needs.algebra, of_items, body=Body.size)
    gyroscopic = mechanics.gyroscopic if needs.mode == "subspace" else mechanics.central_gyroscopic
    terms.add(mechanics.motor_rate, "layout motor, twist", "motor, twist", "motor_rate")
    terms.add(gyroscopic, "twist, numbers6", "twist, momentum", "row")
    for name, load in BODY_LOADS.items():
        if name in needs.loads:
            arguments = (each if each in _STATE else f"body.{each}" for each in load.arguments)
            terms.add(load.formula, load.kinds, ", ".join(arguments), "row")
    series = MotionSeries(terms.function("motion_series", "motor, twist, momentum, body"))
    if "spring" in needs.loads:
        series = series._replace(spring=_spring(needs, of_items))
    return _with_constraints(needs, series, of_items) if needs.mode == "constrained" else series


def _spring(needs: DynamicsConfig, of_items: bool) -> SeriesFunction:
    """Wrenches on both ends; of one body the other end is in the world."""
    world = {"other_motor": 8, "other_twist": 6} if needs.bodies == 1 else {}
    terms = _Terms(needs.algebra, of_items, spring=Spring.size, **world)
    kinds = "motor, twist, position, motor, twist, position, numbers3"
    ends = "motor, twist, spring.point, other_motor, other_twist, spring.anchor, spring.stiffness"
    terms.add(mechanics.spring, kinds, ends, "wrench, other_wrench")
    return terms.function("spring_series", "motor, twist, other_motor, other_twist, spring")


def _with_constraints(needs: DynamicsConfig, series: MotionSeries, of_items: bool) -> MotionSeries:
    layouts = []
    for number, name in enumerate(needs.layouts):
        size = stock_algebra(needs.algebra).kind(name).size
        terms = _Terms(needs.algebra, of_items, v=size)
        terms.add(pins.held_rates, f"motor, twist, layout {name}", "motor, twist, v", "rates, bent")
        layouts.append((number, size, terms.function(f"held_series_{name}", "motor, twist, v")))
    series = series._replace(layouts=tuple(layouts))
    if "twist" in needs.layouts:
        terms = _Terms(needs.algebra, of_items, v=6)
        terms.add(pins.held_power, "motor, twist", "motor, v", "power")
        series = series._replace(power=terms.function("power_series", "motor, v"))
    if needs.bodies > 1:
        terms = _Terms(needs.algebra, of_items)
        rows = "motor, twist, other_motor, other_twist"
        terms.add(pins.relation, "motor, twist, motor, twist", rows, "seen, relative, bend, change")
        series = series._replace(relation=terms.function("relation_series", rows))
    return series
