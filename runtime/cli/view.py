"""`bladesmith view`: a scene file into one interactive page."""

from __future__ import annotations

from pathlib import Path

import click

from . import options


@options.command("view scene.toml -o page.html", "geometry/scenes")
@options.input_file("scene")
@options.output_file("page.html", "The page, .html or .htm.")
@click.option("--title", help="Of the page; default: the scene file's name.")
@click.option("--vertices", type=options.COUNT, help="Of all meshes, about; default: 200000, some 8 MB.")
@options.feedback
def command(scene: Path, output: Path, title: str | None, vertices: int | None, feedback: options.Feedback) -> None:
    """Write a scene as one HTML page: surfaces in 3D to turn and zoom, control objects, camera and lights.

    The page needs no network, only a browser with WebGL; point at a surface to read its name, position and alpha.
    It holds plotly's JavaScript (5 MB) and the meshes.
    """
    from ..common.files import output_path
    from ..tracer import Scene
    from ..tracer.viewer.page import FORMATS, VERTICES, view

    output_path(output, "a page", "pages", FORMATS)
    options.check_outputs([output], [scene], "the scene file")
    loaded = Scene.load(scene)
    page = view(loaded, output, title=scene.stem if title is None else title, vertices=vertices or VERTICES)
    for line in page.missing:
        click.echo(line, err=True)
    feedback.say(f"{output}: {page}")
