"""Joins, meets, factors and blade tests against subspaces known from integer vectors, in every kind of metric."""

from __future__ import annotations

from functools import reduce
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

import bladesmith as bs
from bladesmith import cga3d as cga
from bladesmith import objects
from bladesmith import pga3d as pga

ALGEBRAS = [cga, pga, bs.algebra(2, 1, 2), bs.algebra(0, 0, 4), bs.algebra(3, 3, 0), bs.algebra(6, 1, 2)]
OK, SINGULAR, INVALID = bs.Status.OK, bs.Status.SINGULAR, bs.Status.INVALID
RNG = np.random.default_rng(5)


@pytest.fixture(autouse=True)
def same_numbers() -> None:
    """Each test draws the same, whichever others run."""
    RNG.bit_generator.state = np.random.default_rng(5).bit_generator.state


def blade(algebra: Any, vectors: Any) -> Any:
    """Outer product of rows."""
    rows = [algebra.multivector(np.asarray(v, float), grades=[1]) for v in vectors]
    return reduce(lambda a, b: a ^ b, rows, algebra.scalar(1.0))


def size(x: Any) -> float:
    return float(np.abs(x.values).max(initial=0.0))


def is_span(x: Any, vectors: Any, tolerance: float = 1e-11) -> bool:
    """Whether the blade x stands for the subspace of these vectors: right grade, and each of them in it."""
    algebra = x.algebra
    rows = np.asarray(vectors, float).reshape(-1, algebra.dimension)
    rank = np.linalg.matrix_rank(rows) if len(rows) else 0
    if x.grades != (rank,) or size(x) == 0:
        return False
    members = [algebra.multivector(v, grades=[1]) for v in rows]
    return all(size(x ^ v) <= tolerance * size(x) * size(v) for v in members)


def independent(count: int, n: int) -> Any:
    """Integer vectors of full rank."""
    while True:
        rows = RNG.integers(-4, 5, (count, n))
        if count == 0 or np.linalg.svd(rows.astype(float), compute_uv=False)[-1] > 0.3:
            return rows


def union_of(a: Any, b: Any) -> Any:
    """The vector-level sum: the join, or the meet where objects are built from planes."""
    return objects.meet(a, b) if a.algebra.is_degenerate else objects.join(a, b)


def common_of(a: Any, b: Any) -> Any:
    return objects.join(a, b) if a.algebra.is_degenerate else objects.meet(a, b)


@pytest.mark.slow
@pytest.mark.parametrize("algebra", ALGEBRAS, ids=lambda a: a.name)
def test_every_pair_of_grades_and_every_overlap(algebra: Any) -> None:
    n = algebra.dimension
    for ga in range(1, n + 1):
        for gb in range(1, n + 1):
            for common in range(max(0, ga + gb - n), min(ga, gb) + 1):
                rows = independent(ga + gb - common, n)
                a, b = blade(algebra, rows[:ga]), blade(algebra, rows[ga - common :]) * 0.5
                case = (ga, gb, common)
                assert is_span(union_of(a, b), rows), case
                assert is_span(common_of(a, b), rows[ga - common : ga]), case


@pytest.mark.parametrize("algebra", ALGEBRAS, ids=lambda a: a.name)
def test_factors_multiply_back(algebra: Any) -> None:
    n = algebra.dimension
    for g in range(1, n + 1):
        x = blade(algebra, independent(g, n))
        factors = objects.factorise(x)
        assert factors.shape == (g,) and factors.grades == (1,) and objects.is_blade(x)
        again = reduce(lambda a, b: a ^ b, factors)
        assert size(again - x) <= 1e-13 * size(x)
        if algebra not in (cga, pga):  # there they are orthogonal in scaled units of length
            rows = factors.values[1:]
            assert np.allclose(rows @ rows.T, np.eye(g - 1), atol=1e-13)
            assert np.allclose(factors.values[:1] @ rows.T, 0, atol=1e-13 * size(x))


