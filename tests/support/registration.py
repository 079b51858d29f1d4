"""Scenes for registration made with matrices and parameters alone: nothing of what registers them; and what tests of
results share.
"""

from __future__ import annotations

import numpy as np

from bladesmith import cga3d
from bladesmith.registration import Model

from .checkout import CHECKOUT
from .vectors import unit

EXAMPLES = CHECKOUT / "examples" / "registration"
PATIENCE = 60.0  # seconds for a process on a busy machine
#: Of the models of files, pictures and executors.
POSE = cga3d.translator((1, 2, -0.5)) * cga3d.rotor((1, 2, 3), 2.0)
#: Kinds that have multivectors of their own.
KINDS = ("point", "point_pair", "line", "circle", "plane", "sphere")
TURN = cga3d.translator((1, 2, 3)) * cga3d.rotor((1, 2, 0), 1.3, (3, 1, 1))


def rotation(axis, angle):
    a = np.asarray(axis, float) / np.linalg.norm(axis)
    k = np.array([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]])
    return np.eye(3) + np.sin(angle) * k + (1 - np.cos(angle)) * k @ k


def fresh(kind, n, rng, size=1.0):
    """Parameters of n random objects within a cube."""
    along, radii = unit(rng.normal(size=(n, 3))), size * rng.uniform(0.1, 0.5, (n, 1))

    def place(*shape):
        return size * rng.uniform(-1, 1, shape)

    return {
        "points": lambda: place(n, 3),
        "point_pairs": lambda: place(n, 2, 3),
        "lines": lambda: np.stack([place(n, 3), along], 1),
        "segments": lambda: place(n, 1, 3) + np.stack([0 * along, 2 * radii * along], 1),
        "circles": lambda: np.concatenate([place(n, 3), along, radii], 1),
        "planes": lambda: np.concatenate([along, place(n, 1)], 1),
        "spheres": lambda: np.concatenate([place(n, 3), radii], 1),
    }[kind]()


def blocks(kind, n, rng, size=1.0):
    """Lines or planes of a world of blocks: along three directions, at places of a grid."""
    along, step = np.eye(3)[rng.integers(0, 3, n)], 0.25 * size
    if kind == "planes":
        return np.concatenate([along, step * rng.integers(-4, 5, (n, 1))], 1)
    return np.stack([step * rng.integers(-4, 5, (n, 3)), along], 1)


def table():
    """The lines (22, 2, 3) of a table: a slab, legs and rungs. Half a turn leaves it as it is."""
    a, b, rows = 1.0, 0.6, []
    for z in (0.0, -0.05):
        rows += [((0, s * b, z), (1, 0, 0)) for s in (-1, 1)] + [((s * a, 0, z), (0, 1, 0)) for s in (-1, 1)]
    for x in (-1, 1):
        for y in (-1, 1):
            rows += [((x * a, y * b, 0), (0, 0, 1)), ((0.9 * x * a, 0.9 * y * b, 0), (0, 0, 1))]
    for s in (-1, 1):
        rows += [((0, 0.9 * s * b, -0.5), (1, 0, 0)), ((0.9 * s * a, 0, -0.5), (0, 1, 0))]
    rows += [((0, 0, -0.5), (1, 0, 0)), ((0, 0, -0.5), (0, 1, 0))]
    return np.array(rows, float)


def moved(kind, x, turn, shift):
    """Parameters after x -> turn x + shift."""
    x = np.array(x, float)
    if kind in ("points", "point_pairs", "segments"):
        return x @ turn.T + shift
    if kind == "lines":
        return np.stack([x[:, 0] @ turn.T + shift, x[:, 1] @ turn.T], 1)
    if kind == "planes":
        normal = x[:, :3] @ turn.T
        return np.concatenate([normal, (x[:, 3] + normal @ shift)[:, None]], 1)
    place = x[:, :3] @ turn.T + shift
    return np.concatenate([place, *([x[:, 3:6] @ turn.T] if kind == "circles" else []), x[:, -1:]], 1)


