"""exp, log and square root of motors against series at 60 digits and more, on every angle and every translation."""

from functools import cache
from typing import Any

import numpy as np
import pytest

from bladesmith.codegen.algebra.algebra import Kind, add_plain_kinds, orthonormal
from bladesmith.codegen.algebra.multivector import from_values
from bladesmith.codegen.errors import GradeError
from bladesmith.codegen.formulas.motions import motions
from bladesmith.codegen.formulas.products import exponentials, products
from bladesmith.codegen.rings.protocol import PrecisionRing
from bladesmith.codegen.status import Status

from ...support.formulas import EPS, Array, Traced, members, multivector, precise, rows, series_exp, stock
from ...support.vectors import unit

SPATIAL = ("cga3d", "pga3d")
NULL = ("ni", "0")
#: Errors that are allowed, in units of 2.2e-16 relative to the rotation or the translation part.
EXP_ULPS, LOG_ULPS = 4, 12
PRECISE = PrecisionRing(100)


def split(kind: Kind) -> tuple[list[int], list[int]]:
    """Places of the rotation and of the translation coefficients."""
    vectors = kind.algebra.vectors
    null = [i for i, b in enumerate(kind.blades) if any(b >> k & 1 and v in NULL for k, v in enumerate(vectors))]
    return [i for i in range(kind.size) if i not in null], null


@cache
def bivectors(name: str) -> tuple[Array, Array, Array]:
    """Bivectors b of motors, their angles 2 |b| and the lengths of their translations."""
    kind = stock(name).kind("twist")
    rng = np.random.default_rng(21)
    count = 160
    angle = np.exp(rng.uniform(np.log(1e-16), np.log(2 * np.pi), count))
    angle[:30] = rng.uniform(0.1, 6.2, 30)
    angle[30:50] = np.pi + np.array([-1, 1] * 10) * 10.0 ** rng.uniform(-16, -1, 20)
    angle[50:70] = 2 * np.pi - 10.0 ** rng.uniform(-8, -1, 20)
    length = 10.0 ** rng.uniform(-12, 6, count)
    length[::7] = 0.0
    rotation, translation = split(kind)
    b = np.zeros((count, 6))
    b[:, rotation] = unit(rng.normal(size=(count, 3))) * angle[:, None] / 2
    b[:, translation] = unit(rng.normal(size=(count, 3))) * length[:, None] / 2
    along = b[::5, rotation][:, ::-1] * np.array([1.0, -1.0, 1.0])
    b[::5, translation] = along * length[::5, None]  # pure screws
    return b, angle, 2 * np.linalg.norm(b[:, translation], axis=1)


@cache
def exact(name: str, halves: int = 1) -> list[list[Any]]:
    """exp(b/halves) by the series, at 100 digits: translations of 1e6 are squared away."""
    motor = stock(name).kind("motor")
    if halves == 1:
        roots = (from_values(motor.algebra, PRECISE, motor.blades, values) for values in exact(name, 2))
        return [motor.values(root * root) for root in roots]
    kind = stock(name).kind("twist")
    return [motor.values(series_exp(precise(kind, row, PRECISE) / halves)) for row in bivectors(name)[0]]


def as_floats(values: list[list[Any]]) -> Array:
    return np.array([[float(v) for v in row] for row in values])


def errors(ours: Array, values: list[list[Any]]) -> Array:
    pairs = zip(ours, values, strict=True)
    return np.array([[float(e - float(o)) for o, e in zip(a, row, strict=True)] for a, row in pairs])


def worst(name: str, error: Array, scale: Array) -> float:
    """Largest error in ulps; the offending input is printed."""
    ulps = np.where(error == 0, 0, error / np.where(scale == 0, 1e-300, scale)) / EPS
    i = int(np.argmax(ulps))
    print(f"{ulps[i]:.3g} ulps at b = {bivectors(name)[0][i].tolist()}")
    return float(ulps[i])


