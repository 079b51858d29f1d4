"""Products, duals, meets, reflections and frames: against `clifford`, and against plain geometry."""

import numpy as np
import pytest

from bladesmith.codegen.algebra.algebra import Algebra
from bladesmith.codegen.algebra.blades import grade
from bladesmith.codegen.algebra.members import residuals
from bladesmith.codegen.algebra.multivector import Multivector
from bladesmith.codegen.formulas.motions import motions
from bladesmith.codegen.formulas.objects import conformal, projective
from bladesmith.codegen.formulas.products import frames, products, versors
from bladesmith.codegen.status import Status
from bladesmith.codegen.trace.outputs import Result

from ...oracles.clifford_layouts import COMPLEMENT_SIGN, DUAL_SIGN, JOIN_SIGN, meet_sign, oracle
from ...support.formulas import EPS, Traced, members, multivector, plain, rows, stock
from ...support.vectors import unit

ALGEBRAS = [stock("cga3d"), stock("pga3d"), stock("cga2d"), plain(3), plain(1, 3)]
TABLES = {"geometric": "gmt", "outer": "omt", "inner": "imt"}
PAIRS = 10_000


@pytest.mark.slow
@pytest.mark.parametrize("algebra", ALGEBRAS, ids=lambda a: a.name)
@pytest.mark.parametrize("name", TABLES)
def test_products_agree_with_clifford(algebra: Algebra, name: str) -> None:
    kind = algebra.kind("multivector")
    x, y = members(kind, PAIRS, 1), members(kind, PAIRS, 2)
    ours = rows(kind, getattr(products, name)(multivector(kind, x), multivector(kind, y)))
    theirs = oracle(algebra).product(TABLES[name], x, y)
    scale = np.linalg.norm(x, axis=1) * np.linalg.norm(y, axis=1)
    assert np.max(np.abs(ours - theirs) / scale[:, None]) < 8 * EPS


@pytest.mark.parametrize("algebra", ALGEBRAS, ids=lambda a: a.name)
def test_derived_products_agree_with_their_definitions(algebra: Algebra) -> None:
    kind = algebra.kind("multivector")
    x, y = multivector(kind, members(kind, 50, 3)), multivector(kind, members(kind, 50, 4))
    for ours, expected in (
        (products.commutator(x, y), (x * y - y * x) / 2),
        (products.anticommutator(x, y), (x * y + y * x) / 2),
        (products.scalar_product(x, y), (x * y).grade(0)),
        (products.sandwich(x, y), x * y * products.reverse(x)),
        (products.undual(products.dual(x)), x),
        (products.conjugate(x), products.involute(products.reverse(x))),
    ):
        assert np.allclose(rows(kind, ours), rows(kind, expected), rtol=0, atol=1e-12)
    for r in range(algebra.dimension + 1):
        for s in range(algebra.dimension + 1):
            part = products.left_contraction(x.grade(r), y.grade(s))
            expected = (x.grade(r) * y.grade(s)).grade(s - r) if s >= r else x.new({})
            assert np.allclose(rows(kind, part), rows(kind, expected), rtol=0, atol=1e-12)


@pytest.mark.slow
def test_dual_and_meet_agree_with_clifford() -> None:
    algebra = stock("cga3d")
    kind, theirs = algebra.kind("multivector"), oracle(algebra)
    x, y = members(kind, 20, 5), members(kind, 20, 6)
    minus_i = theirs.back(-theirs.layout.pseudoScalar.value)  # the inverse of its pseudoscalar, which squares to -1
    dual = theirs.product("gmt", x, np.broadcast_to(minus_i, x.shape))
    assert np.allclose(rows(kind, products.dual(multivector(kind, x))), DUAL_SIGN * dual, atol=1e-13)
    grades = np.array([grade(b) for b in algebra.blades])
    for r in range(1, 6):
        for s in range(5 - r, 6):
            a, b = np.where(grades == r, x, 0), np.where(grades == s, y, 0)
            ours = rows(kind, products.meet(multivector(kind, a), multivector(kind, b)))
            for i in range(len(x)):
                vee = theirs.multivector(a[i]).vee(theirs.multivector(b[i])).value
                assert np.allclose(ours[i], meet_sign(5, r, s) * theirs.back(vee), atol=1e-12)