def noisy(kind, x, noise, rng, size=1.0):
    """Parameters with errors of this standard deviation: of positions by the size, of directions in radians."""
    if not noise:
        return x

    def jitter(*shape):
        return noise * size * rng.normal(size=shape)

    def tilted(along):
        return unit(along + noise * rng.normal(size=along.shape))

    n = len(x)
    if kind == "lines":
        along = x[:, 1]
        near = x[:, 0] - (x[:, 0] * along).sum(1, keepdims=True) * along
        return np.stack([near + jitter(n, 3), tilted(along)], 1)
    if kind == "planes":
        return np.concatenate([tilted(x[:, :3]), x[:, 3:] + jitter(n, 1)], 1)
    if kind == "circles":
        return np.concatenate([x[:, :3] + jitter(n, 3), tilted(x[:, 3:6]), x[:, 6:] + jitter(n, 1)], 1)
    return x + jitter(*x.shape)


def turned(kind, x, rng):
    """The same objects, some of them turned round."""
    signs, x = rng.choice([-1.0, 1.0], len(x))[:, None], np.array(x)
    if kind == "lines":
        x[:, 1] *= signs
    elif kind == "segments":
        x = np.where(signs[:, None] < 0, x[:, ::-1], x)
    elif kind == "planes":
        x *= signs
    elif kind == "circles":
        x[:, 3:6] *= signs
    return x


def pose(rng, size=1.0):
    """A rotation of any angle and a shift of about the models' size: matrix, vector and motor."""
    axis, angle, shift = rng.normal(size=3), rng.uniform(0, np.pi), size * rng.normal(size=3)
    return rotation(axis, angle), shift, cga3d.translator(shift) * cga3d.rotor(axis, angle)


def seen(reference, rng, noise=0.0, wrong=0.0, size=1.0, new=fresh):
    """A query of a reference {kind: parameters}, some of its objects new ones; the motor; which ones are new."""
    turn, shift, motor = pose(rng, size)
    query, bad = {}, {}
    for kind, x in reference.items():
        y = noisy(kind, moved(kind, x, turn.T, -turn.T @ shift), noise, rng, size)
        bad[kind] = rng.permutation(len(y))[: int(wrong * len(y))]
        if len(bad[kind]):
            y[bad[kind]] = moved(kind, new(kind, len(bad[kind]), rng, size), turn.T, -turn.T @ shift)
        query[kind] = turned(kind, y, rng)
    return query, motor, bad


def scene(spec, seed, wrong=0.0, missing=0.0, noise=0.0, size=1.0, center=(0.0, 0.0, 0.0)):
    """Query, reference, true motor and true matches {kind: rows}, with outliers and missing objects."""
    rng = np.random.default_rng([seed, 77])
    whole = {kind: fresh(kind, n, rng, size) for kind, n in spec.items()}
    query, motor, bad = seen(whole, rng, noise, wrong, size)
    reference, true = {}, {}
    for kind, x in whole.items():
        kept = rng.permutation(len(x))[int(missing * len(x)) :]
        true[kind] = np.full(len(x), -1)
        true[kind][kept] = np.arange(len(kept))
        true[kind][bad[kind]] = -1
        reference[kind] = x[kept]
    c = np.asarray(center, float)
    query, reference = ({k: moved(k, x, np.eye(3), c) for k, x in part.items()} for part in (query, reference))
    return Model(**query), Model(**reference), cga3d.translator(c) * motor * cga3d.translator(-c), true


def apart(a, b):
    """Greatest difference of two motors' coefficients, whatever their signs."""
    x, y = (np.asarray(m.as_kind("motor", check=False).values, float).ravel() for m in (a, b))
    return float(min(np.abs(x - y).max(), np.abs(x + y).max()))


def twist(a, b):
    """Coefficients (6,) of the twist t in a = exp(t) b."""
    r = a * ~b
    return (r if r.values.ravel()[0] >= 0 else -r).log().values.ravel()


def right(found, true):
    """Whether all matches are the true ones."""
    return all(np.array_equal(found.matches[kind], rows) for kind, rows in true.items())


