"""Motions of CGA and PGA against homogeneous matrices."""

from typing import Any

import numpy as np
import pytest

from bladesmith.codegen.formulas.motions import motions
from bladesmith.codegen.formulas.objects import conformal, projective
from bladesmith.codegen.formulas.products import products
from bladesmith.codegen.status import Status

from ...support.formulas import EPS, Array, Traced, multivector, rows
from ...support.objects.coordinates import CGA, COUNT, SPATIAL, N, V, positive, vectors
from ...support.vectors import rotation_matrix, unit


def points_of(algebra: Any) -> tuple[Traced, Traced]:
    formulas = conformal if algebra is CGA else projective
    return Traced(algebra, formulas.point, V), Traced(algebra, formulas.point_parameters, "point")


@SPATIAL
def test_motions_move_points_as_matrices_do(algebra: Any) -> None:
    x, t, axis, p = vectors(21, count=4)
    angle = np.random.default_rng(22).uniform(-7, 7, COUNT)
    point, position = points_of(algebra)
    move = Traced(algebra, products.sandwich, "motor", "point")
    assert move.returns == algebra.kind("point")
    turn, status = Traced(algebra, motions.rotor_about, V, N, V).all(axis, angle, p)
    assert Traced(algebra, motions.rotor_about, V, N, V).returns == algebra.kind("motor")
    assert np.all(status == Status.OK)
    rotation = rotation_matrix(axis, angle)
    expected = p + (rotation @ (x - p)[..., None])[..., 0]
    assert np.allclose(position(move(turn, point(x))), expected, atol=1e-12)
    shift = multivector(algebra.kind("translator"), Traced(algebra, motions.translator, V)(t))
    shift = rows(algebra.kind("motor"), shift)
    both = Traced(algebra, products.geometric, "motor", "motor")(shift, turn)
    matrix = Traced(algebra, motions.motor_to_matrix, "motor")(both).reshape(-1, 4, 4)
    assert np.allclose(matrix[:, :3, :3], rotation, atol=1e-13)
    assert np.allclose(matrix[:, :3, 3], expected_translation(rotation, p) + t, atol=1e-12)
    assert np.array_equal(matrix[:, 3], np.broadcast_to([0, 0, 0, 1.0], (COUNT, 4)))
    rotor, translation = Traced(algebra, motions.motor_parts, "motor").all(both)
    assert np.allclose(translation, matrix[:, :3, 3], atol=1e-13)
    plain, _ = Traced(algebra, motions.rotor, V, N).all(axis, angle)
    assert np.allclose(rotor, plain, atol=1e-13)
    _, status = Traced(algebra, motions.rotor, V, N).all(0 * axis, angle)
    assert np.all(status == Status.INVALID)


def expected_translation(rotation: Array, p: Array) -> Array:
    return p - (rotation @ p[..., None])[..., 0]


@SPATIAL
def test_motor_from_matrix_at_every_angle(algebra: Any) -> None:
    """Random angles, tiny ones, half turns about the axes and near them."""
    axis, t = vectors(23, count=2)
    axis = unit(axis)
    axis[:6] = [[1, 0, 0], [0, 1, 0], [0, 0, 1], [0, 0.6, 0.8], [-1, 0, 0], [0, -0.6, 0.8]]
    angle = np.random.default_rng(24).uniform(-np.pi, np.pi, COUNT)
    angle[:6] = np.pi
    angle[6:40] = 10.0 ** np.linspace(-16, 0, 34)
    angle[40:70] = np.pi - 10.0 ** np.linspace(-16, -1, 30)
    rotation = rotation_matrix(axis, angle)
    columns = [rotation[..., i] for i in range(3)]
    motor, status = Traced(algebra, motions.motor_from_matrix, V, V, V, V).all(*columns, t)
    assert Traced(algebra, motions.motor_from_matrix, V, V, V, V).returns == algebra.kind("motor")
    assert np.all(status == Status.OK)
    back = Traced(algebra, motions.motor_to_matrix, "motor")(motor).reshape(-1, 4, 4)
    assert np.allclose(back[:, :3, :3], rotation, atol=8 * EPS)
    assert np.allclose(back[:, :3, 3], t, atol=8 * EPS)
    assert np.all(motor[:, 0] >= 0)
    expected, _ = Traced(algebra, motions.rotor, V, N).all(axis, angle)
    rotor, _ = Traced(algebra, motions.rotor_from_matrix, V, V, V).all(*columns)
    same = np.sign(np.sum(rotor * expected, 1, keepdims=True))
    assert np.allclose(rotor, same * expected, atol=4 * EPS)


