"""What differs between items of which several are computed at once, and where their paths part.

A value differs if what it is computed from does, and if only some of the items assign it: by branches, and by loops
that some items leave before others.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence

from ....errors import AlgorithmError
from ....ir.loops.nodes import (
    Allocate,
    Assign,
    Binary,
    Break,
    Call,
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
    parts,
)  # fmt: skip
from ....ir.loops.types import ArrayType, Parameter
from ...loops import in_calling_order
from ..uses import names_in

#: Ids of the statements around a place that only some of the items reach, outermost first.
Path = tuple[int, ...]
Loops = tuple[tuple[Statement, Path], ...]
#: Of arrays that the caller has, too.
OUTSIDE: Path = (-1,)


def varies(names: Collection[str], expression: Expression) -> bool:
    """Whether a number differs between items, where numbers and arrays of these names do."""
    match expression:
        case Variable(name, _):
            return name in names
        case Load(array, index):
            return array.name in names or varies(names, index)
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
    parting : set of int
        Ids of branches and loops that some items take and others do not, or leave before others.
    homes : mapping of str to Path
        The innermost place that has all that is about a number or an array.
    has_parting_return : bool
        Whether some items return before others.
    """

    def __init__(self, function: Function, names: Collection[str]) -> None:
        self.function, self.names = function, names
        self.parting: set[int] = set()
        while True:
            before = len(self.parting)
            self.homes: dict[str, Path] = {p.name: OUTSIDE if _is_result(p) else () for p in function.parameters}
            self.has_parting_return = False
            for statement, path, loops in self.statements():
                self._follow(statement, path, loops)
            if before == len(self.parting):
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
        return (*path, 2 * id(statement) + block) if id(statement) in self.parting else path

    def _follow(self, statement: Statement, path: Path, loops: Loops) -> None:
        for name in _names_of(statement):
            home = self.homes.get(name, path)
            if home != OUTSIDE:
                common = (k for k, (a, b) in enumerate(zip(home, path, strict=False)) if a != b)
                self.homes[name] = home[: next(common, min(len(home), len(path)))]
        match statement:
            case If(condition, _, _) | While(condition, _) if varies(self.names, condition):
                self.parting.add(id(statement))
            case For(_, start, stop, _, _) if varies(self.names, start) or varies(self.names, stop):
                self.parting.add(id(statement))
            case Break() | Continue() if path != loops[-1][1]:
                self.parting.add(id(loops[-1][0]))
            case Return() if path:
                self.parting.update(id(loop) for loop, _ in loops)
                self.has_parting_return = True


