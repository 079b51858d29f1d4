"""Calls for some of several items: the others keep what they have."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from ....errors import AlgorithmError
from ....ir.loops.nodes import (
    Allocate,
    Array,
    Assign,
    Call,
    Constant,
    Expression,
    For,
    Function,
    KernelSignature,
    Load,
    Store,
    Variable,
    View,
    boolean,
    integer,
    outputs,
    plus,
)  # fmt: skip
from ....ir.loops.types import INT
from .paths import is_wide_call, varies
from .places import Places


class CallMasker(Places):
    """Turns a call into that of the callee's text of several items, which is told the items if it needs to know."""

    def call(self, call: Call) -> None:
        callee, names = call.callee, self.names
        if not is_wide_call(names, call):
            self._finish_call(call, [self._argument(a) for a in call.arguments], ())
            return
        written = {id(a) for a in outputs(call)}
        is_kernel = isinstance(callee, KernelSignature)
        arguments: list[Expression | View] = []
        after: list[tuple[View, Array]] = []
        copies: dict[tuple[str, Expression, bool], tuple[Array, Expression]] = {}  # one for what is given twice
        for each in call.arguments:
            if not isinstance(each, View):
                arguments.append(self._argument(each))
                continue
            apart, is_result = varies(names, each.offset), is_kernel and id(each) in written
            is_partial = self.mask is not None and not self.is_own(each.array.name) and each.array.name in names
            if not apart and not (is_result and is_partial):
                arguments.append(self._argument(each))
                continue
            key = each.array.name, each.offset, is_result  # kernels read all before they write
            if key not in copies:
                copies[key] = self._copy(each, apart, is_read=not is_result)
            copy, place = copies[key]
            arguments.append(replace(each, array=copy, offset=integer(0)))
            if id(each) in written:
                after.append((replace(each, offset=place), copy))
        if isinstance(callee, Function) and callee in self.lanes.masked:
            arguments.append(self.mask or boolean(True))
        self._finish_call(call, arguments, after)

    def _argument(self, argument: Expression | View) -> Expression | View:
        if not isinstance(argument, View):
            return self.expression(argument)
        rows = None if argument.rows is None else self.expression(argument.rows)
        if rows is not None and varies(self.names, rows):
            raise AlgorithmError(
                f"the number of rows of {argument.array.name} differs between items", where=self.original.name,
                remedy="Compute its items one after the other.",
            )  # fmt: skip
        return replace(argument, offset=self.expression(argument.offset), rows=rows)

    def _copy(self, view: View, apart: bool, is_read: bool) -> tuple[Array, Expression]:
        """An array of its own with a part of one, and where that begins."""
        shape = view.type.sizes
        if view.type.is_open:
            if not isinstance(view.rows, Constant):
                raise AlgorithmError(
                    f"a part of {view.array.name} that begins where each item says has no fixed length",
                    where=self.original.name, remedy="Compute its items one after the other.",
                )  # fmt: skip
            shape = (int(view.rows.value), *shape[1:])
        offset = self.expression(view.offset)
        place: Expression = self.guards.named("place", self.guards.index(offset, self.mask)) if apart else offset
        copy = Array(self.guards.fresh("own", INT).name, replace(view.type, shape=shape, bits=64), is_local=True)
        self.out.append(Allocate(copy, not is_read))
        if is_read:
            k = self.guards.fresh("k", INT, is_shared=True)
            element = Load(view.array, plus(place, k))
            self.out.append(For(k, integer(0), integer(copy.type.size), 1, (Store(copy, k, element),)))
        return copy, place

    def _finish_call(
        self, call: Call, arguments: Sequence[Expression | View], after: Sequence[tuple[View, Array]]
    ) -> None:
        results = []
        blended: list[tuple[Variable, Variable]] = []
        callee = call.callee
        is_wide = is_wide_call(self.names, call)
        for number, result in enumerate(call.results):
            if self.mask is None or result.name not in self.names or self.is_own(result.name):
                results.append(result)
                continue
            assert isinstance(callee, Function)
            shared = not (is_wide and self.lanes.results[callee][number])
            results.append(self.guards.fresh("found", result.type, is_shared=shared))
            blended.append((result, results[-1]))
        if isinstance(callee, Function) and is_wide:
            callee = self.lanes.printed[callee]
        self.out.append(Call(callee, tuple(arguments), tuple(results)))
        for result, value in blended:
            self.out.append(Assign(result, self.blend(value, result)))
        for view, copy in after:
            k = self.guards.fresh("k", INT, is_shared=True)
            place = plus(view.offset, k)
            new = self.blend(Load(copy, k), Load(view.array, place))
            self.out.append(For(k, integer(0), integer(copy.type.size), 1, (Store(view.array, place, new),)))