def test_null_blades() -> None:
    """Points, tangents, directions, flats at infinity: no inverse, but subspaces like any other."""
    p, q = cga.point([1.0, 2, 3]), cga.point([-1.0, 0, 2])
    tangent = p ^ cga.multivector([0.0, 1.0, 0, 0, 2.0], grades=[1])  # e2 at p
    assert np.abs((tangent * tangent).values).max() < 1e-14
    attitude = cga.e12 ^ cga.ni
    for x in (p, tangent, attitude, cga.ni, cga.e1 ^ cga.ni):
        assert objects.is_blade(x)
        again = reduce(lambda a, b: a ^ b, objects.factorise(x))
        assert again.isclose(x, rtol=1e-14)
    assert objects.join(p, q).isclose(p ^ q, rtol=1e-15)
    assert is_span(objects.join(tangent, p), [p.values, [0, 1, 0, 0, 2]])
    line = cga.line([1.0, 2, 3], [0.0, 1, 0])
    assert is_span(objects.meet(tangent, line), [p.values, [0, 1, 0, 0, 2]])  # the tangent lies in the line
    parallel = objects.meet(cga.plane([0.0, 0, 1], 1.0), cga.plane([0.0, 0, 1], 2.0))
    assert is_span(parallel, np.eye(5)[[0, 1, 4]])  # at infinity: e1 ^ e2 ^ n_inf
    assert cga.classify(parallel) == "direction of planes"
    one = objects.meet(p, q)
    assert one.grades == (0,) and one["1"] == 1
    assert is_span(objects.meet(p, line), [p.values]) and is_span(objects.join(p, line), [*objects_rows(line)])


def objects_rows(x: Any) -> Any:
    return objects.factorise(x).values


def test_geometry_of_lines_planes_and_circles() -> None:
    a, b = cga.line([1.0, 1, 0], [1.0, 0, 0]), cga.line([1.0, 1, 0], [0.0, 1, 1])
    plane, spot = objects.join(a, b), objects.meet(a, b)
    normal = plane.normalized().parameters().normal
    assert np.allclose(np.abs(normal), np.array([0, 1, 1]) / np.sqrt(2), atol=1e-12)
    assert cga.classify(plane) == "plane" and cga.classify(spot) == "flat point"
    assert np.allclose((spot / spot["noni"]).parameters().xyz, [1, 1, 0], atol=1e-12)
    skew = objects.meet(a, cga.line([0.0, 0, 5], [0.0, 1, 0]))
    assert skew.isclose(cga.ni / skew["ni"] * skew["ni"] ** 2)  # nothing but infinity
    first, second = cga.circle([0.0, 0, 0], [0.0, 0, 1], 1.0), cga.circle([1.0, 0, 0], [0.0, 0, 1], 1.0)
    assert cga.classify(objects.join(first, second)) == "plane"  # two circles in one plane
    pair = objects.meet(first, second).normalized()
    ends = np.stack([pair.parameters().a, pair.parameters().b])
    assert np.allclose(ends[:, 0], 0.5) and np.allclose(np.abs(ends[:, 1]), np.sqrt(0.75))
    sphere = cga.sphere([0.0, 0, 0], 2.0)
    assert objects.meet(plane, sphere).isclose(plane & sphere) and objects.join(plane, sphere).grades == (5,)


def test_plane_based_geometry_keeps_its_words() -> None:
    p, q = pga.point([1.0, 2, 3]), pga.point([0.0, 1, 0])
    assert objects.join(p, q).isclose(p & q) and objects.join(p, q).isclose(p.join(q))
    e, f = pga.plane([1.0, 0, 0], 2.0), pga.plane([0.0, 1, 0], 3.0)
    assert objects.meet(e, f).isclose(e ^ f) and objects.meet(e, f).isclose(e.meet(f))
    line = pga.line_through([1.0, 2, 3], [0.0, 1, 0])
    crossing = pga.line_through([1.0, 2, 3], [5.0, 1, 7])
    spot = objects.meet(line, crossing)  # line ^ crossing vanishes
    assert size(line ^ crossing) < 1e-13 and spot.grades == (3,)
    assert np.allclose(spot.normalized("point").parameters().xyz, [1, 2, 3], atol=1e-12)
    plane = objects.join(line, crossing)
    assert plane.grades == (1,) and all(size(plane ^ pga.point(x)) < 1e-12 for x in ([1, 2, 3], [0, 1, 0], [5.0, 1, 7]))
    assert objects.join(p, line).isclose(line) and objects.meet(p, line).isclose(p)


def test_orientation() -> None:
    """a = A ^ M, b = M ^ B, J = A ^ M ^ B up to a positive factor; generic positions are the plain products."""
    for ga, gb, r, n in [(2, 2, 1, 5), (3, 2, 1, 5), (3, 3, 2, 5), (3, 3, 1, 6), (2, 3, 1, 6)]:
        algebra = bs.algebra(n)
        for _ in range(6):
            rows = independent(ga + gb - r, n)
            own, shared, other = rows[: ga - r], rows[ga - r : ga], rows[ga:]
            a, b = blade(algebra, [*own, *shared]), blade(algebra, [*shared, *other])
            j, m = objects.join(a, b), objects.meet(a, b)
            total, part = blade(algebra, rows), blade(algebra, shared)
            signs = [float(np.sign((x.values * y.values).sum())) for x, y in ((j, total), (m, part))]
            assert signs[0] == signs[1]
            if ga + gb - r < n:
                first = j.values[np.abs(j.values) > (0.5 - 1e-12) * np.abs(j.values).max()][0]
                assert first > 0 and np.isclose((j.values**2).sum(), 1)
    sphere, circle = cga.sphere([0.0, 0, 0], 1.0), cga.circle([0.0, 0, 1], [1.0, 0, 1], 1.0)
    assert objects.meet(sphere, circle).isclose(sphere & circle, rtol=1e-14)
    line, point = cga.line([0.0, 0, 1], [0.0, 1, 0]), cga.point([4.0, 4, 4])
    assert objects.join(line, point).isclose(line ^ point, rtol=1e-14)
    assert objects.join(-line, line).isclose(-line) and objects.meet(line, -line).isclose(-line)


