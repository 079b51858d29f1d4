"""Series of the driver's Taylor integrator: the kernels of a body's motion and of its springs as series."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from ...errors import TraceError
from ...formulas.mechanics import mechanics, pins
from ...formulas.motions import flows
from ...targets.c.taylor_functions import HIGHEST_ORDER, SeriesFunction, series_function
from .. import KernelSpec, stock_algebra, trace_spec
from .config import DynamicsConfig

#: What an argument of the kernels is in the driver; those that are not here are series.
_STILL = {
    "center": "body + BS_BODY_CENTER", "weight": "body + BS_BODY_WEIGHT", "wrench": "body + BS_BODY_WORLD",
    "angular": "body + BS_BODY_DRAG", "linear": "body + BS_BODY_DRAG + 1",
}  # fmt: skip
_MOVING = {"r": "motor", "omega": "omega", "momentum": "momentum"}


def series_values(needs: DynamicsConfig) -> dict[str, Any]:
    """Values of the driver's template."""
    algebra = stock_algebra(needs.algebra)
    null = next(v for v in ("ni", "0") if v in algebra.vectors)
    attached = 1 << algebra.vectors.index(null)
    made = [_tumbling(needs)] if needs.in_flight else [_motion(needs)]
    if "spring" in needs.loads:
        made.append(_spring(needs))
    held = [_held_rates(needs, name) for name in needs.layouts] if needs.mode == "constrained" else []
    if held and "twist" in needs.layouts:
        held.append(_series(needs, "powered", ("v",), (pins.held_power, "motor, twist")))
    joint = [_series(needs, "relation", (), (pins.relation, "motor, twist, motor, twist"))]
    joint = joint if held and needs.bodies > 1 else []
    return {
        "series": [*made, *held, *joint],
        "joint_work": joint[0].work if joint else 0,
        "constraint_work": max([1, *(f.work for f in held)]),
        "constraints": needs.constraints,
        "order": HIGHEST_ORDER,
        "arguments": {**_STILL, **_MOVING},
        "turning": [int(not blade & attached) for blade in algebra.kind("motor").blades],
        "springs": max(needs.springs, 1),
    }


def _series(
    needs: DynamicsConfig, name: str, still: tuple[str, ...], *formulas: tuple[Callable[..., Any], str]
) -> SeriesFunction:
    kernels = [trace_spec(KernelSpec(f, tuple(kinds.split(", ")), "", needs.algebra)) for f, kinds in formulas]
    if unknown := set(still) - set(_STILL) - {item.name for kernel in kernels for item in kernel.inputs}:
        raise TraceError(f"the series {name} has no argument {min(unknown)!r}.")
    return series_function(name, kernels, still)


def _tumbling(needs: DynamicsConfig) -> SeriesFunction:
    """The turning of a body by itself, free or about a point."""
    lever = flows.lever_rate, "layout rotor, position, position, position"
    return _series(
        needs, "motion", ("moments", "inverse", "center", "weight"),
        (flows.rotor_rate, "layout rotor, position"), (flows.spin_rate, "position, position, position"),
        *([lever] if needs.mode == "subspace" and "gravity" in needs.loads else ()),
    )  # fmt: skip


def _motion(needs: DynamicsConfig) -> SeriesFunction:
    """A motor's rate, and the wrenches on its body."""
    loads: dict[str, tuple[Callable[..., Any], str]] = {
        "gravity": (mechanics.pull, "motor, position, position"),
        "world_wrench": (mechanics.wrench_to_body, "motor, twist"),
        "drag": (mechanics.drag, "twist, position, number, number"),
    }
    gyroscopic = mechanics.gyroscopic if needs.mode == "subspace" else mechanics.central_gyroscopic
    return _series(
        needs, "motion", tuple(_STILL),
        (mechanics.motor_rate, "layout motor, twist"), (gyroscopic, "twist, numbers6"),
        *(load for name, load in loads.items() if name in needs.loads),
    )  # fmt: skip


def _held_rates(needs: DynamicsConfig, name: str) -> SeriesFunction:
    """Pinned objects in the body frame: their rates along each unit twist, and their accelerations."""
    return _series(needs, f"held_{name}", ("v",), (pins.held_rates, f"motor, twist, layout {name}"))


def _spring(needs: DynamicsConfig) -> SeriesFunction:
    """The wrenches of a spring on its two bodies; of one body the other end is in the world."""
    world = ("s", "psi") if needs.bodies == 1 else ()
    return _series(
        needs, "pulled", ("point", "other_point", "law", *world),
        (mechanics.spring, "motor, twist, position, motor, twist, position, numbers3"),
    )  # fmt: skip
