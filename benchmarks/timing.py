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


def row_text(row: Row) -> str:
    """One line of a row: what was measured, and whether a bar is missed."""
    line = f"  {row['method']:42s}"
    if "setting" in row:
        line += f" {row['setting']!s:>8s}"
    if "error" in row:
        line += f" error {row['error']:8.1e}"
    if row.get("lost"):
        line += f", {row['lost']} lost"
    if "ns" in row:
        line += f" {row['ns']:12.4g} ns"
    if "rate" in row:
        line += f" {row['rate']:9.3g} steps/s"
    if "bar" in row:
        line += f"  bar {row['bar']:g} ns{'' if row['ns'] <= row['bar'] else ' MISSED'}"
    if "times" in row:
        line += f"  {row['times']:.3g} times"
    if "least" in row:
        line += f", bar {row['least']:.3g}{'' if row['times'] >= row['least'] else ' MISSED'}"
    return line


def run_parts(
    options: argparse.Namespace, parts: Mapping[str, Part], text: Callable[[Row], str] = row_text, headings: bool = True
) -> None:
    """Run the parts that are asked for, tell their rows, with headings where `what` changes, and keep them."""
    rows, before = [], ""
    for name in options.only:
        for row in parts[name](options):
            rows.append(row)
            if headings and row["what"] != before:
                before = row["what"]
                print(f"-- {before}")
            print(text(row), flush=True)
    if options.json:
        with open(options.json, "w", encoding="utf-8") as file:
            json.dump(rows, file, indent=1)
