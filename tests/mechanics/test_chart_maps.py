"""Maps from twists to motors and their rates, against dual quaternions at 50 digits: no geometric algebra in there."""

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
from bladesmith.codegen.formulas.motions import maps
from bladesmith.errors import AlgebraMismatchError, InputError, SingularError
from bladesmith.mechanics.chart_maps import FORMS, MAPS

from ..oracles.motions.dual_quaternions import MP, Dual, conjugate, motor, row_of, slopes, times
from ..support.formulas import EPS, Traced, stock
from ..support.vectors import unit

ALGEBRAS = [cga, pga]
FULL_TURN = 2 * np.pi
#: Rounding units that a motor, and a rate away from full turns, may be off by.
MOTOR_ULPS, RATE_ULPS = 4, 4


# -- samples -----------------------------------------------------------------------------------------------

ANGLES = (0.0, 1e-16, 1e-9, 1e-5, 1e-3, 0.03, 0.5, 1.0, 2.0, 3.1, np.pi, 3.2, 4.0, 5.0, 6.0, 6.2, 6.28)
NEAR = (FULL_TURN - 1e-4, FULL_TURN - 1e-8)


@cache
def samples(name: str) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Phi and twists as rows (w, v), and the angles; the outer exponential reaches half a turn."""
    rng = np.random.default_rng(61)
    angles = np.array([a for a in ANGLES if name != "outer" or a < np.pi] + (list(NEAR) if name != "outer" else []))
    size = {"cayley": np.tan(angles / 4), "outer": np.tan(angles / 2)}.get(name, angles)
    phi, twist = rng.normal(size=(2, len(angles), 6))
    phi[:, :3] = unit(phi[:, :3]) * size[:, None]
    phi[:, 3:] *= 10.0 ** rng.integers(-6, 5, size=(len(angles), 1))
    return phi, twist, angles


def screws(rows: Any, algebra: Any) -> Any:
    return dynamics.screw_from_coordinates(rows, algebra=algebra)


def motor_rows(r: Any) -> np.ndarray:
    """Dual quaternions of motors: 1, e23, e31, e12 and I3 n, e1 n, e2 n, e3 n."""
    n = "ni" if r.algebra is cga else "0"
    names = ["1", "e23", "e31", "e12", f"e123{n}", f"e1{n}", f"e2{n}", f"e3{n}"]
    columns = [np.broadcast_to(r[b], r.shape) for b in names]
    signs = [1, -1, -1, -1, 1, 1, 1, 1]
    return np.stack([s * c for s, c in zip(signs, columns, strict=True)], -1)


@cache
def exact_motors(name: str) -> list[list[Any]]:
    return [[*a[0], *a[1]] for a in (motor(name, row) for row in samples(name)[0])]


@cache
def exact_slopes(name: str) -> list[tuple[Dual, list[Dual]]]:
    return [(motor(name, row), slopes(name, row)) for row in samples(name)[0]]


@cache
def exact_rates(name: str, frame: str) -> list[list[Any]]:
    """dPhi by solving Omega = -2 dR ~R (world) or -2 ~R dR (body)."""
    found = []
    for (r, columns), twist in zip(exact_slopes(name), samples(name)[1], strict=True):
        back = conjugate(r)
        rows = [row_of(times(c, back) if frame == "world" else times(back, c)) for c in columns]
        found.append(list(MP.lu_solve(MP.matrix(rows).T, MP.matrix([MP.mpf(x) for x in twist]))))
    return found


def errors(found: np.ndarray, exact: list[list[Any]]) -> np.ndarray:
    difference = [
        [float(MP.mpf(float(f)) - e) for f, e in zip(a, b, strict=True)] for a, b in zip(found, exact, strict=True)
    ]
    return np.array(difference)


# -- motors and rates --------------------------------------------------------------------------------------


@pytest.mark.parametrize("algebra", ALGEBRAS)
@pytest.mark.parametrize("name", MAPS)
def test_motors_are_their_definitions(name: str, algebra: Any) -> None:
    phi, _, _ = samples(name)
    r = dynamics.map_motor(screws(phi, algebra), map=name)
    assert r.kind == algebra.kind("motor") and (r.status == bs.Status.OK).all()
    error = errors(motor_rows(r), exact_motors(name))
    reach = np.linalg.norm(phi[:, 3:], axis=1)
    assert (np.linalg.norm(error[:, :4], axis=1) < MOTOR_ULPS * EPS).all()
    assert (np.linalg.norm(error[:, 4:], axis=1) < MOTOR_ULPS * EPS * reach).all()


@pytest.mark.slow
@pytest.mark.parametrize("algebra", ALGEBRAS)
@pytest.mark.parametrize("frame", ["world", "body"])
@pytest.mark.parametrize("name", MAPS)
def test_rates_against_differences_at_50_digits(name: str, frame: str, algebra: Any) -> None:
    """Near a full turn, rounding of Phi alone moves the rate by the angle over what is left of the turn."""
    phi, twist, angles = samples(name)
    found = dynamics.map_rate(screws(phi, algebra), screws(twist, algebra), map=name, frame=frame)
    assert (found.status == bs.Status.OK).all()
    exact = np.array(exact_rates(name, frame), float)
    error = errors(dynamics.screw_coordinates(found), exact_rates(name, frame))
    limit = np.pi if name == "outer" else FULL_TURN
    allowed = RATE_ULPS * EPS * (1 + angles / (limit - angles))
    size = np.linalg.norm(exact[:, :3], axis=1)
    spin, reach = np.linalg.norm(twist[:, :3], axis=1), np.linalg.norm(phi[:, 3:], axis=1)
    assert (np.linalg.norm(error[:, :3], axis=1) < allowed * size).all()
    sweep = np.linalg.norm(exact[:, 3:], axis=1) + reach * np.maximum(size, spin)
    assert (np.linalg.norm(error[:, 3:], axis=1) < allowed * sweep).all()


@pytest.mark.parametrize("form", FORMS[1:])
@pytest.mark.parametrize("frame", ["world", "body"])
def test_the_forms_of_the_thesis_agree_where_they_keep_their_digits(form: str, frame: str) -> None:
    phi, twist, angles = samples("exponential")
    ordinary = (angles > 0.4) & (angles < 5) if form == "split" else angles < 5
    for algebra in ALGEBRAS:
        x, omega = screws(phi[ordinary], algebra), screws(twist[ordinary], algebra)
        found = dynamics.map_rate(x, omega, frame=frame, form=form)
        exact = exact_rates("exponential", frame)
        error = errors(dynamics.screw_coordinates(found), [exact[i] for i in np.flatnonzero(ordinary)])
        size = 1 + np.linalg.norm(phi[ordinary, 3:], axis=1)
        assert (np.linalg.norm(error, axis=1) < 200 * EPS * size).all()


def large(w: Any) -> Any:
    return maps.bend(w)[:2]


def small(w: Any) -> Any:
    return maps.small_bend(w)[:2]


def test_the_printed_coefficients_lose_what_ours_keep() -> None:
    """(6.24) as printed near 0: its coefficients are off by more than they are at 1e-3."""
    u = 1e-3
    printed = 1 / u**4 + (u + np.sin(u)) / (4 * u**3 * (np.cos(u) - 1))
    assert abs(printed + 1 / 720) > 1e-2
    for bend in (large, small):
        value, slope = Traced(stock("cga3d"), bend, "number").all(np.array([0.0, 1e-20, u * u]))
        assert np.allclose(value, 1 / 12, rtol=1e-6) and np.allclose(slope, 1 / 720, rtol=1e-6)


def test_rotations_alone_obey_the_bortz_equation() -> None:
    """Bortz 1971: dphi = w + phi x w/2 + (1/u^2)(1 - u sin u/(2 (1 - cos u))) phi x (phi x w), w the body's."""
    rng = np.random.default_rng(5)
    phi, w = rng.normal(size=(2, 40, 3))
    u = np.linalg.norm(phi, axis=1)[:, None]
    across = np.cross(phi, np.cross(phi, w))
    expected = w + np.cross(phi, w) / 2 + (1 - u * np.sin(u) / (2 * (1 - np.cos(u)))) / u**2 * across
    for algebra in ALGEBRAS:
        for name in ("bortz", "exponential"):
            x, omega = dynamics.twist(phi, algebra=algebra), dynamics.twist(w, algebra=algebra)
            found = dynamics.twist_parts(dynamics.map_rate(x, omega, map=name, frame="body"))
            assert np.allclose(found.angular, expected, rtol=1e-13, atol=1e-13) and not found.linear.any()


