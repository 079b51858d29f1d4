"""JAX arrays as coefficients. Multivectors are trees of arrays for JAX's transformations."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from numpy.typing import NDArray

from ...codegen.autodiff.jax_kernels import floating_array
from .evaluation import ArrayBackend


class JaxBackend(ArrayBackend):
    """JAX."""

    name = "JAX"

    def __init__(self) -> None:
        for node in self.nodes:
            jax.tree_util.register_pytree_node(node.type, node.flatten, partial(node.unflatten, self))

    def function(self, kernel: Any) -> Callable[..., Any]:
        found: Callable[..., Any] = kernel.jax()
        return found

    def floating(self, value: Any, name: str) -> Any:
        return floating_array(value, name)

    def constant(self, values: NDArray[Any], like: Any) -> Any:
        return jnp.asarray(values, like.dtype)

    def take(self, data: Any, columns: NDArray[np.int64]) -> Any:
        if (columns < 0).any():
            data = jnp.concatenate([data, jnp.zeros_like(data[..., :1])], -1)
        return data[..., columns]

    def stack(self, columns: Sequence[Any]) -> Any:
        return jnp.stack(jnp.broadcast_arrays(*columns), -1)

    def norm(self, squares: Any) -> Any:
        return jnp.sqrt(jnp.abs(squares))

    def cast(self, data: Any, dtype: np.dtype[Any]) -> Any:
        return data.astype(dtype)

    def numbers(self, data: Any) -> NDArray[Any] | None:
        return None if isinstance(data, jax.core.Tracer) else np.asarray(data)
