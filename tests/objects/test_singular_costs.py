"""Costs of singular and extreme pairs; shapes and bad input."""

from __future__ import annotations

import numpy as np
import pytest

from bladesmith import cga3d as cga
from bladesmith import errors
from bladesmith.codegen.formulas.objects.costs import pair_cost
from bladesmith.codegen.rings.protocol import PrecisionRing
from bladesmith.objects.rotors.between import rotor_between
from bladesmith.objects.rotors.costs import cost_matrix, rotor_cost
from bladesmith.objects.rotors.pairwise import nearest, pair_values

from ..support.formulas import precise, stock
from ..support.objects.costs import INVALID, KINDS, NOT_UNIQUE, flipped, objects


@pytest.mark.parametrize("kind", KINDS)
def test_opposite_objects_have_the_cost_of_the_documented_choice(kind: str) -> None:
    x = objects(kind, 6, 14)
    cost, status = cost_matrix(x, flipped(x), status=True)
    assert (np.diag(status) == NOT_UNIQUE).all() and np.isfinite(cost).all()
    there, back = rotor_between(x, flipped(x)), rotor_between(flipped(x), x)
    np.testing.assert_allclose(np.diag(cost), np.minimum(rotor_cost(there), rotor_cost(back)), rtol=1e-12)
    np.testing.assert_allclose(np.diag(cost), np.diag(cost_matrix(flipped(x), x)), rtol=1e-12)


@pytest.mark.parametrize("short", [1e-1, 1e-3, 1e-6, 1e-9, 1e-12])
def test_nearly_opposite_lines(short: float) -> None:
    angle = np.pi - short
    x = cga.line([0, 0, 0], [1, 0, 0])
    y = cga.line([0, 0, 0], [-np.cos(short), np.sin(short), 0])
    assert abs(cost_matrix(x, y) - (2 - 2 * np.cos(angle / 2))) < 1e-8
    assert cost_matrix(x, y, align=True) == pytest.approx(4 * np.sin(short / 4) ** 2, rel=1e-12)


def test_touching_spheres_and_a_circle_with_its_own_axis() -> None:
    spheres = cga.sphere([[0, 0, 0], [2, 0, 0]], 1.0)
    cost, status = cost_matrix(spheres, spheres, status=True)
    assert np.isfinite(cost).all() and status[0, 1] == status[1, 0] == NOT_UNIQUE and cost[0, 1] == cost[1, 0]
    circle, axis = cga.circle([0, 0, 0], [0, 0, 1], 1.0), cga.line([0, 0, 0], [0, 0, 1])
    for align in (False, True):
        cost, status = cost_matrix([circle, axis], [circle, axis], align=align, status=True)
        assert np.isfinite(cost).all() and status.tolist() == [[0, NOT_UNIQUE], [NOT_UNIQUE, 0]]
        assert cost[0, 1] == pytest.approx(cost[1, 0]) and cost[0, 1] > 0.5


def test_where_the_choices_of_both_directions_differ_the_cheaper_one_counts() -> None:
    """Lines, and circles that touch them and run the other way."""
    r = np.random.default_rng(4)
    foot, along, side = r.normal(size=(3, 20, 3))
    side = np.cross(along, side)
    side /= np.linalg.norm(side, axis=1)[:, None]
    radius = 10.0 ** r.uniform(0.5, 2, 20)
    lines = cga.line(foot, along)
    circles = cga.circle(foot + radius[:, None] * side, np.cross(side, along), radius)
    there, back = rotor_cost(rotor_between(lines, circles)), rotor_cost(rotor_between(circles, lines))
    assert (np.abs(there - back) > 0.1).any()
    for x, y in ((lines, circles), (circles, lines)):
        cost, status = cost_matrix(x, y, status=True)
        assert (np.diag(status) == NOT_UNIQUE).all()
        np.testing.assert_allclose(np.diag(cost), np.minimum(there, back), rtol=1e-9)


