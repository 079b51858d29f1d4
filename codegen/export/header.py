"""What every exported file begins with: what it is, whose it is, how to compile it, and its conventions."""

from __future__ import annotations

import textwrap

from ..status import Status
from ..targets.printer import comment_text
from ..version import __version__
from .unit import Unit

_WIDTH = 112


#: What most languages promise of numbers.
SAME_BITS = (
    "The same numbers give the same bits in every language and on every machine, but for those of a NaN, where "
    "products and sums are not contracted (gcc, clang: -ffp-contract=off) and not reordered (no -ffast-math)."
)


def _wrapped(text: str) -> list[str]:
    """Lines, which joined by spaces are the text: it is read again where a file is overwritten."""
    return textwrap.wrap(text, _WIDTH, break_long_words=False, break_on_hyphens=False)


def header_lines(unit: Unit, arithmetic: str = SAME_BITS) -> list[str]:
    """Lines of the comment at the beginning of a file; ``arithmetic``: what is said of its numbers."""
    codes = ", ".join(f"{code.value} {code.name}" for code in Status)
    has_status = any(s.is_status for e in unit.entries for s in e.outputs)
    count = len(unit.entries)
    parts = [
        f"{unit.name}: {count} function{'' if count == 1 else 's'} of geometric algebra, by bladesmith {__version__}.",
        "This text is yours: use, change and pass it on as you like, without conditions "
        "(SPDX-License-Identifier: 0BSD).",
        "",
        f"Source: {comment_text(unit.source)}",
        f"Functions: {', '.join(e.name for e in unit.entries)}.",
        "",
        arithmetic,
        "Angles are in radians, lengths in whatever unit the arguments have. Coefficients stand in the order of the "
        "fields; s is the scalar, e12 that of the blade e12.",
    ]
    if has_status:
        parts.append(f"Codes of status: {codes}. Values of items with another code than 0 are NaN or as the code says.")
    return [line for part in parts for line in (_wrapped(part) or [""])]
