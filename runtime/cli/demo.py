"""`bladesmith demo`: the main job end to end on bundled inputs, into one page."""

from __future__ import annotations

import sys
import tempfile
import time
from collections.abc import Callable
from importlib import resources
from pathlib import Path
from typing import Any

import click

from ..errors import BladesmithError

#: The algebra that the demonstration derives again.
DEMO_ALGEBRA = "cga3d"


@click.command(
    epilog="Example: bladesmith demo && open bladesmith-demo/index.html",
    context_settings={"help_option_names": ["-h", "--help"]},
)
@click.option("-o", "--out", default="bladesmith-demo", type=click.Path(file_okay=False), help="Folder to write.")
@click.option("--width", type=click.IntRange(16, 8192), help="Width of the picture; default: the scene's.")
@click.option("--threads", default=None, type=click.IntRange(1), help="Threads of the renderer. Default: all.")
@click.option("--quiet", is_flag=True, help="No progress bars.")
def command(out: str, width: int | None, threads: int | None, quiet: bool) -> None:
    """Derive an algebra, render a scene with it, blend and cluster objects, and measure error against run time.

    Needs no input file and no network. Opens with bladesmith-demo/index.html.
    """
    folder = Path(out)
    folder.mkdir(parents=True, exist_ok=True)
    stages: list[tuple[str, str, float]] = []

    def stage(title: str, work: Callable[[], str]) -> None:
        click.echo(f"{title} ...")
        start = time.perf_counter()
        said = work()
        stages.append((title, said, time.perf_counter() - start))
        click.echo(f"  {said} ({stages[-1][2]:.1f} s)")

    results: list[Any] = []
    stage(f"Deriving {DEMO_ALGEBRA} from its signature", lambda: _regenerate(quiet))
    stage("Rendering the scene", lambda: _render(folder, width, threads, quiet))
    stage("Blending and clustering objects", lambda: _objects(folder))
    stage("Measuring error against run time", lambda: _studies(folder, results, quiet))
    page = _write(folder, stages, results, width)
    click.echo(f"Look at {page}")


def _regenerate(quiet: bool) -> str:
    """Generate the stock algebra in a temporary folder and compare it with what is installed."""
    import json

    from ..codegen.generator import generate
    from ..codegen.spec import load_spec, stock_spec_path

    installed = Path(str(resources.files(f"{__package__.partition('.')[0]}.generated").joinpath(DEMO_ALGEBRA)))
    records = json.loads((installed / "forms.json").read_text(encoding="utf-8"))
    with tempfile.TemporaryDirectory(prefix="bladesmith-demo-") as temporary:
        files = generate(load_spec(stock_spec_path(DEMO_ALGEBRA)), records)
        for name, text in files.items():
            (Path(temporary) / name).write_text(text, encoding="utf-8")
        different = [
            name
            for name in files
            if (Path(temporary) / name).read_text("utf-8") != (installed / name).read_text("utf-8")
        ]
    if different:
        raise BladesmithError(f"the generated {DEMO_ALGEBRA} differs from the installed one: {', '.join(different)}.")
    kernels = len(json.loads(files["manifest.json"])["kernels"])
    return f"{kernels} kernels, identical to the installed ones"


def _render(folder: Path, width: int | None, threads: int | None, quiet: bool) -> str:
    from .. import tracer

    scene = tracer.Scene.load(demo_scene_path())
    settings = scene.settings
    height = None if width is None else max(1, width * settings["height"] // settings["width"])
    # a bar is for a terminal, not for a pipe or a log
    shown = not quiet and sys.stderr.isatty()
    image = scene.render(width=width, height=height, threads=threads, progress=shown)
    tracer.save_image(folder / "scene.png", image)
    rows, columns = image.shape[:2]
    return f"{columns} x {rows} pixels with {len(scene.kernels)} kernels"


def _objects(folder: Path) -> str:
    """A curve through circles, and clusters of lines: computed in batches, drawn without a window."""
    import numpy as np

    from .. import cga3d, curves, objects, plot

    rings = cga3d.circle(
        center=[[0, 0, 0], [0.3, 0, 1.2], [1.5, 0.4, 2.2], [2.9, 1, 1.9], [3.6, 1.4, 0.8]],
        normal=[[0, 0, 1], [0.5, 0, 1], [1, 0.3, 0.2], [1, 0.5, -0.6], [0.3, 0.2, -1]],
        radius=[0.9, 0.5, 0.8, 0.4, 0.7],
    )
    rng = np.random.default_rng(3)
    axes = [([0, 0, 0], [0, 0, 1]), ([2, 0, 0], [0, 1, 0.3]), ([0, 2, 1], [1, 0, 0])]
    means = np.repeat(np.array(axes, float), 40, axis=0)
    seen = means + rng.normal(scale=0.12, size=means.shape)
    lines = cga3d.line(seen[:, 0], seen[:, 1])
    found = objects.kmeans(lines, len(axes), seed=1)
    left, right = plot.panels(1, 2, size=(9.6, 4.2), frame=False)
    plot.draw(curves.KochanekBartels(rings), ax=left, size=0.7, samples=40)
    plot.draw(rings, ax=left, color=plot.palette.INK, size=2)
    plot.draw(lines, ax=right, color=found.labels, extent=3)
    plot.draw(found.centroids, ax=right, color=plot.palette.INK, size=2.5)
    plot.save(folder / "objects.png", right)
    return f"a tube through {len(rings)} circles; {len(lines)} lines in {len(axes)} clusters"


def demo_scene_path() -> Path:
    """The bundled scene."""
    return Path(str(resources.files(f"{__package__.partition('.')[0]}.tracer").joinpath("data", "demo.toml")))


def _studies(folder: Path, results: list[Any], quiet: bool) -> str:
    from tqdm import tqdm

    from ..report.registry import STUDIES, load_study
    from ..report.runner import run_study
    from ..report.write import write_report

    for name in STUDIES:
        study = load_study(name)
        with tqdm(desc=name, disable=quiet or None, unit="run", leave=False) as bar:

            def progress(done: int, total: int, text: str, bar: Any = bar) -> None:
                bar.total, bar.n = total, done
                bar.refresh()

            results.append((study, run_study(study, quick=True, progress=progress)))
    write_report(results, folder / "report")
    return f"{len(results)} studies, {sum(len(rows) for _, rows in results)} measurements"


def _write(folder: Path, stages: list[tuple[str, str, float]], results: list[Any], width: int | None) -> Path:
    from ..codegen.templating import render
    from ..files import write_atomically
    from ..report.write import machine

    source = demo_scene_path().read_text(encoding="utf-8")
    size = None if width is None else f"a width of {width}"
    page = render("report/demo.html.j2", stages=stages, results=results, machine=machine(), scene=source, size=size)
    write_atomically(folder / "index.html", page)
    return folder / "index.html"
