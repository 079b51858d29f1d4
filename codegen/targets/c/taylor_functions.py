"""Taylor series of kernels: C text that makes coefficient k of the outputs from those up to k of the inputs.

Kernels are run on the ring of power series (rings/power_series.py) and printed for vectors of each width (taylor.py).
Coefficients are normalised: x = sum of x_k t^k.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from ...rings.power_series import Item, SeriesRing
from ...trace.kernel import Kernel
from .printer import ELEMENTARY
from .taylor import HIGHEST_ORDER, WIDTHS, SeriesPrinter

__all__ = ["HIGHEST_ORDER", "WIDTHS", "SeriesFunction", "series_function"]


@dataclass(frozen=True)
class SeriesFunction:
    """The text of one function, for each width of vectors.

    Attributes
    ----------
    name : str
    texts : mapping of str to str
        By the names of `WIDTHS`.
    inputs, outputs : mapping of str to int
        Its arguments after the order and the work space, outputs first: numbers of each.
    work : int
        Numbers that it keeps from order to order.
    products : int
        Convolutions.
    elementary : bool
        Whether it needs elementary.h.
    """

    name: str
    texts: Mapping[str, str]
    inputs: Mapping[str, int]
    outputs: Mapping[str, int]
    work: int
    products: int
    elementary: bool


def series_function(name: str, kernels: Sequence[Kernel], still: Sequence[str] = ()) -> SeriesFunction:
    """Kernels as one function of series, arguments of one name being one argument.

    Parameters
    ----------
    name : str
        Of the function.
    kernels : sequence of Kernel
        Their outputs become those of the function, in order; alike names are told apart by the kernels' names.
    still : sequence of str
        Arguments that do not vary in time: numbers, not series.

    Raises
    ------
    TraceError
        If a function has no recurrence (Stumpff functions: they have none of bounded length at zero).
    """
    ring = SeriesRing()
    outputs: list[tuple[str, tuple[Item, ...]]] = []
    inputs: dict[str, int] = {}
    for kernel in kernels:
        flat = [ring.input(i.name, j, i.name not in still) for i in kernel.inputs for j in range(i.kind.size)]
        inputs.update({i.name: i.kind.size for i in kernel.inputs})
        for output, values in zip(kernel.outputs, kernel.evaluate_flat(flat, ring), strict=True):
            several = f"{kernel.name}_{output.name}" if len(kernel.outputs) > 1 else kernel.name
            own = output.name if len(kernels) == 1 else several
            outputs.append((own, tuple(values)))
    texts = {}
    for width, tag in WIDTHS.items():
        printer = SeriesPrinter(ring, outputs, width)
        texts[tag] = printer.function(f"{name}_{tag}", list(inputs), [i for i in inputs if i in still])
    needed = {item.op for item in printer.order}
    sizes = {output: len(items) for output, items in outputs}
    return SeriesFunction(name, texts, inputs, sizes, printer.size, printer.products, bool(needed & ELEMENTARY))
