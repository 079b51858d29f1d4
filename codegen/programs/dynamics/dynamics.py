"""The dynamics driver: for one algebra, the loads, constraints and integrators that a simulation has, and no others."""

from __future__ import annotations

import hashlib
import json
from collections import namedtuple
from collections.abc import Callable
from functools import cache
from typing import TYPE_CHECKING, Any, NamedTuple

from ...algebra.algebra import Algebra
from ...algorithms.dynamics.records import Layout, Parts, kept_record, work_records
from ...build import text_cache
from ...build.cpu_features import vector_options
from ...formulas.mechanics import mechanics, pins
from ...formulas.motions import flows, maps
from ...formulas.registration import registration
from ...targets.loops import in_calling_order
from .. import KernelSpec, Program, program, stock_algebra
from ..algorithms import c_item, loop_declarations, numba_text
from ..stock import ENTRIES, entries
from .config import DynamicsConfig
from .loads import BODY_LOADS, LAW_PLACES
from .taylor import rotor_part, with_series

if TYPE_CHECKING:
    from ...algorithms.dynamics.series import MotionSeries
    from ...algorithms.dynamics.simulations import SimulationAlgorithms
    from ...ir.loops.algorithm import Algorithm
    from ...ir.loops.nodes import Function

_USER = """
extern "Python" int bs_dynamics_user(void *handle, int32_t which, ptrdiff_t item, double t, const double *state,
                                     double *out);
"""
#: Of names of loops: one simulation of a batch each.
PART = "items"
#: File of a program: of its records the number of numbers, and where the fields begin.
RECORDS = "records.json"
#: What the printed algorithms depend on, from the package's folder.
_SOURCES = ("programs/dynamics/dynamics.py",)


@cache
def dynamics_program(needs: DynamicsConfig) -> Program:
    """The program of simulations that have just this, in C: loops over simulations by the names of its entries."""
    needs.check()
    texts = json.loads(_made_once("c", needs, lambda: json.dumps(_c_texts(needs))))
    values = {
        "title": f"Dynamics of {needs.bodies} bodies in {needs.algebra}, {needs.mode}",
        "callbacks": needs.callbacks,
        **{name: texts[name] for name in ("lanes", "call_of_lanes", "algorithms", "series", "others", "items")},
    }
    specs = {spec.name: spec for spec in _kernel_specs(needs)}
    along = [specs[name].along(tuple(varying)) for name, varying in texts["along"]]
    return program(
        _name(needs), [*specs.values(), *along], "dynamics.c.j2", "", values, options=_options(needs),
        declarations=texts["declarations"] + (_USER if needs.callbacks else ""),
        headers={ENTRIES: texts["entries"], RECORDS: texts["records"]},
    )  # fmt: skip


def numba_program(needs: DynamicsConfig) -> tuple[str, str, str, str]:
    """The same as Python text for numba: a name, the text, and its entries and records as JSON."""
    needs.check()
    text, entries, records = json.loads(_made_once("numba", needs, lambda: json.dumps(_numba_texts(needs))))
    return _name(needs), text, entries, records


def simulation_parts(needs: DynamicsConfig) -> Parts:
    """What decides about the algorithms of a simulation."""
    algebra = stock_algebra(needs.algebra)
    null = next(v for v in ("ni", "0") if v in algebra.vectors)
    is_angular = [not b & (1 << algebra.vectors.index(null)) for b in mechanics.twist_blades(algebra)]
    layouts = tuple(
        Layout(i, name, algebra.kind(name).size, tuple(_degree(algebra, b) for b in algebra.kind(name).blades))
        for i, name in enumerate(needs.layouts)
    )
    return Parts(
        bodies=needs.bodies,
        rows=max(needs.rows, 1),
        mode=needs.mode,
        loads=needs.loads,
        layouts=layouts,
        twist_layout=next((x.number for x in layouts if x.name == "twist"), 0),
        angular=tuple(j for j, turns in enumerate(is_angular) if turns),
        linear=tuple(j for j, turns in enumerate(is_angular) if not turns),
        identity=tuple(float(not b) for b in algebra.kind("motor").blades),
        methods=(needs.method,),
        calls=needs.callbacks,
        tangents=needs.tangents,
        functions=needs.functions,
        laws=tuple(place for name, place in LAW_PLACES.items() if name in needs.loads),
        lanes=needs.lanes,
        in_flight=needs.in_flight,
    )


def _made_once(target: str, needs: DynamicsConfig, make: Callable[[], str]) -> str:
    sources = (*_SOURCES, f"specs/{needs.algebra}.toml")
    name = f"{target}_{hashlib.sha256(repr(needs).encode()).hexdigest()}.json"
    return text_cache.made_once("dynamics", sources, name, make)


