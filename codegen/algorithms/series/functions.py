"""Taylor series of kernels: algorithms that compute coefficient k of the outputs from those up to k of the inputs.

Kernels are run on the ring of power series (rings/power_series.py) and written in the language of algorithms (text.py).
"""

from __future__ import annotations

import linecache
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from ...errors import TraceError
from ...ir.loops import language
from ...ir.loops.algorithm import Algorithm, inlined
from ...rings.power_series import Item, SeriesRing
from ...trace.kernel import Kernel
from .recurrences import RECURRENCES, convolve
from .text import SeriesText


class Argument(NamedTuple):
    """An argument of a kernel in a row of numbers.

    Attributes
    ----------
    row : str
        Name of the row.
    offset : int
        Where in it the argument begins.
    varies : bool
        Whether the row is coefficient k of a series; else it has numbers that do not depend on time.
    """

    row: str
    offset: int = 0
    varies: bool = True


class Term(NamedTuple):
    """A kernel as a part of a series function.

    Attributes
    ----------
    kernel : Kernel
    arguments : tuple of Argument
        Of the kernel.
    results : tuple of str
        Of the function, to which the kernel's outputs are added.
    """

    kernel: Kernel
    arguments: tuple[Argument, ...]
    results: tuple[str, ...]


class SeriesFunction(NamedTuple):
    """Coefficient k of some results.

    Attributes
    ----------
    compute : Algorithm
        Of k, the numbers that are kept from order to order, results and rows.
    size : int
        Numbers that are kept.
    products : int
        Convolutions.
    results, rows : mapping of str to int
        Numbers of each.
    text : str
        Of the algorithm.
    """

    compute: Algorithm
    size: int
    products: int
    results: Mapping[str, int]
    rows: Mapping[str, int]
    text: str


def series_function(
    name: str, terms: Sequence[Term], rows: Mapping[str, int], of_items: bool = False
) -> SeriesFunction:
    """Sums of kernels as one algorithm on series.

    Parameters
    ----------
    name : str
        Of the algorithm.
    terms : sequence of Term
        Outputs with one name are added, in this order.
    rows : mapping of str to int
        Rows that the arguments are in, with their sizes: parameters of the algorithm behind the results.
    of_items : bool
        Whether it is for several items at once; the bits are the same.

    Raises
    ------
    TraceError
        If a function has no recurrence (Stumpff functions: they have none of bounded length at zero), or an argument
        is not in its row.
    """
    ring = SeriesRing()
    sums: dict[str, list[list[Item]]] = {}
    for kernel, arguments, results in terms:
        flat = [
            item
            for declared, argument in zip(kernel.inputs, arguments, strict=True)
            for item in _inputs(ring, name, rows, argument, declared.kind.size)
        ]
        for result, values in zip(results, kernel.evaluate_flat(flat, ring), strict=True):
            parts = sums.setdefault(result, [[] for _ in values])
            for part, value in zip(parts, values, strict=True):
                part.append(value)
    written = SeriesText(ring, list(sums.items()), of_items)
    sizes = {result: len(parts) for result, parts in sums.items()}
    size = max(written.size, 1)
    parameters = ", ".join([
        "k: Int", f"work: InOut[Vector[{size}]]", *(f"{result}: Out[Vector[{n}]]" for result, n in sizes.items()),
        *(f"{row}: Vector[{n}]" for row, n in rows.items()),
    ])  # fmt: skip
    note = f'    """Coefficient k of {", ".join(sizes)}."""'
    text = "\n".join([f"def {name}({parameters}) -> None:", note, *(f"    {line}" for line in written.lines), ""])
    return SeriesFunction(_algorithm(name, text), size, written.products, sizes, dict(rows), text)


def _inputs(ring: SeriesRing, name: str, rows: Mapping[str, int], argument: Argument, size: int) -> list[Item]:
    if argument.offset + size > rows.get(argument.row, 0):
        raise TraceError(f"the series {name} has no {size} numbers from {argument.offset} on in {argument.row!r}.")
    return [ring.input(argument.row, argument.offset + j, argument.varies) for j in range(size)]


def _algorithm(name: str, text: str) -> Algorithm:
    """The algorithm with this text, which tracebacks and refusals quote."""
    file = f"<series {name} {hash(text):x}>"
    linecache.cache[file] = (len(text), None, text.splitlines(keepends=True), file)
    names: dict[str, Any] = {
        "convolve": convolve, **{each.name: each for each in RECURRENCES.values()},
        **{each: getattr(language, each) for each in _WORDS},
    }  # fmt: skip
    exec(compile(text, file, "exec", dont_inherit=True), names)
    return inlined(names[name])


#: Names of the language that the text has.
_WORDS = ("InOut", "Int", "NAN", "Out", "Vector", "atan2", "cos", "empty", "epsilon", "exp", "log", "sin", "sqrt")
