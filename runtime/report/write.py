"""Writing a report: raw JSON, work-precision plots and stability tables, in one folder with an HTML page."""

from __future__ import annotations

import json
import os
import platform
import sys
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import numpy as np

from ..codegen.templating import render
from ..errors import MissingExtraError
from .runner import SEED, Measurement
from .study import Study

#: Errors below this are drawn on this line: a logarithmic axis has no zero.
SMALLEST_DRAWN = 1e-18
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


def write_atomically(path: Path, data: str | bytes) -> None:
    """Write a file under a temporary name and rename it into place, so that no reader sees half of it."""
    path.parent.mkdir(parents=True, exist_ok=True)
    handle, temporary = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(data.encode() if isinstance(data, str) else data)
        os.chmod(temporary, 0o644)
        os.replace(temporary, path)
    except BaseException:
        os.unlink(temporary)
        raise


def plot(study: Study, rows: Sequence[Measurement], path: Path) -> None:
    """Work-precision plot: one panel per case, largest error against nanoseconds per item, a line per method.

    Raises
    ------
    MissingExtraError
        If matplotlib is not installed.
    """
    try:
        from matplotlib.figure import Figure
    except ImportError:
        raise MissingExtraError("plot") from None
    cases = list(dict.fromkeys(r.case for r in rows))
    columns = min(len(cases), 3)
    lines = -(-len(cases) // columns)
    figure = Figure(figsize=(4.6 * columns, 3.6 * lines + 0.6), layout="constrained")
    axes = figure.subplots(lines, columns, squeeze=False, sharey=True)
    for panel, case in zip(axes.flat, cases, strict=False):
        for number, method in enumerate(dict.fromkeys(r.method for r in rows)):
            own = [r for r in rows if r.case == case and r.method == method]
            _draw(panel, own, f"C{number}", method)
        panel.set(xscale="log", yscale="log", title=case, xlabel="ns per item")
        times = [r.nanoseconds for r in rows if r.case == case]
        panel.set_xlim(10 ** np.floor(np.log10(min(times) * 0.9)), 10 ** np.ceil(np.log10(max(times) * 1.1)))
        panel.grid(True, which="major", alpha=0.3)
    for panel in list(axes.flat)[len(cases) :]:
        panel.set_visible(False)
    for row in axes:
        row[0].set_ylabel(f"largest error ({study.unit})")
    handles, labels = axes[0][0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=min(len(labels), 4), frameon=False)
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=110)


def _height(row: Measurement) -> float:
    """Where a point is drawn: no error at all at the bottom, nothing found at all at 1."""
    if row.max_error > 0:
        return row.max_error
    return 1.0 if row.lost else SMALLEST_DRAWN


def _draw(panel: Any, rows: Sequence[Measurement], color: str, method: str) -> None:
    """Points of one method; hollow where answers were lost, with their number."""
    x = [r.nanoseconds for r in rows]
    y = [_height(r) for r in rows]
    panel.plot(x, y, "-", color=color, alpha=0.5)
    for r, a, b in zip(rows, x, y, strict=True):
        panel.plot([a], [b], "o", color=color, fillstyle="none" if r.lost else "full", label=None)
        note = " ".join(part for part in (r.setting, f"({r.lost} lost)" if r.lost else "") if part)
        if note:
            panel.annotate(note, (a, b), textcoords="offset points", xytext=(4, 4), fontsize=7)
    panel.plot([], [], "o-", color=color, label=method)


def write_report(results: Sequence[tuple[Study, Sequence[Measurement]]], folder: Path) -> Path:
    """Write ``report.json``, one PNG per study and ``index.html``; returns the page's path."""
    about = machine()
    raw: Mapping[str, Any] = {
        "machine": about,
        "studies": {
            s.name: {"title": s.title, "unit": s.unit, "rows": [asdict(r) for r in rows]} for s, rows in results
        },
    }
    write_atomically(folder / "report.json", json.dumps(raw, indent=1) + "\n")
    for study, rows in results:
        plot(study, rows, folder / f"{study.name}.png")
    page = render("report/index.html.j2", machine=about, results=results)
    write_atomically(folder / "index.html", page)
    return folder / "index.html"
