"""Models: what they hold, what they refuse and how they say it, transforms, duplicates."""

from __future__ import annotations

import pickle

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import bladesmith as bs
from bladesmith import cga3d as cga
from bladesmith import errors
from bladesmith.registration.model.model import Model

from ...support.registration import KINDS, TURN, model_of, random_parameters, same_objects

# -- what it holds -----------------------------------------------------------------------------------------


def test_objects_are_those_of_the_constructors():
    given_ = random_parameters(np.random.default_rng(1))
    m = Model(**given_)
    assert list(m.objects) == list(KINDS) and len(m) == 24 and m.counts == dict.fromkeys(KINDS, 4)
    c = given_["circles"]
    assert m.circles.isclose(cga.circle(c[:, :3], c[:, 3:6], c[:, 6])).all()
    assert m.lines.isclose(cga.line(given_["lines"][:, 0], given_["lines"][:, 1])).all()
    assert m.planes.isclose(cga.plane(given_["planes"][:, :3], given_["planes"][:, 3])).all()
    assert m.point_pairs.isclose(cga.point_pair(given_["point_pairs"][:, 0], given_["point_pairs"][:, 1])).all()
    assert m.spheres.isclose(cga.sphere(given_["spheres"][:, :3], given_["spheres"][:, 3])).all()
    assert m.points.isclose(cga.point(given_["points"])).all()
    assert [m.slices[k] for k in KINDS] == [slice(4 * i, 4 * i + 4) for i in range(6)]
    for kind in KINDS:
        assert m.objects[kind].kind == cga.kind(kind)


def test_multivectors_lists_and_parameters_are_one():
    m = model_of(2)
    by_name = {f"{kind}s": x for kind, x in m.objects.items()}
    same_objects(Model(**by_name).objects, m.objects)
    same_objects(Model(**{k: list(x) for k, x in by_name.items()}).objects, m.objects)
    same_objects(Model(**{k: [x[0], x[1:]] for k, x in by_name.items()}).objects, m.objects)
    same_objects(Model(**{k: x[:0] if i else x for i, (k, x) in enumerate(by_name.items())}).objects,
                 {"point": m.points})  # fmt: skip
    single = Model(lines=m.lines[2])
    assert len(single) == 1 and single.lines.isclose(m.lines[2]).all()


def test_loose_and_single_precision_objects_are_taken():
    m = model_of(3)
    turned = TURN >> m.lines  # known to be lines
    scaled = (cga.dilator(2.0) * TURN) >> m.lines  # on the blades of circles, for all that is known
    same_objects(Model(lines=turned).objects, m.transformed(TURN).subset({"line": slice(None)}).objects)
    assert Model(lines=scaled).lines.kind == cga.kind("line")
    single = Model(circles=m.circles.astype(np.float32))
    assert single.circles.dtype == np.float64 and single.circles.isclose(m.circles, 1e-5).all()
    assert (np.abs((single.circles * single.circles)["1"] - 1) < 1e-14).all()  # unit in double precision


def test_inward_spheres_become_outward():
    m = Model(spheres=-cga.sphere((1, 2, 3), 2.0))
    assert m.spheres.isclose(cga.sphere((1, 2, 3), 2.0)).all()


def test_directions_of_any_length():
    for scale in (1e-300, 1e-3, 7.0, 1e300):
        m = Model(lines=[[(1, 2, 3), (0, 0, scale)]], planes=[(0, scale, 0, 2 * scale)])
        np.testing.assert_allclose(m.parameters["line"], [[1, 2, 3, 0, 0, 1]], rtol=1e-15)
        np.testing.assert_allclose(m.parameters["plane"], [[0, 1, 0, 2]], rtol=1e-15)


def test_empty_models_are_models():
    for empty in (Model(), Model(points=[]), Model(lines=np.empty((0, 2, 3)))):
        assert len(empty) == 0 and empty and empty.objects == {} and empty.points is None
        assert repr(empty) == "<Model: empty>" and len(empty.duplicates()) == 0
        assert len(empty.transformed(TURN)) == 0 and len(empty.subset([])) == 0


