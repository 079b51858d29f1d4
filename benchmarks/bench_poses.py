"""Exponential and logarithm of a million poses beside scipy, pytransform3d and jaxlie, in one process.

Everything is warm, float64, on one thread; calls make their results anew. Times are the least processor time of runs.
Errors are the largest change of the twist that comes back, relative to each twist. Peers that are not installed are
skipped; jaxlie runs compiled, by `jax.jit` and `jax.vmap`.

    python benchmarks/bench_poses.py
    python benchmarks/bench_poses.py --items 100000 --json poses.json
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from importlib.util import find_spec
from typing import Any

os.environ.setdefault("XLA_FLAGS", "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse

import numpy as np
from timing import Row, arguments, run_parts, seconds

import bladesmith
from bladesmith import poses

#: Milliseconds for a million exponentials and logarithms together.
BAR = 30.0
Pair = tuple[Callable[[Any], Any], Callable[[Any], Any]]


def scipy_rotations() -> Pair:
    from scipy.spatial.transform import Rotation

    return Rotation.from_rotvec, lambda x: x.as_rotvec()


def scipy_transforms() -> Pair:
    from scipy.spatial.transform import RigidTransform

    return RigidTransform.from_exp_coords, lambda x: x.as_exp_coords()


def pytransform3d() -> Pair:
    from pytransform3d import trajectories

    return trajectories.transforms_from_exponential_coordinates, trajectories.exponential_coordinates_from_transforms


def jaxlie() -> Pair:
    """Twists (v, w): the columns are exchanged beforehand, which is not timed."""
    import jax
    import jaxlie as package

    jax.config.update("jax_enable_x64", True)
    exp = jax.jit(jax.vmap(lambda twist: package.SE3.exp(twist).wxyz_xyz))
    log = jax.jit(jax.vmap(lambda row: package.SE3(row).log()))
    return lambda t: exp(t).block_until_ready(), lambda x: log(x).block_until_ready()


#: Packages, what they are called here, and their functions.
PEERS: dict[str, tuple[str, Callable[[], Pair]]] = {
    "scipy RigidTransform": ("scipy", scipy_transforms),
    "pytransform3d": ("pytransform3d", pytransform3d),
    "jaxlie": ("jaxlie", jaxlie),
}


def rows(what: str, twists: Any, methods: dict[str, tuple[Pair, Any]]) -> Iterator[Row]:
    first = None
    for name, ((exp, log), given) in methods.items():
        made = exp(given)
        back = np.asarray(log(made))
        off = float((np.linalg.norm(back - np.asarray(given), axis=-1) / np.linalg.norm(twists, axis=-1)).max())
        repeats = 9 if first is None else 3
        ns = [1e9 * seconds(run, repeats) / len(twists) for run in (lambda: exp(given), lambda: log(made))]  # noqa: B023
        total = sum(ns)
        first = first or total
        yield {"what": what, "method": name, "exp": ns[0], "log": ns[1], "times": total / first, "error": off}


def transforms(options: argparse.Namespace) -> Iterator[Row]:
    """Twists by angles below pi, of which every package gives the same logarithm."""
    twists = np.random.default_rng(0).normal(size=(options.items, 6))
    twists[:, :3] *= np.minimum(1, 3 / np.linalg.norm(twists[:, :3], axis=-1))[:, None]
    methods: dict[str, tuple[Pair, Any]] = {"bladesmith": ((poses.exp, poses.log), twists)}
    for name, (package, make) in PEERS.items():
        if find_spec(package) is None:
            continue
        given = twists
        if package == "jaxlie":
            import jax

            pair = make()
            given = jax.numpy.asarray(np.roll(twists, 3, -1))
        else:
            pair = make()
        methods[name] = (pair, given)
    yield from rows("exp and log of twists", twists, methods)


def rotations(options: argparse.Namespace) -> Iterator[Row]:
    """Rotation vectors."""
    vectors = np.random.default_rng(1).normal(size=(options.items, 3))
    vectors *= np.minimum(1, 3 / np.linalg.norm(vectors, axis=-1))[:, None]
    methods: dict[str, tuple[Pair, Any]] = {
        "bladesmith": ((poses.from_rotation_vector, poses.to_rotation_vector), vectors),
        "scipy Rotation": (scipy_rotations(), vectors),
    }
    yield from rows("rotation vectors to rotations and back", vectors, methods)


def conversions(options: argparse.Namespace) -> Iterator[Row]:
    """Each function by itself."""
    rng = np.random.default_rng(2)
    x = poses.exp(rng.normal(size=(options.items, 6)))
    q, p, matrix = poses.to_quaternion(x), poses.position(x), poses.to_matrix(x)
    angles = poses.to_euler(x, "xyz")
    near = poses.exp(rng.normal(size=(options.items, 6)) * 0.3)
    spline, times = poses.Spline(near[:50], np.arange(50.0)), rng.uniform(0, 49, options.items)
    runs: dict[str, Callable[[], Any]] = {
        "from_quaternion": lambda: poses.from_quaternion(q, p),
        "to_quaternion": lambda: poses.to_quaternion(x),
        "from_matrix": lambda: poses.from_matrix(matrix),
        "to_matrix": lambda: poses.to_matrix(x),
        "from_euler": lambda: poses.from_euler("xyz", angles, p),
        "to_euler": lambda: poses.to_euler(x, "xyz"),
        "compose": lambda: poses.compose(x, x),
        "act": lambda: poses.act(x, p),
        "interpolate": lambda: poses.interpolate(x, x[::-1], 0.3),
        "mean": lambda: poses.mean(near),
        "spline": lambda: spline(times),
        "left_jacobian": lambda: poses.left_jacobian(p[:, [0, 1, 2, 0, 1, 2]]),
    }
    for name, run in runs.items():
        yield {"what": "one by one", "method": name, "ns": 1e9 * seconds(run, 5) / options.items}


PARTS = {"transforms": transforms, "rotations": rotations, "conversions": conversions}


def row_text(row: Row) -> str:
    if "ns" in row:
        return f"{row['method']:24}{row['ns']:10.1f} ns"
    both = f"{row['exp'] + row['log']:9.1f} ns (exp {row['exp']:.1f}, log {row['log']:.1f})"
    return f"{row['method']:24}{both}  {row['times']:8.1f} times ours  round trip {row['error']:.1e}"


def main() -> None:
    parser = arguments(__doc__, PARTS)
    parser.add_argument("--items", type=int, default=1_000_000)
    options = parser.parse_args()
    bladesmith.set_threads(1)
    run_parts(options, PARTS, row_text)
    print(f"bar: {BAR} ns for exp and log of a pose together")


if __name__ == "__main__":
    main()