def _c_texts(needs: DynamicsConfig) -> dict[str, Any]:
    from ...targets.c.lanes.items import LANES_TAG, c_call_of_lanes
    from ...targets.c.lanes.printer import lanes_text
    from ...targets.c.lanes.varying import Lanes
    from ...targets.c.loops import c_functions

    functions, before, series, wide = _functions(needs)
    roots = [*before, *series, *functions.values()]
    lanes, call_of_lanes = "", ""
    if wide is not None:
        call, root = wide
        roots.append(root)
        found = Lanes(root, [p.name for p in root.parameters if not p.name.startswith("d_")])
        lanes = lanes_text(found)
        call_of_lanes = c_call_of_lanes(call, found, LANES_TAG, ("d_numbers", "d_bodies", "d_w"))
    own = {spec.name for spec in _kernel_specs(needs)}
    return {
        "lanes": lanes,
        "call_of_lanes": call_of_lanes,
        "algorithms": c_functions(before),
        "series": c_functions(series, printed=before),
        "others": c_functions(functions.values(), printed=[*before, *series]),
        "along": [x.kernel.origin for x in in_calling_order(roots)[1] if x.kernel.name not in own],
        "items": {f"bs_{name}_{PART}": c_item(function) for name, function in functions.items()},
        "declarations": loop_declarations(f"bs_{name}_{PART}_f64" for name in functions),
        "entries": entries({PART: functions}),
        "records": _records(needs),
    }


def _records(needs: DynamicsConfig) -> str:
    parts, _ = parts_with_series(needs)
    work = work_records(parts)
    records = {"work": work.whole, "integers": work.integers, "kept": kept_record(parts)}
    return json.dumps({name: (record.size, record.offsets) for name, record in records.items()})


def _numba_texts(needs: DynamicsConfig) -> tuple[str, str, str]:
    functions = _functions(needs)[0]
    text = numba_text(_name(needs), {f"{name}_{PART}": f for name, f in functions.items()})
    return text, entries({PART: functions}), _records(needs)


@cache
def parts_with_series(needs: DynamicsConfig, of_items: bool = False) -> tuple[Parts, MotionSeries | None]:
    """What decides about the algorithms, and the series functions of the motion; or for several items at once."""
    parts = simulation_parts(needs)
    return with_series(needs, parts, of_items) if needs.method == "taylor" else (parts, None)


class Found(NamedTuple):
    """Algorithms of a simulation.

    Attributes
    ----------
    entries : SimulationAlgorithms
        Those that callers call.
    before, series : list of Algorithm
        Those that series call; those of series, of which C has text for wide vectors.
    lanes : tuple of Function, or None
        What C calls for several directions at once, and what that is for one.
    """

    entries: SimulationAlgorithms
    before: list[Algorithm]
    series: list[Algorithm]
    lanes: tuple[Function, Function] | None


def simulation_algorithms_of(needs: DynamicsConfig, of_items: bool = False) -> Found:
    """The algorithms of a simulation; or those for several simulations at once."""
    from ...algorithms.dynamics.acceleration import rate_algorithms
    from ...algorithms.dynamics.advance import MethodAlgorithms, advance_algorithm
    from ...algorithms.dynamics.projection import projection_algorithms
    from ...algorithms.dynamics.simulations import simulation_algorithms
    from ...algorithms.dynamics.steps.adaptive_steps import adaptive_algorithms
    from ...algorithms.dynamics.steps.charts import chart_algorithms
    from ...algorithms.dynamics.steps.error_scales import error_scales
    from ...algorithms.dynamics.steps.fixed_steps import METHODS, fixed_step_algorithm
    from ...algorithms.dynamics.steps.flows import flight_algorithm, flow_algorithms
    from ...algorithms.dynamics.steps.implicit_steps import implicit_algorithms
    from ...algorithms.dynamics.tangents import tangent_algorithms
    from ...algorithms.dynamics.taylor import taylor_algorithms

    (parts, series), specs = parts_with_series(needs, of_items), _kernel_specs(needs)
    names: Any = namedtuple("Kernels", [spec.name for spec in specs])  # type: ignore[misc]
    kernels = names(*specs)
    rates = rate_algorithms(parts, kernels)
    projections = projection_algorithms(parts, kernels, rates)
    own: dict[str, Any] = {}
    wide: list[Any] = []
    lanes = None
    if series is not None:
        gyration = projections.radius_of_gyration
        taylor = taylor_algorithms(parts, kernels, rates, series, gyration, rotor_part(needs.algebra))
        own = taylor._asdict()
        wide = [each for each in (own.pop("find_coefficients"), own.pop("coefficients_along")) if each is not None]
    elif needs.in_flight:
        own = {"flight_steps": flight_algorithm(parts, kernels)}
    elif needs.method == "composition":
        own = flow_algorithms(parts, kernels, rates)._asdict()
    elif needs.method in METHODS:
        own = {"fixed_step": fixed_step_algorithm(parts, kernels, rates)}
    else:
        charts = chart_algorithms(parts, kernels, rates)
        if charts.rates_of_lanes is not None:
            lanes = charts.rates_of_lanes.instance(), charts.rates_along.function
        if needs.method == "chart":
            own = {"chart_step": charts.chart_step}
        else:
            scales = error_scales(parts, charts, projections.radius_of_gyration)
            make = implicit_algorithms if needs.method == "implicit" else adaptive_algorithms
            own = make(parts, kernels, charts, scales)._asdict()
    if needs.tangents:
        own |= tangent_algorithms(parts, kernels, projections, own)._asdict()
    method = MethodAlgorithms(**own)
    advance = advance_algorithm(parts, method, projections.bring_back, projections.radius_of_gyration)
    found = simulation_algorithms(parts, rates, projections, method, advance)
    return Found(found, [rates.accelerate], wide, lanes)


