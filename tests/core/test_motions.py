"""Motions of CGA and PGA against elementary geometry: matrices, screws, moved points, reflections."""

from __future__ import annotations

import numpy as np
import pytest

import bladesmith as bs
from bladesmith import errors

from ..support.objects.positions import OFFSET, RADIUS, RANDOM, UNIT, A, B, C, N, V
from ..support.vectors import rotation_matrix


@pytest.mark.parametrize("algebra", ["cga3d", "pga3d"])
def test_motors_are_the_rigid_motions(algebra: str) -> None:
    alg = getattr(bs, algebra)
    angle = RANDOM.uniform(-7, 7, N)
    turn = rotation_matrix(V, angle)
    about = alg.rotor(V, angle, point=A)
    assert np.allclose((about >> alg.point(B)).parameters().xyz, np.einsum("nij,nj->ni", turn, B - A) + A)
    motor = alg.translator(C) * alg.rotor(V, angle)
    assert motor.kind == alg.kind("motor")
    matrix = motor.to_matrix()
    assert np.allclose(matrix[:, :3, :3], turn) and np.allclose(matrix[:, :3, 3], C)
    assert np.allclose(matrix[:, 3], [0, 0, 0, 1])
    back = alg.motor_from_matrix(matrix)
    assert (back["1"] >= 0).all() and np.allclose(back.to_matrix(), matrix)
    assert (back.isclose(motor, rtol=1e-9) | back.isclose(-motor, rtol=1e-9)).all()
    assert np.allclose(alg.motor_from_matrix(turn).to_matrix()[:, :3, :3], turn)


@pytest.mark.parametrize("algebra", ["cga3d", "pga3d"])
def test_screws_come_back(algebra: str) -> None:
    alg = getattr(bs, algebra)
    angle = RANDOM.uniform(0.01, 2 * np.pi - 0.01, N)
    r = alg.rotor(V, angle, point=A)
    found = r.parameters()
    assert np.allclose(found.axis, UNIT) and np.allclose(found.angle, angle)
    assert np.allclose(found.advance, 0, atol=1e-9)
    across = A - (A * UNIT).sum(-1, keepdims=True) * UNIT
    assert np.allclose(found.point, across, atol=1e-7)
    screw = (alg.translator(UNIT * OFFSET[:, None]) * r).parameters()
    assert np.allclose(screw.advance, OFFSET) and np.allclose(screw.point, across, atol=1e-7)
    assert np.allclose(alg.rotor(V, angle).parameters().axis, UNIT)
    still = (alg.translator(np.zeros(3)) * alg.rotor([0.0, 0.0, 1.0], 0.0)).parameters()
    assert still.status == bs.Status.NOT_UNIQUE and still.angle == 0


def test_conformal_motions() -> None:
    cga = bs.cga3d
    x = cga.point(B)
    scaled = cga.dilator(RADIUS, A) >> x
    assert np.allclose(scaled.normalized().parameters().xyz, A + RADIUS[:, None] * (B - A))
    assert np.allclose((cga.dilator(RADIUS) >> x).normalized().parameters().xyz, RADIUS[:, None] * B)
    t = 0.1 * V
    square = (B**2).sum(-1, keepdims=True)
    expected = (B + square * t) / (1 + 2 * (t * B).sum(-1, keepdims=True) + (t**2).sum(-1, keepdims=True) * square)
    assert np.allclose((cga.transversor(t) >> x).normalized().parameters().xyz, expected)
    sphere = cga.dilator(2.0) >> cga.sphere([1.0, 0.0, 0.0], 1.5)
    assert np.allclose(sphere.parameters().center, [2, 0, 0]) and np.isclose(sphere.parameters().radius, 3)


def test_reflections() -> None:
    for alg in (bs.cga3d, bs.pga3d):
        plane = alg.plane([0.0, 0.0, 1.0], 1.0)
        image = alg.point(A).reflect(plane)
        expected = A * [1, 1, -1] + [0, 0, 2]
        assert np.allclose(image.normalized().parameters().xyz, expected)
    cga = bs.cga3d
    inverted = cga.point(A).reflect(cga.sphere([0.0, 0.0, 0.0], 2.0)).normalized()
    assert np.allclose(inverted.parameters().xyz, 4 * A / (A**2).sum(-1, keepdims=True))
    with pytest.raises(errors.GradeError, match="one"):
        cga.point(A).reflect(cga.e1 + cga.e12)


