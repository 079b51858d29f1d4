"""Curves of geometric objects. For now: Bezier curves of first degree, between two control objects."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ..errors import InputError

__all__ = ["Bezier"]


class Bezier:
    """Bezier curve over control objects; t = 0 is the first, t = 1 the last.

    Parameters
    ----------
    controls : sequence of two objects
        Circles as (center, normal, radius), or as their coefficients.
    """

    def __init__(self, controls: Sequence[Any]) -> None:
        if len(controls) != 2:
            raise InputError(f"a Bezier curve of first degree has 2 control objects, not {len(controls)}.")
        self.controls = tuple(controls)

    @property
    def degree(self) -> int:
        """Degree of the polynomial."""
        return len(self.controls) - 1

    def __repr__(self) -> str:
        return f"Bezier({list(self.controls)!r})"
