"""What one exported file holds, in no language: structs, and functions in calling order."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import count

from ..algebra.algebra import Kind
from ..errors import InputError
from ..ir.loops.algorithm import refusal_of_library
from ..ir.loops.nodes import (
    Binary,
    Call,
    For,
    Function,
    If,
    Intrinsic,
    KernelSignature,
    Statement,
    While,
    expressions,
    parts,
)
from ..optimise.variants import Variant
from ..targets.elementary import FAR_OR_NEAR
from ..targets.loops import in_calling_order
from ..targets.printer import comment_text
from ..trace.kernel import Kernel, blade_label
from .bound import ExportedAlgorithm, Table
from .elementary import ELEMENTARY, elementary_functions
from .kernel_functions import kernel_function
from .notes import kernel_notes


@dataclass(frozen=True)
class Struct:
    """The coefficients of a kind by name, in their order."""

    name: str
    fields: tuple[str, ...]


@dataclass(frozen=True)
class Slot:
    """An argument or a result of a kernel: a struct, an array of ``size`` numbers, or one number (``size`` 0).

    ``array``: its name in the kernel's function. ``is_status``: an integer, a `bladesmith.Status`.
    """

    name: str
    array: str
    size: int
    struct: Struct | None = None
    is_status: bool = False


@dataclass(frozen=True)
class Entry:
    """A function for users: a kernel, with structs, or an algorithm, on arrays (no slots)."""

    name: str
    function: Function
    notes: tuple[str, ...]
    inputs: tuple[Slot, ...] = ()
    outputs: tuple[Slot, ...] = ()

    @property
    def is_kernel(self) -> bool:
        return bool(self.outputs)


@dataclass(frozen=True)
class Unit:
    """One file.

    Attributes
    ----------
    name : str
        An identifier: of the file, and before or around all names in it.
    precision : {"f64", "f32"}
    structs : tuple of Struct
    tables : tuple of Table
        Constants.
    functions : tuple of Function
        What entries call, callees first.
    entries : tuple of Entry
    mathematics : tuple of Function
        Elementary functions that all of these need, callees first.
    source : str
        What the functions are made from, for readers and for who writes the file again.
    """

    name: str
    precision: str
    structs: tuple[Struct, ...]
    tables: tuple[Table, ...]
    functions: tuple[Function, ...]
    entries: tuple[Entry, ...]
    mathematics: tuple[Function, ...]
    source: str = ""

    def name_of(self, function: Function) -> str:
        """What a function is called in the file; elementary functions have another word before theirs."""
        names = {e.function: e.name for e in self.entries if not e.is_kernel}
        taken = {e.name for e in self.entries}
        return names.get(function) or (f"{function.name}_inner" if function.name in taken else function.name)

    @property
    def intrinsics(self) -> frozenset[str]:
        """Functions of numbers that occur, for which a language has names or texts."""
        own = [*self.functions, *(e.function for e in self.entries), *self.mathematics]
        return frozenset().union(*(own_intrinsics(f) for f in own))

    def in_precision(self, precision: str) -> Unit:
        """The same with the elementary functions of another precision."""
        return replace(
            self, precision=precision, mathematics=tuple(elementary_functions(self.intrinsics & ELEMENTARY, precision))
        )

    @property
    def is_reduced_far(self) -> bool:
        """Whether angles are reduced."""
        return any(f.name == FAR_OR_NEAR for f in self.mathematics)


def exported_unit(
    name: str, items: Sequence[Variant | ExportedAlgorithm], precision: str = "f64", source: str = ""
) -> Unit:
    """Collect what the functions of a file need.

    Raises
    ------
    InputError
        If two functions have one name.
    """
    structs: dict[tuple[str, ...], Struct] = {}
    linker = _Linker()
    entries: dict[str, Entry] = {}
    for item in items:
        entry = linker.kernel_entry(item, structs) if isinstance(item, Variant) else linker.algorithm_entry(item)
        if entry.name in entries:
            raise InputError(
                f"two exported functions are called {entry.name}.", remedy="Give one of them another name (name=...)."
            )
        entries[entry.name] = entry
    own = [e.function for e in entries.values()]
    called, _ = in_calling_order([linker.linked(f) for f in own])
    inner = {f.name for e in own for f in deep_callees(e)}
    functions = tuple(f for f in called if f.name in inner)
    tables = {t.name: t for i in items if isinstance(i, ExportedAlgorithm) for t in i.tables}
    used = frozenset().union(*(own_intrinsics(f) for f in called)) & ELEMENTARY
    return Unit(
        name, precision, tuple(structs.values()), tuple(tables.values()), functions, tuple(entries.values()),
        tuple(elementary_functions(used, precision)), source or name,
    )  # fmt: skip


def intrinsics_of(function: Function) -> frozenset[str]:
    """Functions of numbers that a function needs, or one that it calls."""
    return frozenset().union(*(own_intrinsics(f) for f in (function, *deep_callees(function))))


def own_intrinsics(function: Function) -> frozenset[str]:
    """Functions of numbers, and operators of integers with a function behind them, that a function itself calls."""
    found = [p for s in function.walk() for e in expressions(s) for p in parts(e)]
    names = {p.name for p in found if isinstance(p, Intrinsic)}
    return frozenset(names | {p.operator for p in found if isinstance(p, Binary) and p.operator in ("//", "%")})


def deep_callees(function: Function) -> list[Function]:
    """What a function calls, and what these call."""
    found: dict[Function, None] = {}
    waiting = [function]
    while waiting:
        for callee in waiting.pop().callees():
            if isinstance(callee, Function) and callee not in found:
                found[callee] = None
                waiting.append(callee)
    return list(found)


class _Linker:
    """Makes functions of kernels, where they are exported or algorithms call them."""

    def __init__(self) -> None:
        self.kernels: dict[Kernel, Function] = {}
        self.linked_functions: dict[Function, Function] = {}

    def kernel_entry(self, variant: Variant, structs: dict[tuple[str, ...], Struct]) -> Entry:
        kernel, function = variant.kernel, kernel_function(variant, self.kernels)
        arrays = iter(function.parameters)
        outputs = tuple(_slot(o.name, next(arrays).name, o.kind, structs, o.role) for o in kernel.outputs)
        inputs = tuple(_slot(i.name, next(arrays).name, i.kind, structs) for i in kernel.inputs)
        return Entry(kernel.name, function, kernel_notes(variant), inputs, outputs)

    def algorithm_entry(self, item: ExportedAlgorithm) -> Entry:
        function = self.linked(item.function)
        notes = tuple(map(comment_text, (item.function.note, *item.notes)))
        return Entry(item.name, function, notes)

    def linked(self, function: Function) -> Function:
        """The function, with those of kernels where it and what it calls have their signatures."""
        found = self.linked_functions.get(function)
        if found is None:
            if function.is_library and not function.body:
                raise refusal_of_library(function.name)
            found = self.linked_functions[function] = replace(function, body=self._body(function.body))
            self.linked_functions[found] = found
        return found

    def _body(self, body: tuple[Statement, ...]) -> tuple[Statement, ...]:
        return tuple(self._statement(s) for s in body)

    def _statement(self, statement: Statement) -> Statement:
        match statement:
            case Call(KernelSignature() as signature, _, _):
                return replace(statement, callee=kernel_function(signature.kernel.variant, self.kernels))
            case Call(Function() as function, _, _):
                return replace(statement, callee=self.linked(function))
            case For() | While():
                return replace(statement, body=self._body(statement.body))
            case If():
                return replace(statement, yes=self._body(statement.yes), no=self._body(statement.no))
            case _:
                return statement


def _slot(name: str, array: str, kind: Kind, structs: dict[tuple[str, ...], Struct], role: str = "value") -> Slot:
    if role == "status" or kind.is_scalar_argument or kind.blades == (0,):
        return Slot(name, array, 0, is_status=role == "status")
    return Slot(name, array, kind.size, _struct(kind, structs))


def _struct(kind: Kind, structs: dict[tuple[str, ...], Struct]) -> Struct | None:
    """The struct of a kind: that of all kinds with these blades, named as the algebra's first one."""
    if kind.form != "multivector":
        return None
    fields = tuple(blade_label(kind.algebra.blade_name(b)) for b in kind.blades)
    if fields not in structs:
        first = next((k.name for k in kind.algebra.kinds.values() if k.blades == kind.blades), kind.name)
        first = first if first.isidentifier() else f"blades{kind.size}"  # few blades are joined, as in 1_e1_e2
        taken = {s.name for s in structs.values()}
        names = (first if k == 1 else f"{first}_{k}" for k in count(1))  # layouts of many blades share their names
        structs[fields] = Struct(next(n for n in names if n not in taken), fields)
    return structs[fields]
