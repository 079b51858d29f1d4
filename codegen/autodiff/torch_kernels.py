"""Kernels as functions of PyTorch tensors: one custom operator, whose gradient is the same operator of another kernel.

Operands are as in `calls`: tables of rows, or rows that all items share. A call is named by a number, since operators
take numbers and tensors.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import torch

from ..errors import InputError, one_line
from ..execute.arrays import broadcast_leads
from .calls import Call, call_of, items, positional, rows_of, run, shaped, shapes, tables

_calls: list[Call] = []
_numbers: dict[Call, int] = {}
_TYPES = {torch.float32: np.float32, torch.float64: np.float64}


def _number(call: Call) -> int:
    """The call's number."""
    if call not in _numbers:
        _calls.append(call)
        _numbers[call] = len(_calls) - 1
    return _numbers[call]


def _call(number: int, operands: list[torch.Tensor]) -> list[torch.Tensor]:
    call = _calls[number]
    arrays = [o.detach().contiguous().numpy() for o in operands]
    return [torch.from_numpy(r) for r in run(call, call.kernel.bound("c", arrays), *arrays)]


def _fake(number: int, operands: list[torch.Tensor]) -> list[torch.Tensor]:
    call, first = _calls[number], operands[0]
    roles = [o.role for o in call.kernel.outputs]
    return [
        first.new_empty(shape, dtype=torch.uint8 if role == "status" else first.dtype)
        for (shape, _), role in zip(shapes(call, operands), roles, strict=True)
    ]


def _keep(ctx: Any, inputs: tuple[int, list[torch.Tensor]], output: list[torch.Tensor]) -> None:
    number, operands = inputs
    ctx.number = number
    ctx.save_for_backward(*operands)


def _backward(context: Any, cotangents: Sequence[torch.Tensor | None]) -> tuple[None, list[torch.Tensor | None]]:
    """The reverse derivative, with respect to the arguments that have gradients."""
    call, operands = _calls[context.number], context.saved_tensors
    kernel = call.kernel
    given = [
        torch.zeros(shape, dtype=operands[0].dtype) if c is None else c
        for c, (shape, _), output in zip(cotangents, shapes(call, operands), kernel.outputs, strict=True)
        if output.role != "status"
    ]
    n, wanted = items(operands), [o.requires_grad for o in operands]
    names = [name for name, own in zip(kernel.arguments, wanted, strict=True) if own]
    summed = tuple(n is not None and o.ndim == 1 for o in operands if o.requires_grad)
    found = iter(_operator(_number(Call(kernel.pullback(*names), summed)), [*operands, *given]))
    return None, [next(found) if own else None for own in wanted]


_operator: Any = torch.library.custom_op(
    "bladesmith::kernel", _call, mutates_args=(), schema="(int number, Tensor[] operands) -> Tensor[]"
)
_operator.register_fake(_fake)
_operator.register_autograd(_backward, setup_context=_keep)


def torch_function(kernel: Any) -> Callable[..., Any]:
    """A declared kernel as a function of tensors: see `KernelFunction.torch`."""

    def call(*arguments: Any, **by_name: Any) -> Any:
        given = positional(kernel, arguments, by_name)
        tensors = [floating_tensor(a, n) for a, n in zip(given, kernel.arguments, strict=True)]
        dtype = torch.float64 if any(t.dtype == torch.float64 for t in tensors) else torch.float32
        sized = rows_of(kernel, [t.to(dtype) for t in tensors])
        lead = broadcast_leads([tuple(t.shape[:-1]) for t in sized], kernel.name)
        operands = tables(sized, lead, torch.broadcast_to)
        return shaped(kernel, _operator(_number(call_of(kernel, lead)), operands), lead)

    call.__name__ = call.__qualname__ = kernel.name
    call.__doc__ = kernel.__doc__
    return call


def floating_tensor(value: Any, name: str) -> torch.Tensor:
    """A tensor of float32 or float64 on the host."""
    try:
        tensor = (
            value if isinstance(value, torch.Tensor) else torch.from_numpy(np.require(value, requirements=("C", "W")))
        )
    except (TypeError, ValueError) as error:
        raise InputError(f"{name} is no array of numbers: {one_line(value)}.") from error
    if tensor.device.type != "cpu":
        what = f"{name} is on {tensor.device}, and kernels are called on the CPU"
        raise InputError(what, remedy="Move it: x.cpu()")
    if tensor.layout != torch.strided:
        raise InputError(f"{name} is sparse", remedy="Make it dense: x.to_dense()")
    if tensor.dtype in _TYPES:
        return tensor
    if tensor.dtype in (torch.int8, torch.int16, torch.int32, torch.int64, torch.uint8):
        return tensor.to(torch.float64)
    what = f"{name} has type {tensor.dtype}; float32 or float64 is needed"
    raise InputError(what, remedy="Convert it: x.double()")
