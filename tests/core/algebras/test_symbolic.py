"""Multivectors of SymPy expressions: against numbers, and against the compiled functions of numeric multivectors."""

from __future__ import annotations

import copy
import pickle
import subprocess
import sys
from typing import Any

import numpy as np
import pytest
import sympy

import bladesmith as bs
from bladesmith import cga3d, pga3d

A, B, C, T = sympy.symbols("a b c t", real=True)
SPACE = bs.algebra(3)
VALUES = {A: sympy.Rational(3, 7), B: sympy.Rational(-5, 3), C: sympy.Rational(11, 9)}


def numeric(x: Any) -> Any:
    """At `VALUES`, as numbers."""
    return x.algebra.multivector({name: float(e) for name, e in x.subs(VALUES).expressions.items()} or {"1": 0.0})


OPERATIONS: dict[str, Any] = {
    "product": lambda x, y: x * y,
    "outer": lambda x, y: x ^ y,
    "inner": lambda x, y: x | y,
    "regressive": lambda x, y: x & y,
    "sandwich": lambda x, y: x >> y,
    "sum": lambda x, y: x + y,
    "difference": lambda x, y: x - y,
    "left": lambda x, y: x.left_contraction(y),
    "right": lambda x, y: x.right_contraction(y),
    "commutator": lambda x, y: x.commutator(y),
}


@pytest.mark.parametrize("name", OPERATIONS)
@pytest.mark.parametrize("algebra", [SPACE, cga3d, pga3d, bs.algebra(metric=[[2, 1], [1, 0]])], ids=lambda a: a.name)
def test_operators_agree_with_numbers_on_either_side(name: str, algebra: Any) -> None:
    operation = OPERATIONS[name]
    x = algebra.multivector({"1": A, "e1": B + 1, "e12": A * B - 2})
    y = algebra.multivector({"e1": C, "e2": A / C, "e21": sympy.sin(B)})
    z = algebra.multivector({"1": 0.5, "e2": 3.0, "e12": -1.25})
    for first, second in ((x, y), (x, z), (z, y)):
        found = numeric(operation(first, second))
        expected = operation(*(v if isinstance(v, bs.Multivector) else numeric(v) for v in (first, second)))
        assert found.isclose(expected, rtol=1e-13, atol=1e-13)


def test_expressions_and_numbers_on_either_side() -> None:
    x, e1 = SPACE.multivector({"e1": B}), SPACE.e1
    pairs = [
        (A * x, x * A), (e1 * A, A * e1), (e1 + A, A + e1), (A - e1, -(e1 - A)), (x / A, x * (1 / A)), (2 * x, x + x),
        (e1 ^ A, A * e1), (x * sympy.Rational(1, 2), x / 2), (1 - x, -(x - 1)), (A / x, x * (A / B**2)),
    ]  # fmt: skip
    for left, right in pairs:
        assert (left - right).expressions == {}, (left, right)
    assert (0.1 * x).expressions == {"e1": 0.1 * B} and (0.5 * e1 * A).expressions == {"e1": 0.5 * A}
    assert (x + SPACE.e1 * 3.0).expressions == {"e1": B + 3}  # whole floats are exact


def test_coefficients() -> None:
    x = SPACE.multivector({"e21": A + B, "e1": 2})
    assert x.coefficient("e12") == -A - B and x.coefficient("e3") == 0 and x.free_symbols == {A, B}
    assert x.diff(A).expressions == {"e12": -1} and x.subs(A, -B).expressions == {"e1": 2}
    assert SPACE.vector([A, 0, B]).expressions == {"e1": A, "e3": B}
    assert SPACE.multivector([A, B], blades=["e31", "e1"]).expressions == {"e1": B, "e13": -A}
    assert SPACE.multivector([A, 1, 2], kind="vector").expressions == {"e1": A, "e2": 1, "e3": 2}
    assert x.integrate((A, 0, 1)).coefficient("e1") == 2 and x.evalf().coefficient("e1") == 2.0
    y = SPACE.multivector({"1": sympy.sin(A) ** 2 + sympy.cos(A) ** 2})
    assert y.simplify().expressions == {"1": 1} and y.equals(1) and not y.equals(2)
    assert SPACE.multivector({"1": sympy.sin(A + B)}).expand(trig=True).coefficient("1").is_Add
    assert copy.copy(x).equals(x) and pickle.loads(pickle.dumps(x)).equals(x)


def test_pickles_are_read_by_other_processes() -> None:
    x = SPACE.multivector({"e1": A * B + sympy.sin(C), "e2": 1 / (A + B)})
    code = f"import pickle; print(pickle.loads({pickle.dumps(x)!r}))"  # atoms have other numbers there
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout == f"{x}\n"


def test_inverses() -> None:
    for x in (
        SPACE.vector([A, B, 0]),
        SPACE.multivector({"1": A, "e1": B, "e12": C}),
        bs.algebra(metric=[[2, 1], [1, -1]]).multivector({"1": A, "e1": B, "e2": 1}),
        SPACE.random(seed=1) * A + B,
    ):
        one = numeric(x.inverse()) * numeric(x)
        assert one.isclose(1.0, rtol=1e-11, atol=1e-11)
    assert (SPACE.vector([A, 0, 0]) ** -2).expressions == {"1": A**-2}
    for zero in (SPACE.multivector({"e1": A}) * 0, pga3d.e0 * A, SPACE.multivector({"1": A, "e1": A})):
        with pytest.raises(bs.errors.NotInvertibleError):
            zero.inverse()


