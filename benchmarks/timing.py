"""Shared by benchmarks: the time of a call on one processor, and sections whose rows are printed as they finish."""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Callable, Iterator, Mapping
from typing import Any

Row = dict[str, Any]
Part = Callable[[argparse.Namespace], Iterator[Row]]
#: Times that are taken, of which the least counts.
REPEATS = 9
#: A run is repeated within a timing until it takes so long, in seconds.
LEAST = 0.01


def seconds(run: Callable[[], Any], repeats: int = REPEATS) -> float:
    """Processor time of one run: the least of several."""
    run()
    start = time.process_time()
    run()
    rounds = max(1, int(LEAST / max(time.process_time() - start, 1e-7)))
    found = []
    for _ in range(repeats):
        start = time.process_time()
        for _ in range(rounds):
            run()
        found.append((time.process_time() - start) / rounds)
    return min(found)


def arguments(description: str | None, parts: Mapping[str, Part]) -> argparse.ArgumentParser:
    """A parser of what all such benchmarks take; it is the script that adds its own, and parses."""
    parser = argparse.ArgumentParser(description=description, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", nargs="+", choices=list(parts), default=list(parts))
    parser.add_argument("--skip-clifford", action="store_true")
    parser.add_argument("--json", help="write the rows to this file")
    return parser


def run_parts(
    options: argparse.Namespace, parts: Mapping[str, Part], row_text: Callable[[Row], str], headings: bool = True
) -> None:
    """Run the parts that are asked for, tell their rows, with headings where `what` changes, and keep them."""
    rows, before = [], ""
    for name in options.only:
        for row in parts[name](options):
            rows.append(row)
            if headings and row["what"] != before:
                before = row["what"]
                print(f"-- {before}")
            print(row_text(row), flush=True)
    if options.json:
        with open(options.json, "w", encoding="utf-8") as file:
            json.dump(rows, file, indent=1)
