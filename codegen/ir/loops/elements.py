"""Reading names, elements and numbers of algorithms: index arithmetic, conversions, static values."""

from __future__ import annotations

import ast
from abc import ABC, abstractmethod
from dataclasses import replace
from typing import Any, NoReturn

from ...errors import AlgorithmError
from .nodes import Binary, Constant, Expression, Intrinsic, Load, View, integer, plus, scaled
from .scope import Meaning, Scope, Static
from .static import plain
from .text import AlgorithmText
from .types import BOOL, INT, REAL, ArrayType, Scalar

#: Integers are less than this, and not less than minus this.
LIMIT = 1 << 63


class ElementReader(ABC):
    """What names and elements of arrays mean, and meanings as numbers."""

    def __init__(self, text: AlgorithmText) -> None:
        self.text = text
        self.scope = Scope()
        self.guards = 0  # of expressions that are not always computed: no statement may come before them

    def refuse(self, node: ast.AST, what: str, remedy: str) -> NoReturn:
        self.text.refuse(node, what, remedy)

    @abstractmethod
    def meaning(self, node: ast.expr) -> Meaning:
        """What an expression means: a static value, a number, or a part of an array."""

    # -- numbers -------------------------------------------------------------------------------------------------

    def static(self, node: ast.expr, what: str) -> Any:
        """The value of an expression that must be static."""
        found = self.meaning(node)
        if not isinstance(found, Static):
            self.refuse(node, f"{what} is not static", "Use constants, Static parameters and lengths of fixed arrays.")
        return found.value

    def expression(self, node: ast.expr, type: Scalar | None = None) -> Expression:
        """A number, converted to a type where that is asked for and loses nothing."""
        found = self.number(node, self.meaning(node))
        return self.converted(node, found, type) if type else found

    def number(self, node: ast.AST, found: Meaning) -> Expression:
        """A meaning as a number."""
        if isinstance(found, Static):
            value = plain(found.value)
            kinds: dict[type, Scalar] = {bool: BOOL, int: INT, float: REAL}
            if type(value) not in kinds:
                self.refuse(node, f"{value!r} is not a number", "Static strings and tuples only decide branches.")
            if type(value) is int and not -LIMIT <= value < LIMIT:
                self.refuse(node, "an integer of more than 64 bits", "Write a real number, such as 2.0 ** 70.")
            return Constant(value, kinds[type(value)])
        if isinstance(found, (View, tuple)):
            self.refuse(node, "an array or a tuple stands where a number should", "Take one element of it.")
        return found

    def converted(self, node: ast.AST, found: Expression, type: Scalar) -> Expression:
        if found.type == type:
            return found
        if found.type == INT and type == REAL:
            if isinstance(found, Constant):
                return Constant(float(found.value), REAL)
            return Intrinsic("real", (found,), REAL)
        return self.refuse(node, f"a value of type {found.type} stands where {type} should", "Convert it: int(x).")

    def condition(self, node: ast.expr) -> Meaning:
        """A condition: static or of type Bool."""
        found = self.meaning(node)
        if isinstance(found, Static):
            return Static(bool(found.value))
        return self.converted_condition(node, self.number(node, found))

    def converted_condition(self, node: ast.AST, found: Expression) -> Expression:
        if found.type != BOOL:
            self.refuse(node, f"a condition is of type {found.type}", "Write a comparison, such as x != 0.")
        return found

    # -- names and elements --------------------------------------------------------------------------------------

    def _name(self, node: ast.Name, name: str) -> Meaning:
        if name in self.scope.defined:
            return self.scope.defined[name]
        if name in self.bound:
            self.refuse(node, f"{name} may not be defined here", "Give it a value on every path to this line.")
        return self._static(node, self.text.outside(node, name))

    #: Names that the function binds itself.
    bound: dict[str, int]

    def _static(self, node: ast.AST, value: Any) -> Static:
        return Static(value)  # whether its type is of any use, what takes it decides

    def index_of(self, node: ast.expr, length: int | None) -> Expression:
        """One index; a static one is checked against a fixed length, and may count from the end."""
        found = self.expression(node)
        if found.type != INT:
            self.refuse(node, f"an index is of type {found.type}", "Use an integer; int(x) cuts a number off.")
        if isinstance(found, Constant):
            value = int(found.value)
            if value < 0 and length is not None:
                value += length
            if value < 0 or (length is not None and value >= length):
                given = int(found.value)
                self.refuse(node, f"the index {given} is outside of a length of {length}", "Take one inside.")
            return integer(value)
        return found

    def _subscript(self, node: ast.Subscript, base: Meaning, index: ast.expr) -> Meaning:
        if isinstance(base, Static):
            key = self._static_slice(index) if isinstance(index, ast.Slice) else self.static(index, "a static index")
            try:
                return Static(base.value[key])
            except (LookupError, TypeError, ValueError) as error:
                self.refuse(node, f"a static value has no such element ({error})", "Look at the value.")
        if not isinstance(base, View):
            self.refuse(node, "an index of what is not an array", "Arrays are parameters, zeros(...) or empty(...).")
        indices = index.elts if isinstance(index, ast.Tuple) else [index]
        if len(indices) == 1 and isinstance(indices[0], ast.Slice):
            return self._slice(base, indices[0])
        sizes = base.type.sizes
        if len(indices) > len(sizes) or any(isinstance(i, ast.Slice) for i in indices):
            self.refuse(node, f"{len(indices)} indices for {base.type}", "Slices stand alone: a[2:4], a[i][:].")
        offset = base.offset
        for axis, each in enumerate(indices):
            offset = plus(offset, scaled(self.index_of(each, sizes[axis]), base.type.stride(axis)))
        if len(indices) == len(sizes):
            return Load(base.array, offset)
        return View(base.array, offset, base.type.row(len(indices)))

    def _static_slice(self, bounds: ast.Slice) -> slice:
        parts = (bounds.lower, bounds.upper, bounds.step)
        return slice(*(None if p is None else self.static(p, "a bound of a static slice") for p in parts))

    def _field(self, node: ast.AST, base: View, name: str) -> Meaning:
        """A field of one row of a record."""
        if len(base.type.sizes) != 1:
            self.refuse(node, f"the field {name} of several rows", "Take one row first, such as x[i].")
        try:
            offset, type = base.type.record.field(name)
        except AlgorithmError as error:
            self.refuse(node, error.what, str(error.remedy))
        place = plus(base.offset, integer(offset))
        if not isinstance(type, ArrayType):
            return Load(base.array, place)
        return View(base.array, place, type, is_still=name in base.type.record.still)

    def _slice(self, base: View, bounds: ast.Slice) -> View:
        """``a[:]``, part of an array from one static index to another, ``a[i : i + n]`` with a static n, or ``a[i:]``.

        The last is of an array whose number of rows is known at run time.
        """
        if bounds.step is not None:
            self.refuse(bounds.step, "a slice with a step", "Write a loop.")
        if bounds.lower is None and bounds.upper is None:
            return base
        length = base.type.sizes[0]
        low = integer(0) if bounds.lower is None else self.expression(bounds.lower)
        if low.type != INT:
            self.refuse(bounds, f"a slice begins at a value of type {low.type}", "Use an integer.")
        if base.type.is_open and bounds.upper is None:
            assert base.rows is not None
            rest = Binary("-", base.rows, low, INT)
            return replace(base, offset=plus(base.offset, scaled(low, base.type.stride(0))), rows=rest)
        if isinstance(low, Constant):
            high = length if bounds.upper is None else self.static(bounds.upper, "the end of a slice")
            count = high - int(low.value) if isinstance(high, int) else 0
        else:
            count = self._length_of_moving_slice(bounds)
        begin = int(low.value) if isinstance(low, Constant) else 0
        is_inside = isinstance(count, int) and count > 0 and begin >= 0 and (length is None or begin + count <= length)
        if not is_inside:
            what = f"a slice of length {count} from {ast.unparse(bounds.lower or ast.Constant(0))} of {base.type}"
            self.refuse(bounds, what, "Take one inside, not empty.")
        offset = plus(base.offset, scaled(low, base.type.stride(0)))
        return View(base.array, offset, replace(base.type, shape=(count, *base.type.sizes[1:]), record=None))

    def _length_of_moving_slice(self, bounds: ast.Slice) -> Any:
        """The n of ``a[i : i + n]``."""
        match bounds.lower, bounds.upper:
            case ast.expr() as lower, ast.BinOp(left, ast.Add(), right) if ast.unparse(left) == ast.unparse(lower):
                return self.static(right, "the length of a slice")
        return self.refuse(bounds, "a slice whose length is not seen", "Write a[i : i + n] with a static n.")
