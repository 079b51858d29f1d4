"""Formulas by name on multivectors and arrays: the generated kernel that fits, or the formula traced on the spot.

A formula that no stock kernel serves is run with NumPy on its expression graph: no compiler starts at a prompt.
Used much, it is compiled once.
"""

from __future__ import annotations

import logging
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..codegen.algebra.algebra import Kind, numbers, scalar_argument
from ..codegen.algebra.mismatch import algebra_mismatch
from ..codegen.errors import BladesmithError, GradeError, ShapeError, TraceError
from ..codegen.execute.arrays import READY
from ..codegen.trace.result_kinds import belongs
from ..common.dtypes import F64, common_precision
from ..common.validation import real_array
from .arrays.backends import backend_of
from .coefficients import embed
from .item_plans import NO_PLAN, ItemPlan, NoPlan, make_plan
from .kernel_entries import Entry, Key, Result
from .multivector_data import MultivectorData, from_buffer
from .types import TypedAlgebra

#: Items of a formula after which it is compiled: NumPy takes some microseconds for each, the compiler half a second.
WORTH_COMPILING = 100_000
#: What single items are given as.
PLAIN = frozenset((tuple, list, float, int))
_log = logging.getLogger("bladesmith")


class ArrayOperand(NamedTuple):
    """A plain operand, with its name in errors.

    ``key`` is 0 for one number per item, k for a row of k numbers, or a kind whose coefficients the rows are.
    """

    value: ArrayLike
    key: Key
    name: str

    def rows(self) -> NDArray[Any]:
        """The checked array."""
        count = self.key if isinstance(self.key, int) else self.key.size
        return real_array(self.value, self.name, (..., count) if count else None)


#: Operands of single items; plain numbers may be an array alone.
ItemOperand: TypeAlias = MultivectorData | ArrayOperand | NDArray[Any]


@dataclass(frozen=True)
class ResolvedKernel:
    """Function that evaluates a formula for operands of some kinds."""

    inputs: tuple[Key, ...]
    outputs: tuple[Result, ...]
    run: Callable[..., Any]


class FormulaResult(NamedTuple):
    """Results of a formula: multivectors and arrays in the formula's order, and the status of each item."""

    values: tuple[Any, ...]
    status: NDArray[np.uint8] | None

    @property
    def value(self) -> Any:
        """The first result."""
        return self.values[0]


def evaluate(algebra: TypedAlgebra, formula: str, *operands: MultivectorData | ArrayOperand) -> FormulaResult:
    """Run ``module.function`` of `codegen.formulas`.

    Raises
    ------
    AlgebraMismatchError
        If an operand belongs to another algebra.
    GradeError
        If the formula means nothing for operands on these blades.
    """
    return evaluate_item(algebra, formula, operands) or evaluate_batch(algebra, formula, *operands)


def evaluate_batch(algebra: TypedAlgebra, formula: str, *operands: MultivectorData | ArrayOperand) -> FormulaResult:
    """`evaluate` for what `evaluate_item` and `item_value` leave: batches, and single items that are not as usual."""
    for x in operands:
        if not isinstance(x, ArrayOperand) and x.algebra is not algebra:
            raise algebra_mismatch(
                f"{x.algebra.name} is not {algebra.name}.", x._type, algebra, "Convert the operand first"
            )
    for x in operands:
        backend = backend_of(x.value) if isinstance(x, ArrayOperand) else x._type.backend
        if backend is not None:
            found_on_arrays: FormulaResult = backend.evaluate(algebra, formula, operands)
            return found_on_arrays
    keys = tuple(x.key if isinstance(x, ArrayOperand) else x.kind for x in operands)
    found = resolve_kernel(algebra, formula, keys)
    given = [
        x.rows() if isinstance(x, ArrayOperand) else embed(x, key) if isinstance(key, Kind) else x._data
        for x, key in zip(operands, found.inputs, strict=True)
    ]
    own = [x.value if isinstance(x, ArrayOperand) else data for x, data in zip(operands, given, strict=True)]
    dtype = common_precision(*own)
    try:
        results = found.run(*(data if data.dtype == dtype else data.astype(dtype) for data in given))
    except ShapeError:
        _check_batches(algebra, formula, operands)
        raise
    items = results if isinstance(results, tuple) else (results,)
    code = next((v for v, o in zip(items, found.outputs, strict=True) if o.is_status), None)
    values = tuple(_value(algebra, v, o, code) for v, o in zip(items, found.outputs, strict=True) if not o.is_status)
    return FormulaResult(values, code)


