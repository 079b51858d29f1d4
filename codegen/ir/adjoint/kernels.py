"""Cotangents of calls of kernels: what their inputs get is computed by the kernel of the formula's pullback."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from ...errors import AlgorithmError
from ..graph import reachable
from ..loops.nodes import (
    Allocate,
    Array,
    Assign,
    Binary,
    Call,
    For,
    If,
    KernelSignature,
    Load,
    Statement,
    Store,
    Variable,
    View,
    boolean,
    integer,
    plus,
    real,
)  # fmt: skip
from ..loops.scope import fresh_name
from ..loops.types import BOOL, INT, REAL, ArrayType
from .partials import Cotangents
from .statements import fill


class KernelCalls:
    """Calls of kernels in one text.

    Parameters
    ----------
    cotangents : Cotangents
    where : str
        Of the algorithm, for errors.
    """

    def __init__(self, cotangents: Cotangents, where: str) -> None:
        self.cotangents, self.where = cotangents, where
        self.rows: list[Allocate] = []  # cotangents of inputs of kernels; of results that have none, zeros

    def spread(self, call: Call, visible: set[str]) -> tuple[list[Statement], set[str]]:
        """Statements that add to the cotangents of a kernel's inputs, and the arrays whose values they need.

        Nothing is called where all cotangents are zero: partial derivatives may be NaN then.
        """
        kernel = call.callee
        assert isinstance(kernel, KernelSignature)
        count = len(kernel.outputs)
        views = [a for a in call.arguments if isinstance(a, View)]
        results, inputs = views[:count], views[count:]
        active = [v for v in results if v.array.name in visible]
        varying = [v.array.name in visible and not v.is_still for v in inputs]
        names = tuple(n for (n, _), varies in zip(kernel.inputs, varying, strict=True) if varies)
        if not active or not names:
            return self._zeros(active), set()
        derived: KernelSignature = kernel.kernel.pullback_signature(names)
        given = [v for v, is_value in zip(results, kernel.are_values, strict=True) if is_value]
        rows = [self._row(v.type.size) for v, varies in zip(inputs, varying, strict=True) if varies]
        if [n for _, n in derived.outputs] != [v.type.size for v in rows]:
            raise AlgorithmError(
                f"the pullback of the kernel {kernel.symbol} has other blades than {', '.join(names)}",
                where=self.where, remedy="Declare the arguments by layouts, or use derivative(...)",
            )  # fmt: skip
        weights = [self._view(v) if v.array.name in visible else self._row(v.type.size, True) for v in given]
        targets = [self._view(v) for v, varies in zip(inputs, varying, strict=True) if varies]
        added = [self._added(target, row) for target, row in zip(targets, rows, strict=True)]
        asked, body = self._any([self._view(v) for v in given if v in active])
        call = Call(derived, (*rows, *inputs, *weights), ())
        body.append(If(asked, (call, *self._zeros([v for v in active if v in given]), *added)))
        body += self._zeros([v for v in active if v not in given])
        home = derived.kernel
        read = {node.data[0] for node in reachable(home.forms) if node.op == "var"}
        return body, {v.array.name for k, v in enumerate(inputs) if k in read}

    def _zeros(self, results: Sequence[View]) -> list[Statement]:
        """What makes the cotangents of some results zero."""
        return [s for v in results for s in fill(self._view(v), v.type.size, self.cotangents.taken)]

    def _any(self, weights: Sequence[View]) -> tuple[Variable, list[Statement]]:
        """Whether any cotangent is not zero."""
        found = Variable(fresh_name("any_share", self.cotangents.taken), BOOL)
        body: list[Statement] = [Assign(found, boolean(False))]
        for v in weights:
            k = Variable(fresh_name("k", self.cotangents.taken), INT)
            differs = Binary("!=", Load(v.array, plus(v.offset, k)), real(0.0), BOOL)
            one = Assign(found, Binary("or", found, differs, BOOL))
            body.append(For(k, integer(0), integer(v.type.size), 1, (one,)))
        return found, body

    def _view(self, view: View) -> View:
        return replace(view, array=self.cotangents.array(view.array), is_still=False)

    def _row(self, size: int, is_zero: bool = False) -> View:
        """Room for the cotangents of one input of a kernel; or zeros."""
        array = Array(fresh_name("row", self.cotangents.taken), ArrayType(REAL, (size,)), is_local=True)
        self.rows.append(Allocate(array, is_zero))
        return View(array, integer(0), array.type)

    def _added(self, target: View, row: View) -> Statement:
        k = Variable(fresh_name("k", self.cotangents.taken), INT)
        place = plus(target.offset, k)
        total = Binary("+", Load(target.array, place), Load(row.array, k), REAL)
        return For(k, integer(0), integer(row.type.size), 1, (Store(target.array, place, total),))
