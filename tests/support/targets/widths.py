"""Widths of vectors in bytes that this processor runs, and the text around what is compiled for one."""

from __future__ import annotations

from bladesmith.codegen.build.cpu_features import runs
from bladesmith.codegen.targets.c.instances import OF_KERNELS

BEGIN = {32: "BS_V3_BEGIN", 64: "BS_V4_BEGIN"}
WIDTHS = (0, 16, *(int(i.bytes) for i in OF_KERNELS if i.wide and i.bits == 64 and runs(i)))


def enclosed(width: int, text: str) -> str:
    """A text for one width of vectors."""
    return f"{BEGIN[width]}\n{text}\nBS_V3_END" if width in BEGIN else text


__all__ = ["WIDTHS", "enclosed"]
