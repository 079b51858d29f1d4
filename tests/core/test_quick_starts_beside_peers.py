"""Quick starts of `clifford` and `kingdon` in their words and in ours: at most five lines changed, the same results."""

from __future__ import annotations

from difflib import SequenceMatcher
from typing import Any

import numpy as np
import pytest
import sympy

pytestmark = pytest.mark.peers

CLIFFORD = (
    """
from math import e, pi
from clifford.g3 import *
a = e1 + 2 * e2 + 3 * e3
R = e ** (-pi / 4 * e12)
turned = R * a * ~R
plane = e1 ^ (e2 + e3)
volume = plane ^ (2 * e3 + 1)
contracted = e1 << plane
inner = a | plane
there_and_back = a * a.inv()
part = (a * plane)(1)
unit = a.normal()
mirrored = -e1 * a * e1
""",
    """
from math import e, pi
from bladesmith.vga3d import e1, e2, e3, e12
a = e1 + 2 * e2 + 3 * e3
R = e ** (-pi / 4 * e12)
turned = R * a * ~R
plane = e1 ^ (e2 + e3)
volume = plane ^ (2 * e3 + 1)
contracted = e1.left_contraction(plane)
inner = a | plane
there_and_back = a * a.inverse()
part = (a * plane).grade(1)
unit = a.normalized()
mirrored = -e1 * a * e1
""",
)

KINGDON = (
    """
from kingdon import Algebra
alg = Algebra(3, 0, 1)
locals().update(alg.blades)
b = 2 * e12
v = 3 * e1
product = b * v
B = alg.bivector(name="B")
u = alg.vector(name="u")
symbolic = B.cp(u)
some = alg.bivector(e12="s", e03=3)
w = alg.vector(e1=1, e3=1)
partly = some.cp(w)
met = (e1 + e0) ^ e2 ^ (e3 - 2 * e0)
moved = (1 + e01) >> met
""",
    """
from bladesmith import algebra as Algebra; from sympy import Symbol
alg = Algebra(3, 0, 1)
locals().update(alg.blades)
b = 2 * e12
v = 3 * e1
product = b * v
B = alg.bivector(name="B")
u = alg.vector(name="u")
symbolic = B.commutator(u)
some = alg.bivector(e12=Symbol("s"), e03=3)
w = alg.vector(e1=1, e3=1)
partly = some.commutator(w)
met = (e1 + e0) ^ e2 ^ (e3 - 2 * e0)
moved = (1 + e01) >> met
""",
)


def results(program: str, names: tuple[str, ...]) -> dict[str, Any]:
    scope: dict[str, Any] = {}
    exec(program, scope)
    return {name: scope[name] for name in names}


def changed_lines(theirs: str, ours: str) -> int:
    a, b = theirs.strip().splitlines(), ours.strip().splitlines()
    return sum(
        max(i2 - i1, j2 - j1) for tag, i1, i2, j1, j2 in SequenceMatcher(None, a, b).get_opcodes() if tag != "equal"
    )


def test_the_quick_start_of_clifford():
    theirs, ours = CLIFFORD
    assert changed_lines(theirs, ours) <= 5
    names = ("turned", "plane", "volume", "contracted", "inner", "there_and_back", "part", "unit", "mirrored")
    expected, found = results(theirs, names), results(ours, names)
    for name in names:
        x = found[name]
        dense = np.zeros(8)
        for blade, value in zip(x.blades, x.values, strict=True):
            dense[["1", "e1", "e2", "e3", "e12", "e13", "e23", "e123"].index(str(blade))] = value
        assert dense == pytest.approx(expected[name].value, abs=1e-12), name  # that is how far `clifford` is off


def test_the_readme_of_kingdon():
    theirs, ours = KINGDON
    assert changed_lines(theirs, ours) <= 5
    names = ("product", "symbolic", "partly", "met", "moved")
    expected, found = results(theirs, names), results(ours, names)
    for name in names:
        wanted = {
            f"e{key[1:]}" if key != "e" else "1": sympy.sympify(value) for key, value in of_kingdon(expected[name])
        }
        x = found[name]
        got = x.expressions if hasattr(x, "expressions") else dict(zip(map(str, x.blades), x.values, strict=True))
        got = {blade: renamed(value) for blade, value in got.items()}
        for blade in wanted.keys() | got.keys():
            assert sympy.simplify(wanted.get(blade, 0) - got.get(blade, 0)) == 0, (name, blade)


def of_kingdon(x: Any) -> list[tuple[str, Any]]:
    return [(x.algebra.bin2canon[key], value) for key, value in zip(x.keys(), x.values(), strict=True)]


def renamed(value: Any) -> Any:
    """An expression with the names that kingdon gives: ``B12`` for ``B_e12``."""
    expression = sympy.sympify(value)
    return expression.subs({s: sympy.Symbol(s.name.replace("_e", "")) for s in expression.free_symbols})
