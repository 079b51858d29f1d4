"""Registration beside what people would use instead, in one process: REFORM of the package `clifford`, and points that
are sampled from the lines (GICP of small_gicp; FPFH features, RANSAC and GICP of Open3D and small_gicp).

Models of random lines between -1 and 1. A pose's error is the greatest displacement of a corner of that cube; it is
right up to 0.1. Points come from the same segments of both models: their ends are known to the others, which lines do
not have ("slid": pieces of the same lines up to a whole half-length apart). Times are medians over scenes, of
processor time and on the wall; everything is warm. Figures of a busy machine mean little; ratios more.

    python benchmarks/bench_reform.py
    python benchmarks/bench_reform.py --only near anywhere --seeds 100 --skip-clifford
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from timing import Row, arguments, run_parts

from bladesmith import registration
from bladesmith.benchmarks.harness.study import optional_module
from bladesmith.benchmarks.studies.registration import pose_peers, poses

Find = Callable[[poses.Scene], Any]
#: Lines of a query, and milliseconds on two threads that are allowed.
BARS = {20: 2.0, 100: 30.0, 400: 300.0}
WRONG = {"outliers": 0.3, "missing": 0.3}
#: Beside a displacement and the options of the scenes: as near as the text's methods need it.
NEAR = 0.1
#: Shares of poses that are so exact are counted.
LIMITS = (poses.RIGHT, 1e-2, 1e-9)
#: Samples of the others.
RANSAC, CLIFFORD = 100_000, (5, 20)
#: Lines up to which they are run.
MOST_OF_RANSAC, MOST_OF_CLIFFORD = 100, 20
GROWN = ((1_000, 0.0), (1_000, 1e-3), (10_000, 0.0), (10_000, 1e-3))
GROWN_BAR = 30.0


def measured(name: str, scenes: list[poses.Scene], find: Find, cap: float) -> Row:
    """What a method makes of the scenes: of all, or of as many as it can within so many seconds."""
    find(scenes[0])
    found, busy, wall = [], [], []
    for scene in scenes:
        start, clock = time.process_time(), time.perf_counter()
        found.append(np.asarray(find(scene)))
        busy.append(time.process_time() - start)
        wall.append(time.perf_counter() - clock)
        if sum(wall) > cap:
            break
    errors = poses.pose_errors(np.stack(found), np.stack([s.pose for s in scenes[: len(found)]]))
    return {
        "method": name, "scenes": len(found), "shares": [float((errors <= limit).mean()) for limit in LIMITS],
        "median": float(np.median(errors)), "ms": 1e3 * float(np.median(busy)), "wall": 1e3 * float(np.median(wall)),
    }  # fmt: skip


def ours(threads: int, **options: Any) -> Find:
    """Ours, as a matrix."""
    return lambda s: registration.register(s.query, s.reference, threads=threads, **options).motor.to_matrix()


def at_best(scene: poses.Scene) -> Any:
    """The pose of the least positive cost over the true matches: what noise leaves."""
    from bladesmith.registration.estimation.estimate_rotor import estimate_rotor

    true = scene.true["line"]
    query = scene.query.subset(np.flatnonzero(true >= 0))
    return estimate_rotor(query, scene.reference.subset(true[true >= 0]), "linear", threads=1).to_matrix()


def compared(options: argparse.Namespace, what: str, count: int, **nature: Any) -> Iterator[Row]:
    """All methods on the same scenes of so many lines."""
    scenes = poses.scenes(np.random.default_rng(count), options.seeds, {"line": count}, **nature).items
    first = measured("bladesmith, 1 thread", scenes, ours(1), options.cap)
    yield {"what": what, **first}
    yield {"what": what, **measured("bladesmith, 2 threads", scenes, ours(2), options.cap), "bar": BARS.get(count)}

    if nature.get("noise"):
        yield {"what": what, **measured("least cost, true matches", scenes, at_best, options.cap)}

    def peer(name: str, find: Find) -> Row:
        row = measured(name, scenes, find, options.cap)
        return {"what": what, **row, "times": row["ms"] / first["ms"]}

    if optional_module("small_gicp") and not options.skip_points:
        yield peer("points: GICP", pose_peers.local)
    if optional_module("open3d") and not options.skip_points and count <= MOST_OF_RANSAC:
        yield peer("points: FPFH, RANSAC, GICP", lambda s: pose_peers.anywhere(s, RANSAC))
    if not options.skip_clifford and count <= MOST_OF_CLIFFORD:
        pose_peers.clifford_tools()
        for samples in CLIFFORD:
            yield peer(f"clifford REFORM, {samples}", lambda s, k=samples: pose_peers.with_clifford(s, k))  # type: ignore[misc]


def scenes_of(options: argparse.Namespace, where: str, displacement: float | None) -> Iterator[Row]:
    """All sizes, clean and with wrong and missing lines, exact and with noise."""
    for count in BARS:
        for text, nature in (("", {}), (", 30 % wrong and missing", WRONG)):
            for noise in (0.0, 1e-2):
                what = f"{count} lines {where}{text}{f', noise {noise:g}' if noise else ''}"
                yield from compared(options, what, count, displacement=displacement, noise=noise, **nature)


def near(options: argparse.Namespace) -> Iterator[Row]:
    """(a) A query a tenth of its size away."""
    yield from scenes_of(options, "near", NEAR)


def anywhere(options: argparse.Namespace) -> Iterator[Row]:
    """(b) Any rotation, a translation of the model's size."""
    yield from scenes_of(options, "anywhere", None)


