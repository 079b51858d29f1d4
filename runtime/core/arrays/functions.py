"""exp, log, norms and inverses on other packages' arrays: the formulas of NumPy's, without what depends on the numbers.

An item without an answer is NaN.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from ...codegen.errors import GradeError
from ...dispatch.arrays.types import wrap
from ...dispatch.coefficients import embed, no_items
from ...dispatch.formulas import evaluate_batch
from ...dispatch.multivector_data import M
from .. import kind_constraints, linear_maps
from ..functions import exponentials, inverses, norms, powers


def _formula(x: M, formula: str, like: Callable[[Any], Any] | None) -> M:
    """The first result of a formula, of the kind that a function gives it on NumPy arrays."""
    value: M = evaluate_batch(x.algebra, formula, x).value
    if like is None:
        return value
    kind, backend = x._type.memoize(("kind", formula), lambda: like(no_items(x)).kind), x._type.backend
    assert backend is not None
    return value if value.kind == kind else wrap(x.algebra, kind, embed(value, kind), backend)


def exp(x: M) -> M:
    """The exponential, where it has a closed form.

    Raises
    ------
    GradeError
        If it has none.
    """
    like = no_items(x)
    formula = x._type.memoize("exp", lambda: exponentials._exp_formula(like) if x.grades == (2,) else "")
    if not formula:
        raise GradeError(
            f"exp of a {x.kind.name} of {x.algebra.name} is a series, which NumPy arrays have alone.",
            remedy="Take bivectors, of motors or of up to five dimensions",
        )
    return _formula(x, formula, exponentials.exp)


def log(x: M) -> M:
    """The logarithm of a rotor."""
    exponentials.log(no_items(x))  # for its refusals
    formula = x._type.memoize("log", lambda: exponentials._rotor_formula(no_items(x), "log"))
    return _formula(x, formula, exponentials.log)


def sqrt(x: M) -> M:
    """The square root of a rotor."""
    exponentials.sqrt(no_items(x))  # for its refusals
    formula = x._type.memoize("sqrt", lambda: exponentials._rotor_formula(no_items(x), "sqrt"))
    return _formula(x, formula, exponentials.sqrt)


def power(x: Any, exponent: Any) -> Any:
    """A power: of whole numbers the product, of others, and arrays of them, exp(exponent log(x))."""
    is_array = hasattr(exponent, "shape") and not isinstance(exponent, np.generic)
    whole = None if is_array else powers.whole_exponent(exponent)
    if whole is None:
        rows = exponent if isinstance(exponent, float) else x._type.backend.floating(exponent, "the exponent")
        return exp(log(x) * rows)
    if whole == 0:
        one = x._type.backend.constant(np.ones((*x.shape, 1)), x.values)
        return wrap(x.algebra, x.algebra.scalar_layout, one, x._type.backend)
    return powers.repeated_product(x if whole > 0 else inverse(x), abs(whole))


def norm(x: Any) -> Any:
    """sqrt |<x ~x>_0| of each item: an array."""
    return x._type.backend.norm(x.scalar_product(~x).values[..., 0])


def normalized(x: Any) -> Any:
    """Motors, lines and planes: the nearest ones. Points: over their weight. All others over their norm.

    Only the first are of a constrained kind, whatever the numbers are.
    """
    if x.kind.constraints:
        return x
    plain = no_items(x)
    kind = next((k for k in kind_constraints.candidate_kinds(plain) if k.blades == x.kind.blades), None)
    weights = kind and kind_constraints.linear_scale(kind)
    if weights:
        row = x._type.backend.constant(np.array(weights), x.values)
        return x._make(x._type, x.values / (x.values * row).sum(-1)[..., None], x.shape)
    if kind is not None and norms._is_repaired(plain, kind):
        return _formula(x, norms.NEAREST, None)
    value = evaluate_batch(x.algebra, norms.NORMALISE, x).value
    return value._make(value._type.unconstrained, value.values, value.shape)


def inverse(x: Any) -> Any:
    """The y with x y = 1: the reverse, up to sign, where the kind says so, else by Shirokov's recursion."""
    sign = inverses._unit_square(x)
    if sign:
        reverse = linear_maps.apply_linear_map(x, "reverse")
        return reverse if sign > 0 else -reverse
    inverses.check_size(x, "inverse")
    return _formula(x, "inverses.shirokov", None)
