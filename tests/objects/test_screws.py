"""Screws and closest points against homogeneous matrices, plain vector geometry and least squares at 50 digits."""

from __future__ import annotations

from typing import Any

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import least_squares

import bladesmith as bs
from bladesmith import cga3d as cga
from bladesmith import objects
from bladesmith import pga3d as pga
from bladesmith.core.kind_constraints import satisfies_constraints
from bladesmith.objects import screws

from ..support.vectors import rotation_matrix, unit

RNG = np.random.default_rng(11)
N = 200
P1, P2, M1, M2 = (RNG.normal(size=(N, 3)) for _ in range(4))
OK, SINGULAR, NOT_UNIQUE, INVALID = bs.Status.OK, bs.Status.SINGULAR, bs.Status.NOT_UNIQUE, bs.Status.INVALID


def twist(m: Any, t: Any, algebra: Any = cga) -> Any:
    """m I3 + t n from plain vectors, blade by blade."""
    m, t = np.asarray(m, float), np.asarray(t, float)
    n = "ni" if algebra is cga else "0"
    parts = {"e23": m[..., 0], "e31": m[..., 1], "e12": m[..., 2]}
    parts |= {(f"e{i + 1}ni" if n == "ni" else f"e{i + 1}0"): t[..., i] for i in range(3)}
    return algebra.multivector(parts)


def turned(points: Any, foot: Any, axis: Any, angle: Any, advance: Any) -> Any:
    """Points moved by a screw, by Rodrigues' formula."""
    matrix = rotation_matrix(axis, angle)
    return foot + np.einsum("...ij,...j->...i", matrix, points - foot) + np.asarray(advance)[..., None] * axis


@pytest.mark.parametrize("algebra", [cga, pga])
def test_screw_parts_are_those_it_was_built_from(algebra: Any) -> None:
    axis, pitch, size = unit(M1), RNG.normal(size=N), np.exp(RNG.normal(size=N) * 3)
    s = twist(size[:, None] * axis, size[:, None] * (np.cross(P1, axis) + pitch[:, None] * axis), algebra)
    found = objects.screw(s)
    assert (found.status == OK).all() and found.axis.kind == algebra.kind("line")
    assert np.allclose(found.pitch, pitch, rtol=1e-12, atol=1e-13) and np.allclose(found.magnitude, size, rtol=1e-14)
    assert found.axis.isclose(algebra.line(P1, axis), rtol=1e-13).all()
    again = screws.screw_bivector(found.axis, found.pitch, found.magnitude)
    assert again.isclose(s, rtol=1e-13).all()


@pytest.mark.parametrize("algebra", [cga, pga])
def test_screw_motor_moves_points_along_the_screw(algebra: Any) -> None:
    angle, pitch = RNG.uniform(-7, 7, N), RNG.normal(size=N)
    line = algebra.line(P1, M1)
    motor = screws.screw_motor(line, angle, pitch)
    assert motor.kind == algebra.kind("motor")
    matrix = motor.to_matrix()
    moved = np.einsum("nij,nj->ni", matrix[:, :3, :3], P2) + matrix[:, :3, 3]
    assert np.allclose(moved, turned(P2, P1, unit(M1), angle, pitch * angle), atol=1e-12)
    by_exp = (-angle / 2 * screws.screw_bivector(line, pitch)).exp()
    assert by_exp.isclose(motor, rtol=1e-13).all()


@pytest.mark.parametrize("algebra", [cga, pga])
def test_sum_of_lines_is_a_screw_about_a_line_between_them(algebra: Any) -> None:
    alpha = RNG.uniform(-1, 2, N)
    l1, l2 = algebra.line(P1, M1), algebra.line(P2, M2)
    found, fraction = screws.screw_of_lines(l1, l2, alpha)
    d1, d2 = (x.dual() if algebra is cga else x for x in (l1, l2))
    direct = objects.screw(alpha * d1 + (1 - alpha) * d2)
    assert direct.axis.isclose(found.axis, rtol=1e-12).all() and np.allclose(direct.pitch, found.pitch, rtol=1e-10)
    # by vectors: the feet of the common perpendicular, and the wrench of two unit turns about the lines
    m1, m2 = unit(M1), unit(M2)
    n = np.cross(m1, m2)
    gap = P2 - P1
    s1 = (np.cross(gap, m2) * n).sum(-1) / (n * n).sum(-1)
    s2 = (np.cross(gap, m1) * n).sum(-1) / (n * n).sum(-1)
    foot1, foot2 = P1 + s1[:, None] * m1, P2 + s2[:, None] * m2
    c, a, b = (m1 * m2).sum(-1), alpha, 1 - alpha
    expected = (b * b + a * b * c) / (a * a + b * b + 2 * a * b * c)
    assert np.allclose(fraction, expected, rtol=1e-9, atol=1e-12)
    at = foot1 + expected[:, None] * (foot2 - foot1)
    m = a[:, None] * m1 + b[:, None] * m2
    assert found.axis.isclose(algebra.line(at, m), rtol=1e-9, atol=1e-9).all()
    moment = a[:, None] * np.cross(foot1 - at, m1) + b[:, None] * np.cross(foot2 - at, m2)
    assert np.allclose(found.pitch, (moment * m).sum(-1) / (m * m).sum(-1), rtol=1e-7, atol=1e-9)
    assert np.allclose(np.cross(moment, unit(m)), 0, atol=1e-9 * np.abs(moment).max())  # nothing but pitch is left