@pytest.mark.slow
@pytest.mark.parametrize("name", SPATIAL)
def test_exp_to_a_few_ulps(name: str) -> None:
    algebra = stock(name)
    exp = Traced(algebra, exponentials.exp_bivector, "twist")
    assert exp.returns == algebra.kind("motor")
    b, angle, length = bivectors(name)
    error = errors(exp(b), exact(name))
    rotation, translation = split(algebra.kind("motor"))
    assert worst(name, np.linalg.norm(error[:, rotation], axis=1), np.ones(len(b))) < EXP_ULPS
    assert worst(name, np.linalg.norm(error[:, rotation[1:]], axis=1), angle / 2) < EXP_ULPS
    assert worst(name, np.linalg.norm(error[:, translation], axis=1), length / 2) < EXP_ULPS


@pytest.mark.slow
@pytest.mark.parametrize("name", SPATIAL)
@pytest.mark.parametrize("kind", ["motor", "~motor"])
def test_log_undoes_the_series(name: str, kind: str) -> None:
    """Input: the motor rounded to double. Near 2 pi rounding it moves the axis by 1/sin: intrinsic, and allowed for."""
    algebra = stock(name)
    log = Traced(algebra, exponentials.log_motor, kind)
    assert log.returns == algebra.kind("twist")
    b, angle, length = bivectors(name)
    found, status = log.all(as_floats(exact(name)))
    assert np.all(status == Status.OK)
    rotation, translation = split(algebra.kind("twist"))
    condition = np.where(angle > np.pi, 1 / np.sin(angle / 2), 1.0)
    error = np.abs(found - b)
    assert worst(name, np.linalg.norm(error[:, rotation], axis=1), angle / 2) < LOG_ULPS
    assert worst(name, np.linalg.norm(error[:, translation], axis=1), condition * length / 2) < LOG_ULPS


@pytest.mark.slow
@pytest.mark.parametrize("name", SPATIAL)
def test_square_root_is_half_the_motion(name: str) -> None:
    algebra = stock(name)
    root = Traced(algebra, exponentials.sqrt_motor, "motor")
    assert root.returns == algebra.kind("motor")
    b, angle, length = bivectors(name)
    found, status = root.all(as_floats(exact(name)))
    assert np.all(status == Status.OK)
    error = errors(found, exact(name, 2))
    rotation, translation = split(algebra.kind("motor"))
    condition = np.where(angle > np.pi, 1 / np.sin(angle / 2), 1.0)
    assert worst(name, np.linalg.norm(error[:, rotation], axis=1), np.ones(len(b))) < EXP_ULPS
    assert worst(name, np.linalg.norm(error[:, rotation[1:]], axis=1), angle / 4) < EXP_ULPS
    assert worst(name, np.linalg.norm(error[:, translation], axis=1), condition * length / 4) < LOG_ULPS


@pytest.mark.parametrize("name", SPATIAL)
def test_translations_are_exact(name: str) -> None:
    algebra = stock(name)
    t = np.random.default_rng(22).normal(size=(50, 3)) * 10.0 ** np.linspace(-12, 6, 50)[:, None]
    translation = Traced(algebra, motions.translator, "euclidean")(t)
    kinds = algebra.kind("translator"), algebra.kind("motor"), algebra.kind("twist")
    motor = rows(kinds[1], multivector(kinds[0], translation))
    log, status = Traced(algebra, exponentials.log_motor, "motor").all(motor)
    assert np.all(status == Status.OK)
    assert np.array_equal(rows(kinds[1], multivector(kinds[2], log) + 1), motor)
    assert np.array_equal(Traced(algebra, exponentials.exp_bivector, "twist")(log), motor)
    own, _ = Traced(algebra, exponentials.log_motor, "translator").all(translation)
    assert np.array_equal(own, translation[:, 1:])


