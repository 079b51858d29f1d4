"""Times of two commits in one run, in turns; exit status 1 where the newer one is slower by more than a tenth.

Both are checked out and compiled in folders of their own, and each case is timed in one process of each, turn by
turn, so that what the machine does beside it meets both. Of the ratios of turns the median counts, with the interval
that 95 % of resampled medians lie in: a loss is one whose interval lies above the limit.

    python benchmarks/compare.py main~1                      # against what is checked out here, changes included
    python benchmarks/compare.py v0.1.0 main --only first_hits delta --turns 31
    python benchmarks/compare.py --figures docs/accuracy/figures.md     # a table of this state, for the docs
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from cases import CASES

ROOT = Path(__file__).resolve().parents[1]
#: The loss that is none.
LIMIT = 1.10
TURNS = 21
#: Seconds that a turn takes at least, of runs one after the other.
TURN = 0.02
#: Packages beside `runtime`, whose folders stand inside the installed one.
PACKAGES = ("codegen", "templates", "generated")


class Worker:
    """A process that times cases of one state of the package."""

    def __init__(self, name: str, view: Path, cache: Path) -> None:
        environment = {**os.environ, "PYTHONPATH": str(view), "BLADESMITH_CACHE_DIR": str(cache)}
        self.name = name
        self._process = subprocess.Popen(
            [sys.executable, str(Path(__file__)), "--serve"], env=environment, text=True,
            stdin=subprocess.PIPE, stdout=subprocess.PIPE,
        )  # fmt: skip

    def ask(self, request: Any) -> Any:
        """The answer to a request, or None where the case does not run there."""
        assert self._process.stdin is not None and self._process.stdout is not None
        self._process.stdin.write(json.dumps(request) + "\n")
        self._process.stdin.flush()
        answer = json.loads(self._process.stdout.readline() or '{"error": "the process ended"}')
        if "error" in answer:
            print(f"{self.name}: {request['case']}: {answer['error']}", file=sys.stderr)
        return answer.get("seconds")

    def end(self) -> None:
        """Let the process go."""
        self._process.kill()
        self._process.wait()


def serve() -> None:
    """Answer requests: prepare a case, or time a turn of it."""
    calls: dict[str, tuple[Any, int]] = {}
    for line in sys.stdin:
        name = json.loads(line)["case"]
        try:
            if name not in calls:
                call = CASES[name].prepare(np.random.default_rng(1))
                call()
                begin = time.perf_counter()
                call()
                calls[name] = call, max(1, int(TURN / max(time.perf_counter() - begin, 1e-7)))
            call, rounds = calls[name]
            begin = time.process_time()
            for _ in range(rounds):
                call()
            answer: dict[str, Any] = {"seconds": (time.process_time() - begin) / rounds}
        except Exception as error:  # of a state that has no such function: it is told, and the next case goes on
            answer = {"error": f"{type(error).__name__}: {error}".splitlines()[0]}
        print(json.dumps(answer), flush=True)


@contextmanager
def state(commit: str | None) -> Iterator[Path]:
    """A folder from which a commit's package is imported, compiled; of None what is checked out here."""
    with ExitStack() as stack, tempfile.TemporaryDirectory() as folder:
        home = ROOT
        if commit is not None:
            home = Path(folder, "checkout")
            git("worktree", "add", "--detach", "--quiet", str(home), commit)
            stack.callback(git, "worktree", "remove", "--force", str(home))
        subprocess.run([sys.executable, "setup.py", "-q", "build_ext", "--inplace"], cwd=home, check=True, stdout=2)
        package = Path(folder, "view", "bladesmith")
        package.mkdir(parents=True)
        for path in [*(home / "runtime").iterdir(), *(home / name for name in PACKAGES)]:
            (package / path.name).symlink_to(path)
        yield package.parent


def git(*words: str) -> str:
    """Run git here."""
    done = subprocess.run(["git", *words], cwd=ROOT, check=True, capture_output=True, text=True)
    return done.stdout.strip()


def interval(ratios: np.ndarray, seed: int = 0) -> tuple[float, float, float]:
    """Median of ratios, and the ends between which 95 % of the medians of resampled ones lie."""
    drawn = np.random.default_rng(seed).choice(ratios, size=(2000, len(ratios)))
    low, high = np.quantile(np.median(drawn, axis=1), [0.025, 0.975])
    return float(np.median(ratios)), float(low), float(high)


