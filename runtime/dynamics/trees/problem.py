"""Systems that are trees, as problems in the coordinates of their joints; and why others are not."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

from ...core.multivector import Multivector
from ...mechanics.system import System
from ..assembly.assemble import assemble
from ..assembly.data import Assembly
from ..integration import integrators
from ..integration.integrators import Method
from ..integration.time_grid import Settings
from ..model import loads as load_types
from ..model.joint_loads import JointLoad
from .decay import fastest_decay_of_tree, is_stiff
from .driver import TreeDriver
from .parameters import TreeParameters, tree_parameters
from .spanning_tree import SpanningTree, spanning_tree

#: Integrators of motions in coordinates of joints.
INTEGRATORS = (
    "auto", "adaptive", "implicit", "rk4",
    *(name for name, kind in integrators.INTEGRATORS.items() if kind == "chart"),
)  # fmt: skip


@dataclass(frozen=True, eq=False)
class TreeProblem:
    """A tree with its loads, at its start; ``decay``: by which loads slow it down, per second, at most."""

    tree: SpanningTree
    assembly: Assembly
    parameters: TreeParameters
    integrator: str
    target: str
    decay: float

    @property
    def is_implicit(self) -> bool:
        """Whether implicit steps are asked for."""
        return self.integrator == "implicit"

    def with_fixed_steps(self) -> TreeProblem:
        """The same with "rk4" in place of an integrator that chooses its steps."""
        return replace(self, integrator="rk4") if self.integrator in ("auto", "adaptive") else self

    def part(self, begin: int, end: int) -> TreeProblem:
        """Some simulations of the batch."""
        return replace(self, parameters=self.parameters.part(begin, end))

    def driver(self, settings: Settings) -> TreeDriver:
        """The compiled motion, with the settings of a run."""
        duration, step, rtol, atol = settings
        name = self.integrator
        if name == "auto":
            name = "implicit" if is_stiff(self.decay, self.tree.count, duration) else "adaptive"
        size = duration if name in ("adaptive", "implicit") else step
        method = Method(name, size, integrators.RTOL if rtol is None else rtol, 0.0 if atol is None else atol)
        return TreeDriver(self.tree, self.assembly, self.parameters, method, self.target)


def tree_problem(system: Any, loads: Sequence[Any], integrator: str, target: str) -> TreeProblem | str:
    """The problem of a system; or the reason why it is none in coordinates of joints."""
    if not isinstance(system, System) or not system.joints:
        return "there are no joints"
    if integrator not in INTEGRATORS:
        return f"integrator {integrator!r} moves bodies, not joints"
    for load in loads:
        match load:
            case load_types.Gravity() | load_types.Spring() | JointLoad():
                continue
            case load_types.BodyLaw() if load.other is None:
                continue
            case load_types.BodyWrench() | load_types.WorldWrench() if isinstance(load.wrench, Multivector):
                continue
        return f"a {load.label} is a function, or a load of bodies alone"
    tree = spanning_tree(system)
    if isinstance(tree, str):
        return tree
    bodies = tuple(system.bodies.values())
    assembly = assemble(bodies, tuple(system.bodies), loads, (), 1.0, False)
    parameters = tree_parameters(system, tree, assembly, tuple(loads))
    if isinstance(parameters, str):
        return parameters
    decay = fastest_decay_of_tree(tree, assembly, parameters) if integrator == "auto" else 0.0
    return TreeProblem(tree, assembly, parameters, integrator, target, decay)