@pytest.mark.slow
def test_j_and_join_agree_with_clifford() -> None:
    algebra = stock("pga3d")
    kind, theirs = algebra.kind("multivector"), oracle(algebra)
    x, y = members(kind, 50, 7), members(kind, 50, 8)
    j = rows(kind, frames.j_map(multivector(kind, x)))
    undone = rows(kind, products.undual(multivector(kind, x)))
    join = rows(kind, products.join(multivector(kind, x), multivector(kind, y)))
    for i in range(len(x)):
        one, other = theirs.multivector(x[i]), theirs.multivector(y[i])
        assert np.allclose(j[i], COMPLEMENT_SIGN * theirs.back(one.right_complement().value), atol=1e-13)
        assert np.allclose(undone[i], COMPLEMENT_SIGN * theirs.back(one.left_complement().value), atol=1e-13)
        assert np.allclose(join[i], JOIN_SIGN * theirs.back(one.vee(other).value), atol=1e-12)


@pytest.mark.parametrize("algebra", [stock("pga3d"), plain(2, 0, 2), plain(3), stock("cga3d")], ids=lambda a: a.name)
def test_j_is_the_complement_and_twice_j_is_a_sign(algebra: Algebra) -> None:
    kind = algebra.kind("multivector")
    x = multivector(kind, members(kind, 5, 9))
    n = algebra.dimension
    assert np.array_equal(rows(kind, frames.j_map(x)), rows(kind, x.complement()))
    twice = x.complement().complement()
    assert np.array_equal(rows(kind, twice), rows(kind, x.scale_blades(lambda b: (-1) ** (grade(b) * (n - grade(b))))))


# -- PGA: the covariance test, and joins and meets as geometry ---------------------------------------------------


def test_pga_is_covariant() -> None:
    """A point and a plane moved together keep their incidence; the point lands where vector algebra says.

    Nothing else can tell our point from the printed J(x + e0), which is the point -x.
    """
    pga = stock("pga3d")
    rng = np.random.default_rng(10)
    x, n, t = rng.normal(size=(3, 500, 3))
    offset = np.sum(n * x, 1)  # the plane through x
    point = Traced(pga, projective.point, "euclidean")(x)
    plane = Traced(pga, projective.plane, "euclidean", "number")(n, offset)
    move = Traced(pga, motions.translator, "euclidean")(t)
    moved = Traced(pga, products.sandwich, "translator", "point")(move, point)
    plane = Traced(pga, products.sandwich, "translator", "plane")(move, plane)
    incidence = Traced(pga, products.outer, "plane", "point")(plane, moved)
    assert np.max(np.abs(incidence)) < 1e-14 * 100
    assert np.allclose(Traced(pga, projective.point_parameters, "point")(moved), x + t, atol=1e-14)
    printed = Traced(pga, projective.printed_point, "euclidean")(x)
    opposite = -Traced(pga, projective.point, "euclidean")(-x)
    euclidean = pga.kind("point")
    assert np.allclose(rows(euclidean, multivector(euclidean, printed)), opposite, atol=0)


