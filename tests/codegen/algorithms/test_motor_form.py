"""The motor of least form, against one that is known: the text with 50 digits, and C against the text."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest

from bladesmith import cga3d as cga
from bladesmith.codegen.algorithms.motor_form import FORM, MOTOR, least_pivot
from bladesmith.codegen.build import extension
from bladesmith.codegen.execute.items import CLoop, ItemFunction
from bladesmith.codegen.ir.loops import language
from bladesmith.codegen.programs.algorithms import algorithm_extension
from bladesmith.codegen.programs.registration import scene
from bladesmith.codegen.programs.registration.registration import KIND_SETS

LINES = cga.line(np.random.default_rng(3).normal(size=(4, 3)), np.random.default_rng(4).normal(size=(4, 3)))


def form_of_lines(target, numbers):
    """The form of motors that take lines to others, in any numbers."""
    kind = KIND_SETS["line"][0]
    total = language.zeros(FORM)
    for x, y in zip(LINES.values, target, strict=True):
        rows = [np.array([language.number(v) for v in row]) for row in (x, y)]
        total = total + kind.form(*rows, np.array([numbers(1)]))
    return total


def test_fifty_digits_find_the_motor() -> None:
    motor = (cga.translator((0.5, -1.0, 0.25)) * cga.rotor((1, 2, 3), 1.25)).as_kind("motor", check=False)
    target = (motor >> LINES).as_kind("line", check=False).values
    context = mpmath.mp.clone()
    context.dps = 50
    with language.number_type(context):
        form = form_of_lines(target, context.mpf)
    found, least = scene.form_motor.reference(form, numbers=context)
    sign = 1 if float(found[0]) * motor.values[0] > 0 else -1
    assert np.allclose(sign * found.astype(float), motor.values, rtol=0, atol=1e-12)
    assert 0 <= least < 1e-14 * sum(abs(c) for c in form)  # what keeps the translation along lines determined
    double, _ = scene.form_motor.reference(form.astype(float))
    assert np.allclose(double, found.astype(float), rtol=0, atol=1e-13) and found[0] != float(found[0])


@pytest.mark.skipif(extension.compiler() is None, reason="no C compiler")
def test_c_has_the_bits_of_the_text() -> None:
    roots = np.random.default_rng(5).normal(size=(20, MOTOR, MOTOR))
    squares = roots @ roots.transpose(0, 2, 1)
    forms = squares[:, *np.triu_indices(MOTOR)]
    for algorithm in (scene.form_motor, least_pivot):
        function = algorithm.specialised([p.type for p in algorithm.text.parameters])
        compiled = ItemFunction(function, CLoop(extension.load(algorithm_extension(function)), "f64"), np.float64)
        found = compiled(forms)
        for i, form in enumerate(forms):
            expected = algorithm.reference(form)
            if algorithm is least_pivot:
                assert found[i] == expected > 0
            else:
                assert np.allclose(found[0][i], expected[0], rtol=0, atol=1e-14) and found[1][i] == expected[1]
