"""Text of multivectors: mathematics, batches abbreviated."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..common.validation import as_bool, as_int
from ..dispatch.multivector_data import MultivectorData
from ..status import Status


@dataclass(frozen=True)
class PrintOptions:
    """How multivectors are printed.

    Attributes
    ----------
    unicode : bool
        Subscripts in place of letters and digits: e\u2081\u2082 for e12, n\u2092 and n\u221e for no and ni.
    digits : int
        Significant digits of coefficients.
    terms : int
        Terms of one item that are shown.
    edge : int
        Items at each end of a batch that are shown; the rest is dots.
    """

    unicode: bool = False
    digits: int = 6
    terms: int = 12
    edge: int = 3


DEFAULT = PrintOptions()
_options: ContextVar[PrintOptions] = ContextVar("bladesmith_print_options", default=DEFAULT)


def set_print_options(
    *, unicode: bool | None = None, digits: int | None = None, terms: int | None = None, edge: int | None = None
) -> None:
    """Set how multivectors are printed from now on; what is not given stays.

    Parameters
    ----------
    unicode : bool, optional
        Print e\u2081\u2082 for e12, and n\u2092, n\u221e for no, ni.
    digits : int, optional
        Significant digits of coefficients, 6 at first.
    terms : int, optional
        Terms of one item that are shown, 12 at first.
    edge : int, optional
        Items at each end of a batch that are shown, 3 at first.

    Raises
    ------
    InputError
        If a value is not a flag, or not a number in range.
    """
    _options.set(_changed(unicode, digits, terms, edge))


@contextmanager
def print_options(
    *, unicode: bool | None = None, digits: int | None = None, terms: int | None = None, edge: int | None = None
) -> Iterator[None]:
    """Context in which multivectors are printed in another way; parameters of `set_print_options`."""
    token = _options.set(_changed(unicode, digits, terms, edge))
    try:
        yield
    finally:
        _options.reset(token)


def _changed(unicode: Any, digits: Any, terms: Any, edge: Any) -> PrintOptions:
    given: dict[str, Any] = {} if unicode is None else {"unicode": as_bool(unicode, "unicode")}
    for name, value, high in (("digits", digits, MOST_DIGITS), ("terms", terms, None), ("edge", edge, None)):
        if value is not None:
            given[name] = as_int(value, name, 1, high)
    return replace(_options.get(), **given)


#: Significant digits that a double has.
MOST_DIGITS = 17


def plain(x: MultivectorData) -> str:
    """``point of cga3d: 1 e1 + 2 e2 + 1 no + 2.5 ni``."""
    head = _head(x)
    if not x.shape:
        return f"{head}: {_item(x, ())}"
    rows = (f"  [{', '.join(map(str, i))}] {_item(x, i)}" if i is not None else "  ..." for i in _shown(x))
    return "\n".join([f"{head}:", *rows])


def _head(x: MultivectorData) -> str:
    head = f"{_kind_name(x)} of {x.algebra.name}" + (", float32" if x.dtype == np.float32 else "")
    return f"{head}, shape {x.shape}" if x.shape else head


def _shown(x: MultivectorData) -> list[tuple[int, ...] | None]:
    """Indices of the items of a batch that are shown, None for those between its ends."""
    edge = _options.get().edge
    if x.size <= 2 * edge:
        return list(np.ndindex(x.shape))
    ends = [*range(edge), *range(x.size - edge, x.size)]
    indices = [tuple(int(i) for i in np.unravel_index(i, x.shape)) for i in ends]
    return [*indices[:edge], None, *indices[edge:]]


def _kind_name(x: MultivectorData) -> str:
    """The kind's name; "layout motor" for a motor's blades with nothing known."""
    named = x.algebra.kinds.get(x.kind.name)
    is_bare = named is not None and named.constraints and x.kind.is_layout
    return f"layout {x.kind.name}" if is_bare else x.kind.name


def _item(x: MultivectorData, index: tuple[int, ...]) -> str:
    text, status = _sum([(_number(v), blade_text(x.algebra, b)) for b, v in _terms(x, index)]), _status(x, index)
    return f"{text} {status}" if status else text


def _status(x: MultivectorData, index: tuple[int, ...]) -> str:
    status = np.asarray(x.status)[index]
    return "" if status == Status.OK else f"({Status(int(status)).name})"


def _terms(x: MultivectorData, index: tuple[int, ...]) -> list[tuple[int, float]]:
    row = x.values[index]
    return [(b, float(v)) for b, v in zip(x._type.blades, row, strict=True) if v != 0]


def _number(value: float) -> str:
    return f"{value:.{_options.get().digits}g}"


def _sum(terms: list[tuple[str, str]]) -> str:
    most = _options.get().terms
    shown = terms if len(terms) <= most + 1 else terms[:most]
    text = join_terms((n.startswith("-"), n.lstrip("-") + (f" {b}" if b != "1" else "")) for n, b in shown)
    return text if shown is terms else f"{text} + ... ({len(terms)} terms)"


def join_terms(terms: Iterable[tuple[bool, str]]) -> str:
    """A sum from its terms' signs, true for minus, and the rest of their text; "0" without terms."""
    text = ""
    for negative, term in terms:
        text += ((" - " if negative else " + ") if text else ("-" if negative else "")) + term
    return text or "0"


