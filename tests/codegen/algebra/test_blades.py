"""Blades, metrics and products against an independent construction: matrices of the regular representation."""

from __future__ import annotations

from fractions import Fraction

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bladesmith.codegen.algebra.algebra import Algebra, orthonormal
from bladesmith.codegen.algebra.blades import outer_sign
from bladesmith.codegen.algebra.members import RationalSource
from bladesmith.codegen.algebra.multivector import Multivector, from_values
from bladesmith.codegen.errors import BladeError, KindError, SignatureError
from bladesmith.codegen.rings.protocol import RationalRing

CGA = Algebra(
    "c",
    ["1", "2", "3", "no", "ni"],
    [[1, 0, 0, 0, 0], [0, 1, 0, 0, 0], [0, 0, 1, 0, 0], [0, 0, 0, 0, -1], [0, 0, 0, -1, 0]],
)


def naive_product(word_a: list[int], word_b: list[int], squares: list[int]) -> tuple[int, int]:
    """Product of two words of orthonormal vectors by bubble sort: the sign and the mask."""
    word, sign = word_a + word_b, 1
    done = False
    while not done:
        done = True
        for i in range(len(word) - 1):
            if word[i] > word[i + 1]:
                word[i], word[i + 1] = word[i + 1], word[i]
                sign, done = -sign, False
            elif word[i] == word[i + 1]:
                sign *= squares[word[i]]
                del word[i : i + 2]
                done = False
                break
    return sign, sum(1 << i for i in word)


@given(st.integers(0, 3), st.integers(0, 3), st.integers(0, 2), st.data())
@settings(max_examples=200)
def test_orthonormal_products_match_sorting(p: int, q: int, r: int, data: st.DataObject) -> None:
    algebra = orthonormal(p, q, r)
    n = algebra.dimension
    squares = [int(algebra.metric[i][i]) for i in range(n)]
    a, b = (data.draw(st.integers(0, 2**n - 1)) for _ in range(2))
    words = [[i for i in range(n) if m >> i & 1] for m in (a, b)]
    sign, blade = naive_product(words[0], words[1], squares)
    assert algebra.product(a, b) == (((blade, Fraction(sign)),) if sign else ())
    assert algebra.signature == (p, q, r)


def random_multivector(algebra: Algebra, seed: int) -> Multivector:
    source = RationalSource(seed)
    return from_values(algebra, source.ring, algebra.blades, [source.scalar() for _ in algebra.blades])


def equal(a: Multivector, b: Multivector) -> bool:
    return not (a - b).terms


@pytest.mark.parametrize("algebra", [CGA, orthonormal(3, 0, 1), orthonormal(2, 2, 1)], ids=lambda a: a.name)
@pytest.mark.parametrize("seed", [1, 2])
def test_geometric_product_is_associative_and_filters_agree(algebra: Algebra, seed: int) -> None:
    a, b, c = (random_multivector(algebra, 10 * seed + i) for i in range(3))
    assert equal((a * b) * c, a * (b * c))
    assert equal((a ^ b) ^ c, a ^ (b ^ c))
    assert equal(~(a * b), ~b * ~a)
    assert equal(a.commutator(b) + a.anticommutator(b), a * b)
    parts = [
        (a.grade(g) * b.grade(h)).grade(g + h)
        for g in range(algebra.dimension + 1)
        for h in range(algebra.dimension + 1)
    ]
    assert equal(a.sum(parts), a ^ b)
    inner = [
        (a.grade(g) * b.grade(h)).grade(abs(g - h))
        for g in range(1, algebra.dimension + 1)
        for h in range(1, algebra.dimension + 1)
    ]
    assert equal(a.sum(inner), a | b)
    assert equal((a * b).grade(0), a.scalar_product(b))
    assert equal(a.undual().dual(), a)