def test_items_of_different_grades() -> None:
    lines = cga.line(np.zeros((4, 3)), [[1.0, 0, 0], [0, 1, 0], [1, 0, 0], [0, 0, 1]])
    others = cga.line([[0.0, 0, 0], [0, 0, 1], [0, 0, 0], [0, 0, 0]], [[0.0, 1, 0], [1, 0, 0], [2, 0, 0], [0, 0, 3]])
    j, m = objects.join(lines, others), objects.meet(lines, others)
    assert j.grades == (3, 4, 5) and m.grades == (1, 2, 3)
    for i, (whole, part) in enumerate([(4, 2), (5, 1), (3, 3), (3, 3)]):
        assert size(j[i].grade(whole)) > 0.1 and all(size(j[i].grade(g)) == 0 for g in {3, 4, 5} - {whole})
        assert size(m[i].grade(part)) > 0.1 and all(size(m[i].grade(g)) == 0 for g in {1, 2, 3} - {part})
    assert objects.is_blade(j).all()
    back = objects.meet(j, lines)
    assert back.grades == (3,) and back.isclose(lines).all()
    with pytest.raises(bs.errors.GradeError, match="item 1 has grade 5"):
        objects.factorise(j)
    assert objects.factorise(j[2:]).shape == (3, 2)
    grid = objects.join(lines[:, None], others[None, :])
    assert grid.shape == (4, 4) and grid[1, 0].isclose(objects.join(lines[1], others[0]))


def test_far_from_the_origin() -> None:
    far = np.array([1e6, -1e6, 2e6])
    p, q = cga.point(far), cga.point(far + [0, 0, 1.0])
    assert objects.join(p, q).grades == (2,) and objects.meet(p, q).grades == (0,)
    a, b = cga.line(far, [1.0, 2, 0]), cga.line(far, [0.0, 1, 3])
    assert objects.join(a, b).grades == (4,) and objects.meet(a, b).grades == (2,)
    gap = cga.line(far + 1e-2 * np.cross([1.0, 2, 0], [0.0, 1, 3]), [0.0, 1, 3])
    assert objects.join(a, gap).grades == (5,)
    circle = cga.circle(far, [1.0, 1, 1], 0.5)
    assert objects.is_blade(circle)
    again = reduce(lambda x, y: x ^ y, objects.factorise(circle)).normalized()
    back, own = again.parameters(), circle.parameters()
    assert np.allclose(back.center, own.center, rtol=1e-14) and np.isclose(back.radius, 0.5, rtol=5e-2)
    e, f = pga.line(far, [1.0, 2, 0]), pga.line(far, [0.0, 1, 3])
    assert objects.meet(e, f).grades == (3,) and objects.join(e, f).grades == (1,)


def test_sums_that_are_no_blades() -> None:
    circles = cga.circle(RNG.normal(size=(50, 3)), RNG.normal(size=(50, 3)), 1.0)
    mixed = circles + circles[::-1] * 0.5
    assert objects.is_blade(circles).all() and not objects.is_blade(mixed).any()
    defect = np.abs((mixed * mixed).grade(4).values).max(-1)
    assert (defect > 1e-3).all()  # what the metric says of the same thing
    for step in (1e-9, 1e-14):
        near = circles[0] + step * circles[1]
        assert objects.is_blade(near) == (step < 1e-12)
        assert objects.is_blade(near, tolerance=1e-6)
    assert not objects.is_blade(bs.algebra(4).multivector({"e12": 1.0, "e34": 1.0}))
    assert not objects.is_blade(bs.algebra(0, 0, 4).multivector({"e12": 1.0, "e34": 1.0}))
    assert not objects.is_blade(bs.algebra(6).multivector({"e123": 1.0, "e456": 1.0}))
    assert not objects.is_blade(cga.multivector({"1": 1.0, "e12": 1.0}))
    assert not objects.is_blade(cga.scalar(0.0)) and objects.is_blade(cga.scalar(2.0))
    assert objects.is_blade(cga.multivector({"e1": 0.0, "e12": 3.0, "e123": 0.0}))
    kept = objects.is_blade(cga.multivector({"e12": [1.0, 0.0, np.nan, 1e-300, np.inf]}))
    assert list(kept) == [True, False, False, True, False]