def latex(x: MultivectorData) -> str:
    """LaTeX for notebooks, with subscripts; of a batch the shape and its ends."""
    if not x.shape:
        return f"${_latex_item(x, ())}$"
    rows = [_latex_text(_head(x)), *(r"\vdots" if i is None else _latex_item(x, i) for i in _shown(x))]
    return "$\\begin{array}{l}" + r"\\".join(rows) + "\\end{array}$"


def _latex_item(x: MultivectorData, index: tuple[int, ...]) -> str:
    terms = [(_latex_number(v), latex_blade(x.algebra, b)) for b, v in _terms(x, index)]
    text, status = _sum(terms).replace("...", r"\dots"), _status(x, index)
    return text + (rf"\quad{_latex_text(status)}" if status else "")


def _latex_text(text: str) -> str:
    return rf"\text{{{text}}}".replace("_", r"\_")


def _latex_number(value: float) -> str:
    mantissa, _, exponent = _number(value).partition("e")
    if exponent:
        return rf"{mantissa} \cdot 10^{{{int(exponent)}}}"
    return mantissa.replace("inf", r"\infty").replace("nan", r"\text{nan}")


def latex_blade(algebra: Any, blade: int) -> str:
    """Name of a blade in LaTeX."""
    if blade == 0:
        return "1"
    runs = algebra.label_runs(blade)
    joint = "," if any(len(v) > 1 for run in runs for v in run if v.isdigit()) else ""
    return "".join(
        rf"\mathbf{{e}}_{{{joint.join(run)}}}"
        if run[0].isdigit()
        else r" \wedge ".join(WORDS.get(v, rf"\mathbf{{{v}}}".replace("_", r"\_")) for v in run)
        for run in runs
    )


#: Vectors that are not numbered.
WORDS = {"no": r"\mathbf{n}_{0}", "ni": r"\mathbf{n}_{\infty}"}


def blade_text(algebra: Any, blade: int) -> str:
    """Name of a blade as it is printed: with subscripts, vectors whose numbers have several digits one by one."""
    if blade == 0 or not _options.get().unicode:
        return str(algebra.blade_name(blade))
    joint, wedge = ("e", "\u2227") if algebra.has_wide_labels else ("", "")
    return "".join(
        "e" + joint.join(v.translate(SUBSCRIPTS) for v in run)
        if run[0].isdigit()
        else wedge.join(UNICODE_WORDS.get(v, v) for v in run)
        for run in algebra.label_runs(blade)
    )


SUBSCRIPTS = str.maketrans("0123456789", "".join(chr(0x2080 + digit) for digit in range(10)))
UNICODE_WORDS = {"no": "n\u2092", "ni": "n\u221e"}