@pytest.mark.parametrize("algebra", ["cga3d", "pga3d"])
def test_parameters_of_motors_are_those_of_the_screw(algebra: str) -> None:
    """Any angle, also next to a full turn and where squares of sines underflow; one item gives what a batch does."""
    alg = getattr(bs, algebra)
    angles = np.array([0.0, 1e-200, 1e-12, 1e-4, 1.0, np.pi, 2 * np.pi - 1e-6, 2 * np.pi - 1e-9])
    axis, middle = np.array([2.0, -3.0, 6.0]) / 7, np.array([3.0, 2.0, 0.0])
    for advance in (0.0, -1.5):
        for start in (np.zeros(3), middle):
            r = alg.rotor(axis, angles, start)
            motors = (alg.translator(advance * axis) * r).as_kind("motor")
            batch = motors.parameters()
            for i, angle in enumerate(angles.tolist()):
                one = motors[i].parameters()
                for found, expected in zip(one, batch, strict=True):
                    assert (
                        np.array_equal(found, expected[i], equal_nan=True) and not np.signbit(found[found == 0]).any()
                    )
                assert np.isclose(one.angle, angle, rtol=1e-14, atol=0) or abs(one.angle - angle) < 4e-15
                assert np.isclose(one.advance, advance if angle else abs(advance), atol=1e-14)
                if angle > 1e-5 and angle < 6.283185:
                    assert np.allclose(one.axis, axis, atol=1e-11) and np.allclose(one.point, start, atol=1e-6)
                elif not angle:
                    assert np.allclose(one.axis, np.sign(advance) * axis if advance else [0, 0, 1])
                    assert not one.point.any() and one.status == (bs.Status.OK if advance else bs.Status.NOT_UNIQUE)
    found = alg.rotor(axis, 1e-200).parameters()
    assert np.allclose(found.axis, axis, atol=1e-15) and found.angle == pytest.approx(1e-200, rel=1e-14)
    turned = (-alg.translator([1.0, 2.0, 2.0])).as_kind("motor").parameters()
    assert turned.status == bs.Status.NOT_UNIQUE and np.isclose(turned.angle, 2 * np.pi)
    assert (
        np.allclose(turned.axis, np.array([1, 2, 2]) / 3) and np.isclose(turned.advance, 3) and not turned.point.any()
    )
    shift = alg.translator([1.0, 2.0, 2.0])
    assert np.allclose(shift.parameters().t, [1, 2, 2]) and np.isclose(alg.motor_parameters(shift).advance, 3)


def test_parameters_of_conformal_rotors_one_and_many() -> None:
    cga = bs.cga3d
    t, scales = np.array([[1.0, -2.0, 0.5], [0.0, 0.0, 0.0]]), np.array([0.25, 1.0])
    for make in (cga.transversor, cga.translator):
        for i in range(2):
            assert np.array_equal(make(t[i]).parameters().t, make(t).parameters().t[i])
            assert np.array_equal(np.abs(make(t[i]).parameters().t), np.abs(t[i]))
    moved = cga.translator(t[0]) >> cga.dilator(scales)
    one, still = moved[0].parameters(), moved[1].parameters()
    assert np.allclose(one.scale, 0.25) and np.allclose(one.center, t[0]) and one.status == bs.Status.OK
    assert np.allclose(still.scale, 1) and still.status == bs.Status.NOT_UNIQUE
    assert moved.parameters().status.tolist() == [bs.Status.OK, bs.Status.NOT_UNIQUE]
    alone = cga.dilator(4.0).parameters()
    assert np.isclose(alone.scale, 4) and np.array_equal(alone.center, np.zeros(3)) and alone.status == bs.Status.OK
    assert cga.dilator(1.0).parameters().status == bs.Status.OK
