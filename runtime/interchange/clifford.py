"""Exchange with the package `clifford`: its layouts are orthonormal, dense, and one multivector at a time.

Signs and bases are settled here, once: `blade_table` says which blade of ours, with which sign, each coefficient of
a layout is; `dual_sign` says how the duals differ (ours is X I, theirs X I^-1).
"""

from __future__ import annotations

from functools import cache
from importlib import import_module
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..codegen.errors import BladesmithError, InputError, MissingExtraError, SignatureError
from ..multivector import Multivector
from . import bases

if TYPE_CHECKING:
    from ..algebras import Algebra


def to_clifford(x: Multivector, layout: Any = None) -> Any:
    """x as a multivector of `clifford`, or for a batch an array (``MVArray``) of them.

    Parameters
    ----------
    x : Multivector
        Of any algebra; null bases are converted (in CGA e4 = e+, e5 = e-).
    layout : clifford.Layout, optional
        For example ``clifford.g3c.layout``. Default: ``clifford.Cl(p, q, r)``, made once.

    Raises
    ------
    SignatureError
        If the layout has another signature.
    """
    package = _package()
    layout = layout if layout is not None else default_layout(*x.algebra.signature)
    algebra = algebra_of(layout)
    if algebra.signature != x.algebra.signature:
        raise SignatureError(f"the layout is Cl{algebra.signature}, the multivector Cl{x.algebra.signature}.")
    own = x.to_basis("orthonormal")
    columns, signs = blade_table(algebra, *_described(layout))
    values = bases.dense(own, algebra)[..., columns] * signs
    if not x.shape:
        return layout.MultiVector(values)
    made = np.empty(x.shape, object)
    for place in np.ndindex(x.shape):
        made[place] = layout.MultiVector(values[place])
    return made.view(package.MVArray)


def from_clifford(value: Any, algebra: Algebra | None = None) -> Multivector:
    """A multivector, list or array of multivectors of `clifford`, with all blades that are not zero throughout.

    Parameters
    ----------
    value : clifford.MultiVector, MVArray, or nested sequence of multivectors
    algebra : Algebra, optional
        Where it shall go, for example ``bs.cga3d``. Default: ``bs.algebra(p, q, r)`` of its signature.

    Raises
    ------
    InputError
        If it is no multivector of `clifford`, or its layouts differ.
    """
    shape, flat = _items(value)
    if not flat or any(not hasattr(mv, "layout") or not hasattr(mv, "value") for mv in flat):
        raise InputError("from_clifford takes multivectors of the package clifford, one or an array of them.")
    layout = flat[0].layout
    if any(mv.layout != layout for mv in flat):
        raise InputError("the multivectors have different layouts.")
    orthonormal = algebra_of(layout)
    columns, signs = blade_table(orthonormal, *_described(layout))
    given: NDArray[Any] = np.stack([np.asarray(mv.value, float) for mv in flat])
    dense = np.zeros_like(given)
    dense[:, columns] = given * signs
    dense = dense.reshape(*shape, dense.shape[-1])
    present = [b for i, b in enumerate(orthonormal.blades) if dense[..., i].any()] or [orthonormal.blades[0]]
    place = {int(b): i for i, b in enumerate(orthonormal.blades)}
    made = orthonormal.multivector(dense[..., [place[int(b)] for b in present]], blades=present)
    return made if algebra is None else algebra.multivector(made)


def _items(value: Any) -> tuple[tuple[int, ...], list[Any]]:
    """Shape and items of nested sequences; NumPy cannot be asked, for it would look into the multivectors."""
    if isinstance(value, np.ndarray) and value.dtype == object:
        return value.shape, list(value.reshape(-1))
    if not isinstance(value, list | tuple):
        return (), [value]
    shapes, parts = zip(*(_items(item) for item in value), strict=True) if value else ((), ())
    if len(set(shapes)) > 1:
        raise InputError("the nested lists of multivectors are ragged.")
    return (len(value), *(shapes[0] if shapes else ())), [item for part in parts for item in part]


@cache
def default_layout(p: int, q: int, r: int) -> Any:
    """``clifford.Cl(p, q, r)``; a single null vector is called e0 there as here."""
    layout, _ = _package().Cl(p, q, r, firstIdx=0) if r == 1 else _package().Cl(p, q, r)
    return layout


def algebra_of(layout: Any) -> Algebra:
    """The orthonormal algebra of a layout's signature.

    Raises
    ------
    SignatureError
        If its basis vectors are not of square 1, -1 or 0.
    """
    from ..loading import algebra

    squares = [int(s) for s in layout.sig]
    if any(s not in (1, -1, 0) for s in squares):
        raise SignatureError(f"the layout's vectors have the squares {squares}; they are 1, -1 or 0 here.")
    return algebra(*(squares.count(s) for s in (1, -1, 0)))


def _described(layout: Any) -> tuple[tuple[int, ...], tuple[tuple[int, ...], ...]]:
    """Squares of a layout's vectors, and for each coefficient its vectors by position."""
    position = {identity: i for i, identity in enumerate(layout._basis_vector_ids.values)}
    blades = tuple(tuple(position[i] for i in ids) for ids in layout.bladeTupList)
    return tuple(int(s) for s in layout.sig), blades


@cache
def blade_table(
    algebra: Algebra, squares: tuple[int, ...], blades: tuple[tuple[int, ...], ...]
) -> tuple[NDArray[Any], NDArray[Any]]:
    """For each coefficient of a layout: its place among our blades, and its sign.

    The k-th vector of square s there is the k-th vector of square s here; a blade's vectors in another order change
    its sign.
    """
    own: dict[int, list[str]] = {1: [], -1: [], 0: []}
    for i, label in enumerate(algebra.vectors):
        own[int(algebra.metric[i][i])].append(label)
    labels = [own[s].pop(0) for s in squares]
    place = {int(blade): i for i, blade in enumerate(algebra.blades)}
    pairs = [algebra.parse_blade(tuple(labels[i] for i in blade)) for blade in blades]
    return np.array([place[blade] for blade, _ in pairs]), np.array([float(sign) for _, sign in pairs])


def dual_sign(algebra: Algebra) -> int:
    """The sign s with X.dual() = s * (the dual of `clifford`), X I against X I^-1; 0 where there is no I^-1."""
    from ..general import basis_blade

    i = basis_blade(algebra, algebra.pseudoscalar) * algebra.pseudoscalar_sign
    square = (i * i).terms.get(0)
    return 0 if square is None else int(square)


def _package() -> Any:
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
