"""Names of files that users give, and files written whole or not at all."""

from __future__ import annotations

import errno
import os
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from ..codegen.interrupts import deferred_interrupts
from ..errors import InputError
from .validation import short_repr

#: Bytes that are written at a time: an interrupt is seen between them.
BLOCK = 1 << 20


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


def write_atomically(path: Path, data: str | bytes) -> None:
    """Write a file under a temporary name and rename it into place, so that no reader sees half of it.

    Raises
    ------
    OSError
        With the name that the user knows, not the temporary one.
    """
    with replacing(path) as temporary:
        whole = memoryview(data.encode() if isinstance(data, str) else data)
        with open(temporary, "wb") as file:
            for begin in range(0, len(whole), BLOCK):
                file.write(whole[begin : begin + BLOCK])


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """An empty file beside this one, for a library to write; it takes the name when the block ends well.

    Raises
    ------
    OSError
        With the name that the user knows, not the temporary one. The temporary file is gone then.
    """
    if path.is_dir():
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
    if path.exists() and not path.is_file():
        with _beside_a_device(path) as whole:
            yield whole
        return
    temporary: Path | None = None
    try:
        with deferred_interrupts():  # no file is left whose name is not known yet
            handle, name = tempfile.mkstemp(dir=path.absolute().parent, prefix=f".{path.name}.")
            temporary = Path(name)
            os.close(handle)
        yield temporary
        os.chmod(temporary, 0o666 & ~_umask())
        os.replace(temporary, path)
    except BaseException as error:
        if temporary is not None:
            temporary.unlink(missing_ok=True)
        if isinstance(error, OSError):
            raise OSError(error.errno, error.strerror or str(error), str(path)) from None
        raise


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


@contextmanager
def _beside_a_device(path: Path) -> Iterator[Path]:
    """Write to devices and pipes (/dev/stdout) directly: a file must not replace them."""
    with tempfile.TemporaryDirectory(prefix="bladesmith-") as folder:
        temporary = Path(folder) / "whole"
        temporary.touch()
        yield temporary
        try:
            with open(path, "wb", buffering=0) as device:
                data = memoryview(temporary.read_bytes())
                while data:
                    data = data[device.write(data) :]
        except OSError as error:
            raise OSError(error.errno, error.strerror or str(error), str(path)) from None


def _umask() -> int:
    current = os.umask(0)
    os.umask(current)
    return current
