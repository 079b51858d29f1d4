"""Text files of users."""

from __future__ import annotations

from pathlib import Path

from ..errors import InputError


def read_text(path: str | Path, error: type[InputError] = InputError) -> str:
    """Text of a file.

    Raises
    ------
    InputError
        Of the class `error`, if the file cannot be read or is not UTF-8.
    """
    try:
        return Path(path).read_bytes().decode("utf-8-sig")
    except UnicodeDecodeError as failure:
        raise error(f"is not UTF-8 text (byte {failure.start}).", where=str(path)) from None
    except (OSError, ValueError) as failure:
        raise error(f"cannot be read: {getattr(failure, 'strerror', None) or failure}.", where=str(path)) from None
