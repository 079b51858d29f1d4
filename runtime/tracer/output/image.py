"""Pictures to files: sRGB in eight bits or linear EXR, written whole or not at all."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError, MissingExtraError
from ..files import replacing
from . import exr
from .layers import LAYERS, exr_channels, shown
from .values import shown as shown_value

Array = NDArray[Any]
#: sRGB (IEC 61966-2-1): linear below the knee, a power above it.
_KNEE, _SLOPE, _OFFSET, _EXPONENT = 0.0031308, 12.92, 0.055, 1 / 2.4
#: Pixels that are encoded at once: the copies of a band are small beside the picture.
BAND = 1 << 20


@dataclass(frozen=True)
class Format:
    """What is known of a file format; ``name`` is pillow's, ``most`` the longest side that it can hold."""

    name: str
    most: int
    transparent: bool = True


_JPEG, _TIFF = Format("JPEG", 65500, transparent=False), Format("TIFF", 2**31 - 1)
EXR = Format("EXR", 2**31 - 1)
FORMATS = {
    ".png": Format("PNG", 2**31 - 1),
    ".exr": EXR,
    ".jpg": _JPEG,
    ".jpeg": _JPEG,
    ".webp": Format("WEBP", 16383),
    ".bmp": Format("BMP", 2**31 - 1, transparent=False),
    ".tif": _TIFF,
    ".tiff": _TIFF,
}


def encode(image: Array) -> NDArray[np.uint8]:
    """Linear light to sRGB bytes, clipped to [0, 1]."""
    linear = np.clip(np.asarray(image, np.float64), 0.0, 1.0)
    curved = (1 + _OFFSET) * np.power(np.maximum(linear, _KNEE), _EXPONENT) - _OFFSET
    return np.asarray(np.where(linear <= _KNEE, _SLOPE * linear, curved) * 255 + 0.5, np.uint8)


def check_writable(path: str | os.PathLike[str], width: int = 1, height: int = 1) -> None:
    """Find out before a long render whether its picture can be saved.

    Parameters
    ----------
    path : path
    width, height : int, optional
        Pixels, where they are known.

    Raises
    ------
    MissingExtraError
        Without pillow, or without OpenEXR for an EXR file.
    InputError
        If the format is unknown or too small, or the folder does not take files.
    """
    target = file_named(path)
    known = _format(target)
    if known is EXR:
        exr.check_available()
    else:
        _pillow()
    if max(width, height) > known.most:
        what = f"{known.name} files have at most {known.most} pixels along a side, not {max(width, height)}."
        raise InputError(what, where=str(path), remedy="Take PNG or EXR.")
    if not target.parent.is_dir():
        raise InputError(f"there is no folder {target.parent}.", where=str(path))
    if target.is_dir():
        raise InputError("it is a folder.", where=str(path))
    try:  # permissions say too little of disks that are mounted read-only
        tempfile.TemporaryFile(dir=target.parent).close()
    except OSError as error:
        raise InputError(f"it cannot be written there: {error.strerror}.", where=str(path)) from None


def save_image(path: str | os.PathLike[str], image: Array, done: Array | None = None) -> None:
    """Save a linear picture (h, w, 3) as a file of the format of its suffix, in one step.

    Parameters
    ----------
    path : path
        EXR keeps linear numbers (float32); other formats hold sRGB in eight bits, clipped to [0, 1].
    image : array, shape (h, w, 3)
        Linear light; 1 is white, row 0 the top.
    done : array of bool, shape (h, w), optional
        Pixels that are known, of a picture in parts; the others become transparent, or black where the format
        has no transparency.

    Raises
    ------
    MissingExtraError
        Without pillow, or without OpenEXR for an EXR file.
    InputError
        If it is no such array, holds NaN, or cannot be written there.
    OSError
        If the disk is full or fails. Nothing is left behind, and a file of that name stays as it was.
    """
    save_layers(path, {"color": image}, done)


