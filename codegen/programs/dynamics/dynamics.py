"""The dynamics driver: for one algebra, the loads, constraints and integrators that a simulation has, and no others."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

from ...algebra.algebra import Algebra
from ...build.cpu_features import vector_options
from ...formulas.mechanics import mechanics, motion_tangents, pins
from ...formulas.motions import flows, maps
from ...formulas.registration import registration
from .. import KernelSpec, Program, program, stock_algebra
from .config import DynamicsConfig
from .records import C_TEXT
from .taylor import series_values

_USER = """
extern "Python" int bs_dynamics_user(void *handle, int32_t which, ptrdiff_t item, double t, const double *state,
                                     double *out);
"""


@dataclass(frozen=True)
class Layout:
    """Blades of pinned objects, as the driver's template sees them; degrees are the powers of a length in them."""

    name: str
    number: int
    size: int
    degrees: tuple[int, ...]


@cache
def dynamics_program(needs: DynamicsConfig) -> Program:
    """The program of simulations that have just this."""
    needs.check()
    algebra = stock_algebra(needs.algebra)
    null = next(v for v in ("ni", "0") if v in algebra.vectors)
    angular = [int(not b & (1 << algebra.vectors.index(null))) for b in mechanics.twist_blades(algebra)]
    layouts = [
        Layout(name, i, algebra.kind(name).size, tuple(_degree(algebra, b) for b in algebra.kind(name).blades))
        for i, name in enumerate(needs.layouts)
    ]
    motor = algebra.kind("motor").blades
    methods = ("chart", "adaptive") if needs.method == "adaptive" else (needs.method,)
    values = {
        "title": f"Dynamics of {needs.bodies} bodies in {needs.algebra}, {needs.mode}",
        "prefix": needs.algebra,
        "bodies": needs.bodies,
        "mode": needs.mode,
        "loads": needs.loads,
        "layouts": layouts,
        "rows": max(needs.rows, 1),
        "rank": max(1, min(needs.rows, 6 * needs.bodies)),
        "sizes": max([6, *(layout.size for layout in layouts)]),
        "twist_layout": next((x.number for x in layouts if x.name == "twist"), 0),
        "linear_place": angular.index(0),
        "angular": angular,
        "identity": [int(not b) for b in motor],
        "methods": methods,
        "callbacks": needs.callbacks,
        "elementary": True,
        "flight": needs.in_flight,
        "tangents": needs.tangents,
        "records": C_TEXT,
        **(series_values(needs) if needs.method == "taylor" else {}),
    }
    return program(
        _name(needs), _kernel_specs(needs), "dynamics.c.j2", "dynamics_types.h", values,
        declarations=_USER if needs.callbacks else "",
        options=_options(needs),
    )  # fmt: skip


def _options(needs: DynamicsConfig) -> tuple[str, ...]:
    """Options of the compiler: only a body in flight gains from -O3; series have text for wide vectors."""
    level = () if needs.in_flight else ("-O2",)
    return (*level, *(vector_options() if needs.method == "taylor" else ()))


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
    if "drag" in needs.loads:
        add(mechanics.drag, "twist, position, number, number")
    if "spring" in needs.loads:
        add(mechanics.spring, "motor, twist, position, motor, twist, position, numbers3")
    if needs.in_flight:
        add(flows.flight, "motor, twist")
        add(flows.state_after_flight, "layout rotor, position, position, position")
        add(flows.rotor_rate, "layout rotor, position")
        add(flows.spin_rate, "position, position, position")
        add(flows.renormalize, "layout rotor")
    elif needs.method == "rk4":
        add(mechanics.motor_rate, "layout motor, twist")
    if needs.method in ("chart", "adaptive"):
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
    return [*found, *(_tangents(needs) if needs.tangents else ())]


def _tangents(needs: DynamicsConfig) -> list[KernelSpec]:
    """The same with tangents: directions behind the arguments."""
    found: list[KernelSpec] = []

    def add(formula: str, kinds: str, named: str = "") -> None:
        made = getattr(motion_tangents, formula)
        found.append(KernelSpec(made, tuple(kinds.split(", ")), named or f"{formula}_tangent", needs.algebra))

    moves = "layout motor"
    central = "gyroscopic" if needs.mode == "subspace" else "central_gyroscopic"
    add(central, "twist, numbers6, twist, numbers6", "gyroscopic_tangent")
    add("wrench_to_body", f"motor, twist, {moves}, twist")
    add(f"moved_{needs.chart}", "motor, twist, twist", "moved_chart_tangent")
    add(f"chart_rate_{needs.chart}", "twist, twist, twist, twist", "chart_rate_tangent")
    add("twist_of", f"motor, {moves}", "twist_of")
    add("moved_off", "motor, twist", "moved_off")
    if "gravity" in needs.loads:
        add("pull", f"motor, position, position, {moves}, position")
    if "drag" in needs.loads:
        add("drag", "twist, position, number, number, twist, number, number")
    if "spring" in needs.loads:
        end, moved_end = "motor, twist, position", f"{moves}, twist, position"
        add("spring", f"{end}, {end}, numbers3, {moved_end}, {moved_end}, numbers3")
    if needs.mode == "constrained":
        add("relative", f"motor, motor, {moves}, {moves}")
        add("adjoint", f"motor, {moves}")
        add("bracket", "twist, twist, twist, twist")
        for name in needs.layouts:
            v = f"layout {name}"
            add("body_object", f"motor, {v}, {moves}, {v}", f"body_object_{name}_tangent")
            add("moved_rates", f"{v}, {v}", f"moved_rates_{name}_tangent")
            add("turned_rate", f"{v}, twist, {v}, twist", f"turned_rate_{name}_tangent")
            add("path_rates", f"motor, twist, {v}, {v}, {v}, {moves}, twist", f"path_rates_{name}_tangent")
    return found
