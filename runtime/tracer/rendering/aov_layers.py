"""What a picture may hold for each pixel besides its color: normals, depth, the curve's parameter, the cost."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..errors import MissingExtraError, SceneError, suggest
from .values import shown as shown_value

Array = NDArray[Any]


@dataclass(frozen=True)
class Layer:
    """One kind of number per pixel.

    Attributes
    ----------
    channels : tuple of str
        Names in EXR files; the standard's where it has one.
    integer : bool
        int32, else the picture's own type.
    missing : float
        Where nothing was rendered.
    reciprocal : bool
        Pictures of it are colored evenly in 1 / x: a horizon leaves most of the scale to what is near.
    """

    channels: tuple[str, ...]
    integer: bool = False
    missing: float = np.nan
    reciprocal: bool = False

    def empty(self, rows: int, columns: int, dtype: Any) -> Array:
        """Room for the layer."""
        shape = (rows, columns) if len(self.channels) == 1 else (rows, columns, len(self.channels))
        return np.empty(shape, np.int32 if self.integer else dtype)

    def bytes_per_pixel(self, dtype: Any) -> int:
        """Memory that it takes."""
        return len(self.channels) * np.dtype(np.int32 if self.integer else dtype).itemsize


#: By the names of `Scene.layers`, of the driver's arrays and of the command.
LAYERS = {
    "color": Layer(("R", "G", "B")),
    "normal": Layer(("N.X", "N.Y", "N.Z")),
    "depth": Layer(("Z",), reciprocal=True),
    "alpha": Layer(("alpha",)),
    "cost": Layer(("cost",), integer=True, missing=-1),
}


def checked_names(names: Any) -> tuple[str, ...]:
    """Names of layers, each once, in the order of `LAYERS`.

    Raises
    ------
    SceneError
        If there is none, or one is unknown.
    """
    wanted = [names] if isinstance(names, str) else list(names) if isinstance(names, Sequence) else []
    for name in wanted:
        if not isinstance(name, str) or name not in LAYERS:
            near = suggest(name, LAYERS) if isinstance(name, str) else ""
            raise SceneError(f"there is no layer {shown_value(name)}{near}; there are {', '.join(LAYERS)}.")
    if not wanted:
        raise SceneError(f"layers is {shown_value(names)}; a list of names is needed: {', '.join(LAYERS)}.")
    return tuple(name for name in LAYERS if name in wanted)


class Shown(NamedTuple):
    """A layer as people look at it.

    Attributes
    ----------
    pixels : (h, w, 3) array of uint8
        sRGB.
    legend : str
        What the colors mean.
    """

    pixels: NDArray[np.uint8]
    legend: str


def shown(name: str, values: Array) -> Shown:
    """Colors for a layer other than ``color``: of a normal its coordinates, else a scale from dark to light.

    Raises
    ------
    MissingExtraError
        Without matplotlib, whose color map is used.
    """
    if name == "normal":
        missing = np.asarray(np.isnan(values).any(axis=2))
        pixels = np.where(missing[..., None], 0.0, (np.nan_to_num(values) + 1) * 127.5 + 0.5)
        return Shown(pixels.astype(np.uint8), "normal: red, green, blue from -1 to 1 are x, y, z; black: nothing")
    layer = LAYERS[name]
    known = np.isfinite(values) & (values >= 0 if layer.integer or layer.reciprocal else True)
    if not known.any():
        return Shown(np.zeros((*values.shape, 3), np.uint8), f"{name}: there is none")
    found = values[known].astype(np.float64)
    low, high = (0.0 if layer.integer else float(found.min())), float(found.max())
    scaled = np.full(values.shape, np.nan)
    scaled[known] = _scaled(found, low, high, layer.reciprocal)
    ends = ("light", "dark, evenly in its reciprocal") if layer.reciprocal else ("dark", "light")
    legend = f"{name}: viridis from {low:.4g} ({ends[0]}) to {high:.4g} ({ends[1]}); black: nothing"
    return Shown(_viridis(scaled), legend)


def _scaled(values: Array, low: float, high: float, reciprocal: bool) -> Array:
    """Values between 0 (dark) and 1."""
    if high <= low:
        return np.ones_like(values)
    if reciprocal and low > 0:
        return (low / values - low / high) / (1 - low / high)
    return (high - values if reciprocal else values - low) / (high - low)


def _viridis(scaled: Array) -> NDArray[np.uint8]:
    """A perceptual scale; black for NaN."""
    try:
        from matplotlib import colormaps
    except ImportError:
        raise MissingExtraError("plot", "Pictures of layers") from None
    colored = colormaps["viridis"](np.nan_to_num(scaled), bytes=True)[..., :3]
    colored[np.isnan(scaled)] = 0
    return np.ascontiguousarray(colored)


def exr_channels(layers: Mapping[str, Array]) -> dict[str, NDArray[np.float32]]:
    """The layers' numbers as channels of an EXR file: raw, float32."""
    channels = {}
    with np.errstate(over="ignore"):
        for name, values in layers.items():
            names = LAYERS[name].channels
            for i, channel in enumerate(names):
                plane = values if len(names) == 1 else values[..., i]
                channels[channel] = np.ascontiguousarray(plane, np.float32)
    return channels


__all__ = ["LAYERS", "Layer", "Shown", "checked_names", "exr_channels", "shown"]
