"""Rotors between objects: what they do to objects, shapes, bad operands."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import bladesmith as bs
from bladesmith import Status, objects
from bladesmith import cga2d as plane_cga
from bladesmith import cga3d as cga

from ...support.objects.rotors import (
    CIRCLE,
    COUNT,
    GRADES,
    KINDS,
    LINE,
    MIXTURES,
    PLANE,
    TURNED,
    assert_takes,
    random_objects,
    square,
)


@pytest.mark.slow
@pytest.mark.parametrize("first, second", MIXTURES)
def test_every_mixture_at_the_scale_of_one(first: str, second: str) -> None:
    rng = np.random.default_rng(1)
    x, y = random_objects(first, rng, COUNT), random_objects(second, rng, COUNT)
    r = objects.rotor_between(x, y)
    assert_takes(r, x, y)
    if GRADES[first] < 4:
        assert (r.status == Status.OK).all()


@pytest.mark.parametrize("first, second", MIXTURES)
def test_every_mixture_at_any_scale(first: str, second: str) -> None:
    rng = np.random.default_rng(2)
    x, y = random_objects(first, rng, 20_000, spread=True), random_objects(second, rng, 20_000, spread=True)
    assert_takes(objects.rotor_between(x, y), x, y, relative=True)


@pytest.mark.compiles
@pytest.mark.parametrize("first, second", [("circle", "circle"), ("line", "line"), ("plane", "sphere")])
def test_single_precision(first: str, second: str) -> None:
    rng = np.random.default_rng(3)
    x = random_objects(first, rng, 20_000, dtype=np.float32)
    y = random_objects(second, rng, 20_000, dtype=np.float32)
    r = objects.rotor_between(x, y)
    assert r.dtype == np.float32
    assert_takes(r, x, y, 1e-13 * float(np.finfo(np.float32).eps / np.finfo(float).eps), relative=True)


@pytest.mark.parametrize("kind", [*KINDS, "flat_point"])
def test_an_object_with_itself_gives_one(kind: str) -> None:
    x = random_objects(kind, np.random.default_rng(4), 200)
    r = objects.rotor_between(x, x)
    assert (r.status == Status.OK).all()
    assert np.max(np.abs((r - 1.0).values).max(-1) / np.maximum(1, square(x))) <= 1e-15


# -- points ----------------------------------------------------------------------------------------------------


def test_points_are_translated() -> None:
    a, b = np.random.default_rng(8).normal(size=(2, 50, 3)) + 1e3
    for r in (objects.rotor_between(cga.point(a), cga.point(b)), objects.trs_rotor(cga.point(a), cga.point(b))):
        assert r.kind.name == "translator"
        assert np.allclose((r >> cga.point(a)).parameters().xyz, b, rtol=1e-14)


# -- what users hand over ----------------------------------------------------------------------------------------


def test_bad_operands() -> None:
    with pytest.raises(bs.errors.GradeError, match="same grade"):
        objects.rotor_between(LINE, PLANE)
    with pytest.raises(bs.errors.GradeError):
        objects.mirror_between(cga.point((0, 0, 0.0)), cga.point((1.0, 0, 0)))
    with pytest.raises(bs.errors.InputError):
        objects.rotor_between(LINE, 3.0)
    with pytest.raises(bs.errors.AlgebraMismatchError):
        objects.rotor_between(LINE, plane_cga.circle((0, 0.0), 1.0))
    with pytest.raises(bs.errors.ShapeError):
        objects.rotor_between(random_objects("line", np.random.default_rng(0), 2), cga.line(np.eye(3), np.eye(3)))


@pytest.mark.parametrize("function", [objects.rotor_between, objects.mirror_between, objects.trs_rotor])
def test_bad_items_are_named_and_the_others_are_done(function: Any) -> None:
    circles = cga.circle([(0, 0, 0.0), (1.0, 0, 0), (2.0, 0, 0)], (0, 0.6, 0.8), [1.0, -1.0, 2.0])
    found = function(circles, CIRCLE)
    assert list(found.status) == [Status.OK, Status.INVALID, Status.OK]
    assert np.isnan(found.values[1]).all() and np.isfinite(found.values[[0, 2]]).all()
    with pytest.raises(bs.errors.SingularError, match="item 1 is INVALID"):
        function(CIRCLE, circles, strict=True)
    twice = cga.multivector(np.stack([2 * CIRCLE.values, CIRCLE.values]), grades=[3])
    assert list(function(twice, CIRCLE).status) == [Status.INVALID, Status.OK]


def test_shapes_broadcast_and_may_be_empty() -> None:
    rng = np.random.default_rng(12)
    x, y = random_objects("circle", rng, 3)[:, None], random_objects("line", rng, 4)
    r = objects.rotor_between(x, y)
    assert r.shape == (3, 4)
    assert r[2, 1].isclose(objects.rotor_between(x[2, 0], y[1]))
    assert objects.rotor_between(x[2, 0], y[1]).shape == ()
    for function in (objects.rotor_between, objects.mirror_between, objects.trs_rotor):
        assert function(x[:0, 0], x[:0, 0]).shape == (0,)


def test_singular_far_and_ordinary_items_of_one_batch_do_not_mix() -> None:
    """Each item is what it is alone, whatever else is in the batch."""
    singles = [TURNED["circle reversed"], TURNED["circle and its axis"], (CIRCLE, LINE)]
    singles.append((cga.circle((1e6, 0, 0), (0, 0, 1), 1.0), cga.circle((1e6, 1, 0), (0, 1, 1), 2.0)))
    wide = [tuple(x.as_kind("circle") for x in pair) for pair in singles]
    r = objects.rotor_between([a for a, _ in wide], [b for _, b in wide])
    for i, pair in enumerate(wide):
        alone = objects.rotor_between(*pair)
        assert r[i].status == alone.status
        assert np.array_equal(r[i].values, alone.values)


@pytest.mark.compiles
def test_in_the_plane() -> None:
    rng = np.random.default_rng(13)
    p, q, radius = rng.normal(size=(500, 2)), rng.normal(size=(500, 2)), rng.uniform(0.1, 2, 500)
    x, y = plane_cga.point_pair(p, q), plane_cga.point_pair(q + 1, p * 2)
    r = objects.rotor_between(x, y)
    assert np.max(np.abs((r >> x).grade(2).values - y.values).max(-1) / square(r) / square(y)) <= 1e-13
    x, y = plane_cga.circle(p, radius), plane_cga.circle(q, 1.0)
    r = objects.rotor_between(x, y)
    sign = np.where(np.asarray(r.status) == Status.NOT_UNIQUE, -1.0, 1.0)[:, None]
    assert (sign < 0).any() and (sign > 0).any()
    assert np.max(np.abs((r >> x).grade(3).values - sign * y.values).max(-1) / square(r) / square(y)) <= 1e-13
    x, y = plane_cga.line((0, 0.0), (1.0, 0)), plane_cga.line((1.0, 1.0), (-1.0, 0))
    r = objects.rotor_between(x, y)
    assert r.status == Status.NOT_UNIQUE and np.allclose(
        (r >> x).grade(3).as_kind("line", check=False).values, y.values
    )
