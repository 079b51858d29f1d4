"""Names of files that users give, and files written whole or not at all."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from ..codegen.documents.whole_files import replacing as replacing
from ..codegen.documents.whole_files import write_atomically as write_atomically
from ..errors import InputError
from .validation import short_repr


def as_path(path: Any, use: str, error: type[InputError] = InputError) -> Path:
    """Path of a file that a user names.

    Parameters
    ----------
    path : path
        Text, bytes or an ``os.PathLike``.
    use : str
        What it is for, such as "a model is read from".
    error : type
        Class of the error.

    Raises
    ------
    InputError
        Of the class ``error``, if it names no file.
    """
    try:
        file = Path(os.fsdecode(path))
    except TypeError:
        raise error(f"{use} a file, and {short_repr(path)} names none; a text or a path is needed.") from None
    if "\0" in str(file):
        raise error(f"the name {str(file)!r} has a null character.")
    return file


def output_path(path: Any, one: str, many: str, formats: Sequence[str]) -> Path:
    """Path of a file to write.

    Parameters
    ----------
    path : path
    one, many : str
        Contents of the file, such as "a trajectory" and "trajectories".
    formats : sequence of str
        Suffixes of the known formats.

    Raises
    ------
    InputError
        If it is not a path, or its suffix is not known.
    """
    file = as_path(path, f"{one} is written to")
    if file.suffix.lower() not in formats:
        listed = " or ".join((", ".join(formats[:-1]), formats[-1]))
        raise InputError(f"{many} are written as {listed}, not {file.suffix or 'a name without a suffix'}.",
                         where=str(file))  # fmt: skip
    return file


def write_file(path: Path, data: str | bytes) -> None:
    """`write_atomically`, for a file that a user names.

    Raises
    ------
    InputError
        If it cannot be written.
    """
    with failures_named(path):
        write_atomically(path, data)


@contextmanager
def replacing_by_suffix(path: Path) -> Iterator[Path]:
    """`replacing` for a library that goes by the suffix: there is no file of the temporary name yet."""
    with replacing(path) as temporary:
        named = temporary.with_name(temporary.name + path.suffix)
        try:
            yield named
            named.replace(temporary)
        finally:
            named.unlink(missing_ok=True)


@contextmanager
def failures_named(path: str | os.PathLike[str]) -> Iterator[None]:
    """Raise the system's errors while a file is written as `InputError`.

    Raises
    ------
    InputError
        For every OSError.
    """
    try:
        yield
    except OSError as error:
        raise InputError(f"cannot be written: {error.strerror or error}.", where=str(path)) from None


def check_folder(path: Path) -> None:
    """Check before long work that files can be written to a folder; it is created if it is missing.

    Raises
    ------
    InputError
        If they cannot.
    """
    with failures_named(path):
        path.mkdir(parents=True, exist_ok=True)
        # permissions say too little of disks that are mounted read-only
        tempfile.TemporaryFile(dir=path).close()
