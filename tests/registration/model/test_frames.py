"""Frames of models: where they stand and what is seen from there, against plain geometry in NumPy."""

from __future__ import annotations

import numpy as np
import pytest

from bladesmith import cga3d
from bladesmith.codegen.build.extension import compiler
from bladesmith.codegen.programs.registration.registration import DIRECTED, KINDS, matched_as
from bladesmith.dispatch.formulas import ArrayOperand, evaluate
from bladesmith.registration.backends.driver import Driver
from bladesmith.registration.model.normalization import (
    OUTLIER_FACTOR,
    SIZE_QUANTILE,
    model_size,
    motors_to_world,
    normalize_pair,
    robust_center,
    twists_to_world,
)

pytestmark = pytest.mark.skipif(compiler() is None, reason="no C compiler")
COUNT = 30


@pytest.fixture(scope="module")
def driver():
    return Driver(KINDS)


def parameters(seed, count=COUNT):
    rng = np.random.default_rng(seed)
    along = rng.normal(size=(count, 3))
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    return rng.uniform(-1, 1, (count, 3)), along, rng.uniform(0.1, 0.5, count)


def made(kind, places, along, sizes):
    return {
        "point": lambda: cga3d.point(places),
        "point_pair": lambda: cga3d.point_pair(places - sizes[:, None] * along, places + sizes[:, None] * along),
        "line": lambda: cga3d.line(places, along),
        "circle": lambda: cga3d.circle(places, along, sizes),
        "plane": lambda: cga3d.plane(along, (places * along).sum(1)),
        "sphere": lambda: cga3d.sphere(places, sizes),
    }[matched_as(kind)]()


def projectors(kind, along):
    """To the directions in which an object places a point."""
    own = np.einsum("ni,nj->nij", along, along)
    return {"line": np.eye(3) - own, "plane": own}.get(matched_as(kind), np.tile(np.eye(3), (len(along), 1, 1)))


# -- elements ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("directed", [0.0, 1.0])
@pytest.mark.parametrize("align", [False, True])
def test_how_far_elements_are_apart(directed, align):
    rng = np.random.default_rng(1)
    a, b = rng.normal(size=(2, COUNT, 7))
    for e in (a, b):
        e[:, 3:6] *= directed / np.linalg.norm(e[:, 3:6], axis=1, keepdims=True)
    weights = (0.7, 2 * 0.3, 0.9)
    given = [ArrayOperand(a, 7, "a"), ArrayOperand(b, 7, "b"), ArrayOperand(np.tile(weights, (COUNT, 1)), 3, "weights")]
    given += [ArrayOperand(np.full(COUNT, x), 0, "flag") for x in (directed, -1.0 if align else 1.0)]
    square, cosine = evaluate(cga3d, "registration.apart", *given).values
    expected = (a[:, 3:6] * b[:, 3:6]).sum(1)
    angle = np.arccos(np.clip(np.abs(expected) if align else expected, -1, 1)) if directed else np.zeros(COUNT)
    turn = (2 * np.sin(angle / 2)) ** 2
    total = 0.7 * ((a - b)[:, :3] ** 2).sum(1) + 0.3 * turn + 0.9 * (a - b)[:, 6] ** 2
    np.testing.assert_allclose(cosine[:, 0], expected, atol=1e-15)
    np.testing.assert_allclose(square[:, 0], total, atol=1e-14)


@pytest.mark.parametrize("kind", ["position", "line", "plane"])
def test_how_far_a_point_is_off(kind):
    places, along, _ = parameters(2)
    rng = np.random.default_rng(3)
    points, step = rng.normal(size=(2, COUNT, 3))
    elements = np.column_stack([places, along, np.zeros(COUNT)])

    def off(p):
        found = evaluate(cga3d, f"registration.off_{kind}", cga3d.spatial(p, "p"), ArrayOperand(elements, 7, "a"))
        return list(found.values)

    square, gradient, matrix = off(points)
    apart = points - places
    lengths = {
        "position": lambda: np.linalg.norm(apart, axis=1),
        "line": lambda: np.linalg.norm(np.cross(apart, along), axis=1),
        "plane": lambda: np.abs((apart * along).sum(1)),
    }[kind]()
    np.testing.assert_allclose(square[:, 0], lengths**2, rtol=1e-12)
    full = np.zeros((COUNT, 3, 3))
    rows, columns = np.triu_indices(3)
    full[:, rows, columns] = full[:, columns, rows] = matrix
    second = np.einsum("ni,nij,nj->n", step, full, step)
    expected = lengths**2 + 2 * (gradient * step).sum(1) + second
    np.testing.assert_allclose(off(points + step)[0][:, 0], expected, rtol=1e-9)