def slid(options: argparse.Namespace) -> Iterator[Row]:
    """(c) The same where the others see different pieces of the same lines."""
    for where, displacement in (("near", NEAR), ("anywhere", None)):
        yield from compared(options, f"20 lines {where}, slid", 20, displacement=displacement, slide=1.0)


def kinds(options: argparse.Namespace) -> Iterator[Row]:
    """(d) Other kinds, anywhere, 30 % wrong and missing: nobody else has them."""
    every = ("point", "point_pair", "line", "circle", "plane", "sphere")
    for what, counts in (
        ("10 lines, 10 planes", {"line": 10, "plane": 10}),
        ("5 of each kind", dict.fromkeys(every, 5)),
        ("20 of each kind", dict.fromkeys(every, 20)),
        *((f"30 {kind}s".replace("_", " "), {kind: 30}) for kind in every),
    ):
        scenes = poses.scenes(np.random.default_rng(7), options.seeds, counts, **WRONG).items
        yield {"what": f"{what}, 30 % wrong and missing", **measured("bladesmith", scenes, ours(1), options.cap)}


def starts(options: argparse.Namespace) -> Iterator[Row]:
    """(e) The text's own ways from near, and the global start."""
    from bladesmith.registration.matching.icp import iterate

    for count in (20, 100):
        for text, nature in (("", {}), (", 30 % wrong and missing", WRONG)):
            scenes = poses.scenes(
                np.random.default_rng(count), options.seeds, {"line": count}, displacement=NEAR, noise=1e-3, **nature
            ).items
            what = f"{count} lines near{text}, noise 0.001"
            ways: dict[str, Find] = {
                "global": ours(1),
                "REFORM by proximity (5.5)": ours(1, start="proximity"),
                "iterative matching (5.4)": lambda s: iterate(s.query, s.reference, threads=1).motor.to_matrix(),
            }
            for name, find in ways.items():
                yield {"what": what, **measured(name, scenes, find, options.cap)}


def stages(options: argparse.Namespace) -> Iterator[Row]:
    """(f) The motor between matched lines (5.3): three ways of ours, two of `clifford`'s."""
    from bladesmith.registration.estimation.estimate_rotor import METHODS, estimate_rotor

    for count in (5, 20, 100):
        made = poses.scenes(np.random.default_rng(count), options.seeds, {"line": count}, displacement=1.0).items
        scenes = [_matched(scene) for scene in made]
        what, first = f"motor between {count} matched lines", None
        for method in METHODS:
            row = measured(
                f"bladesmith, {method}", scenes,
                lambda s, m=method: estimate_rotor(s.query, s.reference, m, threads=1).to_matrix(),  # type: ignore[misc]
                options.cap,
            )  # fmt: skip
            first = min(first or row["ms"], row["ms"])
            yield {"what": what, **row}
        if not options.skip_clifford and count <= MOST_OF_CLIFFORD:
            for name in ("sequential_object_rotor_estimation", "estimate_rotor_objects"):
                row = measured(
                    f"clifford, {name.split('_')[0]}", scenes, lambda s, n=name: _clifford_motor(s, n), options.cap
                )  # type: ignore[misc]
                yield {"what": what, **row, "times": row["ms"] / (first or row["ms"])}


