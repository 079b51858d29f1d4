"""`bladesmith render`: a scene file into a picture."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import click

from . import options

#: What `--aov` offers; the names are those of `tracer.layers.LAYERS`.
LAYERS = ("normal", "depth", "alpha", "cost")
METHODS = ("isolate", "companion", "sampled")
NOTHING = "interrupted before the first pixels were done; nothing was written"
NOTICE = "preparing: what a scene needs is compiled when it is first rendered, and kept"


@options.command("render scene.toml -o image.png --width 1280 --height 720 --aov depth", "geometry/scenes")
@options.input_file("scene")
@options.output_file("image.png", "PNG, JPEG, WebP, BMP or TIFF in sRGB; EXR in linear float32.")
@click.option("--width", type=int, help="Pixels; default: the scene's, else 640.")
@click.option("--height", type=int, help="Pixels; default: the scene's, else 480.")
@click.option("--antialias", type=int, help="Rays along each side of a pixel; default: the scene's, else 1.")
@options.threads
@options.option_with_default("--method", "isolate", "How rays find evolved surfaces.", click.Choice(METHODS))
@options.option_with_default("--samples", 64, "Samples of the sampled method.")
@click.option(
    "--aov",
    "layers",
    multiple=True,
    type=click.Choice(LAYERS),
    help="Another layer, may be repeated: a channel of an EXR file, else a picture such as image.depth.png.",
)
@options.feedback
def command(
    scene: Path, output: Path, width: int | None, height: int | None, antialias: int | None, threads: int | None,
    method: str, samples: int, layers: tuple[str, ...], feedback: options.Feedback,
) -> int:  # fmt: skip
    """Render a scene file into an image.

    Ctrl-C leaves what is done in image.partial.png, beside the image that was asked for.
    """
    from ..tracer import Scene
    from ..tracer.output.image import check_writable
    from ..tracer.rendering.canvas import RenderInterrupted
    from ..tracer.scene.render_options import picture_options

    check_writable(output)  # before the scene is read, which may take long
    loaded = Scene.load(scene)
    check_writable(output, *loaded.size(width, height))
    names = ("color", *layers)
    picture_options(loaded.settings, width, height, names, method, samples, antialias, float)  # before it is compiled
    start = time.perf_counter()
    try:
        with feedback.preparing(NOTICE):  # one pixel: the bar tells the picture's own time then
            loaded.layers(1, 1, names, method=method, samples=samples)
    except KeyboardInterrupt:
        click.echo(NOTHING, err=True)
        return 1
    ready = time.perf_counter()
    try:
        found = loaded.layers(
            width, height, names, threads, feedback.shows_bars, method=method, samples=samples, antialias=antialias
        )
    except RenderInterrupted as interrupt:
        click.echo(_keep_partial(output, interrupt.partial), err=True)
        return 1
    try:
        written = _save(output, found)
    except KeyboardInterrupt:
        click.echo(f"interrupted while {output} was written; what is not there is lost", err=True)
        return 1
    rows, columns = found["color"].shape[:2]
    taken = f"{time.perf_counter() - ready:.2f} s, after {ready - start:.2f} s of preparation"
    legends = [f"{path}: {legend}" for path, legend in written.items()] if layers else []
    feedback.say(f"{output}: {columns} x {rows} pixels in {taken}", *legends)
    return 0


def _keep_partial(output: Path, partial: Any) -> str:
    """Save what an interrupt left, under a name that says so; the line to tell about it."""
    from ..tracer.output.image import save_layers

    if not partial.done.any():
        return NOTHING
    note = f"interrupted with {100 * partial.fraction_done:.3g} % of the picture done"
    return note + options.save_partial([output], lambda path: list(save_layers(path, partial.layers, partial.done)))


def _save(output: Path, layers: Mapping[str, Any]) -> dict[Path, str]:
    """Save the picture; where the disk fails after a long render, in the folder for temporary files instead."""
    from ..errors import InputError
    from ..tracer.output.image import save_layers

    try:
        return save_layers(output, layers)
    except InputError as error:
        spare = Path(tempfile.mkdtemp(prefix="bladesmith-")) / output.name
        try:
            save_layers(spare, layers)
        except InputError:
            spare.parent.rmdir()
            raise error from None
        raise click.ClickException(f"{error} The picture is in {spare}.") from None