def test_sums_of_lines_are_taken_directly_too() -> None:
    l1, l2 = cga.line(P1, M1), cga.line(P2, M2)
    a, b = objects.screw(l1 + l2), objects.screw(l1.dual() + l2.dual())
    assert a.axis.isclose(b.axis).all() and np.array_equal(a.pitch, b.pitch)


def test_lines_far_away() -> None:
    far = np.array([1e6, -2e6, 5e5])
    near, fraction = screws.screw_of_lines(cga.line(P1, M1), cga.line(P2, M2), 0.3)
    found, other = screws.screw_of_lines(cga.line(P1 + far, M1), cga.line(P2 + far, M2), 0.3)
    assert np.allclose(fraction, other, rtol=1e-12, atol=1e-12)
    size = 1 + np.abs(near.pitch)
    assert np.all(np.abs(found.pitch - near.pitch) <= 3e-8 * size)  # 1e-9 of the lines' own rounding, over |m|^2
    moved = cga.translator(far) >> near.axis
    assert moved.isclose(found.axis, rtol=1e-11).all()


def test_translations_and_zero() -> None:
    line = cga.line(P1, M1)
    parallel = cga.line(P1 + np.cross(M1, M2), M1)
    found, fraction = screws.screw_of_lines(line, -parallel)
    assert (found.status == NOT_UNIQUE).all() and np.isinf(found.pitch).all() and np.isnan(fraction).all()
    gap = np.cross(M1, M2) - 0.0
    assert np.allclose(found.magnitude, np.linalg.norm(np.cross(gap, unit(M1)), axis=-1) / 2, rtol=1e-9)
    assert found.axis.isclose(cga.line(np.zeros(3), np.cross(unit(M1), gap)), atol=1e-9).all()
    t = twist(np.zeros((3, 3)), [[0.0, 0.0, 3.0], [1e-200, 0.0, 0.0], [0.0, 0.0, 0.0]])
    moved = objects.screw(t)
    assert list(moved.status) == [NOT_UNIQUE, NOT_UNIQUE, SINGULAR]
    assert np.allclose(moved.magnitude, [3, 1e-200, np.nan], equal_nan=True, rtol=1e-14)
    assert np.isnan(moved.axis.values[2]).all() and np.isnan(moved.pitch[2])
    assert screws.screw_bivector(moved.axis[0], moved.pitch[0], moved.magnitude[0]).isclose(t[0])
    with pytest.raises(bs.errors.SingularError, match="item 2"):
        objects.screw(t, strict=True)


@given(st.floats(-150, 150), st.floats(-12, 12), st.floats(-8, 8))
def test_screw_at_every_scale(scale: float, ratio: float, far: float) -> None:
    """The scale of the bivector, the size of the pitch against one, the distance of the axis."""
    axis, p = unit(np.array([1.0, -2.0, 0.5])), np.array([0.3, 0.7, -1.0]) * 10**far
    pitch, size = 10.0**ratio, 10.0**scale
    found = objects.screw(twist(size * axis, size * (np.cross(p, axis) + pitch * axis)))
    spread = 1 + pitch + 10**far
    assert np.isclose(found.magnitude, size, rtol=1e-14)
    assert abs(found.pitch - pitch) <= 1e-14 * spread
    line = cga.line(p, axis)
    assert np.abs(found.axis.values - line.values).max() <= 1e-14 * spread
    assert satisfies_constraints(cga.kind("line"), found.axis.values)


def test_bad_twists() -> None:
    bad = objects.screw(twist([[np.nan, 0, 0], [1.0, 0, 0]], np.ones((2, 3))))
    assert list(bad.status) == [INVALID, OK] and np.isnan(bad.axis.values[0]).all() and np.isnan(bad.magnitude[0])
    with pytest.raises(bs.errors.KindError):
        objects.screw(cga.point_pair([0.0, 0, 0], [1.0, 0, 0]))
    with pytest.raises(bs.errors.GradeError):
        objects.screw(cga.plane([0.0, 0, 1], 0.0))
    with pytest.raises(bs.errors.GradeError):
        objects.screw(bs.algebra(3).e12)
    with pytest.raises(bs.errors.InputError):
        objects.screw(np.ones(6))  # type: ignore[arg-type]
    with pytest.raises(bs.errors.GradeError):
        screws.screw_motor(cga.circle([0.0, 0, 0], [0.0, 0, 1], 1.0), 1.0)
    assert objects.screw(twist(np.zeros((0, 3)), np.zeros((0, 3)))).axis.shape == (0,)


