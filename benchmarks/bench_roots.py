"""Roots of a ray against an evolved surface: lost, false, largest error and time of each method.

Truth is 50-digit arithmetic from the circles and the ray themselves, so that the rounding of the scalars that
the methods start from counts as error. The peer is NumPy: batched eigenvalues of the printed companion
matrices.

    python benchmarks/bench_roots.py --pairs 10000 --processes 2      (about three minutes)
"""

import argparse
import sys
import time
from collections.abc import Callable
from functools import partial
from multiprocessing import Pool
from pathlib import Path

import mpmath as mp
import numpy as np
from numpy.typing import NDArray

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))
import evolved_support as es  # noqa: E402

FAMILIES = ("random", "tube", "cospherical")
SAMPLES = (8, 16, 32, 64, 128, 256, 512)
REACH = 0.01  # a true root is found when a reported one is as near as that
REPEATS = 7
BATCH = 1000  # rays per timed call: they stay in the cache, as a tile of an image would

Truth = tuple[list[float], list[float], list[float]]  # scalars of the ray, of the surface, roots
Found = list[NDArray[np.floating]]


def truth(task: tuple[str, int]) -> Truth:
    with mp.workdps(es.DIGITS):
        surface, ray = es.pair(*task)
        nine = surface.ray(ray)
        return es.as_floats(nine), es.as_floats(surface.scalars), es.reference(nine, *surface.scalars)


def numpy_companion(rays: NDArray[np.float64], surfaces: NDArray[np.float64], some: slice) -> Found:
    """The printed method with batched numpy.linalg.eigvals."""
    rays, surfaces = rays[some], surfaces[some]
    powers = np.zeros((len(rays), 13))
    es.call("dodecics", np.float64, len(rays), rays, surfaces, powers)
    matrices = np.zeros((len(rays), 12, 12))
    with np.errstate(divide="ignore", invalid="ignore"):
        matrices[:, 0] = -powers[:, 11::-1] / powers[:, 12:]
    matrices[:, range(1, 12), range(11)] = 1
    matrices[~np.isfinite(matrices).all(axis=(1, 2))] = 0  # the highest power is missing
    values = np.linalg.eigvals(matrices)
    a = np.real(values)
    a = np.where((np.imag(values) == 0) & (a >= 0) & (a <= 1), a, np.nan)
    b, (m0, kappa) = 1 - a, surfaces.T[:, :, None]
    aa, ab, bb = a * a, a * b, b * b
    s0 = aa + bb + ab * m0
    with np.errstate(invalid="ignore", divide="ignore"):
        s = np.sqrt(s0 * s0 - kappa * ab * ab)
        t = np.where(s0 >= 0, s0 + s, -kappa * ab * ab / (s - s0))
        part = rays.T[:, :, None]
        u, x, e = (part[i] * bb + part[i + 1] * ab + part[i + 2] * aa for i in (0, 3, 6))
        f = (t * u - 2 * ab * x + ab * ab * e / t) / (2 * s * s)
        keep = np.abs(f) < 1e-6
    return [np.sort(row[k]) for row, k in zip(a, keep, strict=True)]


def timed(solve: Callable[[slice], Found], count: int) -> tuple[Found, float]:
    """What is found, and the best time of a ray in nanoseconds."""
    total, found = 0.0, []
    for begin in range(0, count, BATCH):
        part, times = slice(begin, min(begin + BATCH, count)), []
        for _ in range(REPEATS):
            start = time.perf_counter()
            result = solve(part)
            times.append(time.perf_counter() - start)
        found += result
        total += min(times)
    return found, total / count * 1e9


def compiled(
    method: str, dtype: type, samples: int, rays: NDArray[np.float64], surfaces: NDArray[np.float64]
) -> tuple[Found, float]:
    """Rays through the compiled loop, without the conversion to lists."""
    rays, surfaces, number = rays.astype(dtype), surfaces.astype(dtype), es.METHODS[method]
    roots, counts = np.zeros((len(rays), es.MOST), dtype), np.zeros(len(rays), np.int32)

    def run(part: slice) -> Found:
        n, arrays = part.stop - part.start, (x[part] for x in (rays, surfaces, roots, counts))
        es.call("many", dtype, number, samples, es.MOST, n, *arrays)
        return []

    _, ns = timed(run, len(rays))
    return [row[: max(k, 0)] for row, k in zip(roots, counts, strict=True)], ns


def report(name: str, wanted: list[list[float]], found: Found, ns: float) -> None:
    results = [es.matched(w, g, REACH) for w, g in zip(wanted, found, strict=True)]
    lost, false, error = sum(r[0] for r in results), sum(r[1] for r in results), max(r[2] for r in results)
    print(f"{name:34s} {sum(map(len, wanted)):7d} {lost:6d} {false:6d} {error:10.1e} {ns:10.0f}", flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--pairs", type=int, default=900, help="of a ray and a surface, in all")
    parser.add_argument("--processes", type=int, default=2, help="for the 50-digit reference")
    options = parser.parse_args()
    each = -(-options.pairs // len(FAMILIES))
    es.library()
    print(f"{'':34s} {'roots':>7s} {'lost':>6s} {'false':>6s} {'max error':>10s} {'ns per ray':>10s}")
    for family in FAMILIES:
        with Pool(options.processes) as pool:
            exact = pool.map(truth, [(family, seed) for seed in range(each)], chunksize=16)
        rays, surfaces = (np.array([t[i] for t in exact]) for i in (0, 1))
        wanted = [t[2] for t in exact]
        print(f"{family}, {each} pairs, {np.mean([not w for w in wanted]):.0%} of them missed")
        runs = [("isolate", 0), ("companion", 0), *(("sampled", n) for n in SAMPLES)]
        for dtype in (np.float64, np.float32):
            for method, samples in runs if dtype is np.float64 else runs[:1]:
                title = f"  {method}{f' {samples}' if samples else ''}, {np.dtype(dtype).name}"
                report(title, wanted, *compiled(method, dtype, samples, rays, surfaces))
        peer = timed(partial(numpy_companion, rays, surfaces), len(rays))
        report("  numpy eigvals, float64", wanted, *peer)


if __name__ == "__main__":
    main()
