"""Where in an algorithm on several items a statement stands, and which of the items get there."""

from __future__ import annotations

from dataclasses import dataclass

from ....ir.loops.nodes import Assign, Call, Expression, Function, Select, Statement, Store, Variable, outputs
from .guards import Guards, Mask
from .paths import Path
from .varying import Lanes


@dataclass
class Region:
    """A place that only some items reach, and which."""

    path: Path
    mask: Mask
    loop: ParallelLoop | None = None


@dataclass
class ParallelLoop:
    """A loop, and the items in it where some leave before others; None: all leave together."""

    inside: Variable | None
    depth: int


class Places:
    """What is known of the place that is looked at, and the statements so far.

    Parameters
    ----------
    function : Function
    lanes : Lanes
    """

    def __init__(self, function: Function, lanes: Lanes) -> None:
        self.original, self.lanes, self.paths = function, lanes, lanes.paths[function]
        self.names = lanes.names[function]
        self.guards = Guards(self.names, lambda statement: self.out.append(statement), self.paths.homes)
        self.out: list[Statement] = []
        self.regions: list[Region] = []
        self.loops: list[ParallelLoop] = []
        self.results: list[Variable] = []
        #: What is assigned where some of those that know it do not get: it has a value before.
        homes, found = self.paths.homes, self.paths.statements()
        self.partial = {name for s, path, _ in found for name in changed_names(s) if homes[name] != path}

    @property
    def mask(self) -> Mask:
        return self.regions[-1].mask

    @property
    def path(self) -> Path:
        return self.regions[-1].path

    def is_own(self, name: str) -> bool:
        """Whether only those items know a number or an array that are meant here."""
        return self.paths.homes.get(name, self.path) == self.path

    def blend(self, value: Expression, old: Expression) -> Expression:
        """A value for the items that are meant here; the others keep the old one."""
        return value if self.mask is None else Select(self.mask, value, old, value.type)

    def expression(self, expression: Expression) -> Expression:
        return self.guards.mask_expression(expression, self.mask)


def changed_names(statement: Statement) -> list[str]:
    """Numbers and arrays that a statement itself changes."""
    match statement:
        case Assign(target, _):
            return [target.name]
        case Store(array, _, _):
            return [array.name]
        case Call(_, _, results):
            return [r.name for r in results] + [a.array.name for a in outputs(statement)]
        case _:
            return []
