"""PyTorch tensors as coefficients."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray

from ...codegen.autodiff.torch_kernels import floating_tensor
from ...common.dtypes import F32
from .evaluation import ArrayBackend


class TorchBackend(ArrayBackend):
    """PyTorch."""

    name = "PyTorch"

    def function(self, kernel: Any) -> Callable[..., Any]:
        found: Callable[..., Any] = kernel.torch()
        return found

    def floating(self, value: Any, name: str) -> Any:
        return floating_tensor(value, name)

    def constant(self, values: NDArray[Any], like: Any) -> Any:
        return torch.tensor(values, dtype=like.dtype)

    def take(self, data: Any, columns: NDArray[np.int64]) -> Any:
        if (columns < 0).any():
            data = torch.cat([data, torch.zeros_like(data[..., :1])], -1)
            columns = np.where(columns < 0, data.shape[-1] - 1, columns)
        return data[..., torch.from_numpy(columns)]

    def stack(self, columns: Sequence[Any]) -> Any:
        return torch.stack(torch.broadcast_tensors(*columns), -1)

    def norm(self, squares: Any) -> Any:
        return squares.abs().sqrt()

    def cast(self, data: Any, dtype: np.dtype[Any]) -> Any:
        return data.to(torch.float32 if dtype == F32 else torch.float64)

    def numbers(self, data: Any) -> NDArray[Any] | None:
        found: NDArray[Any] = data.detach().numpy()
        return found
