"""Twists, wrenches and statics against plain vectors, 6 x 6 matrices and `clifford`, in CGA and PGA."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import bladesmith as bs
from bladesmith import cga3d as cga
from bladesmith import dynamics
from bladesmith import pga3d as pga
from bladesmith.dispatch.coefficients import embed
from bladesmith.errors import AlgebraMismatchError, GradeError, InputError, KindError, ShapeError, SingularError

from ..oracles.clifford_layouts import oracle
from ..support.formulas import EPS
from ..support.vectors import rotation_matrix, unit

ALGEBRAS = [cga, pga]
RNG = np.random.default_rng(31)
N = 100
A, B, C, D, P = RNG.normal(size=(5, N, 3))
OK, INVALID = bs.Status.OK, bs.Status.INVALID


def skew(v: Any) -> np.ndarray:
    """[v x]."""
    x, y, z = np.moveaxis(np.asarray(v, float), -1, 0)
    o = np.zeros_like(x)
    return np.stack([o, -z, y, z, o, -x, -y, x, o], -1).reshape(*o.shape, 3, 3)


def adjoint(rotation: Any, t: Any) -> np.ndarray:
    """How (w, v) and (f, tau) move: [[R, 0], [[t x] R, R]]."""
    matrix = np.zeros((*rotation.shape[:-2], 6, 6))
    matrix[..., :3, :3] = matrix[..., 3:, 3:] = rotation
    matrix[..., 3:, :3] = skew(t) @ rotation
    return matrix


def six(s: Any) -> np.ndarray:
    return dynamics.screw_coordinates(s)


def rows(first: Any, second: Any) -> np.ndarray:
    return np.concatenate([first, second], -1)


# -- what they mean ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e4])
def test_a_twist_moves_points_by_the_commutator(scale: float) -> None:
    """dX = X x Omega: the difference of two points, v + w x p away."""
    t = dynamics.twist(A, B)
    x = cga.point(scale * P)
    moved = (x * t - t * x) / 2
    velocity = np.stack([moved[e] for e in ("e1", "e2", "e3")], -1)
    expected = B + np.cross(A, scale * P)
    assert np.allclose(velocity, expected, rtol=1e-13, atol=1e-13 * max(1.0, scale))
    assert np.allclose(moved["ni"], (scale * P * expected).sum(-1), rtol=1e-12, atol=1e-12 * max(1, scale**2))
    assert np.allclose(dynamics.velocity_at(t, scale * P), expected, rtol=1e-14)


def test_a_twist_of_pga_moves_points_by_the_commutator() -> None:
    t, x = dynamics.twist(A, B, algebra=pga), pga.point(P)
    moved = ((x * t - t * x) / 2).grade(3)
    assert moved.isclose(pga.direction(B + np.cross(A, P)), atol=1e-13).all()
    assert np.allclose(dynamics.velocity_at(t, P), B + np.cross(A, P))


@pytest.mark.parametrize("algebra", ALGEBRAS)
def test_a_motor_of_a_twist_turns_about_its_axis(algebra: Any) -> None:
    """exp(-t Omega/2) after a small time, against Rodrigues' formula about the instantaneous screw axis."""
    step = 1e-3
    found = dynamics.screw(dynamics.twist(A, B, algebra=algebra))
    place = np.cross(A, B) / (A * A).sum(-1)[:, None]
    assert np.allclose(found.pitch, (A * B).sum(-1) / (A * A).sum(-1)) and np.allclose(
        found.magnitude, np.linalg.norm(A, axis=1)
    )
    assert np.allclose(found.axis.parameters().point, place, atol=1e-13)
    r = dynamics.map_motor(step * dynamics.twist(A, B, algebra=algebra))
    turn = rotation_matrix(unit(A), step * np.linalg.norm(A, axis=1))
    moved = place + np.einsum("nij,nj->ni", turn, P - place) + step * found.pitch[:, None] * A
    matrix = r.to_matrix()
    assert np.allclose(np.einsum("nij,nj->ni", matrix[:, :3, :3], P) + matrix[:, :3, 3], moved, atol=1e-14)


