"""Plans of operations on two types: functions of two multivectors that call one compiled loop.

The order of choice is: a generated kernel for these kinds, one for the layouts of the same blades, the general
product by tables; a combination that is used much is then specialised. Plans are kept; finding one is one look-up.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..codegen.algebra.algebra import Kind
from ..codegen.algebra.mismatch import algebra_mismatch, motor_conversion
from ..codegen.execute.bound_kernels import BoundKernel
from ..codegen.execute.ranges import parallel_for
from ..codegen.execute.result_memory import MANY, STORE
from ..codegen.trace.result_kinds import belongs
from ..common.dtypes import F32, F64
from . import product_tables
from .coefficients import broadcast, embed, expand_rows, no_items
from .kernel_entries import Entry, KernelSource, Key
from .multivector_data import MultivectorData, from_buffer
from .product_tables import Table, product_table
from .specialization import Rows, operation_formula, specialize_when_hot
from .types import Type

#: Product of two multivectors of certain types.
Plan = Callable[[Any, Any], Any]
#: C loop with its kernel bound: (n, out, a, stride of a, b, stride of b).
Loop = Callable[[int, Any, Any, int, Any, int], None]

#: Plans by operation and types.
PLANS: dict[tuple[str, Type, Type], Plan] = {}
#: Kinds of products with more terms are not inferred: the layout of the product is taken.
MAX_TERMS = 4096
#: The first call of a batch multiplies this many terms at most, some 0.1 s, so that an interrupt is seen.
MOST_TERMS = 2**27
#: A general sandwich keeps this many items between its two products.
CHUNK = 4096
#: Formula of each operation.
FORMULAS = {name: f"products.{name}" for name in (*product_tables.OPERATIONS, "sandwich")}


def plan(operation: str, a: MultivectorData, b: MultivectorData) -> Plan:
    """The plan for two multivectors, cached.

    Raises
    ------
    AlgebraMismatchError
        If they belong to different algebras.
    """
    key = operation, a._type, b._type
    known = PLANS.get(key)
    if known is None:
        is_plain = a._type.backend is None and b._type.backend is None
        known = PLANS[key] = _make(*key) if is_plain else _on_arrays(operation, a, b)
    return known


def _on_arrays(operation: str, a: MultivectorData, b: MultivectorData) -> Plan:
    """The plan where an operand holds another package's array: its result has the kind of that of NumPy arrays."""
    x, y = no_items(a), no_items(b)
    backend = a._type.backend or b._type.backend
    assert backend is not None
    found: Plan = backend.product(FORMULAS[operation], plan(operation, x, y)(x, y).kind, a, b)
    return found


def _make(operation: str, a: Type, b: Type) -> Plan:
    if a.algebra is not b.algebra:
        raise algebra_mismatch(
            f"the operands belong to different algebras, {a.algebra.name} and {b.algebra.name}.", a, b.algebra,
            motor_conversion(b, a.algebra)
            or f"Convert one first: {a.algebra.name}.multivector(x), where both have the same signature",
        )  # fmt: skip
    if a.dtype != b.dtype:
        return _promoted_plan(operation)
    found = _stock(operation, a, b)
    if found is not None:
        return _by_kernel(*found, operation, a, b)
    if operation == "sandwich":
        return _sandwich_via_superkind(a, b) or _general_sandwich(a, b)
    return _general(operation, a, b)


def _by_kernel(kernels: KernelSource, entry: Entry, operation: str, a: Type, b: Type) -> Plan:
    """Plan of a generated kernel; the result has the kind that is proved for a and b, whatever the kernel knows."""
    output = entry.outputs[0].kind
    assert output is not None
    kind = _result_kind(entry, operation, a, b)
    if kind.blades == output.blades:
        return _kernel_plan(kernels.bound(entry), a.algebra.type_of(kind, a.dtype), a, b)
    return _plan_with_kind(_kernel_plan(kernels.bound(entry), a.algebra.type_of(output, a.dtype), a, b), kind)


def _plan_with_kind(wide: Plan, kind: Kind) -> Plan:
    """A plan whose results have another kind: on blades whose other coefficients vanish, or are not there."""

    def with_kind(x: Any, y: Any) -> Any:
        result = wide(x, y)
        return result._make(result.algebra.type_of(kind, result.dtype), embed(result, kind), result._lead)

    return with_kind


def _result_kind(entry: Entry, operation: str, a: Type, b: Type) -> Kind:
    """The kind of a kernel's result for two kinds that it serves."""
    output = entry.outputs[0].kind
    assert output is not None
    if entry.results is None:  # written by a generator that did not prove it
        return _proved_kind(operation, a, b) or output
    return entry.results.get((a.kind, b.kind), output)


