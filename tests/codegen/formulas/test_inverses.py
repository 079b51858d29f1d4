"""Inverses of general multivectors: the three methods against each other, exact fractions, and `clifford`."""

from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bladesmith.codegen.algebra.algebra import Algebra, orthonormal
from bladesmith.codegen.algebra.members import RationalSource
from bladesmith.codegen.algebra.multivector import Multivector
from bladesmith.codegen.errors import GradeError
from bladesmith.codegen.formulas.objects import conformal
from bladesmith.codegen.formulas.products import frames, inverses, versors
from bladesmith.codegen.rings.protocol import NumericRing
from bladesmith.codegen.status import Status

from ...oracles.clifford_layouts import oracle
from ...support.formulas import Array, Traced, members, multivector, plain, rows, stock

ALGEBRAS = [plain(1), plain(0, 1), plain(2), plain(0, 0, 2), plain(3), plain(1, 3), plain(2, 0, 2)]
ALGEBRAS += [stock("cga2d"), stock("pga3d"), stock("cga3d"), plain(4, 1, 1), plain(3, 3)]


def matrix_inverse(algebra: Algebra, kind: str, x: Array) -> tuple[Array, Array]:
    """Perwass: y -> x y as a matrix, solved for x y = 1; and its condition number."""
    size = len(algebra.blades)
    matrix = np.zeros((len(x), size, size))
    for entry in frames.left_multiplication(algebra, algebra.kind(kind).blades):
        matrix[:, entry.row, entry.column] += x[:, entry.coefficient] * float(entry.weight)
    one = np.zeros((len(x), size, 1))
    one[:, 0] = 1
    return np.linalg.solve(matrix, one)[..., 0], np.linalg.cond(matrix)


@pytest.mark.slow
@pytest.mark.parametrize("algebra", ALGEBRAS, ids=lambda a: a.name)
@pytest.mark.parametrize("kind", ["multivector", "even"])
def test_methods_agree(algebra: Algebra, kind: str) -> None:
    x = members(algebra.kind(kind), 400, 31)
    solved, condition = matrix_inverse(algebra, kind, x)
    methods = [inverses.shirokov] + ([inverses.hitzer] if algebra.dimension <= 5 else [])
    for method in methods:
        found = method(multivector(algebra.kind(kind), x))
        value = rows(algebra.kind("multivector"), found[0])
        assert np.all(found[1].value.scalar() == Status.OK)
        error = np.linalg.norm(value - solved, axis=1) / np.linalg.norm(solved, axis=1) / condition
        assert np.max(error) < 1e-12, (method.__name__, x[np.argmax(error)])


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["multivector", "even"])
@pytest.mark.parametrize("method", [inverses.shirokov, inverses.hitzer])
def test_traced_in_cga(method: Any, kind: str) -> None:
    """As a kernel, with the status; even multivectors invert in the algebra of one vector less."""
    cga = stock("cga3d")
    x = members(cga.kind(kind), 20, 32)
    value, status = Traced(cga, method, kind).all(x)
    solved, _ = matrix_inverse(cga, kind, x)
    if kind == "even":
        solved = solved[:, [cga.blades.index(b) for b in cga.kind("even").blades]]
    assert np.all(status == Status.OK)
    assert np.allclose(value, solved, rtol=1e-8, atol=1e-8)


@pytest.mark.slow
@pytest.mark.parametrize("algebra", [stock("cga3d"), stock("pga3d"), plain(3), plain(1, 3)], ids=lambda a: a.name)
def test_clifford_agrees(algebra: Algebra) -> None:
    """Its product makes one of ours and its operand, on both sides; in Cl(4,1) its own inverse too."""
    kind, theirs = algebra.kind("multivector"), oracle(algebra)
    x = members(kind, 300, 33)
    found = rows(kind, inverses.shirokov(multivector(kind, x))[0])
    scale = np.linalg.norm(x, axis=1) * np.linalg.norm(found, axis=1)
    for one in (theirs.product("gmt", x, found), theirs.product("gmt", found, x)):
        assert np.max(np.abs(one - np.eye(len(algebra.blades))[0]) / scale[:, None] ** 2) < 1e-12
    if algebra.name == "cga3d":
        for row, operand in zip(found[:50], x[:50], strict=True):
            other = theirs.back(theirs.multivector(operand).hitzer_inverse().value)
            assert np.allclose(row, other, rtol=1e-8, atol=1e-8 * np.max(np.abs(other)))


