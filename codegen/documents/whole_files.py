"""Files written whole or not at all."""

from __future__ import annotations

import errno
import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from ..interrupts import deferred_interrupts

#: Bytes that are written at a time: an interrupt is seen between them.
BLOCK = 1 << 20


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
