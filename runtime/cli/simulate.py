"""`bladesmith simulate`: a file of bodies, loads and constraints into a trajectory, plots and films."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from .outputs import check_places, partial_name
from .waiting import counted, noticed_bar

if TYPE_CHECKING:
    from ..dynamics.document import Setup
    from ..dynamics.record import Record

NOTICE = "preparing: what such a simulation needs is compiled once, and kept"


@click.command(
    epilog="Example: bladesmith simulate body.toml -o trajectory.npz --plot --animate motion.html",
    context_settings={"help_option_names": ["-h", "--help"]},
)
@click.argument("body", type=click.Path(path_type=Path))
@click.option(
    "--output",
    "-o",
    "outputs",
    type=click.Path(path_type=Path),
    multiple=True,
    help="A .npz file of arrays or a .csv table, may be repeated; default: trajectory.npz.",
)
@click.option("--plot", is_flag=True, help="Curves over time, in a .png beside the first output. (Extra: plot.)")
@click.option("--picture", type=click.Path(path_type=Path), help="The motion in space: PNG, PDF, SVG. (Extra: plot.)")
@click.option(
    "--animate",
    "films",
    type=click.Path(path_type=Path),
    multiple=True,
    help="A .html page, a .gif (extra: plot) or a .mp4 (extra: video), may be repeated.",
)
@click.option("--speed", type=float, help="Of films: units of time in a second; default: 1, or what takes 4 to 20 s.")
@click.option("--rate", type=float, default=25.0, show_default=True, help="Of films: pictures in a second.")
@click.option("--progress/--quiet", default=None, help="Show a bar; default: on a terminal.")
def command(
    body: Path,
    outputs: tuple[Path, ...],
    plot: bool,
    picture: Path | None,
    films: tuple[Path, ...],
    speed: float | None,
    rate: float,
    progress: bool | None,
) -> int:
    """Simulate the bodies of a TOML file, and write their trajectory.

    Says on stdout how it went. The exit status is 1 if the simulation could not go on to its end, or was interrupted:
    what there is by then goes to trajectory.partial.npz, beside the file that was asked for.
    """
    from ..dynamics.document import load_simulation

    places = list(outputs) or [Path("trajectory.npz")]
    drawn = [places[0].with_suffix(".png")] if plot else []
    _check(body, places, [*drawn, *([picture] if picture else [])], films, speed, rate)
    setup = load_simulation(body)
    shown = sys.stderr.isatty() if progress is None else progress
    record, trouble = _run(setup, shown)
    if record is not None:
        _tell(setup, record)
    if trouble:
        click.echo(f"{trouble}{_keep_partial(places, record)}", err=True)
        return 1
    assert record is not None  # without trouble there is one
    for place in places:
        record.save(place)
    for place in drawn:
        record.plot(place)
    if picture is not None:
        record.picture(picture)
    for place in films:
        with counted(place.name, "pictures", shown) as tell:
            record.animate(place, speed=speed, rate=rate, progress=tell)
    if progress is not False:
        for place in filter(None, (*places, *drawn, picture, *films)):
            click.echo(f"wrote {place}", err=True)
    return 0


def _check(
    body: Path, places: list[Path], pictures: list[Path], films: tuple[Path, ...], speed: float | None, rate: float
) -> None:
    """Refuse what could not be written, before any work."""
    from ..dynamics import animation, files
    from ..errors import InputError
    from ..plot.figures import check_suffix

    for place in places:
        files.checked_name(place)
    for place in pictures:
        check_suffix(place)
    for place in films:
        animation.checked_name(place)
    check_places([*places, *pictures, *films], [body], "the simulation file")
    for name, value in (("--speed", speed), ("--rate", rate)):
        if value is not None and not 0 < value < float("inf"):
            raise InputError(f"{name} is {value:g}; a positive number is needed.")


def _run(setup: Setup, shown: bool) -> tuple[Record | None, str]:
    """What came of it, and what went wrong."""
    from ..dynamics.progress import told
    from ..dynamics.record import recorded
    from ..errors import SimulationError

    with noticed_bar(NOTICE, told(True, setup.duration) if shown else None) as tell:
        try:
            found: Any = setup.run(progress=tell)
            trouble = found.message
        except SimulationError as error:
            found, trouble = error.trajectory, " ".join(str(error).split())
    return (None if found is None else recorded(found, setup.sketch)), trouble


def _tell(setup: Setup, record: Record) -> None:
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


def _keep_partial(places: list[Path], record: Record | None) -> str:
    """Save what there is, under names that say so; how the line about it ends."""
    from ..errors import InputError

    if record is None or not len(record):
        return "; nothing was written"
    kept = [partial_name(place) for place in places]
    try:
        for place in kept:
            record.save(place)
    except InputError as error:
        return f"; what there is could not be written: {error}"
    return f"; what there is, to t = {record.time[-1]:.6g}: {', '.join(map(str, kept))}"
