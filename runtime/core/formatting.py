"""Text of multivectors: mathematics, batches abbreviated."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..dispatch.multivector_data import MultivectorData
from ..status import Status

#: Items at each end of a batch that are shown; the rest is dots.
EDGE = 3
#: Terms of one item that are shown.
MOST_TERMS = 12
#: Significant digits.
DIGITS = 6


def plain(x: MultivectorData) -> str:
    """``point of cga3d: 1 e1 + 2 e2 + 1 no + 2.5 ni``."""
    head = f"{_kind_name(x)} of {x.algebra.name}"
    if x.dtype == np.float32:
        head += ", float32"
    if not x.shape:
        return f"{head}: {_item(x, ())}"
    lines = [f"{head}, shape {x.shape}:"]
    indices = list(np.ndindex(x.shape)) if x.size <= 2 * EDGE else None
    if indices is None:
        ends = [*range(EDGE), *range(x.size - EDGE, x.size)]
        indices = [tuple(int(i) for i in np.unravel_index(i, x.shape)) for i in ends]
    for count, index in enumerate(indices):
        if count == EDGE and x.size > 2 * EDGE:
            lines.append("  ...")
        lines.append(f"  [{', '.join(map(str, index))}] {_item(x, index)}")
    return "\n".join(lines)


def _kind_name(x: MultivectorData) -> str:
    """The kind's name; "layout motor" for a motor's blades with nothing known."""
    named = x.algebra.kinds.get(x.kind.name)
    is_bare = named is not None and named.constraints and x.kind.is_layout
    return f"layout {x.kind.name}" if is_bare else x.kind.name


def _item(x: MultivectorData, index: tuple[int, ...]) -> str:
    text = _sum([(_number(v), x.algebra.blade_name(b)) for b, v in _terms(x, index)])
    status = np.asarray(x.status)[index]
    return text if status == Status.OK else f"{text} ({Status(int(status)).name})"


def _terms(x: MultivectorData, index: tuple[int, ...]) -> list[tuple[int, float]]:
    row = x.values[index]
    return [(b, float(v)) for b, v in zip(x._type.blades, row, strict=True) if v != 0]


def _number(value: float) -> str:
    return f"{value:.{DIGITS}g}"


def _sum(terms: list[tuple[str, str]]) -> str:
    if not terms:
        return "0"
    shown = terms if len(terms) <= MOST_TERMS + 1 else terms[:MOST_TERMS]
    text = ""
    for number, blade in shown:
        negative = number.startswith("-")
        joint = (" - " if negative else " + ") if text else ("-" if negative else "")
        text += joint + number.lstrip("-") + (f" {blade}" if blade != "1" else "")
    return text if shown is terms else f"{text} + ... ({len(terms)} terms)"


def latex(x: MultivectorData) -> str:
    """LaTeX for notebooks, with subscripts; a batch is abbreviated to its ends."""
    if not x.shape:
        return f"${_latex_item(x, ())}$"
    rows = [f"{_latex_item(x, (i, *([0] * (x.ndim - 1))))}" for i in range(min(x.shape[0], EDGE))] if x.size else []
    if x.size and x.shape[0] > EDGE:
        rows.append(r"\vdots")
    return "$\\begin{array}{l}" + r"\\".join(rows) + "\\end{array}$"


def _latex_item(x: MultivectorData, index: tuple[int, ...]) -> str:
    terms = [(_latex_number(v), _latex_blade(x.algebra, b)) for b, v in _terms(x, index)]
    return _sum(terms).replace("...", r"\dots")


def _latex_number(value: float) -> str:
    mantissa, _, exponent = _number(value).partition("e")
    return f"{mantissa} \\cdot 10^{{{int(exponent)}}}" if exponent else mantissa.replace("inf", r"\infty")


def _latex_blade(algebra: Any, blade: int) -> str:
    if blade == 0:
        return "1"
    labels = [v for i, v in enumerate(algebra.vectors) if blade >> i & 1]
    digits = [v for v in labels if v.isdigit()]
    joint = "," if any(len(v) > 1 for v in digits) else ""
    words = [rf"\mathbf{{n}}_{{{WORDS.get(v, v)}}}" for v in labels if not v.isdigit()]
    return (rf"\mathbf{{e}}_{{{joint.join(digits)}}}" if digits else "") + r" \wedge ".join(words)


#: Subscripts of vectors that are not numbered.
WORDS = {"no": "0", "ni": r"\infty"}