# -- closest points ----------------------------------------------------------------------------------------


def precise_midpoint(l1: Any, l2: Any) -> list[Any]:
    """Least squares for the two lines that these very coefficients stand for, at 50 digits."""
    mp = mpmath.mp.clone()
    mp.dps = 50
    matrix, right = mp.zeros(3), mp.zeros(3, 1)
    for line in (l1, l2):
        dual = line.dual()
        m = [mp.mpf(float(dual[b])) for b in ("e23", "e31", "e12")]
        t = [mp.mpf(float(dual[b])) for b in ("e1ni", "e2ni", "e3ni")]
        size = mp.sqrt(sum(v * v for v in m))
        m, t = [v / size for v in m], [v / size for v in t]
        p = [m[1] * t[2] - m[2] * t[1], m[2] * t[0] - m[0] * t[2], m[0] * t[1] - m[1] * t[0]]
        for i in range(3):
            for j in range(3):
                q = (1 if i == j else 0) - m[i] * m[j]
                matrix[i, j] += q
                right[i] += q * p[j]
    return list(mp.lu_solve(matrix, right))


@pytest.mark.parametrize("angle", [1.0, 1e-3, 1e-6, 1e-9])
@pytest.mark.parametrize("gap", [0.0, 0.5])
def test_closest_point_of_nearly_parallel_lines(angle: float, gap: float) -> None:
    """Lines that meet lose nothing; of skew ones, rounding of the coefficients alone means 1e-16 gap/angle."""
    for i in range(12):
        m = unit(M1[i])
        other = m + angle * unit(np.cross(m, M2[i]))
        l1 = cga.line(P1[i], m)
        l2 = cga.line(P1[i] + gap * unit(np.cross(m, other)), other * (-1) ** i)
        found = objects.closest_point(l1, l2)
        assert found.status == OK and found.kind == cga.kind("point")
        exact = [float(v) for v in precise_midpoint(l1, l2)]
        assert np.abs(found.parameters().xyz - exact).max() <= 4e-15 + 2e-16 * gap / angle


def test_closest_point_is_the_midpoint_of_the_common_perpendicular() -> None:
    n = np.cross(M1, M2)
    a, b = P1, P1 + n + 0.7 * M1
    l1, l2 = cga.line(a - 2 * M1, M1), cga.line(b + 3 * M2, M2)
    found = objects.closest_point(l1, l2)
    assert (found.status == OK).all()
    expected = P1 + 0.7 * M1 + n / 2
    assert np.allclose(found.parameters().xyz, expected, rtol=1e-9, atol=1e-9)
    assert np.allclose(objects.closest_point(l2, -l1).parameters().xyz, expected, rtol=1e-9, atol=1e-9)
    sets = objects.closest_point(cga.multivector(np.stack([l1.values, l2.values]), blades=l1.blades))
    assert sets.shape == (N,) and np.allclose(sets.parameters().xyz, expected, rtol=1e-9, atol=1e-9)
    far = np.array([1e6, 2e6, -1e6])
    moved = objects.closest_point(cga.line(a + far, M1), cga.line(b + far, M2)).parameters().xyz - far
    assert np.abs(moved - expected).max(-1).max() <= 1e-9 * 2e6 and np.median(np.abs(moved - expected)) <= 1e-8


def test_parallel_lines_have_a_line_of_closest_points() -> None:
    l1, l2 = cga.line([0.0, 0, 5], [1.0, 0, 0]), cga.line([3.0, 4.0, 1.0], [-2.0, 0, 0])
    found = objects.closest_point(l1, l2)
    assert found.status == NOT_UNIQUE and np.allclose(found.parameters().xyz, [0, 2, 3])
    same = objects.closest_point(l1, l1)
    assert same.status == NOT_UNIQUE and np.allclose(same.parameters().xyz, [0, 0, 5])
    several = objects.closest_point([l1, l2])
    assert several.status == NOT_UNIQUE and np.allclose(several.parameters().xyz[1:], [2, 3])


