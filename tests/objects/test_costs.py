"""Costs of rotors and of pairs of objects: matrices of the algebra, 50 digits, motions whose cost is known."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import sqrtm

import bladesmith as bs
from bladesmith import cga3d as cga
from bladesmith.codegen.rings.protocol import PrecisionRing
from bladesmith.objects.rotors import pairwise
from bladesmith.objects.rotors.between import rotor_between
from bladesmith.objects.rotors.costs import cost_matrix, rotor_cost

from ..support.formulas import members, precise, stock
from ..support.objects.costs import KINDS, flipped, objects

COSTS = ("positive", "thesis")


# -- costs of rotors ---------------------------------------------------------------------------------------


def written_cost(names: Any, values: np.ndarray, kind: str) -> np.ndarray:
    """(5.1), and the positive one, term by term on orthonormal blades: those with e- = e5 square to the other sign."""
    total: Any = 0.0
    for blade, c in zip(names, np.moveaxis(values, -1, 0), strict=True):
        sign = -1.0 if "5" in blade and kind == "thesis" else 1.0
        total = total + sign * ((c - 1) ** 2 if blade == "1" else c**2) + (sign * c**2 if "4" in blade else 0)
    return np.asarray(total)


@pytest.mark.parametrize("kind", COSTS)
@pytest.mark.parametrize("of", ["rotor", "motor", "homothety", "transversor", "rotor_conformal"])
def test_cost_of_a_rotor_is_its_coefficients(of: str, kind: str) -> None:
    rows = members(stock("cga3d").kind(of), 40, 3)
    r = cga.wrap(cga.kind(of), rows)
    x = r.to_basis("orthonormal")
    sign = np.where(x["1"] < 0, -1.0, 1.0)[:, None]
    assert of in ("transversor", "homothety") or (sign < 0).any()
    expected = written_cost([str(b) for b in x.blades], sign * x.values, kind)
    scale = np.sum(x.values**2, -1)
    np.testing.assert_array_less(np.abs(rotor_cost(r, kind) - expected), 1e-12 * scale + 1e-300)
    if of != "transversor":  # whose scalar part is 1
        other = cga.wrap(cga.kind(of), -rows)
        np.testing.assert_allclose(rotor_cost(other, kind), rotor_cost(r, kind), rtol=0, atol=1e-14 * scale.max())


def test_costs_of_known_motions() -> None:
    angle, t = np.linspace(0, 3.1, 9), np.array([[0.0, 0, 1.5]])
    turn = cga.rotor(axis=(0, 0, 1), angle=angle)
    np.testing.assert_allclose(rotor_cost(turn), 2 - 2 * np.cos(angle / 2), atol=1e-15)
    np.testing.assert_allclose(rotor_cost(cga.translator(t) * turn), 2 - 2 * np.cos(angle / 2) + 0.75 * 2.25)
    np.testing.assert_allclose(rotor_cost(cga.translator(t) * turn, "thesis"), 2 - 2 * np.cos(angle / 2) + 0.25 * 2.25)
    c, s = np.cosh(np.log(10) / 2), np.sinh(np.log(10) / 2)
    np.testing.assert_allclose(rotor_cost(cga.dilator(10.0)), (c - 1) ** 2 + 2 * s**2)
    np.testing.assert_allclose(rotor_cost(cga.dilator(10.0), "thesis"), (c - 1) ** 2 - 2 * s**2)
    assert rotor_cost(cga.rotor(axis=(0, 0, 1), angle=0.0)) == 0.0


def test_small_motions_keep_their_digits() -> None:
    angle = 10.0 ** -np.arange(1, 150)
    np.testing.assert_allclose(rotor_cost(cga.rotor(axis=(0, 0, 1), angle=angle)), 4 * np.sin(angle / 4) ** 2, 1e-14)


# -- costs of pairs, against matrices ----------------------------------------------------------------------


@cache
def left_matrices() -> tuple[list[str], np.ndarray]:
    """For each blade of Cl(4,1) the matrix of the product with it from the left."""
    algebra = bs.algebra(4, 1)
    full = algebra.multivector(np.eye(32), grades=range(6))
    products = full[:, None] * full[None]
    table = algebra.multivector(products.values, blades=[str(b) for b in products.blades])
    assert table.blades == full.blades
    return [str(b) for b in full.blades], np.moveaxis(table.values, 1, 2)


def matrix_rotor(x: Any, y: Any) -> np.ndarray:
    """K^(-1/2) (1 + gamma Y X) by the square root of a 32 x 32 matrix: no closed form is used."""
    names, table = left_matrices()

    def rows(mv: Any) -> np.ndarray:
        on = mv.to_basis("orthonormal")
        full = np.zeros(32)
        full[[names.index(str(b)) for b in on.blades]] = on.values
        return full

    a, b = (np.tensordot(rows(mv), table, 1) for mv in (x, y))
    gamma = 1.0 if x.grades[0] < 4 else -1.0
    if gamma < 0 and (a @ b)[0, 0] > 1:  # spheres apart: to -Y
        b = -b
    z = np.eye(32) + gamma * b @ a
    k = 2 * np.eye(32) + gamma * (a @ b + b @ a)
    r = np.linalg.solve(sqrtm(k).real, z)[:, 0]
    return r if r[0] >= 0 else -r


@pytest.mark.parametrize("kind", KINDS)
def test_pairs_against_square_roots_of_matrices(kind: str) -> None:
    x, y = objects(kind, 6, 1), objects(kind, 5, 2)
    names, _ = left_matrices()
    for cost in COSTS:
        found = cost_matrix(x, y, cost)
        assert found.shape == (6, 5)
        expected = [[written_cost(names, matrix_rotor(a, b), cost) for b in y] for a in x]
        np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("mixture", [("line", "circle"), ("plane", "sphere")])
def test_flats_and_rounds_mixed(mixture: tuple[str, str]) -> None:
    flat, round_ = (objects(kind, 4, seed) for kind, seed in zip(mixture, (7, 8), strict=True))
    names, _ = left_matrices()
    for x, y in [(flat, round_), (round_, flat), ([flat[0], round_[1]], [round_[2], flat[3]])]:
        expected = [[written_cost(names, matrix_rotor(a, b), "positive") for b in y] for a in x]
        np.testing.assert_allclose(cost_matrix(x, y), expected, rtol=1e-9, atol=1e-9)


def exact_cost(x: Any, y: Any, digits: int = 50) -> float:
    """The positive cost at 50 digits: K^(-1/2) by Newton's iteration Y (3 - K Y^2)/2, on the coefficients given."""
    ring = PrecisionRing(digits)
    algebra = stock("cga3d")
    a, b = (precise(algebra.kind(mv.kind.name), mv.values, ring) for mv in (x, y))
    gamma = 1 if x.grades[0] < 4 else -1
    z, k = 1 + gamma * (b * a), 2 + gamma * (a * b + b * a)
    size = sum(abs(c) for c in k.terms.values())
    scale = k.new({0: 1 / size})
    root, scaled = k.constant(1), k * scale
    for _ in range(400):
        step = root * (3 - scaled * root * root) / 2
        if max((abs(c) for c in (step - root).terms.values()), default=0) < 10.0 ** (8 - digits):
            break
        root = step
    r = root * z
    terms = {algebra.blade_name(b): c / ring.context.sqrt(size) for b, c in r.terms.items()}
    positive = [(c - 1) ** 2 if name == "1" else c**2 for name, c in _orthonormal(terms).items()]
    parallel = [c**2 for name, c in _orthonormal(terms).items() if "p" in name]
    return float(sum(positive) + sum(parallel))