@pytest.mark.parametrize("name", SPATIAL)
def test_full_turns_are_a_documented_choice(name: str) -> None:
    """-1, and -(a translation): the axis along the translation through the origin, e3 where there is none."""
    algebra = stock(name)
    motor, twist = algebra.kind("motor"), algebra.kind("twist")
    t = np.array([[0.0, 0.0, 0.0], [0.3, -2.0, 5.0], [0.0, 1e-9, 0.0]])
    translation = Traced(algebra, motions.translator, "euclidean")(t)
    turn = -rows(motor, multivector(algebra.kind("translator"), translation))
    for kind in ("motor", "~motor"):
        log, status = Traced(algebra, exponentials.log_motor, kind).all(turn)
        assert np.all(status == Status.NOT_UNIQUE)
        assert np.allclose(Traced(algebra, exponentials.exp_bivector, "twist")(log), turn, atol=1e-15)
        root, status = Traced(algebra, exponentials.sqrt_motor, kind).all(turn)
        assert np.all(status == Status.NOT_UNIQUE)
        assert np.allclose(root, Traced(algebra, exponentials.exp_bivector, "twist")(log / 2), atol=1e-15)
    about_e3 = [-np.pi if algebra.blade_name(blade) == "e12" else 0.0 for blade in twist.blades]
    assert np.allclose(log[0], about_e3)


@pytest.mark.parametrize("name", SPATIAL)
def test_near_full_turns_are_answered_to_their_conditioning(name: str) -> None:
    """Rounding the far axis moves exp(b) by |t|/sin; where the sine itself is rounding, it is a full turn."""
    algebra = stock(name)
    motor = algebra.kind("motor")
    less = np.array([0.0, 1e-14, 1e-13, 1e-11, 1e-9, 1e-6])
    axis, t = np.broadcast_to([0.0, 1.0, 1.0], (6, 3)), np.broadcast_to([1.0, 2.0, 3.0], (6, 3))
    turn, _ = Traced(algebra, motions.rotor, "euclidean", "number").all(axis, 2 * np.pi - less)
    shift = Traced(algebra, motions.translator, "euclidean")(t)
    r = rows(motor, multivector(algebra.kind("translator"), shift) * multivector(algebra.kind("rotor"), turn))
    log, status = Traced(algebra, exponentials.log_motor, "motor").all(r)
    root, root_status = Traced(algebra, exponentials.sqrt_motor, "motor").all(r)
    expected = np.where(less < 2e-14, Status.NOT_UNIQUE, Status.OK)
    assert np.array_equal(status, expected) and np.array_equal(root_status, expected)
    allowed = np.where(less < 2e-14, 1e-13, 1e-14 + 32 * EPS / np.maximum(less, EPS))
    square = Traced(algebra, products.geometric, "motor", "motor")(root, root)
    for again in (Traced(algebra, exponentials.exp_bivector, "twist")(log), square):
        assert np.all(np.max(np.abs(again - r), 1) < allowed)


@pytest.mark.parametrize("name", SPATIAL)
def test_the_sign_and_the_angle_are_kept(name: str) -> None:
    """log's angle is in [0, 2 pi): 3.5 rad stays 3.5 rad about the same axis."""
    algebra = stock(name)
    axis, angle = np.array([1.0, 2.0, -2.0]), np.linspace(0.01, 6.27, 60)
    turn, _ = Traced(algebra, motions.rotor, "euclidean", "number").all(np.broadcast_to(axis, (60, 3)), angle)
    log, _ = Traced(algebra, exponentials.log_motor, "rotor").all(turn)
    assert np.allclose(2 * np.linalg.norm(log, axis=1), angle, rtol=4 * EPS, atol=0)
    assert np.allclose(log, log[:1] / np.linalg.norm(log[0]) * angle[:, None] / 2, rtol=1e-14)


