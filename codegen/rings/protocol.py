"""Rings: what the coefficients of a multivector are made of, and how they are combined.

A formula in GA notation runs on any ring: expression graphs (it becomes a kernel), NumPy arrays or mpmath
numbers (it is its own reference), exact points of F_p^2 (it is proved), rationals, values with a running
error bound. A ring has few operations; the geometric algebra lives in `multivector`.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any, Protocol

import numpy as np

from . import modular
from .modular import Samples

Coefficient = Any
Terms = Sequence[tuple[Coefficient, Fraction]]

#: Stumpff functions: c6 and c7 are there for the derivatives of c4 and c5.
STUMPFF = tuple(f"stumpff{k}" for k in range(8))
#: Functions of real arguments that a formula may apply, with their number of arguments.
FUNCTIONS = {
    "sqrt": 1, "reciprocal": 1, "abs": 1, "sin": 1, "cos": 1, "exp": 1, "log": 1, "atan2": 2,
    **dict.fromkeys(STUMPFF, 1),
    "nan": 0, "epsilon": 0, "rounded": 1,
}  # fmt: skip
#: "nan" stands for "no value" in a branch of `select`; "epsilon" is the spacing of the target's numbers at 1.
#: "rounded" equals its argument numerically but is opaque to exact simplification: it computes a rounding error as the
#: difference of two expressions that are equal exactly.
#: Spacing of float64 numbers at 1.
FLOAT64_EPSILON = Fraction(1, 2**52)
#: Comparisons and their combinations: their results are masks, which only `select` takes.
PREDICATES = {"lt": 2, "le": 2, "and": 2, "or": 2, "not": 1}


class Ring(Protocol):
    """Arithmetic on one kind of coefficient."""

    def constant(self, value: Fraction) -> Coefficient: ...
    def combine(self, terms: Terms) -> Coefficient: ...
    def multiply(self, a: Coefficient, b: Coefficient) -> Coefficient: ...
    def apply(self, name: str, *arguments: Coefficient) -> Coefficient: ...
    def select(self, mask: Any, a: Coefficient, b: Coefficient) -> Coefficient: ...
    def is_zero(self, a: Coefficient) -> bool: ...


class RationalRing:
    """Exact fractions; no roots. Tolerances are those of float64, whose reference this ring is."""

    def constant(self, value: Fraction) -> Fraction:
        return value

    def combine(self, terms: Terms) -> Fraction:
        return sum((c * w for c, w in terms), Fraction(0))

    def multiply(self, a: Fraction, b: Fraction) -> Fraction:
        return a * b

    def apply(self, name: str, *arguments: Fraction) -> Any:
        if name == "reciprocal":
            return 1 / arguments[0]
        if name in ("lt", "le"):
            return arguments[0] < arguments[1] if name == "lt" else arguments[0] <= arguments[1]
        if name in ("and", "or", "not"):
            return bool(_NUMPY[name](*arguments))
        if name in ("abs", "rounded"):
            return abs(arguments[0]) if name == "abs" else arguments[0]
        if name in ("nan", "epsilon"):  # no fraction is NaN: None fails loudly where it is not selected away
            return FLOAT64_EPSILON if name == "epsilon" else None
        raise NotImplementedError(f"{name} of a rational number")

    def select(self, mask: bool, a: Fraction, b: Fraction) -> Fraction:
        return a if mask else b

    def is_zero(self, a: Fraction) -> bool:
        return a == 0


class NumericRing:
    """NumPy arrays of one floating type; total: a division by zero gives inf or NaN, without a warning."""

    def __init__(self, dtype: Any = np.float64) -> None:
        self.dtype = np.dtype(dtype)

    def constant(self, value: Fraction) -> Any:
        return self.dtype.type(value.numerator / value.denominator)

    def combine(self, terms: Terms) -> Any:
        total: Any = None
        with np.errstate(all="ignore"):
            for c, w in terms:
                scaled = c if w == 1 else -c if w == -1 else c * self.constant(w)
                total = scaled if total is None else total + scaled
        return self.constant(Fraction(0)) if total is None else total

    def multiply(self, a: Any, b: Any) -> Any:
        with np.errstate(all="ignore"):  # both branches of a selection are computed
            return a * b

    def apply(self, name: str, *arguments: Any) -> Any:
        if not arguments:
            return self.dtype.type(np.nan if name == "nan" else np.finfo(self.dtype).eps)
        with np.errstate(all="ignore"):
            return _NUMPY[name](*arguments)

    def select(self, mask: Any, a: Any, b: Any) -> Any:
        return np.where(mask, a, b)

    def is_zero(self, a: Any) -> bool:
        return False


def _stumpff(k: int) -> Any:
    """c_k by closed form away from 0 and by series near it; a reference, not a kernel."""

    def function(w: Any) -> Any:
        w = np.asarray(w, float)
        term = np.ones_like(w) / _FACTORIAL[k]
        series = term.copy()
        for n in range(1, 12):
            term = term * -w / ((2 * n + k - 1) * (2 * n + k))
            series = series + term
        r = np.sqrt(np.abs(w))
        c0 = np.where(w > 0, np.cos(r), np.cosh(r))
        c1 = np.where(w > 0, np.sin(r), np.sinh(r)) / r
        closed = [c0, c1]
        for j in range(k - 1):
            closed.append((1 / _FACTORIAL[j] - closed[j]) / w)
        return np.where(np.abs(w) < 1, series, closed[k])

    return function


_FACTORIAL = (1, 1, 2, 6, 24, 120, 720, 5040)
_NUMPY: dict[str, Any] = {
    "sqrt": np.sqrt, "reciprocal": lambda a: np.float64(1) / a if np.ndim(a) == 0 else a.dtype.type(1) / a,
    "abs": np.abs, "rounded": lambda a: a,
    "sin": np.sin, "cos": np.cos, "exp": np.exp, "log": np.log, "atan2": np.arctan2,
    "lt": np.less, "le": np.less_equal, "and": np.logical_and, "or": np.logical_or, "not": np.logical_not,
    **{name: _stumpff(k) for k, name in enumerate(STUMPFF)},
}  # fmt: skip


class PrecisionRing:
    """mpmath numbers at the context's precision, one item at a time; division by zero and bad roots give NaN.

    ``epsilon`` is the unit roundoff of the target precision: tolerance tests take the same branch as on the target.
    """

    def __init__(self, digits: int = 50, epsilon: Fraction = FLOAT64_EPSILON) -> None:
        import mpmath

        self.context = mpmath.mp.clone()
        self.context.dps = digits
        self.epsilon = epsilon

    def constant(self, value: Fraction) -> Any:
        return self.context.mpf(value.numerator) / value.denominator

    def combine(self, terms: Terms) -> Any:
        total = self.context.mpf(0)
        for c, w in terms:
            total += c * w.numerator / w.denominator
        return total

    def multiply(self, a: Any, b: Any) -> Any:
        return a * b

    def apply(self, name: str, *arguments: Any) -> Any:
        mp = self.context
        if not arguments:
            return mp.nan if name == "nan" else self.constant(self.epsilon)
        x = arguments[0]
        if name == "lt" or name == "le":
            return x < arguments[1] if name == "lt" else x <= arguments[1]
        if name in ("and", "or", "not"):
            return bool(_NUMPY[name](*arguments))
        if name == "reciprocal":
            return mp.nan if x == 0 else 1 / x
        if name in ("sqrt", "log") and x < 0:
            return mp.nan
        if name.startswith("stumpff"):
            k = int(name[-1])
            # hypergeometric form of sum (-w)^n/(2n + k)!: no branch, no cancellation that precision cannot cover
            return mp.hyp1f2(1, mp.mpf(k + 1) / 2, mp.mpf(k + 2) / 2, -x / 4) / mp.factorial(k)
        if name in ("abs", "rounded"):
            return abs(x) if name == "abs" else x
        return getattr(mp, name)(*arguments)

    def select(self, mask: Any, a: Any, b: Any) -> Any:
        return a if mask else b

    def is_zero(self, a: Any) -> bool:
        return False


class SampleRing:
    """Random exact points of F_p^2; points at which a root or a reciprocal is missing are dropped."""

    def __init__(self, count: int) -> None:
        self.count = count
        self.alive = np.ones(count, bool)
        self._nan = modular.opaque(99, [self.constant(Fraction(0))])
        self._comparisons: list[tuple[str, Samples, Samples]] = []

    def constant(self, value: Fraction) -> Samples:
        return modular.constant(value, self.count)

    def combine(self, terms: Terms) -> Samples:
        return modular.combine(terms) if terms else self.constant(Fraction(0))

    def multiply(self, a: Samples, b: Samples) -> Samples:
        return modular.multiply(a, b)

    def apply(self, name: str, *arguments: Any) -> Any:
        if name == "reciprocal" or name == "sqrt":
            value, alive = (modular.reciprocal if name == "reciprocal" else modular.sqrt)(arguments[0])
            self.alive &= alive
            return value
        if not arguments:
            return self._nan if name == "nan" else modular.opaque(98, [self.constant(Fraction(0))])
        if name in ("lt", "le"):
            return modular.comparison_pattern(self.comparison(name, *arguments), self.count)
        if name in ("and", "or", "not"):
            return _NUMPY[name](*arguments)
        if name in ("sin", "cos"):
            return self._conic(0 if name == "cos" else 1, arguments[0], self.constant(Fraction(1)), salt=1)
        if name in ("stumpff0", "stumpff1"):
            return self._conic(int(name[-1]), arguments[0], arguments[0], salt=2)
        if name.startswith("stumpff"):  # c_{k+2} = (1/k! - c_k)/w
            k = int(name[-1]) - 2
            lower = self.apply(f"stumpff{k}", arguments[0])
            first = self.constant(Fraction(1, _FACTORIAL[k]))
            difference = self.combine([(first, Fraction(1)), (lower, Fraction(-1))])
            return self.multiply(difference, self.apply("reciprocal", arguments[0]))
        return modular.opaque(100 + sorted(FUNCTIONS).index(name), arguments)

    @property
    def comparison_count(self) -> int:
        """Number of different comparisons."""
        return len(self._comparisons)

    def comparison(self, name: str, a: Samples, b: Samples) -> int:
        """Number of a comparison: equal ones, however their operands were computed, share theirs."""
        for i, (other, c, d) in enumerate(self._comparisons):
            if other == name and self._equal(a, c) and self._equal(b, d):
                return i
        self._comparisons.append((name, a, b))
        return len(self._comparisons) - 1

    def release(self) -> None:
        """Forget the operands of comparisons."""
        self._comparisons = []

    def _equal(self, a: Samples, b: Samples) -> bool:
        return self.is_zero(self.combine([(a, Fraction(1)), (b, Fraction(-1))]))

    def _conic(self, which: int, argument: Samples, w: Samples, salt: int) -> Samples:
        """Point (c, s) with c^2 + w s^2 = 1 that depends on the argument only: the rational parametrization."""
        t = modular.opaque(salt, [argument])
        wtt = self.multiply(w, self.multiply(t, t))
        one = self.constant(Fraction(1))
        scale = self.apply("reciprocal", self.combine([(one, Fraction(1)), (wtt, Fraction(1))]))
        if which == 0:
            return self.multiply(self.combine([(one, Fraction(1)), (wtt, Fraction(-1))]), scale)
        return self.multiply(self.combine([(t, Fraction(2))]), scale)

    def select(self, mask: Any, a: Samples, b: Samples) -> Samples:
        if a is self._nan or b is self._nan:  # items without a value prove nothing and disprove nothing
            return b if a is self._nan else a
        return modular.select(mask, a, b)

    def is_zero(self, a: Samples) -> bool:
        return bool(np.all(a.is_zero() | ~self.alive))
