"""Where the items of one function part: branches that some of several items take, and loops that some leave first."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence

from ....ir.loops.nodes import (
    Allocate,
    Assign,
    Binary,
    Break,
    Call,
    Constant,
    Continue,
    Expression,
    For,
    Function,
    If,
    Intrinsic,
    KernelSignature,
    Load,
    Return,
    Select,
    Statement,
    Store,
    Unary,
    Variable,
    View,
    While,
    blocks,
    expressions,
    names_in,
)  # fmt: skip
from ....ir.loops.types import ArrayType, Parameter

#: Ids of the statements around a place that only some of the items reach, outermost first.
Path = tuple[int, ...]
Loops = tuple[tuple[Statement, Path], ...]
#: Of arrays that the caller has, too.
OUTSIDE: Path = (-1,)


def element(array: str, place: int) -> str:
    """Among names of what differs: an element, of an array that differs, which all items share as they do its field."""
    return f"{array}[{place}]"


def varies(names: Collection[str], expression: Expression) -> bool:
    """Whether a number differs between items, where numbers and arrays of these names do."""
    match expression:
        case Variable(name, _):
            return name in names
        case Load(array, index):
            differs = array.name in names and element(array.name, _first(index)) not in names
            return differs or varies(names, index)
        case Unary(_, operand, _):
            return varies(names, operand)
        case Binary(_, left, right, _):
            return varies(names, left) or varies(names, right)
        case Select(condition, yes, no, _):
            return varies(names, condition) or varies(names, yes) or varies(names, no)
        case Intrinsic(name, arguments, _):
            return name != "any" and any(varies(names, a) for a in arguments)
        case _:
            return False


def _first(index: Expression) -> int:
    """Where the field begins that an element is of: what is known of its index."""
    match index:
        case Constant(value):
            return int(value)
        case Binary("+", left, right, _):
            return _first(left) + _first(right)
        case _:
            return 0


def argument_varies(names: Collection[str], argument: Expression | View) -> bool:
    """The same of an argument."""
    if not isinstance(argument, View):
        return varies(names, argument)
    return argument.array.name in names or varies(names, argument.offset)


def is_wide_call(names: Collection[str], call: Call) -> bool:
    """Whether a call has anything that differs between items: others compute what all of them share."""
    return any(argument_varies(names, a) for a in call.arguments)


def shared_results(names: Collection[str], call: Call) -> range:
    """Results of a kernel that items share: all; those beside tangents, where only directions differ; or none."""
    kernel = call.callee
    assert isinstance(kernel, KernelSignature)
    count = len(kernel.outputs)
    differ = [argument_varies(names, a) for a in call.arguments[count:]]
    origin = getattr(kernel.kernel, "origin", None)
    if any(differ[: len(differ) - len(origin[1])] if origin else differ):
        return range(0)
    return range(count // 2 if any(differ) else count)


class Paths:
    """Where the items of one function part, given what differs.

    Attributes
    ----------
    divergent : set of int
        Ids of branches and loops that some items take and others do not, or leave before others.
    homes : mapping of str to Path
        The innermost place that has all that is about a number or an array.
    has_divergent_return : bool
        Whether some items return before others.
    """

    def __init__(self, function: Function, names: Collection[str]) -> None:
        self.function, self.names = function, names
        self.divergent: set[int] = set()
        while True:
            before = len(self.divergent)
            self.homes: dict[str, Path] = {p.name: OUTSIDE if _is_result(p) else () for p in function.parameters}
            self.has_divergent_return = False
            for statement, path, loops in self.statements():
                self._follow(statement, path, loops)
            if before == len(self.divergent):
                break

    def statements(self) -> Iterator[tuple[Statement, Path, Loops]]:
        """All statements, the paths to them, and the loops around them with the paths into these."""
        yield from self._walk(self.function.body, (), ())

    def _walk(self, body: Sequence[Statement], path: Path, loops: Loops) -> Iterator[tuple[Statement, Path, Loops]]:
        for statement in body:
            yield statement, path, loops
            for k, block in enumerate(blocks(statement)):
                inside = self.path_into(statement, path, k)
                is_loop = isinstance(statement, (For, While))
                yield from self._walk(block, inside, (*loops, (statement, inside)) if is_loop else loops)

    def path_into(self, statement: Statement, path: Path, block: int = 0) -> Path:
        """The path to a block of a statement: the branches of one condition are two places."""
        return (*path, 2 * id(statement) + block) if id(statement) in self.divergent else path

    def _follow(self, statement: Statement, path: Path, loops: Loops) -> None:
        for name in _names_of(statement):
            home = self.homes.get(name, path)
            if home != OUTSIDE:
                common = (k for k, (a, b) in enumerate(zip(home, path, strict=False)) if a != b)
                self.homes[name] = home[: next(common, min(len(home), len(path)))]
        match statement:
            case If(condition, _, _) | While(condition, _) if varies(self.names, condition):
                self.divergent.add(id(statement))
            case For(_, start, stop, _, _) if varies(self.names, start) or varies(self.names, stop):
                self.divergent.add(id(statement))
            case Break() | Continue() if path != loops[-1][1]:
                self.divergent.add(id(loops[-1][0]))
            case Return() if path:
                self.divergent.update(id(loop) for loop, _ in loops)
                self.has_divergent_return = True


def _is_result(parameter: Parameter) -> bool:
    return isinstance(parameter.type, ArrayType) and parameter.access != "in"


def _names_of(statement: Statement) -> set[str]:
    """Numbers and arrays that a statement itself has to do with."""
    found = {name for e in expressions(statement) for name in names_in(e)}
    match statement:
        case Assign(target, _):
            found.add(target.name)
        case Allocate(array, _) | Store(array, _, _):
            found.add(array.name)
        case Call(_, arguments, results):
            found |= {a.array.name for a in arguments if isinstance(a, View)} | {r.name for r in results}
    return found
