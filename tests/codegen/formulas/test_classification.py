"""Invariants that tell objects apart."""

import numpy as np
import pytest

from bladesmith.codegen.formulas.objects import blades, classification, conformal

from ...support.formulas import EPS, Array, Traced, members
from ...support.objects.coordinates import CGA, COUNT, N, V, positive, vectors, widened


def test_invariants_tell_objects_apart() -> None:
    """Squares, blade test and flatness at the scale of their own rounding, a million units from the origin too."""
    r, n = positive(30), vectors(31)
    for scale in (1.0, 1e6):
        c = vectors(32, scale=scale)
        circle = Traced(CGA, conformal.circle, V, V, N)(c, n, r)
        line = widened("line", Traced(CGA, conformal.line, V, V)(c, n), "trivector")
        general = members(CGA.kind("trivector"), COUNT, 33)
        square, noise, others, other_noise, _, is_flat, _, _ = read("trivector", circle)
        assert np.all(square > 8 * EPS * noise) and np.all(others <= 64 * EPS * other_noise)
        assert np.all(is_flat == 0)
        square, noise, others, other_noise, _, is_flat, inner, size = read("trivector", line)
        assert np.allclose(square, 1) and np.all(others <= 64 * EPS * other_noise)
        assert np.all(is_flat == 1) and np.all(inner > EPS * size)
        _, _, others, other_noise, *_ = read("trivector", general)
        assert np.all(others > 1e6 * EPS * other_noise)
    sphere = Traced(CGA, conformal.sphere, V, N)(c, r)
    square, noise, *_ = read("quadvector", -sphere)
    assert np.all(square < 0)
    point = Traced(CGA, conformal.point, V)(vectors(34))
    square, noise, *_ = read("vector", point)
    assert np.all(np.abs(square) <= 8 * EPS * noise)


def read(grade: str, values: Array) -> Array:
    return np.moveaxis(Traced(CGA, classification.invariants, f"~{grade}")(values), -1, 0)


@pytest.mark.parametrize("kind", ["point_pair", "line", "circle", "plane", "sphere"])
def test_the_projector_returns_every_kind(kind: str) -> None:
    project = Traced(CGA, blades.project_to_blade, f"~{kind}")
    assert project.returns == CGA.kind(kind)
    x = members(CGA.kind(kind), 50, 35)
    assert np.allclose(project(3 * x), x, atol=1e-10 * np.max(np.abs(x)))
