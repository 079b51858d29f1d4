"""Objects of CGA and PGA against elementary geometry: incidences, known parameters, moved points."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import bladesmith as bs
from bladesmith import errors

from ..support.objects.positions import OFFSET, RADIUS, RANDOM, UNIT, A, B, C, D, N, V

# -- parameters come back ----------------------------------------------------------------------------------

CGA_OBJECTS: dict[str, tuple[tuple[Any, ...], dict[str, Any]]] = {
    "point": ((A,), {"xyz": A}),
    "flat_point": ((A,), {"xyz": A}),
    "direction": ((V,), {"v": V}),
    "point_pair": ((A, B), {"a": A, "b": B}),
    "line": ((A, V), {"direction": UNIT, "point": A - (A * UNIT).sum(-1, keepdims=True) * UNIT}),
    "circle": ((A, V, RADIUS), {"center": A, "normal": UNIT, "radius": RADIUS}),
    "plane": ((V, OFFSET), {"normal": UNIT, "offset": OFFSET / np.linalg.norm(V, axis=-1)}),
    "sphere": ((A, RADIUS), {"center": A, "radius": RADIUS}),
    "translator": ((V,), {"t": V}),
    "dilator": ((RADIUS, A), {"scale": RADIUS, "center": A}),
    "transversor": ((V,), {"t": V}),
}
PGA_OBJECTS = {name: CGA_OBJECTS[name] for name in ("point", "direction", "line", "plane", "translator")}
CASES = [("cga3d", name) for name in CGA_OBJECTS] + [("pga3d", name) for name in PGA_OBJECTS]


@pytest.mark.parametrize(("algebra", "name"), CASES)
def test_parameters_come_back(algebra: str, name: str) -> None:
    alg = getattr(bs, algebra)
    arguments, expected = CGA_OBJECTS[name]
    x = getattr(alg, name)(*arguments)
    assert x.shape == (N,) and (x.status == bs.Status.OK).all()
    found = x.parameters()
    assert set(found._fields) == set(expected)
    for field, value in expected.items():
        assert np.allclose(getattr(found, field), value, rtol=1e-9, atol=1e-9), field
    assert np.array_equal(found.orientation, np.ones(N)) and (found.status == bs.Status.OK).all()
    again = getattr(alg, name)(*found)
    assert again.isclose(x, rtol=1e-9, atol=1e-9).all() and again.kind == x.kind
    words = {"point_pair": "point pair", "flat_point": "flat point", "dilator": "homothety"}
    assert set(alg.classify(x)) == {words.get(name, name)}
    single = getattr(alg, name)(*(a[0] for a in arguments))
    assert single.shape == () and single.isclose(x[0], rtol=1e-14)
    assert alg.classify(single) == words.get(name, name) and isinstance(alg.classify(single), str)


def test_objects_are_normalised() -> None:
    cga, pga = bs.cga3d, bs.pga3d
    for name, square in (("point_pair", 1), ("line", 1), ("circle", 1), ("plane", -1), ("sphere", -1), ("point", 0)):
        x = getattr(cga, name)(*CGA_OBJECTS[name][0])
        assert (x * x).isclose(float(square), rtol=1e-9, atol=1e-9).all()
    assert np.allclose((cga.point(A) | cga.ni)["1"], -1)
    for name in PGA_OBJECTS:
        if name != "direction":
            x = getattr(pga, name)(*PGA_OBJECTS[name][0])
            assert (x * ~x).isclose(1, rtol=1e-9, atol=1e-9).all()


def test_conventions() -> None:
    cga = bs.cga3d
    x, y, s = cga.point(A), cga.point(B), cga.sphere(A, RADIUS)
    assert np.allclose((x | y)["1"], -((A - B) ** 2).sum(-1) / 2)
    power = ((B - A) ** 2).sum(-1) - RADIUS**2
    assert np.allclose((s.dual() | y)["1"], -power / (2 * RADIUS))  # outside negative, inside positive
    assert (((s.dual() | cga.ni)["1"]) < 0).all()
    line = cga.line_through(A, B)
    assert line.isclose((x ^ y ^ cga.ni).normalized(), rtol=1e-9).all()
    circle = cga.circle(A, V, RADIUS)
    assert circle.isclose((cga.plane(V, (V * A).sum(-1)) & s), rtol=1e-9, atol=1e-9).all()
    turn = cga.rotor([0.0, 0.0, 1.0], np.pi / 2)
    assert np.allclose((turn >> cga.point([1.0, 0.0, 0.0])).parameters().xyz, [0, 1, 0])
    assert (cga.translator(V) >> cga.point(A)).isclose(cga.point(A + V), rtol=1e-12).all()


def test_objects_through_points() -> None:
    cga = bs.cga3d
    points = [cga.point(p) for p in (A, B, C, D)]
    for name, count in (("line_through", 2), ("circle_through", 3), ("plane_through", 3), ("sphere_through", 4)):
        x = getattr(cga, name)(*(A, B, C, D)[:count])
        for p in points[:count]:
            assert (np.abs((x ^ p).values).max(-1) <= 1e-11 * np.abs(x.values).max(-1) * np.abs(p.values).max(-1)).all()
        blade = points[0]
        for p in points[1:count]:
            blade = blade ^ p
        blade = blade ^ cga.ni if name in ("line_through", "plane_through") else blade
        assert blade.normalized().isclose(x, rtol=1e-7, atol=1e-9).all()  # same orientation
    inside_out = cga.sphere_through(A, C, B, D).parameters()
    outward = cga.sphere_through(A, B, C, D).parameters()
    assert np.array_equal(inside_out.orientation, -outward.orientation) and set(outward.orientation) == {-1.0, 1.0}
    assert np.allclose(inside_out.radius, outward.radius, rtol=1e-6) and (outward.radius > 0).all()
    counter = cga.circle_through([1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]).parameters()
    assert np.allclose(counter.normal, [0, 0, 1]) and np.allclose(counter.radius, 1)
    collinear = cga.circle_through([0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0])
    assert collinear.status is bs.Status.SINGULAR and np.isnan(collinear.values).all()


def test_pga_incidence_and_joins() -> None:
    pga = bs.pga3d
    p, q, r = (pga.point(x) for x in (A, B, C))
    assert (p & q).normalized().isclose(pga.line_through(A, B), rtol=1e-9, atol=1e-9).all()
    assert (p & q & r).normalized().isclose(pga.plane_through(A, B, C), rtol=1e-8, atol=1e-9).all()
    plane = pga.plane(V, OFFSET)
    meet = (pga.line_through(A, B) ^ plane).normalized()
    assert meet.kind == pga.kind("point")
    xyz = meet.parameters().xyz
    assert np.allclose((xyz * V).sum(-1), OFFSET, rtol=1e-7, atol=1e-7)
    planes = [pga.plane(n, d) for n, d in (([1.0, 0, 0], 2.0), ([0, 1.0, 0], 3.0), ([0, 0, 1.0], 4.0))]
    assert np.allclose((planes[0] ^ planes[1] ^ planes[2]).parameters().xyz, [2, 3, 4])


def test_pga_is_covariant() -> None:
    """Translate a point and a plane through it: still incident. Printed signs fail here and nowhere else."""
    pga = bs.pga3d
    plane = pga.plane(V, (V * A).sum(-1))
    for motor in (pga.translator(B), pga.rotor(C, OFFSET), pga.rotor(C, OFFSET, point=D)):
        moved = motor >> pga.point(A)
        assert np.allclose(moved.parameters().xyz, apply(motor.to_matrix(), A))
        normal, offset = (motor >> plane).parameters()
        assert np.allclose((normal * moved.parameters().xyz).sum(-1), offset)
        turned = apply(motor.to_matrix(), A + V) - moved.parameters().xyz
        assert (motor >> pga.line(A, V)).isclose(pga.line(moved.parameters().xyz, turned), rtol=1e-8, atol=1e-8).all()


def apply(matrix: np.ndarray, points: np.ndarray) -> np.ndarray:
    return np.einsum("...ij,...j->...i", matrix[..., :3, :3], points) + matrix[..., :3, 3]


def test_the_plane() -> None:
    plane = bs.cga2d
    a, b = A[:, :2], B[:, :2]
    circle = plane.circle(a, RADIUS)
    assert np.allclose(circle.parameters().center, a) and np.allclose(circle.parameters().radius, RADIUS)
    assert set(plane.classify(circle)) == {"circle"} and set(plane.classify(plane.line_through(a, b))) == {"line"}
    assert np.allclose(plane.point_pair(a, b).parameters().b, b) and np.allclose(plane.point(a).parameters().xyz, a)
    angle = RANDOM.uniform(-3, 3, N)
    turn = plane.rotor(angle, point=a)
    moved = (turn >> plane.point(b)).parameters().xyz
    c, s = np.cos(angle), np.sin(angle)
    d = b - a
    assert np.allclose(moved, a + np.stack([c * d[:, 0] - s * d[:, 1], s * d[:, 0] + c * d[:, 1]], -1))
    assert np.allclose(turn.parameters().angle, angle) and np.allclose(turn.parameters().point, a, atol=1e-6)
    again = plane.motor_from_matrix(turn.to_matrix())
    assert np.allclose(again.to_matrix(), turn.to_matrix())


# -- classification ----------------------------------------------------------------------------------------


def test_classify() -> None:
    cga, pga = bs.cga3d, bs.pga3d
    origin = cga.point([0.0, 0.0, 0.0])
    imaginary = (cga.no + 0.5 * cga.ni).undual()  # dual sphere with r^2 = -1
    tests = {
        "imaginary sphere": imaginary,
        "imaginary circle": (cga.plane([0.0, 0.0, 1.0], 0.0) & imaginary),
        "imaginary point pair": (cga.line([0.0, 0.0, 0.0], [1.0, 0.0, 0.0]) & imaginary),
        "tangent vector": origin ^ cga.e1,
        "sphere of radius zero": origin.undual(),
        "direction": cga.e1 ^ cga.ni,
        "direction of planes": cga.e12 ^ cga.ni,
        "direction of space": cga.e123 ^ cga.ni,
        "point at infinity": cga.ni,
        "dual plane": cga.e1 + 2 * cga.ni,
        "dual sphere": cga.sphere([1.0, 2.0, 3.0], 1.0).dual(),
        "scalar": cga.scalar(2.0),
        "pseudoscalar": cga.e123noni,
        "zero": cga.e1 * 0,
        "not a blade": cga.e12 + cga.e3 * cga.ni,
        "invalid": cga.e1 * np.nan,
        "motor": cga.translator([1.0, 0.0, 0.0]) * cga.rotor([0.0, 1.0, 1.0], 1.0),
        "rotor": cga.rotor([0.0, 1.0, 1.0], 1.0),
    }
    assert {name: cga.classify(x) for name, x in tests.items()} == {name: name for name in tests}
    assert cga.classify(cga.e1 + cga.e12) == "not a blade"
    assert cga.classify(cga.circle(A, V, RADIUS) + cga.circle(B, C, RADIUS)).tolist() == ["not a blade"] * N
    tests = {
        "plane at infinity": pga.e0,
        "line at infinity": pga.e0 * pga.e1,
        "not a blade": pga.e12 + pga.e0 * pga.e3,
        "line": pga.e12,
        "motor": pga.translator([1.0, 0.0, 0.0]) * pga.rotor([0.0, 1.0, 1.0], 1.0),
    }
    assert {name: pga.classify(x) for name, x in tests.items()} == {name: name for name in tests}
    weights = RANDOM.uniform(1e-8, 1e8, N)
    far = cga.circle(A * 1e3, V, RADIUS)
    assert set(cga.classify(far * weights)) == {"circle"}  # neither weight nor distance matters


@pytest.mark.parametrize("far", [1e6, 1e7, 1e12])
def test_known_kinds_are_named_wherever_they_are(far: float) -> None:
    cga, pga = bs.cga3d, bs.pga3d
    x, n = [far, 1.0, 2.0], [0.0, 0.0, 1.0]
    objects = {"point": cga.point(x), "sphere": cga.sphere(x, 1.0), "circle": cga.circle(x, n, 1.0),
               "line": cga.line(x, n), "plane": cga.plane(n, far)}  # fmt: skip
    assert {cga.classify(o) for o in objects.values()} == set(objects)
    assert all(cga.classify(o) == name for name, o in objects.items())
    assert pga.classify(pga.plane(n, far)) == "plane"
    assert cga.classify(cga.line(x, n).as_kind("circle")) == "line"  # it satisfies what circles satisfy
    assert cga.classify(cga.sphere(x, [1.0, -1.0])).tolist() == ["sphere", "invalid"]
    with pytest.raises(errors.InputError, match="is .x.; a multivector"):
        cga.classify("x")


@pytest.mark.parametrize("name", ["cga3d", "pga3d"])
@pytest.mark.parametrize("size", [1e200, 1e-165])
def test_directions_of_any_size(name: str, size: float) -> None:
    alg: Any = getattr(bs, name)
    d = np.array([1.0, 2.0, 2.0])
    assert alg.line([1.0, 0.0, 0.0], size * d).isclose(alg.line([1.0, 0.0, 0.0], d))
    assert alg.plane(size * d, 0.0).isclose(alg.plane(d, 0.0))
    assert alg.rotor(size * d, 1.0).isclose(alg.rotor(d, 1.0))
    nothing = alg.rotor([0.0, 0.0, 0.0], 1.0)
    assert nothing.status is bs.Status.INVALID and np.isnan(nothing.values).all()


def test_a_full_turn_has_its_axis_through_the_origin() -> None:
    cga = bs.cga3d
    motor = cga.translator([1.0, 2.0, 3.0]) * cga.rotor([0.0, 1.0, 1.0], 2 * np.pi)
    assert motor.log().status is bs.Status.NOT_UNIQUE and motor.log().exp().isclose(motor, rtol=1e-14)
    assert (motor.sqrt() * motor.sqrt()).isclose(motor, rtol=1e-14)
    screw = motor.parameters()
    assert np.allclose(screw.axis, np.array([1, 2, 3]) / np.sqrt(14)) and np.allclose(screw.point, 0)


def test_parameters_of_unnormalised_objects() -> None:
    cga = bs.cga3d
    x = 3.0 * cga.circle([1.0, 2.0, 3.0], [0.0, 0.0, 1.0], 2.0)
    assert x.kind.is_layout and np.allclose(x.parameters().center, [1, 2, 3])
    assert np.allclose((5 * cga.point([1.0, 2.0, 3.0])).parameters().xyz, [1, 2, 3])
    with pytest.raises(errors.KindError, match="classify"):
        (cga.e12 + cga.e3 * cga.ni).parameters()
    with pytest.raises(errors.GradeError, match="no geometric objects"):
        bs.algebra(3).e1.parameters()
    assert np.allclose(cga.plane([0.0, 0.0, 1.0], 1.0).parameters().offset, 1)


# -- bad values --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("bad", [0.0, -1.0, np.nan, np.inf])
def test_bad_radii(bad: float) -> None:
    cga = bs.cga3d
    for make in (lambda r, **k: cga.sphere(A, r, **k), lambda r, **k: cga.circle(A, V, r, **k)):
        radius = RADIUS.copy()
        radius[3] = bad
        x = make(radius)
        assert x.status[3] == bs.Status.INVALID and np.isnan(x.values[3]).all()
        assert (np.delete(x.status, 3) == 0).all() and np.isfinite(np.delete(x.values, 3, axis=0)).all()
        with pytest.raises(errors.SingularError, match="item 3 is INVALID"):
            make(radius, strict=True)
    single = cga.sphere([0.0, 0.0, 0.0], bad)
    assert single.status is bs.Status.INVALID and np.isnan(single.values).all()


@pytest.mark.parametrize("name", [name for name in CGA_OBJECTS if name not in ("point_pair", "dilator", "transversor")])
def test_what_is_not_finite(name: str) -> None:
    cga = bs.cga3d
    arguments = [np.array(a) for a in CGA_OBJECTS[name][0]]
    arguments[0][7, 1], arguments[0][8, 1] = np.nan, np.inf
    x = getattr(cga, name)(*arguments)
    assert (x.status[7:9] == bs.Status.INVALID).all() and np.isnan(x.values[7:9]).all()
    assert (np.delete(x.status, [7, 8]) == 0).all()


def test_degenerate_objects() -> None:
    cga = bs.cga3d
    zero = np.zeros(3)
    assert cga.line(A[0], zero).status is bs.Status.INVALID and cga.plane(zero, 1.0).status is bs.Status.INVALID
    assert cga.line_through(A[0], A[0]).status is bs.Status.SINGULAR
    assert cga.point_pair(A[0], A[0]).status is bs.Status.SINGULAR
    assert cga.plane_through(zero, [1.0, 0, 0], [2.0, 0, 0]).status is bs.Status.SINGULAR
    assert cga.sphere_through(zero, [1.0, 0, 0], [0, 1.0, 0], [1.0, 1.0, 0]).status is bs.Status.SINGULAR
    assert cga.rotor(zero, 1.0).status is bs.Status.INVALID and cga.dilator(-1.0).status is bs.Status.INVALID
    assert cga.motor_from_matrix(np.diag([1.0, 1, 2, 1])).status is bs.Status.INVALID
    affine = np.eye(4)
    affine[3, 0] = 1
    assert cga.motor_from_matrix(affine).status is bs.Status.INVALID
    assert cga.circle_through(A[0], B[0], A[0]).status is not bs.Status.OK


@pytest.mark.parametrize(
    ("call", "error", "words"),
    [
        (lambda: bs.cga3d.point([1.0, 2.0]), errors.ShapeError, "xyz has shape .* 3. is needed"),
        (lambda: bs.cga3d.sphere(np.zeros((4, 3)), np.ones(3)), errors.ShapeError, "broadcast"),
        (lambda: bs.cga3d.point("abc"), errors.InputError, "real numbers"),
        (lambda: bs.cga3d.sphere([0, 0, 0], None), errors.InputError, "real numbers"),
        (lambda: bs.cga3d.motor_from_matrix(np.eye(5)), errors.ShapeError, r"\(4, 4\)"),
        (lambda: bs.cga3d.point([1, 2, 3]).to_matrix(), errors.KindError, "not a motor"),
        (lambda: bs.cga3d.classify(bs.pga3d.e1), errors.AlgebraMismatchError, "pga3d"),
    ],
)
def test_wrong_arguments(call: Any, error: type[Exception], words: str) -> None:
    with pytest.raises(error, match=words):
        call()


@pytest.mark.compiles
def test_single_precision() -> None:
    cga = bs.cga3d
    x = cga.sphere(A.astype(np.float32), RADIUS.astype(np.float32))
    assert x.dtype == np.float32 and x.kind == cga.kind("sphere") and set(cga.classify(x)) == {"sphere"}
    assert np.allclose(x.parameters().center, A, atol=1e-4) and x.parameters().radius.dtype == np.float32
    motor = cga.rotor(V.astype(np.float32), np.float32(0.5))
    assert (motor >> x).dtype == np.float32
    assert cga.sphere(A.astype(np.float32), 2.0).dtype == np.float32  # single numbers do not widen


@pytest.mark.parametrize("n", [5, 5000])
def test_what_is_not_finite_is_found_among_few_and_many(n: int) -> None:
    """However great the others are: their squares and sums are not finite."""
    x = bs.cga3d.point(np.full((n, 3), 0.5))
    data = x._data.copy()
    data[:, :3] = 1.5e308
    data[0, :3], data[1, :3] = (np.inf, 0, 0), (-np.inf, np.nan, 0)
    found = x._make(x._type, data, x.shape).parameters()
    assert found.status.tolist() == [bs.Status.INVALID] * 2 + [bs.Status.OK] * (n - 2)
    assert np.isnan(found.xyz[:2]).all() and (found.xyz[2:] == 1.5e308).all()