@pytest.mark.parametrize("far", [1e3, 1e6])
def test_far_rounds_are_done_carefully(far: float) -> None:
    r = np.random.default_rng(2)
    x = cga.circle(far + r.normal(size=(4, 3)), r.normal(size=(4, 3)), 1.0)
    cost, status = cost_matrix(x, x, status=True)
    assert not status.any() and (np.diag(cost) < 1e-15).all()
    ring, kind = PrecisionRing(120), stock("cga3d").kind("circle")
    exact = [precise(kind, row, ring) for row in x.values]
    for i in range(3):
        expected = float(pair_cost(exact[i], exact[i + 1]).scalar())
        # the coefficients themselves are rounded: eps c^2/r in the n_inf part
        assert cost[i, i + 1] == pytest.approx(expected, rel=1e-8 if far < 1e4 else 1e-2)


def test_invalid_objects_are_named_and_the_others_are_not_touched() -> None:
    good = objects("circle", 5, 15)
    data = good.values.copy()
    data[2, 0] = np.nan
    data[4] *= 1.5
    bad = cga.multivector(data, grades=[3])
    cost, status = cost_matrix(bad, good, status=True)
    expected = cost_matrix(good, good)
    np.testing.assert_array_equal(cost[[0, 1, 3]], expected[[0, 1, 3]])
    assert np.isnan(cost[[2, 4]]).all() and (status[[2, 4]] == INVALID).all() and not status[[0, 1, 3]].any()
    assert np.isnan(cost_matrix(good, bad)[:, [2, 4]]).all()


def test_shapes() -> None:
    x, y = objects("line", 6), objects("line", 4)
    whole = cost_matrix(x, y)
    np.testing.assert_array_equal(cost_matrix(x.reshape(2, 3), y), whole.reshape(2, 3, 4))
    np.testing.assert_array_equal(cost_matrix(x[1], y[2]), whole[1, 2])
    none = cga.line(np.empty((0, 3)), np.empty((0, 3)))
    assert cost_matrix(none, y).shape == (0, 4) and cost_matrix(x, none).shape == (6, 0)
    cost, status = cost_matrix(none, none, status=True)
    assert cost.shape == status.shape == (0, 0)


def test_what_is_refused() -> None:
    line, plane = objects("line", 2), objects("plane", 2)
    with pytest.raises(errors.GradeError, match="grade 3 and a plane grade 4"):
        cost_matrix(line, plane)
    with pytest.raises(errors.InputError, match="did you mean 'thesis'"):
        cost_matrix(line, line, cost="thesys")
    for kind in (["thesis"], None, np.zeros(2)):
        with pytest.raises(errors.InputError, match="one of positive, thesis"):
            cost_matrix(line, line, cost=kind)
        with pytest.raises(errors.InputError, match="one of positive, thesis"):
            rotor_cost(cga.rotor((0, 0, 1), 1.0), cost=kind)
    for name in ("align", "status"):
        with pytest.raises(errors.InputError, match=f"{name} is array.*; True or False is needed"):
            cost_matrix(line, line, **{name: np.zeros(2)})
    with pytest.raises(errors.InputError, match="a whole number from 1"):
        cost_matrix(line, line, threads=0)
    with pytest.raises(errors.InputError, match=r"array\("):
        cost_matrix(line, np.ones((2, 6)))
    with pytest.raises(errors.GradeError, match="even grades"):
        rotor_cost(line)
    with pytest.raises(errors.InputError, match="conformal"):
        rotor_cost(1.0)


def test_nearest_is_the_least_of_each_row() -> None:
    x, y = objects("circle", 50, 16), objects("circle", 9, 17)
    values = pair_values("costs.pair_cost", x, y)
    index, least = nearest("costs.pair_cost", x, y)
    np.testing.assert_array_equal(index, values.argmin(1))
    np.testing.assert_array_equal(least, values.min(1))
