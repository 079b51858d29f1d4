"""exp, log and square root of every rotor of Cl(4,1) and of small algebras, and of motors at every angle.

The oracle is the power series at 40 digits: exp by it, log by the series of what log returned.
"""

import math
from functools import cache
from itertools import product
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import bladesmith as bs
from bladesmith.codegen.algebra.algebra import Algebra, Kind, add_plain_kinds, orthonormal
from bladesmith.codegen.algebra.multivector import Multivector, from_values
from bladesmith.codegen.api import KernelFunction
from bladesmith.codegen.errors import GradeError
from bladesmith.codegen.formulas.products import exponentials, invariant
from bladesmith.codegen.rings.protocol import PrecisionRing
from bladesmith.codegen.status import Status

from ...support.formulas import EPS, Array, multivector, precise, rows, series_exp, stock
from ...support.vectors import unit

PRECISE = PrecisionRing(40)
#: The bar: exp(log(R)) and sqrt(R)^2 to this, on the scale of what was read and written.
ROUND_TRIP = 1e-14
ANGLES = (0, 1e-16, 1e-12, 1e-8, 1e-3, 1, math.pi - 1e-9, math.pi, 2 * math.pi - 1e-3, 2 * math.pi - 1e-9)
DILATIONS = (0, 1e-16, 1e-8, 0.1, 5)
SHIFTS = (0, 1e-9, 1, 1e3)
CGA = stock("cga3d")
BIVECTOR, EVEN = CGA.kind("bivector"), CGA.kind("even")


@cache
def compiled(formula: Any, kind: Kind) -> KernelFunction:
    return KernelFunction(formula, (kind,), None, formula.__name__, CGA)


def on_numbers(formula: Any, kind: Kind, values: Any, out: Kind) -> tuple[Array, Array]:
    """The formula itself on NumPy: its value on a kind's blades, and its statuses."""
    result = formula(multivector(kind, values))
    value, status = result if isinstance(result, tuple) else (result, None)
    lead = np.shape(values)[:-1]
    found = np.broadcast_to(rows(out, value), (*lead, out.size))
    codes = np.zeros(lead) if status is None else np.broadcast_to(np.asarray(status.value.scalar()), lead)
    return found, codes


def series_error(kind: Kind, b: Array, target: Kind, r: Array) -> float:
    """|exp(b) - r| on the scale of both."""
    exact = target.values(series_exp(precise(kind, b, PRECISE)))
    return max(abs(float(e - float(v))) for e, v in zip(exact, r, strict=True)) / scale(b, r)


def square_error(kind: Kind, root: Array, r: Array) -> float:
    """|root^2 - r| on the scale of both."""
    x = precise(kind, root, PRECISE)
    exact = kind.values(x * x)
    return max(abs(float(e - float(v))) for e, v in zip(exact, r, strict=True)) / scale(root**2, r)


def scale(a: Array, b: Array) -> float:
    return float(max(np.abs(a).max(), np.abs(b).max()))


def largest(errors: list[float], what: list[Any]) -> float:
    i = int(np.argmax(errors))
    print(f"{errors[i]:.2e} at {what[i]}")
    return errors[i]


class Space:
    """CGA or PGA at 40 digits: what the bivectors under test are made of."""

    def __init__(self, algebra: Algebra) -> None:
        self.one = Multivector(algebra, PRECISE, {0: PRECISE.context.mpf(1)})
        self.null = self.one.basis("ni" if "ni" in algebra.vectors else "e0")
        self.i3 = self.one.basis("e123")

    def number(self, x: float) -> Multivector:
        return self.one.new({0: PRECISE.context.mpf(float(x))})

    def vector(self, v: Any) -> Multivector:
        return self.one.sum(self.number(c) * self.one.basis(f"e{i + 1}") for i, c in enumerate(v))

    def translator(self, t: Any) -> Multivector:
        return 1 - self.vector(t) * self.null / 2

    def screw(self, angle: float, axis: Any, shift: Any, centre: Any) -> Multivector:
        """Rotation about an axis through a centre, plus any translation."""
        t = self.translator(centre)
        return t * (self.vector(axis) * self.i3 * self.number(-angle / 2)) * ~t - self.vector(shift) * self.null / 2

    def scaling(self, g: float, centre: Any) -> Multivector:
        t = self.translator(centre)
        return t * (self.null ^ self.one.basis("no")) * ~t * self.number(-g / 2)


