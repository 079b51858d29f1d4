"""`bladesmith view`: a scene file into one interactive page."""

from __future__ import annotations

from pathlib import Path

import click


@click.command(epilog="Example: bladesmith view scene.toml -o page.html")
@click.argument("scene", type=click.Path(path_type=Path))
@click.option("--output", "-o", type=click.Path(path_type=Path), default="page.html", show_default=True)
@click.option("--title", help="Of the page; default: the scene file's name.")
@click.option(
    "--vertices",
    type=click.IntRange(min=1),
    help="About how many the meshes may have together; default: 200000, some 8 MB.",
)
@click.option("--quiet", is_flag=True, help="Do not say what was written.")
def command(scene: Path, output: Path, title: str | None, vertices: int | None, quiet: bool) -> None:
    """Write a scene as one HTML page: surfaces in 3D to turn and zoom, control objects, camera and lights.

    The page needs no network, only a browser with WebGL; point at a surface to read its name, position and alpha.
    It holds plotly's JavaScript (5 MB) and the meshes.
    """
    from ..errors import InputError
    from ..tracer import Scene
    from ..tracer.view import VERTICES, view

    if not output.absolute().parent.is_dir():
        raise InputError(f"there is no folder {output.parent}.", where=str(output))
    if output.exists() and scene.exists() and output.samefile(scene):
        raise InputError("the page would take the place of the scene file.", where=str(output))
    loaded = Scene.load(scene)
    page = view(loaded, output, title=scene.stem if title is None else title, vertices=vertices or VERTICES)
    for line in page.missing:
        click.echo(line, err=True)
    if not quiet:
        click.echo(f"{output}: {page}", err=True)
