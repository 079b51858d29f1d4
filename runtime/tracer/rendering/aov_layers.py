"""Layers of a picture (arbitrary output variables): color, normal, depth, the curve's parameter, cost."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...common.validation import as_choice, short_repr
from ...errors import MissingExtraError, SceneError

Array = NDArray[Any]


@dataclass(frozen=True)
class Layer:
    """A quantity that a picture holds for each pixel.

    Attributes
    ----------
    channels : tuple of str
        Names in EXR files; the standard's where it has one.
    integer : bool
        int32, else the data type of the picture.
    missing : float
        Value of pixels that were not rendered.
    reciprocal : bool
        Pictures of it are colored linearly in 1 / x: with a horizon, most of the scale remains for near objects.
    """

    channels: tuple[str, ...]
    integer: bool = False
    missing: float = np.nan
    reciprocal: bool = False

    def empty(self, rows: int, columns: int, dtype: Any) -> Array:
        """Allocate the layer."""
        shape = (rows, columns) if len(self.channels) == 1 else (rows, columns, len(self.channels))
        return np.empty(shape, np.int32 if self.integer else dtype)

    def bytes_per_pixel(self, dtype: Any) -> int:
        """Memory of the layer."""
        return len(self.channels) * np.dtype(np.int32 if self.integer else dtype).itemsize


#: All layers, by the names in `Scene.layers`, in the driver's structure and on the command line.
LAYERS = {
    "color": Layer(("R", "G", "B")),
    "normal": Layer(("N.X", "N.Y", "N.Z")),
    "depth": Layer(("Z",), reciprocal=True),
    "alpha": Layer(("alpha",)),
    "cost": Layer(("cost",), integer=True, missing=-1),
}


def check_layer_names(names: Any) -> tuple[str, ...]:
    """Check names of layers; return each once, in the order of `LAYERS`.

    Raises
    ------
    SceneError
        If the list is empty, or a name is unknown.
    """
    requested = [names] if isinstance(names, str) else list(names) if isinstance(names, Sequence) else []
    for name in requested:
        as_choice(name, "a layer", LAYERS, SceneError)
    if not requested:
        raise SceneError(f"layers is {short_repr(names)}; a list of names is needed: {', '.join(LAYERS)}.")
    return tuple(name for name in LAYERS if name in requested)


class LayerPicture(NamedTuple):
    """A layer as a picture.

    Attributes
    ----------
    pixels : (h, w, 3) array of uint8
        sRGB.
    legend : str
        Meaning of the colors.
    """

    pixels: NDArray[np.uint8]
    legend: str


def layer_picture(name: str, values: Array) -> LayerPicture:
    """Map a layer other than ``color`` to colors: coordinates of normals, else a scale from dark to light.

    Raises
    ------
    MissingExtraError
        Without matplotlib, which supplies the color map.
    """
    if name == "normal":
        missing = np.asarray(np.isnan(values).any(axis=2))
        pixels = np.where(missing[..., None], 0.0, (np.nan_to_num(values) + 1) * 127.5 + 0.5)
        return LayerPicture(
            pixels.astype(np.uint8), "normal: red, green, blue from -1 to 1 are x, y, z; black: nothing"
        )
    layer = LAYERS[name]
    valid = np.isfinite(values) & (values >= 0 if layer.integer or layer.reciprocal else True)
    if not valid.any():
        return LayerPicture(np.zeros((*values.shape, 3), np.uint8), f"{name}: there is none")
    numbers = values[valid].astype(np.float64)
    low, high = (0.0 if layer.integer else float(numbers.min())), float(numbers.max())
    scaled = np.full(values.shape, np.nan)
    scaled[valid] = _scale_values(numbers, low, high, layer.reciprocal)
    ends = ("light", "dark, evenly in its reciprocal") if layer.reciprocal else ("dark", "light")
    legend = f"{name}: viridis from {low:.4g} ({ends[0]}) to {high:.4g} ({ends[1]}); black: nothing"
    return LayerPicture(_viridis(scaled), legend)


def _scale_values(values: Array, low: float, high: float, reciprocal: bool) -> Array:
    """Scale values to the interval from 0 (dark) to 1."""
    if high <= low:
        return np.ones_like(values)
    if reciprocal and low > 0:
        return (low / values - low / high) / (1 - low / high)
    return (high - values if reciprocal else values - low) / (high - low)


def _viridis(scaled: Array) -> NDArray[np.uint8]:
    """Colors of a perceptually uniform map; black for NaN."""
    try:
        from matplotlib import colormaps
    except ImportError:
        raise MissingExtraError("plot", "Pictures of layers") from None
    colored = colormaps["viridis"](np.nan_to_num(scaled), bytes=True)[..., :3]
    colored[np.isnan(scaled)] = 0
    return np.ascontiguousarray(colored)


def exr_channels(layers: Mapping[str, Array]) -> dict[str, NDArray[np.float32]]:
    """Channels of an EXR file: the layers' raw numbers in float32."""
    channels = {}
    with np.errstate(over="ignore"):
        for name, values in layers.items():
            names = LAYERS[name].channels
            for i, channel in enumerate(names):
                plane = values if len(names) == 1 else values[..., i]
                channels[channel] = np.ascontiguousarray(plane, np.float32)
    return channels
