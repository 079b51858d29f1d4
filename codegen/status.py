"""Codes that say, item by item, why a function gave no answer or made a choice. Light: the standard library only.

Formulas return them beside their values; the runtime shows them as `bladesmith.Status`.
"""

from __future__ import annotations

from enum import IntEnum


class Status(IntEnum):
    """Outcome of one item; values other than `OK` and `NOT_UNIQUE` come with NaN."""

    OK = 0
    #: Not invertible, of norm zero, or without the parameters that were asked for.
    SINGULAR = 1
    #: The answer is no real object.
    IMAGINARY = 2
    #: There are several answers; the documented one was returned.
    NOT_UNIQUE = 3
    #: No posture or path leads there.
    UNREACHABLE = 4
    #: An iteration stopped before it reached its tolerance.
    NOT_CONVERGED = 5
    #: The input is no member of its kind, or not finite.
    INVALID = 6
