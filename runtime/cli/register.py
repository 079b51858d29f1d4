"""`bladesmith register`: two files of models into the pose that lays one on the other."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import click

from .outputs import check_places, partial_name
from .waiting import noticed_bar

NOTICE = "preparing: what these kinds of object need is compiled once, and kept"


@click.command(
    epilog="Example: bladesmith register query.json reference.json -o result.json --picture result.png",
    context_settings={"help_option_names": ["-h", "--help"]},
)
@click.argument("query", type=click.Path(path_type=Path))
@click.argument("reference", type=click.Path(path_type=Path))
@click.option("--output", "-o", type=click.Path(path_type=Path), help="Write the result as JSON; default: nowhere.")
@click.option("--picture", type=click.Path(path_type=Path), help="Draw it: PNG, PDF, SVG. (Extra: plot.)")
@click.option("--samples", type=int, default=64, show_default=True, help="Sets of objects that vote, at most.")
@click.option("--sample-size", type=int, help="Objects of a set; default: two where that places a pose, else three.")
@click.option("--iterations", type=int, help="Rounds of iterative matching, at most; default: 30.")
@click.option("--seed", type=int, default=0, show_default=True, help="The same seed gives the same result.")
@click.option("--threads", type=click.IntRange(min=1), help="Default: all processors.")
@click.option("--backend", type=click.Choice(["c", "numba", "cuda"]), default="c", show_default=True)
@click.option(
    "--start",
    default="global",
    show_default=True,
    help="global: from any displacement; proximity: from where the query stands; or a result to go on from.",
)
@click.option("--oriented", is_flag=True, help="Directions must agree; default: an object and its negative are one.")
@click.option(
    "--length", type=float, default=1.0, show_default=True, help="What a radian counts as, in sizes of the models."
)
@click.option(
    "--similarity", is_flag=True, help="The reference may be larger or smaller than the query: find the scale too."
)
@click.option("--progress/--quiet", default=None, help="Show a bar; default: on a terminal.")
def command(
    query: Path,
    reference: Path,
    output: Path | None,
    picture: Path | None,
    samples: int,
    sample_size: int | None,
    iterations: int | None,
    seed: int,
    threads: int | None,
    backend: str,
    start: str,
    oriented: bool,
    length: float,
    similarity: bool,
    progress: bool | None,
) -> int:
    """Find the pose that lays the models of QUERY on those of REFERENCE, and which objects are one.

    Says on stdout what was found. The exit status is 1 if the pose is not to be relied on. Ctrl-C keeps the best so
    far, in result.partial.json beside the file that was asked for.
    """
    from ..reform import Model, register
    from ..reform.progress import told
    from ..reform.summary import summary
    from ..reform.unfinished import INTERRUPTED

    _check_places(output, picture, query, reference)
    models = Model.load(query), Model.load(reference)
    settings: dict[str, Any] = {
        "samples": samples, "sample_size": sample_size, "iterations": iterations, "seed": seed, "backend": backend,
        "length": length, "align": not oriented, "similarity": similarity,
    }  # fmt: skip
    shown = sys.stderr.isatty() if progress is None else progress
    with noticed_bar(NOTICE, told(True) if shown else None) as tell:
        result = register(*models, **settings, threads=threads, start=_start(start, similarity), progress=tell)
    record = result, *models, {**settings, "start": start}
    if result.message == INTERRUPTED:
        click.echo(f"interrupted{_keep_partial(output, record)}", err=True)
        return 1
    if output is not None:
        _write(output, record)
    if picture is not None:
        from ..reform.picture import picture as draw

        draw(result, *models, path=picture)
    if progress is not False:
        for place in filter(None, (output, picture)):
            click.echo(f"wrote {place}", err=True)
    click.echo(summary(result, *models))
    return 0 if result.converged else 1


def _check_places(output: Path | None, picture: Path | None, *inputs: Path) -> None:
    """Refuse what could not be written, before any work."""
    from ..errors import InputError

    places = [place for place in (output, picture) if place is not None]
    if len(places) == 2 and places[0].absolute() == places[1].absolute():
        raise InputError("result and picture have one name.", where=str(output))
    check_places(places, inputs, "a model")
    if picture is not None:
        from ..plot.figures import check_suffix

        check_suffix(picture)


def _start(start: str, similarity: bool) -> Any:
    """What `register` takes: a name, or the motor of a result that was saved."""
    from ..errors import InputError
    from ..reform import load_registration
    from ..reform.register import STARTS

    if start in STARTS or not start or not (Path(start).exists() or start.endswith(".json")):
        return start
    found = load_registration(start)
    if found.scale != 1 and not similarity:
        what = f"is a similarity of scale {found.scale:.6g}, and its motor alone lays nothing on the reference."
        raise InputError(what, where=start, remedy="Add --similarity")
    return found.motor


def _write(place: Path, record: tuple[Any, ...]) -> None:
    from ..files import write_atomically
    from ..reform.record import registration_text

    write_atomically(place, registration_text(*record))


def _keep_partial(output: Path | None, record: tuple[Any, ...]) -> str:
    """Save what an interrupt left, under a name that says so; how the line about it ends."""
    result = record[0]
    count = int(result.inliers.sum())
    if not count:
        return " before a pose was found; nothing was written"
    text = f": the best so far matches {count} of {len(result.inliers)} objects"
    if output is None:
        return text
    place = partial_name(output)
    try:
        _write(place, record)
    except OSError as error:
        return f"{text}; it could not be written: {error.strerror or error}"
    return f"{text}: {place}"