def _proved_kind(operation: str, a: Type, b: Type) -> Kind | None:
    """The kind of the result by proof; None where nothing is known of the operands, or where they are too large."""
    if (a.kind.is_layout and b.kind.is_layout) or a.size * b.size > MAX_TERMS:
        return None
    return a.algebra.result_kind(operation_formula(operation), (a.kind, b.kind))


def _promoted_plan(operation: str) -> Plan:
    def in_double_precision(x: Any, y: Any) -> Any:
        x, y = x.astype(F64), y.astype(F64)
        return plan(operation, x, y)(x, y)

    return in_double_precision


def _sandwich_via_superkind(a: Type, b: Type) -> Plan | None:
    """A rotor is a motor: where only the motor's kernel exists, it serves what it provably holds."""
    kernels = a.algebra.stock
    entries = kernels.entries.get(FORMULAS["sandwich"], ()) if kernels else ()
    for entry in sorted(entries, key=lambda e: _size(e.inputs[0])):
        holder = entry.inputs[0]
        if isinstance(holder, int) or not holder.constraints or entry.inputs[1] not in (b.kind, b.kind.layout):
            continue
        if belongs(a.kind, holder):
            wide = a.algebra.type_of(holder, a.dtype)
            known = _make("sandwich", wide, b)
            found = _stock("sandwich", wide, b)
            assert found is not None
            kind = _result_kind(found[1], "sandwich", a, b)
            if kind != _result_kind(found[1], "sandwich", wide, b):
                known = _plan_with_kind(known, kind)
            return lambda r, x: known(r._make(wide, embed(r, wide.kind), r._lead), x)
    return None


def _size(key: Key) -> int:
    return key if isinstance(key, int) else key.size


def _stock(operation: str, a: Type, b: Type) -> tuple[KernelSource, Entry] | None:
    """The generated kernel for the kinds as they are, else for their layouts."""
    kernels = a.algebra.stock
    if kernels is None:
        return None
    entries = {entry.inputs: entry for entry in kernels.entries.get(FORMULAS[operation], ())}
    for first in (a.kind, a.kind.layout):
        for second in (b.kind, b.kind.layout):
            if (first, second) in entries:
                return kernels, entries[first, second]
    return None


# -- plans of compiled loops -------------------------------------------------------------------------------


def _kernel_plan(kernel: Any, out: Type, a: Type, b: Type) -> Plan:
    """Plan of a generated kernel, with a short path for two single items, which store their buffers' pointers."""

    def rows(result: NDArray[Any], x: NDArray[Any], y: NDArray[Any], n: int) -> None:
        kernel.run([x, y], [result], n)

    batch = _batch_plan(rows, out)
    if not isinstance(kernel, BoundKernel) or not kernel.provide(bool(out.single)):
        return batch
    run, index, precision = kernel.library.lib.bs_run2, kernel.index, out.single
    result_class: Any = out.algebra.multivector_class
    new, empty, buffer = result_class.__new__, np.empty, from_buffer
    size, size_a, size_b = out.size, a.size, b.size

    def single(x: Any, y: Any) -> Any:
        if x._lead or y._lead:
            return batch(x, y)
        data = empty(size, F32) if precision else empty(size)
        result = new(result_class)
        result._type = out
        result._data = data
        result._lead = ()
        result._status = None
        result._pointer = pointer = buffer(data)
        run(index, precision, 1, pointer, x._pointer or x._point(), size_a, y._pointer or y._point(), size_b)
        return result

    return single


def _batch_plan(rows: Rows, out: Type) -> Plan:
    """Plan over broadcast leading dimensions."""
    make = out.algebra.multivector_class._make

    def batch(a: Any, b: Any) -> Any:
        lead = a._lead if a._lead == b._lead else broadcast(a, b)
        n = math.prod(lead)
        data = (np.empty if n < MANY else STORE.empty)((*lead, out.size), out.dtype)
        if n:
            rows(data, expand_rows(a, lead), expand_rows(b, lead), n)
        return make(out, data, lead)

    return batch


# -- the general product -----------------------------------------------------------------------------------


def _general(operation: str, a: Type, b: Type) -> Plan:
    algebra = a.algebra
    kind = _proved_kind(operation, a, b)
    table = product_table(algebra, operation, a.blades, b.blades, kind.blades if kind else ())
    out = algebra.type_of(kind or algebra.layout_of(table.blades), a.dtype)
    rows = specialize_when_hot(table_rows(table, out.single), (operation, a, b), out, table.terms)
    batch = _batch_plan(rows, out)
    loop = _table_loop(table, out.single)
    return batch if loop is None else _table_plan(loop, batch, out, a.size, b.size)


