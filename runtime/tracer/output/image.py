"""Image files, written atomically: sRGB in eight bits, or linear EXR."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...common.files import as_path, failures_named, replacing
from ...common.validation import as_array, as_choice, as_instance, check_shape, invalid, real_array
from ...errors import InputError, MissingExtraError
from ..rendering.aov_layers import LAYERS, exr_channels, layer_picture
from . import exr

Array = NDArray[Any]
#: sRGB (IEC 61966-2-1): linear light below which the encoding is linear; a power law above it.
_KNEE = 0.0031308
#: Slope of the linear part.
_SLOPE = 12.92
#: Offset of the power law.
_OFFSET = 0.055
#: Exponent of the power law.
_EXPONENT = 1 / 2.4
#: Pixels that are encoded at once: intermediate copies stay small beside the picture.
BAND = 1 << 20


@dataclass(frozen=True)
class Format:
    """Properties of a file format: pillow's name, the largest side in pixels, and support of transparency."""

    name: str
    max_side: int
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
    """Convert linear light to sRGB bytes, clipped to [0, 1]."""
    linear = np.clip(np.asarray(image, np.float64), 0.0, 1.0)
    curved = (1 + _OFFSET) * np.power(np.maximum(linear, _KNEE), _EXPONENT) - _OFFSET
    return np.asarray(np.where(linear <= _KNEE, _SLOPE * linear, curved) * 255 + 0.5, np.uint8)


def check_writable(path: str | os.PathLike[str], width: int = 1, height: int = 1) -> None:
    """Check before a long render that its picture can be saved.

    Parameters
    ----------
    path : path
    width, height : int, optional
        Size in pixels, if it is known.

    Raises
    ------
    MissingExtraError
        Without pillow, or without OpenEXR for an EXR file.
    InputError
        If the format is unknown or too small for the picture, or the folder is not writable.
    """
    target = as_path(path, "a picture is written to")
    format_ = _format(target)
    if format_ is EXR:
        exr.check_available()
    else:
        _pillow()
    if max(width, height) > format_.max_side:
        what = f"{format_.name} files have at most {format_.max_side} pixels along a side, not {max(width, height)}."
        raise InputError(what, where=str(path), remedy="Take PNG or EXR.")
    with failures_named(target):  # such as a name that is too long
        if not target.parent.is_dir():
            raise InputError(f"there is no folder {target.parent}.", where=str(path))
        if target.is_dir():
            raise InputError("the path is a folder.", where=str(path))
    try:  # permissions do not tell disks that are mounted read-only
        tempfile.TemporaryFile(dir=target.parent).close()
    except OSError as error:
        raise InputError(f"the folder is not writable: {error.strerror}.", where=str(path)) from None


def save_image(path: str | os.PathLike[str], image: Array, done: Array | None = None) -> None:
    """Save a linear picture (h, w, 3) atomically, in the format of the suffix.

    Parameters
    ----------
    path : path
        EXR keeps linear numbers (float32); other formats hold sRGB in eight bits, clipped to [0, 1].
    image : array, shape (h, w, 3)
        Linear light; 1 is white, row 0 the top.
    done : array of bool, shape (h, w), optional
        Finished pixels of a partial picture; the others become transparent, or black where the format has no
        transparency.

    Raises
    ------
    MissingExtraError
        Without pillow, or without OpenEXR for an EXR file.
    InputError
        If the array has another shape or type, holds NaN, or the file cannot be written: no partial file remains, and
        an existing file stays as it was.
    """
    save_layers(path, {"color": image}, done)


