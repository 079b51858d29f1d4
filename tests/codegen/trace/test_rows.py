"""Names of the numbers in rows: in generated text, and never in what is compiled."""

from __future__ import annotations

import re
from typing import Annotated, NamedTuple

import numpy as np

from bladesmith import cga3d as cga
from bladesmith import codegen
from bladesmith.codegen.algebra.multivector import Multivector
from bladesmith.codegen.trace.derivatives import tangent_formula
from bladesmith.codegen.trace.rows import BladesOf

Point = Annotated[tuple[Multivector, ...], BladesOf("vector")]


class Spring(NamedTuple):
    stiffness: Multivector
    length_of_the_spring_at_rest: Multivector


class Wrong(NamedTuple):
    only: Multivector


def energy(x: Multivector, law: Spring) -> Multivector:
    return law.stiffness * (x - law.length_of_the_spring_at_rest) * (x - law.length_of_the_spring_at_rest) / 2


def plain(x: Multivector, law: tuple[Multivector, ...]) -> Multivector:
    return law[0] * (x - law[1]) * (x - law[1]) / 2


def first(points: Point) -> Multivector:
    return points[0]


def mismatched(law: Wrong) -> Multivector:
    return law[0] + law[1]


def kernel(formula, *kinds):
    return codegen.kernel(*kinds, algebra=cga)(formula)


def test_fields_of_a_named_tuple_name_the_numbers():
    made = kernel(energy, codegen.scalar, codegen.numbers(2))
    assert "law_stiffness = law_in[0]" in made.source("c")
    assert "law_length_of_the_spring_at_rest" in made.source("numba")
    assert made(3.0, np.array([2.0, 1.0])) == 4.0 == made.reference(3.0, np.array([2.0, 1.0]))


def test_names_change_neither_operations_nor_statements():
    texts = [kernel(f, codegen.scalar, codegen.numbers(2)).source("c") for f in (energy, plain)]
    numbered = texts[0].replace("law_stiffness", "law_0").replace("law_length_of_the_spring_at_rest", "law_1")
    assert numbered.replace("energy", "plain") == texts[1]


def test_blades_name_coefficients_of_one_multivector_or_several():
    one, two = (kernel(first, codegen.numbers(n)).source("c") for n in (5, 10))
    assert "points_e1 = points_in[0]" in one
    assert "points_0_e1 = points_in[0]" in two
    assert "points_0 = points_in[0]" in kernel(first, codegen.numbers(7)).source("c")  # of no vectors


def test_a_type_of_another_length_names_nothing():
    made = kernel(mismatched, codegen.numbers(2))
    assert re.search(r"law_0\b", made.source("c")) and made(np.array([1.0, 2.0])) == 3.0


def test_tangents_keep_names():
    formula = tangent_formula(energy, __name__, constant=["x"])
    text = kernel(formula, codegen.scalar, codegen.numbers(2), codegen.numbers(2)).source("c")
    assert "d_law_stiffness = d_law_in[0]" in text and "law_stiffness = law_in[0]" in text
