"""Functions of multivectors for formulas: the values of the runtime's methods, and what they refuse."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

import bladesmith as bs
from bladesmith import cga3d as cga
from bladesmith import codegen, objects, pga3d
from bladesmith.codegen.formulas import ga

CASES: dict[str, tuple[Any, Any, tuple[Any, ...], Any]] = {
    "exp": (ga.exp, (pga3d.kind("twist"),), (pga3d.random("twist", 5, 1),), lambda b: b.exp()),
    "exp of all bivectors": (ga.exp, (cga.kind("bivector"),), (cga.random("bivector", 5, 1),), lambda b: b.exp()),
    "log": (ga.log, (cga.kind("motor"),), (cga.random("motor", 5, 1),), lambda r: r.log()),
    "sqrt": (ga.sqrt, (pga3d.kind("motor"),), (pga3d.random("motor", 5, 1),), lambda r: r.sqrt()),
    "inverse": (ga.inverse, (pga3d.kind("multivector"),), (pga3d.random(n=5, seed=1),), lambda x: x.inverse()),
    "versor_inverse": (ga.versor_inverse, (cga.kind("circle"),), (cga.random("circle", 5, 1),), lambda x: x.inverse()),
    "norm": (ga.norm, (cga.kind("multivector"),), (cga.random(n=5, seed=1),), lambda x: cga.scalar(x.norm())),
    "normalize": (ga.normalize, (cga.layout("circle"),), (3 * cga.random("circle", 5, 1),), lambda x: x.normalized()),
    "nearest": (ga.nearest, (cga.layout("motor"),), (2 * cga.random("motor", 5, 1),), lambda x: x.normalized()),
    "rotor_between": (
        ga.rotor_between, (cga.kind("circle"),) * 2, (cga.random("circle", 5, 1), cga.random("circle", 5, 2)),
        lambda x, y: objects.rotor_between(x, y),
    ),
    "reflect": (
        ga.reflect, (cga.kind("point"), cga.kind("plane")), (cga.random("point", 5, 1), cga.random("plane", 5, 2)),
        lambda x, mirror: x.reflect(mirror),
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", CASES)
def test_values_are_those_of_the_methods(name: str) -> None:
    function, kinds, operands, method = CASES[name]
    algebra = operands[0].algebra

    if len(kinds) == 1:
        formula: Any = lambda x: function(x)  # noqa: E731
    else:
        formula = lambda x, y: function(x, y)  # noqa: E731
    kernel = codegen.kernel(*kinds, name="formula", algebra=algebra)(formula)
    found = kernel.reference(*operands)  # not compiled: the text is that of formulas which are tested by themselves
    assert found.isclose(method(*operands), rtol=1e-9, atol=1e-9).all()


def test_objects_between_two_and_signs() -> None:
    @codegen.kernel(cga.kind("circle"), cga.kind("circle"), codegen.scalar)
    def middle(x: Any, y: Any, t: Any) -> Any:
        return ga.interpolate(x, y, t), ga.project(x + y)

    x, y = cga.random("circle", 4, 1), cga.random("circle", 4, 2)
    between, projected = middle.reference(x, y, 0.5)
    assert between.isclose(objects.interpolate(x, y, alpha=0.5), rtol=1e-9).all()
    assert projected.isclose(between, rtol=1e-9).all()

    @codegen.kernel(pga3d.kind("motor"))
    def upright(r: Any) -> Any:
        return ga.canonicalize_sign(-r)

    R = pga3d.random("motor", 20, 3)
    assert (upright.reference(R)["1"] >= 0).all()


def test_scalars_are_the_functions_of_numbers() -> None:
    @codegen.kernel(codegen.scalar, algebra=cga)
    def chain(t: Any) -> Any:
        return ga.log(ga.exp(t) * ga.sqrt(t * t + 1) * ga.inverse(t * t + 1))

    assert abs(float(chain.reference(0.3)[0]) - (0.3 - 0.5 * 0.08617769624105241)) < 1e-15


def test_what_formulas_may_not_ask_for() -> None:
    def trace(formula: Any, kind: Any) -> None:
        assert codegen.kernel(kind, name="formula")(formula).traced

    with pytest.raises(bs.errors.GradeError, match=r"exp is that of scalars.*codegen\.ga\.exp"):
        trace(lambda b: codegen.exp(b), cga.kind("bivector"))
    for value in (cga.e12, 0.5, "a"):
        with pytest.raises(bs.errors.TraceError, match=r"codegen\.exp is a function of values in formulas; this is a "):
            codegen.exp(value)
    with pytest.raises(bs.errors.GradeError, match=r"sin is that of scalars.*grade\(0\)"):
        trace(lambda b: codegen.sin(b), cga.kind("bivector"))
    with pytest.raises(bs.errors.GradeError, match="grades"):
        trace(lambda b: ga.exp(1 + b), cga.kind("bivector"))
    with pytest.raises(bs.errors.GradeError):
        trace(lambda b: ga.exp(b), bs.algebra(7).kind("bivector"))


def test_the_table_in_the_docs_has_all() -> None:
    text = (Path(__file__).parents[3] / "docs" / "algebra" / "kernels.md").read_text()
    assert all(f"`ga.{name}(" in text for name in ga.FUNCTIONS)


@pytest.mark.parametrize("name", ["rotor_between", "interpolate"])
def test_what_is_conformal_is_refused_elsewhere(name: str) -> None:
    plane = bs.pga3d.kind("plane")
    weights = [codegen.scalar] if name == "interpolate" else []
    kernel = codegen.kernel(plane, plane, *weights, name=name)(getattr(ga, name))
    with pytest.raises(bs.errors.GradeError, match="conformal"):
        kernel.traced  # noqa: B018


def test_functions_of_formulas_say_that_they_are() -> None:
    for wrong in (cga.e12, 3):
        with pytest.raises(bs.errors.TraceError, match="for multivectors of formulas"):
            ga.exp(wrong)  # type: ignore[arg-type]
        with pytest.raises(bs.errors.TraceError, match="for multivectors of formulas"):
            ga.rotor_between(wrong, wrong)  # type: ignore[arg-type]


def test_projections_are_of_one_grade() -> None:
    kernel = codegen.kernel(cga.kind("motor"), name="mixed")(ga.project)
    with pytest.raises(bs.errors.GradeError, match="of one grade"):
        kernel.reference(cga.random("motor", 1, 1))