@given(st.data())
def test_random_blades_of_a_random_metric(data: Any) -> None:
    p, q, r = (data.draw(st.integers(0, 3)) for _ in range(3))
    n = p + q + r
    assume(n >= 2)
    algebra = bs.algebra(p, q, r)
    count = data.draw(st.integers(2, n))
    rows = np.array(
        data.draw(st.lists(st.lists(st.integers(-3, 3), min_size=n, max_size=n), min_size=count, max_size=count))
    )
    assume(np.linalg.svd(rows.astype(float), compute_uv=False)[-1] > 0.05)
    cut, back = data.draw(st.integers(1, count - 1)), data.draw(st.integers(0, count - 1))
    start = min(cut, back)
    a, b = blade(algebra, rows[:cut]), blade(algebra, rows[start:])
    assert objects.is_blade(a) and objects.is_blade(b)
    assert is_span(union_of(a, b), rows, 1e-10) and is_span(common_of(a, b), rows[start:cut], 1e-10)


def test_scales_and_dimensions() -> None:
    big = bs.algebra(9, 2, 1)
    rows = independent(4, 12)
    x = blade(big, rows)
    again = reduce(lambda a, b: a ^ b, objects.factorise(x))
    assert again.isclose(x, rtol=1e-12) and objects.is_blade(x)
    assert is_span(union_of(blade(big, rows[:3]), blade(big, rows[1:])), rows)
    lines = cga.line([0.0, 0, 1], [0.0, 1, 0]) * np.array([1e-250, 1.0, 1e250])
    assert objects.is_blade(lines).all()
    assert reduce(lambda a, b: a ^ b, objects.factorise(lines)).isclose(lines, rtol=1e-13).all()
    planes = objects.join(lines, cga.line([0.0, 0, 1], [1.0, 1, 0]))
    assert planes.grades == (4,) and planes.isclose(planes[1], rtol=1e-12).all()


def test_bad_input() -> None:
    lines = cga.line(np.zeros((4, 3)), np.eye(3)[[0, 1, 2, 0]])
    data = np.array(lines.values)
    data[1], data[2] = np.nan, 0.0
    bad = cga.multivector(data, blades=lines.blades)
    bad = bad + cga.multivector({"e1noni": [0, 0, 0, 2.0], "e23ni": [0, 0, 0, 1.0]})  # a screw
    plane = cga.plane([0.0, 0, 1], 2.0)
    for found in (objects.join(bad, plane), objects.meet(plane, bad)):
        assert list(found.status) == [OK, INVALID, SINGULAR, INVALID]
        assert np.isnan(found.values[1:]).all() and np.isfinite(found.values[0]).all()
    factors = objects.factorise(bad)
    assert factors.shape == (3, 4) and list(factors.status[2]) == [OK, INVALID, SINGULAR, INVALID]
    for call in (lambda: objects.join(bad, plane, strict=True), lambda: objects.factorise(bad, strict=True)):
        with pytest.raises(bs.errors.SingularError, match="item 1 is INVALID"):
            call()
    assert objects.join(bad[1:2], plane).status[0] == INVALID
    with pytest.raises(bs.errors.AlgebraMismatchError):
        objects.join(plane, pga.plane([1.0, 0, 0], 1.0))
    with pytest.raises(bs.errors.InputError):
        objects.is_blade(np.ones(5))  # type: ignore[arg-type]
    with pytest.raises(bs.errors.InputError):
        objects.is_blade(plane, tolerance=-1.0)
    with pytest.raises(bs.errors.GradeError):
        objects.factorise(cga.scalar(1.0))
    with pytest.raises(bs.errors.ShapeError):
        objects.join(lines, lines[:3])
    none = lines[:0]
    assert objects.join(none, plane).shape == (0,) and objects.meet(none, none).shape == (0,)
    assert objects.factorise(none).shape == (3, 0) and objects.is_blade(none).shape == (0,)


def test_single_precision() -> None:
    points = RNG.normal(size=(30, 3, 3)).astype(np.float32)
    circles = cga.circle_through(points[:, 0], points[:, 1], points[:, 2])
    assert circles.dtype == np.float32 and objects.is_blade(circles).all()
    spheres = objects.join(circles, cga.point(points[::-1, 0]))
    assert spheres.dtype == np.float32 and spheres.grades == (4,)
    assert objects.factorise(circles).dtype == np.float32
    assert objects.meet(spheres, circles).isclose(circles, rtol=1e-3).all()