@pytest.mark.parametrize("algebra", ALGEBRAS)
def test_parts_moments_and_power_are_those_of_vectors(algebra: Any) -> None:
    w, t = dynamics.wrench(A, P, algebra=algebra), dynamics.twist(C, D, algebra=algebra)
    assert w.kind == t.kind == algebra.kind("twist")
    force, moment = dynamics.wrench_parts(w)
    assert np.array_equal(force, A) and np.allclose(moment, np.cross(P, A), atol=1e-15)
    assert np.allclose(dynamics.moment_about(w, P), 0, atol=1e-14)
    assert np.allclose(dynamics.moment_about(w, B), np.cross(P - B, A), atol=1e-14)
    angular, linear = dynamics.twist_parts(t)
    assert np.array_equal(angular, C) and np.array_equal(linear, D)
    at_the_point = (A * (D + np.cross(C, P))).sum(-1)
    assert np.allclose(dynamics.power(t, w), at_the_point, atol=1e-13)
    assert np.allclose(dynamics.reciprocal(w, t), dynamics.power(t, w), atol=1e-14)
    free = dynamics.couple(B, algebra=algebra)
    assert np.array_equal(dynamics.wrench_parts(free).moment, B) and not dynamics.wrench_parts(free).force.any()
    assert np.allclose(dynamics.power(t, free), (C * B).sum(-1))