@cache
def similarities() -> tuple[list[Any], Array]:
    """Every angle with every dilation, translations along and across the axis, centres near and far."""
    rng, space, cases, values = np.random.default_rng(7), Space(CGA), [], []
    for k, (angle, g) in enumerate(product(ANGLES, DILATIONS)):
        for j in (k % 4, (k + k // 4 + 1 + k % 3) % 4):
            shift = SHIFTS[j]
            axis = np.array([0.0, 0.0, 1.0]) if (j + k) % 3 == 0 else unit(rng.normal(size=3))
            across = unit(np.cross(axis, rng.normal(size=3)))
            distance = (0, 1, 1e3)[(k + 2 * j) % 3]
            centre = unit(rng.normal(size=3)) * distance
            b = space.screw(angle, axis, (axis, across)[(j + k) % 2] * shift, centre) + space.scaling(g, centre)
            cases.append((angle, g, shift, distance, axis.tolist()))
            values.append([float(v) for v in BIVECTOR.values(b)])
    return cases, np.array(values)


@pytest.fixture(scope="module")
def rotors() -> tuple[list[Any], Array, Array]:
    cases, b = similarities()
    return cases, b, compiled(invariant.exp_bivector, BIVECTOR)(b)


@pytest.mark.slow
def test_exp_of_similarities(rotors: tuple[list[Any], Array, Array]) -> None:
    cases, b, r = rotors
    errors = [series_error(BIVECTOR, x, EVEN, y) for x, y in zip(b[::5], r[::5], strict=True)]
    assert largest(errors, cases[::5]) < 8 * EPS


@pytest.mark.slow
def test_log_of_similarities(rotors: tuple[list[Any], Array, Array]) -> None:
    cases, _, r = rotors
    log, status = compiled(invariant.log_rotor, EVEN)(r)
    assert np.all(status == Status.OK)
    errors = [series_error(BIVECTOR, x, EVEN, y) for x, y in zip(log, r, strict=True)]
    assert largest(errors, cases) < ROUND_TRIP / 4


@pytest.mark.slow
def test_sqrt_of_similarities(rotors: tuple[list[Any], Array, Array]) -> None:
    cases, _, r = rotors
    root, status = compiled(invariant.sqrt_rotor, EVEN)(r)
    assert np.all(status == Status.OK)
    errors = [square_error(EVEN, x, y) for x, y in zip(root, r, strict=True)]
    assert largest(errors, cases) < ROUND_TRIP / 4


def test_logarithms_are_those_taken(rotors: tuple[list[Any], Array, Array]) -> None:
    """Where rounding R moves its planes little: log(exp(b)) is b itself, and not another logarithm."""
    cases, b, r = rotors
    log, _ = compiled(invariant.log_rotor, EVEN)(r)
    for (angle, g, shift, distance, _), own, found in zip(cases, b, log, strict=True):
        if angle <= math.pi + 1 and max(angle, g) >= 1e-3:
            assert np.abs(found - own).max() <= 1e-13 * max(np.abs(own).max(), distance * shift), (angle, g, shift)
        elif angle > math.pi + 1 and distance < 1e3 and shift < 1e3:
            rest = 2 * math.pi - angle  # a tilt of the axis by EPS/rest has a shift across, which counts 1/rest times
            allowed = 8 * EPS * (np.abs(own).max() / rest + shift / rest**2)
            assert np.abs(found - own).max() <= allowed, (angle, g, shift)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["cga3d", "pga3d"])
def test_round_trips_of_motors(name: str) -> None:
    """The same bar for the formulas of motors: their own, and shorter."""
    algebra = stock(name)
    motor, twist = algebra.kind("motor"), algebra.kind("twist")
    rng, space, cases, values = np.random.default_rng(8), Space(algebra), [], []
    for angle, shift in product(ANGLES, SHIFTS):
        distance = (0, 1, 1e3)[len(cases) % 3]
        axis = unit(rng.normal(size=3)) if len(cases) % 4 else np.array([0.0, 0.0, 1.0])
        centre = unit(rng.normal(size=3)) * distance
        values.append([float(v) for v in twist.values(space.screw(angle, axis, axis * shift, centre))])
        cases.append((angle, shift, distance))
    b = np.array(values)
    r, _ = on_numbers(exponentials.exp_bivector, twist, b, motor)
    log, status = on_numbers(exponentials.log_motor, motor, r, twist)
    root, root_status = on_numbers(exponentials.sqrt_motor, motor, r, motor)
    assert np.all(status == Status.OK) and np.all(root_status == Status.OK)
    for errors in (
        [series_error(twist, x, motor, y) for x, y in zip(b[::4], r[::4], strict=True)],
        [series_error(twist, x, motor, y) for x, y in zip(log, r, strict=True)],
        [square_error(motor, x, y) for x, y in zip(root, r, strict=True)],
    ):
        assert largest(errors, cases) < ROUND_TRIP / 4


@cache
def oblique() -> Array:
    """Bivectors with transversions: random ones, and hyperbolic, parabolic, elliptic ones in general position."""
    rng, space = np.random.default_rng(9), Space(CGA)
    simple = []
    for k in range(12):
        bend = 1 - space.vector(rng.normal(size=3)) * space.one.basis("no")
        versor = space.translator(rng.normal(size=3)) * bend
        inverse = ~versor
        seed = (space.scaling(1.5, [0, 0, 0]), space.screw(0, [0, 0, 1], [0.5, 1, 0], [0, 0, 0]))[k % 2]
        if k % 3 == 0:
            seed = seed + space.screw((0.3, 3.0, 6.0, 1e-9)[k // 3], [0, 0, 1], [0, 0, 0], [0, 0, 0])
        simple.append([float(v) for v in BIVECTOR.values(versor * seed * inverse)])
    return np.concatenate([rng.normal(size=(12, 10)), rng.normal(size=(3, 10)) * 1e-9, np.array(simple)])


@pytest.mark.slow
def test_rotors_in_general_position() -> None:
    b = oblique()
    r = compiled(invariant.exp_bivector, BIVECTOR)(b)
    errors = [series_error(BIVECTOR, x, EVEN, y) for x, y in zip(b, r, strict=True)]
    assert largest(errors, list(b)) < 64 * EPS
    allowed = 4 * ROUND_TRIP  # planes that are oblique by a factor of 25 cost as much
    log, status = compiled(invariant.log_rotor, EVEN)(r)
    root, _ = compiled(invariant.sqrt_rotor, EVEN)(r)
    assert np.all(status == Status.OK)
    assert largest([series_error(BIVECTOR, x, EVEN, y) for x, y in zip(log, r, strict=True)], list(b)) < allowed
    assert largest([square_error(EVEN, x, y) for x, y in zip(root, r, strict=True)], list(b)) < allowed


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


def test_what_is_no_rotor_is_invalid() -> None:
    r = compiled(invariant.exp_bivector, BIVECTOR)(oblique()[:12])
    bad = np.concatenate([2 * r, r + 1e-3, 0 * r, np.full((1, 16), np.nan), np.full((1, 16), np.inf)])
    for formula in (invariant.log_rotor, invariant.sqrt_rotor):
        value, status = compiled(formula, EVEN)(bad)
        assert np.all(status == Status.INVALID) and np.all(np.isnan(value).any(1))
        _, status = compiled(formula, EVEN)(r * (1 + 4e-16))
        assert np.all(status == Status.OK)


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


def test_single_precision() -> None:
    b = np.array([x for x, c in zip(similarities()[1], similarities()[0], strict=True) if c[3] < 1e3 and c[2] < 1e3])
    b = np.concatenate([b, oblique()[:12]]).astype(np.float32)
    r = compiled(invariant.exp_bivector, BIVECTOR).on("numpy")(b)
    assert r.dtype == np.float32
    log, status = compiled(invariant.log_rotor, EVEN).on("numpy")(r)
    answered = (status == Status.OK) | (status == Status.NOT_UNIQUE)
    assert answered.all() and log.dtype == np.float32
    exact, _ = on_numbers(invariant.exp_bivector, BIVECTOR, b.astype(float), EVEN)
    size = np.maximum(np.abs(b).max(1), np.abs(exact).max(1))
    assert np.max(np.abs(r - exact).max(1) / size) < 64 * np.finfo(np.float32).eps
    again, _ = on_numbers(invariant.exp_bivector, BIVECTOR, log.astype(float), EVEN)
    size = np.maximum(np.abs(log).max(1), np.abs(r).max(1))
    assert np.percentile(np.abs(again - r).max(1) / size, 99) < 64 * np.finfo(np.float32).eps


@pytest.mark.slow
@pytest.mark.parametrize("signature", [(3, 1), (1, 3), (4, 0), (0, 4), (4, 1), (1, 4), (5, 0), (2, 1), (1, 1), (2, 0)])
def test_other_signatures(signature: tuple[int, int]) -> None:
    algebra = orthonormal(*signature)
    add_plain_kinds(algebra)
    bivector, even = algebra.kind("bivector"), algebra.kind("even")
    b = np.random.default_rng(10).normal(size=(40, bivector.size))
    r, _ = on_numbers(invariant.exp_bivector, bivector, b, even)
    assert max(series_error(bivector, x, even, y) for x, y in zip(b[:8], r, strict=False)) < 32 * EPS
    log, status = on_numbers(invariant.log_rotor, even, r, bivector)
    root, _ = on_numbers(invariant.sqrt_rotor, even, r, even)
    assert np.all(status == Status.OK)
    again, _ = on_numbers(invariant.exp_bivector, bivector, log, even)
    size = np.maximum(np.abs(log).max(1), np.abs(r).max(1))[:, None]
    assert np.max(np.abs(again - r) / size) < 64 * ROUND_TRIP
    assert max(square_error(even, x, y) for x, y in zip(root, r, strict=True)) < ROUND_TRIP
    minus, codes = on_numbers(invariant.log_rotor, even, -np.eye(1, even.size), bivector)
    has_plane = max(signature) > 1
    assert codes[0] == (Status.NOT_UNIQUE if has_plane else Status.SINGULAR)
    if has_plane:
        again, _ = on_numbers(invariant.exp_bivector, bivector, minus, even)
        assert np.allclose(again, -np.eye(1, even.size), atol=1e-15)


def test_negative_translations_of_the_plane_have_no_logarithm() -> None:
    algebra = stock("cga2d")
    even, bivector = algebra.kind("even"), algebra.kind("bivector")
    one = from_values(algebra, PRECISE, (0,), [PRECISE.context.mpf(1)])
    shift = -(1 - one.basis("e1ni") / 2)
    bend = 1 + one.basis("e2no") / 3
    r = np.array([[float(v) for v in even.values(x)] for x in (shift, bend * shift * ~bend)])
    log, status = on_numbers(invariant.log_rotor, even, r, bivector)
    assert np.all(status == Status.SINGULAR) and np.all(np.isnan(log).any(1))


def test_signatures_that_do_not_decompose_are_refused() -> None:
    for signature in ((2, 2), (3, 2), (6, 0)):
        algebra = orthonormal(*signature)
        add_plain_kinds(algebra)
        with pytest.raises(GradeError, match="simple"):
            invariant.exp_bivector(multivector(algebra.kind("bivector"), np.ones(algebra.kind("bivector").size)))


numbers = st.floats(-3, 3).filter(lambda x: x == 0 or abs(x) > 1e-6)


@pytest.mark.slow
@settings(max_examples=60, deadline=None)
@given(st.lists(numbers, min_size=10, max_size=10))
def test_logarithms_of_small_bivectors_are_the_bivectors(coefficients: list[float]) -> None:
    """Below half a turn in all there is one logarithm near 1."""
    b = np.array(coefficients) / max(1.0, float(np.abs(coefficients).sum()))
    r, _ = on_numbers(invariant.exp_bivector, BIVECTOR, b, EVEN)
    log, status = on_numbers(invariant.log_rotor, EVEN, r, BIVECTOR)
    assert status == Status.OK
    assert np.allclose(log, b, rtol=0, atol=1e-14)


# -- at run time -------------------------------------------------------------------------------------------


def test_kinds_of_results() -> None:
    cga = bs.cga3d
    dilator, transversor = cga.dilator(2.0), cga.transversor([1.0, 2.0, 3.0])
    rotor = cga.translator([1.0, 2.0, 3.0]) * cga.rotor([0.0, 0.0, 1.0], 0.5) * dilator
    for x, name in ((dilator, "dilator"), (transversor, "transversor"), (rotor, "rotor_conformal")):
        assert x.kind.name == name
        assert x.sqrt().kind == x.kind and x.log().exp().kind == x.kind
        assert (x.sqrt() * x.sqrt()).isclose(x, rtol=1e-14) and x.log().exp().isclose(x, rtol=1e-14)
    assert dilator.log().blades == cga.noni.blades
    assert (-dilator).log().status is Status.SINGULAR
    assert (-rotor).log().exp().isclose(-rotor, rtol=1e-13)


def test_algebras_without_a_closed_form() -> None:
    wide = bs.algebra(2, 2)
    b = wide.multivector(np.random.default_rng(1).normal(size=(3, 6)), grades=[2])
    r = b.exp()
    assert (r * ~r).isclose(wide.scalar(np.ones(3)), rtol=1e-12).all()
    with pytest.raises(bs.errors.NotARotorError):
        r.log()
