"""Methods beside ours: the form that is printed, and functions of the package `clifford`."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from ....interchange.clifford import from_clifford
from ...harness.algebras import cga3d
from ...harness.study import PRECISIONS, Method


def methods(
    printed_name: str, kernel: Callable[..., Any], printed: Callable[..., Any], clifford: Callable[..., Any]
) -> tuple[Method, ...]:
    """Ours, the printed form, and that of `clifford` in full runs only: it compiles for some seconds."""
    return (
        Method("bladesmith", kernel, "precision", PRECISIONS),
        Method(printed_name, printed, "precision", PRECISIONS),
        Method("clifford", clifford, slow=True, copies=1, requires="clifford"),
    )


def clifford_results(function: Callable[..., Any], *operands: Any) -> Any:
    """A function of `clifford` on each item of batches; NaN where it raises an error."""
    from clifford.g3c import layout

    def attempt(*items: Any) -> Any:
        try:
            return function(*items)
        except (ArithmeticError, ValueError, TypeError, np.linalg.LinAlgError):
            return layout.MultiVector(np.full(layout.gaDims, np.nan))

    with np.errstate(all="ignore"):
        results = [attempt(*items) for items in zip(*(x.to_clifford(layout) for x in operands), strict=True)]
    return from_clifford(results, algebra=cga3d)