# -- models of files, pictures and executors, and their results ---------------------------------------------


def random_lines(n, random):
    return np.stack([random.uniform(-1, 1, (n, 3)), random.normal(size=(n, 3))], 1)


def noisy_lines(n=40, noise=0.01, wrong=0.3, seed=0):
    """A query that POSE takes to a reference, about; the first part of it does not belong there."""
    random = np.random.default_rng(seed)
    reference = random_lines(n, random)
    moved = reference.copy()
    moved += noise * random.normal(size=moved.shape)
    moved[: int(wrong * n)] = random_lines(int(wrong * n), random)
    return Model(lines=moved).transformed(~POSE), Model(lines=reference)


def lines_and_planes(seed=0, lines=12, planes=6):
    """A model of random lines and planes."""
    random = np.random.default_rng(seed)
    return Model(
        lines=np.stack([random.uniform(-1, 1, (lines, 3)), random.normal(size=(lines, 3))], axis=1),
        planes=np.hstack([random.normal(size=(planes, 3)), random.uniform(-1, 1, (planes, 1))]),
    )


def mixed(n, seed=0):
    random = np.random.default_rng(seed)
    places, ways, sizes = (
        random.uniform(-1, 1, (5, n, 3)),
        random.normal(size=(3, n, 3)),
        random.uniform(0.1, 0.4, (2, n, 1)),
    )
    return Model(
        points=places[0], point_pairs=random.uniform(-1, 1, (n, 2, 3)), lines=np.stack([places[1], ways[0]], 1),
        circles=np.hstack([places[2], ways[1], sizes[0]]), planes=np.hstack([ways[2], random.uniform(-1, 1, (n, 1))]),
        spheres=np.hstack([places[3], sizes[1]]), unit="m",
    )  # fmt: skip


def tables():
    return (Model.load(EXAMPLES / name) for name in ("table_query.json", "table.json"))


def same(a, b):
    """Every bit of two results."""
    assert a.motor.values.tobytes() == b.motor.values.tobytes()
    assert [repr(s) for s in a.history] == [repr(s) for s in b.history]
    assert np.asarray(a.matches).tobytes() == np.asarray(b.matches).tobytes()
    assert np.asarray(a.inliers).tobytes() == np.asarray(b.inliers).tobytes()
    assert a.covariance.tobytes() == b.covariance.tobytes()
    assert [m.values.tobytes() for m in a.ambiguous] == [m.values.tobytes() for m in b.ambiguous]
    assert a.undetermined.values.tobytes() == b.undetermined.values.tobytes()
    for name in ("cost", "converged", "scale", "doubt", "threshold", "unit", "message"):
        assert getattr(a, name) == getattr(b, name), name
    assert a.center.tobytes() == b.center.tobytes()


def unrelated():
    random = np.random.default_rng(5)
    return tuple(Model(points=random.uniform(-1, 1, (12, 3)), lines=random_lines(3, random)) for _ in range(2))


def full_disk(*_, **__):
    raise OSError(28, "No space left on device")


def random_parameters(rng, n=4, size=1.0, offset=0.0):
    """Parameters of n objects of each kind, by the names of the arguments."""
    radius = size * rng.uniform(0.5, 2, (n, 1))

    def place(*shape):
        return offset + size * rng.normal(size=shape)

    return {
        "points": place(n, 3), "point_pairs": place(n, 2, 3),
        "lines": np.stack([place(n, 3), rng.normal(size=(n, 3))], 1),
        "circles": np.hstack([place(n, 3), rng.normal(size=(n, 3)), radius]),
        "planes": np.hstack([rng.normal(size=(n, 3)), place(n, 1)]), "spheres": np.hstack([place(n, 3), radius]),
    }  # fmt: skip


def model_of(seed=0, **options):
    return Model(**random_parameters(np.random.default_rng(seed), **options))


def same_objects(a, b, rtol=1e-12):
    assert list(a) == list(b)
    for kind in a:
        assert a[kind].isclose(b[kind], rtol).all()