# -- frames ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("far", [1.0, 1e4])
def test_objects_are_seen_from_an_origin(driver, kind, far):
    places, along, sizes = parameters(4)
    origin = far * np.array((0.6, -0.3, 0.8))
    found = driver.to_frame(kind, made(kind, places + origin, along, sizes)._data, origin)
    expected = made(kind, places, along, sizes)._data
    rounding = 1e-12 * far if kind in ("line", "plane") else 1e-13 * far * far
    np.testing.assert_allclose(found, expected, atol=rounding)


@pytest.mark.parametrize("kinds", [("line",), ("plane",), ("point", "circle"), ("line", "plane", "sphere")])
def test_the_middle_is_nearest_to_all(driver, kinds):
    """It is what solves the equations of least squares for all objects but the far ones; those do no harm."""
    elements = {}
    for i, kind in enumerate(kinds):
        places, along, sizes = parameters(5 + i)
        elements[kind] = driver.elements(kind, made(kind, places + (5, 2, 1), along, sizes)._data)
    found = robust_center(driver, elements)
    across = np.concatenate([projectors(kind, e[:, 3:6]) for kind, e in elements.items()])
    places = np.concatenate([e[:, :3] for e in elements.values()])
    off = np.einsum("ni,nij,nj->n", places - found, across, places - found)
    near = off <= OUTLIER_FACTOR**2 * np.sort(off)[round(SIZE_QUANTILE * (len(off) - 1))]
    assert near.mean() > 0.9
    expected = np.linalg.solve(across[near].sum(0), np.einsum("nij,nj->i", across[near], places[near]))
    np.testing.assert_allclose(found, expected, atol=1e-12)
    elements[kinds[0]] = np.concatenate([elements[kinds[0]], elements[kinds[0]][:4] + (60, 70, -80, 0, 0, 0, 0)])
    np.testing.assert_allclose(robust_center(driver, elements), found, atol=1e-12)


def test_parallel_lines_place_the_middle_but_along_them(driver):
    places, _, _ = parameters(8)
    elements = {"line": driver.elements("line", cga3d.line(places + (0, 0, 9), np.tile((0.0, 0, 1), (COUNT, 1)))._data)}
    np.testing.assert_allclose(robust_center(driver, elements), [*places[:, :2].mean(0), 0], atol=1e-12)


def test_both_models_have_one_unit_and_elements_of_what_they_hold(driver):
    query, reference = ({k: made(k, *parameters(s)) for k in KINDS} for s in (9, 10))
    shift = cga3d.translator((30.0, -20.0, 5.0))
    pair = normalize_pair(driver, {k: shift >> x for k, x in query.items()}, {k: x for k, x in reference.items()})
    assert pair[0].unit == pair[1].unit and np.log2(pair[0].unit) % 1 == 0
    assert 0.5 < max(model_size(local.data.elements) for local in pair) < 2
    for local, given in zip(pair, (query, reference), strict=True):
        for kind in KINDS:
            again = driver.elements(kind, local.data.rows[kind])
            assert np.array_equal(again, local.data.elements[kind])
            assert np.array_equal(local.objects[kind]._data, local.data.rows[kind])
            radii = driver.elements(kind, given[kind]._data)[:, 6] / local.unit
            np.testing.assert_allclose(again[:, 6], radii, atol=1e-9)
            assert (np.linalg.norm(again[:, 3:6], axis=1) > 0.5).all() == (kind in DIRECTED)


def test_motors_and_twists_of_frames_are_told_to_the_world(driver):
    rng = np.random.default_rng(11)
    lines = {"line": made("line", *parameters(12))}
    moved = {"line": cga3d.translator((3.0, 4.0, -7.0)) >> lines["line"]}
    query, reference = normalize_pair(driver, lines, moved)
    inside = cga3d.translator(rng.normal(size=(5, 3))) * cga3d.rotor(rng.normal(size=(5, 3)), rng.uniform(3, 6, 5))
    rows = np.array(inside.as_kind("motor")._data)
    world = motors_to_world(driver, rows, query, reference, cga3d)
    assert (world.values[:, 0] > 0).all() and (rows[:, 0] < 0).any()
    there, back = np.tile(np.eye(4), (2, 1, 1))
    there[:3, 3], back[:3, 3] = reference.center, -query.center
    grown = np.diag([query.unit] * 3 + [1])
    expected = there @ grown @ inside.to_matrix() @ np.linalg.inv(grown) @ back
    np.testing.assert_allclose(world.to_matrix(), expected, atol=1e-12)
    twists = 1e-6 * rng.normal(size=(5, 6))
    small = cga3d.wrap(cga3d.kind("twist"), twists).exp().to_matrix()
    told = twists_to_world(driver, twists, reference, cga3d).exp().to_matrix()
    there_and_back = there @ grown @ small @ np.linalg.inv(grown) @ np.linalg.inv(there)
    np.testing.assert_allclose(told, there_and_back, atol=1e-13)
    assert twists_to_world(driver, np.empty((0, 6)), reference, cga3d).shape == (0,)