def test_pga_joins_and_meets_are_geometry() -> None:
    pga = stock("pga3d")
    rng = np.random.default_rng(11)
    a, b, c = rng.normal(size=(3, 200, 3))
    point = Traced(pga, projective.point, "euclidean")
    pa, pb, pc = point(a), point(b), point(c)
    join = Traced(pga, products.join, "point", "point")(pa, pb)
    line = Traced(pga, projective.line_through, "euclidean", "euclidean")(a, b)
    assert np.allclose(join, line * np.linalg.norm(b - a, axis=1)[:, None], atol=1e-13)
    spanned = Traced(pga, products.join, "~line", "point")(join, pc)
    plane = Traced(pga, projective.plane_through, "euclidean", "euclidean", "euclidean")(a, b, c)
    normal = np.cross(b - a, c - a)
    assert np.allclose(spanned, plane * np.linalg.norm(normal, axis=1)[:, None], atol=1e-12)
    assert np.allclose(plane[:, 1:], unit(normal), atol=1e-13)
    m = b - a  # line & z is the plane with normal m x (z - p)
    assert np.allclose(spanned[:, 1:], np.cross(m, c - a), atol=1e-12)
    normals, offsets = rng.normal(size=(3, 200, 3)), rng.normal(size=(3, 200))
    planes = [Traced(pga, projective.plane, "euclidean", "number")(n, d) for n, d in zip(normals, offsets, strict=True)]
    axis = Traced(pga, products.meet, "plane", "plane")(planes[0], planes[1])
    hit = Traced(pga, products.meet, "~line", "plane")(axis, planes[2])
    position, status = Traced(pga, projective.point_parameters, "~point").all(hit)
    solved = np.linalg.solve(np.moveaxis(normals, 0, 1), offsets.T[..., None])[..., 0]
    assert np.all(status == Status.OK)
    assert np.allclose(position, solved, rtol=1e-9, atol=1e-9)


# -- reflections -------------------------------------------------------------------------------------------------


def test_reflections_move_points_as_geometry_says() -> None:
    cga = stock("cga3d")
    rng = np.random.default_rng(12)
    x, p, q, n = rng.normal(size=(4, 300, 3))
    d, r = rng.normal(size=300), rng.uniform(0.2, 2, 300)
    un, h = unit(n), (q - p) / 2
    centre = (p + q) / 2
    point = Traced(cga, conformal.point, "euclidean")(x)
    plane = Traced(cga, conformal.plane, "euclidean", "number")(n, d)
    line = Traced(cga, conformal.line, "euclidean", "euclidean")(p, n)
    sphere = Traced(cga, conformal.sphere, "euclidean", "number")(p, r)
    pair = Traced(cga, conformal.point_pair, "euclidean", "euclidean")(p, q)
    circle = Traced(cga, conformal.circle, "euclidean", "euclidean", "number")(p, n, r)
    in_sphere = p + (x - p) * (r**2 / np.sum((x - p) ** 2, 1))[:, None]
    in_plane = x - 2 * (np.sum((x - p) * un, 1))[:, None] * un
    around = 2 * p + 2 * np.sum((x - p) * un, 1)[:, None] * un - x
    expected = {
        "plane": (plane, x - 2 * (np.sum(x * un, 1) - d / np.linalg.norm(n, axis=1))[:, None] * un),
        "line": (line, around),
        "sphere": (sphere, in_sphere),
        "circle": (circle, p + (in_plane - p) * (r**2 / np.sum((in_plane - p) ** 2, 1))[:, None]),
        "point_pair": (pair, None),
    }
    # a point pair: the half turn about its line, then inversion in the sphere of diameter ab, negative power
    along = np.sum((x - centre) * unit(h), 1)[:, None] * unit(h)
    turned = 2 * along - (x - centre)
    power = np.sum(h**2, 1) / np.sum((x - centre) ** 2, 1)
    expected["point_pair"] = (pair, centre + turned * power[:, None])
    for kind, (mirror, image) in expected.items():
        moved, status = Traced(cga, versors.reflect, "point", kind).all(point, mirror)
        found, _ = Traced(cga, conformal.point_parameters, "~point").all(moved)
        assert np.all(status == Status.OK)
        assert np.allclose(found, image, rtol=1e-9, atol=1e-9), kind
        in_unit = Traced(cga, versors.reflect_in_unit, "point", kind)(point, mirror)
        assert np.allclose(in_unit, moved, rtol=1e-9, atol=1e-9), kind
        again, _ = Traced(cga, versors.reflect, "~point", kind).all(moved, mirror)
        assert np.allclose(again, point, rtol=1e-9, atol=1e-9), kind
        if kind != "point_pair":
            kinds = cga.kind("point"), cga.kind(kind)
            literal = multivector(kinds[1], mirror) * multivector(kinds[0], point) * multivector(kinds[1], mirror)
            assert np.allclose(rows(kinds[0], literal), moved, atol=1e-9 * np.max(np.abs(moved)))


