"""Inertia against clouds of particles and Newton-Euler in plain vectors, CGA and PGA."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import bladesmith as bs
from bladesmith import cga3d as cga
from bladesmith import dynamics
from bladesmith import pga3d as pga
from bladesmith.codegen.algebra.multivector import from_values
from bladesmith.codegen.formulas.mechanics import mechanics
from bladesmith.codegen.rings.protocol import PrecisionRing
from bladesmith.errors import AlgebraMismatchError, InputError, ShapeError, SingularError
from bladesmith.mechanics.principal_axes import principal

from ..support.formulas import stock
from ..support.vectors import rotation_matrix, unit

ALGEBRAS = [cga, pga]
N = 200


def parts(s: Any) -> tuple[np.ndarray, np.ndarray]:
    found = dynamics.screw_coordinates(s)
    return found[..., :3], found[..., 3:]


@cache
def cloud(scale: float = 1.0, away: float = 0.0, count: int = N) -> dict[str, np.ndarray]:
    """Rigid clouds of eight particles: masses (n, 8), places (n, 8, 3), and what follows by sums."""
    rng = np.random.default_rng(17)
    masses, places = rng.uniform(0.1, 2.0, size=(count, 8)), scale * rng.normal(size=(count, 8, 3))
    mass = masses.sum(1)
    own = places - np.einsum("nk,nkj->nj", masses, places)[:, None] / mass[:, None, None]
    tensor = np.einsum(
        "nk,nkij->nij", masses, (own * own).sum(-1)[..., None, None] * np.eye(3) - own[..., None] * own[..., None, :]
    )
    center = rng.normal(size=(count, 3)) * scale + away
    turn = rotation_matrix(unit(rng.normal(size=(count, 3))), rng.uniform(0, 6, count))
    w, v = rng.normal(size=(2, count, 3))
    return {
        "masses": masses, "mass": mass, "own": np.einsum("nij,nkj->nki", turn, own), "tensor": tensor,
        "center": center, "turn": turn, "world": turn @ tensor @ np.swapaxes(turn, 1, 2), "w": w, "v": v * scale,
    }  # fmt: skip


def pose(algebra: Any, body: dict[str, np.ndarray]) -> Any:
    return algebra.translator(body["center"]) * algebra.motor_from_matrix(body["turn"])


def inertia(algebra: Any, body: dict[str, np.ndarray]) -> Any:
    return dynamics.Inertia(body["mass"], body["tensor"], pose(algebra, body), algebra)


def twist_at_the_center(algebra: Any, w: np.ndarray, u: np.ndarray, center: np.ndarray) -> Any:
    """The twist of a body whose centre moves with u."""
    return dynamics.twist(w, u - np.cross(w, center), algebra=algebra)


# -- the function ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("algebra", ALGEBRAS)
@pytest.mark.parametrize("scale, away", [(1.0, 0.0), (1e-6, 0.0), (1.0, 1e4), (1e4, 0.0)])
def test_momentum_is_the_sum_over_particles(scale: float, away: float, algebra: Any) -> None:
    body = cloud(scale, away)
    q = inertia(algebra, body)
    linear, angular = parts(q(twist_at_the_center(algebra, body["w"], body["v"], body["center"])))
    places = body["center"][:, None] + body["own"]
    moving = body["masses"][..., None] * (body["v"][:, None] + np.cross(body["w"][:, None], body["own"]))
    reach = scale + away
    assert np.allclose(linear, moving.sum(1), rtol=0, atol=1e-13 * reach)
    assert np.allclose(angular, np.cross(places, moving).sum(1), rtol=0, atol=1e-12 * reach * (scale + reach))
    again = q.inverse(q(twist_at_the_center(algebra, body["w"], body["v"], body["center"])))
    assert np.allclose(parts(again)[0], body["w"], rtol=0, atol=1e-13 * (reach / scale) ** 2)


@pytest.mark.parametrize("algebra", ALGEBRAS)
def test_energy_center_tensor_and_matrix(algebra: Any) -> None:
    body = cloud()
    q = inertia(algebra, body)
    assert q.shape == (N,) and np.allclose(q.center, body["center"], atol=1e-13)
    assert np.allclose(q.tensor, body["world"], rtol=1e-12, atol=1e-12)
    t = twist_at_the_center(algebra, body["w"], body["v"], body["center"])
    speeds = body["v"][:, None] + np.cross(body["w"][:, None], body["own"])
    assert np.allclose(q.energy(t), (body["masses"] * (speeds * speeds).sum(-1)).sum(1) / 2)
    matrix = q.matrix()
    assert np.allclose(np.einsum("nij,nj->ni", matrix, dynamics.screw_coordinates(t)), dynamics.screw_coordinates(q(t)))
    flipped = np.roll(matrix, 3, 1)  # rows (tau, f): the symmetric matrix of the energy
    assert np.allclose(flipped, np.swapaxes(flipped, 1, 2)) and (np.linalg.eigvalsh(flipped) > 0).all()


def test_the_printed_forms_and_what_is_wrong_with_one() -> None:
    """(6.15, 6.16) over reciprocal frames; in PGA as corrected. The printed pair of PGA undoes itself all the same."""
    mass, gamma = 2.0, np.array([0.3, 0.5, 0.7])
    moments = mass * gamma
    t = dynamics.twist((0.4, -1.1, 0.6), (0.2, 0.9, -0.5))
    q = dynamics.Inertia(mass, moments)
    e, f = [cga.e1, cga.e2, cga.e3], [pga.e1, pga.e2, pga.e3]
    total = cga.scalar(0.0)
    for g, x in zip(gamma, e, strict=True):
        low, high = x * cga.e123, x ^ cga.ni
        total = total + mass * ((t | (x ^ cga.no)) * low + g * (t | (-low)) * high)
    assert total.grade(2).isclose(q(t), atol=1e-15)

    p = dynamics.twist((0.4, -1.1, 0.6), (0.2, 0.9, -0.5), algebra=pga)

    def paired(x: Any, y: Any) -> float:
        return -float((x ^ y)["e0123"])  # the coefficient of e1230

    def printed(x: Any, weights: Any, on_lines: bool) -> Any:
        total = pga.scalar(0.0)
        for g, u in zip(weights, f, strict=True):
            l_up, t_up = u ^ pga.e0, u * pga.e123
            first, second = (g, 1.0) if on_lines else (1.0, g)
            total = total + first * paired(x, l_up) * l_up + second * paired(x, t_up) * t_up
        return total.grade(2)

    assert (mass * printed(p, gamma, True)).isclose(dynamics.Inertia(mass, moments, algebra=pga)(p), atol=1e-15)
    wrong = -mass * printed(p, gamma, False)
    assert (-1 / mass * printed(wrong, 1 / gamma, True)).isclose(p, atol=1e-14)
    assert not wrong.isclose(dynamics.Inertia(mass, moments, algebra=pga)(p), atol=1e-2)


# -- rates -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("algebra", ALGEBRAS)
def test_the_rate_is_newton_and_euler(algebra: Any) -> None:
    """1e3 bodies: m du = f, d(I w) = tau; the twist's rate as the world sees it, and back to the wrench."""
    body = cloud(count=1000)
    rng = np.random.default_rng(3)
    f, tau = rng.normal(size=(2, 1000, 3))
    w, u, c, tensor = body["w"], body["v"], body["center"], body["world"]
    q = inertia(algebra, body)
    t = twist_at_the_center(algebra, w, u, c)
    load = dynamics.wrench(f, c, algebra=algebra) + dynamics.couple(tau, algebra=algebra)
    dw = np.linalg.solve(tensor, (tau - np.cross(w, np.einsum("nij,nj->ni", tensor, w)))[..., None])[..., 0]
    du = f / body["mass"][:, None]
    expected = np.concatenate([dw, du - np.cross(dw, c) - np.cross(w, u)], 1)
    found = dynamics.screw_coordinates(q.rate(q(t), load))
    assert np.abs(found - expected).max() < 1e-10 * np.abs(expected).max()
    again = q.momentum_rate(t, q.rate(q(t), load))
    assert np.abs((again - load).values).max() < 1e-10 * np.abs(load.values).max()


