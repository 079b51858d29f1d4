"""Writer of reports: raw JSON, work-precision plots and stability tables, in one folder with an HTML page."""

from __future__ import annotations

import json
import math
import os
import platform
import re
import sys
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import asdict, dataclass
from datetime import date
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from ...codegen.build.cpu_features import processor_name
from ...codegen.targets.templates import render
from ...common.executors import Payload, Task, run_pieces
from ...common.files import as_path, write_atomically
from ...common.progress import ProgressOption, open_progress
from ...errors import InputError, MissingExtraError
from ...plot.palette import SERIES
from ..registry import load_study
from .runner import SEED, Measurement, run_study, time_text
from .study import Study

_PACKAGES = ("bladesmith", "numpy", "cffi", "sympy", "jinja2", "numba", "mpmath", "clifford")


def machine() -> dict[str, str]:
    """Description of the machine of the measurements."""
    from ...codegen.build.extension import compiler

    c_compiler = compiler()
    versions = {}
    for package in _PACKAGES:
        try:
            versions[package] = version(package)
        except PackageNotFoundError:
            continue
    return {
        "date": date.today().isoformat(),
        "processor": f"{processor_name()}, {os.cpu_count()} threads",
        "system": f"{platform.system()} {platform.machine()}",
        "python": sys.version.split()[0],
        "compiler": c_compiler.summary if c_compiler else "none",
        "seed": str(SEED),
        **versions,
    }


def plot(study: Study, rows: Sequence[Measurement], path: Path) -> None:
    """Work-precision plot: one panel per case, largest error against time per item, a line per method. For a study
    with a promised fraction: the measured fractions.

    Raises
    ------
    MissingExtraError
        If matplotlib is not installed.
    """
    try:
        from .plot import draw, draw_fractions, draw_sweeps
    except ImportError:
        raise MissingExtraError("plot") from None
    path.parent.mkdir(parents=True, exist_ok=True)
    picture = draw if study.promised is None else draw_fractions
    picture(study, [r for r in rows if not r.sweep]).savefig(path)
    if any(r.sweep for r in rows):
        draw_sweeps(study, rows).savefig(path.with_name(f"{path.stem}-sweeps.png"))


def measure(
    names: Sequence[str],
    folder: Path,
    quick: bool = False,
    progress: ProgressOption = False,
    executor: Executor | None = None,
) -> Iterator[tuple[Study, list[Measurement]]]:
    """Run studies one after another. Each is drawn and the report written again before it is yielded, so that an
    interrupt loses nothing but the present study.

    Parameters
    ----------
    names : sequence of str
        See `load_study`: names, and files of users.
    folder : Path
        Folder of the report.
    quick : bool
        See `run_study`.
    progress : bool or callable
        See `run_study`; with an executor a callable gets a `bladesmith.Progress` of studies.
    executor : concurrent.futures.Executor, optional
        Runs one study in each call, on machines that are like this one: times are the workers' own.

    Raises
    ------
    InputError
        If a name is not that of a study, or two studies have one name, before any is run.
    ExecutorError
        If workers of the executor fail or end, and do so again.
    """
    studies = [load_study(name) for name in names]
    if doubled := [name for name, count in Counter(study.name for study in studies).items() if count > 1]:
        raise InputError(f"two studies are called {doubled[0]!r}; results are kept by name.")
    results: list[tuple[Study, list[Measurement]]] = []

    def add(study: Study, rows: list[Measurement]) -> None:
        plot(study, rows, folder / f"{study.name}.png")
        results.append((study, rows))
        _write_page(results, folder)

    if executor is None:
        for study in studies:
            add(study, run_study(study, quick, progress))
            yield results[-1]
        return
    with open_progress(progress, "report", "studies", len(studies)) as report:

        def take(number: int, rows: list[Measurement]) -> None:
            add(studies[number], rows)
            report(len(results), studies[number].name)

        pieces = [((name,), f"the measurements of {study.name}") for name, study in zip(names, studies, strict=True)]
        run_pieces(executor, Payload.of(_Studies(quick)), _run_named, pieces, take)
    yield from results


@dataclass(frozen=True)
class _Studies(Task):
    quick: bool

    def prepare(self) -> bool:
        return self.quick


def _run_named(quick: bool, name: str) -> list[Measurement]:
    return run_study(load_study(name), quick)


def write_report(results: Sequence[tuple[Study, Sequence[Measurement]]], folder: str | Path) -> Path:
    """Write a report of studies that were run: ``report.json``, ``index.html``, and a `plot` of each.

    Parameters
    ----------
    results : sequence of (Study, sequence of Measurement)
        What `run_study` returned of each.
    folder : path
        Made where it is not there.

    Returns
    -------
    Path
        The page.

    Raises
    ------
    MissingExtraError
        If matplotlib is not installed.
    """
    home = as_path(folder, "a report is written to")
    for study, rows in results:
        plot(study, rows, home / f"{study.name}.png")
    return _write_page(results, home)


def _choices(results: Sequence[tuple[Study, Sequence[Measurement]]]) -> dict[str, str]:
    """What the page chooses methods from, as JSON that may stand in HTML (empty where there is nothing to choose), and
    the colors of methods."""
    studies = {
        study.name: {
            "title": study.title,
            "unit": study.unit,
            "rows": [
                {
                    "case": r.case, "method": r.method, "setting": r.setting_text, "lost": r.lost, "ns": r.nanoseconds,
                    "error": r.max_error if math.isfinite(r.max_error) else None,
                }
                for r in rows
                if not r.sweep
            ],
        }
        for study, rows in results
        if study.promised is None
    }  # fmt: skip
    measured = json.dumps(studies, separators=(",", ":")).replace("<", "\\u003c") if studies else ""
    return {"measured": measured, "colors": " ".join(SERIES)}


def publish(
    results: Sequence[tuple[Study, Sequence[Measurement]]], path: Path, about: Mapping[str, str], quick: bool = False
) -> None:
    """Write the page of a report as Markdown (MyST), for a site that Sphinx makes: the chooser and the tables.

    Parameters
    ----------
    about : mapping
        Of the machine that measured: see `machine`.
    quick : bool
        Whether the runs were quick: the page says so.
    """
    page = render(
        "page.md.j2", about=about, quick=quick, results=results, time=time_text, md=_markdown, **_choices(results)
    )
    write_atomically(path, page)


def _markdown(text: str) -> str:
    """Text whose characters mean nothing in Markdown, but for code in backticks."""

    def plain(found: re.Match[str]) -> str:
        return found[0] if found[0].startswith("`") else "&lt;" if found[0] == "<" else f"\\{found[0]}"

    return re.sub(r"`[^`]*`|[\\*_|$<\[\]]", plain, text)


def _write_page(results: Sequence[tuple[Study, Sequence[Measurement]]], folder: Path) -> Path:
    """Write ``report.json`` and ``index.html``, which shows ``<study>.png`` of each study; return the page's path."""
    about = machine()
    raw: Mapping[str, Any] = {
        "machine": about,
        "studies": {
            s.name: {"title": s.title, "unit": s.unit, "rows": [asdict(r) for r in rows]} for s, rows in results
        },
    }
    folder.mkdir(parents=True, exist_ok=True)
    write_atomically(folder / "report.json", json.dumps(raw, indent=1) + "\n")
    page = render("index.html.j2", machine=about, results=results, time=time_text, **_choices(results))
    write_atomically(folder / "index.html", page)
    return folder / "index.html"
