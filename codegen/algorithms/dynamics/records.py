"""Simulations: what their algorithms take, and what a simulation's kind decides about them.

A state is a motor and a twist (in the body's frame) for each body, one after the other. Rows of six are linear
functions of twists: of a wrench its powers on unit twists.
"""

from __future__ import annotations

from enum import IntEnum
from functools import cache
from math import prod
from typing import Any, NamedTuple

from ...ir.loops.language import Int, IntVector, Matrix, Real, Vector
from ...ir.loops.records import Record, record
from ...ir.loops.types import INT
from ..series.recurrences import ROWS
from ..weighted_rows import WeightedRows, weighted_rows

#: Numbers of a body in all laws of loads, at most.
LAW_NUMBERS = 8
#: A rigid body: diagonal of its mass matrix, the inverses and their roots; weight and where it acts, in the body, which
#: no parameter moves there; constant wrenches of the world and of the body; numbers of laws of loads; the mass matrix
#: and the inverse of what pins allow of it; numbers of the flows of a free rotation; principal moments.
Body: Any = record(
    "Body", metric=Vector[6], inverse=Vector[6], roots=Vector[6], weight=Vector[3], center=Vector[3], world=Vector[6],
    wrench=Vector[6], laws=Vector[LAW_NUMBERS], mass=Matrix[6, 6], compliance=Matrix[6, 6], flows=Vector[9],
    moments=Vector[3],
).with_still("center")  # fmt: skip
#: A spring: its ends, stiffness, length at rest, and damping.
Spring: Any = record("Spring", point=Vector[3], anchor=Vector[3], stiffness=Real, length=Real, damping=Real)
#: A body whose motion another one brakes: its center, and numbers of laws of loads.
Coupling: Any = record("Coupling", center=Vector[3], laws=Vector[LAW_NUMBERS])
#: The fields of the two ends of a spring.
SPRING_ENDS = ("point", "anchor")
#: A constraint A[~S V S] = H, where S is the motor of a body, or that of it as another body sees it: the layout of V
#: (-1: V is a wrench without power on the relative twist), bodies (other: -1 for the world), equations, the function of
#: time that gives V, dV, ddV, H, dH, ddH and the unknown (-1 for none), and offsets in a simulation's numbers: of V, H,
#: A (rows by coefficients of V; -1: one), and of the length by which errors may be off (-1: none).
Constraint: Any = record(
    "Constraint", layout=Int, body=Int, other=Int, rows=Int, user=Int, v=Int, h=Int, a=Int, unknown=Int
)  # fmt: skip
#: What callers ask of a run: to give up, if the first is not 0; states before the last, within a budget of steps of
#: each simulation; whether starts are brought to the constraints.
Control: Any = record("Control", stop=IntVector[1], last=Int, budget=Int, projects=Int)
#: What a simulation has come to: its number, whether it has begun, its status, the steps that were taken, the states
#: that are stored; the rows that its start is off most, of poses and of rates.
Progress: Any = record(
    "Progress", number=Int, has_begun=Int, status=Int, steps=Int, stored=Int, start_rows=IntVector[2]
)  # fmt: skip
#: The time of the last state; how far the start is off the constraints, poses as fractions of the bodies' sizes and
#: distances or in radians, rates as fractions of the bodies' own; how far the last state stays off them, and which row;
#: the least independent fraction of a constraint at ends of steps, and when.
Reached: Any = record("Reached", reached=Real, start=Vector[2], off=Vector[2], singular=Vector[2])

#: What implicit steps keep: for what step the systems are factored; whether derivatives are there: 2 of the step
#: at hand, 1 of an earlier one; how fast iterations converge, now and in the last step; for how many steps derivatives
#: are renewed within them; error and length of the last step; the last change of an iteration, and how many were worse
#: than the one before.
Iteration: Any = record(
    "Iteration", factored_step=Real, has_jacobian=Real, rate=Real, rate_now=Real, turns=Real, last_error=Real,
    last_step=Real, last_change=Real, worse=Real,
)  # fmt: skip

