"""`bladesmith render`: a scene file into a picture."""

from __future__ import annotations

import sys
import tempfile
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import click

from .outputs import partial_name
from .waiting import PATIENCE, noticed

#: What `--aov` offers; the names are those of `tracer.layers.LAYERS`.
LAYERS = ("normal", "depth", "alpha", "cost")
NOTHING = "interrupted before the first pixels were done; nothing was written"
NOTICE = "preparing: what a scene needs is compiled when it is first rendered, and kept"


@click.command(
    epilog="Example: bladesmith render scene.toml -o image.png --width 1280 --height 720 --aov depth",
    context_settings={"help_option_names": ["-h", "--help"]},
)
@click.argument("scene", type=click.Path(path_type=Path))
@click.option(
    "--output",
    "-o",
    type=click.Path(path_type=Path),
    default="image.png",
    show_default=True,
    help="PNG, JPEG, WebP, BMP or TIFF in sRGB; EXR in linear float32.",
)
@click.option("--width", type=int, help="Pixels; default: the scene's, else 640.")
@click.option("--height", type=int, help="Pixels; default: the scene's, else 480.")
@click.option("--antialias", type=int, help="Rays along each side of a pixel; default: the scene's, else 1.")
@click.option("--threads", type=click.IntRange(min=1), help="Default: all processors.")
@click.option(
    "--method",
    type=click.Choice(["isolate", "companion", "sampled"]),
    default="isolate",
    show_default=True,
    help="How rays find evolved surfaces.",
)
@click.option("--samples", type=int, default=64, show_default=True, help="Samples of the sampled method.")
@click.option(
    "--aov",
    "layers",
    multiple=True,
    type=click.Choice(LAYERS),
    help="Another layer, may be repeated: a channel of an EXR file, else a picture such as image.depth.png.",
)
@click.option("--progress/--quiet", default=None, help="Show a bar with the remaining time; default: on a terminal.")
def command(
    scene: Path,
    output: Path,
    width: int | None,
    height: int | None,
    antialias: int | None,
    threads: int | None,
    method: str,
    samples: int,
    layers: tuple[str, ...],
    progress: bool | None,
) -> int:
    """Render a scene file into an image.

    Ctrl-C leaves what is done in image.partial.png, beside the image that was asked for.
    """
    from ..tracer import Scene
    from ..tracer.image import check_writable
    from ..tracer.options import picture_view
    from ..tracer.pictures import RenderInterrupted

    check_writable(output)  # before the scene is read, which may take long
    loaded = Scene.load(scene)
    check_writable(output, *loaded.size(width, height))
    shown = sys.stderr.isatty() if progress is None else progress
    names = ("color", *layers)
    picture_view(loaded.settings, width, height, names, method, samples, antialias, float)  # before it is compiled
    start = time.perf_counter()
    try:
        _prepare(loaded, names, method, samples, shown)
    except KeyboardInterrupt:
        click.echo(NOTHING, err=True)
        return 1
    ready = time.perf_counter()
    try:
        found = loaded.layers(width, height, names, threads, shown, method=method, samples=samples, antialias=antialias)
    except RenderInterrupted as interrupt:
        click.echo(_keep_partial(output, interrupt.partial), err=True)
        return 1
    try:
        written = _save(output, found)
    except KeyboardInterrupt:
        click.echo(f"interrupted while {output} was written; what is not there is lost", err=True)
        return 1
    if progress is not False:
        rows, columns = found["color"].shape[:2]
        taken = f"{time.perf_counter() - ready:.2f} s, after {ready - start:.2f} s of preparation"
        click.echo(f"{output}: {columns} x {rows} pixels in {taken}", err=True)
        for path, legend in written.items() if layers else ():
            click.echo(f"{path}: {legend}", err=True)
    return 0


def _prepare(scene: Any, names: tuple[str, ...], method: str, samples: int, shown: bool) -> None:
    """Render one pixel: what is compiled is compiled then, and the bar tells the picture's own time."""
    with noticed(NOTICE, shown, PATIENCE):
        scene.layers(1, 1, names, method=method, samples=samples)


def _keep_partial(output: Path, partial: Any) -> str:
    """Save what an interrupt left, under a name that says so; the line to tell about it."""
    from ..errors import BladesmithError
    from ..tracer.image import save_layers

    if not partial.done.any():
        return NOTHING
    share = f"interrupted with {100 * partial.share:.3g} % of the picture done"
    place = partial_name(output)
    try:
        written = save_layers(place, partial.layers, partial.done)
    except (OSError, BladesmithError) as error:
        return f"{share}; it could not be written: {error}"
    return f"{share}: {', '.join(str(path) for path in written)}"


def _save(output: Path, layers: Mapping[str, Any]) -> dict[Path, str]:
    """Save the picture; where the disk fails after a long render, in the folder for temporary files instead."""
    from ..tracer.image import save_layers

    try:
        return save_layers(output, layers)
    except OSError as error:
        spare = Path(tempfile.mkdtemp(prefix="bladesmith-")) / output.name
        try:
            save_layers(spare, layers)
        except OSError:
            spare.parent.rmdir()
            raise error from None
        reason = error.strerror or str(error)
        raise click.ClickException(f"{error.filename or output}: {reason}. The picture is in {spare}.") from None
