"""Projection, interpolation, its rate, averages and orientation, against 50 digits and against geometry."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from bladesmith import Multivector, Status, cga2d, errors, objects
from bladesmith import cga3d as cga
from bladesmith.codegen.algebra.multivector import Multivector as Symbolic
from bladesmith.codegen.algebra.multivector import from_values
from bladesmith.codegen.rings.protocol import PrecisionRing

from ...support.formulas import stock

Array = Any
CGA = stock("cga3d")
DIGITS = 80
RING = PrecisionRing(DIGITS)
MP = RING.context
KINDS = ("point_pair", "line", "circle", "plane", "sphere")
COUNT = 40
FAR = np.array([1e6, -6e5, 3e5])


def drawn(kind: str, count: int, seed: int, at: Any = 0.0) -> Multivector:
    """Random objects of a kind, from Euclidean numbers."""
    rng = np.random.default_rng(seed)
    c, n = rng.normal(size=(count, 3)) + at, rng.normal(size=(count, 3))
    n /= np.linalg.norm(n, axis=-1, keepdims=True)
    r = rng.uniform(0.4, 2, count)
    made: Multivector = {
        "point": lambda: cga.point(c),
        "point_pair": lambda: cga.point_pair(c - n * r[:, None], c + n * r[:, None]),
        "line": lambda: cga.line(c, n),
        "circle": lambda: cga.circle(c, n, r),
        "plane": lambda: cga.plane(n, (n * c).sum(-1)),
        "sphere": lambda: cga.sphere(c, r),
    }[kind]()
    return made


# -- 80 digits ---------------------------------------------------------------------------------------------


def exact(x: Multivector, i: int) -> Symbolic:
    """Item i with mpmath numbers."""
    return from_values(CGA, RING, x.kind.blades, [MP.mpf(float(v)) for v in x.values[i]])


def number(x: Symbolic) -> Any:
    return x.terms.get(0, MP.mpf(0))


def split(x: Symbolic) -> Symbolic:
    """The projection by another road: x = X1 + X2 with commuting blades of squares a > b; X1/sqrt(a).

    sigma x = (a + b) x + 2 (b X1 + a X2), so X1 = (2 a x - sigma4 x)/(2 (a - b)).
    """
    sigma = -(x * ~x)
    s0, s4 = number(sigma), sigma.grade(4)
    k = number((s4 * s4).grade(0))
    gap = MP.sqrt(s0 * s0 - k)
    a, b = (s0 + gap) / 2, (s0 - gap) / 2
    if not s4.terms or a == b:  # a plane or a sphere: one blade
        return x * x.new({0: 1 / MP.sqrt(s0)})
    scale = 1 / (2 * (a - b) * MP.sqrt(a))
    return (x * x.new({0: 2 * a}) - (s4 * x).grade(*x.grades)) * x.new({0: scale})


def values(x: Symbolic, like: Multivector) -> Array:
    return np.array([float(x.terms.get(int(b), 0)) for b in like.blades])


def relative(found: Multivector, expected: Array) -> Array:
    """Largest difference of each item, on the scale of its largest coefficient."""
    return np.abs(found.values - expected).max(-1) / np.abs(expected).max(-1)


@pytest.mark.parametrize("kind", KINDS)
def test_projection_against_many_digits(kind: str) -> None:
    """Also where Sigma0 < 0; the items without an answer are those with a <= 0."""
    a, b = drawn(kind, COUNT, 1), drawn(kind, COUNT, 2)
    total = 0.6 * a + 0.9 * b
    found = objects.project_to_blade(total)
    assert found.kind == cga.kind(kind) and found.shape == (COUNT,)
    negative = 0
    for i in range(COUNT):
        x = exact(total, i)
        sigma = -(x * ~x)
        s0 = number(sigma)
        real = s0 > 0 or bool(sigma.grade(4).terms and number((sigma.grade(4) * sigma.grade(4)).grade(0)) < 0)
        assert found.status[i] == (Status.OK if real else Status.IMAGINARY)
        if real:
            negative += s0 < 0
            expected = values(split(x), found)
            assert np.abs(found.values[i] - expected).max() <= 1e-12 * np.abs(expected).max()
        else:
            assert np.isnan(found.values[i]).all()
    assert negative > 2 or kind not in ("point_pair", "circle")


@pytest.mark.parametrize("kind", KINDS)
def test_rate_against_many_digits(kind: str) -> None:
    """Central differences of the other road at 80 digits."""
    a, b = drawn(kind, COUNT, 3), drawn(kind, COUNT, 4)
    alpha = np.linspace(0.1, 0.9, COUNT)
    value = objects.interpolate(a, b, alpha=alpha)
    rate = objects.interpolate_derivative(a, b, alpha=alpha)
    assert np.array_equal(rate.status, value.status) and rate.kind.is_layout
    h, negative = MP.mpf(10) ** -20, 0
    for i in range(COUNT):
        if value.status[i] != Status.OK:
            assert np.isnan(rate.values[i]).all()
            continue
        x, y, t = exact(a, i), exact(b, i), MP.mpf(float(alpha[i]))
        sides = [split(x * x.new({0: t + s}) + y * y.new({0: 1 - t - s})) for s in (h, -h)]
        difference = (sides[0] - sides[1]) * x.new({0: 1 / (2 * h)})
        expected = values(difference, rate)
        z = x * x.new({0: t}) + y * y.new({0: 1 - t})
        negative += number(-(z * ~z)) < 0
        assert np.abs(rate.values[i] - expected).max() <= 1e-12 * np.abs(expected).max()
    assert negative > 2 or kind not in ("point_pair", "circle")


def closed_form(x: Symbolic, dx: Symbolic, sign: int = -1) -> Symbolic:
    """(4.26) to (4.30) with the tilde in Sigma; ``sign`` -1: the derivative of the inverse as it is, +1: as printed."""
    sigma = -(x * ~x)
    rate = -(dx * ~x + x * ~dx)

    def scalar(value: Any) -> Symbolic:
        return x.new({0: value})

    s0, r0 = number(sigma), number(rate)
    k, rk = number((sigma.grade(4) * sigma.grade(4)).grade(0)), number((sigma.grade(4) * rate.grade(4)).grade(0))
    norm = MP.sqrt(s0 * s0 - k)
    d_norm = (s0 * r0 - rk) / norm  # (4.28)
    inverse = 1 / MP.sqrt(2 * (s0 + norm))
    d_inverse = -(r0 + d_norm) * inverse / (2 * (s0 + norm))
    root = (sigma + scalar(norm)) * scalar(inverse)
    d_root = (rate + scalar(d_norm)) * scalar(inverse) + (sigma + scalar(norm)) * scalar(d_inverse)  # (4.29)
    conjugate, d_conjugate = root.grade(0) - root.grade(4), d_root.grade(0) - d_root.grade(4)
    product = number((conjugate * root).grade(0))
    d_product = number((d_conjugate * root + conjugate * d_root).grade(0))
    d_projector = d_conjugate * scalar(1 / product) + conjugate * scalar(sign * d_product / product**2)  # (4.30)
    return d_projector * x + conjugate * scalar(1 / product) * dx  # (4.26)


@pytest.mark.parametrize("kind", ["point_pair", "circle"])
def test_rate_against_the_corrected_closed_form(kind: str) -> None:
    """The closed form with its minus sign agrees; as printed it does not. Sigma0 < 0 needs 80 digits there."""
    a, b = drawn(kind, 20, 5), drawn(kind, 20, 6)
    rate = objects.interpolate_derivative(a, b, alpha=0.35)
    wrong = []
    for i in range(20):
        x, y = exact(a, i), exact(b, i)
        t = MP.mpf(0.35)
        z, dz = x * x.new({0: t}) + y * y.new({0: 1 - t}), x - y
        expected = values(closed_form(z, dz).grade(*x.grades), rate)
        assert np.abs(rate.values[i] - expected).max() <= 1e-12 * np.abs(expected).max()
        printed = values(closed_form(z, dz, +1).grade(*x.grades), rate)
        wrong.append(np.abs(printed - expected).max() / np.abs(expected).max())
    assert np.median(wrong) > 0.1


def test_directional_rate_of_the_projector() -> None:
    """`blades.project_rate` along any trivector; and the derivative of an average as a sum of them."""
    from bladesmith.dispatch.formulas import evaluate

    rng = np.random.default_rng(7)
    x = drawn("circle", 20, 8) + cga.multivector(0.3 * rng.normal(size=(20, 10)), grades=[3])
    direction = cga.multivector(rng.normal(size=(20, 10)), grades=[3])
    outcome = evaluate(cga, "blades.project_rate", x, direction)
    assert np.array_equal(outcome.status, objects.project_to_blade(x).status)
    h = MP.mpf(10) ** -20
    for i in np.flatnonzero(outcome.status == Status.OK):
        z, dz = exact(x, i), exact(direction, i)
        difference = (split(z + dz * z.new({0: h})) - split(z - dz * z.new({0: h}))) * z.new({0: 1 / (2 * h)})
        expected = values(difference, outcome.value)
        assert np.abs(outcome.value.values[i] - expected).max() <= 1e-12 * np.abs(expected).max()


@pytest.mark.compiles
@pytest.mark.parametrize("kind", ["line", "circle", "sphere"])
def test_single_precision(kind: str) -> None:
    a, b = drawn(kind, 50, 9), drawn(kind, 50, 10)
    single = [x.astype(np.float32) for x in (a, b)]
    for function in (objects.interpolate, objects.interpolate_derivative):
        found, expected = function(*single, alpha=0.3), function(a, b, alpha=0.3)
        assert found.dtype == np.float32
        both = (found.status == Status.OK) & (expected.status == Status.OK)
        assert both.sum() >= 0.9 * (expected.status == Status.OK).sum()
        assert np.median(relative(found[both], expected[both].values)) < 1e-6
    far = drawn(kind, 50, 9, 1e3).astype(np.float32)
    for found in (objects.average(far), objects.interpolate(far, far, alpha=0.3), objects.project_to_blade(far)):
        assert found.dtype == np.float32
    assert objects.average(single[0], np.arange(50.0)).dtype == np.float32


def test_in_the_plane() -> None:
    """Circles of the plane blend as spheres do: with points on a line, radii by the weights of their points."""
    one, two = cga2d.circle([0.0, 0.0], 1.0), cga2d.circle([1.0, 0.0], 2.0)
    found = objects.interpolate(one, two, alpha=0.5)
    w = 1.0 / 1.5
    assert np.allclose(found.parameters().center, [1 - w, 0], atol=1e-14)
    assert np.isclose(found.parameters().radius, np.sqrt(w + (1 - w) * 4 - w * (1 - w)))
    far = cga2d.circle([[1e6, 1e6], [1e6 + 1, 1e6]], [1.0, 2.0])
    for far_found in (objects.interpolate(far[0], far[1], alpha=0.5), objects.average(far)):
        assert np.allclose(far_found.parameters().center - 1e6, [1 - w, 0], atol=1e-9)


# -- geometry ----------------------------------------------------------------------------------------------


def test_concentric_circles_meet_at_the_geometric_mean() -> None:
    r = np.array([[1.0, 4.0], [0.25, 9.0], [3.0, 3.0]])
    c, n = np.array([1.0, -2.0, 0.5]), np.array([1.0, 2.0, 2.0]) / 3
    found = objects.interpolate(cga.circle(c, n, r[:, 0]), cga.circle(c, n, r[:, 1]), alpha=0.5).parameters()
    assert np.allclose(found.radius, np.sqrt(r[:, 0] * r[:, 1]), rtol=1e-14)
    assert np.allclose(found.center, c, atol=1e-14) and np.allclose(found.normal, n, atol=1e-14)


def test_spheres_by_the_weights_of_their_points() -> None:
    """Radii as in 3.11 with w = (a/r1)/(a/r1 + b/r2) for alpha: imaginary where the square is negative."""
    a, b = drawn("sphere", 200, 11), drawn("sphere", 200, 12)
    p, q = a.parameters(), b.parameters()
    alpha = 0.3
    w = alpha / p.radius / (alpha / p.radius + (1 - alpha) / q.radius)
    gap = ((p.center - q.center) ** 2).sum(-1)
    square = w * p.radius**2 + (1 - w) * q.radius**2 - w * (1 - w) * gap
    found = objects.interpolate(a, b, alpha=alpha)
    assert np.array_equal(found.status == Status.OK, square > 0) and np.array_equal(
        found.status == Status.IMAGINARY, square < 0
    )
    good = square > 1e-3
    centers = w[:, None] * p.center + (1 - w[:, None]) * q.center
    assert np.allclose(found[good].parameters().center, centers[good], atol=1e-12)
    assert np.allclose(found[good].parameters().radius, np.sqrt(square[good]), rtol=1e-11)


def test_separate_spheres_are_mostly_imaginary_half_way() -> None:
    """Outward spheres apart from each other: about seven in ten have no real half-way sphere; aligned ones all do."""
    rng = np.random.default_rng(13)
    c, r = rng.normal(size=(2, 4000, 3)) * 2, rng.uniform(0.1, 1, (2, 4000))
    apart = np.linalg.norm(c[0] - c[1], axis=-1) > r.sum(0)
    a, b = (cga.sphere(c[i][apart], r[i][apart]) for i in range(2))
    found = objects.interpolate(a, b, alpha=0.5)
    assert 0.5 < np.mean(found.status == Status.IMAGINARY) <= 1
    assert np.all(np.isnan(found.values[found.status == Status.IMAGINARY]))
    assert np.all(objects.interpolate(a, b, alpha=0.5, align=True).status == Status.OK)


def test_planes_interpolate_the_dual() -> None:
    """Normal a n1 + b n2, and the offset a d1 + b d2 divided by its length."""
    a, b = drawn("plane", 50, 14), drawn("plane", 50, 15)
    p, q = a.parameters(), b.parameters()
    m = 0.3 * p.normal + 0.7 * q.normal
    size = np.linalg.norm(m, axis=-1)
    found = objects.interpolate(a, b, alpha=0.3).parameters()
    assert np.allclose(found.normal, m / size[:, None], atol=1e-13)
    assert np.allclose(found.offset, (0.3 * p.offset + 0.7 * q.offset) / size, atol=1e-12)


def test_lines_take_the_axis_of_the_screw() -> None:
    """At (b^2 + a b c)/(a^2 + b^2 + 2 a b c) of the common perpendicular, along a m1 + b m2."""
    x, y = drawn("line", 50, 16), drawn("line", 50, 17)
    p, q = x.parameters(), y.parameters()
    n = np.cross(p.direction, q.direction)
    system = np.stack([p.direction, -q.direction, n], -1)
    s = np.linalg.solve(system, (q.point - p.point)[..., None])[..., 0]
    feet = p.point + s[:, :1] * p.direction, q.point + s[:, 1:2] * q.direction
    a, b = 0.3, 0.7
    c = (p.direction * q.direction).sum(-1)
    fraction = ((b * b + a * b * c) / (a * a + b * b + 2 * a * b * c))[:, None]
    through = (1 - fraction) * feet[0] + fraction * feet[1]
    m = a * p.direction + b * q.direction
    expected = cga.line(through, m)
    assert np.allclose(objects.interpolate(x, y, alpha=a).values, expected.values, atol=1e-10)


def test_points_go_straight() -> None:
    a, b = drawn("point", 20, 18), drawn("point", 20, 19)
    p, q = a.parameters().xyz, b.parameters().xyz
    for method in ("direct", "rotor"):
        found = objects.interpolate(a, b, alpha=0.3, method=method)
        assert found.kind == cga.kind("point") and np.allclose(found.parameters().xyz, 0.3 * p + 0.7 * q, atol=1e-14)
    rate = objects.interpolate_derivative(a, b, alpha=0.3)
    assert np.allclose(rate.values[:, :3], p - q, atol=1e-14)
    w = np.random.default_rng(20).uniform(0, 1, 20)
    assert np.allclose(objects.average(a, w).parameters().xyz, np.average(p, 0, w), atol=1e-14)
    assert np.allclose(objects.average(a).parameters().xyz, p.mean(0), atol=1e-14)


@pytest.mark.parametrize("kind", ["line", "circle"])
def test_the_rotors_way(kind: str) -> None:
    """The ends are met; the way is that of the group: a quarter of it four times is all of it."""
    a, b = drawn(kind, 20, 21), drawn(kind, 20, 22)
    way = objects.interpolate(a, b[:, None], alpha=np.ones(20), method="rotor")
    assert way.shape == (20, 20)
    ends = [objects.interpolate(a, b, alpha=t, method="rotor") for t in (1.0, 0.0)]
    assert ends[0].kind == a.kind and ends[0].isclose(a).all() and ends[1].isclose(b).all()
    step = objects.interpolate(a, b, alpha=0.75, method="rotor")
    rotor = objects.rotor_between(a, step)
    assert (rotor >> (rotor >> (rotor >> step))).isclose(b, 1e-8).all()


def test_mixed_flats_and_rounds() -> None:
    """A line is a circle of no curvature: the interpolant of the two has half the curvature vector."""
    circle, line = cga.circle([0, 0, 0], [0, 0, 1], 2.0), cga.line([2, 0, 0], [0, 1, 0])
    found = objects.interpolate(circle, line, alpha=0.5)
    assert found.kind == cga.kind("circle") and found.status == Status.OK
    p = found.parameters()  # they touch, with the same direction: so does this
    assert np.allclose(p.center, [-2, 0, 0], atol=1e-12) and np.isclose(p.radius, 4.0)
    many = objects.average([circle, line, circle])
    assert many.shape == () and many.status == Status.OK


def test_extrapolation() -> None:
    a, b = drawn("line", 5, 23), drawn("line", 5, 24)
    beyond = objects.interpolate(a, b, alpha=1.5)
    assert np.allclose(beyond.values, objects.project_to_blade(1.5 * a - 0.5 * b).values, atol=1e-13)


# -- far away ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", ["point", *KINDS])
def test_far_from_the_origin(kind: str) -> None:
    """Built from parameters at 1e6, interpolants, means and rates keep 1e-9 of the objects' own size.

    Positions are multiples of 2^-20, so that they are the same near and far.
    """
    rng = np.random.default_rng(25)
    c, d = (np.round(rng.uniform(-1, 1, (2, 40, 3)) * 2**20) / 2**20), rng.normal(size=(2, 40, 3))
    d /= np.linalg.norm(d, axis=-1, keepdims=True)
    r = rng.uniform(0.7, 1.4, (2, 40))
    made = {
        "point": lambda i, o: cga.point(c[i] + o),
        "point_pair": lambda i, o: cga.point_pair(c[i] + o, c[i] + np.array([1.0, 0.5, 0]) + o),
        "line": lambda i, o: cga.line(c[i] + o, d[i]),
        "circle": lambda i, o: cga.circle(c[i] + o, d[i], r[i]),
        "plane": lambda i, o: cga.plane(d[i], (d[i] * (c[i] + o)).sum(-1)),
        "sphere": lambda i, o: cga.sphere(c[i] / 4 + o, r[i]),
    }[kind]
    for compute in (
        lambda i, o: objects.interpolate(made(0, o), made(1, o), alpha=0.4),
        lambda i, o: objects.average([made(0, o), made(1, o)], align=True),
    ):
        near, far = compute(0, 0.0), compute(0, FAR)
        assert np.array_equal(near.status, far.status) and np.all(near.status == Status.OK)
        if kind in ("line", "plane"):  # read at the local origin
            far = cga.translator(-FAR) >> far
            assert np.abs(far.values - near.values).max() < 2e-9
            continue
        for name, one, other in zip(near.parameters()._fields, near.parameters(), far.parameters(), strict=True):
            shift = FAR if name in ("xyz", "a", "b", "center") else 0.0
            assert np.abs(other - shift - one).max() < 4e-9, name
    slope = objects.interpolate_derivative(made(0, FAR), made(1, FAR), alpha=0.4)
    assert np.allclose(
        (cga.translator(-FAR) >> slope).values[..., 0],
        objects.interpolate_derivative(made(0, 0.0), made(1, 0.0), alpha=0.4).values[..., 0],
        atol=1e-3,
    )


def test_far_sums_keep_the_digits_that_they_have() -> None:
    """A sum of coefficients of size c^2/r knows radii to (c/r)^2 rounding units; no more is lost."""
    for kind in ("circle", "sphere", "point_pair", "line", "point"):
        near, far = drawn(kind, 20, 36), drawn(kind, 20, 36, FAR / 10)
        found = objects.project_to_blade(2.0 * far)
        assert np.all(found.status == Status.OK) and found.kind == near.kind
        if kind in ("circle", "sphere"):
            assert np.allclose(found.parameters().radius, near.parameters().radius, rtol=1e-4)
        expected = far.values / np.abs(far.values).max(-1, keepdims=True)
        assert np.abs(found.values / np.abs(found.values).max(-1, keepdims=True) - expected).max() < 1e-5


def test_frames_are_made_only_where_they_gain() -> None:
    from bladesmith.objects.rotors import local_origin

    near, far = drawn("circle", 10, 26), drawn("circle", 10, 26, FAR)
    assert local_origin.frame(near) is None
    frame = local_origin.frame(far)
    assert frame is not None and np.abs(frame.origin - FAR).max() < 10
    seen = frame.to_local(far)
    assert seen.kind == far.kind and np.abs(seen.values).max() < 100
    assert np.allclose(frame.to_world(seen).parameters().radius, near.parameters().radius, rtol=1e-12)
    both = local_origin.frame(far, shared=True)
    assert both is not None and both.origin.shape == (3,)
    mixed = objects.average([far[0], cga.line(FAR, [1, 2, 3])])  # a round and a flat share the local origin
    expected = objects.average([near[0], cga.line([0, 0, 0], [1, 2, 3])])
    assert np.allclose(mixed.parameters().center - FAR, expected.parameters().center, atol=1e-8)


# -- statuses and bad input --------------------------------------------------------------------------------


def test_what_cancels_is_singular() -> None:
    for kind in KINDS:
        x = drawn(kind, 3, 27)
        found = objects.interpolate(x, -1 * x, alpha=0.5)
        assert np.all(found.status == Status.SINGULAR) and np.isnan(found.values).all()
        assert np.all(objects.interpolate_derivative(x, -1 * x, alpha=0.5).status == Status.SINGULAR)
        with pytest.raises(errors.SingularError, match="item 0 is SINGULAR"):
            objects.interpolate(x, -1 * x, alpha=0.5, strict=True)
        assert objects.interpolate(x, -1 * x, alpha=0.5, align=True).isclose(x).all()
    # opposite and apart: only a line at infinity is left
    parallel = objects.interpolate(cga.line([0, 0, 0], [0, 0, 1]), cga.line([1, 0, 0], [0, 0, -1]), alpha=0.5)
    assert parallel.status == Status.SINGULAR
    # nearly opposite is no noise: the answer has the digits that are left
    tilted = objects.interpolate(cga.line([0, 0, 0], [1, 0, 0]), cga.line([0, 0, 0], [-1, 1e-10, 0]), alpha=0.5)
    assert tilted.status == Status.OK and np.allclose(tilted.parameters().direction, [0, 1, 0], atol=1e-5)


def test_noise_in_the_quadrivector_is_no_real_root() -> None:
    """Circles on a common sphere have an S4 of rounding noise: where Sigma0 < 0 the interpolant is imaginary."""
    rng = np.random.default_rng(28)
    n = rng.normal(size=(2, 500, 3))
    n /= np.linalg.norm(n, axis=-1, keepdims=True)
    c, h = rng.normal(size=(500, 3)), rng.uniform(-0.9, 0.9, (2, 500))
    a, b = (cga.circle(c + h[i][:, None] * n[i], n[i], np.sqrt(1 - h[i] ** 2)) for i in range(2))
    x = 0.5 * a + 0.5 * b
    square = (x * x)["1"]
    status = objects.interpolate(a, b, alpha=0.5).status
    sure = np.abs(square) > 1e-9
    assert np.array_equal((status == Status.IMAGINARY)[sure], (square < 0)[sure]) and (square < 0).sum() > 5
    assert np.array_equal((status == Status.OK)[sure], (square > 0)[sure])


def test_bad_items_keep_their_reasons() -> None:
    a, b = drawn("sphere", 4, 29), cga.sphere(np.zeros((4, 3)), np.array([1.0, -1.0, 1.0, 1.0]))
    found = objects.interpolate(a, b, alpha=np.array([0.9, 0.9, np.nan, 0.9]))
    assert list(found.status) == [Status.OK, Status.INVALID, Status.INVALID, Status.OK]
    assert np.isnan(found.values[1:3]).all()
    assert objects.average(b).status == Status.INVALID
    x = cga.multivector(np.full((2, 10), [[np.nan], [1.0]]), grades=[3])
    assert objects.project_to_blade(x).status[0] == Status.INVALID


@pytest.mark.compiles
def test_averages() -> None:
    """Any axis, weights, and alignment to the first object."""
    lines = cga.line(np.random.default_rng(30).normal(size=(6, 4, 3)) * 0.1, [0.0, 0.0, 1.0])
    flipped = np.random.default_rng(31).random((6, 4)) < 0.5
    mixed = np.where(flipped, -1.0, 1.0) * lines
    for axis in (0, 1, -1):
        plain = objects.average(lines, axis=axis)
        assert plain.shape == ((4,) if axis == 0 else (6,)) and plain.kind == cga.kind("line")
        aligned = objects.average(mixed, axis=axis, align=True)
        same = aligned.values * np.sign(aligned.values[..., -1:]) * np.sign(plain.values[..., -1:])
        assert np.allclose(same, plain.values, atol=1e-13)
    w = np.arange(1.0, 7)
    weighted = objects.average(lines, w)
    assert np.allclose(weighted.values, objects.average(lines, 5 * w).values, atol=1e-14)
    assert np.allclose(weighted.values, objects.average(lines, np.repeat(w[:, None], 4, 1)).values, atol=1e-14)
    assert np.allclose(
        weighted.values,
        objects.project_to_blade(cga.line(np.einsum("i,ijk->jk", w, lines.parameters().point) / 21, [0, 0, 1])).values,
        atol=1e-13,
    )
    single = objects.average(lines.astype(np.float32), w)
    assert single.dtype == np.float32 or single.dtype == np.float64
    assert np.allclose(single.values, weighted.values, atol=1e-5)
    assert objects.average(cga.line(np.zeros((3, 0, 3)), np.ones((3, 0, 3)))).shape == (0,)


def test_align() -> None:
    lines = cga.line([0, 0, 0], np.array([[1.0, 0, 0], [-1, 0.1, 0], [0, 1, 0], [1, 1, 1]]))
    aligned, flipped = objects.align(lines)
    assert list(flipped) == [False, True, False, False]  # the tie keeps its sign
    assert np.allclose(aligned.parameters().direction[1], -lines.parameters().direction[1])
    _, flipped = objects.align(lines, cga.line([5, 5, 5], [-1, -1, 0]))
    assert list(flipped) == [True, False, True, True]
    _, flipped = objects.align(drawn("point", 3, 32))
    assert not flipped.any()
    apart = cga.sphere([[0, 0, 0], [3, 0, 0], [0.5, 0, 0]], 1.0)
    assert list(objects.align(apart)[1]) == [False, True, False]
    aligned, flipped = objects.align(lines[:0])
    assert aligned.shape == flipped.shape == (0,)


def test_shapes() -> None:
    a, b = drawn("circle", 3, 33), drawn("circle", 4, 34)
    assert objects.interpolate(a[:, None], b, alpha=0.5).shape == (3, 4)
    assert objects.interpolate(a[0], b[0], alpha=np.linspace(0, 1, 7)).shape == (7,)
    assert objects.interpolate(a[:0], b[0], alpha=0.5).shape == (0,)
    assert objects.project_to_blade(a[0]).shape == () and objects.project_to_blade(a[0]).status == Status.OK


def test_bad_calls() -> None:
    line, point = cga.line([0, 0, 0], [1, 0, 0]), cga.point([0, 0, 0])
    two = [line, line]
    for call, error, words in (
        (lambda: objects.average([]), errors.InputError, "empty"),
        (lambda: objects.average(drawn("line", 2, 1)[:0]), errors.InputError, "no objects"),
        (lambda: objects.average(line), errors.InputError, "single"),
        (lambda: objects.average(two, axis=1), errors.InputError, "axis 1"),
        (lambda: objects.average(two, [1.0, -1.0]), errors.InputError, "sum to zero"),
        (lambda: objects.average(two, [1.0, np.nan]), errors.InputError, r"weights\[1\] is nan"),
        (lambda: objects.average(two, [1.0, 1.0, 1.0]), errors.ShapeError, "weights"),
        (lambda: objects.interpolate(line, point, alpha=0.5), errors.GradeError, "grade"),
        (lambda: objects.interpolate(line, 3.0, alpha=0.5), errors.InputError, "multivector"),
        (lambda: objects.interpolate(line, line, alpha="x"), errors.InputError, "alpha"),
        (lambda: objects.interpolate(line, line, alpha=0.5, method="rotors"), errors.InputError, "did you mean"),
        (lambda: objects.interpolate(drawn("line", 3, 1), line, alpha=np.ones(2)), errors.ShapeError, "alpha"),
        (lambda: objects.project_to_blade(cga.translator([1, 2, 3])), errors.GradeError, "one grade"),
        (lambda: objects.project_to_blade(3.0), errors.InputError, "multivector"),
        (lambda: objects.align(line, point), errors.GradeError, "grade"),
        (lambda: objects.common_sphere(point, point), errors.GradeError, "grade"),
        (lambda: objects.orthogonal_sphere(*[drawn("point_pair", 1, 1)] * 2), errors.GradeError, "grade"),
    ):
        with pytest.raises(error, match=words):
            call()


# -- spheres of two circles --------------------------------------------------------------------------------


def test_common_spheres() -> None:
    circle = cga.circle([1, 2, 3], [0, 1, 1], 2.0)
    for again in (circle, -1 * circle):  # the great sphere
        found = objects.common_sphere(circle, again)
        assert found.status == Status.NOT_UNIQUE
        assert np.allclose(found.parameters().center, [1, 2, 3]) and np.isclose(found.parameters().radius, 2)
    coplanar = cga.circle([2, 2, 3], [0, -1, -1], 1.0)
    plane = objects.common_sphere(circle, coplanar)
    assert plane.status == Status.OK and cga.classify(plane) == "plane"
    assert np.allclose(plane.as_kind("plane").parameters().normal, np.array([0, 1, 1]) / np.sqrt(2))
    assert np.isclose(plane.as_kind("plane").parameters().offset, 5 / np.sqrt(2))
    x_axis = cga.line([0, 0, 1], [1, 0, 0])
    crossed = objects.common_sphere(x_axis, cga.line([0, 0, 1], [0, 1, 0]))
    assert crossed.kind == cga.kind("plane") and np.allclose(np.abs(crossed.parameters().normal), [0, 0, 1])
    assert objects.common_sphere(x_axis, x_axis).status == Status.SINGULAR
    assert objects.common_sphere(x_axis, cga.line([0, 0, 2], [0, 1, 0])).status == Status.SINGULAR
    assert objects.common_sphere(circle, cga.circle([5, 0, 0], [1, 0, 0], 1.0)).status == Status.SINGULAR
    chords = cga.point_pair([1, 0, 0], [0, 1, 0]), cga.point_pair([-1, 0, 0], [0, -1, 0])
    assert objects.common_sphere(*chords).status == Status.SINGULAR


@pytest.mark.parametrize(("at", "scale"), [(0.0, 1e-6), (0.0, 1.0), (0.0, 1e5), (FAR, 1.0), (FAR, 100.0)])
def test_common_spheres_at_every_scale(at: Any, scale: float) -> None:
    rng = np.random.default_rng(35)
    n = rng.normal(size=(2, 200, 3))
    n /= np.linalg.norm(n, axis=-1, keepdims=True)
    c, radius = rng.normal(size=(200, 3)) * scale, rng.uniform(0.5, 2, 200) * scale
    h = rng.uniform(-0.8, 0.8, (2, 200)) * radius
    a, b = (cga.circle(c + at + h[i][:, None] * n[i], n[i], np.sqrt(radius**2 - h[i] ** 2)) for i in range(2))
    found = objects.common_sphere(a, b)
    assert np.all(found.status == Status.OK) and np.all(found.parameters().orientation == 1)
    limit = (1e-8 if np.ndim(at) else 1e-11) * max(scale, 1.0 if np.ndim(at) else 0.0)
    assert np.median(np.abs(found.parameters().center - c - at)) < limit
    assert np.median(np.abs(found.parameters().radius - radius)) < limit
    assert np.all(objects.orthogonal_sphere(a, b).status == Status.SINGULAR)


def test_orthogonal_spheres() -> None:
    ring = cga.circle([0, 0, 0], [0, 0, 1], 1.0)
    assert objects.orthogonal_sphere(ring, cga.circle([1, 0, 0], [0, 1, 0], 1.0)).status == Status.IMAGINARY
    assert objects.orthogonal_sphere(ring, cga.line([0.2, 0, 0], [0.1, 0, 1])).status == Status.IMAGINARY
    assert objects.orthogonal_sphere(ring, cga.circle([2, 0, 0], [0, 1, 0], 1.0)).status == Status.SINGULAR  # touching
    found = objects.orthogonal_sphere(ring, cga.circle([3, 0, 0], [0, 1, 1], 1.0))
    p = found.parameters()
    assert np.allclose(p.center, [1.5, 0, 0], atol=1e-14) and np.isclose(p.radius, np.sqrt(1.25))
    assert found.kind == cga.kind("sphere") and p.orientation == 1


@pytest.mark.parametrize(("distance", "radius"), [(30, 0.01), (1e3, 1.0), (1e5, 5.0)])
def test_imaginary_interpolants_far_away_are_no_noise(distance: float, radius: float) -> None:
    """Circles on a sphere, disjoint and opposed: their places are rounded, and that makes no real circle of the sum."""
    rng = np.random.default_rng(17)
    n, m = 200, rng.normal(size=(200, 3))
    m /= np.linalg.norm(m, axis=-1, keepdims=True)
    tilt = m + 0.2 * rng.normal(size=(n, 3))
    tilt /= np.linalg.norm(tilt, axis=-1, keepdims=True)
    place = distance * rng.normal(size=(n, 3))
    h, r = 0.95 * radius, np.sqrt(1 - 0.95**2) * radius
    a, b = cga.circle(place + h * m, m, r), cga.circle(place - h * tilt, tilt, r)
    # sphere* ^ plane*: -<a ~b>_0 is the product of unit planes about the sphere, n.n' - h h' over both radii
    product = ((m * tilt).sum(-1) + 0.95**2) / (1 - 0.95**2)
    assert np.all(product > 1)
    middle = objects.interpolate(a, -b, alpha=0.5)
    assert np.all(middle.status == Status.IMAGINARY)
    assert np.all(objects.interpolate_derivative(a, -b, alpha=0.5).status == Status.IMAGINARY)
    three = cga.multivector(np.stack([a.values, -b.values, a.values, -b.values]), kind="circle")
    assert np.all(objects.average(three).status == Status.IMAGINARY)
    assert np.all(objects.interpolate(a, b, alpha=0.5).status == Status.OK)