def compare(old: Worker, new: Worker, names: list[str], turns: int, limit: float) -> list[str]:
    """Print a row for each case; the names of those that lost."""
    lost = []
    print(f"{'':24s}{'before':>12s}{'now':>12s}   now/before, 95 %")
    for name in names:
        times = np.array([[each.ask({"case": name}) or np.nan for each in (old, new)] for _ in range(turns + 1)][1:])
        if not np.isfinite(times).all():
            print(f"{name:24s} not compared")
            continue
        middle, low, high = interval(times[:, 1] / times[:, 0])
        before, now = (readable(x / CASES[name].items) for x in times.min(axis=0))
        verdict = "  LOSS" if low > limit else "  gain" if high < 1 / limit else ""
        print(f"{name:24s}{before:>12s}{now:>12s}   {middle:.3f}  [{low:.3f}, {high:.3f}]{verdict}", flush=True)
        if low > limit:
            lost.append(name)
    return lost


def figures(worker: Worker, names: list[str], turns: int) -> str:
    """A page with the times of all cases, and what machine it was."""
    rows = []
    for name in names:
        found = [x for _ in range(turns) if (x := worker.ask({"case": name})) is not None]
        if found:
            least, middle = (readable(x / CASES[name].items) for x in (min(found), float(np.median(found))))
            many = f"{CASES[name].items:,}".replace(",", " ")
            rows.append(f"| {CASES[name].says} | {many} | {least} | {middle} |")
    machine = f"{processor()}, {os.cpu_count()} processors, {platform.system()}, Python {platform.python_version()}"
    return "\n".join(
        [
            "# Times of this version",
            "",
            "Written by `python benchmarks/compare.py --figures docs/accuracy/figures.md`, not by hand: processor",
            f"time of one thread for each item, the least and the median of {turns} turns. {machine};",
            f"bladesmith {git('describe', '--always', '--dirty')}.",
            "",
            "| what | items in a call | least | median |",
            "| --- | --- | --- | --- |",
            *rows,
            "",
        ]
    )


def processor() -> str:
    """What the processor calls itself."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        return platform.processor() or platform.machine()
    return next((line.split(":")[1].strip() for line in lines if line.startswith("model name")), platform.machine())


def readable(seconds: float) -> str:
    """A time with its unit."""
    for unit, factor in (("s", 1.0), ("ms", 1e3), ("us", 1e6)):
        if seconds * factor >= 1:
            return f"{seconds * factor:.3g} {unit}"
    return f"{seconds * 1e9:.3g} ns"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("base", nargs="?", help="the commit before")
    parser.add_argument("head", nargs="?", help="the commit after; default: what is checked out here, changes included")
    parser.add_argument("--only", nargs="+", metavar="CASE", choices=list(CASES), default=list(CASES))
    parser.add_argument("--turns", type=int, default=TURNS)
    parser.add_argument("--limit", type=float, default=LIMIT, help="the ratio from which on it is a loss")
    parser.add_argument("--figures", type=Path, metavar="FILE", help="write a table of this state's times instead")
    parser.add_argument("--serve", action="store_true", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.serve:
        serve()
        return 0
    if (options.base is None) == (options.figures is None):
        parser.error("give a commit to compare with, or --figures FILE")
    states = [options.head] if options.figures else [options.base, options.head]
    with ExitStack() as stack:
        workers = []
        for commit in states:
            view = stack.enter_context(state(commit))
            cache = Path(stack.enter_context(tempfile.TemporaryDirectory()))
            workers.append(Worker(commit or "here", view, cache))
            stack.callback(workers[-1].end)
        if options.figures:
            options.figures.write_text(figures(workers[0], options.only, options.turns), encoding="utf-8")
            return 0
        lost = compare(*workers, options.only, options.turns, options.limit)
    if lost:
        print(f"slower by more than {options.limit - 1:.0%}: {', '.join(lost)}", file=sys.stderr)
    return 1 if lost else 0


if __name__ == "__main__":
    sys.exit(main())
