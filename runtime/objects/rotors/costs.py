"""Cost of taking one object to another (thesis 3.13, 5.1): of a rotor, and of all pairs of two batches."""

from __future__ import annotations

from typing import Any, Literal, overload

import numpy as np
from numpy.typing import NDArray

from ...codegen.errors import GradeError, InputError
from ...codegen.formulas.objects.costs import CARE
from ...common.deprecation import renamed_keywords
from ...common.dtypes import common_precision
from ...common.validation import as_bool, as_choice
from ...core.multivector import Multivector
from ...dispatch.formulas import evaluate
from ...dispatch.item_statuses import array_result
from ...dispatch.multivector_data import Statuses
from ...status import Status
from ..arguments import as_objects, same_sort
from .pairwise import pair_values

#: Cost -> ending of the formulas' names.
COSTS = {"positive": "", "thesis": "_thesis"}
#: Kinds whose coefficients grow with the square of the distance.
ROUNDS = {"point_pair", "circle", "sphere"}
#: Pairs that take the careful way at a time.
CAREFUL_BLOCK = 65536


@overload
def rotor_cost(
    R: Multivector, cost: str = ..., *, status: Literal[False] = ..., strict: bool = ...
) -> NDArray[Any]: ...  # fmt: skip
@overload
def rotor_cost(
    R: Multivector, cost: str = ..., *, status: Literal[True], strict: bool = ...
) -> tuple[NDArray[Any], Statuses]: ...  # fmt: skip
@renamed_keywords(kind="cost")
def rotor_cost(
    R: Multivector, cost: str = "positive", *, status: bool = False, strict: bool = False
) -> NDArray[Any] | tuple[NDArray[Any], Statuses]:
    """Distance of rotors from the identity.

    Parameters
    ----------
    R : Multivector, shape (...)
        Unit rotors, motors or other even versors of conformal geometry. R and -R, the same motion, cost the same:
        what the one with <R>_0 >= 0 costs.
    cost : str
        "positive": the sum of the squared coefficients of R - 1 and of R . e_+ on the orthonormal basis. "thesis":
        <(R - 1)(~R - 1)>_0 + <R_par ~R_par>_0 with R_par = R . e_+, which dilations make negative.
    status : bool
        Return (cost, status): `INVALID` where R is not finite, or what R's own status says.
    strict : bool
        Raise for the first rotor without a cost.

    Returns
    -------
    array, shape (...)
        For a rotation by th and then a translation by t along its axis: 2 - 2 cos(th/2) + (t^2/4 times 3 for
        "positive", 1 for "thesis"). NaN where R is.

    Raises
    ------
    InputError, GradeError
        If R is not a multivector of conformal geometry, or not even; if the cost is unknown.
    SingularError
        With ``strict``.

    Notes
    -----
    Thesis (3.13), (5.1). Both depend on the origin and on the unit of length.
    """
    ending = _ending(cost)
    if not isinstance(R, Multivector) or "ni" not in R.algebra.vectors:
        raise InputError(
            "R is not a multivector of conformal geometry; rotors come from objects.rotor_between or cga3d."
        )
    if any(g % 2 for g in R.grades):
        raise GradeError(f"R is a {R.kind.name} of grades {R.grades}; rotors have even grades only.")
    costs = np.asarray(evaluate(R.algebra, f"costs.rotor_cost{ending}", R).value._data[..., 0])[()]
    return array_result(costs, R._status, "rotor_cost", status, strict)


@overload
def cost_matrix(
    X: Any, Y: Any, cost: str = ..., align: bool = ..., threads: int | None = ..., status: Literal[False] = ...,
    strict: bool = ...,
) -> NDArray[Any]: ...  # fmt: skip
@overload
def cost_matrix(
    X: Any, Y: Any, cost: str = ..., align: bool = ..., threads: int | None = ..., *, status: Literal[True],
    strict: bool = ...,
) -> tuple[NDArray[Any], Statuses]: ...  # fmt: skip
@renamed_keywords(kind="cost")
def cost_matrix(
    X: Any,
    Y: Any,
    cost: str = "positive",
    align: bool = False,
    threads: int | None = None,
    status: bool = False,
    strict: bool = False,
) -> NDArray[Any] | tuple[NDArray[Any], Statuses]:
    """Cost of the rotor from each of n objects to each of m.

    Parameters
    ----------
    X, Y : Multivector or list, shapes (n,) and (m,)
        Unit objects of one grade, flats and rounds mixed as you like; points too (they are translated). Batches of
        any shape are taken, and single objects.
    cost : str
        "positive" or "thesis"; see `rotor_cost`.
    align : bool
        Orientation does not matter: each pair costs what the two cost when they are turned the same way.
    threads : int, optional
        Default: the package's (`bladesmith.set_threads`). The result does not depend on it.
    status : bool
        Return the statuses too.
    strict : bool
        Raise for the first pair without a rotor.

    Returns
    -------
    cost : array (n, m), float64, or float32 where both batches are
        Shape of X, then shape of Y. Symmetric. Where `rotor_between` documents a choice (objects that face each
        other, touching spheres from outside) it is the cost of that choice, the smaller one of both directions;
        infinity where there is no rotor; NaN for invalid objects only.
    status : array (n, m) of uint8
        With ``status=True``: `Status.NOT_UNIQUE` for such choices, `Status.INVALID` for invalid objects, and what
        `rotor_between` says of pairs that have no rotor.

    Raises
    ------
    InputError, GradeError, AlgebraMismatchError
        If they are no objects, or not of one grade.
    SingularError
        With ``strict``.

    Notes
    -----
    One compiled loop. Pairs for which it would lose digits (nearly opposite objects; rounds some hundred radii from
    the origin) are done again by `rotor_between`, at a hundred times the price: the origin belongs among the objects.
    """
    ending, align = _ending(cost), as_bool(align, "align")
    with_codes = as_bool(status, "status") or as_bool(strict, "strict")
    x, y = as_objects(X, "the first objects"), as_objects(Y, "the second objects")
    same_sort(x, y)
    rows, columns = x.reshape(-1), y.reshape(-1)
    costs = pair_values(f"costs.{'aligned' if align else 'pair'}_cost{ending}", rows, columns, threads)
    codes = _complete(costs, rows, columns, cost, align, with_codes)
    shape = x.shape + y.shape
    known = None if codes is None else codes.reshape(shape)
    return array_result(costs.reshape(shape)[()], known, "cost_matrix", status, strict)


