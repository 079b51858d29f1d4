"""Memory of the machine: what can never fit is refused before anything is allocated; large arrays that are filled."""

from __future__ import annotations

import math
import os
import re
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..codegen.errors import InputError

_MEMINFO = Path("/proc/meminfo")
#: Limits of containers: version 2 and version 1 of control groups. What they count as used may be given back.
_LIMITS = (Path("/sys/fs/cgroup/memory.max"), Path("/sys/fs/cgroup/memory/memory.limit_in_bytes"))
#: More bytes than anybody has.
_MOST = 10**30
#: Bytes that a machine is taken to have if it does not say.
_ASSUMED = 64 << 30
#: Numbers that are written at a time.
_FILLED = 1 << 22
_UNITS = ("bytes", "kB", "MB", "GB", "TB", "PB")


def available() -> int | None:
    """Bytes that can be had: what Linux counts as available, elsewhere all there is; None where nobody tells."""
    found = [_system(), *(_group(limit) for limit in _LIMITS)]
    return min((value for value in found if value is not None), default=None)


@cache
def total() -> int:
    """Bytes of memory of the machine."""
    try:
        return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    except (AttributeError, OSError, ValueError):  # Windows
        return _ASSUMED


def check_workspace(size: int, threads: int, what: str) -> None:
    """Raise `InputError` if a compiled driver needs more bytes for each thread than there are."""
    there = total()
    if size * threads > there:
        raise InputError(
            f"{what} takes {size} bytes of memory for each of {threads} threads; this machine has {there} bytes.",
            remedy="Take fewer bodies" + (", or fewer threads" if threads > 1 else ""),
        )


def fill(array: NDArray[Any], value: Any) -> None:
    """Fill an array without gaps, in blocks between which an interrupt is seen: memory is cleared as it is written."""
    flat = array.reshape(-1)
    for begin in range(0, flat.size, _FILLED):
        flat[begin : begin + _FILLED] = value


def filled(shape: Sequence[int], value: Any, dtype: Any = np.float64) -> NDArray[Any]:
    """A new array that holds one value; see `fill`."""
    if math.prod(shape) <= _FILLED:
        return np.full(tuple(shape), value, dtype)
    array = np.empty(tuple(shape), dtype)
    fill(array, value)
    return array


def readable(count: int) -> str:
    """A number of bytes as people say it."""
    power, size = 0, float(min(count, _MOST))
    while size >= 1000 and power < len(_UNITS) - 1:
        size, power = size / 1000, power + 1
    return f"{size:.3g} {_UNITS[power]}"


def _system() -> int | None:
    try:
        match = re.search(r"^MemAvailable:\s+(\d+) kB", _MEMINFO.read_text(encoding="ascii"), re.MULTILINE)
        if match:
            return int(match.group(1)) * 1024
    except OSError:
        pass
    try:
        return os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    except (AttributeError, ValueError, OSError):
        return None


def _group(limit: Path) -> int | None:
    try:
        return int(limit.read_text(encoding="ascii"))
    except (OSError, ValueError):  # no such group, or no limit: "max"
        return None