#: Integers of the work that all simulations of a program's call share, and none changes; see `WorkRecords`. Those of
#: the rows are there where there are constraints.
CONSTANTS_OF_ROWS = ("bodies", "powers")
CONSTANTS = (
    "project", "handle", "stride", "spring_offset", "springs", "couplings", "constraints", "loads", "stages",
    "all_stages", "dense_rows", "method_order",
)  # fmt: skip
#: Stages of an implicit method, at most.
MOST_STAGES = 7
#: Fraction of a constraint, by energy, that must be independent of the others; below it, it is redundant.
FINE = 1e-7
#: Bodies beyond which arrays for all of them are in the work: on the stack compilers keep small ones in registers.
LARGE = 32


class Code(IntEnum):
    """Status of a simulation as its algorithms have it."""

    OK = 0
    NOT_FINITE = 1
    UNDERFLOW = 2
    RANK_CHANGED = 3
    USER_FAILED = 4
    STOPPED = 5
    EVENT = 6
    NOT_SOLVED = 7
    VIOLATED = 8
    PAUSED = 9
    STALLED = 10
    MEETING = 11


class Layout(NamedTuple):
    """Blades of pinned objects.

    Attributes
    ----------
    number : int
    name : str
    size : int
    degrees : tuple of int
        Powers of a length that coefficients have, counted from those of the origin.
    """

    number: int
    name: str
    size: int
    degrees: tuple[int, ...]


class LawPlace(NamedTuple):
    """Where the numbers of a law of loads begin and end in a body's, and whether it takes the motor and the twist."""

    name: str
    first: int
    last: int
    has_motor: bool
    has_twist: bool


