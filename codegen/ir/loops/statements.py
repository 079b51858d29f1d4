"""Reading statements of algorithms: blocks, branches, loops, and what is defined behind them."""

from __future__ import annotations

import ast
from collections.abc import Sequence
from typing import Any

from . import language
from .assignments import Loop
from .calls import CallReader
from .elements import LIMIT
from .nodes import (
    Break,
    Constant,
    Continue,
    Expression,
    For,
    If,
    Load,
    Return,
    Statement,
    Variable,
    View,
    While,
    integer,
    parts,
)  # fmt: skip
from .scope import Meaning, Static, bound_names, items_of
from .types import BOOL, INT, Scalar

_STATEMENTS = "There are assignments, for ... in range(...), while, if, break, continue, return and calls."


class StatementReader(CallReader):
    """Turns the body of a function into IR."""

    def read(self) -> tuple[Statement, ...]:
        """The body."""
        self._statements(self.text.tree.body)
        if self.is_live and self.results:
            self.refuse(self.text.tree, "not every path returns a value", "End it with a return.")
        self.results = self.results or ()
        return tuple(self.blocks[0])

    # -- blocks --------------------------------------------------------------------------------------------------

    def _statements(self, statements: Sequence[ast.stmt]) -> None:
        for each in statements:
            if not self.is_live:
                if self.was_decided:
                    return
                self.refuse(each, "a line that is never reached", "Leave it out.")
            self._statement(each)

    def _reach(self, is_live: bool = True) -> None:
        """What follows can be reached, or not, whatever the block before decided."""
        self.is_live, self.was_decided = is_live, False

    def block(self, statements: Sequence[ast.stmt]) -> tuple[Statement, ...]:
        self.blocks.append([])
        self._statements(statements)
        return tuple(self.blocks.pop())

    def _statement(self, node: ast.stmt) -> None:
        match node:
            case ast.Expr(ast.Constant(str())) | ast.Pass():
                pass
            case ast.Expr(ast.Call() as call):
                self.call_statement(call, [])
            case ast.Assign([target], value):
                self._assign(node, target, value)
            case ast.Assign():
                self.assign_to_each(node, node.targets, node.value)
            case ast.AnnAssign(ast.Name(name), annotation, value) if value is not None:
                declared = self.text.annotation(annotation).type
                if not isinstance(declared, Scalar):
                    self.refuse(node, "a type of an array", "zeros(...) and empty(...) say it.")
                self._assign_number(node, name, self.expression(value, declared))
            case ast.AugAssign():
                self._assign_augmented(node)
            case ast.For():
                self._for(node)
            case ast.While():
                self._while(node)
            case ast.If():
                self._if(node)
            case ast.Return():
                self._return(node)
            case ast.Break() | ast.Continue():
                self._jump(node)
            case _:
                self.refuse(node, "a statement that is not in the language", _STATEMENTS)

    def _assign(self, node: ast.stmt, target: ast.expr, value: ast.expr) -> None:
        if isinstance(value, ast.Call) and self.is_call_statement(value):
            self.call_statement(value, target.elts if isinstance(target, ast.Tuple) else [target])
        elif isinstance(target, ast.Tuple):
            self.assign_several(node, target, self.meaning(value))
        elif isinstance(value, ast.Call) and self.is_allocation(value):
            self.allocate(node, target, value)
        else:
            self.assign_one(node, target, self.meaning(value))

    def _assign_augmented(self, node: ast.AugAssign) -> None:
        as_load = ast.parse(ast.unparse(node.target), mode="eval").body
        for part in ast.walk(as_load):
            ast.copy_location(part, node)
        value = ast.copy_location(ast.BinOp(as_load, node.op, node.value), node)
        self.assign_one(node, node.target, self.meaning(value))

    def _if(self, node: ast.If) -> None:
        condition = self.condition(node.test)
        if isinstance(condition, Static):
            self._statements(node.body if condition.value else node.orelse)
            self.was_decided = not self.is_live
            return
        before = self.scope.branch()
        yes, reached_yes = self._branch(node.body)
        self.scope.defined = before
        no, reached_no = self._branch(node.orelse)
        self.scope.join(reached_yes, reached_no)
        self._reach(reached_yes is not None or reached_no is not None)
        self.emit(If(self.number(node.test, condition), yes, no))

    def _branch(self, statements: Sequence[ast.stmt]) -> tuple[tuple[Statement, ...], dict[str, Any] | None]:
        self.scope.defined = dict(self.scope.defined)
        body = self.block(statements)
        reached = self.scope.branch() if self.is_live else None
        self._reach()
        return body, reached

    def _for(self, node: ast.For) -> None:
        if node.orelse:
            self.refuse(node, "for ... else", "Use a variable.")
        items: Meaning | None = None
        callee = None
        if isinstance(node.iter, ast.Call):
            callee = self.callee_of(node.iter)
            items = self._steps(node.iter) if callee is language.unrolled else None
            if items is None and callee in (range, language.unrolled):
                self._range(node, node.iter, is_unrolled=callee is language.unrolled)
                return
        items = items or self.meaning(node.iter)
        if not isinstance(items, Static) or not isinstance(items.value, (tuple, range)):
            self.refuse(node, "a loop over what is not a range or a static tuple", "Write for i in range(n).")
        self.loops.append(Loop(None, is_unrolled=True))
        for item in items.value:  # one copy of the body for each
            if not self.is_live:
                break
            self._bind_static(node, node.target, item)
            self._statements(node.body)
        self.loops.pop()
        if callee is language.unrolled and isinstance(node.target, ast.Name):  # as of a range: no meaning behind it
            self.scope.defined.pop(node.target.id, None)
            self.scope.types.pop(node.target.id, None)

    def _steps(self, call: ast.Call) -> Static | None:
        """The steps of an `unrolled` loop that is written out; None: there are too many, or they are not known."""
        bounds = [self.meaning(a) for a in call.args]
        if call.keywords or not all(isinstance(b, Static) and isinstance(b.value, int) for b in bounds):
            return None
        steps = self._fold(call, range, *(b.value for b in bounds if isinstance(b, Static)))
        return steps if len(steps.value) <= language.MOST_UNROLLED else None

    def _bind_static(self, node: ast.For, target: ast.expr, item: Any) -> None:
        if isinstance(target, ast.Name):
            self.scope.types.pop(target.id, None)
            self.scope.bind(target.id, Static(item))
        elif isinstance(target, ast.Tuple) and isinstance(item, tuple) and len(item) == len(target.elts):
            for each, value in zip(target.elts, item, strict=True):
                self._bind_static(node, each, value)
        else:
            self.refuse(node, f"{ast.unparse(target)} does not fit the static value {item!r}", "Name each part.")

    def _range(self, node: ast.For, call: ast.Call, is_unrolled: bool) -> None:
        if not isinstance(node.target, ast.Name):
            self.refuse(node, "a range has one variable", "Write for i in range(n).")
        name = node.target.id
        if not 1 <= len(call.args) <= 3 or call.keywords:
            self.refuse(node, "range() takes one to three integers", "Write range(n) or range(a, b, step).")
        bounds = [self.expression(a, INT) for a in call.args[:2]]
        start, stop = (integer(0), bounds[0]) if len(bounds) == 1 else bounds
        step = self.static(call.args[2], "the step of a range") if len(call.args) == 3 else 1
        if not isinstance(step, int) or step == 0 or abs(step) >= LIMIT:
            self.refuse(node, f"a range with the step {step!r}", "Use a static integer, not 0.")
        known = self.scope.types.get(name)
        if name in self.scope.defined or (known is not None and known != Variable(name, INT)):
            self.refuse(node, f"{name} counts a loop and is something else before it", "Use another name.")
        changed = self._changed_names(node)
        if not isinstance(stop, Constant) and any(
            isinstance(p, (Variable, Load)) and (isinstance(p, Load) or p.name in changed) for p in parts(stop)
        ):
            stop = self.named(stop)  # Python computes it once
        variable = Variable(name, INT)
        self.loops.append(Loop(name, is_unrolled))
        before = self._enter_loop(changed)
        self.scope.bind(name, variable)
        body = self.block(node.body)
        self._reach()
        self.loops.pop()
        self.scope.defined = before
        self.emit(For(variable, start, stop, step, body, self.text.place(node)))

    def _changed_names(self, node: ast.AST) -> set[str]:
        return set(bound_names(node))

    def _enter_loop(self, changed: set[str]) -> dict[str, Any]:
        """What is defined at each iteration and behind the loop: not what would mean two things there."""
        for name in changed & set(self.scope.defined):
            binding = self.scope.defined[name]
            moves = isinstance(binding, View) and isinstance(binding.offset, Variable)
            if not isinstance(binding, Variable) and not moves:
                del self.scope.defined[name]
        return self.scope.branch()

    def _while(self, node: ast.While) -> None:
        if node.orelse:
            self.refuse(node, "while ... else", "Use a variable.")
        outside = self.scope.branch()
        before = self._enter_loop(self._changed_names(node))
        self.guards += 1  # it is computed again and again
        condition = self.condition(node.test)
        self.guards -= 1
        if isinstance(condition, Static) and not condition.value:
            self.scope.defined = outside
            return
        self.loops.append(Loop(None))
        body = self.block(node.body)
        loop = self.loops.pop()
        self.scope.defined = before
        is_endless = isinstance(condition, Static)
        if is_endless:
            self.scope.join(*loop.leaves)
        self._reach(bool(loop.leaves) if is_endless else True)
        value = Constant(True, BOOL) if isinstance(condition, Static) else self.number(node.test, condition)
        self.emit(While(value, body, self.text.place(node)))

    def _jump(self, node: ast.Break | ast.Continue) -> None:
        if not self.loops or self.loops[-1].is_unrolled:
            self.refuse(
                node, "break or continue outside of a loop that runs", "Loops over tuples and unrolled are written out."
            )
        if isinstance(node, ast.Break):
            self.loops[-1].leaves.append(self.scope.branch())
        self.emit(Break() if isinstance(node, ast.Break) else Continue())
        self.is_live = False

    def _return(self, node: ast.Return) -> None:
        values: tuple[Expression, ...] = ()
        if node.value is not None and not (isinstance(node.value, ast.Constant) and node.value.value is None):
            if isinstance(node.value, ast.Call) and self.is_call_statement(node.value):
                callee = self.called(node.value)
                if hasattr(callee, "kernel_signature"):
                    self.refuse(node, "a kernel's result is returned at once", "Give it a name first.")
                values = self.call_algorithm(node.value, callee, None)
            else:
                found = self.meaning(node.value)
                items = items_of(found)
                items = (found,) if items is None else items
                if any(isinstance(i, View) for i in items):
                    self.refuse(node, "an array is returned", "Write it into a parameter: Out[...].")
                values = tuple(self.number(node, i) for i in items)
        types = tuple(v.type for v in values)
        if self.results is None:
            self.results = types
        elif len(types) != len(self.results):
            here, elsewhere = len(types), len(self.results)
            self.refuse(node, f"{here} values are returned here, {elsewhere} elsewhere", "Return as many.")
        else:
            values = tuple(self.converted(node, v, t) for v, t in zip(values, self.results, strict=True))
        self.emit(Return(values))
        self.is_live = False
