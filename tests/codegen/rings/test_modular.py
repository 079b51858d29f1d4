"""The exact layer: arithmetic of F_p^2 against Python integers, and what the zero tests can and cannot see."""

from __future__ import annotations

from fractions import Fraction

import numpy as np

from bladesmith.codegen.rings import modular
from bladesmith.codegen.rings.modular import P, Samples
from bladesmith.codegen.rings.protocol import SampleRing


def pair(z: Samples, i: int) -> tuple[int, int]:
    return int(z.re[i]), int(z.imaginary()[i])


def times(a: tuple[int, int], b: tuple[int, int]) -> tuple[int, int]:
    return (a[0] * b[0] - a[1] * b[1]) % P, (a[0] * b[1] + a[1] * b[0]) % P


def random_samples(seed: int, real: bool, count: int = 200) -> Samples:
    rng = np.random.default_rng(seed)
    re = rng.integers(0, P, count, dtype=np.uint64)
    re[:3] = [0, 1, P - 1]
    return Samples(re, None if real else rng.integers(0, P, count, dtype=np.uint64))


def test_products_match_python_integers() -> None:
    for real_a in (True, False):
        for real_b in (True, False):
            a, b = random_samples(1, real_a), random_samples(2, real_b)
            product = modular.multiply(a, b)
            assert all(pair(product, i) == times(pair(a, i), pair(b, i)) for i in range(200))


def test_sums_with_rational_weights() -> None:
    a, b = random_samples(3, True), random_samples(4, False)
    total = modular.combine([(a, Fraction(-3, 7)), (b, Fraction(5))])
    seventh = pow(7, -1, P)
    for i in range(200):
        expected = (-3 * pair(a, i)[0] * seventh + 5 * pair(b, i)[0]) % P, 5 * pair(b, i)[1] % P
        assert pair(total, i) == expected


def test_reciprocals_and_roots() -> None:
    for real in (True, False):
        a = random_samples(5, real)
        inverse, alive = modular.reciprocal(a)
        assert bool(alive[0]) == (not real)
        assert all(pair(modular.multiply(a, inverse), i) == (1, 0) for i in range(200) if alive[i])
        root, alive = modular.sqrt(a)
        assert all(pair(modular.multiply(root, root), i) == pair(a, i) for i in range(200) if alive[i])
        assert alive.mean() == 1 if real else 0.3 < alive.mean() < 0.7


def test_every_square_of_the_field_has_its_root() -> None:
    a = random_samples(6, False)
    _, alive = modular.sqrt(modular.multiply(a, a))
    assert alive.all()


def test_comparisons_meet_in_all_combinations() -> None:
    rows = [modular.comparison_pattern(i, 1024) for i in range(6)]
    seen = {tuple(bool(row[sample]) for row in rows) for sample in range(1024)}
    assert len(seen) == 2**6
    assert all(400 < modular.comparison_pattern(i, 1024).sum() < 624 for i in range(6, 40))


def test_functions_keep_the_identities_that_formulas_use() -> None:
    ring = SampleRing(64)
    x = random_samples(7, True, 64)
    one = Fraction(1)

    def vanishes(*terms: tuple[Samples, Fraction]) -> bool:
        return ring.is_zero(ring.combine(terms))

    c, s = ring.apply("cos", x), ring.apply("sin", x)
    assert vanishes((ring.multiply(c, c), one), (ring.multiply(s, s), one), (ring.constant(one), -one))
    c0, c1, c2, c3 = (ring.apply(f"stumpff{k}", x) for k in range(4))
    w_c1 = ring.multiply(x, ring.multiply(c1, c1))
    assert vanishes((ring.multiply(c0, c0), one), (w_c1, one), (ring.constant(one), -one))
    assert vanishes((ring.multiply(x, c2), one), (c0, one), (ring.constant(one), -one))
    assert vanishes((ring.multiply(x, c3), one), (c1, one), (ring.constant(one), -one))
    assert not vanishes((ring.apply("exp", x), one), (ring.apply("log", x), -one))
