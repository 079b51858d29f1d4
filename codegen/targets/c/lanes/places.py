"""Where in an algorithm on several items a statement stands, and which of the items get there."""

from __future__ import annotations

from dataclasses import dataclass

from ....ir.loops.nodes import Assign, Call, Expression, Function, Statement, Store, Variable
from .guards import Guards, Mask
from .paths import Path, outputs
from .varying import Lanes


@dataclass
class Region:
    """A place that only some items reach, and which."""

    path: Path
    mask: Mask
    loop: ParallelLoop | None = None


@dataclass
class ParallelLoop:
    """A loop that is left by some items before others: those in it."""

    inside: Variable | None
    depth: int
    is_parting: bool


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

    def expression(self, expression: Expression) -> Expression:
        return self.guards.text(expression, self.mask)


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