@pytest.mark.parametrize("name", ["cga3d", "pga3d"])
def test_the_rate_in_a_moving_frame_by_differences_at_50_digits(name: str) -> None:
    """(6.17) mended: the frame moves with a twist that is not the body's, and the momentum changes."""
    ring, home = PrecisionRing(50), {"cga3d": cga, "pga3d": pga}[name]
    algebra, h = stock(name), ring.context.mpf(10) ** -17
    rng = np.random.default_rng(4)
    psi, load, omega = (home.multivector(rng.normal(size=6), kind="twist") for _ in range(3))
    frame = (home.translator((1, 2, -1)) * home.rotor((1, 1, 2), 0.8)).as_kind("motor")
    q = dynamics.Inertia(1.7, (0.4, 0.9, 1.1), frame, home)

    def precise(x: Any) -> Any:
        return from_values(algebra, ring, x.kind.blades, [ring.context.mpf(float(v)) for v in x.values])

    def at(side: int) -> Any:
        step = precise(psi).new({0: side * h})
        turned = precise(frame) - precise(omega) * precise(frame) * step / 2  # to second order in the step
        mass = step.new({0: ring.context.mpf(1.7)})
        moments = sum(
            (
                step.new({0: ring.context.mpf(m)}) * step.basis(e)
                for m, e in zip((0.4, 0.9, 1.1), ("e1", "e2", "e3"), strict=True)
            ),
            step.constant(0),
        )
        return mechanics.twist_in(turned, mass, moments, precise(psi) + step * precise(load))

    found = q.rate(psi, load, omega)
    forward, backward = at(1), at(-1)
    for blade in found.kind.blades:
        slope = (forward.terms[blade] - backward.terms[blade]) / (2 * h)
        assert abs(float(slope) - float(found.terms[blade])) < 1e-13 * float(np.abs(found.values).max())
    v = q.inverse(psi)
    moved = q.momentum_rate(v, found, omega)
    assert moved.isclose(load, rtol=1e-12, atol=1e-12)