def _check_batches(
    algebra: TypedAlgebra, formula: str, operands: Sequence[MultivectorData | ArrayOperand]
) -> None:
    """Raise if the operands' batches do not broadcast, with their names and shapes as the user gave them."""
    shapes = [np.shape(x.value) if isinstance(x, ArrayOperand) else x.shape for x in operands]
    leads = [s[:-1] if isinstance(x, ArrayOperand) and x.key else s for x, s in zip(operands, shapes, strict=True)]
    try:
        np.broadcast_shapes(*leads)
    except ValueError:
        names = [x.name if isinstance(x, ArrayOperand) else f"the {x.kind.name}" for x in operands]
        given = ", ".join(f"{name} {shape}" for name, shape in zip(names, shapes, strict=True))
        raise ShapeError(
            f"the shapes of its arguments do not broadcast: {given}.",
            where=f"{algebra.name}, {formula.rpartition('.')[2]}", remedy="Insert axes with a[:, None]",
        ) from None  # fmt: skip


def evaluate_item(algebra: TypedAlgebra, formula: str, operands: Sequence[ItemOperand]) -> FormulaResult | None:
    """`evaluate` for single items in double precision, all finite and OK; None where anything is not as usual."""
    plan, pointers = item_plan(algebra, formula, operands)
    values = plan.values(pointers)
    return None if values is None else FormulaResult(tuple(values), plan.status)


def item_value(algebra: TypedAlgebra, formula: str, operands: Sequence[ItemOperand]) -> Any:
    """The first result of `evaluate_item`, a multivector."""
    plan, pointers = item_plan(algebra, formula, operands)
    return plan.value(pointers)


def item_plan(
    algebra: TypedAlgebra, formula: str, operands: Sequence[ItemOperand]
) -> tuple[ItemPlan | NoPlan, Sequence[Any]]:
    """The plan for single operands in double precision, and their pointers; no plan for any others."""
    signature: list[Any] = [formula]
    pointers: list[Any] = []
    for x in operands:
        array: Any = x[0] if x.__class__ is ArrayOperand else x
        if array.__class__ in PLAIN:
            array = np.array(array)
            if array.dtype.kind == "i":
                array = array.astype(F64)
        if array.__class__ is np.ndarray:
            if array.dtype is not F64 or array.flags.num & READY != READY:
                return NO_PLAN, ()
            signature.append(array.shape)
            pointers.append(from_buffer(array))
        elif isinstance(array, MultivectorData) and not array._lead and array._type.backend is None:
            signature.append(array._type)
            pointers.append(array._pointer or array._point())
        else:
            return NO_PLAN, ()
    key = tuple(signature)
    plan = algebra.item_plans.get(key)
    if plan is None:
        plan = algebra.item_plans[key] = _find_item_plan(algebra, formula, key[1:], operands) or NO_PLAN
    return plan, pointers


def _find_item_plan(
    algebra: TypedAlgebra, formula: str, signature: Sequence[Any], operands: Sequence[ItemOperand]
) -> ItemPlan | None:
    """The plan of single items; None where their blades or shapes are not those of a compiled kernel."""
    keys: list[Key] = []
    for own, x in zip(signature, operands, strict=True):
        if isinstance(x, ArrayOperand):
            count = x.key if isinstance(x.key, int) else x.key.size
            if own != ((count,) if count else ()):
                return None
            keys.append(x.key)
        elif isinstance(x, np.ndarray):
            if len(own) > 1:
                return None
            keys.append(own[0] if own else 0)
        elif x.algebra is not algebra or own.dtype != F64:
            return None
        else:
            keys.append(own.kind)
    found = resolve_kernel(algebra, formula, tuple(keys))
    for key, wanted in zip(keys, found.inputs, strict=True):
        if isinstance(key, Kind) and isinstance(wanted, Kind) and key.blades != wanted.blades:
            return None
    return make_plan(algebra, found.run, found.inputs, found.outputs)


def _value(algebra: TypedAlgebra, data: NDArray[Any], result: Result, code: NDArray[np.uint8] | None) -> Any:
    if result.kind is None:
        return data
    return algebra.multivector_class._make(algebra.type_of(result.kind, data.dtype), data, data.shape[:-1], code)