def _orthonormal(terms: dict[str, Any]) -> dict[str, Any]:
    """Coefficients by blade with p = e+, m = e-: n0 = (m - p)/2, n_inf = p + m, n0 ^ n_inf = -(p ^ m)."""
    found: dict[str, Any] = {}
    for name, c in terms.items():
        if "no" in name and "ni" in name:
            parts = {name.replace("no", "").replace("ni", "") + "pm": -c}
        elif "no" in name:
            stem = name.replace("no", "")
            parts = {stem + "p": -c / 2, stem + "m": c / 2}
        elif "ni" in name:
            stem = name.replace("ni", "")
            parts = {stem + "p": c, stem + "m": c}
        else:
            parts = {name: c}
        for blade, part in parts.items():
            found[blade] = found.get(blade, 0) + part
    return found


@pytest.mark.parametrize("kind", KINDS)
def test_pairs_at_50_digits_near_and_far_from_each_other(kind: str) -> None:
    x = objects(kind, 4, 3)
    for size in (1.0, 1e-3, 1e-6):
        y = cga.translator(size * np.array([0.3, -0.5, 0.4])) >> (cga.rotor((1, 2, 3), size * 0.7) >> x)
        expected = [exact_cost(a, b.as_kind(kind, check=False)) for a, b in zip(x, y, strict=True)]
        # of a difference of size s, rounded coefficients keep eps/s
        np.testing.assert_allclose(np.diag(cost_matrix(x, y)), expected, rtol=1e-13 / size)