def test_closest_point_of_many_objects_against_an_optimiser() -> None:
    lines, planes, points = cga.line(P1[:7], M1[:7]), cga.plane(M2[:4], P2[:4, 0]), cga.point(P2[:3])
    weights = RNG.uniform(0.2, 3, 14)
    found = objects.closest_point([lines, planes, points], weights=weights)

    def distances(x: Any) -> Any:
        across = np.cross(x - P1[:7], unit(M1[:7]))
        size = np.linalg.norm(M2[:4], axis=-1)
        heights = (M2[:4] @ x - P2[:4, 0]) / size
        own = [across * np.sqrt(weights[:7, None]), heights * np.sqrt(weights[7:11])]
        return np.concatenate([*(v.ravel() for v in own), ((x - P2[:3]) * np.sqrt(weights[11:, None])).ravel()])

    best = least_squares(distances, np.zeros(3), xtol=1e-15, ftol=1e-15, gtol=1e-15)
    assert found.status == OK and np.allclose(found.parameters().xyz, best.x, atol=1e-7)
    assert np.abs(best.jac.T @ distances(found.parameters().xyz)).max() <= 1e-6


def test_sets_along_an_axis_with_weights() -> None:
    lines = cga.line(P1.reshape(10, 20, 3), M1.reshape(10, 20, 3))
    w = RNG.uniform(0.5, 2, (10, 20))
    rows = objects.closest_point(lines, weights=w, axis=1)
    assert rows.shape == (10,) and (rows.status == OK).all()
    one = objects.closest_point(lines[3], weights=w[3])
    assert one.isclose(rows[3], rtol=1e-12)
    equal = objects.closest_point(lines, weights=np.full(20, 7.0), axis=-1)
    assert equal.isclose(objects.closest_point(lines, axis=1), rtol=1e-11).all()
    doubled = [lines[3][i] for i in range(20)] + [lines[3][0]]
    first = np.ones(20)
    first[0] = 2
    assert objects.closest_point(doubled).isclose(objects.closest_point(lines[3], weights=first), rtol=1e-12)


def test_many_nearly_parallel_lines() -> None:
    """At an angle of 1e-6 the normal matrix would have lost every digit along the lines."""
    directions = np.array([0.0, 0, 1]) + 1e-6 * np.concatenate([M1[:20, :2], np.zeros((20, 1))], -1)
    target = np.array([0.3, -0.2, 0.6])
    found = objects.closest_point(cga.line(target + 2 * directions, directions))
    assert found.status == OK and np.allclose(found.parameters().xyz, target, atol=1e-8)


def test_bad_sets() -> None:
    lines = cga.line(P1[:3], M1[:3])
    broken = np.array(lines.values)
    broken[1] = np.nan
    bad = cga.multivector(broken, blades=lines.blades)
    assert objects.closest_point(bad).status == INVALID
    assert objects.closest_point(bad, cga.line(P2[:3], M2[:3])).status[1] == INVALID
    assert objects.closest_point(lines, weights=[1.0, -1.0, 1.0]).status == INVALID
    assert objects.closest_point(lines, weights=[0.0, 0.0, 0.0]).status == INVALID
    with pytest.raises(bs.errors.SingularError):
        objects.closest_point(lines, weights=[0.0, 0.0, 0.0], strict=True)
    with pytest.raises(bs.errors.ShapeError):
        objects.closest_point(lines, weights=[1.0, 2.0])
    with pytest.raises(bs.errors.InputError):
        objects.closest_point([])
    with pytest.raises(bs.errors.InputError):
        objects.closest_point(cga.line(np.zeros((0, 3)), np.zeros((0, 3))))
    with pytest.raises(bs.errors.ShapeError):
        objects.closest_point(lines, axis=1)
    with pytest.raises(bs.errors.GradeError):
        objects.closest_point(cga.sphere(P1[:3], 1.0))
    with pytest.raises(bs.errors.GradeError):
        objects.closest_point(cga.circle(P1[:3], M1[:3], 1.0), lines)
    with pytest.raises(bs.errors.InputError):
        objects.closest_point(lines, lines, weights=[1.0, 1.0, 1.0])
    single = objects.closest_point(lines, lines).status
    assert (single == NOT_UNIQUE).all()


@pytest.mark.slow
def test_single_precision() -> None:
    l1, l2 = (cga.line(p.astype(np.float32), m.astype(np.float32)) for p, m in ((P1, M1), (P2, M2)))
    exact = objects.closest_point(l1.astype(np.float64), l2.astype(np.float64)).parameters().xyz
    found = objects.closest_point(l1, l2)
    crossing = np.linalg.norm(np.cross(unit(M1), unit(M2)), axis=-1)
    assert found.dtype == np.float32
    assert np.all(np.abs(found.parameters().xyz - exact).max(-1) <= 1e-5 * (1 + np.abs(exact).max(-1)) / crossing)
    found, _ = screws.screw_of_lines(l1, l2)
    assert found.axis.dtype == np.float32 and found.pitch.dtype == np.float32
    assert objects.closest_point(l1.reshape(20, 10)).dtype == np.float32
