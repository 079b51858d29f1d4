"""Mirrors and similarities between objects."""

from __future__ import annotations

import numpy as np
import pytest

import bladesmith as bs
from bladesmith import Status, objects
from bladesmith import cga3d as cga

from ...support.objects.rotors import (
    FLIPPED,
    GRADES,
    MIXTURES,
    SPHERE,
    TURNED,
    coefficients,
    largest,
    negative,
    parameters,
    placed,
    random_objects,
    square,
)

# -- mirrors ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("first, second", MIXTURES)
def test_mirrors(first: str, second: str) -> None:
    rng = np.random.default_rng(9)
    x, y = random_objects(first, rng, 5000), random_objects(second, rng, 5000)
    m = objects.mirror_between(x, y)
    assert m.grades == x.grades
    apart = np.asarray(objects.rotor_between(x, y).status) == Status.NOT_UNIQUE  # spheres whose mirror is imaginary
    assert ((np.asarray(m.status) == Status.IMAGINARY) == apart).all()
    assert np.isnan(m.values[apart]).all() and np.isfinite(m.values[~apart]).all()
    gamma = -1 if GRADES[first] == 4 else 1
    x, y, m = x[~apart], y[~apart], m[~apart]
    error = np.abs(coefficients(m * x * m, GRADES[first]) - gamma * coefficients(y)).max(-1)
    assert np.max(error / np.maximum(1, square(m)) / np.maximum(1, largest(x))) <= 1e-11


def test_the_mirror_of_two_planes_halves_their_angle() -> None:
    m = objects.mirror_between(cga.plane((1.0, 0, 0), 0.0), cga.plane((0, 1.0, 0), 0.0)).parameters()
    assert np.allclose(m.normal, np.array([1, 1, 0]) / np.sqrt(2)) and np.isclose(m.offset, 0)


def test_mirrors_that_do_not_exist() -> None:
    for name in ("line reversed", "opposite lines apart", "opposite planes apart", "circle and its axis"):
        assert objects.mirror_between(*TURNED[name]).status == Status.SINGULAR
    for name in ("sphere inside out", "spheres tangent from outside"):
        assert objects.mirror_between(*FLIPPED[name]).status == Status.SINGULAR
    assert objects.mirror_between(*FLIPPED["spheres apart"]).status == Status.IMAGINARY
    assert objects.mirror_between(*TURNED["opposite coaxial circles"]).status == Status.IMAGINARY
    with pytest.raises(bs.errors.SingularError, match="mirror_between: it is IMAGINARY"):
        objects.mirror_between(*FLIPPED["spheres apart"], strict=True)


# -- similarities ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", ["point_pair", "circle", "sphere"])
@pytest.mark.parametrize("shift", [0.0, 1e6])
def test_similarities(kind: str, shift: float) -> None:
    """They take x1 to x2, every distance to its multiple, and infinity to infinity."""
    rng = np.random.default_rng(10)
    (c1, m1, r1), (c2, m2, r2) = parameters(rng, 2000), parameters(rng, 2000)
    c1, c2 = c1 + shift, c2 + shift
    x, y = placed(kind, c1, m1, r1), placed(kind, c2, m2, r2)
    z = objects.trs_rotor(x, y)
    assert (z.status == Status.OK).all() and (z["1"] >= 0).all()
    transversion = [str(blade) for blade in z.blades if "no" in str(blade) and "ni" not in str(blade)]
    assert all((z[blade] == 0).all() for blade in transversion)
    assert np.max(np.abs((z * ~z - 1.0).values).max(-1) / np.maximum(1, square(z))) <= 1e-14
    offset = rng.normal(size=(2000, 3)) * r1[:, None]
    images = [z >> cga.point(p) for p in (c1, c1 + offset)]
    places = [np.stack([x[e] / x["no"] for e in ("e1", "e2", "e3")], -1) for x in images]
    assert np.max(np.abs(places[0] - c2) / (1 + shift)) <= 1e-12
    ratio = np.linalg.norm(places[1] - places[0], axis=-1) / np.linalg.norm(offset, axis=-1)
    assert np.max(np.abs(ratio * r1 / r2 - 1)) <= 1e-11 * max(1, shift / 10)
    if shift == 0:
        error = np.abs(coefficients(z >> x) - coefficients(y)).max(-1)
        assert np.max(error / largest(y) / np.maximum(1, square(z))) <= 1e-13


@pytest.mark.parametrize("kind", ["point_pair", "circle", "sphere"])
@pytest.mark.parametrize("size", [1e12, 1e14, 1e15, 1e30, 1e100])
def test_similarities_do_not_depend_on_the_unit_of_length(kind: str, size: float) -> None:
    """A radius of 1e15 is no flat; what has the distance of its center for a radius could be one (see the notes)."""
    rng = np.random.default_rng(12)
    (c1, m1, r1), (c2, m2, r2) = parameters(rng, 2000), parameters(rng, 2000)
    clear = [np.abs(np.linalg.norm(c, axis=-1) / r - 1) > 0.005 for c, r in ((c1, r1), (c2, r2))]
    good = clear[0] & clear[1]
    x, y = placed(kind, c1 * size, m1, r1 * size), placed(kind, c2 * size, m2, r2 * size)
    z, expected = objects.trs_rotor(x, y), objects.trs_rotor(placed(kind, c1, m1, r1), placed(kind, c2, m2, r2))
    assert good.sum() > 1000 and (z.status[good] == expected.status[good]).all()
    assert np.abs(z["noni"] - expected["noni"])[good].max() <= 1e-14 * np.abs(expected["noni"][good]).max()
    shift = np.stack([(z[e] / size - expected[e])[good] for e in ("e1ni", "e2ni", "e3ni")])
    assert np.abs(shift).max() <= 1e-13 * max(np.abs(expected[e]).max() for e in ("e1ni", "e2ni", "e3ni"))


@pytest.mark.parametrize("kind", ["line", "plane", "flat_point"])
def test_flats_are_moved_without_scaling(kind: str) -> None:
    rng = np.random.default_rng(11)
    x, y = random_objects(kind, rng, 500), random_objects(kind, rng, 500)
    z = objects.trs_rotor(x, y)
    assert (z.status == Status.OK).all()
    assert np.max(np.abs(z["noni"])) <= 1e-15
    assert np.max(np.abs(coefficients(z >> x) - coefficients(y)).max(-1)) <= 1e-13


def test_similarities_that_are_not_unique_or_not_there() -> None:
    circle = cga.circle((0, 0, 0.0), (0, 0, 1.0), 1.0)
    for tilt in (0.0, 1e-16, 1e-15, 1e-13, 1e-9, 1e-3):
        other = cga.circle((1.0, 2.0, 3.0), (0, tilt, -1.0), 2.0)
        z = objects.trs_rotor(circle, other)
        assert z.status == (Status.NOT_UNIQUE if tilt < 1e-14 else Status.OK)
        assert np.abs(coefficients(z >> circle) - coefficients(other)).max() <= 1e-14
    z = objects.trs_rotor(SPHERE, negative(SPHERE))
    assert z.status == Status.NOT_UNIQUE and np.abs((z - 1.0).values).max() <= 1e-14
    lines_among_circles = cga.line([(0, 0, 0.0), (1.0, 0, 0)], (0, 0, 1.0))
    z = objects.trs_rotor(circle, lines_among_circles)
    assert (z.status == Status.SINGULAR).all() and np.isnan(z.values).all()
    with pytest.raises(bs.errors.SingularError, match="trs_rotor: item 0 is SINGULAR"):
        objects.trs_rotor(circle, lines_among_circles, strict=True)
