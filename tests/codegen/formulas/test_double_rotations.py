"""exp, log and square root of double rotations and full turns of Cl(4,1), where planes are not unique.

The oracle is the power series at 40 digits.
"""

import math

import numpy as np
import pytest

from bladesmith.codegen.formulas.products import exponentials, invariant
from bladesmith.codegen.status import Status

from ...support.formulas import EPS, Array, multivector, rows
from ...support.objects.exponentials import (
    BIVECTOR,
    CGA,
    EVEN,
    PRECISE,
    ROUND_TRIP,
    Space,
    compiled,
    largest,
    on_numbers,
    series_error,
    similarities,
    square_error,
)


def double_rotation(f: float, g: float, bend: bool) -> Array:
    """cos and sin by mpmath: (cos f + sin f e12) (cos g + sin g e3 e+), perhaps moved."""
    space, mp = Space(CGA), PRECISE.context
    plus = space.null / 2 - space.one.basis("no")
    planes = space.one.basis("e12"), space.one.basis("e3") * plus
    angles = [space.one.new({0: mp.mpf(x)}) for x in (f, g)]
    r = space.one
    for plane, angle in zip(planes, angles, strict=True):
        r = r * (space.one.new({0: mp.cos(angle.scalar())}) + plane * space.one.new({0: mp.sin(angle.scalar())}))
    if bend:
        versor = space.translator([0.3, -1, 0.5]) * (1 - space.vector([0.2, 0.4, -0.1]) * space.one.basis("no"))
        r = versor * r * ~versor
    return np.array([float(v) for v in EVEN.values(r)])


@pytest.mark.slow
@pytest.mark.parametrize("bend", [False, True])
def test_exp_of_double_rotations_by_nearly_equal_angles(bend: bool) -> None:
    """The squares of both parts differ by less than their rounding leaves, the parts themselves do not."""
    space, b = Space(CGA), []
    planes = space.one.basis("e12"), space.one.basis("e3") * (space.null / 2 - space.one.basis("no"))
    versor = space.translator([0.3, -1, 0.5]) * (1 - space.vector([0.2, 0.4, -0.1]) * space.one.basis("no"))
    for angle in (0.3, 1.0, 1.5, 2.5, 1e-5):
        for h in (0, 1e-16, 1e-12, 1e-9, -1e-9, 1e-8, 1e-7, 3e-7, 1e-6, 1e-5, 1e-4):
            x = planes[0] * space.number(angle) + planes[1] * space.number(angle * (1 + h))
            b.append([float(v) for v in BIVECTOR.values(versor * x * ~versor if bend else x)])
    r, _ = on_numbers(invariant.exp_bivector, BIVECTOR, np.array(b), EVEN)
    assert largest([series_error(BIVECTOR, np.array(x), EVEN, y) for x, y in zip(b, r, strict=True)], b) < 64 * EPS


def test_a_moved_pure_four_vector_is_singular() -> None:
    """Two half turns, whose bivector is rounding noise of either sign of the square."""
    space, rng, r = Space(CGA), np.random.default_rng(5), []
    four = space.one.basis("e123") * (space.null / 2 - space.one.basis("no"))
    for _ in range(40):
        bend = 1 - space.vector(0.5 * rng.normal(size=3)) * space.one.basis("no")
        versor = space.translator(rng.normal(size=3)) * bend
        r.append([float(v) for v in EVEN.values(versor * four * ~versor)])
    for formula, out in ((invariant.log_rotor, BIVECTOR), (invariant.sqrt_rotor, EVEN)):
        _, status = on_numbers(formula, EVEN, np.array(r), out)
        assert np.all(status == Status.SINGULAR)


@pytest.mark.slow
@pytest.mark.parametrize("bend", [False, True])
def test_double_rotations(bend: bool) -> None:
    """Angles that agree, nearly agree, add up to nearly a turn; near 1, -1 and the pure 4-vector."""
    near = [0.0, 1e-15, 1e-12, 1e-8, 1e-4]
    pairs = [(0.7, 0.7 + h) for h in near] + [(math.pi - 0.7 - h, 0.7) for h in near[2:]]
    pairs += [(math.pi / 2 - h, math.pi / 2 - 3 * h) for h in near[2:]] + [(h, h) for h in near] + [(1e-9, 3e-10)]
    pairs += [(math.pi - 1e-9, 3e-10), (math.pi - 1e-3, 1e-8), (3.0, 0.1), (2.0, 1.0), (math.pi / 2, 1e-9)]
    r = np.array([double_rotation(f, g, bend) for f, g in pairs])
    log, status = on_numbers(invariant.log_rotor, EVEN, r, BIVECTOR)
    root, root_status = on_numbers(invariant.sqrt_rotor, EVEN, r, EVEN)
    assert np.all(status == Status.OK) and np.all(root_status == Status.OK), status
    assert largest([series_error(BIVECTOR, x, EVEN, y) for x, y in zip(log, r, strict=True)], pairs) < ROUND_TRIP
    assert largest([square_error(EVEN, x, y) for x, y in zip(root, r, strict=True)], pairs) < ROUND_TRIP


