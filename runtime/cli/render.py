"""`bladesmith render`: a scene file into a picture."""

from __future__ import annotations

import sys
import time
from pathlib import Path

import click


@click.command(epilog="Example: bladesmith render scene.toml -o image.png --width 1280 --height 720")
@click.argument("scene", type=click.Path(path_type=Path))
@click.option("--output", "-o", type=click.Path(path_type=Path), default="image.png", show_default=True)
@click.option("--width", type=int, help="Pixels; default: the scene's, else 640.")
@click.option("--height", type=int, help="Pixels; default: the scene's, else 480.")
@click.option("--antialias", type=int, help="Rays along each side of a pixel.")
@click.option("--threads", type=click.IntRange(min=1), help="Default: all processors.")
@click.option(
    "--method",
    type=click.Choice(["isolate", "companion", "sampled"]),
    default="isolate",
    show_default=True,
    help="How rays find evolved surfaces.",
)
@click.option("--samples", type=int, default=64, show_default=True, help="Samples of the sampled method.")
@click.option("--progress/--quiet", default=None, help="Show a bar; default: on a terminal.")
def command(
    scene: Path,
    output: Path,
    width: int | None,
    height: int | None,
    antialias: int | None,
    threads: int | None,
    method: str,
    samples: int,
    progress: bool | None,
) -> None:
    """Render a scene file into an image."""
    from ..tracer import Scene, save_image
    from ..tracer.image import check_writable

    check_writable(output)
    loaded = Scene.load(scene)
    shown = sys.stderr.isatty() if progress is None else progress
    start = time.perf_counter()
    image = loaded.render(width, height, threads, shown, method=method, samples=samples, antialias=antialias)
    save_image(output, image)
    if progress is not False:
        rows, columns = image.shape[:2]
        click.echo(f"{output}: {columns} x {rows} pixels in {time.perf_counter() - start:.2f} s", err=True)
