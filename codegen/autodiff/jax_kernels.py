"""Kernels as functions of JAX arrays: one primitive, with rules for jit, vmap, and derivatives of any order.

Inside, an operand is a table of rows (n, size), or one row (size,) that all items share. A result is a table where an
operand is, or the sum over the items. Forward derivatives are kernels of tangents, reverse ones kernels of cotangents:
both are kernels, so that the primitive is its own derivative.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache, partial
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax.extend.core import Primitive
from jax.interpreters import ad, batching, mlir

from ..errors import InputError, one_line
from ..execute.arrays import broadcast_leads
from ..status import Status
from .calls import Call, call_of, positional, rows_of, run, shaped, shapes, tables
from .jax_calls import TARGET, key_of

_primitive = Primitive("bladesmith_kernel")
_primitive.multiple_results = True


def _bind(call: Call, operands: Sequence[Any]) -> list[Any]:
    return list(_primitive.bind(*operands, call=call))


def _abstract(*operands: Any, call: Call) -> list[Any]:
    return [jax.core.ShapedArray(shape, dtype) for shape, dtype in shapes(call, operands)]


@cache
def _compiled(call: Call) -> Callable[..., Any]:
    function: Callable[..., Any] = jax.jit(partial(_primitive.bind, call=call))
    return function


def _run(*operands: Any, call: Call) -> Any:
    return _compiled(call)(*operands)


_primitive.def_abstract_eval(_abstract)
_primitive.def_impl(_run)


# -- on the host ----------------------------------------------------------------------------------------------------


def _lower(context: Any, *operands: Any, call: Call) -> Any:
    """A call through the foreign-function interface; of Python where the kernel is not compiled."""
    avals = context.avals_in
    kernel = call.kernel.bound("c", [np.empty(0, a.dtype) for a in avals])
    key = key_of(kernel, avals[0].dtype == np.float32)
    if key is not None:
        return jax.ffi.ffi_lowering(TARGET)(context, *operands, kernel=np.int64(key))
    return mlir.lower_fun(partial(_call_back, call, kernel), multiple_results=True)(context, *operands)


def _call_back(call: Call, kernel: Any, *operands: Any) -> Any:
    results = [jax.ShapeDtypeStruct(*each) for each in shapes(call, operands)]

    return jax.pure_callback(partial(run, call, kernel), results, *operands)


def _refuse(context: Any, *operands: Any, call: Call) -> Any:
    raise InputError(
        f"{call.kernel.name}: kernels are called on the CPU, and these arrays are on another device",
        remedy='Move them: jax.device_put(x, jax.devices("cpu")[0])',
    )


mlir.register_lowering(_primitive, _refuse)
mlir.register_lowering(_primitive, _lower, platform="cpu")


# -- derivatives ----------------------------------------------------------------------------------------------------


def _jvp(primals: Sequence[Any], tangents: Sequence[Any], *, call: Call) -> Any:
    """Values, and the tangents' kernel: linear in the directions."""
    values = _bind(call, primals)
    places = [i for i, t in enumerate(tangents) if type(t) is not ad.Zero]
    names = tuple(call.kernel.arguments[i] for i in places)
    roles = [o.role for o in call.kernel.outputs]
    summed = tuple(s for s, role in zip(call.is_summed, roles, strict=True) if role != "status")
    along = Call(call.kernel.along(names, within=True), summed, (call.kernel, names))
    found = _bind(along, [*primals, *(tangents[i] for i in places)]) if summed else []
    moving = iter(found)
    pairs = zip(values, roles, strict=True)
    return values, [ad.Zero(jax.typeof(v).to_tangent_aval()) if role == "status" else next(moving) for v, role in pairs]


def _transpose(cotangents: Sequence[Any], *operands: Any, call: Call) -> list[Any]:
    """Cotangents of the directions: the reverse derivative of the kernel whose tangents these are."""
    kernel, names = call.source  # type: ignore[misc]
    count = len(kernel.arguments)
    primals, directions = operands[:count], operands[count:]
    n = next((o.aval.shape[0] if ad.is_undefined_primal(o) else o.shape[0] for o in operands if _rank(o) == 2), None)
    summed = tuple(n is not None and _rank(o) == 1 for o in directions)
    given = [ad.instantiate_zeros(c) for c in cotangents]
    found = _bind(Call(kernel.pullback(*names), summed), [*primals, *given])
    return [None] * count + found