def resolve_kernel(algebra: TypedAlgebra, formula: str, keys: tuple[Key, ...]) -> ResolvedKernel:
    """Function that evaluates a formula for operands of these keys; cached."""
    known = algebra.targets.get((formula, keys))
    if known is None:
        known = _find_stock_kernel(algebra, formula, keys) or _trace_formula(algebra, formula, keys)
        algebra.targets[formula, keys] = known
    return known


def _find_stock_kernel(algebra: TypedAlgebra, formula: str, keys: tuple[Key, ...]) -> ResolvedKernel | None:
    """The stock kernel that loses least: the kinds themselves, their layouts, then kinds that hold them."""
    if algebra.stock is None:
        return None
    entries = algebra.stock.entries.get(formula, ())
    costs = [(cost, entry) for entry in entries if (cost := _cost(entry, keys)) is not None]
    if not costs:
        return None
    entry = min(costs, key=lambda pair: pair[0])[1]
    return ResolvedKernel(entry.inputs, entry.outputs, algebra.stock.bound(entry))


def _cost(entry: Entry, keys: Sequence[Key]) -> int | None:
    """0 for the same kinds, more for knowing less or carrying zeros; None where an operand does not fit."""
    if len(entry.inputs) != len(keys):
        return None
    total = 0
    for wanted, given in zip(entry.inputs, keys, strict=True):
        if isinstance(wanted, int) or isinstance(given, int):
            if wanted != given:
                return None
        elif wanted == given:
            continue
        elif belongs(given, wanted):
            total += 2 * (wanted.size - given.size) + int(wanted.is_layout)
        else:
            return None
    return total


def _trace_formula(algebra: TypedAlgebra, formula: str, keys: tuple[Key, ...]) -> ResolvedKernel:
    """The formula traced for these kinds, or for their layouts where it repairs what a kind already has."""
    from ..codegen.api import KernelFunction
    from ..codegen.declarations import formula_by_name

    function = formula_by_name(formula)
    name = formula.rpartition(".")[2]
    problem: BladesmithError | None = None
    for kinds in dict.fromkeys((_kinds(algebra, keys), _kinds(algebra, keys, layouts=True))):
        # printed as written: a search takes up to a second, which is for kernels that are declared
        kernel = KernelFunction(function, kinds, None, name, algebra, search=False)
        try:
            outputs = tuple(_result(o) for o in kernel.traced.outputs)
        except (TraceError, GradeError, ZeroDivisionError) as error:
            problem = problem or (error if isinstance(error, BladesmithError) else TraceError(str(error)))
            continue
        inputs = tuple(key if isinstance(key, int) else kind for key, kind in zip(keys, kinds, strict=True))
        return ResolvedKernel(inputs, outputs, TieredKernel(kernel))
    what = " and ".join(f"a {key.name}" for key in keys if isinstance(key, Kind))
    raise GradeError(f"{name} of {what} of {algebra.name}: {problem}")


def _kinds(algebra: TypedAlgebra, keys: Sequence[Key], layouts: bool = False) -> tuple[Kind, ...]:
    return tuple(
        (key.layout if layouts else key)
        if isinstance(key, Kind)
        else numbers(algebra, key)
        if key
        else scalar_argument(algebra)
        for key in keys
    )


def _result(output: Any) -> Result:
    if output.role == "status":
        return Result(output.name, None, 1, True)
    kind = output.kind if output.kind.form == "multivector" else None
    return Result(output.name, kind, len(output.nodes))


class TieredKernel:
    """A declared kernel on arrays: interpreted, and compiled once `WORTH_COMPILING` items went through it."""

    def __init__(self, kernel: Any) -> None:
        self.kernel = kernel
        self.items = 0
        self.is_hot = False

    def __call__(self, *data: NDArray[Any]) -> Any:
        return self.ready(max((math.prod(a.shape[:-1]) for a in data), default=1), data)(*data)

    def ready(self, items: int, data: Sequence[NDArray[Any]]) -> Any:
        """Kernel for this many more items, in the precision of the arrays."""
        self.items += items
        if self.items > WORTH_COMPILING and not self.is_hot:
            self.is_hot = True
            _log.info("compiling %r after %d items.", self.kernel, self.items)
        return self.kernel.bound("c" if self.is_hot else "numpy", data)


__all__ = [
    "ArrayOperand",
    "FormulaResult",
    "evaluate",
    "evaluate_batch",
    "evaluate_item",
    "item_value",
    "resolve_kernel",
]