def test_pga_reflections_keep_points_points() -> None:
    pga = stock("pga3d")
    rng = np.random.default_rng(13)
    x, p, n = rng.normal(size=(3, 200, 3))
    un = unit(n)
    point = Traced(pga, projective.point, "euclidean")
    mirrors = {
        "plane": (Traced(pga, projective.plane, "euclidean", "number")(n, np.sum(n * p, 1)),
                  x - 2 * np.sum((x - p) * un, 1)[:, None] * un),
        "line": (Traced(pga, projective.line, "euclidean", "euclidean")(p, n),
                 2 * p + 2 * np.sum((x - p) * un, 1)[:, None] * un - x),
        "point": (point(p), 2 * p - x),
    }  # fmt: skip
    for kind, (mirror, image) in mirrors.items():
        reflected = Traced(pga, versors.reflect, "point", kind)
        assert reflected.returns == pga.kind("point")
        assert np.allclose(reflected(point(x), mirror), point(image), atol=1e-12), kind
        in_unit = Traced(pga, versors.reflect_in_unit, "point", kind)(point(x), mirror)
        assert np.allclose(in_unit, point(image), atol=1e-12), kind


def test_a_singular_mirror_is_reported() -> None:
    cga = stock("cga3d")
    point = Traced(cga, conformal.point, "euclidean")(np.array([[1.0, 2.0, 3.0]]))
    for mirror in (point, np.zeros((1, 5)), np.full((1, 5), np.nan)):
        moved, status = Traced(cga, versors.reflect, "point", "~vector").all(point, mirror)
        assert np.all(np.isnan(moved)) and np.all(status == Status.SINGULAR)


# -- norms -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "name", ["cga3d.motor", "cga3d.line", "cga3d.plane", "cga3d.sphere", "pga3d.motor", "pga3d.line", "pga3d.plane"]
)
def test_normalising_repairs_and_proves_the_kind(name: str) -> None:
    algebra, name = stock(name.partition(".")[0]), name.partition(".")[2]
    kind = algebra.kind(name)
    normalise = Traced(algebra, versors.normalise_flat, f"~{name}")
    assert normalise.returns == kind
    x = members(kind, 200, 14)
    rng = np.random.default_rng(15)
    off = x * rng.uniform(0.1, 30, (200, 1)) + 1e-3 * rng.normal(size=x.shape)
    repaired, status = normalise.all(off)
    assert np.all(status == Status.OK)
    for residual in residuals(kind, multivector(kind, repaired)):
        assert all(np.max(np.abs(c)) < 1e-11 for c in residual.terms.values())
    assert np.allclose(normalise(x * 7.0), x, atol=1e-12)
    nothing, status = normalise.all(np.zeros((1, kind.size)))
    assert np.all(np.isnan(nothing)) and np.all(status == Status.SINGULAR)


def test_null_objects_have_no_normal_form() -> None:
    cga = stock("cga3d")
    x = Traced(cga, conformal.point, "euclidean")(np.array([[0.1, 0.7, -0.3], [1e5, 3.3e4, 17.0]]))
    scaled, status = Traced(cga, versors.normalise, "~point").all(x)
    assert np.all(np.isnan(scaled)) and np.all(status == Status.SINGULAR)
    imaginary = Traced(cga, conformal.sphere, "euclidean", "number")(np.zeros((1, 3)), np.ones(1))
    dual = multivector(cga.kind("sphere"), imaginary).dual() + multivector(cga.kind("vector"), [[0, 0, 0, 0, 1.0]])
    _, status = Traced(cga, versors.normalise_flat, "~sphere").all(rows(cga.kind("sphere"), dual.undual()))
    assert np.all(status == Status.IMAGINARY)


