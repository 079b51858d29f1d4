"""`bladesmith check`: what it finds right, what it finds wrong and at which operands, and what it refuses."""

import re
from fractions import Fraction

import numpy as np
import pytest

from bladesmith.cli import main
from bladesmith.codegen.algebra.loader import algebra_from_data
from bladesmith.codegen.checks import kernels
from bladesmith.codegen.checks.errors import CONSTANT, compare, exact_rows
from bladesmith.codegen.declarations import declared_kernels, plain_spec
from bladesmith.codegen.trace.trace import trace

SPEC = """name = "small2d"
vectors = ["0", "1", "2"]
metric = [["1", "1", 1], ["2", "2", 1]]

[kinds.line]
grades = [1]
constraints = ["x * x - 1"]
member = "unit(e1, e2) + scalar() * e0"

[kinds.motor]
grades = [0, 2]
constraints = ["x * ~x - 1"]
member = "(unit(e1, e2) + scalar() * e0) * (unit(e1, e2) + scalar() * e0)"

[[kernels]]
formula = "products.geometric"
operands = [["motor", "motor"], ["layout line", "line"]]

[[kernels]]
formula = "versors.norm"
operands = [["layout line"]]
"""


@pytest.fixture
def spec(tmp_path):
    path = tmp_path / "small2d.toml"
    path.write_text(SPEC)
    return path


def test_right_kernels(spec, capsys):
    assert main.run(["check", str(spec), "--target", "c", "--target", "numpy"]) == 0
    header, *rows, last = capsys.readouterr().out.splitlines()
    assert header.split()[:5] == ["kernel", "operations", "bound", "float64", "float32"]
    names = ["geometric_motor_motor", "geometric_any_line_line", "norm_any_line"]
    assert [row.split()[0] for row in rows] == names
    assert last == "3 of 3 kernels are as exact as their formulas"
    for row in rows:
        operations, bound, double, single, fraction, *targets = row.split()[1:]
        assert int(operations) > 0 and float(bound) > 0 and targets == ["c", "numpy"]
        assert float(double) > 0 and float(single) > 0 and 0 < float(fraction) <= CONSTANT


@pytest.mark.parametrize(
    ("wrong", "says"),
    [
        (lambda v: v * (1 + 1e-12), r"is off by \S+ where \S+ is allowed; x = \["),
        (lambda v: np.where(np.arange(len(v))[:, None] == 3, np.nan, v), r"item 3, coefficient \S+ of out: nan is not"),
    ],
)
def test_a_wrong_kernel_is_named_with_its_operands(wrong, says, spec, capsys, monkeypatch):
    bind = kernels.bind_kernel
    calls = {"c": lambda call: call, "numpy": lambda call: lambda *arrays: wrong(call(*arrays))}
    monkeypatch.setattr(
        kernels, "bind_kernel", lambda variant, target, precision: calls[target](bind(variant, target, precision))
    )
    arguments = ["check", str(spec), "--kernel", "products.geometric"]
    assert main.run([*arguments, "--target", "c"]) == 0
    assert "2 of 2" in capsys.readouterr().out
    assert main.run([*arguments, "--target", "c", "--target", "numpy"]) == 1
    out = capsys.readouterr().out
    assert re.search(rf"geometric_motor_motor on numpy in float64, ordinary members, .*{says}", out)
    assert out.count("FAILED") == 2 and "0 of 2" in out
    operands = re.search(r"; x = (\[.*\]), y = (\[.*\])\n", out)  # as they can be copied
    assert operands and all(len(eval(text)) == 4 for text in operands.groups())


def test_errors_are_in_units_of_roundoff():
    """Against fractions computed here: a result that is moved by a known number of units."""
    algebra = algebra_from_data(plain_spec(2, 0, 0, "plane"))
    (declared,) = (d for d in declared_kernels(algebra, plain_spec(2, 0, 0, "plane")["kernels"]) if
                   d.name == "inner_vector_vector")  # fmt: skip
    kernel = trace(declared.formula, declared.kinds, declared.name)
    a, b = np.array([[3.0, 0.1]]), np.array([[0.7, -2.3]])
    true = sum((Fraction(x) * Fraction(y) for x, y in zip(a[0], b[0], strict=True)), Fraction(0))
    exact = exact_rows(kernel, [a, b])
    assert exact == [[[true]]]
    bound = abs(3 * 0.7) + abs(0.1 * 2.3) + abs(float(true))  # a rounding of each product, and of the sum
    for units in (3, 7, 9, 30):
        moved = np.array([[float(true) + units * 2.0**-53 * bound]])
        found = compare(kernel, [a, b], moved, exact)
        assert found.fraction == pytest.approx(units / CONSTANT, rel=0.05)
        assert found.units == pytest.approx(units * bound / abs(float(true)), rel=0.05)
        assert bool(found.fault) == (units > CONSTANT)


def test_numbers_beyond_the_range_are_no_fault():
    """A product in single precision, of numbers whose product is none; but NaN of ordinary ones is."""
    algebra = algebra_from_data(plain_spec(1, 0, 0, "line"))
    kernel = trace(lambda a, b: a * b * 1, [algebra.kind("vector")] * 2, "square")
    for size, is_fault in ((1e30, False), (1.0, True)):
        arrays = [np.full((1, 1), size, np.float32)] * 2
        found = compare(kernel, arrays, np.full((1, 1), np.nan, np.float32), exact_rows(kernel, arrays))
        assert bool(found.fault) == is_fault


@pytest.mark.parametrize(
    ("change", "arguments", "says"),
    [
        (('grades = [1]', 'grades = ["x"]'), [], r"SpecError: .*small2d.toml, line 6: kinds.line.grades\[0\] is"),
        (('"versors.norm"', '"versors.nrm"'), [], "versors has no formula 'nrm' .did you mean 'norm'"),
        (("x * x - 1", "x * x - 2"), [], "its random member breaks it"),
        (("", ""), ["--kernel", "geometric_motor_moto"], "did you mean 'geometric_motor_motor'"),
    ],
)  # fmt: skip
def test_bad_input(change, arguments, says, spec, capsys):
    spec.write_text(SPEC.replace(*change) if change[0] else SPEC)
    assert main.run(["check", str(spec), *arguments]) == 2
    captured = capsys.readouterr()
    assert re.search(says, captured.err) and not captured.out


def test_a_target_that_does_not_run_here(spec, capsys, monkeypatch):
    monkeypatch.setattr(kernels, "_why_no_c", lambda: "no C compiler")
    assert main.run(["check", str(spec), "--target", "c"]) == 2
    assert "--target c does not run here: no C compiler" in capsys.readouterr().err
    monkeypatch.setattr(kernels, "_why_no_numba", lambda: "no numba")
    assert main.run(["check", str(spec), "--kernel", "versors.norm"]) == 0
    captured = capsys.readouterr()
    assert "not run here: c: no C compiler; numba: no numba" in captured.err
    assert captured.out.splitlines()[1].split()[6] == "numpy"