def save_layers(
    path: str | os.PathLike[str], layers: Mapping[str, Array], done: Array | None = None
) -> dict[Path, str]:
    """Save the layers of a picture: raw in one EXR file, or as pictures in one file each.

    Parameters
    ----------
    path : path
        File of the color. In formats other than EXR each other layer gets a file with its name before the suffix:
        ``image.depth.png``.
    layers : mapping
        As from `Scene.layers`.
    done : array of bool, optional
        As for `save_image`.

    Returns
    -------
    dict
        Paths of the files, and the meaning of the colors of each, with their ranges.

    Raises
    ------
    MissingExtraError, InputError
        As for `save_image`.
    """
    target = as_path(path, "a picture is written to")
    format_ = _format(target)
    if not as_instance(layers, "layers", Mapping, "a mapping of names to arrays"):
        raise InputError("layers are empty; one at least is needed.")
    if done is not None:
        done = _pixels(done)
    arrays = {name: _check_layer(name, values, done) for name, values in layers.items()}
    shape = next(iter(arrays.values())).shape
    for name, values in arrays.items():
        if values.shape[:2] != shape[:2]:
            raise InputError(f"{name} has {values.shape[:2]} pixels, the layer before {shape[:2]}.")
    check_writable(target, shape[1], shape[0])
    if format_ is EXR:
        channels = exr_channels(arrays)
        if done is not None:
            channels["A"] = np.asarray(done, np.float32)
        exr.save_exr(target, channels)
        return {target: f"float32 channels {', '.join(channels)}"}
    written = {}
    for name, values in arrays.items():
        file = target if name == "color" else target.with_name(f"{target.stem}.{name}{target.suffix}")
        pixels, legend = (_encode_image(values), "") if name == "color" else layer_picture(name, values)
        _save(file, pixels, legend, format_, done)
        written[file] = legend or "color: sRGB"
    return written


def _pixels(done: Any) -> NDArray[np.bool_]:
    """Check the mask of finished pixels."""
    mask = as_array(done, "done")
    if mask.dtype != np.bool_:
        raise invalid(done, "done", "an array of bool, one for each pixel,")
    return mask


def _check_layer(name: str, values: Any, done: Array | None) -> Array:
    """Check shape and type of a layer, and that a color has no NaN; unfinished pixels of the color become black."""
    trailing = len(LAYERS[as_choice(name, "a layer", LAYERS)].channels)
    what = "the picture" if name == "color" else name
    real_array(values, what, ("height", "width", trailing)[: 2 + (trailing > 1)])
    pixels = np.asarray(values)  # indices stay whole numbers
    if not pixels.size:
        raise InputError(f"{what} has no pixels.")
    if done is not None:
        check_shape(done, "done", pixels.shape[:2])
    if name != "color":
        return pixels
    if done is not None:
        pixels = np.where(done[..., None], pixels, 0)
    missing = np.isnan(pixels).any(axis=2)
    if missing.any():
        row, column = np.argwhere(missing)[0]
        raise InputError(f"NaN in {missing.sum()} pixels of the picture, the first in row {row}, column {column}.")
    return pixels


def _encode_image(image: Array) -> NDArray[np.uint8]:
    """Apply `encode` to bands of rows: intermediate arrays take many times the memory of the result."""
    pixels = np.empty(image.shape, np.uint8)
    rows = max(1, BAND // image.shape[1])
    for row in range(0, len(image), rows):
        pixels[row : row + rows] = encode(image[row : row + rows])
    return pixels


def _save(path: Path, pixels: NDArray[np.uint8], legend: str, format_: Format, done: Array | None) -> None:
    pillow = _pillow()
    if done is not None and format_.transparent:
        pixels = np.dstack([pixels, np.where(done, 255, 0).astype(np.uint8)])
    options: dict[str, Any] = {}
    if format_.name == "PNG" and legend:
        from PIL.PngImagePlugin import PngInfo

        options["pnginfo"] = PngInfo()
        options["pnginfo"].add_text("Description", legend)
    with failures_named(path), replacing(path) as temporary, open(temporary, "wb") as file:
        pillow.fromarray(pixels).save(file, format_.name, **options)


def _format(path: Path) -> Format:
    if path.suffix.lower() not in FORMATS:
        suffixes = ", ".join(FORMATS)
        raise InputError(f"{path.name} does not end with the suffix of a picture format ({suffixes}).", where=str(path))
    return FORMATS[path.suffix.lower()]


def _pillow() -> Any:
    try:
        from PIL import Image
    except ImportError:
        raise MissingExtraError("plot", "Saving pictures") from None
    return Image