def _table_plan(loop: Loop, batch: Plan, out: Type, size_a: int, size_b: int) -> Plan:
    """Short path for two single items, for a loop over tables."""
    make = out.algebra.multivector_class._make

    def single(x: Any, y: Any) -> Any:
        if x._lead or y._lead:
            return batch(x, y)
        result = make(out, np.empty(out.size, out.dtype), ())
        loop(1, result._point(), x._pointer or x._point(), size_a, y._pointer or y._point(), size_b)
        return result

    return single


def _table_loop(table: Table, single: int) -> Loop | None:
    """The compiled loop over a table, bound to it."""
    module = product_tables.library()
    return None if module is None else partial(module.lib.bs_multiply, table.pointer, single, 0)


def table_rows(table: Table, single: int) -> Rows:
    """Rows by a table: compiled and shared over threads, or NumPy."""
    module = product_tables.library()
    if module is None:

        def with_numpy(out: NDArray[Any], x: NDArray[Any], y: NDArray[Any], n: int) -> None:
            size_a, size_b = table.sizes
            table.multiply(out.reshape(n, -1), x.reshape(-1, size_a), y.reshape(-1, size_b))

        return with_numpy
    multiply, product = module.lib.bs_multiply, table.pointer
    step = max(1, MOST_TERMS // max(1, table.terms))

    def rows(out: NDArray[Any], x: NDArray[Any], y: NDArray[Any], n: int) -> None:
        size_a, size_b = table.sizes
        pointers = from_buffer(out), from_buffer(x), from_buffer(y)
        stride_a, stride_b = (size_a if x.size > size_a else 0), (size_b if y.size > size_b else 0)

        def part(begin: int, end: int) -> None:
            # sizes of operands and result differ, so the loop takes the first row and the range
            multiply(product, single, begin, end, pointers[0], pointers[1], stride_a, pointers[2], stride_b)

        parallel_for(part, n, step)

    return rows


def _general_sandwich(a: Type, b: Type) -> Plan:
    """R x ~R by two tables. Coefficients that vanish for members of the kinds are left out."""
    algebra = a.algebra
    inner = product_table(algebra, "geometric", a.blades, b.blades)
    kind = _sandwich_kind(a, b, inner)
    outer = product_table(algebra, "reversed", inner.blades, a.blades, kind.blades)
    out = algebra.type_of(kind, a.dtype)
    first, second = table_rows(inner, out.single), table_rows(outer, out.single)

    def rows(result: NDArray[Any], r: NDArray[Any], x: NDArray[Any], n: int) -> None:
        result, r, x = result.reshape(n, -1), r.reshape(-1, a.size), x.reshape(-1, b.size)
        middle = np.empty((min(n, CHUNK), len(inner.blades)), out.dtype)
        for begin in range(0, n, CHUNK):
            end = min(begin + CHUNK, n)
            part_r, part_x = (m if len(m) == 1 else m[begin:end] for m in (r, x))
            first(middle[: end - begin], part_r, part_x, end - begin)
            second(result[begin:end], middle[: end - begin], part_r, end - begin)

    batch = _batch_plan(specialize_when_hot(rows, ("sandwich", a, b), out, inner.terms + outer.terms), out)
    loops = _table_loop(inner, out.single), _table_loop(outer, out.single)
    if loops[0] is None or loops[1] is None:
        return batch
    left, right = loops[0], loops[1]
    size = len(inner.blades)

    def loop(n: int, result: Any, r: Any, size_r: int, x: Any, size_x: int) -> None:
        middle = from_buffer(np.empty(size, out.dtype))
        left(n, middle, r, size_r, x, size_x)
        right(n, result, middle, size, r, size_r)

    return _table_plan(loop, batch, out, a.size, b.size)


def _sandwich_kind(a: Type, b: Type, inner: Table) -> Kind:
    algebra = a.algebra
    if inner.terms <= MAX_TERMS and len(inner.blades) * a.size <= MAX_TERMS:
        return algebra.result_kind(operation_formula("sandwich"), (a.kind, b.kind))
    outer = product_table(algebra, "reversed", inner.blades, a.blades)
    signs = {blade.bit_count() & 2 for blade in b.blades}
    # x = +-~x makes R x ~R = +-~(R x ~R), so grades of the other sign cancel exactly
    kept = [blade for blade in outer.blades if len(signs) > 1 or blade.bit_count() & 2 in signs]
    return algebra.layout_of(kept or (0,))