def test_null_basis_is_the_orthonormal_algebra_in_disguise() -> None:
    """Substitute n0 = (e- - e+)/2, n_inf = e+ + e- in Cl(4,1): the products must agree."""
    other = orthonormal(4, 1)
    like = Multivector(other, RationalRing(), {})
    images = [like.basis("e1"), like.basis("e2"), like.basis("e3")]
    images += [(like.basis("e5") - like.basis("e4")) / 2, like.basis("e4") + like.basis("e5")]

    def image(x: Multivector) -> Multivector:
        total = like
        for blade, c in x.terms.items():
            word = like.constant(1)
            for i in range(5):
                if blade >> i & 1:
                    word = word ^ images[i]
            total = total + word * like.new({0: c})
        return total

    a, b = random_multivector(CGA, 3), random_multivector(CGA, 4)
    assert equal(image(a * b), image(a) * image(b))
    assert equal(image(a | b), image(a) | image(b))
    assert CGA.signature == (4, 1, 0)


def test_pga_dual_is_the_poincare_map() -> None:
    """MATHS: X ^ J(X) = I = e1230 on basis blades, J(J(A)) = (-1)^{g(4-g)} A."""
    metric = [[0, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]
    pga = Algebra("p", ["0", "1", "2", "3"], metric, pseudoscalar="e1230")
    like = Multivector(pga, RationalRing(), {})
    for blade in pga.blades:
        x = like.new({blade: Fraction(1)})
        assert equal(x ^ x.dual(), x.pseudoscalar())
        g = blade.bit_count()
        assert equal(x.dual().dual(), x * (-1) ** (g * (4 - g)))
        assert equal(x.dual().undual(), x)


@pytest.mark.parametrize(
    ("name", "blade", "sign"),
    [
        ("e12", 0b11, 1),
        ("e21", 0b11, -1),
        ("1", 0, 1),
        ("e1noni", 0b11001, 1),
        ("nino", 0b11000, -1),
        ("no", 0b1000, 1),
    ],
)
def test_blade_names(name: str, blade: int, sign: int) -> None:
    assert CGA.parse_blade(name) == (blade, sign)
    assert CGA.parse_blade(CGA.blade_name(blade)) == (blade, 1)


def test_wide_algebras_spell_indices_apart() -> None:
    wide = orthonormal(12)
    blade, sign = wide.parse_blade("e1_12")
    assert (wide.blade_name(blade), sign) == ("e1_12", 1)
    assert wide.parse_blade((12, 1)) == (blade, -1)
    assert wide.parse_blade("e12") == (1 << 11, 1)


@pytest.mark.parametrize("name", ["e9", "x", "e1noo", "e_1", "__import__", 3, None, 1.5, b"e1", {}, [None], (1, 2.5)])
def test_unknown_blades_are_named(name: object) -> None:
    with pytest.raises(BladeError, match="is not a blade of c"):
        CGA.parse_blade(name)  # type: ignore[arg-type]
    with pytest.raises(BladeError, match="twice"):
        CGA.parse_blade("e11")


@pytest.mark.parametrize("pqr", [(-1, 0, 0), (13, 12, 0), (2.0, 0, 0), (True, 0, 0), ("3", 0, 0)])
def test_bad_signatures(pqr: tuple[int, int, int]) -> None:
    with pytest.raises(SignatureError):
        orthonormal(*pqr)


@pytest.mark.parametrize("name", ["", "a-b", "1a", "a" * 65, "x;y", "é", None])
def test_names_that_are_no_identifiers(name: str) -> None:
    with pytest.raises(SignatureError, match="a name is a letter"):
        Algebra(name, ["1"], [[1]])


def test_unknown_kind_says_the_nearest() -> None:
    with pytest.raises(KindError, match="has no kind"):
        CGA.kind("circel")


def test_fifteen_dimensions_are_lazy() -> None:
    algebra = orthonormal(9, 6)
    assert algebra.product(0b111, 0b110)[0][0] == 0b001
    assert len(algebra._products) < 4
    assert outer_sign(0b10, 0b01) == -1
