"""EXR files with linear float32 channels, through the OpenEXR library."""

from __future__ import annotations

import errno
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...common.files import failures_named, replacing
from ...errors import MissingExtraError


def check_available() -> None:
    """Check that EXR files can be written.

    Raises
    ------
    MissingExtraError
        Without OpenEXR.
    """
    _library()


def save_exr(path: Path, channels: Mapping[str, NDArray[np.float32]]) -> None:
    """Write channels (h, w) to a file, atomically.

    Raises
    ------
    InputError
        If it cannot be written.
    """
    library = _library()
    header = {"compression": library.ZIP_COMPRESSION, "type": library.scanlineimage}
    with failures_named(path), replacing(path) as temporary:
        try:
            library.File(header, dict(channels)).write(str(temporary))
        except (RuntimeError, ValueError) as error:  # the library's message: '... "file". reason.'
            raise OSError(errno.EIO, str(error).rpartition('". ')[2].rstrip("."), str(path)) from None


def _library() -> Any:
    try:
        import OpenEXR
    except ImportError:
        raise MissingExtraError("exr", "Writing EXR files") from None
    return OpenEXR
