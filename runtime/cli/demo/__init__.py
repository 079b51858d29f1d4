"""`bladesmith demo`: the main job end to end on bundled inputs, into one page."""

from __future__ import annotations

from pathlib import Path

import click

from ...codegen.build.extension import compiler
from .. import options
from . import parts


@options.command("demo && open bladesmith-demo/index.html", "index")
@options.output_folder("bladesmith-demo")
@click.option("--width", type=click.IntRange(16, 8192), help="Width of the picture; default: the scene's.")
@options.threads
@options.feedback
def command(out: Path, width: int | None, threads: int | None, feedback: options.Feedback) -> None:
    """Render a scene, compile a formula, derive an algebra, blend and cluster objects, measure error against run time.

    Needs no input file and no network. Opens with bladesmith-demo/index.html, which is written after each part.
    """
    from ...common.files import check_folder

    check_folder(out)
    page = parts.Page(out, width)
    try:
        page.do("Rendering the scene", lambda: parts.render_part(page, threads, feedback.shows_bars))
        page.do("Compiling a formula", lambda: parts.compile_part(page))
        page.do(f"Deriving Cl({parts.SIGNATURE_TEXT}) from its signature", parts.derive_part)
        page.do("Blending and clustering objects", lambda: parts.objects_part(page))
        names = [name for name in parts.DEMO_STUDIES if name not in parts.COMPILED_STUDIES or compiler()]
        runs = parts.studies_part(page, names, feedback.shows_bars)
        for name in names:
            page.do(f"Measuring: {name}", lambda: next(runs))
    except KeyboardInterrupt:
        if page.parts:
            click.echo(f"What was done is in {page.path}", err=True)
        raise
    page.complete = True
    page.write()
    if len(names) < len(parts.DEMO_STUDIES):
        click.echo(f"Left out without a C compiler: {', '.join(parts.COMPILED_STUDIES)}")
    click.echo(f"Look at {page.path}")