@pytest.mark.parametrize("algebra", ALGEBRAS)
def test_screw_products_are_those_of_six_vectors(algebra: Any) -> None:
    s, t = (dynamics.screw_from_coordinates(rows(x, y), algebra=algebra) for x, y in ((A, B), (C, D)))
    crossed = dynamics.screw_cross(s, t)
    assert np.allclose(six(crossed), rows(np.cross(A, C), np.cross(A, D) + np.cross(B, C)), atol=1e-14)
    assert np.allclose(dynamics.reciprocal(s, t), (A * D + B * C).sum(-1))
    ads = []
    for a, b in ((A, B), (C, D)):
        ad = np.zeros((N, 6, 6))
        ad[:, :3, :3] = ad[:, 3:, 3:] = skew(a)
        ad[:, 3:, :3] = skew(b)
        ads.append(ad)
    killing = np.trace(ads[0] @ ads[1], axis1=1, axis2=2)
    assert np.allclose(dynamics.killing_form(s, t), killing, rtol=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("algebra", ALGEBRAS)
def test_clifford_agrees_on_the_products_of_screws(algebra: Any) -> None:
    """6.2.3 by its tables: S T = <S T>_0 - S cross T + (S o T) I3 n, with S = a I3 + b n."""
    plain = algebra.layout_of(algebra.blades)
    s, t = dynamics.twist(A, B, algebra=algebra), dynamics.twist(C, D, algebra=algebra)
    dense = [embed(x, plain) for x in (s, t)]
    theirs = algebra.multivector(oracle(algebra).product("gmt", *dense))
    null = algebra.ni if algebra is cga else algebra.e0
    volume = algebra.e123 * null
    scalar = algebra.scalar(dynamics.killing_form(s, t) / 4)
    expected = scalar - dynamics.screw_cross(s, t) + dynamics.reciprocal(s, t) * volume
    assert np.abs((theirs - expected).values).max() < 1e-13


@pytest.mark.parametrize("algebra", ALGEBRAS)
def test_the_order_of_six_numbers_and_motion_by_the_adjoint(algebra: Any) -> None:
    turn = rotation_matrix(unit(C), 1.1 * np.ones(N))
    r = algebra.translator(P) * algebra.rotor(C, 1.1)
    s = dynamics.screw_from_coordinates(rows(A, B), algebra=algebra)
    expected = np.einsum("nij,nj->ni", adjoint(turn, P), rows(A, B))
    assert np.allclose(six(r >> s), expected, atol=1e-13)
    assert np.array_equal(six(s), rows(A, B))
    assert np.array_equal(dynamics.screw_coordinates(s, order="axis-last"), rows(B, A))
    again = dynamics.screw_from_coordinates(rows(B, A), order="axis-last", algebra=algebra)
    assert np.array_equal(again.values, s.values)


# -- forces in other hands ---------------------------------------------------------------------------------


@pytest.mark.parametrize("algebra", ALGEBRAS)
def test_forces_are_lines(algebra: Any) -> None:
    size = np.linalg.norm(A, axis=1)
    line = algebra.line(P, A)
    w = dynamics.wrench(A, P, algebra=algebra)
    assert dynamics.force_along(line, size).isclose(w, rtol=1e-13).all()
    back = dynamics.line_of_wrench(w / size)
    assert back.isclose(line, rtol=1e-13).all()


def test_the_force_through_two_points_is_the_thesis_line() -> None:
    """(6.1), (6.2): up(a) ^ up(a + f) ^ n_inf, times I5; F^2 = |f|^2."""
    f = cga.point(P) ^ cga.point(P + A) ^ cga.ni
    assert np.allclose((f * f)["1"], (A * A).sum(-1), rtol=1e-11)
    assert f.dual().isclose(dynamics.wrench(A, P), rtol=1e-11, atol=1e-12).all()


def test_forces_as_vectors_of_lasenby_and_doran() -> None:
    columns = {"e1": A[:, 0], "e2": A[:, 1], "e3": A[:, 2]}
    for alpha in (0.0, 3.7):
        w = dynamics.wrench_of_vector(cga.multivector({**columns, "ni": np.full(N, alpha)}), cga.point(P))
        assert w.isclose(dynamics.wrench(A, P), rtol=1e-12, atol=1e-13).all()
    found = dynamics.vector_of_wrench(dynamics.wrench(A, P) + dynamics.couple(B))
    assert (found.status == OK).all()
    again = dynamics.wrench_of_vector(found.force, found.point) + found.couple
    assert again.isclose(dynamics.wrench(A, P) + dynamics.couple(B), rtol=1e-12, atol=1e-12).all()
    place, along = found.point.parameters().xyz, (A * B).sum(-1) / (A * A).sum(-1)
    assert np.allclose((place * A).sum(-1), 0, atol=1e-13)
    assert np.allclose(found.couple["e1ni"], along * A[:, 0], rtol=1e-11)
    alone = dynamics.vector_of_wrench(dynamics.couple([(1.0, 0, 0), (0, np.nan, 0)]))
    assert alone.status.tolist() == [bs.Status.SINGULAR, INVALID] and np.isnan(alone.force.values).all()
    with pytest.raises(SingularError):
        dynamics.vector_of_wrench(dynamics.couple((1, 0, 0)), strict=True)
    with pytest.raises(GradeError, match="pga3d"):
        dynamics.vector_of_wrench(dynamics.couple((1, 0, 0), algebra=pga))
    with pytest.raises(GradeError, match="vector of cga3d"):
        dynamics.wrench_of_vector(dynamics.couple((1, 0, 0)), cga.point((0, 0, 0)))


def test_ideal_lines_of_gunn_are_couples() -> None:
    """e0 a = -a e0: its power on a turn about a is negative."""
    found = dynamics.ideal_line(A)
    by_hand = pga.e0 * pga.multivector({"e1": A[:, 0], "e2": A[:, 1], "e3": A[:, 2]})
    assert found.isclose(by_hand).all() and found.isclose(dynamics.couple(-A, algebra=pga)).all()
    assert (dynamics.power(dynamics.twist(A, algebra=pga), found) < 0).all()


# -- statics -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("algebra", ALGEBRAS)
def test_a_beam_and_a_ladder_are_in_equilibrium(algebra: Any) -> None:
    """Reactions of a beam of length 4 with a load at 1; a ladder against a smooth wall."""

    def at(force: Any, point: Any) -> Any:
        return dynamics.wrench(force, point, algebra=algebra)

    beam = [at((0, 0, -12.0), (1, 0, 0)), at((0, 0, 9.0), (0, 0, 0)), at((0, 0, 3.0), (4, 0, 0))]
    found = dynamics.equilibrium(beam)
    assert found.balanced and found.status == OK and found.force == 0
    weight, height, foot = 200.0, 4.0, 1.5
    push = weight * foot / 2 / height
    ladder = [
        at((0, 0, -weight), (foot / 2, 0, height / 2)), at((push, 0, 0), (0, 0, height)),
        at((-push, 0, weight), (foot, 0, 0)),
    ]  # fmt: skip
    assert dynamics.equilibrium(ladder).balanced
    without_friction = dynamics.equilibrium(ladder[:2] + [at((0, 0, weight), (foot, 0, 0))])
    assert not without_friction.balanced and np.isclose(without_friction.force, push)
    assert np.allclose(dynamics.wrench_parts(without_friction.residual).force, (push, 0, 0))


@pytest.mark.parametrize("algebra", ALGEBRAS)
def test_resultants_are_sums_of_forces_and_moments(algebra: Any) -> None:
    forces, points = RNG.normal(size=(2, 7, 20, 3))
    found = dynamics.wrench_parts(dynamics.resultant(dynamics.wrench(forces, points, algebra=algebra)))
    assert np.allclose(found.force, forces.sum(0)) and np.allclose(found.moment, np.cross(points, forces).sum(0))
    listed = dynamics.resultant([dynamics.wrench(f, p, algebra=algebra) for f, p in zip(forces, points, strict=True)])
    assert np.allclose(dynamics.wrench_parts(listed).moment, found.moment)
    last = dynamics.resultant(dynamics.wrench(forces, points, algebra=algebra), axis=-1)
    assert np.allclose(dynamics.wrench_parts(last).force, forces.sum(1))
    opposite = dynamics.resultant([dynamics.wrench(A, P, algebra=algebra), dynamics.wrench(-A, B, algebra=algebra)])
    assert np.allclose(dynamics.wrench_parts(opposite).force, 0)
    assert np.allclose(dynamics.wrench_parts(opposite).moment, np.cross(P - B, A))


@pytest.mark.parametrize("scale, away", [(1e-6, 0.0), (1.0, 1e4), (1e-6, 1e4), (1e4, 0.0)])
def test_equilibrium_of_small_and_far_bodies(scale: float, away: float) -> None:
    """Random forces and the one force and couple that balance them, about a point of the body."""
    center = np.array([away, -away, away])
    forces, offsets = RNG.normal(size=(2, 6, 3))
    wrenches = [dynamics.wrench(f, center + scale * p) for f, p in zip(forces, offsets, strict=True)]
    exact = sum(np.cross((center + scale * p) - center, f) for f, p in zip(forces, offsets, strict=True))
    balance = [dynamics.wrench(-forces.sum(0), center), dynamics.couple(-exact)]
    assert dynamics.equilibrium(wrenches + balance, about=center).balanced
    off = dynamics.equilibrium(
        [*wrenches, *balance, dynamics.couple((1e-6 * scale + 1e-10 * away, 0, 0))], about=center
    )
    assert not off.balanced


def test_statuses_of_statics() -> None:
    w = dynamics.wrench([(1.0, 0, 0), (np.nan, 0, 0)], 0)
    assert w.status.tolist() == [OK, INVALID]
    total = dynamics.resultant([w, dynamics.couple((0, 0, 1))])
    assert total.status.tolist() == [OK, INVALID] and np.isnan(total.values[1]).all()
    found = dynamics.equilibrium([w, -w])
    assert found.status.tolist() == [OK, INVALID] and found.balanced.tolist() == [True, False]
    assert dynamics.equilibrium(dynamics.wrench(np.zeros((0, 3)), 0)).balanced
    with pytest.raises(InputError, match="empty"):
        dynamics.resultant([])
    with pytest.raises(ShapeError, match="without an axis"):
        dynamics.resultant(dynamics.couple((1, 0, 0)))
    with pytest.raises(ShapeError, match="broadcast"):
        dynamics.resultant([dynamics.couple(np.ones((2, 3))), dynamics.couple(np.ones((3, 3)))])
    with pytest.raises(AlgebraMismatchError):
        dynamics.resultant([dynamics.couple((1, 0, 0)), dynamics.couple((1, 0, 0), algebra=pga)])


# -- properties --------------------------------------------------------------------------------------------

numbers = st.floats(-1e3, 1e3)
rows6 = st.lists(numbers, min_size=6, max_size=6)


@given(rows6, rows6, rows6, st.sampled_from(ALGEBRAS))
def test_power_is_the_same_in_every_frame(t: list[float], w: list[float], pose: list[float], algebra: Any) -> None:
    r = dynamics.map_motor(dynamics.screw_from_coordinates(np.array(pose) * 1e-3, algebra=algebra))
    x, y = (dynamics.screw_from_coordinates(s, algebra=algebra) for s in (t, w))
    moved = dynamics.power(r >> x, r >> y)
    room = 100 * EPS * (1 + np.abs(t).sum()) * (1 + np.abs(w).sum()) * 10
    assert abs(moved - dynamics.power(x, y)) <= room


@given(rows6, rows6, rows6)
def test_the_cross_product_is_a_lie_bracket(a: list[float], b: list[float], c: list[float]) -> None:
    x, y, z = (dynamics.screw_from_coordinates(np.array(s) / 1e3) for s in (a, b, c))
    cross = dynamics.screw_cross
    jacobi = cross(x, cross(y, z)) + cross(y, cross(z, x)) + cross(z, cross(x, y))
    assert np.abs(jacobi.values).max() < 1e-14 and np.abs((cross(x, y) + cross(y, x)).values).max() < 1e-15


# -- input -------------------------------------------------------------------------------------------------


def test_precisions_shapes_and_empty_batches() -> None:
    assert dynamics.twist(np.float32([1, 2, 3])).dtype == np.float32
    assert dynamics.twist((1, 2, 3)).dtype == dynamics.twist(0).dtype == dynamics.couple((1, 2, 3)).dtype == np.float64
    assert dynamics.twist(np.ones((4, 1, 3)), np.ones((5, 3))).shape == (4, 5)
    empty = dynamics.wrench(np.zeros((0, 3)), 0)
    assert empty.shape == (0,) and dynamics.power(empty, empty).shape == (0,) and six(empty).shape == (0, 6)
    w = dynamics.wrench(np.float32(A), np.float32(P))
    assert w.dtype == np.float32
    assert np.allclose(dynamics.wrench_parts(w).moment, np.cross(P, A), atol=1e-5)


def test_errors_say_what_is_needed() -> None:
    with pytest.raises(ShapeError, match="angular has shape .2,.; .*3. is needed"):
        dynamics.twist((1, 2))
    with pytest.raises(GradeError, match="screws are bivectors"):
        dynamics.twist_parts(cga.point((1, 2, 3)))
    with pytest.raises(GradeError, match="force_along"):
        dynamics.wrench_parts(cga.line((0, 0, 0), (1, 0, 0)))
    with pytest.raises(KindError, match="e1no, which a twist of cga3d does not have"):
        dynamics.twist_parts(cga.e1 ^ cga.no)
    with pytest.raises(AlgebraMismatchError):
        dynamics.power(dynamics.twist((1, 0, 0)), dynamics.couple((1, 0, 0), algebra=pga))
    with pytest.raises(GradeError, match="no screws of space"):
        dynamics.twist((1, 0, 0), algebra=bs.cga2d)
    with pytest.raises(InputError, match="algebra is 'cga3d'"):
        dynamics.twist((1, 0, 0), algebra="cga3d")  # type: ignore[arg-type]
    with pytest.raises(InputError, match="order is 'wv'"):
        dynamics.screw_coordinates(dynamics.twist((1, 0, 0)), order="wv")
    with pytest.raises(InputError, match="multivector is needed"):
        dynamics.power((1, 2, 3), dynamics.twist((1, 0, 0)))  # type: ignore[arg-type]
    with pytest.raises(GradeError, match="lines are needed"):
        dynamics.force_along(cga.circle((0, 0, 0), (0, 0, 1), 1.0))
    with pytest.raises(SingularError, match="INVALID"):
        dynamics.twist((np.inf, 0, 0), strict=True)
