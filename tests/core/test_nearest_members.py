"""The nearest member of a kind, and how far it was: objects of `clifford` moved far away, and perturbed ones."""

from __future__ import annotations

from functools import reduce
from typing import Any

import numpy as np
import pytest

import bladesmith as bs
from bladesmith import cga3d as cga
from bladesmith import errors

KINDS = ["point", "point_pair", "line", "circle", "plane", "sphere"]
COUNT = 100


def perturbed(x: Any, size: float, seed: int = 0) -> Any:
    noise = np.random.default_rng(seed).normal(size=(*x.shape, x.kind.size))
    return x._make(x._type.unconstrained, x.values * (1 + size * noise), x.shape)


def members(name: str, count: int = COUNT) -> Any:
    random = np.random.default_rng(5)
    a, b, c = random.normal(size=(3, count, 3))
    radius = random.uniform(0.5, 2, count)
    made = {
        "point": lambda: cga.point(a), "point_pair": lambda: cga.point_pair(a, b), "line": lambda: cga.line(a, b),
        "circle": lambda: cga.circle(a, b, radius), "plane": lambda: cga.plane(a, radius),
        "sphere": lambda: cga.sphere(a, radius), "flat_point": lambda: cga.flat_point(a),
        "motor": lambda: cga.translator(a) * cga.rotor(b, radius), "rotor": lambda: cga.rotor(b, radius),
        "translator": lambda: cga.translator(a),
        "rotor_conformal": lambda: (cga.dilator(radius, b) * cga.transversor(c) * cga.translator(a)),
    }  # fmt: skip
    return made[name]().as_kind(name)


@pytest.mark.parametrize("size", [1e-3, 1e-6, 1e-9])
@pytest.mark.parametrize("name", [*KINDS, "flat_point", "motor", "rotor", "translator", "rotor_conformal"])
def test_perturbed_members_come_back(name: str, size: float) -> None:
    x = members(name)
    found = perturbed(x, size).normalized(name, tolerance=20 * size)
    assert found.kind == cga.kind(name) and (np.asarray(found.status) == bs.Status.OK).all()
    assert (found.deviation <= 10 * size).all() and (found.as_kind("multivector").as_kind(name)).isclose(found).all()
    assert np.abs(found.values - x.values).max() <= 60 * size * np.abs(x.values).max()
    scaled = (3 * perturbed(x, size)).normalized(name, tolerance=20 * size)
    assert scaled.isclose(found, rtol=100 * size).all()


def test_nothing_nearer_is_found() -> None:
    """Members about the result, in all directions, are no nearer to what was given."""
    given = perturbed(members("circle", 10), 1e-2)
    found = given.normalized("circle", tolerance=0.2)
    for seed in range(200):
        step = 10.0 ** np.random.default_rng(seed).uniform(-4, -2)
        other = perturbed(found, step, seed).normalized("circle", tolerance=0.5)
        gap = [np.abs((x * (given * x.reverse())["1"] * -1 - given).values) for x in (found, other)]
        assert (gap[1].max(-1) >= 0.2 * gap[0].max(-1)).all()


def test_what_is_too_far() -> None:
    x = members("circle", 4)
    given = perturbed(x, 1e-3)
    found = given.normalized("circle", tolerance=1e-6)
    assert (found.status == bs.Status.INVALID).all() and np.isnan(found.values).all() and (found.deviation > 1e-6).all()
    with pytest.raises(errors.SingularError, match="item 0 is INVALID"):
        given.normalized("circle", tolerance=1e-6, strict=True)
    with pytest.raises(errors.KindError, match="no kind of cga3d"):
        given.normalized(tolerance=1e-6)
    assert given.normalized(tolerance=1e-2).kind == cga.kind("circle")
    with pytest.raises(errors.InputError, match="tolerance"):
        given.normalized("circle", tolerance=-1.0)
    imaginary = (cga.sphere([0, 0, 0.0], 1.0).dual() + cga.ni).undual() & cga.plane([0, 0, 1.0], 0.0)
    assert imaginary.normalized("circle", tolerance=1e-3).status is not bs.Status.OK
    mixed = cga.multivector(np.stack([x[0].values, np.full(10, np.nan), 0 * x[0].values]), blades=x.blades)
    found = mixed.normalized("circle", tolerance=1e-3)
    assert found[0].isclose(x[0]) and (np.asarray(found.status)[1:] != bs.Status.OK).all()
    assert np.isnan(found.values[1:]).all() and x.deviation is None and (found + found).deviation is None