# -- principal axes ----------------------------------------------------------------------------------------


def test_principal_axes_of_tensors() -> None:
    rng = np.random.default_rng(6)
    squares = rng.uniform(0.1, 1.0, size=(N, 3))
    moments = squares.sum(1)[:, None] - squares  # every body's: sums of two
    turn = rotation_matrix(unit(rng.normal(size=(N, 3))), rng.uniform(0, 3, N))
    for scale in (1e-20, 1.0, 1e20):
        tensor = scale * np.einsum("nij,nj,nkj->nik", turn, moments, turn)
        found, axes = principal(tensor)
        assert np.allclose(np.sort(found), np.sort(scale * moments), rtol=1e-13, atol=0)
        assert np.allclose(np.linalg.det(axes), 1) and np.allclose(
            np.swapaxes(axes, 1, 2) @ axes, np.eye(3), atol=1e-14
        )
        assert np.allclose(np.einsum("nij,nj,nkj->nik", axes, found, axes), tensor, rtol=0, atol=1e-14 * scale * 4)
    near = rotation_matrix(unit(rng.normal(size=(N, 3))), 0.2 * np.ones(N))
    _, axes = principal(np.einsum("nij,j,nkj->nik", near, (3.0, 1.0, 2.5), near))
    assert (np.trace(axes, axis1=1, axis2=2) > 2.8).all()  # each axis is named after the one of the body beside it


def test_degenerate_tensors_and_diagonal_ones() -> None:
    ball, axes = principal(2 * np.eye(3))
    assert np.array_equal(ball, [2, 2, 2]) and np.array_equal(axes, np.eye(3))
    kept, axes = principal(np.diag([3.0, 1.0, 2.5]))
    assert np.array_equal(kept, [3, 1, 2.5]) and np.array_equal(axes, np.eye(3))
    turn = rotation_matrix(unit(np.array([1.0, 2, 3])), 0.7)
    moments, axes = principal(turn @ np.diag([1.0, 1.0, 2.0]) @ turn.T)
    assert np.allclose(np.sort(moments), [1, 1, 2]) and np.allclose(
        axes * moments @ axes.T, turn @ np.diag([1.0, 1.0, 2.0]) @ turn.T
    )


@pytest.mark.parametrize("algebra", ALGEBRAS)
def test_principal_screws_are_scaled_by_the_inertia(algebra: Any) -> None:
    """Q takes the line of an axis to I times the couple about it, and the couple to m times the line (6.4.4)."""
    body = cloud()
    q = inertia(algebra, body)
    screws = q.principal_screws()
    assert screws.shape == (N, 6)
    lines, couples = screws[:, :3], screws[:, 3:]
    for k in range(3):
        assert q(lines[:, k]).isclose(q.moments[:, k] * couples[:, k], atol=1e-11).all()
        assert q(couples[:, k]).isclose(q.mass * lines[:, k], atol=1e-11).all()


# -- properties and bad input ------------------------------------------------------------------------------

rows6 = st.lists(st.floats(-3, 3), min_size=6, max_size=6)


