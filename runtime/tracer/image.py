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
    """Linear light to sRGB bytes: clipped to [0, 1]; what is not a number is black."""
    linear = np.clip(np.nan_to_num(np.asarray(image, np.float64), nan=0.0), 0.0, 1.0)
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
        Linear light; 1 is white, row 0 the top.
    """
    check_writable(path)
    array = np.asarray(image)
    if array.ndim != 3 or array.shape[2] != 3:
        raise InputError(f"a picture has shape (height, width, 3), not {array.shape}.")
    target = Path(path)
    picture = _pillow().fromarray(encode(array), "RGB")
    handle, temporary = tempfile.mkstemp(prefix=f".{target.name}.", suffix=".part", dir=target.parent)
    try:
        with os.fdopen(handle, "wb") as file:
            picture.save(file, FORMATS[target.suffix.lower()])
        os.chmod(temporary, 0o666 & ~_umask())
        os.replace(temporary, target)
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
