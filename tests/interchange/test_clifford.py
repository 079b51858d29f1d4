"""`clifford` as a second opinion on the runtime, and the exchange of multivectors with it.

The table of signs, ours in terms of clifford's: the dual is `dual_sign` times its dual (X I against X I^-1); the
meet is written with its outer product and our duals, which differ from its `vee` by conventions only.
"""

from __future__ import annotations

import sys
from typing import Any

import numpy as np
import pytest

import bladesmith as bs
from bladesmith.core.conversion import basis_change
from bladesmith.interchange.clifford import dual_sign, from_clifford

from ..oracles.clifford_layouts import clifford

pytestmark = pytest.mark.peers

PAIRS = 10_000
SIGNATURES = [(4, 1, 0), (3, 0, 1), (3, 0, 0), (1, 3, 0)]
ALGEBRAS = {"cga3d": lambda: bs.cga3d, **{f"cl{s}": (lambda s=s: bs.algebra(*s)) for s in SIGNATURES}}


@pytest.fixture(scope="module", params=sorted(ALGEBRAS))
def opinion(request: Any) -> Any:
    return Opinion(ALGEBRAS[request.param]())


class Opinion:
    """Random pairs in one algebra, and clifford's products of them from its multiplication tables."""

    def __init__(self, algebra: Any) -> None:
        self.algebra = algebra
        p, q, r = algebra.signature
        self.layout, _ = clifford.Cl(p, q, r, firstIdx=0) if r == 1 else clifford.Cl(p, q, r)
        random = np.random.default_rng(7)
        size = 2**algebra.dimension
        self.a, self.b = (algebra.multivector(random.normal(size=(PAIRS, size))) for _ in range(2))
        self.u, self.v = self.theirs(self.a), self.theirs(self.b)

    def theirs(self, x: Any) -> np.ndarray:
        """Rows in the layout's order. Its order is ours, by grade and index, so only the basis changes."""
        own = x.to_basis("orthonormal")
        names = ["1" if not t else "e" + "".join(map(str, t)) for t in self.layout.bladeTupList]
        return np.stack([own[name] for name in names], -1)

    def product(self, table: Any, u: np.ndarray, v: np.ndarray) -> np.ndarray:
        """sum_ij u_i T_ikj v_j"""
        coordinates, data = table.coords, table.data
        out = np.zeros_like(u)
        for (i, k, j), weight in zip(coordinates.T, data, strict=True):
            out[:, k] += weight * u[:, i] * v[:, j]
        return out

    def agrees(self, found: Any, expected: np.ndarray) -> None:
        error = np.abs(self.theirs(found) - expected).max(-1)
        scale = np.abs(expected).max(-1) + 1
        worst = int(np.argmax(error / scale))
        assert (error <= 1e-11 * scale).all(), (worst, self.u[worst], self.v[worst])


@pytest.mark.slow
def test_products_agree(opinion: Opinion) -> None:
    layout, a, b = opinion.layout, opinion.a, opinion.b
    opinion.agrees(a * b, opinion.product(layout.gmt, opinion.u, opinion.v))
    opinion.agrees(a ^ b, opinion.product(layout.omt, opinion.u, opinion.v))
    opinion.agrees(a | b, opinion.product(layout.imt, opinion.u, opinion.v))
    opinion.agrees(a.left_contraction(b), opinion.product(layout.lcmt, opinion.u, opinion.v))
    ab, ba = (opinion.product(layout.gmt, *pair) for pair in ((opinion.u, opinion.v), (opinion.v, opinion.u)))
    opinion.agrees(a.commutator(b), (ab - ba) / 2)
    opinion.agrees(a.anticommutator(b), (ab + ba) / 2)


def test_sandwiches_agree(opinion: Opinion) -> None:
    grades = [len(t) for t in opinion.layout.bladeTupList]
    signs = np.array([-1.0 if g & 2 else 1.0 for g in grades])
    opinion.agrees(~opinion.a, opinion.u * signs)
    left = opinion.product(opinion.layout.gmt, opinion.u, opinion.v)
    opinion.agrees(opinion.a >> opinion.b, opinion.product(opinion.layout.gmt, left, opinion.u * signs))


@pytest.mark.slow
def test_duals_and_meets_agree_through_the_table_of_signs(opinion: Opinion) -> None:
    sign = dual_sign(opinion.algebra)
    layout = opinion.layout
    if sign == 0:  # PGA: J is minus their right complement (our I = e1230 is minus theirs), so a join is minus a vee
        right, left = (_matrix(layout, name) for name in ("right_complement", "left_complement"))
        opinion.agrees(opinion.a.dual(), -opinion.u @ right)
        joined = opinion.product(layout.omt, opinion.u @ right, opinion.v @ right) @ left
        opinion.agrees(opinion.a & opinion.b, -joined)
        return
    unit = np.broadcast_to(layout.pseudoScalar.value, opinion.u.shape)
    inverse = unit * opinion.product(layout.gmt, unit[:1], unit[:1])[0, 0]  # I^-1 = I/I^2, and I^2 = +-1
    first, second = (opinion.product(layout.gmt, rows, inverse) for rows in (opinion.u, opinion.v))
    if opinion.algebra.dimension == 3:  # their own function, which takes seconds to compile in each algebra
        assert np.allclose(clifford.MultiVector(layout, opinion.u[0]).dual().value, first[0])
    opinion.agrees(opinion.a.dual(), sign * first)
    # X v Y = (X* ^ Y*) I; their I is ours
    outer = opinion.product(layout.omt, first, second)
    opinion.agrees(opinion.a & opinion.b, opinion.product(layout.gmt, outer, unit))