@pytest.mark.parametrize("name", [*SPATIAL, "cga2d"])
def test_what_is_no_rotor_is_invalid(name: str) -> None:
    algebra = stock(name)
    motor = algebra.kind("motor")
    r = members(motor, 20, 23)
    bad = np.concatenate([2 * r, r + 1e-3, 0 * r, np.full((1, motor.size), np.nan)])
    bad[20:40, 0] += 0.1
    for formula in (exponentials.log_motor, exponentials.sqrt_motor):
        value, status = Traced(algebra, formula, "~motor").all(bad)
        assert np.all(status == Status.INVALID), np.flatnonzero(status != Status.INVALID)
        assert np.all(np.isnan(value).any(1))
        _, status = Traced(algebra, formula, "~motor").all(r * (1 + 4e-16))
        assert np.all(status == Status.OK)


def test_exp_refuses_general_bivectors() -> None:
    with pytest.raises(GradeError, match="bivectors of motors"):
        Traced(stock("cga3d"), exponentials.exp_bivector, "bivector")


@pytest.mark.parametrize("seed", [24, 25])
def test_motors_of_the_plane(seed: int) -> None:
    algebra = stock("cga2d")
    exp = Traced(algebra, exponentials.exp_bivector, "twist")
    assert exp.returns == algebra.kind("motor")
    b = members(algebra.kind("twist"), 40, seed)
    ring = PrecisionRing(60)
    expected = [algebra.kind("motor").values(series_exp(precise(algebra.kind("twist"), row, ring))) for row in b]
    assert np.max(np.abs(errors(exp(b), expected))) < 1e-15 * 4
    log, status = Traced(algebra, exponentials.log_motor, "motor").all(as_floats(expected))
    assert np.all(status == Status.OK)
    assert np.allclose(exp(log), as_floats(expected), atol=1e-14)
    shift = np.array([[-1.0, 0, 0.5, 0], [-1.0, 0, 0, 0]])
    log, status = Traced(algebra, exponentials.log_motor, "motor").all(shift)
    assert status.tolist() == [Status.SINGULAR, Status.NOT_UNIQUE]
    assert np.all(np.isnan(log[0])) and np.allclose(log[1], [-np.pi, 0, 0])


def test_rotors_without_a_null_vector_and_dilations() -> None:
    """Plain Cl(3) has no translations; a simple bivector that squares to plus one gives hyperbolic functions."""
    plain = orthonormal(3)
    add_plain_kinds(plain)
    b = members(plain.kind("bivector"), 40, 26)
    turn = Traced(plain, exponentials.exp_bivector, "bivector")(b)
    ring = PrecisionRing(60)
    even = Kind(plain, "turn", (0, *plain.kind("bivector").blades))
    expected = [even.values(series_exp(precise(plain.kind("bivector"), row, ring))) for row in b]
    assert np.max(np.abs(errors(turn, expected))) < 1e-15
    plane = orthonormal(1, 1)
    add_plain_kinds(plane)
    boost = Traced(plane, exponentials.exp_bivector, "bivector")(np.array([[0.7], [-3.0]]))
    assert np.allclose(boost, [[np.cosh(0.7), np.sinh(0.7)], [np.cosh(3), -np.sinh(3)]], rtol=4 * EPS)


def test_exp_of_a_sum_of_commuting_parts_is_the_product() -> None:
    """Rotation about an axis and translation along it."""
    algebra = stock("cga3d")
    exp = Traced(algebra, exponentials.exp_bivector, "twist")
    rotation, translation = split(algebra.kind("twist"))
    b = np.zeros((3, 2, 6))
    b[:, 0, rotation[0]], b[:, 1, translation[2]] = [0.4, 2.0, 3.1], [1.0, -3.0, 1e5]
    product = Traced(algebra, products.geometric, "motor", "motor")(exp(b[:, 0]), exp(b[:, 1]))
    assert np.allclose(product, exp(b.sum(1)), rtol=1e-14)