class Lanes:
    """What differs between the items of an algorithm, in it and in those that it calls.

    Parameters
    ----------
    root : Function
    shared : collection of str
        Its parameters that all items share.

    Attributes
    ----------
    names : mapping of Function to set of str
        Numbers and arrays that differ.
    results : mapping of Function to list of bool
        Whether what it returns differs.
    paths : mapping of Function to Paths
    wide, shared : set of Function
        What is printed: functions of W items, and of what all of them share.
    masked : set of Function
        Functions of W items that are told which of these are meant.
    printed : mapping of Function to Function
        What is printed of W items; see `masks.masked_function`.

    Raises
    ------
    AlgorithmError
        If an array that all items share is changed by only some, or differs in its length.
    """

    def __init__(self, root: Function, shared: Collection[str]) -> None:
        functions, _ = in_calling_order([root])
        self.root = root
        self.names: dict[Function, set[str]] = {f: set() for f in functions}
        self.functions = functions
        self.results = {f: [False] * len(f.results) for f in functions}
        self.names[root] = {p.name for p in root.parameters if p.name not in shared}
        self.results[root] = [True] * len(root.results)
        self.printed: dict[Function, Function] = {}
        self.paths: dict[Function, Paths] = {}
        counts: dict[Function, int] = {}
        while True:
            before = [len(n) for n in self.names.values()], [list(r) for r in self.results.values()]
            for function in functions:
                if counts.get(function) != len(self.names[function]):
                    counts[function] = len(self.names[function])
                    self.paths[function] = Paths(function, self.names[function])
                for statement, path, _ in self.paths[function].statements():
                    self._follow(function, statement, path)
            if before == ([len(n) for n in self.names.values()], [list(r) for r in self.results.values()]):
                break
        self.wide: set[Function] = set()
        self.shared: set[Function] = set()
        self._collect(root, True)
        self.masked = self._masked()
        changed = sorted(self.names[root] & set(shared))
        if changed:
            raise AlgorithmError(
                f"{', '.join(changed)} of {root.name} is said to be shared, but differs between items",
                remedy="Compute its items one after the other, or give each its own.",
            )

    def _collect(self, function: Function, is_wide: bool) -> None:
        found = self.wide if is_wide else self.shared
        if function in found:
            return
        found.add(function)
        for statement in function.walk():
            if isinstance(statement, Call) and isinstance(statement.callee, Function):
                self._collect(statement.callee, is_wide and is_wide_call(self.names[function], statement))

    # -- what differs ------------------------------------------------------------------------------------------------

    def _follow(self, function: Function, statement: Statement, path: Path) -> None:
        names = self.names[function]
        match statement:
            case Assign(target, value):
                if varies(names, value) or self._is_partial(function, target.name, path):
                    names.add(target.name)
            case Store(array, index, value):
                if varies(names, value) or varies(names, index) or self._is_partial(function, array.name, path):
                    names.add(array.name)
            case For(variable, start, _, _, _) if varies(names, start):
                names.add(variable.name)
            case Return(values):
                for k, value in enumerate(values):
                    parts_here = self.paths[function].has_parting_return
                    self.results[function][k] |= parts_here or varies(names, value)
            case Call():
                self._follow_call(function, statement, path)

    def _follow_call(self, function: Function, call: Call, path: Path) -> None:
        names, callee, arguments = self.names[function], call.callee, call.arguments
        written = outputs(call)
        names.update(a.array.name for a in written if varies(names, a.offset))
        names.update(a.array.name for a in written if self._is_partial(function, a.array.name, path))
        names.update(r.name for r in call.results if self._is_partial(function, r.name, path))
        if isinstance(callee, KernelSignature):
            names.update(a.array.name for a in written[len(shared_results(names, call)) :])
        elif is_wide_call(names, call):
            for p, a in zip(callee.parameters, arguments, strict=True):
                if argument_varies(names, a):
                    self.names[callee].add(p.name)
                elif isinstance(a, View) and p.access != "in" and p.name in self.names[callee]:
                    names.add(a.array.name)
            names.update(r.name for r, v in zip(call.results, self.results[callee], strict=True) if v)

    def _is_partial(self, function: Function, name: str, path: Path) -> bool:
        """Whether some items of those that know a name get here and others do not."""
        paths = self.paths[function]
        home = paths.homes[name]
        if home == OUTSIDE:
            return bool(path) or paths.has_parting_return
        return home != path

    # -- who is told which items are meant -----------------------------------------------------------------------------

    def _masked(self) -> set[Function]:
        needing: set[Function] = set()
        for function in self.functions:  # callees first
            if function in self.wide and self._needs_mask(function, needing):
                needing.add(function)
        masked: set[Function] = set()
        for function in reversed(self.functions):
            if function not in self.wide:
                continue
            paths = self.paths[function]
            some = function in masked or paths.has_parting_return
            masked.update(
                s.callee for s, path, _ in paths.statements()
                if isinstance(s, Call) and s.callee in needing and (some or path) and is_wide_call(self.names[function], s)
            )  # fmt: skip
        return masked

    def _needs_mask(self, function: Function, needing: set[Function]) -> bool:
        names, paths = self.names[function], self.paths[function]
        for statement in function.walk():
            match statement:
                case For() | While() if id(statement) in paths.parting:
                    return True
                case Store(array, _, _) if paths.homes[array.name] == OUTSIDE:
                    return True
                case Call(callee, _, _):
                    if callee in needing and is_wide_call(names, statement):
                        return True
                    if any(paths.homes[a.array.name] == OUTSIDE for a in outputs(statement)):
                        return True
                    if any(isinstance(a, View) and varies(names, a.offset) for a in statement.arguments):
                        return True
            found = (p for e in expressions(statement) for p in parts(e))
            if any(isinstance(p, Load) and varies(names, p.index) for p in found):
                return True
            if isinstance(statement, Store) and varies(names, statement.index):
                return True
        return False


def outputs(call: Call) -> list[View]:
    """Arrays that a call writes to."""
    if isinstance(call.callee, KernelSignature):
        found = call.arguments[: len(call.callee.outputs)]
    else:
        found = tuple(a for p, a in zip(call.callee.parameters, call.arguments, strict=True) if p.access != "in")
    return [a for a in found if isinstance(a, View)]


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