class Parts(NamedTuple):
    """What a kind of simulation has.

    Attributes
    ----------
    bodies, rows : int
        Bodies, and equations of all constraints.
    mode : {"free", "subspace", "constrained"}
    loads : tuple of str
    layouts : tuple of Layout
    twist_layout : int
        The number of that of twists.
    angular, linear : tuple of int
        Coefficients of twists that are rotations, and velocities.
    identity : tuple of float
        The motor 1.
    methods : tuple of str
    calls : bool
        Whether functions of users are called.
    tangents, functions : int
        Directions of parameters along which the trajectory is differentiated; of programs that have such, functions of
        users, which are called once for all directions.
    in_flight : bool
        Whether one body turns by itself, so that series are those of its rotor and its spin.
    series : tuple of (str, shape)
        What Taylor series keep from order to order.
    laws : tuple of LawPlace
        Laws of loads.
    lanes : int
        Directions whose rates in a chart are computed at once; of those, the numbers of one place are side by side.
    """

    bodies: int
    rows: int
    mode: str
    loads: tuple[str, ...]
    layouts: tuple[Layout, ...]
    twist_layout: int
    angular: tuple[int, ...]
    linear: tuple[int, ...]
    identity: tuple[float, ...]
    methods: tuple[str, ...]
    calls: bool
    tangents: int = 0
    functions: int = 0
    in_flight: bool = False
    series: tuple[tuple[str, tuple[int, ...]], ...] = ()
    laws: tuple[LawPlace, ...] = ()
    lanes: int = 1

    @property
    def columns(self) -> int:
        """Tangents in a state of a chart: as many as fill all lanes."""
        return -(-self.tangents // self.lanes) * self.lanes

    @property
    def size(self) -> int:
        """Numbers of all twists."""
        return 6 * self.bodies

    @property
    def largest(self) -> int:
        """Coefficients of the largest pinned object."""
        return max([6, *(layout.size for layout in self.layouts)])

    @property
    def is_large(self) -> bool:
        """Whether what grows with the bodies would fill a thread's stack."""
        return self.bodies > LARGE

    @property
    def state(self) -> int:
        """Numbers of a state of a chart, motions and twists, with those of its tangents."""
        return 2 * self.size * (1 + self.columns)

    @property
    def has_large_state(self) -> bool:
        """Whether states of charts would fill a thread's stack."""
        return self.state > 12 * LARGE

    @property
    def series_state(self) -> int:
        """Numbers of a state of which there are series."""
        return 8 if self.in_flight else 14 * self.bodies

    @property
    def blurs(self) -> bool:
        """Whether rounding of accelerations is estimated."""
        return "adaptive" in self.methods or self.is_implicit

    @property
    def is_implicit(self) -> bool:
        """Whether steps are implicit, which need the derivatives of accelerations by the state."""
        return "implicit" in self.methods


class WorkRecords(NamedTuple):
    """What a thread has for one simulation at a time: real numbers, and integers.

    Those of its system of rows come first. Then the numbers

    - ``weights``: roots of the inverse metric of all bodies; ``wanted``: of the rows; ``step``; ``values``: of calls.
    - ``tolerance``: a row of which less than this fraction is independent is redundant; ``baumgarte``: rate at which
      errors of constraints are made to decay; ``pace``: rates below count as none.
    - ``longest_step``, ``rtol``, ``atol``: of steps that adapt themselves; errors are relative, and in radians.
    - ``off``: how far the last state stays off the constraints behind a projection; ``independent``: the least fraction
      of a constraint, by energy, that is independent of the others there.
    - ``blur``: rounding of each body's accelerations, by energy.
    - Those of series of the motion (series.py), which begin a whole number of vectors behind the begin.

    in ``whole`` behind these ``along``, the tangents of all of them, and ``along_lanes``, those of several directions,
    which begin where a vector may; and the integers

    - ``known_rank``: of the constraints at the start, 0: not known yet; ``off_row``: of ``off``.
    - ``blurred``: whether blur is asked for; ``project``: whether states are brought back to the constraints.
    - ``held``: the directions at hand are those of the rows, which are filled once more for their tangents alone.
    - ``left``: of the budget of steps; ``item``: of a batch; ``handle``: what functions of users are called with.
    - ``stride``: a simulation's numbers; ``spring_offset``: among them; ``springs``, ``couplings``, ``constraints``,
      ``loads``: how many; couplings follow the springs.
    - ``stages``, ``all_stages``, ``dense_rows``: of a Runge-Kutta scheme, of these with its interpolant, and terms of
      that beyond the cubic one; ``method_order``: the step goes by this root of its error.
    """

    numbers: Record
    integers: Record
    rows: WeightedRows | None
    whole: Record


@cache
def work_records(parts: Parts) -> WorkRecords:
    """The work of a kind of simulation."""
    rows = weighted_rows(parts.rows, parts.size) if parts.layouts else None
    shapes: dict[str, tuple[int, ...]] = {"tolerance": (), "baumgarte": (), "pace": (), "off": (), "independent": ()}
    shapes |= {"longest_step": (), "rtol": (), "atol": ()}
    places = ("known_rank", "off_row", "blurred", "held", "left", "item", *CONSTANTS)
    integers: dict[str, tuple[int, ...]] = dict.fromkeys(places, ())
    if parts.blurs:
        shapes["blur"] = (parts.bodies,)
    if parts.is_large:
        shapes["scratch"] = (72 * parts.bodies,)
    if parts.has_large_state:
        shapes |= {"chart_motors": (8 * parts.bodies,), "chart_rows": (parts.size,)}
        shapes |= dict.fromkeys(("chart_x", "chart_start", "chart_end"), (parts.state,))
    if rows is not None or parts.functions:
        shapes["values"] = (max(1, parts.functions), 3 * parts.largest + 3 * parts.rows + 1)
    if rows is not None:
        own = {"weights": parts.size, "wanted": parts.rows, "step": parts.size}
        shapes = {**rows.numbers.shapes, **{name: (n,) for name, n in own.items()}, **shapes}
        integers = {**rows.integers.shapes, **integers}
    if parts.series:
        shapes["alignment"] = _up_to_vectors(sum(map(prod, shapes.values())))
        shapes |= dict(parts.series)
    numbers = Record("Work", shapes)
    has_tangents = parts.tangents > 0 or parts.is_implicit
    whole = Record("WholeWork", {**shapes, "along": (numbers.size,)}) if has_tangents else numbers
    if parts.lanes > 1:
        shapes = {**whole.shapes, "alignment_of_lanes": _up_to_vectors(whole.size)}
        whole = Record("WholeWork", {**shapes, "along_lanes": (parts.lanes * numbers.size,)})
    return WorkRecords(numbers, Record("WorkIntegers", integers, INT), rows, whole)


def _up_to_vectors(size: int) -> tuple[int, ...]:
    """Shape of what fills up the last vector of numbers."""
    return (4 - size % 4,)


@cache
def state_record(bodies: int) -> Record:
    """A state that is stored: motors, twists, reactions as wrenches of the world, and violations of the constraints."""
    return Record(
        "State", {"motors": (8 * bodies,), "twists": (6 * bodies,), "reactions": (6 * bodies,), "violations": ()}
    )


@cache
def kept_record(parts: Parts) -> Record:
    """What a simulation keeps between calls, beside the stages of its scheme; at first the start.

    - ``time``; ``next_step``: its length; ``dense_time``, ``dense_step``: begin and length of the last one;
      ``has_dense``: whether there is its interpolant; ``least_time``: times below are none, where rounding is measured.
    - ``rank_at_start``: of the constraints; ``tolerance``: see `WorkRecords`; ``singular``: see `Reached`; ``off``: how
      far the last state stays off them, and which row; ``ends``: the status that the last step ended with, while states
      within it may do.
    - ``watched``: steps that were looked at for progress: their number, the time before, the longest path.
    - ``motors``, ``twists``: of all bodies; ``old_motors``: at the begin of the last step; ``momenta``: of a
      composition of flows.
    - ``tangents``: of motors, as twists in their frames, and of twists; ``seen_tangents``: those of the last state that
      was asked for.
    - ``stiffness``, ``damping``, ``turning``, ``moving``: of the stages of implicit steps, see stage_systems.py;
      ``factors``, ``pivots``, ``divisors``: of their systems; ``iteration``: see collocated.py.
    - ``coefficients``: of all orders from the state at the begin of the last step, of time in units of ``dense_step``;
      ``now``: the state at its end; ``flight``: position and velocity of a body in flight, at its end and at its begin;
      ``coefficients_along``: tangents of the coefficients, one direction after the other.
    """
    n, tangents = parts.bodies, 2 * parts.size * parts.tangents
    numbers = ("time", "next_step", "dense_time", "dense_step", "has_dense", "rank_at_start", "tolerance", "least_time")
    shapes: dict[str, tuple[int, ...]] = dict.fromkeys(numbers, ())
    shapes |= {"off": (2,), "singular": (2,), "ends": (), "watched": (3,), "motors": (8 * n,), "twists": (6 * n,)}
    shapes |= {"old_motors": (8 * n,), "momenta": (6,)}
    if tangents:
        shapes |= {"tangents": (tangents,), "seen_tangents": (tangents,)}
    if parts.is_implicit:
        rows = MOST_STAGES * parts.size
        shapes |= dict.fromkeys(("stiffness", "damping", "factors"), (rows, parts.size))
        shapes |= dict.fromkeys(("turning", "moving"), (rows, 6)) | dict.fromkeys(("pivots", "divisors"), (rows,))
    if "taylor" in parts.methods:
        state = parts.series_state
        shapes |= {"coefficients": (ROWS, state), "now": (state,), "flight": (12,)}
        if tangents:
            shapes["coefficients_along"] = (parts.tangents * ROWS, state)
    return Record("Kept", shapes, records={"iteration": Iteration} if parts.is_implicit else {})
