"""`bladesmith report`: error against run time and stability, as a page, plots and raw JSON."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING

import click

from . import options

if TYPE_CHECKING:
    from ..benchmarks import Measurement, Study


@options.command("report --quick -o report --study distance --study mine.py", "accuracy/report")
@options.output_folder("bladesmith-report")
@click.option(
    "--study",
    "names",
    multiple=True,
    help="Run only this study, or that of your own file mine.py; repeatable. Default: all.",
)
@options.flag("--quick", "A tenth of the items and fewer timings.")
@options.file("--publish", "published", help="Also write the page as Markdown for Sphinx (MyST), when all is done.")
@options.feedback
def command(out: Path, names: tuple[str, ...], quick: bool, published: Path | None, feedback: options.Feedback) -> None:
    """Run the studies and write index.html, one plot per study and report.json.

    Errors are the largest over all items, against references of 50 digits. How long it takes is said first. All is
    written after each study: results of those that are done are kept when you interrupt.
    """
    from ..benchmarks.harness.runner import duration_text
    from ..benchmarks.harness.write import machine, measure, publish
    from ..benchmarks.registry import STUDIES, expected_seconds, load_study
    from ..common.files import check_folder

    for name in names:
        load_study(name)
    options.check_outputs([] if published is None else [published], [], "a study")
    check_folder(out)
    left = list(dict.fromkeys(names) or STUDIES)

    def about(where: str = "") -> str:
        """How long those take that are left, as far as it is known."""
        own = sum(name not in STUDIES for name in left)
        text = f", about {duration_text(expected_seconds(left, quick))}{where}" if own < len(left) else ""
        return f"{text}, and yours" if text and own else text

    results: list[tuple[Study, list[Measurement]]] = []
    count, done, page = len(left), 0, out / "index.html"
    click.echo(f"{count} {'study' if count == 1 else 'studies'}{about(' on two cores')}")
    start = time.perf_counter()
    try:
        for study, rows in measure(list(left), page.parent, quick, feedback.shows_bars):
            done += 1
            left.pop(0)
            results.append((study, rows))
            rest = f"; {len(left)} left{about()}" if left else ""
            click.echo(f"{study.name}: {len(rows)} measurements ({time.perf_counter() - start:.1f} s){rest}")
            start = time.perf_counter()
    except KeyboardInterrupt:
        if done:
            click.echo(f"{done} of {count} studies are in {page}", err=True)
        raise
    if published is not None:
        publish(results, published, machine(), quick)
    click.echo(f"wrote {page}" if published is None else f"wrote {page} and {published}")
