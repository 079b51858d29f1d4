"""The driver of one mechanism: its poses by Newton's method, and Jacobians by an elimination made for it.

It depends on what hangs on what, by joints of how many freedoms, and on what is asked for; lengths and places are
numbers that come later.
"""

from __future__ import annotations

from functools import cache

from ...formulas.mechanics import joints, mechanics, pins
from .. import KernelSpec, Program, program, stock_algebra
from .config import MechanismConfig
from .layout import assign_offsets, elimination, path_to_ground


@cache
def mechanism_program(needs: MechanismConfig) -> Program:
    """The program of mechanisms that have just this."""
    needs.check()
    algebra = stock_algebra(needs.algebra)
    places = assign_offsets(needs, {name: algebra.kind(name).size for name in algebra.kinds})
    motor = algebra.kind("motor").blades
    names = [*(link.layouts for link in needs.links), *(cut.layouts for cut in needs.cuts)]
    layouts = sorted({name for own in names for name in own})
    plan = elimination(needs, places)
    gone = {*places.driven, *(j for step in plan for j in range(step.first, step.first + step.free))}
    asked = [places.links[b].first + k for b in needs.coordinates for k in range(needs.links[b].free)]
    values = {
        "title": f"A mechanism of {len(needs.links)} bodies in {needs.algebra}",
        "layouts": layouts,
        "prefix": needs.algebra,
        "identity": [int(not b) for b in motor],
        "largest": max([6, *(algebra.kind(name).size for name in layouts)]),
        "p": places,
        "plan": plan,
        "columns": needs.columns,
        "outputs_rows": 6 * len(needs.outputs) + len(asked),
        "body_outputs": [(6 * i, path_to_ground(needs.links, body)) for i, body in enumerate(needs.outputs)],
        "joint_outputs": [(6 * len(needs.outputs) + i, column) for i, column in enumerate(asked)],
        "kept_columns": [j for j in range(places.columns) if j not in gone],
    }
    return program(
        f"mechanism_{needs.algebra}_{len(needs.links)}", _kernel_specs(needs, layouts), "mechanism.c.j2",
        "mechanism_types.h", values, options=("-O2",),
    )  # fmt: skip


def _kernel_specs(needs: MechanismConfig, layouts: list[str]) -> list[KernelSpec]:
    found: list[KernelSpec] = []

    def add(formula: object, kinds: str, named: str = "") -> None:
        found.append(KernelSpec(formula, tuple(kinds.split(", ")), named, needs.algebra))  # type: ignore[arg-type]

    for formula in (joints.compose, joints.relative):
        add(formula, "motor, motor")
    add(joints.move_by_twist, "twist, motor")
    add(joints.adjoint_matrix, "motor")
    add(mechanics.adjoint, "motor")
    if any(x.rows == 6 for x in needs.targets):
        add(joints.twist_between, "motor, motor")
    if any(x.rows == 3 for x in needs.targets):
        add(joints.point_rates, "position")
        add(mechanics.moved_point, "motor, position")
    for name in layouts:
        add(joints.transform_object, f"motor, layout {name}", f"placed_{name}")
    for name in sorted({name for cut in needs.cuts if cut.varying for name in cut.layouts}):
        add(pins.moved_rates, f"layout {name}", f"moved_rates_{name}")
    return found