def _functions(needs: DynamicsConfig) -> tuple[dict[str, Function], list[Function], list[Function], Any]:
    found = simulation_algorithms_of(needs)
    functions = {name: each.instance() for name, each in found.entries._asdict().items() if each is not None}
    before, series = ([each.instance() for each in some] for some in (found.before, found.series))
    return functions, before, series, found.lanes


def _options(needs: DynamicsConfig) -> tuple[str, ...]:
    """Options of the compiler: only a body in flight gains from -O3; series have text for wide vectors."""
    level = () if needs.in_flight else ("-O2",)
    return (*level, *(vector_options() if needs.method == "taylor" or needs.lanes > 1 else ()))


def _degree(algebra: Algebra, blade: int) -> int:
    """How many powers of a length the coefficient of a blade has, one of them for the origin's: 0, 1 or 2."""
    powers = {"no": -1, "ni": 1, "0": 1}
    return 1 + sum(powers.get(name, 0) for i, name in enumerate(algebra.vectors) if blade >> i & 1)


def _name(needs: DynamicsConfig) -> str:
    return f"dynamics_{needs.algebra}_{needs.bodies}_{needs.mode}_{needs.method}"


def _kernel_specs(needs: DynamicsConfig) -> list[KernelSpec]:
    found: list[KernelSpec] = []

    def add(formula: object, kinds: str, named: str = "") -> None:
        found.append(KernelSpec(formula, tuple(kinds.split(", ")), named, needs.algebra))  # type: ignore[arg-type]

    central = needs.mode != "subspace"  # frames of pins are elsewhere
    add(mechanics.central_gyroscopic if central else mechanics.gyroscopic, "twist, numbers6", "gyroscopic")
    add(registration.near_motor, "layout motor", "near_motor")
    add(mechanics.world_wrench, "motor, numbers6")
    add(mechanics.covector_of, "twist")
    add(mechanics.wrench_to_body, "motor, twist")
    add(mechanics.move_by_twist, "motor, twist")
    if "gravity" in needs.loads:
        add(mechanics.pull, "motor, position, position")
    for name in needs.loads:
        if name in LAW_PLACES:
            add(BODY_LOADS[name].formula, BODY_LOADS[name].kinds)
    if "spring" in needs.loads:
        add(mechanics.spring, "motor, twist, position, motor, twist, position, numbers3")
        if needs.method == "taylor":
            add(mechanics.spring_gap, "motor, position, motor, position")
    if "coupling" in needs.loads:
        add(mechanics.relative_twist, "motor, twist, motor, twist")
        add(mechanics.counter_wrench, "motor, motor, numbers6")
    if needs.in_flight:
        add(flows.flight, "motor, twist")
        add(flows.state_after_flight, "layout rotor, position, position, position")
        add(flows.rotor_rate, "layout rotor, position")
        add(flows.spin_rate, "position, position, position")
        add(flows.renormalize, "layout rotor")
    if needs.tangents or (needs.method == "rk4" and not needs.in_flight):
        add(mechanics.motor_rate, "layout motor, twist")
    if needs.method in ("chart", "adaptive", "implicit"):
        add(getattr(maps, f"moved_{needs.chart}"), "motor, twist", "moved_chart")
        add(getattr(maps, f"chart_rate_{needs.chart}"), "twist, twist", "chart_rate")
    if needs.method == "composition":
        add(flows.parts_of_momentum, "motor, numbers6")
        add(flows.momentum_row, "motor, position, position")
        add(flows.translate, "motor, position")
        add(flows.central_flow, "motor, position, number")
        add(flows.axial_flow, "motor, position, unit, number")
    if needs.layouts:
        add(mechanics.relative, "motor, motor")
        add(mechanics.adjoint, "motor")
        add(mechanics.bracket, "twist, twist")
        add(mechanics.distance_of, "motor")
    for name in needs.layouts:
        v = f"layout {name}"
        add(pins.body_object, f"motor, {v}", f"body_object_{name}")
        add(pins.moved_rates, v, f"moved_rates_{name}")
        add(pins.turned_rate, f"{v}, twist", f"turned_rate_{name}")
        add(pins.path_rates, f"motor, twist, {v}, {v}, {v}", f"path_rates_{name}")
    if needs.tangents:
        add(mechanics.twist_of, "motor, layout motor")
    return found
