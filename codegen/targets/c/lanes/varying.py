"""What differs between items of which several are computed at once, and where their paths part.

A value differs if what it is computed from does, and if only some of the items assign it: by branches, and by loops
that some items leave before others.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import NamedTuple

from ....errors import AlgorithmError
from ....ir.loops.nodes import (
    Assign,
    Call,
    Constant,
    For,
    Function,
    KernelSignature,
    Load,
    Return,
    Statement,
    Store,
    View,
    While,
    expressions,
    outputs,
    parts,
)  # fmt: skip
from ....ir.loops.types import REAL
from ...loops import in_calling_order
from .paths import OUTSIDE, Path, Paths, argument_varies, element, is_wide_call, shared_results, varies


class Needs(NamedTuple):
    """Whether a function has to know which items are meant: always, or where others keep what is in these arrays."""

    always: bool
    kept: frozenset[str] = frozenset()

    def at(self, call: Call, own: Collection[str]) -> bool:
        """Whether it has to in a call by items that alone know some arrays."""
        assert isinstance(call.callee, Function)
        given = zip(call.callee.parameters, call.arguments, strict=True)
        apart = {p.name for p, a in given if isinstance(a, View) and a.array.name not in own}
        return self.always or bool(self.kept & apart)


ALWAYS = Needs(True)


class Lanes:
    """What differs between the items of an algorithm, in it and in those that it calls.

    Parameters
    ----------
    root : Function
    shared : collection of str
        Its parameters that all items share.
    still : mapping of str to collection of int, optional
        Elements that all items share of its other parameters, which nothing changes: whole fields of records.

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
        If an array that all items share is changed by only some, or differs in its length; if an element is changed.
    """

    def __init__(
        self, root: Function, shared: Collection[str], still: Mapping[str, Collection[int]] | None = None
    ) -> None:
        functions, _ = in_calling_order([root])
        self.root = root
        self.names: dict[Function, set[str]] = {f: set() for f in functions}
        self.functions = functions
        self.results = {f: [False] * len(f.results) for f in functions}
        self.names[root] = {p.name for p in root.parameters if p.name not in shared}
        for f, elements in _still_elements(root, functions, still or {}).items():
            self.names[f].update(element(*each) for each in elements)
        self.results[root] = [t == REAL for t in root.results]
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
                    parts_here = self.paths[function].has_divergent_return
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
            return bool(path) or paths.has_divergent_return
        return home != path

    # -- who is told which items are meant -----------------------------------------------------------------------------

    def _masked(self) -> set[Function]:
        needing: dict[Function, Needs] = {}
        for function in self.functions:  # callees first
            if function in self.wide:
                needing[function] = self._needs(function, needing)
        masked: set[Function] = set()
        for function in reversed(self.functions):
            if function not in self.wide:
                continue
            paths = self.paths[function]
            some = function in masked or paths.has_divergent_return
            for s, path, _ in paths.statements():
                if not (isinstance(s, Call) and isinstance(s.callee, Function) and (some or path)):
                    continue
                own = {name for name, home in paths.homes.items() if home == path}
                if is_wide_call(self.names[function], s) and needing[s.callee].at(s, own):
                    masked.add(s.callee)
        return masked

    def _needs(self, function: Function, needing: Mapping[Function, Needs]) -> Needs:
        names, paths = self.names[function], self.paths[function]
        changed: set[str] = set()
        for statement in function.walk():
            match statement:
                case For() | While() if id(statement) in paths.divergent:
                    return ALWAYS
                case Store(array, _, _):
                    changed.add(array.name)
                case Call(callee, _, _):
                    if isinstance(callee, Function) and is_wide_call(names, statement) and needing[callee].always:
                        return ALWAYS
                    changed.update(a.array.name for a in outputs(statement))
                    if any(isinstance(a, View) and varies(names, a.offset) for a in statement.arguments):
                        return ALWAYS
            found = (p for e in expressions(statement) for p in parts(e))
            if any(isinstance(p, Load) and varies(names, p.index) for p in found):
                return ALWAYS
            if isinstance(statement, Store) and varies(names, statement.index):
                return ALWAYS
        return Needs(False, frozenset(n for n in changed if paths.homes[n] == OUTSIDE))


#: Elements of arrays by name.
_Elements = set[tuple[str, int]]


def _still_elements(
    root: Function, functions: Sequence[Function], still: Mapping[str, Collection[int]]
) -> dict[Function, _Elements]:
    """Of every function the elements that all items share, of arrays that differ otherwise: as all calls have it."""
    found: dict[Function, _Elements] = {root: {(name, place) for name, places in still.items() for place in places}}
    for function in reversed(functions):  # callers first
        here = found.setdefault(function, set())
        for statement in function.walk():
            match statement:
                case Store(array, Constant(place), _) if (array.name, int(place)) in here:
                    raise AlgorithmError(f"{function.name} changes an element of {array.name} that items share")
            if not (isinstance(statement, Call) and isinstance(statement.callee, Function)):
                continue
            given: _Elements = set()
            for p, a in zip(statement.callee.parameters, statement.arguments, strict=True):
                if isinstance(a, View) and isinstance(a.offset, Constant):
                    begin = int(a.offset.value)
                    given |= {(p.name, place - begin) for name, place in here if name == a.array.name}
            known = found.get(statement.callee)
            found[statement.callee] = given if known is None else known & given
    return found
