"""What a formula reads when it is traced, as text: its code, its constants, and what its names mean.

Formulas with the same text are traced to the same graph, also in another process that has the same sources of the
compiler: these are named and not read, for they have a stamp of their own (`build.source_digest`). Where something
cannot be told from text (state, files, random numbers, objects of other classes) there is none: the formula is traced.
"""

from __future__ import annotations

import builtins
import sys
from collections.abc import Iterator
from fractions import Fraction
from opcode import opmap
from types import BuiltinFunctionType, CodeType, FunctionType, ModuleType
from typing import Any

import numpy as np

from ..algebra.algebra import Algebra, Kind

_COMPILER = __package__.rpartition(".")[0]
_PLAIN = (type(None), bool, int, float, complex, str, bytes, Fraction, type(Ellipsis), range)
#: Modules of the standard library whose functions and classes give the same results in every process.
_PURE = frozenset(("math", "cmath", "itertools", "fractions", "_operator", "_functools"))
#: Functions of Python that do: others read files, names or addresses.
_PURE_BUILTINS = frozenset(
    (
        "abs",
        "all",
        "any",
        "bin",
        "callable",
        "chr",
        "divmod",
        "format",
        "hex",
        "isinstance",
        "issubclass",
        "iter",
        "len",
    )
    + ("max", "min", "next", "oct", "ord", "pow", "repr", "round", "sorted", "sum")
)
#: Instructions that load modules, or leave something behind.
_IMPURE = frozenset(
    opmap[name] for name in ("IMPORT_NAME", "STORE_GLOBAL", "DELETE_GLOBAL", "STORE_ATTR", "DELETE_ATTR")
)


class _Unknown(Exception):
    """Something cannot be told from text."""


def reached_text(value: Any) -> str | None:
    """Text of a formula, or of anything that one may read; None where there can be none.

    Parameters
    ----------
    value : object
        A function, number, text, kind, algebra, array, declared formula, or a container of such.
    """
    try:
        return "\n".join(_Reader().whole(value))
    except (_Unknown, RecursionError):
        return None


class _Reader:
    """Texts of objects; what was met before is named by its place."""

    def __init__(self) -> None:
        self._met: dict[int, tuple[int, Any]] = {}  # objects stay, so that no other one takes their address
        self._names: set[str] = set()
        self._modules: list[ModuleType] = []

    def whole(self, value: Any) -> Iterator[str]:
        """Pieces of text of an object, then of all that any code that was met may ask the modules for."""
        yield from self._parts(value)
        read: set[tuple[int, str]] = set()
        while waiting := [
            (i, name)
            for i, m in enumerate(self._modules)
            for name in self._names & vars(m).keys()
            if (i, name) not in read
        ]:
            for i, name in sorted(waiting):
                yield f"module {i} {name}"
                yield from self._parts(vars(self._modules[i])[name])
            read.update(waiting)

    def _parts(self, value: Any) -> Iterator[str]:
        if type(value) in _PLAIN:
            yield f"{type(value).__name__} {value!r}"
            return
        if id(value) in self._met:
            yield f"met {self._met[id(value)][0]}"
            return
        self._met[id(value)] = (len(self._met), value)
        if (name := _name_in_compiler(value)) is not None:
            yield f"compiler {name}"
        elif isinstance(value, FunctionType):
            yield from self._function(value)
        elif isinstance(value, CodeType):
            yield from self._code(value)
        elif isinstance(value, ModuleType):
            if "__getattr__" in vars(value):  # it may find names that it does not have
                raise _Unknown
            yield f"module {value.__name__}"
            self._modules.append(value)
        elif isinstance(value, BuiltinFunctionType | type):
            yield _name_of_pure(value)
        else:
            yield type(value).__name__
            yield from self._items(_contents(value))

    def _items(self, items: Any) -> Iterator[str]:
        yield f"{len(items)} items"
        for item in items:
            yield from self._parts(item)

    def _function(self, function: FunctionType) -> Iterator[str]:
        yield "function"
        yield from self._code(function.__code__)
        try:
            cells = [cell.cell_contents for cell in function.__closure__ or ()]
        except ValueError:  # one has no value yet
            raise _Unknown from None
        own = (cells, function.__defaults__, function.__kwdefaults__, function.__doc__, vars(function))
        for each in own:
            yield from self._parts(each)
        known: dict[str, Any] = getattr(function, "__builtins__")  # noqa: B009 (typeshed lacks it)
        for name in sorted(set(_names(function.__code__))):
            if name in function.__globals__:
                yield f"global {name}"
                yield from self._parts(function.__globals__[name])
            elif name.startswith("__"):
                raise _Unknown
            elif name in known:
                yield f"builtin {name}"
                yield from self._parts(known[name])

    def _code(self, code: CodeType) -> Iterator[str]:
        if not _IMPURE.isdisjoint(code.co_code[::2]):
            raise _Unknown
        self._names.update(code.co_names)
        counts = (code.co_argcount, code.co_posonlyargcount, code.co_kwonlyargcount, code.co_flags)
        names = (code.co_names, code.co_varnames, code.co_freevars, code.co_cellvars)
        yield f"code {code.co_code!r} {getattr(code, 'co_exceptiontable', b'')!r} {counts} {names}"
        yield from self._items(code.co_consts)


