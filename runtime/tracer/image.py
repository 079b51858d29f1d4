"""Pictures to files: sRGB, eight bits, written whole or not at all."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError, MissingExtraError

#: sRGB (IEC 61966-2-1): linear below the knee, a power above it.
_KNEE, _SLOPE, _OFFSET, _EXPONENT = 0.0031308, 12.92, 0.055, 1 / 2.4
FORMATS = {
    ".png": "PNG",
    ".jpg": "JPEG",
    ".jpeg": "JPEG",
    ".webp": "WEBP",
    ".bmp": "BMP",
    ".tif": "TIFF",
    ".tiff": "TIFF",
}


def encode(image: NDArray[Any]) -> NDArray[np.uint8]:
    """Linear light to sRGB bytes, clipped to [0, 1]."""
    linear = np.clip(np.asarray(image, np.float64), 0.0, 1.0)
    curved = (1 + _OFFSET) * np.power(np.maximum(linear, _KNEE), _EXPONENT) - _OFFSET
    return np.asarray(np.where(linear <= _KNEE, _SLOPE * linear, curved) * 255 + 0.5, np.uint8)


def check_writable(path: str | os.PathLike[str]) -> None:
    """Find out before a long render whether its picture can be saved.

    Raises
    ------
    MissingExtraError
        Without pillow.
    InputError
        If the format is unknown or the folder does not take files.
    """
    _pillow()
    target = Path(path)
    if target.suffix.lower() not in FORMATS:
        known = ", ".join(FORMATS)
        raise InputError(f"{target.name} has no picture format that is known ({known}).", where=str(path))
    folder = target.parent
    if not folder.is_dir():
        raise InputError(f"there is no folder {folder}.", where=str(path))
    if target.is_dir() or not os.access(folder, os.W_OK):
        raise InputError("it cannot be written there.", where=str(path))


def save_image(path: str | os.PathLike[str], image: NDArray[Any]) -> None:
    """Save a linear picture (h, w, 3) as a file of the format of its suffix, in one step.

    Parameters
    ----------
    path : path
    image : array, shape (h, w, 3)
        Linear light; 1 is white, row 0 the top. Values are clipped to [0, 1].

    Raises
    ------
    MissingExtraError
        Without pillow.
    InputError
        If it is no such array, holds NaN, or cannot be written there.
    """
    check_writable(path)
    array = np.asarray(image)
    if array.ndim != 3 or array.shape[2] != 3:
        raise InputError(f"a picture has shape (height, width, 3), not {array.shape}.")
    target = Path(path)
    if array.dtype.kind not in "iuf":
        raise InputError(f"a picture holds real numbers, not {array.dtype}.")
    missing = np.isnan(array).any(axis=2)
    if missing.any():
        row, column = np.argwhere(missing)[0]
        raise InputError(f"NaN in {missing.sum()} pixels of the picture, the first in row {row}, column {column}.")
    picture = _pillow().fromarray(encode(array), "RGB")
    try:
        handle, temporary = tempfile.mkstemp(prefix=f".{target.name}.", suffix=".part", dir=target.parent)
    except OSError as error:
        raise InputError(f"it cannot be written there: {error.strerror}.", where=str(path)) from None
    try:
        with os.fdopen(handle, "wb") as file:
            picture.save(file, FORMATS[target.suffix.lower()])
        os.chmod(temporary, 0o666 & ~_umask())
        os.replace(temporary, target)
    except OSError as error:  # told with the name that the user knows
        Path(temporary).unlink(missing_ok=True)
        raise OSError(error.errno, error.strerror or str(error), str(path)) from None
    except BaseException:
        Path(temporary).unlink(missing_ok=True)
        raise


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask


def _pillow() -> Any:
    try:
        from PIL import Image
    except ImportError:
        raise MissingExtraError("plot", "Saving pictures") from None
    return Image
