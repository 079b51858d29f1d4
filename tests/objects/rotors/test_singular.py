"""Rotors between objects that are nearly opposite, or have no unique rotor."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bladesmith import Status, objects
from bladesmith import cga3d as cga
from bladesmith.dispatch.formulas import evaluate

from ...support.objects.rotors import (
    FLIPPED,
    MIXTURES,
    TURNED,
    assert_takes,
    coefficients,
    placed,
    random_objects,
    square,
)

EXPONENTS = (0.5, 1, 2, 3, 4, 5, 6, 6.5, 7, 7.5, 8, 10, 12, 14, 15, 16, 18)


@pytest.mark.parametrize("kind", ["point_pair", "line", "circle", "plane"])
def test_near_opposite_objects_lose_nothing(kind: str) -> None:
    """pi - e between the axes, in the same place and elsewhere: refined, then turned; never a bad sign or NaN."""
    angle = np.pi - 10.0 ** -np.array(EXPONENTS)
    axis = np.stack([np.sin(angle), np.zeros_like(angle), np.cos(angle)], -1)
    one = np.ones(len(angle))
    for shift, ratio in (((0, 0, 0), 1.0), ((0, 0, 0), 2.0), ((0.3, 1.0, -0.4), 1.5), ((0, 0, 2.0), 1.0)):
        x = placed(kind, np.zeros((len(angle), 3)), np.tile([0.0, 0, 1], (len(angle), 1)), one)
        y = placed(kind, np.tile(np.asarray(shift, float), (len(angle), 1)), axis, ratio * one)
        r = objects.rotor_between(x, y)
        assert np.isin(np.asarray(r.status), [Status.OK, Status.NOT_UNIQUE]).all()
        assert_takes(r, x, y)


@pytest.mark.parametrize("name", TURNED)
def test_where_no_unique_rotor_exists_the_first_is_turned(name: str) -> None:
    x, y = TURNED[name]
    r = objects.rotor_between(x, y)
    assert r.status == Status.NOT_UNIQUE
    assert np.abs(coefficients(r >> x) - coefficients(y)).max() <= 1e-14
    assert np.abs((r * ~r - 1.0).values).max() <= 1e-14
    first = r.values[np.nonzero(r.values)[0][0]]
    assert first > 0  # <R>_0 >= 0, or the first coefficient that is not zero


@pytest.mark.parametrize("name", ["line reversed", "plane reversed", "circle reversed", "pair reversed"])
def test_an_object_and_its_negative_are_half_a_turn_apart(name: str) -> None:
    """About an axis perpendicular to the object's: R R = -1, and R is a motion."""
    r = objects.rotor_between(*TURNED[name])
    assert np.abs((r * r + 1.0).values).max() <= 1e-14
    motion = r.as_kind("motor").parameters()
    assert np.isclose(motion.angle, np.pi) and abs(motion.advance) <= 1e-14


@pytest.mark.parametrize("name", FLIPPED)
def test_spheres_go_to_the_same_sphere_inside_out(name: str) -> None:
    x, y = FLIPPED[name]
    r = objects.rotor_between(x, y)
    assert r.status == Status.NOT_UNIQUE
    assert np.abs(coefficients(r >> x) + coefficients(y)).max() <= 1e-14


def test_spheres_that_touch_from_inside_and_planes_that_enter_are_regular() -> None:
    pairs = [
        (cga.sphere((0, 0, 0.0), 1.0), cga.sphere((1.0, 0, 0), 2.0)),
        (cga.sphere((0, 0, 0.0), 1.0), cga.plane((0, 0, -1.0), -1.0)),
    ]
    for x, y in pairs:
        r = objects.rotor_between(x, y)
        assert r.status == Status.OK
        assert_takes(r, x, y)


def test_what_is_nearly_a_rotor_becomes_one() -> None:
    """R ~R = 1 to rounding, also where the error is of grade 4, which does not commute with R."""
    rng = np.random.default_rng(14)
    x, y = random_objects("circle", rng, 500), random_objects("circle", rng, 500)
    even = objects.rotor_between(x, y).as_kind("even")
    near = even + cga.multivector(1e-3 * rng.normal(size=even.values.shape), blades=even.blades)
    r = evaluate(cga, "rotors.unit_rotor", near.as_kind("even")).value
    assert np.max(np.abs((r * ~r - 1.0).values).max(-1) / square(r)) <= 1e-14
    assert np.max(np.abs((r - even).values).max(-1) / square(r)) <= 0.1


coordinate = st.floats(-3, 3)
direction = st.tuples(coordinate, coordinate, coordinate).filter(lambda v: np.linalg.norm(v) > 0.1)
place = st.tuples(coordinate, coordinate, coordinate)


@pytest.mark.slow
@settings(max_examples=60)
@given(
    st.sampled_from(MIXTURES), place, direction, st.floats(0.05, 5), place, direction, st.floats(0.05, 5), st.booleans()
)
def test_any_pair_has_a_rotor(
    kinds: Any, c1: Any, m1: Any, r1: float, c2: Any, m2: Any, r2: float, nearly: bool
) -> None:
    if nearly:  # the second where the first is, reversed, but for a little
        c2 = np.asarray(c1) + 1e-9 * np.asarray(c2)
        m2 = -np.asarray(m1) + 1e-9 * np.asarray(m2)
    x, y = placed(kinds[0], c1, m1, r1), placed(kinds[1], c2, m2, r2)
    r = objects.rotor_between(x, y)
    assert r.status in (Status.OK, Status.NOT_UNIQUE)
    assert_takes(r, x, y, 1e-12, relative=True)
