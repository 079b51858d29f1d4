"""Multivectors as those of the package `clifford`: its layouts are orthonormal, dense, and one multivector at a time.

Signs and bases are settled here: `blade_table` says which blade of ours, with which sign, each coefficient of a layout
is. The other direction is in `interchange.clifford`.
"""

from __future__ import annotations

from functools import cache
from importlib import import_module
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.errors import BladesmithError, MissingExtraError, SignatureError
from ...dispatch.multivector_data import MultivectorData
from ...dispatch.types import TypedAlgebra
from . import basis_change


def to_clifford(x: MultivectorData, layout: Any = None) -> Any:
    """x, on orthonormal vectors, as a multivector of `clifford`, or for a batch an array (``MVArray``) of them.

    Parameters
    ----------
    x : MultivectorData
    layout : clifford.Layout, optional
        For example ``clifford.g3c.layout``. Default: ``clifford.Cl(p, q, r)``, made once.

    Raises
    ------
    SignatureError
        If the layout has another signature.
    """
    package = clifford_package()
    layout = layout if layout is not None else default_layout(*x.algebra.signature)
    signature = layout_signature(layout)
    if signature != x.algebra.signature:
        raise SignatureError(f"the layout is Cl{signature}, the multivector Cl{x.algebra.signature}.")
    columns, signs = blade_table(x.algebra, *layout_blades(layout))
    values = basis_change.dense(x, x.algebra)[..., columns] * signs
    if not x.shape:
        return layout.MultiVector(values)
    items = np.empty(x.shape, object)
    for index in np.ndindex(x.shape):
        items[index] = layout.MultiVector(values[index])
    return items.view(package.MVArray)


@cache
def default_layout(p: int, q: int, r: int) -> Any:
    """``clifford.Cl(p, q, r)``; a single null vector is called e0 there as here."""
    package = clifford_package()
    layout, _ = package.Cl(p, q, r, firstIdx=0) if r == 1 else package.Cl(p, q, r)
    return layout


def layout_signature(layout: Any) -> tuple[int, int, int]:
    """Numbers (p, q, r) of vectors of square 1, -1 and 0.

    Raises
    ------
    SignatureError
        If a vector has another square.
    """
    squares = [int(s) for s in layout.sig]
    if any(s not in (1, -1, 0) for s in squares):
        raise SignatureError(f"the layout's vectors have the squares {squares}; they are 1, -1 or 0 here.")
    return squares.count(1), squares.count(-1), squares.count(0)


def layout_blades(layout: Any) -> tuple[tuple[int, ...], tuple[tuple[int, ...], ...]]:
    """Squares of a layout's vectors, and for each coefficient its vectors by position."""
    position = {identity: i for i, identity in enumerate(layout._basis_vector_ids.values)}
    blades = tuple(tuple(position[i] for i in ids) for ids in layout.bladeTupList)
    return tuple(int(s) for s in layout.sig), blades


@cache
def blade_table(
    algebra: TypedAlgebra, squares: tuple[int, ...], blades: tuple[tuple[int, ...], ...]
) -> tuple[NDArray[Any], NDArray[Any]]:
    """For each coefficient of a layout: the index of its blade among ours, and its sign.

    The k-th vector of square s there is the k-th vector of square s here; a blade's vectors in another order change
    its sign.
    """
    by_square: dict[int, list[str]] = {1: [], -1: [], 0: []}
    for i, label in enumerate(algebra.vectors):
        by_square[int(algebra.metric[i][i])].append(label)
    labels = [by_square[s].pop(0) for s in squares]
    index = {int(blade): i for i, blade in enumerate(algebra.blades)}
    pairs = [algebra.parse_blade(tuple(labels[i] for i in blade)) for blade in blades]
    return np.array([index[blade] for blade, _ in pairs]), np.array([float(sign) for _, sign in pairs])


def clifford_package() -> Any:
    """The package `clifford`.

    Raises
    ------
    MissingPackageError
        If it is not installed.
    """
    try:
        return import_module("clifford")
    except ImportError:
        raise MissingPackageError() from None


class MissingPackageError(MissingExtraError):
    """The package `clifford` is not installed."""

    def __init__(self) -> None:
        self.extra = "clifford"
        BladesmithError.__init__(
            self, "Exchange with clifford needs the package 'clifford'", remedy="Run: pip install clifford"
        )
