"""Files written whole or not at all."""

from __future__ import annotations

import errno
import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from .errors import InputError


def write_atomically(path: Path, data: str | bytes) -> None:
    """Write a file under a temporary name and rename it into place, so that no reader sees half of it.

    Raises
    ------
    OSError
        With the name that the user knows, not the temporary one.
    """
    with replacing(path) as temporary:
        temporary.write_bytes(data.encode() if isinstance(data, str) else data)


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
        with _beside_a_device(path) as temporary:
            yield temporary
        return
    try:
        handle, name = tempfile.mkstemp(dir=path.absolute().parent, prefix=f".{path.name}.")
    except OSError as error:
        raise OSError(error.errno, error.strerror, str(path)) from None
    os.close(handle)
    temporary = Path(name)
    try:
        yield temporary
        os.chmod(temporary, 0o666 & ~_umask())
        os.replace(temporary, path)
    except BaseException as error:
        temporary.unlink(missing_ok=True)
        if isinstance(error, OSError):
            raise OSError(error.errno, error.strerror or str(error), str(path)) from None
        raise


@contextmanager
def replacing_by_suffix(path: Path) -> Iterator[Path]:
    """As `replacing`, for a library that goes by the suffix: there is no file of the temporary name yet."""
    with replacing(path) as temporary:
        named = temporary.with_name(temporary.name + path.suffix)
        try:
            yield named
            named.replace(temporary)
        finally:
            named.unlink(missing_ok=True)


@contextmanager
def failures_named(path: str | os.PathLike[str]) -> Iterator[None]:
    """What the system says while a file is written, as an error of bad input.

    Raises
    ------
    InputError
        For every OSError.
    """
    try:
        yield
    except OSError as error:
        raise InputError(f"cannot be written: {error.strerror or error}.", where=str(path)) from None


@contextmanager
def _beside_a_device(path: Path) -> Iterator[Path]:
    """What is no file (/dev/stdout, a pipe) is written to: a file in its place would be in everybody's way."""
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