def test_opposed_double_rotations_are_singular() -> None:
    r = np.array([double_rotation(math.pi - f, f, False) for f in (0.7, math.pi / 2, 1.0, 1e-3)])
    for formula, out in ((invariant.log_rotor, BIVECTOR), (invariant.sqrt_rotor, EVEN)):
        value, status = on_numbers(formula, EVEN, r, out)
        assert np.all(status == Status.SINGULAR) and np.all(np.isnan(value).any(1))


def full_turns() -> list[Array]:
    space = Space(CGA)
    e = math.exp(0.4)
    dilator = (e + 1 / e) / 2 - (space.null ^ space.one.basis("no")) * space.number((e - 1 / e) / 2)
    bend = 1 - space.vector([0.3, 0.2, 0.1]) * space.one.basis("no")
    shift = space.translator([3, -2, 1])
    rest = [space.one, space.translator([1, 2, 2]), bend, dilator, shift * dilator * ~shift]
    rest += [shift * bend * ~shift, bend * shift * dilator * ~shift * ~bend]
    return [np.array([float(v) for v in EVEN.values(-x)]) for x in rest]


@pytest.mark.slow
def test_full_turns_have_a_commuting_plane() -> None:
    r = np.array(full_turns())
    log, status = compiled(invariant.log_rotor, EVEN)(r)
    root, root_status = compiled(invariant.sqrt_rotor, EVEN)(r)
    assert np.all(status == Status.NOT_UNIQUE) and np.all(root_status == Status.NOT_UNIQUE)
    assert max(series_error(BIVECTOR, x, EVEN, y) for x, y in zip(log, r, strict=True)) < ROUND_TRIP
    assert max(square_error(EVEN, x, y) for x, y in zip(root, r, strict=True)) < ROUND_TRIP
    half, _ = on_numbers(invariant.exp_bivector, BIVECTOR, log / 2, EVEN)
    assert np.allclose(half, root, rtol=0, atol=1e-13)
    assert np.allclose(log[0], [-np.pi if CGA.blade_name(k) == "e12" else 0 for k in BIVECTOR.blades], rtol=1e-15)
    motor, twist = CGA.kind("motor"), CGA.kind("twist")
    as_motor, _ = on_numbers(exponentials.log_motor, motor, rows(motor, multivector(EVEN, r[:2])), twist)
    assert np.allclose(log[:2], rows(BIVECTOR, multivector(twist, as_motor)), atol=1e-14), "the axis of log_motor"


def test_rounding_noise_on_one_is_valid() -> None:
    r = np.eye(1, 16) + 1e-17 * np.random.default_rng(3).normal(size=(20, 16))
    assert np.all(on_numbers(invariant.log_rotor, EVEN, r, BIVECTOR)[1] == Status.OK)
    motor = CGA.kind("motor")
    assert np.all(on_numbers(exponentials.log_motor, motor, r[:, : motor.size], CGA.kind("twist"))[1] == Status.OK)


def test_full_turns_with_noise_and_small_dilations() -> None:
    """The plane of a turn that is noise beside a small dilation is still a plane, and commutes."""
    cosh, sinh = np.cosh([5e-10, 5e-4, 0.05, 1.0]), np.sinh([5e-10, 5e-4, 0.05, 1.0])
    r = np.zeros((4, 16))
    r[:, 0], r[:, EVEN.blades.index(CGA.parse_blade("noni")[0])] = -cosh, sinh
    for k, name in enumerate(("e12", "e13", "e23")):
        r[:, EVEN.blades.index(CGA.parse_blade(name)[0])] = (k - 0.7) * 2e-15
    log, status = on_numbers(invariant.log_rotor, EVEN, r, BIVECTOR)
    assert np.all(status == Status.NOT_UNIQUE)
    assert max(series_error(BIVECTOR, x, EVEN, y) for x, y in zip(log, r, strict=True)) < 2 * ROUND_TRIP


def test_batches_of_mixed_branches_are_their_items() -> None:
    """Compiled lanes do not see each other, and say what the formula itself says on NumPy."""
    r = np.concatenate([compiled(invariant.exp_bivector, BIVECTOR)(similarities()[1][::9]), np.array(full_turns())])
    r = np.concatenate([r, np.array([double_rotation(math.pi - 0.7, 0.7, False), np.full(16, np.nan)])])
    for formula, out in ((invariant.log_rotor, BIVECTOR), (invariant.sqrt_rotor, EVEN)):
        kernel = compiled(formula, EVEN)
        value, status = kernel(r)
        single = [kernel(x) for x in r]
        assert np.array_equal(value, np.array([v for v, _ in single]), equal_nan=True)
        assert np.array_equal(status, np.array([s for _, s in single]))
        own, codes = on_numbers(formula, EVEN, r, out)
        assert np.array_equal(codes, status)
        regular = np.isfinite(own).all(1)
        back = (lambda b: on_numbers(invariant.exp_bivector, BIVECTOR, b, EVEN)[0]) if out is BIVECTOR else lambda x: x
        assert np.allclose(back(own[regular]), back(value[regular]), rtol=1e-12, atol=1e-12)
