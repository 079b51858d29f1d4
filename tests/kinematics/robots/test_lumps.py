"""Links welded to each other, as one body: inertias against sums over point masses; inertias that no body can have."""

import warnings

import numpy as np
import pytest

import bladesmith as bs
from bladesmith.errors import InputError
from bladesmith.kinematics.robots.description import LinkInertia
from bladesmith.kinematics.robots.inertias import possible_inertia

from .texts import joint, link, robot

ALGEBRAS = [bs.cga3d, bs.pga3d]


def cloud(rng, n=40):
    """Point masses, their mass, center and tensor about it: sums over points."""
    points, masses = rng.normal(size=(n, 3)), rng.uniform(0.1, 1.0, n)
    return points, masses, *properties(points, masses)


def properties(points, masses):
    mass, center = masses.sum(), masses @ points / masses.sum()
    x = points - center
    tensor = np.einsum("n,nij->ij", masses, (x * x).sum(-1)[:, None, None] * np.eye(3) - x[:, :, None] * x[:, None])
    return mass, center, tensor


def inertial(name, mass, center, tensor):
    origin = f'<origin xyz="{" ".join(map(repr, center.tolist()))}"/>'
    return link(
        name, repr(float(mass)), np.diag(tensor).tolist(), origin,
        (float(tensor[0, 1]), float(tensor[0, 2]), float(tensor[1, 2])),
    )  # fmt: skip


@pytest.mark.parametrize("algebra", ALGEBRAS, ids=lambda a: a.name)
def test_lumps_are_sums_of_their_points(load, algebra):
    rng = np.random.default_rng(1)
    clouds = {name: cloud(rng) for name in "bcd"}
    text = robot(
        link("a", 3.0) + "".join(inertial(n, *c[2:]) for n, c in clouds.items()) + link("e")
        + joint("j", "revolute", "a", "b", '<origin xyz="1 2 3"/><axis xyz="0 1 0"/>')
        + joint("f", "fixed", "b", "c", '<origin xyz="0.1 -0.4 2" rpy="0 0 1.5707963267948966"/>')
        + joint("g", "fixed", "c", "e", '<origin xyz="1 1 1"/>')
        + joint("h", "fixed", "e", "d", '<origin xyz="-3 0 0.5"/>')
    )  # fmt: skip
    found = load(text, algebra)
    quarter = np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]])
    points = [
        clouds["b"][0],
        clouds["c"][0] @ quarter.T + [0.1, -0.4, 2],
        (clouds["d"][0] + [-2, 1, 1.5]) @ quarter.T + [0.1, -0.4, 2],
    ]
    mass, center, tensor = properties(np.concatenate(points), np.concatenate([clouds[n][1] for n in "bcd"]))
    assert list(found.lumps) == ["a", "b"] and set(found.lumps["b"].links) == set("bcde")
    assert found.lump_of == {"a": "a", **dict.fromkeys("bced", "b")} and found.lumps["b"].joint.name == "j"
    inertia = found.lumps["b"].inertia
    assert inertia.mass == pytest.approx(mass, rel=1e-14)
    assert np.abs(inertia.center - center).max() < 1e-14
    assert np.abs(inertia.tensor_along_link - tensor).max() < 1e-11
    system = found.system({"j": np.pi / 2})
    assert list(system.bodies) == ["b"] and len(system.joints) == 1 and system.fixed == "a"
    turned = np.array([[0.0, 0, 1], [0, 1, 0], [-1, 0, 0]])
    assert np.abs(system.bodies["b"].position - (turned @ center + [1, 2, 3])).max() < 1e-13
    free = found.system(base="free")
    assert list(free.bodies) == ["a", "b"] and free.fixed == "world"


def test_the_roots_inertia_is_not_needed(load):
    text = robot(link("a", 1.0, (-1.0, 2, 3)) + link("b", 1.0) + joint())
    assert list(load(text).system().bodies) == ["b"]
    with pytest.raises(InputError, match="name='a'.*a principal moment of -1"):
        load(text).system(base="free")


def test_massless_ends_are_left_out(load):
    text = robot(link("a") + link("b", 1.0) + link("c") + joint() + joint("k", parent="b", child="c"))
    system = load(text).system()
    assert list(system.bodies) == ["b"] and len(system.joints) == 1


