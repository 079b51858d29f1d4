"""`bladesmith simulate`: a file of bodies, loads and constraints into a trajectory, plots and films."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from . import options

if TYPE_CHECKING:
    from ..dynamics.io.reader import Setup
    from ..dynamics.record import Record

NOTICE = "preparing: what such a simulation needs is compiled once, and kept"


@options.command("simulate body.toml -o trajectory.npz --plot --animate motion.html", "motion/simulations")
@options.input_file("body")
@options.output_file(
    None, "A .npz file of arrays or a .csv table, may be repeated; default: trajectory.npz.", "outputs", multiple=True
)
@options.flag("--plot", "Curves over time, in a .png beside the first output. (Extra: plot.)")
@options.file("--picture", help=f"The motion in space: {options.IMAGES}")
@options.file(
    "--animate",
    "films",
    multiple=True,
    help="A .html page, a .gif (extra: plot) or a .mp4 (extra: video), may be repeated.",
)
@click.option("--speed", type=float, help="Of films: units of time in a second; default: 1, or what takes 4 to 20 s.")
@options.option_with_default("--rate", 25.0, "Of films: pictures in a second.")
@options.feedback
def command(
    body: Path, outputs: tuple[Path, ...], plot: bool, picture: Path | None, films: tuple[Path, ...],
    speed: float | None, rate: float, feedback: options.Feedback,
) -> int:  # fmt: skip
    """Simulate the bodies of a TOML file, and write their trajectory.

    Says on stdout how it went. The exit status is 1 if the simulation could not go on to its end, or was interrupted:
    what there is by then goes to trajectory.partial.npz, beside the file that was asked for.
    """
    from ..dynamics.io.reader import load_simulation

    paths = list(outputs) or [Path("trajectory.npz")]
    drawn = [paths[0].with_suffix(".png")] if plot else []
    _check(body, paths, [*drawn, *([picture] if picture else [])], films, speed, rate)
    setup = load_simulation(body)
    record, trouble = _run(setup, feedback)
    if record is not None:
        _print_summary(setup, record)
    if trouble:
        click.echo(f"{trouble}{_keep_partial(paths, record)}", err=True)
        return 1
    assert record is not None  # without trouble there is one
    for path in paths:
        record.save(path)
    for path in drawn:
        record.plot(path)
    if picture is not None:
        record.picture(picture)
    for path in films:
        record.animate(path, speed=speed, rate=rate, progress=feedback.shows_bars)
    feedback.wrote((*paths, *drawn, picture, *films))
    return 0


def _check(
    body: Path, paths: list[Path], pictures: list[Path], films: tuple[Path, ...], speed: float | None, rate: float
) -> None:
    """Refuse what could not be written, before any work."""
    from ..common.validation import positive_float
    from ..dynamics.plotting import animation
    from ..dynamics.results import trajectory_files
    from ..plot.style import check_suffix

    for path in paths:
        trajectory_files.checked_name(path)
    for path in pictures:
        check_suffix(path)
    for path in films:
        animation.checked_name(path)
    beside = "; --plot writes a .png beside the first output"
    options.check_outputs([*paths, *pictures, *films], [body], "the simulation file", beside)
    for name, value in (("--speed", speed), ("--rate", rate)):
        if value is not None:
            positive_float(value, name)


def _run(setup: Setup, feedback: options.Feedback) -> tuple[Record | None, str]:
    """Run a simulation; its record, and the message of a failure."""
    from ..dynamics.record import as_record
    from ..errors import Interrupted, SimulationError

    with feedback.progress(NOTICE, "simulate") as tell:
        try:
            found: Any = setup.run(progress=tell, strict=True)
            trouble = found.message
        except Interrupted as interrupt:
            found, trouble = interrupt.partial, interrupt.partial.message
        except SimulationError as error:
            found, trouble = error.trajectory, " ".join(str(error).split())
    return (None if found is None else as_record(found, setup.sketch)), trouble


def _print_summary(setup: Setup, record: Record) -> None:
    """Say what is known of a trajectory."""
    import numpy as np

    units = record.sketch.units
    if not len(record):
        return
    drift = float(np.ptp(record.energy))
    lines = {
        "integrator": f"{record.integrator}, {record.steps} steps",
        "states": f"{len(record)}, to t = {record.time[-1]:.6g} {units.time}",
        "energy": f"{record.energy[0]:.6g} {units.energy} at the start, varies by {drift:.3g}",
    }
    if setup.simulation.constraints:
        lines["violation"] = f"{float(record.violation.max()):.3g} at most"
    for name, own in record.bodies.items():
        key = f"{name} at the end" if len(record.rows) > 1 else "at the end"
        lines[key] = f"({', '.join(f'{x:.6g}' for x in own.position[-1])}) {units.length}"
    width = max(map(len, lines)) + 1
    for key, text in lines.items():
        click.echo(f"{key + ':':<{width}} {text}")


def _keep_partial(paths: list[Path], record: Record | None) -> str:
    """Save what there is, under names that say so; how the line about it ends."""
    if record is None or not len(record):
        return "; nothing was written"
    return f"; what there is, to t = {record.time[-1]:.6g}" + options.save_partial(paths, record.save)