def _matrix(layout: Any, name: str) -> np.ndarray:
    """Matrix of a linear map of clifford on rows."""
    return np.stack([getattr(clifford.MultiVector(layout, row), name)().value for row in np.eye(layout.gaDims)])


@pytest.mark.slow
@pytest.mark.parametrize("method", ["shirokov", "hitzer", "matrix"])
def test_inverses_agree(opinion: Opinion, method: str) -> None:
    inverse = opinion.a.inverse(method)
    one = np.zeros_like(opinion.u)
    one[:, 0] = 1
    product = opinion.product(opinion.layout.gmt, opinion.u, opinion.theirs(inverse))
    # an inverse is as good as its multivector is conditioned: the residual is bounded by its size
    size = np.abs(opinion.u).sum(-1) * np.abs(opinion.theirs(inverse)).sum(-1)
    limit = 1e-13 * (size if method != "shirokov" else size**2)
    residual = np.abs(product - one).max(-1)
    answered = np.asarray(inverse.status) == bs.Status.OK
    assert answered.mean() > 0.999
    assert (residual[answered] <= np.maximum(limit, 1e-12)[answered]).all()


# -- exchange ----------------------------------------------------------------------------------------------


def test_round_trips(opinion: Opinion) -> None:
    x = opinion.a[:5]
    there = x.to_clifford(opinion.layout)
    assert there.shape == (5,) and type(there).__name__ == "MVArray"
    assert np.allclose(there[2].value, opinion.u[2])
    assert from_clifford(there, opinion.algebra).isclose(x, rtol=1e-13).all()
    single = x[3].to_clifford()
    assert np.allclose(single.value, opinion.u[3])
    assert from_clifford(single, opinion.algebra).shape == ()
    assert from_clifford([list(there), list(there)]).shape == (2, 5)


@pytest.mark.slow
def test_the_conformal_model_is_the_one_of_clifford() -> None:
    layout, blades, stuff = clifford.conformalize(clifford.Cl(3)[0])
    cga = bs.cga3d
    e1, e2 = blades["e1"], blades["e2"]
    assert np.allclose(cga.ni.to_clifford(layout).value, stuff["einf"].value)
    assert np.allclose(cga.no.to_clifford(layout).value, stuff["eo"].value)
    assert np.allclose(cga.point([1.0, 2.0, 0.0]).to_clifford(layout).value, stuff["up"](e1 + 2 * e2).value)
    point = from_clifford(stuff["up"](e1 + 2 * e2), cga).normalized()
    assert point.kind == cga.kind("point") and np.allclose(point.parameters().xyz, [1, 2, 0])


def test_layouts_in_another_order_are_understood() -> None:
    layout = clifford.Layout([-1, 1, 0, 1])  # ours: e0, e1, e2 (positive), e3 (negative)
    random = np.random.default_rng(0)
    u, v = (clifford.MultiVector(layout, random.normal(size=16)) for _ in range(2))
    x, y = from_clifford(u), from_clifford(v)
    assert x.algebra is bs.algebra(2, 1, 1)
    assert (x * y).isclose(from_clifford(u * v), rtol=1e-12)
    assert np.allclose(x.to_clifford(layout).value, u.value)


def test_bad_exchanges() -> None:
    with pytest.raises(bs.errors.InputError, match="from_clifford takes"):
        from_clifford([1.0, 2.0])
    with pytest.raises(bs.errors.SignatureError, match="signature|Cl"):
        bs.cga3d.ni.to_clifford(clifford.Cl(3)[0])
    mixed = [clifford.Cl(2)[1]["e1"], clifford.Cl(3)[1]["e1"]]
    with pytest.raises(bs.errors.InputError, match="different layouts"):
        from_clifford(mixed)
    with pytest.raises(bs.errors.AlgebraMismatchError):
        from_clifford(clifford.Cl(3)[1]["e1"], bs.cga3d)


def test_orthonormal_basis_in_and_out() -> None:
    cga = bs.cga3d
    plus, minus = (cga.multivector({name: 1.0}, basis="orthonormal") for name in ("e4", "e5"))
    assert ((plus * plus)["1"], (minus * minus)["1"], (plus * minus + minus * plus).norm()) == (1.0, -1.0, 0.0)
    assert cga.ni.isclose(plus + minus) and cga.no.isclose((minus - plus) / 2)
    dense = np.random.default_rng(1).normal(size=(4, 32))
    x = cga.multivector(dense, basis="orthonormal")
    assert np.allclose(basis_change.dense(x.to_basis("orthonormal"), bs.algebra(4, 1)), dense)
    assert cga.multivector(x.to_basis("orthonormal")).isclose(x, rtol=1e-14).all()
    with pytest.raises(bs.errors.AlgebraMismatchError, match="Convert one first"):
        cga.ni * bs.algebra(4, 1).e4
    with pytest.raises(bs.errors.InputError, match="orthonormal"):
        x.to_basis("dual")
    pga = bs.algebra(3, 0, 1)
    assert pga is bs.pga3d and pga.e12.to_basis("orthonormal") is not None


def test_the_package_that_is_missing_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "clifford", None)
    with pytest.raises(bs.errors.MissingExtraError, match="pip install clifford"):
        bs.cga3d.point([1.0, 2.0, 3.0]).to_clifford()