# -- charts of the integrators -----------------------------------------------------------------------------

SCALES = {"exponential": 1.0, "bortz": 1.0, "cayley": 0.25, "outer": -0.5}


@pytest.mark.parametrize("algebra", ["cga3d", "pga3d"])
@pytest.mark.parametrize("name", MAPS)
def test_charts_are_the_maps_in_one_scale(name: str, algebra: str) -> None:
    home = {"cga3d": cga, "pga3d": pga}[algebra]
    rng = np.random.default_rng(8)
    phi, twist = rng.normal(size=(2, 60, 6))
    phi *= 10.0 ** rng.uniform(-8, 0.1, size=(60, 1))
    x, omega = screws(phi, home), screws(twist, home)
    scale = SCALES[name]
    start = home.translator((1.0, -2.0, 0.5)) * home.rotor((1, 2, 3), 0.7)
    r = np.broadcast_to(start.as_kind("motor").values, (60, 8))
    moved = Traced(stock(algebra), getattr(maps, f"moved_{name}"), "motor", "twist")(r, x.values)
    expected = start * dynamics.map_motor(scale * x, map=name)
    assert np.allclose(moved, expected.values, rtol=0, atol=1e-14)
    found = Traced(stock(algebra), getattr(maps, f"chart_rate_{name}"), "twist", "twist")(x.values, omega.values)
    wanted = dynamics.map_rate(scale * x, omega, map=name, frame="body") / scale
    assert np.allclose(found, wanted.values, rtol=1e-13, atol=1e-14)
    at_rest = Traced(stock(algebra), getattr(maps, f"chart_rate_{name}"), "twist", "twist")(0 * x.values, omega.values)
    assert np.array_equal(at_rest, omega.values)


