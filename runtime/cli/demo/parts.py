"""Parts of `bladesmith demo`, each a line on its page."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from importlib import resources
from pathlib import Path
from typing import Any

import click

#: Quick studies of the algebra and of robots. All: `bladesmith report`.
DEMO_STUDIES = ("products", "distance", "reaching")
#: Those of them that need a C compiler.
COMPILED_STUDIES = ("reaching",)
#: The algebra that is derived from nothing but its signature.
SIGNATURE = (2, 0, 1)
SIGNATURE_TEXT = ",".join(map(str, SIGNATURE))


@dataclass
class Page:
    """The page, written again after each part, so that an interrupt loses nothing but the part at work."""

    folder: Path
    width: int | None
    parts: list[tuple[str, str, float]] = field(default_factory=list)
    picture: bool = False
    compilation: Any = None
    objects: bool = False
    results: list[Any] = field(default_factory=list)
    complete: bool = False

    @property
    def path(self) -> Path:
        return self.folder / "index.html"

    def do(self, title: str, work: Callable[[], str]) -> None:
        """Do a part, put it on the page, and say what was found."""
        click.echo(f"{title} ...")
        start = time.perf_counter()
        found = work()
        self.parts.append((title, found, time.perf_counter() - start))
        click.echo(f"  {found} ({self.parts[-1][2]:.1f} s)")
        self.write()

    def write(self) -> None:
        from ...benchmarks.harness.runner import duration_text
        from ...benchmarks.harness.write import machine
        from ...benchmarks.registry import STUDIES, expected_seconds
        from ...codegen.targets.templates import render
        from ...common.files import write_atomically

        text = render(
            "demo.html.j2",
            page=self,
            machine=machine(),
            scene=demo_scene_path().read_text(encoding="utf-8"),
            studies=len(STUDIES),
            duration=duration_text(expected_seconds(STUDIES)),
        )
        write_atomically(self.path, text)


def render_part(page: Page, threads: int | None, shows_bars: bool) -> str:
    from ... import tracer

    scene = tracer.Scene.load(demo_scene_path())
    settings, width = scene.settings, page.width
    height = None if width is None else max(1, width * settings["height"] // settings["width"])
    image = scene.render(width=width, height=height, threads=threads, progress=shows_bars)
    tracer.save_image(page.folder / "scene.png", image)
    page.picture = True
    rows, columns = image.shape[:2]
    return f"{columns} x {rows} pixels with {len(scene.kernels)} kernels"


def compile_part(page: Page) -> str:
    """The formula of the picture's tube, from its text to compiled code that agrees with 50 digits."""
    from ...benchmarks.harness.compilation import compile_blend

    page.compilation = made = compile_blend()
    count = made.operations.multiplications
    error = f"largest error {made.error:.1e} against {made.digits} digits"
    return f"{count} multiplications; a {made.kind} takes {made.nanoseconds:.0f} ns; {error}"


def derive_part() -> str:
    """An algebra that is not installed, as `bladesmith generate --signature` writes it."""
    import json

    from ...codegen.declarations import plain_spec
    from ...codegen.generator import generate

    files = generate(plain_spec(*SIGNATURE, "pga2d"), {})
    kernels = len(json.loads(files["manifest.json"])["kernels"])
    lines = sum(text.count("\n") for file, text in files.items() if file.endswith((".c", ".h")))
    return f"{kernels} kernels, {lines} lines of C"


def objects_part(page: Page) -> str:
    """A curve through circles, and clusters of lines: computed in batches, drawn without a window."""
    import numpy as np

    from ... import curves, objects, plot
    from ...core.registry import stock_algebra

    cga3d: Any = stock_algebra("cga3d")
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
    plot.save(page.folder / "objects.png", right)
    page.objects = True
    return f"a tube through {len(rings)} circles; {len(lines)} lines in {len(axes)} clusters"


def studies_part(page: Page, names: Sequence[str], shows_bars: bool) -> Iterator[str]:
    """Each step runs one study."""
    from ...benchmarks.harness.write import measure

    for study, rows in measure(names, page.folder / "report", True, shows_bars):
        page.results.append((study, rows))
        yield f"{len(rows)} measurements"


def demo_scene_path() -> Path:
    """The bundled scene."""
    return Path(str(resources.files(f"{__package__.partition('.')[0]}.tracer.io").joinpath("data", "demo.toml")))