def test_immutable_picklable_short():
    m = model_of(4)
    with pytest.raises(AttributeError, match="cannot be changed"):
        m.name = "x"
    with pytest.raises(AttributeError):
        del m.name
    with pytest.raises(ValueError):
        m.parameters["line"][0, 0] = 1
    again = pickle.loads(pickle.dumps(m))
    assert repr(again) == repr(m) and len(repr(m)) < 100
    for kind, rows in m.parameters.items():
        np.testing.assert_array_equal(again.parameters[kind], rows)
    again.objects.clear()
    assert len(again.objects) == 6 and again.points is not None


# -- what it refuses ---------------------------------------------------------------------------------------

LINES, CIRCLES = cga.line(np.eye(3), (0, 0, 1)), cga.circle(np.eye(3), (0, 0, 1), 1.0)
WRONG = [
    ({"circles": LINES}, r"circles\[0\] is a line.*lines"),
    ({"lines": CIRCLES}, r"lines\[0\] is a circle.*circles"),
    ({"circles": LINES.as_kind(cga.kind("circle").layout)}, r"circles\[0\] is a line.*lines"),
    ({"lines": [LINES[0], CIRCLES[1]]}, r"lines\[1\] is a circle.*circles"),
    ({"planes": cga.sphere((0, 0, 0), 1.0)}, r"planes\[0\] is a sphere.*spheres"),
    ({"points": LINES}, "points are a line of grades.*lines"),
    ({"point_pairs": cga.flat_point((1, 2, 3))}, "point_pairs"),
    ({"lines": 2 * LINES}, r"lines\[0\] is not a unit line.*normalized"),
    ({"points": 2 * cga.point((0, 0, 1))}, r"points\[0\] is not a unit point.*normalized"),
    ({"lines": LINES[:1] + cga.line((5, 0, 3), (0, 1, 1))}, r"lines\[0\] is not a blade.*project_to_blade"),
    ({"circles": cga.multivector({"e123": 1.0})}, r"circles\[0\] is an imaginary circle"),
    ({"lines": cga.line(np.zeros((2, 3)), [(0, 0, 1), (0, 0, 0)])}, r"lines\[1\].*INVALID"),
    ({"lines": bs.pga3d.line((0, 0, 0), (0, 0, 1))}, "pga3d"),
    ({"lines": [LINES[0], (0, 0, 1)]}, r"lines\[1\] is .0, 0, 1.; a multivector"),
    ({"points": [(0, 0, 0), (0, np.nan, 0)]}, r"points\[1\].xyz is .*nan.*finite"),
    ({"spheres": [(0, 0, 0, np.inf)]}, r"spheres\[0\].radius"),
    ({"spheres": [(0, 0, 0, 1), (0, 0, 0, -1)]}, r"spheres\[1\].radius is -1.0; a radius is positive"),
    ({"circles": [(0, 0, 0, 0, 0, 1, 0)]}, r"circles\[0\].radius is 0.0"),
    ({"planes": [(0, 0, 0, 1)]}, r"planes\[0\].normal is .*direction is not zero"),
    ({"planes": [(0, 1e-300, 0, 1)]}, r"planes\[0\].offset"),
    ({"lines": [[(0, 0, 0), (0, 0, 0)]]}, r"lines\[0\].direction"),
    ({"point_pairs": [[(1, 2, 3), (1, 2, 3)]]}, r"point_pairs\[0\].b .*two end points"),
    ({"points": (0, 0, 0)}, r"points has shape \(3,\); \(n, 3\).*list"),
    ({"points": np.zeros((2, 4))}, r"\(n, 3\)"),
    ({"lines": np.zeros((2, 6))}, r"\(n, 2, 3\) of point, direction"),
    ({"points": np.zeros((2, 3), complex)}, "complex"),
    ({"points": np.full((2, 3), "1")}, "real numbers are needed"),
    ({"points": np.full((2, 3), None)}, "real numbers are needed"),
    ({"points": np.ones((2, 3), bool)}, "truth values"),
    ({"circles": [((0, 0, 0), (0, 0, 1), 1)]}, r"ragged.*\(n, 7\)"),
    ({"points": "abc"}, "points"),
    ({"points": 5}, r"points is 5.0; \(n, 3\) is needed"),
    ({"points": [(1e200, 0, 0)]}, r"points\[0\].*unit of length"),
    ({"points": cga.point(np.zeros((2, 2, 3)))}, "reshape"),
    ({"name": 3}, "name is 3; a text"),
    ({"name": "\ud800"}, "name"),
]


