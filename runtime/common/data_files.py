"""Arrays in NPZ files, under a header of plain data, and tables of numbers in CSV files.

Reading an NPZ file never executes anything; its header, and the size of all of it, are checked before an array is
unpacked.
"""

from __future__ import annotations

import csv
import io
import json
import math
import os
import platform
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any, TypeVar
from zipfile import ZIP_DEFLATED, ZIP_STORED, ZipFile

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray

from ..codegen.documents.whole_files import BLOCK
from ..codegen.errors import BladesmithError, InputError
from ..codegen.version import __version__
from .files import as_path, failures_named, replacing
from .memory import readable

T = TypeVar("T")
Arrays = dict[str, NDArray[Any]]
#: Name of the array that holds the header: JSON in bytes.
HEADER = "bladesmith"
#: Largest size of a header, in bytes.
MAX_HEADER = 1_000_000
#: Largest size of a file's arrays as a multiple of the file, beyond a size that is always read, in bytes.
MAX_RATIO, ALWAYS_UNPACKED = 100, 64_000_000
#: Characters of another package's message that are repeated.
LONGEST_REASON = 200
#: Suffix of an array's name in the file.
SUFFIX = ".npy"
#: Readers of the descriptions of arrays, by version.
_DESCRIPTIONS = {(1, 0): npy.read_array_header_1_0, (2, 0): npy.read_array_header_2_0}
#: Suffixes of the formats.
FORMATS = (".npz", ".csv")


def producer_versions() -> dict[str, str]:
    """Versions that made a file, for its header."""
    return {"bladesmith": __version__, "numpy": np.__version__, "python": platform.python_version()}


def npz_bytes(arrays: Mapping[str, NDArray[Any]], header: Mapping[str, Any], compressed: bool = True) -> bytes:
    """Bytes of an NPZ file of arrays, with a header that JSON can say."""
    buffer = io.BytesIO()
    _write(buffer, arrays, header, compressed)
    return buffer.getvalue()


def write_npz(path: Path, arrays: Mapping[str, NDArray[Any]], header: Mapping[str, Any]) -> None:
    """Write an NPZ file, not compressed, whole or not at all.

    Raises
    ------
    InputError
        If it cannot be written.
    """
    with failures_named(path), replacing(path) as temporary:
        _write(temporary, arrays, header, compressed=False)


def _write(file: Any, arrays: Mapping[str, NDArray[Any]], header: Mapping[str, Any], compressed: bool) -> None:
    """As NumPy's `savez`, in blocks between which an interrupt is seen."""
    stored = {**arrays, HEADER: np.frombuffer(json.dumps(header).encode(), np.uint8)}
    with ZipFile(file, "w", ZIP_DEFLATED if compressed else ZIP_STORED) as archive:
        for name, given in stored.items():
            array = np.require(given, requirements="C")
            with archive.open(name + SUFFIX, "w", force_zip64=True) as member:
                npy.write_array_header_1_0(member, npy.header_data_from_array_1_0(array))
                data = array.reshape(-1).view(np.uint8).data
                for begin in range(0, len(data), BLOCK):
                    member.write(data[begin : begin + BLOCK])


def read_npz(
    path: Any, what: str, writer: str, expected: Mapping[str, Any], build: Callable[[dict[str, Any], Arrays], T]
) -> T:
    """Read an NPZ file that `npz_bytes` gave.

    Parameters
    ----------
    path : path
    what, writer : str
        Contents of the file and the function that writes it, for messages: "a trajectory", "trajectory.save".
    expected : mapping
        Items that the header has: format and version. Others are of another release.
    build : callable
        Makes the result from the header and the arrays; whatever it raises means that the file is damaged.

    Raises
    ------
    InputError
        If the file cannot be read, is damaged, or holds something else.
    """
    file = as_path(path, f"{what} is read from")
    if os.path.exists(file) and not os.path.isfile(file):  # a pipe would be waited for
        raise InputError("is not a file.", where=str(file), remedy="NPZ is read at any place of a file: copy it to one")
    try:
        with ZipFile(file) as archive:
            header = _read_header(archive, expected)
            _check_size(archive, file)
            names = [member.filename.removesuffix(SUFFIX) for member in archive.infolist()]
            arrays = {name: _read_array(archive, name) for name in names if name != HEADER}
        return build(header, arrays)
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror or error}.", where=str(file)) from None
    except BladesmithError as error:
        raise InputError(str(error), where=str(file)) from None
    except Exception as error:  # a damaged archive raises anything: zlib.error, MemoryError, NotImplementedError, ...
        reason = " ".join(str(error).split())[:LONGEST_REASON]
        detail = "" if "pickle" in reason else f" ({reason})"  # NumPy recommends unsafe loading
        raise InputError(f"is not a file that {writer}() wrote{detail}.", where=str(file)) from None


def _read_header(archive: ZipFile, expected: Mapping[str, Any]) -> dict[str, Any]:
    if archive.getinfo(HEADER + SUFFIX).file_size > MAX_HEADER:
        raise ValueError("its header is too long")
    raw = _read_array(archive, HEADER)
    if raw.dtype != np.uint8 or raw.ndim != 1:
        raise ValueError("its header is of another type")
    header = json.loads(raw.tobytes())
    for key, value in expected.items():
        if header[key] != value:
            raise InputError(
                f"its {key} is {header[key]!r}; this release reads {value!r}.",
                remedy="A newer release of bladesmith may read it",
            )
    return header  # type: ignore[no-any-return]


def _check_size(archive: ZipFile, file: Path) -> None:
    """Refuse a file of some bytes that says that it unpacks to all there is."""
    size, packed = sum(member.file_size for member in archive.infolist()), file.stat().st_size
    if size > max(ALWAYS_UNPACKED, MAX_RATIO * packed):
        raise InputError(
            f"its {readable(packed)} unpack to {readable(size)}; "
            f"beyond {readable(ALWAYS_UNPACKED)} that is at most {MAX_RATIO} times as much."
        )


def _read_array(archive: ZipFile, name: str) -> NDArray[Any]:
    """An array, whose size by its own description is checked before memory is taken for it."""
    with archive.open(name + SUFFIX) as member:
        shape, _, dtype = _DESCRIPTIONS[npy.read_magic(member)](member)
        size = archive.getinfo(name + SUFFIX).file_size - member.tell()
    if math.prod(shape) * dtype.itemsize != size:
        raise ValueError(f"its array {name!r} has not the size that it says")
    with archive.open(name + SUFFIX) as member:
        array = npy.read_array(member, allow_pickle=False)
        member.read()  # to its end, where its checksum is compared
    return array


def csv_text(columns: Iterable[tuple[str, str]], rows: Iterable[Iterable[Any]]) -> str:
    """Text of a CSV file, whose numbers read back to the last bit.

    Parameters
    ----------
    columns : iterable of (name, unit)
        A column without a unit has an empty one.
    rows : iterable
        Texts, and numbers of Python.
    """
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow([f"{name} [{unit}]" if unit else name for name, unit in columns])
    writer.writerows(rows)
    return text.getvalue()


__all__ = ["FORMATS", "csv_text", "npz_bytes", "producer_versions", "read_npz", "write_npz"]