def _ending(cost: str) -> str:
    return COSTS[as_choice(cost, "cost", tuple(COSTS))]


def _complete(
    cost: NDArray[Any], x: Multivector, y: Multivector, name: str, align: bool, with_status: bool
) -> NDArray[np.uint8] | None:
    """Costs of the pairs that were left to the careful method, written in; statuses where they are ``with_status``."""
    code = None
    if with_status:
        code = np.zeros(cost.shape, np.uint8) if align else _flip_statuses(x, y)
    missing = np.isnan(cost) | _far(x, y)
    if not missing.any():
        return code
    bad_x, bad_y = (np.isnan(item._data).any(-1) for item in (x, y))
    if code is not None:
        code[bad_x] = Status.INVALID
        code[:, bad_y] = Status.INVALID
    missing[bad_x] = False
    missing[:, bad_y] = False
    i, j = np.nonzero(missing)
    for first in range(0, len(i), CAREFUL_BLOCK):
        block = slice(first, first + CAREFUL_BLOCK)
        place = i[block], j[block]
        cost[place], found = cost_via_rotors(x[place[0]], y[place[1]], name, align)
        if code is not None:
            code[place] = found
    return code


def _flip_statuses(x: Multivector, y: Multivector) -> NDArray[np.uint8]:
    """NOT_UNIQUE for spheres that are taken to -Y, as `rotor_between` says."""
    if x.grades[0] != x.algebra.dimension - 1:
        return np.zeros((len(x), len(y)), np.uint8)
    with np.errstate(invalid="ignore"):
        beyond = pair_values("costs.agreement", x, y) < -1
    return np.where(beyond, np.uint8(Status.NOT_UNIQUE), np.uint8(Status.OK))


def _far(x: Multivector, y: Multivector) -> NDArray[np.bool_]:
    """Pairs of rounds so far from the origin, for their radii, that products of their coefficients lose the digits."""
    if not is_far(x, y):
        return np.zeros((1, 1), np.bool_)
    return np.asarray(_sizes(x)[:, None] > _limit(x, y) / _sizes(y))  # the product itself may be too great


def is_far(x: Multivector, y: Multivector) -> bool:
    """Test whether there is such a pair. Products of flats contain no squared distances."""
    if not {x.kind.name, y.kind.name} & ROUNDS:
        return False
    one, other = (float(_sizes(item).max(initial=0)) for item in (x, y))
    return other > 0 and one > _limit(x, y) / other


def _sizes(x: Multivector) -> NDArray[np.float64]:
    """Largest coefficient of each object, 1 for invalid ones."""
    size = np.abs(x._data).max(-1).astype(np.float64)
    return np.where(np.isfinite(size), size, 1.0)


def _limit(x: Multivector, y: Multivector) -> float:
    """Size of products that keeps the digits which the formulas want of h, see `formulas.objects.costs.CARE`."""
    return float(CARE / np.sqrt(np.finfo(common_precision(x._data, y._data)).eps))


def cost_via_rotors(
    x: Multivector, y: Multivector, cost: str = "positive", align: bool = False
) -> tuple[NDArray[Any], NDArray[np.uint8]]:
    """Costs of pairs, one by one, by `rotor_between`: the smaller one of both directions, infinite where none is."""
    from .between import rotor_between

    if align:
        turned = evaluate(x.algebra, "costs.agreement", x, y).value._data < 0
        y = y._make(y._type, np.where(turned, -y._data, y._data), y.shape, y._status)
    there, back = rotor_between(x, y), rotor_between(y, x)
    costs: NDArray[Any] = np.stack([rotor_cost(R, cost) for R in (there, back)])
    code = np.zeros(x.shape, np.uint8) if there._status is None else there._status
    return np.where(np.isnan(costs), np.inf, costs).min(0), code
