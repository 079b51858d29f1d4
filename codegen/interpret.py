"""Kernels without a compiler: the expression graph evaluated on arrays with NumPy. Right, and slow."""

from __future__ import annotations

from typing import Any

import numpy as np

from .errors import ShapeError
from .rings import NumericRing
from .trace import Kernel


class Interpreted:
    """A kernel as a function of arrays, like `binding.BoundKernel`."""

    def __init__(self, kernel: Kernel) -> None:
        self.kernel = kernel

    def __call__(self, *arrays: Any) -> Any:
        columns: list[Any] = []
        leads = []
        for array, item in zip(arrays, self.kernel.inputs, strict=True):
            values = np.asarray(array)
            values = values if values.dtype == np.float32 else values.astype(np.float64)
            if item.kind.is_scalar_argument:
                columns.append(values)
                leads.append(values.shape)
                continue
            if values.ndim == 0 or values.shape[-1] != item.kind.size:
                raise ShapeError(f"{item.name} has shape {values.shape}; its last axis must have {item.kind.size} entries.")
            columns.extend(values[..., j] for j in range(item.kind.size))
            leads.append(values.shape[:-1])
        lead = np.broadcast_shapes(*leads)
        dtype = np.result_type(*(c.dtype for c in columns)) if columns else np.dtype(np.float64)
        rows = self.kernel.evaluate_flat(columns, NumericRing(dtype))
        results: list[Any] = []
        for output, row in zip(self.kernel.outputs, rows, strict=True):
            stacked = np.stack([np.broadcast_to(v, lead) for v in row], -1)
            results.append(stacked[..., 0].astype(np.uint8) if output.role == "status" else stacked)
        return results[0] if len(results) == 1 else tuple(results)