@pytest.mark.parametrize("arguments, message", WRONG, ids=lambda x: x if isinstance(x, str) else None)
def test_bad_input_names_list_item_and_remedy(arguments, message):
    with pytest.raises(errors.InputError, match=message):
        Model(**arguments)


@settings(max_examples=50, deadline=None)
@given(st.sampled_from(KINDS), st.integers(0, 5), st.sampled_from([np.nan, np.inf, -np.inf]), st.data())
def test_a_number_that_is_none_is_found_wherever_it_is(kind, item, value, data):
    rows = random_parameters(np.random.default_rng(0), n=6)[f"{kind}s"]
    flat = rows.reshape(6, -1)
    flat[item, data.draw(st.integers(0, flat.shape[1] - 1))] = value
    with pytest.raises(errors.InputError, match=rf"{kind}s\[{item}\]\."):
        Model(**{f"{kind}s": rows})


# -- moved, taken from, in other frames --------------------------------------------------------------------


@pytest.mark.parametrize("R", [TURN, cga.translator((5, 0, 0)), cga.rotor((0, 0, 1), 3.1), -TURN,
                               cga.dilator(3.0, (1, 2, 0)), cga.dilator(0.2) * TURN], ids=str)  # fmt: skip
def test_transformed_is_the_sandwich(R):
    m = model_of(5)
    moved = m.transformed(R)
    for kind, x in m.objects.items():
        expected = (R >> x).normalized(kind)
        assert moved.objects[kind].isclose(expected, 1e-12).all(), kind


@pytest.mark.parametrize("R, message", [
    (cga.transversor((0.1, 0, 0)), "n_inf"), (2.0 * TURN, "not 1"), (cga.plane((0, 0, 1), 0.0), "no|n_inf|not 1"),
    (cga.e1, "even"), (cga.multivector({"1": np.nan, "e12": 1.0}), "finite"),
    (np.eye(3), r"\(\.\.\., 4, 4\) is needed"),
    ((0.5 * bs.vga3d.e12).exp(), "vga3d"), (cga.translator(np.eye(3)), "one rotor"),
])  # fmt: skip
def test_what_moves_no_model_is_refused(R, message):
    with pytest.raises((errors.InputError, errors.AlgebraMismatchError), match=message):
        model_of().transformed(R)


@pytest.mark.parametrize("scale", [1e-9, 1e-3, 1.0, 1e3, 1e9])
def test_similarities_of_any_scale_keep_digits(scale):
    m, matrix = model_of(10), TURN.to_matrix()
    moved = m.transformed(cga.dilator(scale) * TURN).parameters
    turned = m.parameters["point"] @ matrix[:3, :3].T + matrix[:3, 3]
    np.testing.assert_allclose(moved["point"], scale * turned, rtol=1e-12, atol=1e-15 + 1e-13 * scale)
    np.testing.assert_allclose(moved["sphere"][:, 3], scale * m.parameters["sphere"][:, 3], rtol=1e-13)
    np.testing.assert_allclose(moved["line"][:, 3:], m.parameters["line"][:, 3:] @ matrix[:3, :3].T, atol=1e-14)


@pytest.mark.parametrize("scale", [1e95, 1e-95])
def test_what_leaves_the_numbers_is_refused(scale):
    with pytest.raises(errors.InputError, match="unit of length"):
        model_of().transformed(cga.dilator(scale))
    with pytest.raises(errors.InputError, match="unit of length"):
        model_of().in_frame((0, 0, 0), 1 / scale).in_frame((0, 0, 0), 1 / scale)


