"""Arguments and results of kernels, as functions of arrays see them."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Argument:
    """Shape of one argument or result: its name and the length of its last axis (0: no such axis)."""

    name: str
    size: int
    is_status: bool = False
