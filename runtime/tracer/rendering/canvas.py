"""The arrays of a picture while it is rendered, their memory, and the partial picture of a render that was stopped."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...common import memory
from ...common.deprecation import renamed_attribute
from ...errors import ExecutorError, Interrupted, SceneError
from .aov_layers import LAYERS

Array = NDArray[Any]
#: Bytes of each pixel beside its layers: the flag that it is done.
PER_PIXEL = 1
#: Bytes of each channel beside the layer's own: its number in a file that is written.
PER_CHANNEL = 4


class PartialPicture:
    """The finished part of a picture whose render was stopped.

    Attributes
    ----------
    done : (height, width) array of bool
        Pixels that were rendered.
    """

    def __init__(self, layers: dict[str, Array], done: NDArray[np.bool_]) -> None:
        self._layers, self.done = layers, done
        self._is_filled = False

    def __repr__(self) -> str:
        height, width = self.done.shape
        return f"<PartialPicture: {width} x {height} pixels, {self.done.mean():.1%} rendered>"

    @property
    def layers(self) -> dict[str, Array]:
        """Arrays as from `Scene.layers`; NaN, or -1 in ``cost``, where nothing was rendered."""
        if not self._is_filled:  # not before: to write the memory of a large picture takes longer than an interrupt may
            left = ~self.done
            for name, array in self._layers.items():
                np.copyto(array, LAYERS[name].missing, where=left if array.ndim == left.ndim else left[..., None])
            self._is_filled = True
        return self._layers

    @property
    def image(self) -> Array:
        """The color, (height, width, 3)."""
        return self.layers["color"]

    @property
    def fraction_done(self) -> float:
        """Fraction of the pixels that were rendered."""
        return float(self.done.mean())

    share = renamed_attribute("fraction_done")


class RenderInterrupted(Interrupted):
    """An interrupt during a render; the finished part is in ``partial``, a `PartialPicture`."""

    partial: PartialPicture


class RenderError(ExecutorError):
    """A worker of an executor failed or ended; the part that others finished is in ``partial``, a `PartialPicture`."""

    partial: PartialPicture


@dataclass(frozen=True, eq=False)
class Canvas:
    """The arrays of a picture while it is rendered, and a mask of the pixels that are done."""

    width: int
    height: int
    arrays: dict[str, Array]
    done: NDArray[np.bool_] = field(repr=False)

    @classmethod
    def blank(cls, width: int, height: int, names: tuple[str, ...], dtype: Any) -> Canvas:
        """Allocate the layers.

        Raises
        ------
        SceneError
            If there is not enough memory: before anything is allocated.
        """
        check_memory(width, height, names, dtype)
        try:
            arrays = {name: LAYERS[name].empty(height, width, dtype) for name in names}
            return cls(width, height, arrays, np.zeros((height, width), bool))
        except MemoryError:
            raise SceneError(_memory_fault(width, height, names, dtype)) from None

    def partial(self) -> PartialPicture:
        """The pixels that are done."""
        return PartialPicture(self.arrays, self.done)


def check_memory(width: int, height: int, names: tuple[str, ...], dtype: Any) -> None:
    """Refuse a picture that is larger than the available memory."""
    free = memory.available()
    if free is not None and _bytes(width, height, names, dtype) > free:
        raise SceneError(f"{_memory_fault(width, height, names, dtype)}; {memory.readable(free)} are free.")


def _bytes(width: int, height: int, names: tuple[str, ...], dtype: Any) -> int:
    layers = [LAYERS[name] for name in names]
    each = sum(layer.bytes_per_pixel(dtype) + PER_CHANNEL * len(layer.channels) for layer in layers)
    return width * height * (PER_PIXEL + each)


def _memory_fault(width: int, height: int, names: tuple[str, ...], dtype: Any) -> str:
    needed = memory.readable(_bytes(width, height, names, dtype))
    return f"a picture of {width} x {height} pixels takes {needed} of memory"