def _matched(scene: poses.Scene) -> poses.Scene:
    """The same with the query in the reference's order."""
    from dataclasses import replace

    order = np.argsort(scene.true["line"])
    return replace(scene, query=scene.query.subset(order))


def _clifford_motor(scene: poses.Scene, name: str) -> Any:
    from clifford.tools.g3c import rotor_estimation

    query, reference = (pose_peers.clifford_lines(m.parameters["line"]) for m in (scene.query, scene.reference))
    found = getattr(rotor_estimation, name)(list(reference), list(query), object_type="lines")[0]
    return pose_peers.clifford_pose(found)


def growth(options: argparse.Namespace) -> Iterator[Row]:
    """(g) Many lines, 30 % wrong and missing, each in a process of its own for its memory."""
    for count, noise in GROWN:
        command = [sys.executable, __file__, "--grow", str(count), str(noise)]
        done = subprocess.run(command, capture_output=True, text=True, check=True)
        yield {"what": f"{count} lines anywhere, 30 % wrong and missing, noise {noise:g}", **json.loads(done.stdout)}


def memory(is_reset: bool = False) -> float:
    """The most MiB that this process ever held, or from now on (Linux)."""
    if is_reset:
        with open("/proc/self/clear_refs", "w", encoding="utf-8") as file:
            file.write("5")
    with open("/proc/self/status", encoding="utf-8") as lines:
        return next(float(line.split()[1]) for line in lines if line.startswith("VmHWM")) / 1024


def grow(count: int, noise: float) -> None:
    """One large registration; prints the row."""
    small = poses.scenes(np.random.default_rng(0), 1, {"line": 20}).items
    ours(2)(small[0])
    scenes = poses.scenes(np.random.default_rng(1), 1, {"line": count}, noise=noise, **WRONG).items
    before = memory(is_reset=True)
    start, clock = time.process_time(), time.perf_counter()
    found = registration.register(scenes[0].query, scenes[0].reference, threads=2)
    busy, wall = time.process_time() - start, time.perf_counter() - clock
    more = memory() - before
    error = float(poses.pose_errors(found.motor.to_matrix()[None], scenes[0].pose[None])[0])
    wrong = int((np.asarray(found.matches["line"]) != scenes[0].true["line"]).sum())
    row = {
        "method": "bladesmith, 2 threads", "scenes": 1, "shares": [float(error <= limit) for limit in LIMITS],
        "median": error, "ms": 1e3 * busy, "wall": 1e3 * wall, "memory": more, "wrong": wrong,
        "bar": 1e3 * GROWN_BAR,
    }  # fmt: skip
    print(json.dumps(row))


PARTS = {
    "near": near, "anywhere": anywhere, "slid": slid, "kinds": kinds, "starts": starts, "stages": stages,
    "growth": growth,
}  # fmt: skip
HEAD = (
    f"{'method':30s} {'scenes':>6s} {'right':>6s} {'1e-2':>6s} {'1e-9':>6s} {'median':>8s} {'ms':>9s} {'wall ms':>9s}"
)


def row_text(row: Row) -> str:
    """One line of the table."""
    right, fine, exact = (f"{share:6.0%}" for share in row["shares"])
    line = f"{row['method']:30s} {row['scenes']:6d} {right} {fine} {exact} {row['median']:8.1e}"
    line += f" {row['ms']:9.2f} {row['wall']:9.2f}"
    if row.get("bar"):
        line += f"  bar {row['bar']:g} ms{'' if row['wall'] <= row['bar'] else ' MISSED'}"
    if "times" in row:
        line += f"  {row['times']:.3g} times ours"
    if "memory" in row:
        line += f"; {row['memory']:.0f} MiB more at most, {row['wrong']} matches differ"
    return line


def main() -> None:
    parser = arguments(__doc__, PARTS)
    parser.add_argument("--seeds", type=int, default=20, help="scenes of each nature")
    parser.add_argument("--cap", type=float, default=10.0, help="seconds of a method on scenes of one nature, about")
    parser.add_argument("--skip-points", action="store_true")
    parser.add_argument("--grow", nargs=2, type=float, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.grow:
        return grow(int(options.grow[0]), options.grow[1])
    print(HEAD)
    run_parts(options, PARTS, row_text)


if __name__ == "__main__":
    main()
