"""Whether a wheel works on a machine without a compiler: install it, run what a newcomer runs, say how long it took.

    python packaging/check_wheel.py dist/bladesmith-*.whl      # in a virtual environment of its own
    python packaging/check_wheel.py --installed                # what is installed here
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import time
import venv
import zipfile
from pathlib import Path

MOST_BYTES = 12_000_000
MOST_SECONDS = 30.0  # of installing and the first snippet; what pip fetches from its index is not counted
#: Parts of paths that nobody needs in a wheel.
UNWANTED = ("tests/", "docs/", "examples/", "/references/", "__pycache__")

SNIPPET = """
import numpy as np
from bladesmith import cga3d as cga, objects, poses

a = cga.circle(center=(0, 0, 0), normal=(0, 0, 1), radius=1.0)
b = cga.circle(center=(0, 1, 2), normal=(0, 0.5, 1), radius=0.6)
between = objects.interpolate(a, b, alpha=np.linspace(0, 1, 1000))
assert between.shape == (1000,) and np.allclose(between.parameters().radius[[0, -1]], [0.6, 1.0])
motor = cga.rotor((0, 0, 1), np.pi / 2, point=(1, 0, 0))
assert np.allclose((motor >> cga.point((2, 0, 0))).parameters().xyz, (1, 1, 0))
pose = poses.from_euler("ZYX", [90, 0, 30], position=(0.3, 0, 0), degrees=True)
assert np.allclose(poses.exp(poses.log(pose)).values, pose.values)
print("ok")
"""


def check_contents(wheel: Path) -> None:
    """Raise SystemExit for a wheel that is too large, or holds what nobody needs."""
    size = wheel.stat().st_size
    print(f"{wheel.name}: {size / 1e6:.2f} MB")
    if size > MOST_BYTES:
        raise SystemExit(f"it has {size} bytes; at most {MOST_BYTES} are allowed.")
    with zipfile.ZipFile(wheel) as opened:
        unwanted = [n for n in opened.namelist() if any(part in n for part in UNWANTED) or n.endswith(".o")]
        kernels = [n for n in opened.namelist() if n.endswith((".so", ".pyd"))]
    if unwanted:
        raise SystemExit(f"it holds {len(unwanted)} files that nobody needs, such as {unwanted[0]}")
    if not kernels:
        raise SystemExit("it holds no compiled kernels.")


def requirements(wheel: Path) -> list[str]:
    """What a wheel needs, without extras."""
    with zipfile.ZipFile(wheel) as opened:
        metadata = opened.read(next(n for n in opened.namelist() if n.endswith(".dist-info/METADATA"))).decode()
    start = "Requires-Dist: "
    needed = [line.removeprefix(start) for line in metadata.splitlines() if line.startswith(start)]
    return [each for each in needed if "extra ==" not in each]


def run_snippet(python: Path) -> None:
    """The snippet in a new interpreter, which finds no compiler."""
    with tempfile.TemporaryDirectory() as folder:
        hidden = {"PATH": folder, "CC": "", "BLADESMITH_CACHE_DIR": folder, "NUMBA_CACHE_DIR": folder}
        environment = {k: v for k, v in os.environ.items() if k not in ("PYTHONPATH", "PYTHONHOME")}
        done = subprocess.run(
            [python, "-c", SNIPPET], env={**environment, **hidden}, cwd=folder, capture_output=True, text=True
        )
    if done.returncode or done.stdout.strip() != "ok":
        raise SystemExit(f"the snippet failed:\n{done.stdout}{done.stderr}")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("wheel", nargs="?", type=Path)
    parser.add_argument("--installed", action="store_true", help="check what is installed in this environment")
    options = parser.parse_args()
    if options.installed:
        run_snippet(Path(sys.executable))
        return
    if options.wheel is None:
        parser.error("give a wheel, or --installed")
    check_contents(options.wheel)
    with tempfile.TemporaryDirectory() as folder:
        venv.create(folder, with_pip=True)
        python = next(p for p in Path(folder).glob("*/python*") if p.name in ("python", "python.exe"))
        subprocess.run([python, "-m", "pip", "install", "-q", *requirements(options.wheel)], check=True)
        begin = time.perf_counter()
        subprocess.run([python, "-m", "pip", "install", "-q", options.wheel], check=True)
        run_snippet(python)
        seconds = time.perf_counter() - begin
    print(f"installed and run in {seconds:.1f} s")
    if seconds > MOST_SECONDS:
        raise SystemExit(f"that is more than {MOST_SECONDS:g} s.")


if __name__ == "__main__":
    main()