def test_small_rounds_far_away_keep_their_digits():
    """Coefficients of a circle of radius 1 at 1e6 hold it to 1e-4; parameters do not care."""
    far = cga.translator((1e6, -2e6, 3e6))
    m = model_of(6)
    back = m.transformed(far).transformed(~far)
    for kind, rows in m.parameters.items():
        np.testing.assert_allclose(back.parameters[kind], rows, atol=4e-9, rtol=0)
    framed = m.transformed(far).in_frame((1e6, -2e6, 3e6), 2.0)
    expected = m.in_frame((0, 0, 0), 2.0)
    for kind, rows in expected.parameters.items():
        np.testing.assert_allclose(framed.parameters[kind], rows, atol=4e-9, rtol=0)


def test_in_frame_is_seen_from_there():
    m = model_of(7)
    expected = m.transformed(cga.dilator(0.5) * cga.translator((-1, 2, -3)))
    same_objects(m.in_frame((1, -2, 3), 2.0).objects, expected.objects)
    for wrong in (0.0, -1.0, np.nan, np.inf, 5e-324):
        with pytest.raises(errors.InputError, match="unit"):
            m.in_frame((0, 0, 0), wrong)


def test_subset():
    m = model_of(8)
    every = {k: np.arange(s.start, s.stop) for k, s in m.slices.items()}
    mask = np.zeros(len(m), bool)
    mask[[0, 5, 9, 23]] = True
    for chosen in (mask, [0, 5, 9, 23], np.array([23, 9, 5, 0]), [0, 5, 9, -1]):
        part = m.subset(chosen)
        assert part.counts == {"point": 1, "point_pair": 1, "line": 1, "sphere": 1}
        np.testing.assert_array_equal(part.parameters["line"], m.parameters["line"][[1]])
    part = m.subset({"lines": [3, 1], "circle": slice(1, 3), "planes": every["plane"] < 17})
    np.testing.assert_array_equal(part.parameters["line"], m.parameters["line"][[3, 1]])
    assert part.counts == {"line": 2, "circle": 2, "plane": 1}
    for wrong in ([24], mask[:3], {"lines": [4]}, {"cubes": [0]}, [0.5], [[0]]):
        with pytest.raises(errors.InputError):
            m.subset(wrong)


# -- duplicates --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("size, offset", [(1.0, 0.0), (1e-6, 0.0), (1e5, 0.0), (1.0, 1e4)])
def test_duplicates_are_found_however_they_are_written(size, offset):
    m = model_of(9, size=size, offset=offset)
    p = {k: np.array(rows) for k, rows in m.parameters.items()}
    p["line"][:, :3] += size * p["line"][:, 3:]  # another point of it
    p["line"][:, 3:] *= -1
    p["circle"][:, 3:6] *= -1
    p["plane"] *= -1
    p["point_pair"] = p["point_pair"][:, [3, 4, 5, 0, 1, 2]]
    both = {k: np.concatenate([m.parameters[k], p[k][::-1]]) for k in KINDS}
    shaped = {f"{k}s": r.reshape(-1, 2, 3) if k in ("line", "point_pair") else r for k, r in both.items()}
    found = Model(**shaped).duplicates().reshape(6, 8) - 8 * np.arange(6)[:, None]
    np.testing.assert_array_equal(found, np.tile([0, 1, 2, 3, 3, 2, 1, 0], (6, 1)))
    np.testing.assert_array_equal(m.duplicates(), np.arange(24))


def test_near_objects_are_no_duplicates_but_with_a_tolerance():
    m = Model(points=[(0, 0, 0), (1, 1, 1), (0, 0, 1e-6), (1, 1, 1)])
    assert m.duplicates().tolist() == [0, 1, 2, 1]
    assert m.duplicates(1e-5).tolist() == [0, 1, 0, 1]
    assert len(m.subset(np.unique(m.duplicates()))) == 3
    with pytest.raises(errors.InputError):
        m.duplicates(-1.0)
