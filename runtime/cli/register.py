"""`bladesmith register`: two files of models into the pose that lays one on the other."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from . import options

#: Suffixes of results.
RESULTS = (".json", ".tum")
NOTICE = "preparing: what these kinds of object need is compiled once, and kept"


@options.command("register query.json reference.json -o result.json --picture result.png", "registration/registration")
@options.input_file("query")
@options.input_file("reference")
@options.output_file(None, "Write the result as JSON; default: nowhere.")
@options.file("--picture", help=f"Draw it: {options.IMAGES}")
@options.option_with_default("--samples", 64, "Sets of objects that vote, at most.")
@click.option("--sample-size", type=int, help="Objects of a set; default: two where that places a pose, else three.")
@click.option("--iterations", type=int, help="Rounds of iterative matching, at most; default: 30.")
@options.option_with_default("--seed", 0, "The same seed gives the same result.")
@options.threads
@options.option_with_default("--backend", "c", "What runs the kernels.", click.Choice(["c", "numba", "cuda"]))
@options.option_with_default(
    "--start",
    "global",
    "global: from any displacement; proximity: from where the query stands; or a result to go on from.",
)
@options.flag("--oriented", "Directions must agree; default: an object and its negative are one.")
@options.option_with_default(
    "--loss",
    "linear",
    "How matches that are far off count in the refinement.",
    click.Choice(["linear", "huber", "soft_l1", "cauchy", "tukey"]),
)
@options.option_with_default("--length", 1.0, "What a radian counts as, in sizes of the models.")
@options.flag("--similarity", "The reference may be larger or smaller than the query: find the scale too.")
@options.feedback
def command(
    query: Path, reference: Path, output: Path | None, picture: Path | None, threads: int | None, start: str,
    oriented: bool, feedback: options.Feedback, **settings: Any,
) -> int:  # fmt: skip
    """Find the pose that lays the models of QUERY on those of REFERENCE, and which objects are one.

    Models are JSON files, or the segments of .obj (elements l) and .ply (edges). A result that ends in .tum has the
    pose, and those that serve as well, as a trajectory: timestamp tx ty tz qx qy qz qw, numbered from 0.

    Says on stdout what was found. The exit status is 1 if the pose is not to be relied on. Ctrl-C keeps the best so
    far, in result.partial.json beside the file that was asked for.
    """
    from ..common.files import output_path
    from ..errors import Interrupted
    from ..plot.style import check_suffix
    from ..registration import register
    from ..registration.summary import summary

    options.check_outputs([x for x in (output, picture) if x is not None], [query, reference], "a model")
    if output is not None and output.suffix:  # devices have none
        output_path(output, "a registration", "registrations", RESULTS)
    if picture is not None:
        check_suffix(picture)
    models = _load(query), _load(reference)
    settings["align"] = not oriented
    described = {**settings, "start": start}
    begin = _start(start, settings["similarity"])
    try:
        with feedback.progress(NOTICE, "register") as tell:
            result = register(*models, **settings, threads=threads, start=begin, progress=tell)
    except Interrupted as interrupt:
        click.echo(f"interrupted{_keep_partial(output, (interrupt.partial, *models, described))}", err=True)
        return 1
    record = result, *models, described
    if output is not None:
        _write(output, record)
    if picture is not None:
        from ..registration.plotting.picture import picture as draw

        draw(result, *models, path=picture)
    feedback.wrote((output, picture))
    click.echo(summary(result, models[0].unit if models[0].unit == models[1].unit else ""))
    return 0 if result.converged else 1


def _load(path: Path) -> Any:
    """A model: a JSON file, or the segments of a drawing."""
    from ..interchange.polylines import FORMATS
    from ..registration import Model, model_from_edges

    return model_from_edges(path) if path.suffix.lower() in FORMATS else Model.load(path)


def _start(start: str, similarity: bool) -> Any:
    """Value of ``start``: a name, or the motor of a saved result."""
    from ..errors import InputError
    from ..registration import load_registration
    from ..registration.search.register import STARTS

    if start in STARTS or not start or not (Path(start).exists() or start.endswith(".json")):
        return start
    found = load_registration(start)
    if found.scale != 1 and not similarity:
        what = f"is a similarity of scale {found.scale:.6g}, and its motor alone lays nothing on the reference."
        raise InputError(what, where=start, remedy="Add --similarity")
    return found.motor


def _write(path: Path, record: tuple[Any, ...]) -> None:
    from ..common.files import write_file
    from ..registration.io.result_file import registration_text

    if path.suffix.lower() == ".tum":
        from ..poses import save_tum

        motors = [record[0].motor, *record[0].ambiguous]
        save_tum(path, range(len(motors)), motors)
        return
    write_file(path, registration_text(*record))


def _keep_partial(output: Path | None, record: tuple[Any, ...]) -> str:
    """Save what an interrupt left, under a name that says so; how the line about it ends."""
    result = record[0]
    count = int(result.inliers.sum())
    if not count:
        return " before a pose was found; nothing was written"
    text = f": the best so far matches {count} of {len(result.inliers)} objects"
    return text if output is None else text + options.save_partial([output], lambda path: _write(path, record))