@given(rows6, rows6, st.sampled_from(ALGEBRAS))
def test_a_moved_inertia_moves_the_momentum(place: list[float], t: list[float], algebra: Any) -> None:
    r = dynamics.map_motor(dynamics.screw_from_coordinates(place, algebra=algebra))
    omega = dynamics.screw_from_coordinates(t, algebra=algebra)
    q = dynamics.Inertia(1.5, [[2.0, 0.1, 0], [0.1, 1.5, 0.2], [0, 0.2, 1.0]], algebra=algebra)
    moved = q.transformed(r)(r >> omega)
    assert np.abs((moved - (r >> q(omega))).values).max() < 1e-11


def test_precision_is_that_of_the_screws() -> None:
    q = dynamics.Inertia(2.0, (1, 2, 2.5))
    single, double = (dynamics.twist(np.ones((4, 3), d), np.ones((4, 3), d)) for d in (np.float32, np.float64))
    assert q(single).dtype == np.float32 and q(double).dtype == np.float64 and q.inverse(single).dtype == np.float32
    assert np.allclose(q.rate(q(single), single).values, q.rate(q(double), double).values, rtol=1e-5, atol=1e-6)
    assert q(dynamics.twist(np.zeros((0, 3)))).shape == (0,)
    many = dynamics.Inertia([1.0, 2.0], (1, 2, 2.5))
    assert many.shape == (2,) and many(double[:1]).shape == (2,) and many.matrix().shape == (2, 6, 6)
    assert many.transformed(cga.translator(np.ones((5, 1, 3)))).shape == (5, 2) and repr(many)


def test_rods_have_no_inverse() -> None:
    rod = dynamics.Inertia(1.0, (0.0, 2.0, 2.0))
    assert np.allclose(parts(rod(dynamics.twist((1, 1, 0), (0, 0, 1)))), ([0, 0, 1], [0, 2, 0]))
    found = rod.inverse(dynamics.wrench((1, 0, 0), 0))
    assert found.status == bs.Status.SINGULAR and np.isnan(found.values).all()
    assert rod.rate(dynamics.wrench((1, 0, 0), 0)).status == bs.Status.SINGULAR
    with pytest.raises(SingularError):
        rod.inverse(dynamics.wrench((1, 0, 0), 0), strict=True)
    nan = dynamics.Inertia(1.0, (1, 1, 1)).inverse(dynamics.couple([(1, 0, 0), (np.nan, 0, 0)]))
    assert nan.status.tolist() == [bs.Status.OK, bs.Status.INVALID]


def test_bad_bodies_say_what_is_wrong() -> None:
    make = dynamics.Inertia
    with pytest.raises(InputError, match="mass is 0.0; a positive"):
        make(0.0, (1, 1, 1))
    with pytest.raises(InputError, match=r"mass\[1\] is -2"):
        make([1.0, -2.0], (1, 1, 1))
    with pytest.raises(InputError, match=r"inertia\[1\] is nan"):
        make(1.0, (1, np.nan, 1))
    with pytest.raises(InputError, match="moment of inertia is -1"):
        make(1.0, (-1, 2, 2))
    with pytest.raises(InputError, match="moment of inertia is 0"):
        make(1.0, (0, 0, 0))
    with pytest.raises(InputError, match=r"exceeds the sum of the others by 0.5 .item 1."):
        make(1.0, [(1, 1, 1), (1, 1, 2.5)])
    with pytest.raises(InputError, match="not symmetric: it differs from its transpose by up to 2"):
        make(1.0, [[3, 2, 0], [0, 3, 0], [0, 0, 3]])
    with pytest.raises(ShapeError, match="ends in 3"):
        make(1.0, (1, 1))
    with pytest.raises(ShapeError, match="do not broadcast"):
        make(np.ones(2), np.ones((4, 3)))
    with pytest.raises(AlgebraMismatchError, match="motor belongs to pga3d"):
        make(1.0, (1, 1, 1), pga.translator((1, 0, 0)), cga)
    with pytest.raises(InputError, match="motor is .1, 2, 3."):
        make(1.0, (1, 1, 1), (1, 2, 3))  # type: ignore[arg-type]
    with pytest.raises(AlgebraMismatchError, match="twist belongs to pga3d"):
        make(1.0, (1, 1, 1))(dynamics.twist((1, 0, 0), algebra=pga))
    plate = make(1.0, (0.0833333, 0.0833333, 0.1666667))  # rounded in print: within 1e-6
    assert plate.shape == () and "center (0, 0, 0)" in repr(plate)