def test_exponentials() -> None:
    R = SPACE.multivector({"e12": -T / 2}).exp()
    assert R.expressions == {"1": sympy.cos(T / 2), "e12": -sympy.sin(T / 2)}
    assert (R >> SPACE.e1).simplify().expressions == {"e1": sympy.cos(T), "e2": sympy.sin(T)}
    assert pga3d.multivector({"e01": A}).exp().expressions == {"1": 1, "e01": A}
    assert bs.algebra(1, 1).multivector({"e12": A}).exp().coefficient("1") == sympy.cosh(A)
    complex_number = SPACE.multivector({"1": A, "e12": B})
    assert numeric(complex_number.exp()).isclose(numeric(complex_number).exp())
    bivector = SPACE.bivector([A, B, C])
    assert numeric(bivector.exp()).isclose(numeric(bivector).exp(), rtol=1e-13)
    mixed = bs.algebra(2, 1).bivector([A, B, 0])  # A^2 - B^2: a sign that does not show
    assert numeric(mixed.exp()).isclose(numeric(mixed).exp(), rtol=1e-13)
    with pytest.raises(bs.errors.GradeError, match="e123"):
        (bivector + SPACE.e3 * A).exp()


def test_compiled_functions() -> None:
    f = SPACE.bivector([A, B, C]).exp().lambdify(A, B, C)
    numbers = np.random.default_rng(6).normal(size=(3, 50))
    assert f(*numbers).isclose(SPACE.bivector(numbers.T).exp(), rtol=1e-14).all()
    assert f(0, 0, 0).isclose(1.0) and f(1e-9, 0.0, [0.0, 1e-200]).shape == (2,)  # no 0/0
    x = SPACE.multivector(
        {
            "1": sympy.exp(A) / (1 + B**2) + sympy.pi, "e1": sympy.sqrt(C) ** 3 + sympy.tan(A), "e2": sympy.atan2(A, C),
            "e3": sympy.log(C) * sympy.Abs(B) + sympy.sinh(A) - sympy.cosh(B), "e13": C**A, "e23": sympy.sinc(A),
            "e12": 0.1 * A + C ** sympy.Rational(-1, 2),
        }
    )  # fmt: skip
    a, b, c = 0.3, -1.7, 2.5
    g = x.lambdify()  # by name
    for target in ("c", "numpy"):
        found = x.lambdify(target=target)(a, b, c)
        exact = x.subs({A: a, B: b, C: c}).evalf(30)
        assert all(np.isclose(found[n], float(e), rtol=4e-15) for n, e in exact.expressions.items())
    assert g(np.full(3, a), b, c).shape == (3,)


def test_numbers_beyond_floats() -> None:
    big = SPACE.multivector({"e1": 1e200 * A})
    with pytest.raises(bs.errors.InputError, match="range of floats"):
        repr(big * big)
    with pytest.raises(bs.errors.InputError, match="range of floats"):
        SPACE.multivector({"e1": 10**400 * A}) * 0.5
    assert (SPACE.multivector({"e1": 10**400 * A}) / 10**400).expressions == {"e1": A}


def test_text() -> None:
    x = SPACE.multivector({"1": A + B, "e1": -A, "e12": B - 1, "e3": 1})
    assert repr(x) == "a + b - a e1 + e3 + (b - 1) e12" and repr(x * 0) == "0"
    assert x._repr_latex_() == (
        r"$a + b - a \mathbf{e}_{1} + \mathbf{e}_{3} + \left(b - 1\right) \mathbf{e}_{12}$"
    )  # fmt: skip


def test_symbols_of_a_kind() -> None:
    x, m = cga3d.symbols("x", kind="point"), cga3d.symbols("m", kind="motor")
    moved = m >> x
    symbols = sorted(m.free_symbols | x.free_symbols, key=str)
    values = dict(zip(symbols, np.linspace(-1, 1, 13).tolist(), strict=True))
    exact = cga3d.multivector({n: float(e) for n, e in moved.subs(values).expressions.items()})
    numbers = [cga3d.multivector({n: float(e) for n, e in v.subs(values).expressions.items()}) for v in (m, x)]
    assert exact.isclose(numbers[0] >> numbers[1], rtol=1e-12)