def save_layers(
    path: str | os.PathLike[str], layers: Mapping[str, Array], done: Array | None = None
) -> dict[Path, str]:
    """Save the layers of a picture: in one EXR file as they are, else as pictures, each in a file of its own.

    Parameters
    ----------
    path : path
        Of the color. In formats other than EXR a layer goes to the same name with its own before the suffix:
        ``image.depth.png``.
    layers : mapping
        As from `Scene.layers`.
    done : array of bool, optional
        As for `save_image`.

    Returns
    -------
    dict
        Paths of the files, and what the colors of each mean: the ranges that were found.

    Raises
    ------
    MissingExtraError, InputError, OSError
        As for `save_image`.
    """
    target = file_named(path)
    known = _format(target)
    if not isinstance(layers, Mapping) or not layers:
        raise InputError(f"layers are {shown_value(layers)}; a mapping of names to arrays is needed.")
    if done is not None:
        done = _pixels(done)
    arrays = {name: _checked(name, np.asarray(values), done) for name, values in layers.items()}
    shape = next(iter(arrays.values())).shape
    for name, values in arrays.items():
        if values.shape[:2] != shape[:2]:
            raise InputError(f"{name} has {values.shape[:2]} pixels, the layer before {shape[:2]}.")
    check_writable(target, shape[1], shape[0])
    if known is EXR:
        channels = exr_channels(arrays)
        if done is not None:
            channels["A"] = np.asarray(done, np.float32)
        exr.save_exr(target, channels)
        return {target: f"float32 channels {', '.join(channels)}"}
    written = {}
    for name, values in arrays.items():
        place = target if name == "color" else target.with_name(f"{target.stem}.{name}{target.suffix}")
        pixels, legend = (_encoded(values), "") if name == "color" else shown(name, values)
        _save(place, pixels, legend, known, done)
        written[place] = legend or "color: sRGB"
    return written


def file_named(path: Any) -> Path:
    """The path, if it is one."""
    try:
        file = Path(os.fsdecode(path))
    except TypeError:
        raise InputError(f"a file is named by a text or a path, and {shown_value(path)} is neither.") from None
    if "\0" in str(file):
        raise InputError(f"the name {shown_value(path)} has a null character.")
    return file


def _pixels(done: Any) -> NDArray[np.bool_]:
    """Which pixels are done."""
    found = np.asarray(done)
    if found.dtype != np.bool_:
        raise InputError(f"done is {shown_value(done)}; an array of bool, one for each pixel, is needed.")
    return found


def _checked(name: str, values: Array, done: Array | None) -> Array:
    """A layer of the right shape with real numbers, and a color without NaN: unknown pixels are black."""
    if name not in LAYERS:
        raise InputError(f"there is no layer {shown_value(name)}.")
    trailing = len(LAYERS[name].channels)
    if values.ndim != (2 if trailing == 1 else 3) or (trailing > 1 and values.shape[2] != trailing) or not values.size:
        wanted = "(height, width)" if trailing == 1 else f"(height, width, {trailing})"
        raise InputError(f"{'a picture' if name == 'color' else name} has shape {wanted}, not {values.shape}.")
    if values.dtype.kind not in "iuf":
        raise InputError(f"a picture holds real numbers, not {values.dtype}.")
    if done is not None and done.shape != values.shape[:2]:
        raise InputError(f"done has shape {done.shape}; it is {values.shape[:2]}, one for each pixel.")
    if name != "color":
        return values
    if done is not None:
        values = np.where(done[..., None], values, 0)
    missing = np.isnan(values).any(axis=2)
    if missing.any():
        row, column = np.argwhere(missing)[0]
        raise InputError(f"NaN in {missing.sum()} pixels of the picture, the first in row {row}, column {column}.")
    return values


def _encoded(image: Array) -> NDArray[np.uint8]:
    """`encode` in bands: the numbers between take many times the memory of the result."""
    pixels = np.empty(image.shape, np.uint8)
    rows = max(1, BAND // image.shape[1])
    for row in range(0, len(image), rows):
        pixels[row : row + rows] = encode(image[row : row + rows])
    return pixels


def _save(path: Path, pixels: NDArray[np.uint8], legend: str, known: Format, done: Array | None) -> None:
    pillow = _pillow()
    if done is not None and known.transparent:
        pixels = np.dstack([pixels, np.where(done, 255, 0).astype(np.uint8)])
    options: dict[str, Any] = {}
    if known.name == "PNG" and legend:
        from PIL.PngImagePlugin import PngInfo

        options["pnginfo"] = PngInfo()
        options["pnginfo"].add_text("Description", legend)
    with replacing(path) as temporary, open(temporary, "wb") as file:
        pillow.fromarray(pixels).save(file, known.name, **options)


def _format(path: Path) -> Format:
    if path.suffix.lower() not in FORMATS:
        known = ", ".join(FORMATS)
        raise InputError(f"{path.name} has no picture format that is known ({known}).", where=str(path))
    return FORMATS[path.suffix.lower()]


def _pillow() -> Any:
    try:
        from PIL import Image
    except ImportError:
        raise MissingExtraError("plot", "Saving pictures") from None
    return Image
