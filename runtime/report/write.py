"""Writing a report: raw JSON, work-precision plots and stability tables, in one folder with an HTML page."""

from __future__ import annotations

import json
import os
import platform
import sys
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from ..codegen.templating import render
from ..errors import MissingExtraError
from ..files import write_atomically
from .runner import SEED, Measurement, time_text
from .study import Study

_PACKAGES = ("bladesmith", "numpy", "cffi", "sympy", "jinja2", "numba", "mpmath", "clifford")


def machine() -> dict[str, str]:
    """What the figures were measured on."""
    from ..codegen.build import compiler

    found = compiler()
    versions = {}
    for package in _PACKAGES:
        try:
            versions[package] = version(package)
        except PackageNotFoundError:
            continue
    return {
        "processor": _processor(),
        "system": f"{platform.system()} {platform.machine()}",
        "python": sys.version.split()[0],
        "compiler": found.summary if found else "none",
        "seed": str(SEED),
        **versions,
    }


def _processor() -> str:
    try:
        with open("/proc/cpuinfo", encoding="utf-8") as lines:
            name = next(line.split(":", 1)[1].strip() for line in lines if line.startswith("model name"))
    except (OSError, StopIteration):
        name = platform.processor() or "unknown"
    return f"{name}, {os.cpu_count()} threads"


def plot(study: Study, rows: Sequence[Measurement], path: Path) -> None:
    """Work-precision plot: one panel per case, largest error against time per item, a line per method. Of a study that
    promises a share: that which was found of each case.

    Raises
    ------
    MissingExtraError
        If matplotlib is not installed.
    """
    try:
        from .plot import draw, draw_shares, draw_sweeps
    except ImportError:
        raise MissingExtraError("plot") from None
    path.parent.mkdir(parents=True, exist_ok=True)
    picture = draw if study.promised is None else draw_shares
    picture(study, [r for r in rows if not r.sweep]).savefig(path)
    if any(r.sweep for r in rows):
        draw_sweeps(study, rows).savefig(path.with_name(f"{path.stem}-sweeps.png"))


def write_report(results: Sequence[tuple[Study, Sequence[Measurement]]], folder: Path) -> Path:
    """Write ``report.json``, one PNG per study and ``index.html``; returns the page's path."""
    about = machine()
    raw: Mapping[str, Any] = {
        "machine": about,
        "studies": {
            s.name: {"title": s.title, "unit": s.unit, "rows": [asdict(r) for r in rows]} for s, rows in results
        },
    }
    folder.mkdir(parents=True, exist_ok=True)
    write_atomically(folder / "report.json", json.dumps(raw, indent=1) + "\n")
    for study, rows in results:
        plot(study, rows, folder / f"{study.name}.png")
    page = render("report/index.html.j2", machine=about, results=results, time=time_text)
    write_atomically(folder / "index.html", page)
    return folder / "index.html"
