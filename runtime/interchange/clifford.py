"""Exchange with the package `clifford`: its layouts are orthonormal, dense, and one multivector at a time.

Signs and bases are settled here, once: `blade_table` says which blade of ours, with which sign, each coefficient of
a layout is; `dual_sign` says how the duals differ (ours is X I, theirs X I^-1).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..codegen.algebra.algebra import Kind
from ..codegen.errors import InputError
from ..common.validation import as_bool
from ..core.conversion.clifford_layouts import blade_table, layout_blades, layout_signature
from ..core.functions import norms
from ..core.multivector import Algebra, Multivector
from ..core.registry import algebra as algebra_by_signature
from ..dispatch.product_tables import basis_blade

#: What the nearest object may differ by: circles of `clifford` of radius 1, moved by 1e4, are 1e-8 away.
NEAREST = 1e-6
#: Errors of coefficients on an orthonormal basis after a motion or two, relative to the largest of them.
NOISE = 16 * float(np.finfo(np.float64).eps)


def from_clifford(
    value: Any,
    algebra: Algebra | None = None,
    *,
    nearest: bool = False,
    kind: str | Kind | None = None,
    tolerance: float = NEAREST,
) -> Multivector:
    """A multivector, list or array of multivectors of `clifford`, with all blades that are not zero throughout.

    Parameters
    ----------
    value : clifford.MultiVector, MVArray, or nested sequence of multivectors
    algebra : Algebra, optional
        Where it shall go, for example ``bs.cga3d``. Default: ``bs.algebra(p, q, r)`` of its signature.
    nearest : bool
        Make the nearest unit objects of a kind of them, and say in ``.deviation`` how far they were: objects of
        `clifford`, moved and multiplied on its orthonormal basis, carry more rounding than constraints allow. At a
        distance d from the origin the norm of an object of unit size is known to 1e-16 d^4, its radius to 1e-16 d^2
        if its norm was one: it is taken for one where these errors allow it.
    kind : str or Kind, optional
        With ``nearest``: of which kind. Default: the smallest that holds all of them within the tolerance.
    tolerance : float
        With ``nearest``: items further away are `INVALID` and NaN; see `Multivector.normalized`.

    Raises
    ------
    InputError
        If it is no multivector of `clifford`, or its layouts differ; for a kind without ``nearest``.
    KindError
        With ``nearest`` and no kind: if none holds all items within the tolerance.
    """
    if kind is not None and not as_bool(nearest, "nearest"):
        raise InputError("from_clifford takes a kind with nearest=True.", remedy="Else use .as_kind() of the result")
    shape, flat = _items(value)
    if not flat or any(not hasattr(mv, "layout") or not hasattr(mv, "value") for mv in flat):
        raise InputError("from_clifford takes multivectors of the package clifford, one or an array of them.")
    layout = flat[0].layout
    if any(mv.layout != layout for mv in flat):
        raise InputError("the multivectors have different layouts.")
    orthonormal = algebra_of(layout)
    columns, signs = blade_table(orthonormal, *layout_blades(layout))
    given: NDArray[Any] = np.stack([np.asarray(mv.value, float) for mv in flat])
    dense = np.zeros_like(given)
    dense[:, columns] = given * signs
    dense = dense.reshape(*shape, dense.shape[-1])
    present = [b for i, b in enumerate(orthonormal.blades) if dense[..., i].any()] or [orthonormal.blades[0]]
    place = {int(b): i for i, b in enumerate(orthonormal.blades)}
    made = orthonormal.multivector(dense[..., [place[int(b)] for b in present]], blades=present)
    made = made if algebra is None else algebra.multivector(made)
    return norms.nearest(made, kind, tolerance, NOISE) if as_bool(nearest, "nearest") else made


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


def algebra_of(layout: Any) -> Algebra:
    """The orthonormal algebra of a layout's signature.

    Raises
    ------
    SignatureError
        If its basis vectors are not of square 1, -1 or 0.
    """
    return algebra_by_signature(*layout_signature(layout))


def dual_sign(algebra: Algebra) -> int:
    """The sign s with X.dual() = s * (the dual of `clifford`), X I against X I^-1; 0 where there is no I^-1."""
    i = basis_blade(algebra, algebra.full_blade) * algebra.pseudoscalar_sign
    square = (i * i).terms.get(0)
    return 0 if square is None else int(square)
