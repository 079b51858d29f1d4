"""Formulas of the dynamics driver with their tangents: value and rate along a direction of all that they depend on.

Each takes the arguments of the formula that it is named after, then a direction for each argument.
"""

from __future__ import annotations

from ...algebra.multivector import Multivector
from ...trace.derivatives import tangent_formula
from ..motions import maps
from . import mechanics, pins

gyroscopic = tangent_formula(mechanics.gyroscopic, __name__)
central_gyroscopic = tangent_formula(mechanics.central_gyroscopic, __name__)
pull = tangent_formula(mechanics.pull, __name__, constant=["center"])
wrench_to_body = tangent_formula(mechanics.wrench_to_body, __name__)
drag = tangent_formula(mechanics.drag, __name__, constant=["center"])
spring = tangent_formula(mechanics.spring, __name__)
relative = tangent_formula(mechanics.relative, __name__)
adjoint = tangent_formula(mechanics.adjoint, __name__)
bracket = tangent_formula(mechanics.bracket, __name__)
body_object = tangent_formula(pins.body_object, __name__)
moved_rates = tangent_formula(pins.moved_rates, __name__)
turned_rate = tangent_formula(pins.turned_rate, __name__)
path_rates = tangent_formula(pins.path_rates, __name__, constant=["v", "dv", "ddv"])

moved_exponential = tangent_formula(maps.moved_exponential, __name__, constant=["r"])
moved_bortz = tangent_formula(maps.moved_bortz, __name__, constant=["r"])
moved_cayley = tangent_formula(maps.moved_cayley, __name__, constant=["r"])
moved_outer = tangent_formula(maps.moved_outer, __name__, constant=["r"])
chart_rate_exponential = tangent_formula(maps.chart_rate_exponential, __name__)
chart_rate_bortz = tangent_formula(maps.chart_rate_bortz, __name__)
chart_rate_cayley = tangent_formula(maps.chart_rate_cayley, __name__)
chart_rate_outer = tangent_formula(maps.chart_rate_outer, __name__)


def twist_of(r: Multivector, rate: Multivector) -> Multivector:
    """-2 ~R dR, the twist in the body's frame that moves a motor so: dR = -R delta/2 read backwards."""
    return (-2 * (~r * rate)).grade(2)


def moved_off(r: Multivector, delta: Multivector) -> Multivector:
    """-R delta/2."""
    return mechanics.motor_rate(r, delta)
