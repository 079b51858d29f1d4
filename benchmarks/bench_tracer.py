"""The tracer beside what people would use instead, in one process: NumPy's numba, Embree, the package `clifford`.

One thread unless said, everything warm, the best of several runs in processor time (Embree builds its hierarchies with
all threads: there the clock on the wall counts, for both sides). Figures of a busy machine mean little; ratios more.

    python benchmarks/bench_tracer.py
    python benchmarks/bench_tracer.py --only tube sphere --skip-clifford
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from timing import Row, arguments, run_parts

from bladesmith import tracer
from bladesmith.benchmarks.studies.tracing import crowds, hits
from bladesmith.cli.demo.parts import demo_scene_path

WIDTH, HEIGHT = 640, 480
#: Where the camera stands, and what it looks at.
LOOK = (0, -4.0, 0.5), (0, 0, 0.1)
REPEATS = 5
#: A tube that fills about a third of the frame.
TUBE = [((-0.9, 0.0, -0.3), (1.0, 0.2, 0.3), 1.0), ((1.0, 0.3, 0.4), (1.0, -0.3, 0.1), 0.7)]
#: Cubic ones; the ribbon's ends make a linear one.
CUBIC_TUBE = [TUBE[0], ((-0.3, 0.2, 0.1), (1.0, 0.0, -0.2), 0.8), ((0.3, -0.2, 0.2), (1.0, 0.3, 0.2), 0.9), TUBE[1]]
CUBIC_RIBBON = [
    ((-0.9, 0, -0.6), (-0.9, 0.2, 0.6)), ((-0.3, 0.2, -0.7), (-0.3, -0.1, 0.6)), ((0.3, -0.2, -0.5), (0.4, 0.3, 0.6)),
    ((1.0, 0.3, -0.5), (0.8, -0.3, 0.7)),
]  # fmt: skip
#: Rings and segments of meshes, coarse first.
MESHES = ((64, 128), (128, 256), (256, 512), (512, 1024), (1024, 2048))
MANY, CHUNK = 10_000_000, 1_000_000
SPHERE_RAYS = 1_000_000
CLIFFORD_RAYS, CLIFFORD_SAMPLES = 20, 50


def best(run: Callable[[], Any], items: int = 1, repeats: int = REPEATS, clock: Any = time.process_time) -> float:
    """Seconds per item of the fastest run, after one that warms up."""
    run()
    times = []
    for _ in range(repeats):
        start = clock()
        run()
        times.append(clock() - start)
    return min(times) / items


def frame() -> tuple[Any, Any]:
    """Rays through all pixels."""
    camera = tracer.Camera.look_at(*LOOK)
    origins, directions = camera.rays(WIDTH, HEIGHT)
    return np.ascontiguousarray(np.broadcast_to(origins, directions.shape)), directions


def tube(options: argparse.Namespace) -> Iterator[Row]:
    """(a) An evolved linear circle over a frame, in both precisions and by all methods."""
    origins, directions = frame()
    surface = tracer.EvolvedCircles(TUBE)
    filled = float(np.mean(surface.intersect(origins, directions).count > 0))
    scene = tracer.Scene(tracer.Camera.look_at(*LOOK), [], [surface])
    count = WIDTH * HEIGHT
    for name, call in (("all roots", surface.intersect), ("first hit in a scene", scene.intersect)):
        ns = best(lambda call=call: call(origins, directions, threads=1), count) * 1e9  # type: ignore[misc]
        yield {"what": f"tube, {name}, {filled:.0%} of the frame", "ours": ns, "unit": "ns/ray", "bar": 290}
    single = [a.astype(np.float32) for a in (origins, directions)]
    ns = best(lambda: surface.intersect(*single, threads=1), count) * 1e9
    yield {"what": "tube, all roots, float32", "ours": ns, "unit": "ns/ray", "bar": 290}
    few = [a.reshape(-1, 3)[::17] for a in (origins, directions)]
    for method, samples in (("companion", 0), ("sampled", 16), ("sampled", 64), ("sampled", 256)):
        ns = (
            best(
                lambda m=method, s=samples: surface.intersect(*few, method=m, samples=s or 64, threads=1),  # type: ignore[misc]
                len(few[0]),
                2,
            )
            * 1e9
        )
        yield {"what": f"tube, {method}{f' {samples}' if samples else ''}, as printed", "ours": ns, "unit": "ns/ray"}


def sphere(options: argparse.Namespace) -> Iterator[Row]:
    """(a) One sphere through `intersect`; the peer is a loop compiled by numba that gives distances only."""
    import numba

    @numba.njit(error_model="numpy")
    def loop(origins: Any, directions: Any, center: Any, radius: float, out: Any) -> None:
        for i in range(len(origins)):
            dx, dy, dz = directions[i, 0], directions[i, 1], directions[i, 2]
            x, y, z = origins[i, 0] - center[0], origins[i, 1] - center[1], origins[i, 2] - center[2]
            a, b = dx * dx + dy * dy + dz * dz, x * dx + y * dy + z * dz
            c = x * x + y * y + z * z - radius * radius
            d = b * b - a * c
            t = (-b - np.sqrt(d)) / a if d >= 0 else np.nan
            out[i] = t if t > 0 else np.nan

    rng = np.random.default_rng(1)
    origins = np.tile([0.0, -4.0, 0.0], (SPHERE_RAYS, 1))
    directions = np.array([0, 1.0, 0]) + 0.35 * rng.normal(size=(SPHERE_RAYS, 3))
    surface, out = tracer.Sphere((0, 0, 0), 1.0), np.empty(SPHERE_RAYS)
    peer = best(lambda: loop(origins, directions, np.zeros(3), 1.0, out), SPHERE_RAYS) * 1e9
    ns = best(lambda: surface.intersect(origins, directions, threads=1), SPHERE_RAYS) * 1e9
    named = {"peer": peer, "name": "numba", "unit": "ns/ray", "bar": 5}
    yield {"what": "sphere, points and normals of both roots", "ours": ns, **named}
    small = slice(0, 4096)  # results that stay in the cache
    ns = best(lambda: surface.intersect(origins[small], directions[small], threads=1), 4096, 50) * 1e9
    yield {"what": "sphere, 4096 rays", "ours": ns, **named}
    scene = tracer.Scene(tracer.Camera.look_at((0, -4, 0), (0, 0, 0)), [], [surface])
    ns = best(lambda: scene.intersect(origins, directions, threads=1), SPHERE_RAYS) * 1e9
    yield {"what": "sphere, first hit in a scene", "ours": ns, **named}


def several(options: argparse.Namespace) -> Iterator[Row]:
    """(f) First hits of single rays, and of several at once: pixels, which are in order, and the same shuffled."""
    from bladesmith.tracer.rendering import driver, several_rays

    several_rays.PAYS = 1  # compiled at once
    origins, directions = (a.reshape(-1, 3) for a in frame())
    shuffled = np.random.default_rng(0).permutation(len(directions))
    least, in_order = driver.MANY_RAYS, driver.are_in_order
    for name, made, controls in (
        ("linear tube", tracer.EvolvedCircles, TUBE), ("cubic tube", tracer.EvolvedCircles, CUBIC_TUBE),
        ("linear ribbon", tracer.EvolvedPointPairs, CUBIC_RIBBON[::3]),
        ("cubic ribbon", tracer.EvolvedPointPairs, CUBIC_RIBBON),
    ):  # fmt: skip
        scene = tracer.Scene(tracer.Camera.look_at(*LOOK), [], [made(controls)])
        for order, rays in (("pixels", slice(None)), ("shuffled", shuffled)):
            o, d = origins[rays], directions[rays]
            ns = []
            for many in (1 << 60, 1):
                driver.MANY_RAYS, driver.are_in_order = many, lambda rays, n: True
                ns.append(best(partial(scene.intersect, o, d, threads=1), len(d)) * 1e9)
            driver.MANY_RAYS, driver.are_in_order = least, in_order
            yield {"what": f"{name}, {order}, first hits, several rays at once", "ours": ns[1], "peer": ns[0],
                   "name": "single", "unit": "ns/ray"}  # fmt: skip


def pictures(options: argparse.Namespace) -> Iterator[Row]:
    """(g) Pictures by single pixels, and by several at once, in turns on one thread."""
    from bladesmith.tracer.rendering import driver, several_rays

    several_rays.PICTURES_PAY = 1  # compiled at once
    examples = Path(__file__).resolve().parent.parent / "examples" / "scenes"
    least = driver.MANY_SAMPLES
    for path in (demo_scene_path(), examples / "tube.toml", examples / "orientation.toml"):
        scene = tracer.Scene.load(path)
        seconds: dict[int, list[float]] = {1 << 60: [], 1: []}
        for _ in range(REPEATS):
            for many, found in seconds.items():
                driver.MANY_SAMPLES = many
                found.append(best(partial(scene.render, WIDTH, HEIGHT, threads=1, antialias=1), repeats=1))
        driver.MANY_SAMPLES = least
        single, several = (min(found) for found in seconds.values())
        yield {"what": f"{path.name}, {WIDTH} x {HEIGHT}, several pixels at once", "ours": several, "peer": single,
               "name": "single", "unit": "s"}  # fmt: skip


def embree_of(surface: Any, rings: int, around: int) -> tuple[Any, float]:
    """A mesh in Embree, and the seconds that its hierarchy took."""
    from embreex.mesh_construction import TriangleMesh
    from embreex.rtcore_scene import EmbreeScene

    vertices, faces = hits.tessellate(surface, 2 * rings * around)
    vertices = vertices.astype(np.float32)
    start = time.perf_counter()
    scene = EmbreeScene()
    TriangleMesh(scene, vertices, faces)
    scene.run(np.zeros((1, 3), np.float32), np.ones((1, 3), np.float32))  # built when first asked
    return scene, time.perf_counter() - start


def meshes(options: argparse.Namespace) -> Iterator[Row]:
    """(b) Embree on the tessellated tube: a frame with the build, and many rays without."""
    surface = tracer.EvolvedCircles(TUBE)
    origins, directions = (a.reshape(-1, 3).astype(np.float32) for a in frame())
    exact = surface.intersect(origins.astype(float), directions.astype(float)).t[:, 0]
    ours = best(lambda: tracer.EvolvedCircles(TUBE).intersect(origins, directions, threads=1), clock=time.perf_counter)
    ours = min(
        ours,
        best(lambda: tracer.EvolvedCircles(TUBE).intersect(origins.astype(float), directions.astype(float), threads=1),
             clock=time.perf_counter),
    )  # fmt: skip
    seen: dict[float, Any] = {}
    for rings, around in MESHES:
        scene, build = embree_of(surface, rings, around)
        build = min(build, *(embree_of(surface, rings, around)[1] for _ in range(2)))
        trace = best(lambda s=scene: s.run(origins, directions, query="DISTANCE"), 1, 3, time.perf_counter)  # type: ignore[misc]
        away = scene.run(origins, directions, query="DISTANCE").astype(float)
        off = np.abs(np.where(away < 1e3, away, np.nan) - exact)
        error = float(np.nanquantile(off, 0.99))
        yield {
            "what": f"frame, build included; mesh {rings} x {around}: p99 error {error:.1e}, build {build:.2f} s",
            "ours": ours * 1e3, "peer": (build + trace) * 1e3, "name": "Embree", "unit": "ms",
        }  # fmt: skip
        for goal in (1e-4, 1e-5):
            if error <= goal and goal not in seen:
                seen[goal] = (scene, rings, around)
        if error <= 1e-5:
            break
    if 1e-4 not in seen:
        return
    scene, rings, around = seen[1e-4]
    part = [np.tile(a, (-(-CHUNK // len(a)), 1))[:CHUNK] for a in (origins, directions)]
    rounds = max(1, options.many // CHUNK)
    double = [a.astype(float) for a in part]

    def many(call: Callable[[], Any]) -> float:
        return best(lambda: [call() for _ in range(rounds)], rounds * CHUNK, 1) * 1e9

    peer = many(lambda: scene.run(*part, query="DISTANCE"))
    first = tracer.Scene(tracer.Camera.look_at((0, -8, 0), (0, 0, 0)), [], [surface])  # as Embree: nearest distances
    for name, rays in (("float64, exact", double), ("float32", part)):
        first.intersect(*rays, threads=1)
        ns = many(lambda rays=rays: first.intersect(*rays, threads=1))  # type: ignore[misc]
        yield {
            "what": f"{rounds * CHUNK:.0e} rays, {name}; mesh {rings} x {around} at 1e-4", "ours": ns, "peer": peer,
            "name": "Embree", "unit": "ns/ray", "bar": 2.5 * peer,
        }  # fmt: skip


def demo(options: argparse.Namespace) -> Iterator[Row]:
    """(c) The demonstration's picture on two threads, and its program compiled into an empty cache."""
    scene = tracer.Scene.load(demo_scene_path())
    seconds = best(lambda: scene.render(WIDTH, HEIGHT, threads=2, antialias=1), 1, 3, time.perf_counter)
    yield {"what": f"demo scene, {WIDTH} x {HEIGHT}, two threads", "ours": seconds, "unit": "s", "bar": 1}
    text = (
        "import os, time; from bladesmith import tracer; from bladesmith.cli.demo.parts import demo_scene_path\n"
        "from bladesmith.tracer.rendering.program import engine_for\n"
        "scene = tracer.Scene.load(demo_scene_path()); wanted = scene.needs\n"
        "start, before = time.perf_counter(), sum(os.times()[:4]); engine_for(wanted)\n"
        "print(time.perf_counter() - start, sum(os.times()[:4]) - before)"
    )
    with tempfile.TemporaryDirectory() as cache:
        environment = {**os.environ, "BLADESMITH_CACHE_DIR": cache}
        done = subprocess.run([sys.executable, "-c", text], env=environment, capture_output=True, text=True, check=True)
    wall, busy = map(float, done.stdout.split()[-2:])
    yield {"what": f"its program, compiled ({busy:.2f} s of processors)", "ours": wall, "unit": "s", "bar": 1.5}


