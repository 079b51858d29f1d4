"""What the language of algorithms refuses: when it is declared, with the line, and what to write instead."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bladesmith import errors
from bladesmith.codegen import algorithm
from bladesmith.codegen.language import InOut, Int, Matrix, Out, Real, Rows, Vector, empty

HEAD = """from __future__ import annotations
from bladesmith.codegen import algorithm
from bladesmith.codegen.language import *
import math
LIMIT = 3
@algorithm
def change(y: InOut[Vector[2]]) -> Real:
    y[0] += 1.0
    return y[0]
"""

#: Text of a function, what is said, and the line (of the function, from its decorator on).
REFUSED = [
    ("def f(x):\n    pass", "x has no type", 2),
    ("def f(x: float):\n    pass", "not a type of algorithms", 2),
    ("def f(x: 'Real'):\n    pass", "in quotes", 2),
    ("def f(x: Vector[0]):\n    pass", "positive lengths", 2),
    ("def f(x: Vector[2, 2]):\n    pass", "1 axes", 2),
    ("def f(x: Out[Real]):\n    pass", "Out and InOut are of arrays", 2),
    ("def f(x: Real = 0.0):\n    pass", "plain names", 2),
    ("def f(*x: Real):\n    pass", "plain names", 2),
    ("def f(x: Real) -> Real:\n    y = x\n", "not every path returns", 2),
    ("def f(x: Real) -> Real:\n    if x > 0.0:\n        return x\n", "not every path returns", 2),
    ("def f(x: Real):\n    if x > 0.0:\n        return x\n    return x, x\n", "2 values are returned here", 5),
    ("def f(x: Real):\n    return x\n    x = 0.0\n", "never reached", 4),
    ("def f(x: Real):\n    return y\n", "y is not known", 3),
    ("def f(x: Real):\n    return LIMTI\n", "did you mean 'LIMIT'", 3),
    ("def f(x: Real):\n    if x > 0.0:\n        y = x\n    return y\n", "y may not be defined", 5),
    ("def f(n: Int):\n    for i in range(n):\n        y = i\n    return y\n", "y may not be defined", 5),
    ("def f(n: Int):\n    for i in range(n):\n        y = 0\n    return i\n", "i may not be defined", 5),
    ("def f(n: Int):\n    for i in range(n):\n        i = 2\n", "counts a loop", 4),
    ("def f(n: Int):\n    for i in range(n):\n        for i in range(n):\n            pass\n", "counts a loop", 4),
    ("def f(n: Int):\n    for i in [1, 2]:\n        pass\n", "not in the language", 3),
    ("def f(n: Int):\n    for i in range(0, n, n):\n        pass\n", "not static", 3),
    ("def f(n: Int):\n    for i in range(0, n, 0):\n        pass\n", "the step 0", 3),
    ("def f(n: Int):\n    for i in range(n):\n        pass\n    else:\n        n = 1\n", "for ... else", 3),
    ("def f(n: Int):\n    for i in range(0, n, 2 ** 70):\n        pass\n", "with the step", 3),
    ("def f(n: Int):\n    n = 0.5\n", "Int elsewhere", 3),
    ("def f(n: Int):\n    return n + 2 ** 70\n", "more than 64 bits", 3),
    ("def f(x: Reals):\n    return x[2 ** 70]\n", "more than 64 bits", 3),
    ("def f(x: Real):\n    return x + int(INFINITY)\n", "cannot convert float infinity", 3),
    ("def f(x: Real):\n    return x + float('abc')\n", "could not convert string", 3),
    ("def f(x: Real):\n    return x + len(5)\n", "has no len", 3),
    ("def f(x: Real):\n    return x + min('a', 1)\n", "not supported between", 3),
    ("def f(x: Vector[4]):\n    y = x[NAN:3]\n", "begins at a value of type Real", 3),
    ("def f(x: Real):\n    y = zeros(3000000)\n", "have 3000000 numbers", 2),
    ("def f(x: Real):\n    x = 1\n    return x\n", None, 0),
    ("def f(x: Real):\n    return x ** 2\n", "x * x", 3),
    ("def f(x: Real):\n    return x // 2\n", "// of real numbers", 3),
    ("def f(x: Real):\n    return 1 if x else 0\n", "a condition is of type Real", 3),
    ("def f(x: Real):\n    return not x\n", "a condition is of type Real", 3),
    ("def f(x: Real, b: Bool):\n    return x + b\n", "arithmetic with a truth value", 3),
    ("def f(x: Real):\n    return x in (1, 2)\n", "(1, 2) is not a number", 3),
    ("def f(x: Real):\n    return x & 1\n", "& of Real and Int", 3),
    ("def f(x: Real):\n    return x @ 1\n", "an operator", 3),
    ("def f(n: Int):\n    return (n > 0) << 1\n", "<< of Bool and Int", 3),
    ("def f(n: Int):\n    return (n > 0) & n\n", "& of Bool and Int", 3),
    ("def f(n: Int):\n    return n >> 64\n", "a shift by 64", 3),
    ("def f(n: Int):\n    return n << -1\n", "a shift by -1", 3),
    ("def f(x: Real):\n    return 1 << 10 ** 9\n", "very large exponent", 3),
    ("def f(x: Real):\n    return x + 1 >> -1\n", ">> of Real", 3),
    ("def f(x: Real):\n    return (1, 2)[x:]\n", "a bound of a static slice", 3),
    ("def f(x: Real):\n    return (1, 2)[::0]\n", "no such element", 3),
    ("def f(x: Vector[2]):\n    _ = x[0]\n    return _\n", "_ may not be defined", 4),
    ("def f(n: Int):\n    for i in unrolled(3):\n        break\n", "outside of a loop that runs", 4),
    ("def f(n: Int):\n    for i in unrolled(n):\n        break\n", "outside of a loop that runs", 4),
    ("def f(x: Real):\n    y = x + largest(x)\n", "largest takes 0 numbers", 3),
    ("def f(x: Vector[3]):\n    return x\n", "an array is returned", 3),
    ("def f(x: Vector[3]):\n    return x[3]\n", "outside of a length of 3", 3),
    ("def f(x: Vector[3]):\n    return x[-4]\n", "outside of a length of 3", 3),
    ("def f(x: Vector[3]):\n    return x[0, 0]\n", "2 indices", 3),
    ("def f(x: Vector[3], y: Real):\n    return x[y]\n", "an index is of type Real", 3),
    ("def f(x: Vector[3], n: Int):\n    y = x[:n]\n", "not static", 3),
    ("def f(x: Vector[3]):\n    y = x[::2]\n", "a step", 3),
    ("def f(x: Vector[3], n: Int):\n    y = x[n:]\n", "length is not seen", 3),
    ("def f(x: Vector[3], n: Int):\n    y = x[n : n + n]\n", "not static", 3),
    ("def f(x: Vector[3], n: Int):\n    y = x[n : n + 4]\n", "a slice of length 4", 3),
    ("def f(x: Vector[3], y: Real):\n    z = x[y : y + 2]\n", "begins at a value of type Real", 3),
    ("def f(x: Vector[3]):\n    z = x[2:1]\n", "a slice of length -1", 3),
    ("def f(x: Rows[3]):\n    z = x[1:]\n", None, 0),
    ("def f(x: Vector[3]):\n    z = x[3:]\n", "a slice of length 0", 3),
    ("def f(x: Vector[3]):\n    x[0] = 1.0\n", "is an input", 3),
    ("def f(x: Out[Vector[3]], y: Vector[2]):\n    x[:] = y\n", "shape (2) for", 3),
    ("def f(x: Out[Vector[3]]):\n    x[:] = (1.0, 2.0)\n", "2 values for", 3),
    ("def f(x: Out[Vector[3]]):\n    x = 1.0\n", "an array or a static value", 3),
    ("def f(n: Int):\n    x = zeros(n)\n", "not static", 3),
    ("def f(n: Int):\n    x = zeros(0)\n", "positive integers", 3),
    ("def f(n: Int):\n    x = zeros(2)\n    x = zeros(3)\n", "bound twice", 4),
    ("def f(n: Int):\n    return zeros(2)\n", "inside an expression", 3),
    ("def f(x: Real):\n    return math.sqrt(x)\n", "cannot be called", 3),
    ("def f(x: Real):\n    return sqrt(x, x)\n", "takes 1 numbers", 3),
    ("def f(x: Real):\n    return sqrt(x=x)\n", "arguments by name", 3),
    ("def f(x: Real):\n    print(x)\n", "does nothing here", 3),
    ("def f(x: Real):\n    return open('/etc/passwd')\n", "cannot be called", 3),
    ("def f(x: Real):\n    return x.real\n", "no attribute real", 3),
    ("def f(x: Real):\n    return __import__('os').name\n", "cannot be called", 3),
    ("def f(x: Real):\n    return math.__dict__\n", "not a number", 3),
    ("def f(x: Real):\n    y = [x]\n", "not in the language", 3),
    ("def f(x: Real):\n    y = lambda: x\n", "not in the language", 3),
    ("def f(x: Real):\n    def g():\n        pass\n", "a statement that is not", 3),
    ("def f(x: Real):\n    class G:\n        pass\n", "a statement that is not", 3),
    ("def f(x: Real):\n    import os\n", "a statement that is not", 3),
    ("def f(x: Real):\n    raise ValueError\n", "a statement that is not", 3),
    ("def f(x: Real):\n    try:\n        pass\n    finally:\n        pass\n", "a statement that is not", 3),
    ("def f(x: Real):\n    global y\n", "a statement that is not", 3),
    ("def f(x: Real):\n    yield x\n", "a statement that is not", 3),
    ("def f(x: Real):\n    assert x > 0\n", "a statement that is not", 3),
    ("def f(x: Real):\n    del x\n", "a statement that is not", 3),
    ("def f(x: Real):\n    for k in (1, 2):\n        break\n", "outside of a loop", 4),
    ("def f(x: Real) -> Real:\n    return f(x)\n", "calls itself", 3),
    ("def f(x: Real):\n    return (1, 2)[2]\n", "no such element", 3),
    ("def f(x: Real):\n    return 1 / 0\n", "no result", 3),
    ("def f(x: Real):\n    return 10 ** 10 ** 10\n", "very large exponent", 3),
    ("def f(x: Real):\n    return 'a'\n", "not a number", 3),
    ("def f(größe: Real):\n    return größe\n", "letters that C has not", 2),
    ("def f(x: Real, y: Vector[2]):\n    a = b = zeros(2)\n", "inside an expression", 3),
    ("def f(x: Real, y: InOut[Vector[2]]):\n    return y[0] + change(y)\n", "changes arrays inside", 3),
    ("def f(x: Matrix[2, 2]):\n    a = x[0]\n    while a[0] > 0.0:\n        a = x[1]\n", "a may not be defined", 4),
    ("async def f(x: Real):\n    return x\n", "begins with def", 1),
]  # fmt: skip


def declare(text: str, folder: Path) -> Any:
    path = folder / "declared.py"
    path.write_text(HEAD + "@algorithm\n" + text + "\n", encoding="utf-8")
    spec = importlib.util.spec_from_file_location("declared", path)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize(("text", "message", "line"), REFUSED, ids=[text.split("\n", 1)[-1] for text, _, _ in REFUSED])
def test_refusals_name_the_line_and_a_remedy(text: str, message: str | None, line: int, tmp_path: Path) -> None:
    if message is None:
        declare(text, tmp_path)
        return
    with pytest.raises(errors.AlgorithmError) as caught:
        declare(text, tmp_path)
    said = str(caught.value)
    assert message in said
    assert f"declared.py:{HEAD.count(chr(10)) + line}:" in said
    assert caught.value.remedy and said.endswith(".")


@algorithm
def doubled(x: Matrix, y: Out[Vector[2]]) -> Real:
    """An array of any size."""
    y[0] = x[0, 0]
    y[1] = x[1, 1]
    return x[0, 1]


def test_sizes_are_checked_when_a_call_gives_them() -> None:
    with pytest.raises(errors.AlgorithmError, match="outside of a length of 1"):
        doubled.source("c", np.zeros((1, 3)))
    with pytest.raises(errors.InputError, match="needs 2 axes"):
        doubled(np.zeros(3))
    with pytest.raises(errors.InputError, match="needs 2 axes, not empty"):
        doubled(np.zeros((0, 3)))
    with pytest.raises(errors.InputError, match="give the arguments"):
        doubled.source("c")


@algorithm
def scaled(x: Vector[3], s: Real, out: Out[Vector[3]]) -> None:
    """A result."""
    for i in range(3):
        out[i] = x[i] * s


@pytest.mark.parametrize("arguments, message", [
    ((np.zeros(3),), "takes 2 arguments"), ((np.zeros(4), 1.0), "last axes must be"), ((0.0, 1.0), "last axes must be"),
    ((["a", "b", "c"], 1.0), "real numbers"), ((np.zeros((2, 3)), np.zeros(4)), "do not broadcast"),
    ((np.zeros(3, complex), 1.0), "real numbers"), ((np.zeros(3), None), "real numbers"),
])  # fmt: skip
def test_arguments_are_checked(arguments: tuple[Any, ...], message: str) -> None:
    with pytest.raises(errors.InputError, match=message):
        scaled(*arguments)


def test_batches_of_any_shape() -> None:
    x, s = np.arange(24.0).reshape(4, 1, 2, 3), np.arange(6.0).reshape(3, 2)
    assert np.array_equal(scaled(x, s), x * s[..., None])
    assert scaled(np.zeros((0, 3)), 1.0).shape == (0, 3)
    assert np.array_equal(scaled(x[..., ::-1], 2), x[..., ::-1] * 2)
    assert np.array_equal(scaled(x.astype(">f8"), 2.0), x * 2)
    assert scaled(np.ones(3, np.float32), np.float32(2)).dtype == np.float32


@algorithm
def moved_rows(rows: Rows[2], out: Out[Rows[2]], any_size: Out[Vector]) -> None:
    """Results as large as the caller's arrays."""
    for i in range(len(rows)):
        out[i][:] = rows[i]
    any_size[0] = 1.0