def test_the_cheap_exponential_chart_is_right_up_to_the_full_turn() -> None:
    phi, twist, angles = samples("exponential")
    x, omega = screws(phi, cga), screws(twist, cga)
    found = Traced(stock("cga3d"), maps.chart_rate_exponential, "twist", "twist")(x.values, omega.values)
    exact = np.array(exact_rates("exponential", "body"), float)
    error = errors(dynamics.screw_coordinates(cga.multivector(found, kind="twist")), exact_rates("exponential", "body"))
    allowed = RATE_ULPS * EPS * (1 + angles / (FULL_TURN - angles))
    assert (np.linalg.norm(error[:, :3], axis=1) < allowed * np.linalg.norm(exact[:, :3], axis=1)).all()


def test_the_truncated_chart_is_of_fourth_order() -> None:
    rng = np.random.default_rng(9)
    phi, twist = rng.normal(size=(2, 20, 6))
    full = Traced(stock("cga3d"), maps.chart_rate_exponential, "twist", "twist")
    short = Traced(stock("cga3d"), maps.chart_rate_truncated, "twist", "twist")
    first, second = (np.abs(full(s * phi, twist) - short(s * phi, twist)).max(1) for s in (0.2, 0.1))
    assert (first / second > 14).all() and (first / second < 18).all()


# -- properties and bad input ------------------------------------------------------------------------------

rows6 = st.lists(st.floats(-0.7, 0.7), min_size=6, max_size=6)


@given(rows6, rows6, st.sampled_from(MAPS), st.sampled_from(ALGEBRAS))
def test_world_and_body_rates_are_one(phi: list[float], twist: list[float], name: str, algebra: Any) -> None:
    x, omega = screws(phi, algebra), screws(twist, algebra)
    r = dynamics.map_motor(x, map=name)
    world = dynamics.map_rate(x, r >> omega, map=name)
    body = dynamics.map_rate(x, omega, map=name, frame="body")
    assert np.allclose(dynamics.screw_coordinates(world), dynamics.screw_coordinates(body), rtol=0, atol=1e-13)


@pytest.mark.parametrize("algebra", ALGEBRAS)
def test_singular_and_invalid_items_say_so(algebra: Any) -> None:
    phi = dynamics.twist([(0, 0, FULL_TURN), (0, np.nan, 0), (1, 0, 0), (0, 0, 2 * FULL_TURN)], algebra=algebra)
    omega = dynamics.twist((1.0, 2.0, 3.0), algebra=algebra)
    for name in ("exponential", "bortz"):
        found = dynamics.map_rate(phi, omega, map=name)
        assert found.status.tolist() == [bs.Status.SINGULAR, bs.Status.INVALID, bs.Status.OK, bs.Status.SINGULAR]
        assert np.isnan(found.values[[0, 1, 3]]).all() and np.isfinite(found.values[2]).all()
        with pytest.raises(SingularError, match="item 0 is SINGULAR"):
            dynamics.map_rate(phi, omega, map=name, strict=True)
    split = dynamics.map_rate(dynamics.twist([(0, 0, 0), (0, 0, 1)], algebra=algebra), omega, form="split")
    assert split.status.tolist() == [bs.Status.SINGULAR, bs.Status.OK]
    assert dynamics.map_motor(phi).status.tolist()[1] == bs.Status.INVALID
    bad = dynamics.map_rate(phi[2], dynamics.twist((np.inf, 0, 0), algebra=algebra))
    assert bad.status == bs.Status.INVALID


def test_batches_precisions_and_errors() -> None:
    phi = dynamics.twist(np.zeros((0, 3)))
    assert dynamics.map_motor(phi).shape == (0,) and dynamics.map_rate(phi, dynamics.twist((1, 0, 0))).shape == (0,)
    single = dynamics.twist(np.float32([[0.1, 0.2, 0.3]]), np.float32([1, 2, 3]))
    assert dynamics.map_motor(single).dtype == np.float32
    found, wanted = (dynamics.map_rate(s, s).values for s in (single, single.astype(float)))
    assert found.dtype == np.float32 and np.allclose(found, wanted, rtol=1e-6)
    many = dynamics.map_rate(dynamics.twist(np.ones((3, 1, 3))), dynamics.twist(np.ones((4, 3))))
    assert many.shape == (3, 4)
    x = dynamics.twist((1, 0, 0))
    with pytest.raises(InputError, match="'caley' .did you mean 'cayley'"):
        dynamics.map_motor(x, map="caley")
    with pytest.raises(InputError, match="frame is 'wold'"):
        dynamics.map_rate(x, x, frame="wold")
    with pytest.raises(InputError, match="one of exponential"):
        dynamics.map_rate(x, x, map="outer", form="series")
    with pytest.raises(AlgebraMismatchError):
        dynamics.map_rate(x, dynamics.twist((1, 0, 0), algebra=pga))
    with pytest.raises(InputError, match="multivector"):
        dynamics.map_motor((1, 2, 3))  # type: ignore[arg-type]