@pytest.mark.parametrize(
    ("call", "error", "message"),
    [
        (lambda x: x * "a", bs.errors.InputError, "'a'"),
        (lambda x: x * True, bs.errors.InputError, "True"),
        (lambda x: SPACE.multivector({"e1": A, "e2": "z"}), bs.errors.InputError, "'z'"),
        (lambda x: SPACE.multivector({"e1": sympy.oo}), bs.errors.InputError, "oo"),
        (lambda x: SPACE.multivector({"e1": A < B}), bs.errors.InputError, "a < b"),
        (lambda x: SPACE.multivector({"e9": A}), bs.errors.BladeError, "e9"),
        (lambda x: SPACE.multivector({"e1": A}, dtype="float32"), bs.errors.InputError, "dtype"),
        (lambda x: SPACE.vector([A, B]), bs.errors.ShapeError, "2 expressions"),
        (lambda x: x * float("nan"), bs.errors.InputError, "nan"),
        (lambda x: x**0.5, bs.errors.TraceError, "whole numbers"),
        (lambda x: x * SPACE.vector(np.eye(3)), bs.errors.TraceError, "batch"),
        (lambda x: SPACE.vector(np.eye(3)) * x, bs.errors.TraceError, "batch"),
        (lambda x: cga3d.e1 * x, bs.errors.AlgebraMismatchError, "cga3d"),
        (lambda x: x.subs(A), bs.errors.InputError, "subs: "),
        (lambda x: x.diff(3), bs.errors.InputError, "diff: "),
        (lambda x: x.lambdify(B), bs.errors.InputError, "symbols a"),
        (lambda x: x.lambdify(A, A), bs.errors.InputError, "twice"),
        (lambda x: x.lambdify(3), bs.errors.InputError, "3 is no symbol"),
        (lambda x: x.lambdify(target="fortran"), bs.errors.InputError, "fortran"),
        (lambda x: x.lambdify()(1, 2), bs.errors.InputError, "1 arguments"),
        (lambda x: (0 * x + SPACE.e1).lambdify(), bs.errors.InputError, "no symbols"),
        (lambda x: (x + sympy.gamma(A)).lambdify(), bs.errors.InputError, "gamma"),
        (lambda x: list(x), TypeError, "expressions"),
    ],
)
def test_what_is_no_expression(call: Any, error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        call(SPACE.multivector({"e1": A}))


def test_sympy_is_imported_with_the_first_symbol() -> None:
    code = "import sys, bladesmith as bs; x = 2 * bs.algebra(3).e1 + 1; x * x; print('sympy' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout == "False\n"


@pytest.mark.parametrize(
    "value",
    [
        sympy.Symbol("p", commutative=False),
        sympy.MatrixSymbol("m", 2, 2),
        sympy.Matrix([[1]]),
        -sympy.oo * A,
        sympy.O(A),
        sympy.AccumBounds(0, 1),
    ],
)
def test_what_is_no_commuting_number_is_no_coefficient(value: Any) -> None:
    with pytest.raises(bs.errors.InputError, match="a coefficient is"):
        SPACE.multivector({"e1": value})


def test_poles_and_hidden_zeros_are_errors() -> None:
    with pytest.raises(bs.errors.InputError, match="zoo"):
        SPACE.multivector({"e1": 1 / A}).subs(A, 0)
    null = bs.algebra(2, 1).multivector({"e1": 1, "e2": 1, "e3": sympy.sqrt(2)})
    imaginary = SPACE.multivector({"e1": 1, "e2": sympy.I})
    for x in (null, imaginary):
        with pytest.raises(bs.errors.NotInvertibleError):
            x.inverse()
        assert x.exp().equals(x + 1)


def test_symbolic_exponents_are_whole() -> None:
    x = SPACE.multivector({"e1": A, "e2": B})
    assert (x**2.0).equals(x * x) and (x ** sympy.Integer(-1)).equals(x.inverse())
    for exponent in (0.5, A, np.array([1, 2]), sympy.Rational(1, 2), "2"):
        with pytest.raises(bs.errors.TraceError, match="whole numbers"):
            x**exponent


@pytest.mark.parametrize("expression", [A**65, A**200, A ** sympy.Float(3.0), A**-65])
def test_compiled_whole_powers_of_negative_numbers(expression: Any) -> None:
    f = SPACE.multivector({"e1": expression}).lambdify(A)
    assert np.isclose(f(-1.03)["e1"], float(expression.subs(A, -1.03)), rtol=1e-13)


@pytest.mark.parametrize(
    "expression", [sympy.sin(2 * A) / A, sympy.sin(A) ** 2 / A**2, sympy.sinh(A / 3) / A, sympy.sin(A * B) / A]
)
def test_compiled_quotients_are_regular_at_zero(expression: Any) -> None:
    f = SPACE.multivector({"e1": expression, "e2": B}).lambdify(A, B)
    assert np.isclose(f(0.0, 0.7)["e1"], float(sympy.limit(expression.subs(B, 0.7), A, 0)), rtol=1e-14)
    assert np.isclose(f(0.3, 0.7)["e1"], float(expression.subs({A: 0.3, B: 0.7})), rtol=1e-14)


def test_compiled_exponential_of_half_a_bivector_is_regular_at_zero() -> None:
    f = SPACE.multivector({"e12": A / 2, "e13": B / 2}).exp().lambdify(A, B)
    assert f(0.0, 0.0).isclose(1.0)


def test_compiled_constants_beyond_the_range_of_numbers_are_refused() -> None:
    with pytest.raises(bs.errors.InputError, match="beyond the range"):
        SPACE.multivector({"e1": sympy.Integer(10) ** 400 * A}).lambdify(A)
