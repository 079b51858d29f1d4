"""Simulations: what errors of steps are measured against, for all methods that choose their own steps.

Annotations are evaluated: sizes are those of the kind of simulation.
"""

from typing import Any, NamedTuple

from ....ir.loops.algorithm import Algorithm as algorithm
from ....ir.loops.algorithm import inlined
from ....ir.loops.language import InOut, Int, IntRows, IntVector, Real, Reals, Rows, Static, Vector, sqrt
from ..records import Body, Code, Constraint, Parts, kept_record, work_records
from .charts import ChartAlgorithms

OK = int(Code.OK)
#: Roundings of accelerations that come together in an estimate of a step's error.
BLURS = 16.0
#: Of the step that an error allows, the part that is taken; changes of the step, at least and at most.
SAFETY, LEAST_CHANGE, MOST_CHANGE = 0.9, 0.2, 10.0
#: Below it sums of squares are not used: those of less than its square lose digits.
LEAST_ROOT = 1e-140
#: A step that is so much shorter than what is left is not the last one.
ALMOST = 1.0 + 1e-9
#: Roundings of the time that a step takes, at least.
FEWEST_ROUNDINGS = 16.0


class AdaptiveAlgorithms(NamedTuple):
    """Steps that choose their own size.

    Attributes
    ----------
    first_step : algorithm
        Length of the first one.
    adaptive_step : algorithm
        One that is accepted; a status.
    find_state_between : algorithm
        The state at a time within the last step; a status.
    """

    first_step: algorithm
    adaptive_step: algorithm
    find_state_between: algorithm


class ErrorScales(NamedTuple):
    """What errors are measured against.

    Attributes
    ----------
    groups : tuple
        Coefficients of rotations and paths: those of the group, of the other one, whether they are rotations.
    size_of_group, scale_of_state, scale_of_tangent, rounding_of_rates : algorithm
        Of one group of a body.
    radius_of_gyration : algorithm
        Of a body.
    first_step : algorithm
        Length of a first step.
    """

    groups: tuple[tuple[tuple[int, ...], tuple[int, ...], bool], ...]
    size_of_group: algorithm
    scale_of_state: algorithm
    scale_of_tangent: algorithm
    rounding_of_rates: algorithm
    radius_of_gyration: algorithm
    first_step: algorithm


def error_scales(parts: Parts, charts: ChartAlgorithms, radius_of_gyration: Any) -> ErrorScales:
    """Scales of errors of a kind of simulation.

    Parameters
    ----------
    parts : Parts
    charts : ChartAlgorithms
    radius_of_gyration : algorithm
    """
    count, size, state, lanes = parts.bodies, parts.size, parts.state, parts.lanes
    groups = ((parts.angular, parts.linear, True), (parts.linear, parts.angular, False))
    work = work_records(parts)
    Kept: Any = kept_record(parts)
    Work: Any = work.whole
    Integers: Any = work.integers
    chart_rates, start_of_step = charts.chart_rates, charts.start_of_step

    @inlined
    def size_of_group(
        h: Real, start: Vector[state], end: Vector[state], slopes: Vector[state], at: Int, apart: Static, places: Static
    ) -> Real:
        """Size of one of the groups of a body, at most in a step: rotations, paths, angular and linear rates."""
        own = 0.0
        later = 0.0
        change = 0.0
        for j in places:
            i = at + apart * j
            own += start[i] * start[i]
            later += end[i] * end[i]
            change += h * h * slopes[i] * slopes[i]
        result = sqrt(max(own, max(later, change)))
        if result < LEAST_ROOT:  # squares of less are zero, or lose digits
            own = 0.0
            later = 0.0
            change = 0.0
            for j in places:
                i = at + apart * j
                own = max(own, abs(start[i]))
                later = max(later, abs(end[i]))
                change = max(change, h * abs(slopes[i]))
            result = max(own, max(later, change))
        return result

    @inlined
    def scale_of_state(
        h: Real, start: Vector[state], end: Vector[state], slopes: Vector[state], b: Int, rate: Int, group: Static,
        radius: Real,
    ) -> Real:  # fmt: skip
        """What the error of a group of the state is measured against.

        At least a rotation by one radian, a path of the body's own size, and the other rates likewise.
        """
        places, others, is_angular = group
        at = size * rate + 6 * b
        own = size_of_group(h, start, end, slopes, at, 1, places)
        if rate == 0:
            return max(own, 1.0 if is_angular else radius)
        across = size_of_group(h, start, end, slopes, at, 1, others)
        return max(own, (1.0 / radius if is_angular else radius) * across)

    @algorithm
    def scale_of_tangent(
        h: Real, start: Vector[state], end: Vector[state], slopes: Vector[state], at: Int, group: Static, radius: Real,
        of_state: Real,
    ) -> Real:  # fmt: skip
        """What the error of a group of a tangent is measured against: itself, down to a fraction of the state's scale.

        A parameter is taken as large as it is, and tangents that are nothing but rounding are no errors.
        """
        places, others, is_angular = group
        own = size_of_group(h, start, end, slopes, at, lanes, places)
        across = (1.0 / radius if is_angular else radius) * size_of_group(h, start, end, slopes, at, lanes, others)
        return max(max(own, across), 1e-2 * of_state)

    @inlined
    def rounding_of_rates(w: Work, body: Body, b: Int, places: Static) -> Real:
        """Rounding of the rates of a body's rates: no step is short enough to have less of it.

        A body that rests because its forces balance has nothing else.
        """
        most = 0.0
        for j in places:
            most = max(most, body.roots[j])
        return BLURS * w.blur[b] * most

    @algorithm
    def first_step(
        numbers: Reals, bodies: Rows[Body], springs: IntRows[2], user_loads: IntRows[3], constraints: Rows[Constraint],
        directions: Reals, w: InOut[Work], p: InOut[Integers], stop: IntVector[1], duration: Real,
        kept: Kept, stages: InOut[Rows[state]],
    ) -> Real:  # fmt: skip
        """A first step that is short: a hundredth of what the rates would take to change the state by its own size."""
        slopes = stages[0]
        start = stages[1]
        start_of_step(kept, start)
        status = chart_rates(
            numbers,
            bodies,
            springs,
            user_loads,
            constraints,
            directions,
            w,
            p,
            stop,
            kept.time,
            kept.motors,
            start,
            slopes,
        )
        if status != OK:
            return duration
        least = duration
        for b in range(count):
            radius = radius_of_gyration(bodies[b])
            for places, _, is_angular in groups:
                unit = radius
                if is_angular:
                    unit = 1.0
                for j in places:
                    moved = max(abs(slopes[6 * b + j]), sqrt(unit * abs(slopes[size + 6 * b + j]))) / unit
                    if moved > 0.0:
                        least = min(least, 0.01 / moved)
        return least

    return ErrorScales(
        groups, size_of_group, scale_of_state, scale_of_tangent, rounding_of_rates, radius_of_gyration, first_step,
    )  # fmt: skip
