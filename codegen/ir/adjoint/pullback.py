"""Reverse derivatives of algorithms, on the loop IR: a forward sweep, which is the algorithm, then a reverse sweep.

The adjoint method on one text (`flat`) of bounded memory: what the reverse sweep needs of values that are replaced is
kept on a tape whose size is known when the function is made. Branches are as taken, kernels have the pullbacks of their
formulas, and derivatives that algorithms are declared with are transposed.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace

from ...errors import AlgorithmError
from ..loops.algorithm import MOST_LOCAL
from ..loops.nodes import (
    Allocate,
    Array,
    Assign,
    Binary,
    Break,
    Call,
    Constant,
    Expression,
    For,
    Function,
    If,
    Load,
    Return,
    Statement,
    Store,
    Variable,
    View,
    While,
    assigned_variables,
    expressions,
    integer,
    names_in,
    parts,
    real,
    walk,
)  # fmt: skip
from ..loops.scope import fresh_name
from ..loops.tangent import bound_by, sources
from ..loops.types import BOOL, INT, REAL, ArrayType, Parameter, Scalar
from .analysis import Bounds, Stable, varying_names
from .flat import Flat, closed, flat
from .jumps import without_assignments
from .partials import Cotangents
from .statements import Region, copy, fill
from .sweeps import Sweeper
from .tape import Tape


@dataclass(frozen=True)
class Pullback:
    """The reverse derivative of an algorithm.

    Attributes
    ----------
    function : Function
        Parameters of the algorithm that it reads, then a cotangent of each array of real numbers that it changes and of
        each real number that it returns. Its results are cotangents: arrays, then numbers.
    cotangents : tuple of Parameter
        Those that it takes.
    arrays, numbers : tuple of str
        Parameters of the algorithm whose cotangents it gives, in its order.
    """

    function: Function
    cotangents: tuple[Parameter, ...]
    arrays: tuple[str, ...]
    numbers: tuple[str, ...]


_pullbacks: dict[tuple[Function, tuple[str, ...], tuple[tuple[str, int], ...]], Pullback] = {}


def pullback(function: Function, wrt: Collection[str], rows: Mapping[str, int]) -> Pullback:
    """The reverse derivative of an algorithm with respect to some of its parameters.

    Parameters
    ----------
    function : Function
    wrt : collection of str
        Parameters of real numbers that it reads.
    rows : mapping of str to int
        Of the parameters whose number of rows is not known.

    Raises
    ------
    AlgorithmError
        If what the reverse sweep needs may be more than can be kept, with the loop's file and line; if it calls a
        function without a text; or a kernel has no pullback.
    """
    names = tuple(p.name for p in function.parameters if p.name in wrt)
    key = function, names, tuple(sorted(rows.items()))
    if key not in _pullbacks:
        _pullbacks[key] = _Maker(function, names, rows).result()
    return _pullbacks[key]


class _Maker:
    """One reverse derivative."""

    def __init__(self, function: Function, wrt: tuple[str, ...], rows: Mapping[str, int]) -> None:
        self.function, self.wrt, self.rows = function, wrt, rows
        self.text = flat(function, rows)
        self.where = function.where or function.name
        numbers = [p.name for p in function.parameters if isinstance(p.type, Scalar)]
        integers = [p.name for p in function.parameters if p.type == INT]
        self.body = _settled(self.text, Stable(self.text.body, numbers))
        self.stable, self.bounds = Stable(self.body, numbers), Bounds(self.body, integers)
        ends = {v.array.name for v in self.text.changed.values()}
        for e in self.text.results:
            ends |= sources(e)
        self.active = varying_names(self.body, wrt, ends)
        self.taken = self.text.taken
        self.cotangents = Cotangents(self.active, self.taken, self.where)

    def result(self) -> Pullback:
        given = self._given()
        results = self._results()
        sweeper = Sweeper(self.cotangents, self.stable, self.bounds, Tape(self.taken), self.where)
        seeds = self._seeds(given)
        swept = sweeper.block(self.body, set())
        arrays = [p.name for p in self.function.parameters if p.name in results]
        numbers = tuple(name for name in self.wrt if name not in results)
        ends = tuple(self.cotangents.number(n) if n in self.active else real(0.0) for n in numbers)
        asked = {e.name for e in ends if isinstance(e, Variable)} | {a.name for a in results.values()}
        forward, backward = _pruned(swept.forward, (*seeds, *swept.backward), self.stable.computed, asked)
        head = [*self._head(sweeper, forward, backward, results), *sweeper.tape.allocated(swept.room)]
        end = [Return(ends)] if ends else []
        inputs = [self._input(p) for p in self.function.parameters if p.access != "out"]
        outs = [Parameter(a.name, a.type, "out") for a in results.values()]
        made = Function(
            f"{self.function.name}_vjp_{'_'.join(self.wrt)}",
            f"Reverse derivative of {self.function.name}: {self.function.note}",
            (*inputs, *given.values(), *outs), (REAL,) * len(numbers), (*head, *forward, *backward, *end),
        )  # fmt: skip
        if made.local_size > MOST_LOCAL:
            raise AlgorithmError(
                f"the reverse derivative of {self.function.name} keeps {swept.room.total} numbers, {made.local_size} "
                f"with its arrays; {MOST_LOCAL} fit", where=self.where, remedy="Use derivative(...), or fewer steps.",
            )  # fmt: skip
        return Pullback(made, tuple(given.values()), tuple(arrays), numbers)

    # -- parameters --------------------------------------------------------------------------------------------------

    def _input(self, p: Parameter) -> Parameter:
        type = closed(p.type, self.rows.get(p.name, 0)) if isinstance(p.type, ArrayType) else p.type
        return Parameter(p.name, type)

    def _given(self) -> dict[str, Parameter]:
        """Cotangents that it takes, by the parameter or the number of the result."""
        found: dict[str, Parameter] = {}
        for p in self.function.parameters:
            if p.access != "in" and isinstance(p.type, ArrayType) and p.type.scalar == REAL:
                type = closed(replace(p.type, record=None), self.rows.get(p.name, 0))
                found[p.name] = Parameter(fresh_name(f"{p.name}_bar", self.taken), type)
        reals = [k for k, t in enumerate(self.function.results) if t == REAL]
        for k in reals:
            name = "result_bar" if len(reals) == 1 else f"result{k}_bar"
            found[str(k)] = Parameter(fresh_name(name, self.taken), REAL)
        return found

    def _results(self) -> dict[str, Array]:
        """Arrays of cotangents that it gives, by parameter."""
        found: dict[str, Array] = {}
        for p in self.function.parameters:
            if p.name in self.wrt and isinstance(p.type, ArrayType):
                type = closed(replace(p.type, record=None), self.rows.get(p.name, 0))
                found[p.name] = Array(fresh_name(f"{p.name}_bar", self.taken), type)
        self.cotangents.arrays.update(found)
        return found

    def _seeds(self, given: Mapping[str, Parameter]) -> list[Statement]:
        """The cotangents of what the text gives."""
        found: list[Statement] = []
        for name, place in self.text.changed.items():
            if place.array.name in self.active and name in given:
                p = given[name]
                assert isinstance(p.type, ArrayType)
                source = View(Array(p.name, p.type), integer(0), p.type)
                target = replace(place, array=self.cotangents.array(place.array))
                size = 0 if p.type.is_open else p.type.size
                found += copy(target, source, size, self.taken)
        for k, value in enumerate(self.text.results):
            if str(k) in given:
                weight = Variable(given[str(k)].name, REAL)
                found += self.cotangents.spread(value, weight, self.active)
        return found

    # -- what stands before the sweeps -------------------------------------------------------------------------------

    def _head(
        self,
        sweeper: Sweeper,
        forward: Sequence[Statement],
        backward: Sequence[Statement],
        results: Mapping[str, Array],
    ) -> list[Statement]:
        """Arrays, and first values of what is kept before it has one, or is read where another branch has it."""
        found: list[Statement] = []
        zero = {s.array.name for s in walk(tuple(self.text.body)) if isinstance(s, Allocate) and s.is_zero}
        zero |= {self.text.changed[p.name].array.name for p in self.function.parameters if p.access == "out"}
        used = _arrays_of((*forward, *backward))
        for array in self.text.arrays:
            if array.name in used:
                found.append(Allocate(array, array.name in zero or array.name in sweeper.kept))
        for array in results.values():
            size = 0 if array.type.is_open else array.type.size
            found += fill(View(array, integer(0), array.type), size, self.taken)
        own = {a.name for a in results.values()}
        for array in self.cotangents.arrays.values():
            if array.name not in own and array.name in used:
                found.append(Allocate(array, True))
        found += [row for row in sweeper.kernels.rows if row.array.name in used]
        both = _assigned((*forward, *backward))
        wanted = both | {n for n in self.wrt if n in self.active}
        first = [Assign(v, real(0.0)) for n, v in self.cotangents.numbers.items() if v.name in both or n in wanted]
        given = {p.name for p in self.function.parameters} | {n for s in forward for n in bound_by(s)}
        shared = sweeper.kept | _reads(backward) - given
        for v in sorted(set(assigned_variables(forward)), key=lambda v: v.name):
            if v.name in shared and v.name not in {p.name for p in self.function.parameters}:
                first.append(Assign(v, Constant({REAL: 0.0, INT: 0, BOOL: False}[v.type], v.type)))
        return [*found, *first]


def _arrays_of(body: Sequence[Statement]) -> set[str]:
    return _reads(body) | {s.array.name for s in walk(tuple(body)) if isinstance(s, Store)}


def _reads(body: Sequence[Statement]) -> set[str]:
    found = {n for s in walk(tuple(body)) for e in expressions(s) for n in names_in(e)}
    calls = (s for s in walk(tuple(body)) if isinstance(s, Call))
    return found | {a.array.name for s in calls for a in s.arguments if isinstance(a, View)}


Block = tuple[Statement, ...]


def _pruned(forward: Block, backward: Block, computed: Collection[str], ends: Collection[str]) -> tuple[Block, Block]:
    """Both sweeps without what nothing reads. ``computed``: numbers that the reverse sweep computes anew."""
    while unread := {n for n in _assigned(backward) if n in computed} - _reads(backward):
        backward = without_assignments(backward, unread)
    while unread := _changed((*forward, *backward)) - _reads((*forward, *backward)) - set(ends):
        forward, backward = without_assignments(forward, unread), without_assignments(backward, unread)
    return forward, backward


def _assigned(body: Block) -> set[str]:
    return {s.target.name for s in walk(body) if isinstance(s, Assign)}


def _changed(body: Block) -> set[str]:
    return _assigned(body) | {s.array.name for s in walk(body) if isinstance(s, Store)}


def _settled(text: Flat, stable: Stable) -> tuple[Statement, ...]:
    """The text with names for what decides: bounds of loops and conditions that change in them, and indices."""

    def named(value: Expression, stem: str, type: Scalar, before: list[Statement]) -> Expression:
        if stable.is_stable(value):
            return value
        name = Variable(fresh_name(stem, text.taken), type)
        before.append(Assign(name, value))
        return name

    def block(body: Sequence[Statement], is_repeated: bool) -> tuple[Statement, ...]:
        found: list[Statement] = []
        for s in body:
            match s:
                case Allocate(array, is_zero):
                    if is_zero and is_repeated:
                        found += fill(View(array, integer(0), array.type), array.type.size, text.taken)
                    elif is_zero:
                        found.append(s)
                case Region():
                    found.append(replace(s, yes=block(s.yes, is_repeated)))
                case If(condition, yes, no):
                    is_end = yes == (Break(),)
                    asked = condition if is_end else named(condition, "taken", BOOL, found)
                    found.append(If(asked, block(yes, is_repeated), block(no, is_repeated)))
                case For(_, start, stop, _, inner):
                    begin = named(start, "bound", INT, found)
                    match stop:
                        case Binary("+" | "-", left, Constant(), _) if (
                            left == start
                        ):  # so many steps, wherever it begins
                            stop = replace(stop, left=begin)
                        case _:
                            stop = named(stop, "bound", INT, found)
                    found.append(replace(s, start=begin, stop=stop, body=block(inner, True)))
                case While(_, inner):
                    found.append(replace(s, body=block(inner, True)))
                case Store(_, index, _) if _changes(index, stable):
                    found.append(replace(s, index=named(index, "place", INT, found)))
                case _:
                    found.append(s)
        return tuple(found)

    return block(text.body, False)


def _changes(index: Expression, stable: Stable) -> bool:
    """Whether an index is read from an array that changes."""
    return any(isinstance(p, Load) and p.array.name in stable.arrays for p in parts(index))