def test_robots_that_cannot_be_systems_say_why(load):
    with pytest.raises(InputError, match="robot.urdf: no link that moves has a mass: the file is for kinematics"):
        load(robot(link("a") + link("b") + joint())).system()
    with pytest.raises(InputError, match="one body, and its root is fixed.*base='free'"):
        load(robot(link("a", 1.0) + link("b") + joint("f", "fixed"))).system()
    with pytest.raises(InputError, match="name='a'> carries others, and has no mass"):
        load(robot(link("a") + link("b", 1.0) + joint())).system(base="free")
    with pytest.raises(InputError, match=r"the mass of <link name='b'> is -1; it is positive"):
        load(robot(link("a") + link("b", -1.0) + joint())).system()


@pytest.mark.parametrize(
    "moments", [(1e-5, 2e-5, 3.0002e-5), (-4.42e-22, 3e-6, 3e-6), (0.0, 0.0, 0.0), (0.0, 1e-4, 1e-4)]
)
def test_inertias_that_rounding_explains(load, moments):
    text = robot(link("a") + link("b", 0.1, moments) + joint(inside='<origin xyz="0 0 1"/><axis xyz="0 0 1"/>'))
    with pytest.warns(UserWarning, match="the nearest ones are taken: <link name='b'>") as caught:
        body = load(text).system().bodies["b"]
    assert len(caught) == 1 and caught[0].filename == __file__
    found = np.sort(body.moments)
    assert found[0] > 0 and found[2] <= found[0] + found[1]
    assert np.abs(found - np.sort(moments)).max() <= max(1e-3 * max(moments), 0.1 * 1e-8)


def test_impossible_inertias_load_and_are_refused_as_systems(load):
    text = robot(link("a") + link("b", 1.0, (1.0, 2.0, 3.3)) + joint())
    found = load(text)
    assert found.mechanism().mobility() == 1 and found.lumps["b"].inertia.tensor[2, 2] == 3.3
    with pytest.raises(InputError, match=r"robot.urdf: .*moment of 3.3, which exceeds.*others, 3.*inertia='nearest'"):
        found.system()
    with pytest.warns(UserWarning, match=r"by 0.1 of 3.3"):
        body = found.system(inertia="nearest").bodies["b"]
    # the nearest point of the plane x + y = z to (1, 2, 3.3)
    assert np.abs(np.sort(body.moments) - [1.1, 2.1, 3.2]).max() < 1e-12
    with pytest.raises(InputError, match="inertia"):
        found.system(inertia="any")


def test_nearest_moments_are_nearest():
    rng = np.random.default_rng(3)
    grid = rng.uniform(0, 4, (200_000, 3))
    grid = grid[2 * grid.max(-1) <= grid.sum(-1)]
    for moments in rng.uniform(-1, 4, (20, 3)):
        axes, _ = np.linalg.qr(rng.normal(size=(3, 3)))
        given = LinkInertia(1.0, axes * moments @ axes.T, np.eye(4))
        found = possible_inertia(given, "x", 1e-3, "nearest", [])
        near = np.sort(np.linalg.eigvalsh(found.tensor))
        best = np.linalg.norm(grid - moments, axis=-1).min()
        assert np.linalg.norm(near - np.sort(moments)) < best + 1e-9
        assert 2 * near[2] <= near.sum() * (1 + 1e-12) and near[0] > 0


def test_what_is_possible_stays_as_it_is(load):
    text = robot(link("a") + link("b", 1.0, (1.0, 2.0, 3.0)) + joint())
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        body = load(text).system().bodies["b"]
    assert sorted(body.moments.tolist()) == [1.0, 2.0, 3.0]


def test_robots_in_millimetres_are_warned_of(load):
    text = robot(link("a") + link("b") + joint(inside='<origin xyz="0 0 300"/><axis xyz="0 0 1"/>'))
    with pytest.warns(UserWarning, match="robot.urdf: the robot is 300 long; if these are millimetres"):
        load(text)


def test_limits_that_exclude_the_start_are_warned_of(load):
    text = robot(link("a") + link("b", 1.0) + joint(inside='<axis xyz="0 0 1"/><limit lower="0.5" upper="1"/>'))
    with pytest.warns(UserWarning, match="all coordinates zero, which limits of j exclude: give q"):
        load(text).system()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        load(text).system([0.7])