# -- frames and linear maps --------------------------------------------------------------------------------------


def pairings(first: list[Multivector], second: list[Multivector], product: object) -> np.ndarray:
    return np.array([[np.asarray(product(x, y).terms.get(0, 0.0)) for y in second] for x in first])  # type: ignore[operator]


@pytest.mark.parametrize("algebra", [stock("cga3d"), plain(3), plain(1, 3)], ids=lambda a: a.name)
def test_reciprocal_frames(algebra: Algebra) -> None:
    kind = algebra.kind("vector")
    vectors = [multivector(kind, members(kind, 1, 20 + i)[0]) for i in range(algebra.dimension)]
    for found in (frames.reciprocal_vectors(vectors), frames.reciprocal_frame(vectors)):
        assert np.allclose(pairings(vectors, found, Multivector.scalar_product), np.eye(algebra.dimension), atol=1e-10)
    everything = algebra.kind("multivector")
    mixed = [multivector(everything, members(everything, 1, 40 + i)[0]) for i in range(4)]
    found = frames.reciprocal_frame(mixed)
    assert np.allclose(pairings(mixed, found, Multivector.scalar_product), np.eye(4), atol=1e-9)
    basis = frames.blade_frame(mixed[0], algebra.blades)
    found = frames.reciprocal_frame(basis)
    assert np.array_equal(pairings(basis, found, Multivector.scalar_product), np.eye(len(basis)))


@pytest.mark.parametrize("algebra", [stock("pga3d"), plain(2, 0, 2), stock("cga3d")], ids=lambda a: a.name)
def test_pseudo_reciprocal_frames(algebra: Algebra) -> None:
    everything = algebra.kind("multivector")
    mixed = [multivector(everything, members(everything, 1, 50 + i)[0]) for i in range(4)]
    assert np.allclose(pairings(mixed, frames.pseudo_reciprocal_frame(mixed), frames.pairing), np.eye(4), atol=1e-9)
    basis = frames.blade_frame(mixed[0], algebra.blades)
    found = frames.pseudo_reciprocal_frame(basis)
    assert np.array_equal(pairings(basis, found, frames.pairing), np.eye(len(basis)))
    for x, p in zip(basis, found, strict=True):
        assert np.array_equal(rows(everything, x ^ p), rows(everything, x.pseudoscalar()))


@pytest.mark.parametrize("algebra", [stock("cga3d"), stock("pga3d"), plain(3)], ids=lambda a: a.name)
def test_matrices_of_linear_maps_act_on_column_coefficients(algebra: Algebra) -> None:
    """A map that mixes grades and is not symmetric: the printed c_ij, its transpose, fails here."""
    everything = algebra.kind("multivector")
    a, b, x, y = (multivector(everything, members(everything, 1, 60 + i)[0]) for i in range(4))

    def function(v: Multivector) -> Multivector:
        return a * v * b + (b ^ v)

    basis = frames.blade_frame(a, algebra.blades)
    matrix = frames.matrix_of(function, basis, basis)
    numbers = np.array([[float(m.terms.get(0, 0.0)) for m in entries] for entries in matrix])
    assert np.allclose(numbers @ rows(everything, x), rows(everything, function(x)), atol=1e-12)
    applied = frames.apply_matrix(matrix, y, basis, basis)
    assert np.allclose(rows(everything, applied), rows(everything, function(y)), atol=1e-12)


def test_sandwich_as_a_matrix() -> None:
    cga = stock("cga3d")
    blades = cga.kind("point").blades

    def on_points(r: Multivector) -> Result:
        return frames.sandwich_matrix(r, blades)

    matrix = Traced(cga, on_points, "motor")
    r, x = members(cga.kind("motor"), 30, 70), members(cga.kind("point"), 30, 71)
    moved = Traced(cga, products.sandwich, "motor", "point")(r, x)
    assert np.allclose((matrix(r).reshape(-1, 5, 5) @ x[..., None])[..., 0], moved, atol=1e-10)