@pytest.mark.slow
def test_precision_shape_and_other_algebras() -> None:
    x = members("circle", 6).astype(np.float32).reshape(2, 3)
    found = perturbed(x.astype(float), 1e-3).astype(np.float32).normalized("circle", tolerance=1e-2)
    assert found.dtype == np.float32 and found.shape == found.deviation.shape == (2, 3)
    pga = bs.pga3d
    for motion in (pga.rotor([1.0, 2.0, 3.0], 1.0), pga.line([1e3, 2.0, 3.0], [1.0, 1.0, 0.0])):
        near = perturbed(motion, 1e-7).normalized(motion.kind.name, tolerance=1e-5)
        assert near.kind == motion.kind and near.deviation < 1e-6 and near.isclose(motion, rtol=1e-5)


# -- clifford ----------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def conformal() -> Any:
    pytest.importorskip("clifford")
    from clifford import g3c

    return g3c


def moved(g3c: Any, name: str, far: float) -> tuple[Any, Any, np.ndarray]:
    """Objects of clifford through random points, the same moved there, and by how much."""
    random = np.random.default_rng([KINDS.index(name), int(far)])
    count = {"point": 1, "point_pair": 2, "line": 2, "circle": 3, "plane": 3, "sphere": 4}[name]
    near, there, ways = [], [], []
    for _ in range(COUNT):
        points = [g3c.up(p[0] * g3c.e1 + p[1] * g3c.e2 + p[2] * g3c.e3) for p in random.normal(size=(count, 3))]
        x = reduce(lambda a, b: a ^ b, points + [g3c.einf] * (name in ("line", "plane")))
        x = x if name == "point" else x.normal()
        t = random.normal(size=3)
        t *= far / np.linalg.norm(t)
        mover = 1 - (t[0] * g3c.e1 + t[1] * g3c.e2 + t[2] * g3c.e3) * g3c.einf / 2
        near.append(x), there.append(mover * x * ~mover), ways.append(t)
    return near, there, np.array(ways)


@pytest.mark.peers
@pytest.mark.parametrize("far", [1.0, 1e2, 1e3, 1e4])
@pytest.mark.parametrize("name", KINDS)
def test_objects_of_clifford_moved(conformal: Any, name: str, far: float) -> None:
    near, there, ways = moved(conformal, name, far)
    found = bs.from_clifford(there, cga, nearest=True, kind=name)
    assert found.kind == cga.kind(name) and (np.asarray(found.status) == bs.Status.OK).all()
    assert (found.deviation <= 1e-14 * far**2 + 1e-15).all()
    own = bs.from_clifford(near, cga, nearest=True, kind=name).parameters()
    seen = found.parameters()
    if name in ("sphere", "circle"):
        spread = (own.radius + 1 / own.radius) ** 2  # what is lost of small ones, and of large ones whose centre is far
        assert (np.abs(seen.center - own.center - ways).max(-1) <= 1e-15 * far**3 * spread).all()
        assert (np.abs(seen.radius / own.radius - 1) <= 4e-16 * far**2 * spread).all()
    if name == "point":
        assert np.abs(seen.xyz - own.xyz - ways).max() <= 1e-14 * far**2
    assert bs.from_clifford(there, cga, nearest=True).kind == cga.kind(name)


@pytest.mark.peers
def test_circles_that_were_refused(conformal: Any) -> None:
    _, there, _ = moved(conformal, "circle", 1e3)
    plain = bs.from_clifford(there, cga).grade(3)
    with pytest.raises(errors.KindError):
        plain.as_kind("circle")
    assert (np.asarray(plain.normalized("circle").status) == bs.Status.INVALID).mean() > 0.5
    found = bs.from_clifford(there[0], cga, nearest=True)
    assert found.shape == () and found.kind == cga.kind("circle") and 0 < found.deviation < 1e-9
    with pytest.raises(errors.InputError, match="nearest=True"):
        bs.from_clifford(there, cga, kind="circle")
    with pytest.raises(errors.KindError, match="no kind"):
        bs.from_clifford(there, cga, nearest=True, tolerance=1e-14)
    assert bs.from_clifford(there, cga, nearest=False).kind.is_layout