@algorithm
def around(rows: InOut[Rows[2]], x: Vector[2]) -> Real:
    """A caller with such arrays."""
    first = empty(3)
    moved_rows(rows, rows, first)
    return first[0] + x[0]


def test_results_without_a_size() -> None:
    with pytest.raises(errors.InputError, match="out is a result without a size"):
        moved_rows(np.zeros((4, 2)))
    with pytest.raises(errors.InputError, match="takes 1 arguments"):
        moved_rows.reference()
    rows = np.arange(6.0).reshape(3, 2)
    found, total = around(rows, np.array([2.0, 0.0]))
    assert np.array_equal(found, rows) and total == 3.0


def named_alike(scale: float) -> Any:
    @algorithm
    def alike(x: Real) -> Real:
        return x * scale

    return alike


def test_two_algorithms_of_one_name() -> None:
    one, two = named_alike(2.0), named_alike(3.0)

    @algorithm
    def both(x: Real) -> Real:
        return one(x) + two(x)

    with pytest.raises(errors.AlgorithmError, match="have the name alike"):
        both(1.0)
    assert both.reference(1.0) == 5.0
    assert one(1.0) == 2.0 and two(1.0) == 3.0


def test_a_target_that_is_not_there() -> None:
    with pytest.raises(errors.InputError, match="no target"):
        scaled.on("fortran")
    with pytest.raises(errors.InputError, match="no target"):
        scaled.source("fortran")
    with pytest.raises(errors.InputError, match="declares a Python function"):
        algorithm(3)  # type: ignore[arg-type]


def test_a_function_that_calls_itself_in_a_function() -> None:
    with pytest.raises(errors.AlgorithmError, match="again calls itself"):

        @algorithm
        def again(x: Real) -> Real:
            return again(x)  # type: ignore[no-any-return]


def test_arguments_that_have_no_shape_or_do_not_fit() -> None:
    @algorithm
    def first(x: Vector, y: Vector[2], n: Int) -> Real:
        return x[0] + y[0] + float(n)

    with pytest.raises(errors.InputError, match="x has rows of several lengths"):
        first([[1.0, 2.0], [3.0]], [1.0, 2.0], 1)
    with pytest.raises(errors.InputError, match="y has rows of several lengths"):
        first([1.0, 2.0], [[1.0, 2.0], [3.0]], 1)
    with pytest.raises(errors.InputError, match="n has an integer of more than 64 bits"):
        first([1.0], [1.0, 2.0], np.array(2**64 - 1, np.uint64))


def test_a_function_without_text() -> None:
    namespace: dict[str, Any] = {"Real": Real}
    exec("def f(x: Real):\n    return x\n", namespace)
    with pytest.raises(errors.AlgorithmError, match="there is none"):
        algorithm(namespace["f"])