# -- properties --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", ("point", *KINDS))
@pytest.mark.parametrize("align", [False, True])
def test_symmetric_and_zero_for_itself(kind: str, align: bool) -> None:
    x, y = objects(kind, 30, 4), objects(kind, 25, 5)
    cost = cost_matrix(x, y, align=align)
    assert (cost > 0).all()
    np.testing.assert_allclose(cost, cost_matrix(y, x, align=align).T, rtol=1e-11)
    assert (np.diag(cost_matrix(x, x, align=align)) < 1e-25).all()
    thesis = cost_matrix(x, y, "thesis", align=align)
    assert (thesis <= cost * (1 + 1e-12)).all()
    np.testing.assert_allclose(thesis, cost_matrix(y, x, "thesis", align=align).T, rtol=1e-11, atol=1e-11)


@pytest.mark.parametrize("kind", KINDS)
def test_aligned_is_the_cost_of_like_orientations(kind: str) -> None:
    x, y = objects(kind, 30, 6), objects(kind, 25, 7)
    inner = cost_matrix(x, y, align=True)
    np.testing.assert_allclose(inner, cost_matrix(x, flipped(y), align=True), rtol=1e-12)
    agreeing = np.abs(inner - cost_matrix(x, y)) <= 1e-12 * inner
    opposite = np.abs(inner - cost_matrix(x, flipped(y))) <= 1e-12 * inner
    assert (agreeing | opposite).all() and agreeing.any() and opposite.any()


@settings(max_examples=25)
@given(
    st.sampled_from(KINDS),
    st.integers(0, 10**6),
    st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda v: np.linalg.norm(v) > 0.1),
    st.floats(-6, 6),
)
def test_turning_both_about_the_origin_changes_nothing(kind: str, seed: int, axis: Any, angle: float) -> None:
    x, y = objects(kind, 3, seed), objects(kind, 4, seed + 1)
    turn = cga.rotor(axis, angle)
    moved = [(turn >> o).as_kind(kind, check=False) for o in (x, y)]
    np.testing.assert_allclose(cost_matrix(*moved), cost_matrix(x, y), rtol=1e-6)


@pytest.mark.parametrize("kind", ("point", *KINDS))
def test_it_is_the_cost_of_rotor_between(kind: str) -> None:
    x, y = objects(kind, 40, 8), objects(kind, 40, 9)
    for cost in COSTS:
        r = rotor_between(x[:, None], y[None])
        values, status = cost_matrix(x, y, cost, status=True)
        np.testing.assert_allclose(values, rotor_cost(r, cost), rtol=1e-8, atol=1e-8)
        np.testing.assert_array_equal(status, np.asarray(r.status))


@pytest.mark.compiles
@pytest.mark.parametrize("kind", ("point", *KINDS))
def test_single_precision(kind: str) -> None:
    x, y = objects(kind, 60, 10), objects(kind, 50, 11)
    found = cost_matrix(x.astype(np.float32), y.astype(np.float32))
    assert found.dtype == np.float32 and np.isfinite(found).all()
    assert np.median(np.abs(found / cost_matrix(x, y) - 1)) < 1e-5
    assert np.quantile(np.abs(found / cost_matrix(x, y) - 1), 0.999) < 1e-2


def test_points_are_translated() -> None:
    a, b = np.random.default_rng(0).normal(size=(2, 6, 3))
    squared = ((a[:, None] - b) ** 2).sum(-1)
    np.testing.assert_allclose(cost_matrix(cga.point(a), cga.point(b)), 0.75 * squared)
    np.testing.assert_allclose(cost_matrix(cga.point(a + 1e6), cga.point(b + 1e6), "thesis"), squared / 4, rtol=1e-8)


def test_concentric_spheres_cost_less_than_nothing_as_printed() -> None:
    small, large = cga.sphere([0, 0, 0], [1.0, 10.0])
    assert round(float(cost_matrix(small, large, "thesis")), 1) == -3.5
    assert cost_matrix(small, large) > cost_matrix(small, small) >= 0


def test_threads_give_the_same_bits() -> None:
    x, y = objects("line", 400, 12), objects("line", 300, 13)
    np.testing.assert_array_equal(cost_matrix(x, y, threads=1), cost_matrix(x, y, threads=2))


@pytest.mark.parametrize("threads", [1, 2])
def test_long_loops_look_up_between_chunks(threads: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """An interrupt is seen within some hundred milliseconds, and chunks change nothing."""
    monkeypatch.setattr(pairwise, "MOST_PAIRS", 1000)
    monkeypatch.setattr(pairwise.parallel, "GRAIN", 100)
    parts: list[tuple[int, int]] = []
    pairwise.over_rows(100, threads)(lambda begin, end: parts.append((begin, end)), 95)
    assert max(end - begin for begin, end in parts) * 100 <= 1000
    assert sorted(i for part in parts for i in range(*part)) == [*range(95)]
    x, y = objects("line", 95, 18), objects("line", 100, 19)
    chunks = cost_matrix(x, y, threads=threads)
    monkeypatch.undo()
    np.testing.assert_array_equal(chunks, cost_matrix(x, y, threads=threads))
