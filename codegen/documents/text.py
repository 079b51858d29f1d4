"""Text files of users."""

from __future__ import annotations

from pathlib import Path

from ..errors import InputError

#: Largest file that is read, in bytes, where nothing else is said.
MAX_SIZE = 1_000_000_000
_PART = 2**24


def read_text(path: str | Path, error: type[InputError] = InputError, max_size: int = MAX_SIZE) -> str:
    """Text of a file.

    Parameters
    ----------
    path
    error
        Class of the errors.
    max_size
        Of the file, in bytes: of a larger one nothing more is read.

    Raises
    ------
    InputError
        Of the class `error`, if the file cannot be read, is larger, or is not UTF-8.
    """
    try:
        return read_bytes(path, error, max_size).decode("utf-8-sig")
    except UnicodeDecodeError as failure:
        raise error(f"is not UTF-8 text (byte {failure.start}).", where=str(path)) from None


def read_bytes(path: str | Path, error: type[InputError] = InputError, max_size: int = MAX_SIZE) -> bytes:
    """Contents of a file, as for `read_text`."""
    parts, left = [], max_size
    try:
        with open(path, "rb") as file:  # by parts: pipes do not say how much they hold
            while left >= 0 and (part := file.read(_PART)):
                parts.append(part)
                left -= len(part)
    except (OSError, ValueError) as failure:
        raise error(f"cannot be read: {getattr(failure, 'strerror', None) or failure}.", where=str(path)) from None
    if left < 0:
        raise error(f"is larger than {max_size / 1e6:g} MB, the most that is read of such a file.", where=str(path))
    return b"".join(parts)