@settings(max_examples=60)
@given(st.integers(0, 5), st.integers(0, 3), st.integers(0, 2), st.integers(0, 10**6))
def test_exact_on_fractions(p: int, q: int, r: int, seed: int) -> None:
    """Every signature to 5 dimensions, degenerate ones included: x V = 1 without any rounding."""
    n = p + q + r
    if not 0 < n <= 5:
        return
    algebra = orthonormal(p, q, r)
    source = RationalSource(seed)
    chosen = np.random.default_rng(seed).permutation(len(algebra.blades))[:6]
    x = Multivector(algebra, source.ring, {algebra.blades[i]: source.scalar() for i in sorted(chosen)})
    if not x.terms:
        return
    det = inverses.determinant(x).terms.get(0, Fraction(0))
    adjugate = inverses.shirokov_adjugate(x)
    assert (x * adjugate).terms == ({0: det} if det else {})
    assert (adjugate * x).terms == ({0: det} if det else {})
    other = inverses.hitzer_adjugate(x)
    product = (x * other).terms
    assert set(product) <= {0}
    if det and product:
        assert (adjugate * (1 / det)).terms == (other * (1 / product[0])).terms


@pytest.mark.slow
@pytest.mark.parametrize("dtype", [np.float64, np.float32])
@pytest.mark.parametrize("algebra", ALGEBRAS[4:], ids=lambda a: a.name)
def test_singular_items_are_found(algebra: Algebra, dtype: Any) -> None:
    """x (1 + u) y with u^2 = 1, and a sum with several null directions: the determinant is rounding noise."""
    ring = NumericRing(dtype)
    rng = np.random.default_rng(35)

    def random() -> Multivector:
        return Multivector(algebra, ring, {b: rng.normal(size=500).astype(dtype) for b in algebra.blades})

    one = ring.constant(Fraction(1))
    axis = next(i for i in range(algebra.dimension) if algebra.metric[i][i] == 1)
    singular = random() * Multivector(algebra, ring, {0: one, 1 << axis: one}) * random()
    methods = [inverses.shirokov] + ([inverses.hitzer] if algebra.dimension <= 5 else [])
    for method in methods:
        value, status = method(singular)
        assert np.all(status.value.scalar() == Status.SINGULAR)
        assert all(np.all(np.isnan(c)) for c in value.terms.values())
        regular = method(random())[1].value.scalar()
        assert np.mean(regular == Status.OK) >= (1 if dtype == np.float64 else 0.98)


def test_zero_infinite_and_nan() -> None:
    pga = stock("pga3d")
    x = members(pga.kind("multivector"), 4, 36)
    x[0] = 0
    x[1, 3], x[2, 7] = np.nan, np.inf
    value, status = Traced(pga, inverses.shirokov, "multivector").all(x)
    assert status.tolist() == [Status.SINGULAR, Status.INVALID, Status.INVALID, Status.OK]
    assert np.all(np.isnan(value[:3])) and np.all(np.isfinite(value[3]))


def test_large_translations_are_not_singular() -> None:
    """The determinant is 1 however large the coefficients."""
    for name in ("cga3d", "pga3d"):
        algebra = stock(name)
        x = members(algebra.kind("motor"), 50, 37)
        t = members(algebra.kind("translator"), 50, 38, 1e7)
        far = multivector(algebra.kind("translator"), t) * multivector(algebra.kind("motor"), x)
        motor = rows(algebra.kind("motor"), far)
        value, status = Traced(algebra, inverses.shirokov, "~motor").all(motor)
        assert np.all(status == Status.OK)
        reverse = rows(algebra.kind("motor"), ~far)
        assert np.allclose(value, reverse, rtol=1e-12, atol=1e-12 * np.max(np.abs(reverse)))


def test_versor_inverse() -> None:
    cga = stock("cga3d")
    center, radius = members(cga.kind("euclidean"), 50, 39), np.abs(members(cga.kind("scalar"), 50, 40)[:, 0]) + 0.1
    sphere = Traced(cga, conformal.sphere, "euclidean", "number")(center, radius) * -3.0
    value, status = Traced(cga, versors.versor_inverse, "~sphere").all(sphere)
    solved, _ = matrix_inverse(cga, "sphere", sphere)
    solved = solved[:, [cga.blades.index(b) for b in cga.kind("sphere").blades]]
    assert np.all(status == Status.OK) and np.allclose(value, solved, rtol=1e-10, atol=1e-12)
    point = Traced(cga, conformal.point, "euclidean")(center)
    value, status = Traced(cga, versors.versor_inverse, "~point").all(point)
    assert np.all(status == Status.SINGULAR) and np.all(np.isnan(value))


def test_hitzer_ends_at_five_dimensions() -> None:
    six = plain(3, 3)
    with pytest.raises(GradeError, match="goes to 5 dimensions"):
        Traced(six, inverses.hitzer, "multivector")
    seven = orthonormal(5, 2)
    x = multivector_of_vectors(seven, 3)
    value, _ = inverses.shirokov(x)
    one = (x * value).terms
    assert set(one) == {0} and one[0] == 1


def multivector_of_vectors(algebra: Algebra, seed: int) -> Multivector:
    """A sparse element of a large algebra, over the fractions."""
    source = RationalSource(seed)
    v = Multivector(algebra, source.ring, {1 << i: source.scalar() for i in range(3)})
    return v * v.basis("e45") + v.basis("e67") + v.constant(2)