def scale(options: argparse.Namespace) -> Iterator[Row]:
    """(d) Ten thousand surfaces against ten, that cover as much of the view."""
    for kind, make in (("circles", crowds.tubes), ("pairs", crowds.ribbons)):
        crowd = crowds.crowd(np.random.default_rng(5), 1000, kind, make)
        times = {}
        for n in crowds.NUMBERS:
            times[n] = best(partial(crowds.trace_scene, crowd, n), 1000 * crowds.COPIES) * 1e9
        for n, ns in times.items():
            yield {"what": f"{n} surfaces evolved from {kind}", "ours": ns, "unit": "ns/ray", "bar": 4 * times[10]}


def user(options: argparse.Namespace) -> Iterator[Row]:
    """(e) What a user of `clifford` would write: circles at 50 parameters, the sign of the squared meet of each."""
    if options.skip_clifford:
        return
    from clifford.g3c import layout
    from clifford.tools.g3c import average_objects

    from bladesmith import cga3d

    first, second = (cga3d.circle(*c).to_clifford(layout) for c in TUBE)
    alphas = np.linspace(0, 1, CLIFFORD_SAMPLES)
    circles = [average_objects([first, second], [a, 1 - a], check_grades=False) for a in alphas]
    surface = tracer.EvolvedCircles(TUBE)
    origins, directions = (a.reshape(-1, 3) for a in frame())
    seen = np.flatnonzero(surface.intersect(origins, directions).count)
    some = seen[:: len(seen) // CLIFFORD_RAYS]
    origins, directions = origins[some], directions[some]
    lines = [cga3d.line(o, d).to_clifford(layout) for o, d in zip(origins, directions, strict=True)]

    def roots() -> list[Any]:
        found = []
        for line in lines:
            dual = line.dual()
            squares = [((dual ^ c.dual()).dual() ** 2).value[0] for c in circles]
            found.append(np.flatnonzero(np.diff(np.sign(squares))))
        return found

    peer = best(roots, len(lines), 2) * 1e9
    every = [np.tile(a, (1000, 1)) for a in (origins, directions)]
    ns = best(lambda: surface.intersect(*every, threads=1), len(every[0])) * 1e9
    what = f"tube, rays that hit; {CLIFFORD_SAMPLES} samples in clifford"
    yield {"what": what, "ours": ns, "peer": peer, "name": "clifford", "unit": "ns/ray"}


PARTS = {each.__name__: each for each in (tube, several, pictures, sphere, meshes, demo, scale, user)}


def row_text(row: Row) -> str:
    """One line of the table."""
    line = f"{row['what']:78s} {row['ours']:10.4g} {row['unit']:7s}"
    if "peer" in row:
        line += f" {row['name']} {row['peer']:.4g}, {row['ours'] / row['peer']:.2g} times;"
    if "bar" in row:
        line += f" bar {row['bar']:.4g}{'' if row['ours'] <= row['bar'] else ' MISSED'}"
    return line


def main() -> None:
    parser = arguments(__doc__, PARTS)
    parser.add_argument("--many", type=int, default=MANY, help="rays of the long run against Embree")
    options = parser.parse_args()
    run_parts(options, PARTS, row_text, headings=False)


if __name__ == "__main__":
    main()