def test_half_turns_have_a_fixed_sign() -> None:
    """<R>_0 = 0 exactly: the first coefficient that is not zero is positive."""
    for diagonal in ((1, -1, -1), (-1, 1, -1), (-1, -1, 1)):
        columns = np.diag(np.array(diagonal, float))[:, None]
        rotor, status = Traced(CGA, motions.rotor_from_matrix, V, V, V).all(*columns)
        assert np.all(status == Status.OK)
        assert np.array_equal(np.sort(rotor[0]), [0, 0, 0, 1])


@SPATIAL
def test_what_is_no_rotation_is_invalid(algebra: Any) -> None:
    from_matrix = Traced(algebra, motions.motor_from_matrix, V, V, V, V)
    for matrix in (2 * np.eye(3), np.diag([1.0, 1.0, -1.0]), np.eye(3) + np.eye(3, k=1) * 0.1, np.zeros((3, 3))):
        value, status = from_matrix.all(*(matrix[:, i][None] for i in range(3)), np.ones((1, 3)))
        assert np.all(status == Status.INVALID) and np.all(np.isnan(value).any(1))


def test_dilations_and_transversions() -> None:
    x, c, t = vectors(25, count=3)
    scale = positive(26)
    point = Traced(CGA, conformal.point, V)(x)
    scaling, status = Traced(CGA, conformal.homothety, N, V).all(scale, c)
    assert Traced(CGA, conformal.homothety, N, V).returns == CGA.kind("homothety")
    assert Traced(CGA, conformal.dilator, N).returns == CGA.kind("dilator")
    assert np.all(status == Status.OK)
    moved = Traced(CGA, products.sandwich, "homothety", "point")(scaling, point)
    found = Traced(CGA, conformal.point_parameters, "~point")(moved)
    assert np.allclose(found, c + scale[:, None] * (x - c), atol=1e-12)
    moved = Traced(CGA, products.sandwich, "transversor", "point")(Traced(CGA, conformal.transversor, V)(t), point)
    x2, t2, tx = np.sum(x * x, 1), np.sum(t * t, 1), np.sum(t * x, 1)
    expected = (x + x2[:, None] * t) / (1 + 2 * tx + t2 * x2)[:, None]
    found = Traced(CGA, conformal.point_parameters, "~point")(moved)
    assert np.allclose(found, expected, rtol=1e-9, atol=1e-9)
    value, status = Traced(CGA, conformal.dilator, N).all(-scale)
    assert np.all(status == Status.INVALID) and np.all(np.isnan(value))


@pytest.mark.parametrize("kind", ["line", "circle", "plane", "sphere"])
def test_motions_keep_kinds_and_parameters(kind: str) -> None:
    """An object moved is the object built from moved parameters."""
    c, n, axis, t = vectors(27, count=4)
    r, angle = positive(28), np.random.default_rng(29).uniform(-3, 3, COUNT)
    rotation = rotation_matrix(axis, angle)
    columns = [rotation[..., i] for i in range(3)]
    motor = Traced(CGA, motions.motor_from_matrix, V, V, V, V)(*columns, t)
    c2, n2 = (rotation @ c[..., None])[..., 0] + t, (rotation @ n[..., None])[..., 0]
    build = {
        "line": lambda c, n: Traced(CGA, conformal.line, V, V)(c, n),
        "circle": lambda c, n: Traced(CGA, conformal.circle, V, V, N)(c, n, r),
        "plane": lambda c, n: Traced(CGA, conformal.plane, V, N)(n, np.sum(n * c, 1)),
        "sphere": lambda c, n: Traced(CGA, conformal.sphere, V, N)(c, r),
    }[kind]
    moved = Traced(CGA, products.sandwich, "motor", kind)
    assert moved.returns == CGA.kind(kind)
    expected = build(c2, n2)
    assert np.allclose(moved(motor, build(c, n)), expected, atol=1e-11 * np.max(np.abs(expected)))