def _rank(operand: Any) -> int:
    return len(operand.aval.shape if ad.is_undefined_primal(operand) else operand.shape)


ad.primitive_jvps[_primitive] = _jvp
ad.primitive_transposes[_primitive] = _transpose


# -- batches --------------------------------------------------------------------------------------------------------


def _batch(operands: Sequence[Any], axes: Sequence[Any], *, call: Call) -> Any:
    """More items: the axis comes first, then those that there are."""
    lengths = {o.shape[a] for o, a in zip(operands, axes, strict=True) if a is not None}
    length = lengths.pop()
    ranks = [len(o.shape) - (a is not None) for o, a in zip(operands, axes, strict=True)]
    moved = [o if a is None else jnp.moveaxis(o, a, 0) for o, a in zip(operands, axes, strict=True)]
    n = next((o.shape[-2] for o, rank in zip(moved, ranks, strict=True) if rank == 2), None)
    rows = []
    for o, axis, rank in zip(moved, axes, ranks, strict=True):
        if axis is None and rank == 1:
            rows.append(o)
            continue
        if n is not None and rank == 1:
            o = o[:, None]
        shape = (length, o.shape[-1]) if n is None else (length, n, o.shape[-1])
        rows.append(jnp.broadcast_to(o, shape).reshape(-1, o.shape[-1]))
    whole = Call(call.kernel, (False,) * len(call.is_summed), call.source)
    found = []
    for value, output, summed in zip(_bind(whole, rows), call.kernel.outputs, call.is_summed, strict=True):
        if n is not None:
            value = value.reshape(length, n, *value.shape[1:])
            if summed:
                value = _first_code(value) if output.role == "status" else value.sum(1)
        found.append(value)
    return found, [0] * len(found)


def _first_code(codes: Any) -> Any:
    """The status of each sum (m, n): see `execute.reductions.sums`."""
    failed = (codes != Status.OK) & (codes != Status.NOT_UNIQUE)
    codes = jnp.where(failed.any(1, keepdims=True) & ~failed, 0, codes)  # where one failed, the others do not count
    codes = jnp.pad(codes, ((0, 0), (0, 1)))  # of no items OK
    return jnp.take_along_axis(codes, jnp.argmax(codes != Status.OK, 1, keepdims=True), 1)[:, 0]


batching.primitive_batchers[_primitive] = _batch


# -- for users ------------------------------------------------------------------------------------------------------


def jax_function(kernel: Any) -> Callable[..., Any]:
    """A declared kernel as a function of JAX arrays: see `KernelFunction.jax`."""

    def of_arrays(*arrays: Any) -> Any:
        operands, lead = _operands(kernel, arrays)
        return shaped(kernel, _bind(call_of(kernel, lead), operands), lead)

    of_arrays.__name__ = of_arrays.__qualname__ = kernel.name  # in JAX's messages and texts
    compiled = jax.jit(of_arrays)

    def call(*arguments: Any, **by_name: Any) -> Any:
        return compiled(*positional(kernel, arguments, by_name))

    call.__name__ = call.__qualname__ = kernel.name
    call.__doc__ = kernel.__doc__
    return call


def _operands(kernel: Any, given: Sequence[Any]) -> tuple[list[Any], tuple[int, ...]]:
    """Tables of rows, or rows that all items share; and the shape of the items."""
    arrays = [floating_array(a, n) for a, n in zip(given, kernel.arguments, strict=True)]
    dtype = jnp.result_type(*arrays)
    sized = rows_of(kernel, [a.astype(dtype) for a in arrays])
    lead = broadcast_leads([tuple(a.shape[:-1]) for a in sized], kernel.name)
    return tables(sized, lead, jnp.broadcast_to), lead


def floating_array(value: Any, name: str) -> Any:
    """A JAX array of float32 or float64: integers and numbers of Python become floats."""
    try:
        array = jnp.asarray(value)
    except (TypeError, ValueError) as error:
        raise InputError(f"{name} is no array of numbers: {one_line(value)}.") from error
    if array.dtype in (jnp.float32, jnp.float64):
        return array
    if jnp.issubdtype(array.dtype, jnp.integer):
        return array.astype(float)
    what = f"{name} has type {array.dtype}; float32 or float64 is needed"
    raise InputError(what, remedy="Convert it: x.astype(float)")
