"""`bladesmith report`: error against run time and stability, as a page, plots and raw JSON."""

from __future__ import annotations

from pathlib import Path

import click


@click.command(
    epilog="Example: bladesmith report --quick -o report --study distance",
    context_settings={"help_option_names": ["-h", "--help"]},
)
@click.option("-o", "--out", default="bladesmith-report", type=click.Path(file_okay=False), help="Folder to write.")
@click.option("--study", "names", multiple=True, help="Run only this study (repeatable). Default: all.")
@click.option("--quick", is_flag=True, help="A tenth of the items and fewer timings.")
@click.option("--quiet", is_flag=True, help="No progress bar.")
def command(out: str, names: tuple[str, ...], quick: bool, quiet: bool) -> None:
    """Run the studies and write index.html, one plot per study and report.json.

    Errors are the largest over all items, against references of 50 digits. Results of the studies that are done
    are kept when you interrupt.
    """
    from tqdm import tqdm

    from ..report.registry import STUDIES, load_study
    from ..report.runner import Measurement, run_study
    from ..report.study import Study
    from ..report.write import write_report

    folder = Path(out)
    results: list[tuple[Study, list[Measurement]]] = []
    for name in names or STUDIES:
        study = load_study(name)
        with tqdm(total=None, desc=study.name, disable=quiet or None, unit="run") as bar:

            def progress(done: int, total: int, text: str, bar: tqdm = bar) -> None:
                bar.total, bar.n = total, done
                bar.set_postfix_str(text, refresh=True)

            results.append((study, run_study(study, quick, progress)))
        page = write_report(results, folder)
    click.echo(f"wrote {page}")