def algebra_parts(algebra: Algebra) -> list[Any]:
    """The data of an algebra: what products, names and kinds of results follow from."""
    kinds = repr([_kind_parts(kind) for kind in algebra.kinds.values()])
    return [algebra.name, algebra.vectors, algebra.metric, algebra.pseudoscalar_name, kinds]


def _contents(value: Any) -> list[Any]:
    """What an object consists of."""
    if type(value) in (list, tuple):
        return list(value)
    if type(value) is dict:
        return [each for pair in value.items() for each in pair]
    if type(value) in (set, frozenset):
        return sorted(map(repr, value)) if all(type(v) in _PLAIN for v in value) else _refuse()
    if isinstance(value, np.ndarray | np.generic) and value.dtype.kind in "biuf":
        return [value.dtype.str, str(np.shape(value)), value.tobytes()]
    if type(value) is Kind:
        return [*_kind_parts(value), *algebra_parts(value.algebra)]
    if type(value) is Algebra:
        return algebra_parts(value)
    if hasattr(type(value), "declared_parts"):
        return list(value.declared_parts())
    return _refuse()


def _kind_parts(kind: Kind) -> list[Any]:
    return [kind.name, kind.blades, kind.constraints, kind.member, kind.form]


def _refuse() -> list[Any]:
    raise _Unknown


def _names(code: CodeType) -> Iterator[str]:
    """Names of globals, builtins and attributes in a code and in those inside it."""
    yield from code.co_names
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield from _names(constant)


def _name_in_compiler(value: Any) -> str | None:
    """Name of a module, function or class of this package; None of anything else."""
    if isinstance(value, ModuleType):
        return value.__name__ if f"{value.__name__}.".startswith(f"{_COMPILER}.") else None
    if not isinstance(value, FunctionType | type) or not f"{value.__module__}.".startswith(f"{_COMPILER}."):
        return None
    return f"{value.__module__}.{value.__qualname__}" if _is_found(value, value.__module__) else None


def _name_of_pure(value: Any) -> str:
    """Name of a function or class of Python whose results are the same in every process."""
    home, name = value.__module__, value.__qualname__
    is_pure = home in _PURE or (home == "builtins" and (isinstance(value, type) or name in _PURE_BUILTINS))
    if not is_pure or not _is_found(value, home):
        raise _Unknown
    return f"{home}.{name}"


def _is_found(value: Any, home: str) -> bool:
    """Return whether a function or class is what its module has by its name."""
    found: Any = builtins if home == "builtins" else sys.modules.get(home)
    for name in value.__qualname__.split("."):
        found = getattr(found, name, None)
    return found is value
