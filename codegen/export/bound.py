"""Algorithms with some of their arguments given: tables of constants in the file, and local arrays to work in."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from ..errors import InputError
from ..ir.loops.nodes import (
    Allocate,
    Array,
    Call,
    Constant,
    Expression,
    Function,
    Return,
    Statement,
    Variable,
    View,
    integer,
)
from ..ir.loops.types import INT, ArrayType, Parameter, Scalar


@dataclass(frozen=True)
class Table:
    """Constant numbers of a file, by their whole name in it."""

    name: str
    type: ArrayType
    values: tuple[float | int, ...]


@dataclass(frozen=True)
class ExportedAlgorithm:
    """An algorithm to export: its name there, its function, what is said of it, and the constants that it reads."""

    name: str
    function: Function
    notes: tuple[str, ...] = ()
    tables: tuple[Table, ...] = ()


@dataclass(frozen=True)
class Binding:
    """An algorithm that takes less than another one.

    Attributes
    ----------
    name : str
        Of the function in the file.
    function : Function
    given : mapping
        Arrays and numbers in place of parameters.
    shapes : mapping of str to sequence of int
        Of those of the other arrays whose number of rows is not known.
    work : mapping of str to int
        Arrays that nobody reads afterwards, and how many numbers they have.
    notes : tuple of str
        What is said of it, beside the function's first line.
    """

    name: str
    function: Function
    given: Mapping[str, Any]
    shapes: Mapping[str, Sequence[int]] = field(default_factory=dict)
    work: Mapping[str, int] = field(default_factory=dict)
    notes: tuple[str, ...] = ()


def bound_algorithms(file: str, bindings: Iterable[Binding]) -> list[ExportedAlgorithm]:
    """The algorithms of a file, which share tables of the same numbers.

    Raises
    ------
    InputError
        If a shape is missing.
    """
    tables: dict[str, Table] = {}
    return [_bound(file, each, tables) for each in bindings]


def _bound(file: str, binding: Binding, shared: dict[str, Table]) -> ExportedAlgorithm:
    """One of them; its tables are added to those that are shared."""
    function, given = binding.function, binding.given
    parameters: list[Parameter] = []
    arguments: list[Expression | View] = []
    tables: list[Table] = []
    body: list[Statement] = []
    for p in function.parameters:
        if isinstance(p.type, Scalar):
            if p.name in given:
                arguments.append(Constant(np.asarray(given[p.name]).item(), p.type))
            else:
                arguments.append(Variable(p.name, p.type))
                parameters.append(p)
            continue
        assert isinstance(p.type, ArrayType)
        if p.name in given:
            numbers = _numbers(function, p.name, p.type, given[p.name])
            type = ArrayType(p.type.scalar, (max(1, len(numbers)),), bits=p.type.bits)
            table = Table(f"{file}_{p.name}", type, numbers or (0,))  # languages have no arrays without elements
            if shared.setdefault(table.name, table) != table:
                table = replace(table, name=f"{file}_{binding.name}_{p.name}")
                shared[table.name] = table
            tables.append(table)
            array, size = Array(table.name, type), len(numbers)
        elif p.name in binding.work:
            size = binding.work[p.name]
            array = Array(p.name, ArrayType(p.type.scalar, (max(1, size),)), is_local=True)
            body.append(Allocate(array, is_zero=False))
        else:
            own = _known(function, p, binding.shapes)
            parameters.append(replace(p, type=own))
            array, size = Array(p.name, own), own.size
        arguments.append(View(array, integer(0), p.type, integer(size // p.type.size) if p.type.is_open else None))
    results = tuple(Variable(f"returned{k}", t) for k, t in enumerate(function.results))
    body += [Call(function, tuple(arguments), results), *([Return(results)] if results else [])]
    made = Function(f"{binding.name}_of_{file}", function.note, tuple(parameters), function.results, tuple(body))
    return ExportedAlgorithm(binding.name, made, binding.notes, tuple(tables))


def _numbers(function: Function, name: str, type: ArrayType, values: Any) -> tuple[float | int, ...]:
    numbers = np.ravel(np.asarray(values, np.int64 if type.scalar == INT else np.float64)).tolist()
    if len(numbers) % type.size or not (type.is_open or len(numbers) == type.size):
        raise InputError(f"{function.name}: {name} has {len(numbers)} numbers, in place of {type.size}.")
    return tuple(numbers)


def _known(function: Function, parameter: Parameter, shapes: Mapping[str, Sequence[int]]) -> ArrayType:
    assert isinstance(parameter.type, ArrayType)
    if not parameter.type.is_open:
        return parameter.type
    if parameter.name not in shapes:
        raise InputError(f"{function.name}: the number of rows of {parameter.name} is missing.")
    return ArrayType(parameter.type.scalar, tuple(shapes[parameter.name]), bits=parameter.type.bits)
