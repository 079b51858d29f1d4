"""Films of trajectories, whole or not at all: GIF, MP4, and a page that needs no network.

Frames are drawn by matplotlib; a page draws its own.
"""

from __future__ import annotations

import math
import os
from collections.abc import Generator, Iterator
from contextlib import closing
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ... import plot as drawn
from ...common.deprecation import reordered
from ...common.files import failures_named, output_path, replacing_by_suffix, write_file
from ...common.progress import ProgressOption, Report, open_progress
from ...common.validation import as_int, as_pair, positive_float
from ...errors import InputError, MissingExtraError
from ...mechanics.shapes import Shape
from ...plot import axes_setup, drawing, matplotlib_import, palette, style
from ...plot.glyphs import Faces, Strokes
from ..results.figure_spec import Sketch
from ..results.trajectory_data import TrajectoryData, TrajectorySource, data_of, starts_with_trajectory
from . import curves, scene

Array = NDArray[Any]
FORMATS = (".gif", ".mp4", ".html")
#: Pictures in a second of a film.
FRAME_RATE = 25.0
#: Dots of its sides.
SIZE = (640, 520)
#: Largest number of its pictures.
MAX_FRAMES = 20_000
#: Shortest film by default, in seconds.
SHORTEST = 4.0
#: Longest film by default, in seconds.
LONGEST = 20.0
#: Dots per inch.
DOTS = 100
#: Colors of a GIF.
GIF_COLORS = 128
#: Ticks per second in which a GIF counts the time of its pictures.
GIF_TICK = 100
#: Shades of each path's color in the palette of a GIF.
SHADES = 4
#: Weight of each shade: rows of dots.
SWATCH = 24
#: Quality of an MP4, of 10.
QUALITY = 7
#: Opacity of the remaining part of a path.
AHEAD = 0.15
#: Length of the axes that stand for a body without a shape, as a fraction of the view.
AXES = 0.12


@reordered("trajectory", "path", when=starts_with_trajectory)
def animate(
    path: str | os.PathLike[str],
    trajectory: TrajectorySource,
    *,
    sketch: Sketch | None = None,
    speed: float | None = None,
    rate: float = FRAME_RATE,
    size: tuple[int, int] = SIZE,
    view: tuple[float, float] | None = None,
    progress: ProgressOption = False,
) -> None:
    """Write a film, or an interactive page.

    Parameters
    ----------
    path
        ``.gif`` and ``.mp4`` are films; ``.html`` is one file to rotate and to play that needs no network.
    trajectory : Trajectory or Record
    sketch : Sketch, optional
        Contents of the pictures; default: those stored with the trajectory.
    speed : float, optional
        Units of time per second; default: 1, or the value for which the film takes 4 to 20 seconds.
    rate : float
        Pictures in a second.
    size : (width, height)
        Dots of a film.
    view : (elevation, azimuth), optional
        Degrees; default: the sketch's.
    progress : bool or callable
        True: a bar on standard error. A callable gets a `bladesmith.Progress` of pictures.

    Raises
    ------
    InputError
        If it is a batch, the name has another ending, or the file cannot be written.
    MissingExtraError
        If a film is requested and matplotlib (extra `plot`) or, for MP4, imageio-ffmpeg (extra `video`) is missing.
    """
    file = checked_name(path)
    record = curves.single(data_of(trajectory, sketch))
    if not len(record):
        raise InputError("a trajectory without states has no film.")
    pace = default_speed(record) if speed is None else positive_float(speed, "speed")
    angles = record.sketch.view if view is None else as_pair(view, "view")
    if file.suffix.lower() == ".html":
        from .html import page_text

        write_file(file, page_text(record, pace, angles))
        return
    numbers = frame_numbers(record, pace, positive_float(rate, "rate"))
    write: Any = _write_gif if file.suffix.lower() == ".gif" else _write_mp4
    with (
        open_progress(progress, file.name, "pictures", len(numbers)) as report,
        closing(_with_progress(frames(record, numbers, _even(size), angles), report)) as pictures,
        failures_named(file),
        replacing_by_suffix(file) as temporary,  # writers read the suffix
    ):
        write(temporary, pictures, rate, _even(size), [color for _, color, _ in scene.paths(record)])


def checked_name(path: Any) -> Path:
    """Path of a film, whose libraries are installed.

    Raises
    ------
    InputError, MissingExtraError
    """
    file = output_path(path, "a film", "films and pages", FORMATS)
    suffix = file.suffix.lower()
    if suffix != ".html":
        matplotlib_import.figure_class()
        _library("PIL.Image", "plot") if suffix == ".gif" else _library("imageio_ffmpeg", "video")
    return file


def _library(name: str, extra: str) -> Any:
    try:
        return import_module(name)
    except ImportError:
        raise MissingExtraError(extra, "A film") from None


def default_speed(record: TrajectoryData) -> float:
    """Units of time per second: 1, unless a film would be very short or very long."""
    duration = float(record.time[-1] - record.time[0])
    return max(duration / LONGEST, min(1.0, duration / SHORTEST)) or 1.0


def frame_numbers(record: TrajectoryData, speed: float, rate: float) -> Array:
    """Index of the stored state of each picture.

    Raises
    ------
    InputError
        If there are too many pictures.
    """
    start, end = float(record.time[0]), float(record.time[-1])
    count = (end - start) / speed * rate
    if count > MAX_FRAMES:
        raise InputError(
            f"the film has {count:.3g} pictures; at most {MAX_FRAMES} are drawn.", remedy="Raise the speed"
        )
    times = start + np.arange(math.floor(count) + 1) * speed / rate
    after = np.clip(np.searchsorted(record.time, times), 1, max(1, len(record) - 1))
    nearer = np.abs(record.time[after - 1] - times) <= np.abs(record.time[np.minimum(after, len(record) - 1)] - times)
    return np.minimum(np.where(nearer, after - 1, after), len(record) - 1)


def _even(size: Any) -> tuple[int, int]:
    """Sides in dots, even as video codecs need them."""
    width, height = (as_int(int(x), "size", 16, 8192) for x in as_pair(size, "size"))
    return width - width % 2, height - height % 2


def _with_progress(pictures: Iterator[Array], report: Report) -> Generator[Array]:
    """Generator of the pictures that reports progress."""
    for i, each in enumerate(pictures, 1):
        yield each
        report(i)


# -- pictures --------------------------------------------------------------------------------------------------


def frames(record: TrajectoryData, numbers: Array, size: tuple[int, int], view: tuple[float, float]) -> Iterator[Array]:
    """Pictures (height, width, 3) of some states: bodies in their poses, paths up to them."""
    ax = drawn.axes(view, (size[0] / DOTS, size[1] / DOTS))
    figure: Any = ax.figure
    figure.set_dpi(DOTS)
    canvas = matplotlib_import.load_module("matplotlib.backends.backend_agg").FigureCanvasAgg(figure)
    stage = _Stage(record, ax)
    for number in numbers.tolist():
        stage.show(number)
        canvas.draw()
        yield np.asarray(canvas.buffer_rgba())[..., :3].copy()


class _Stage:
    """Moving parts of a picture."""

    def __init__(self, record: TrajectoryData, ax: Any) -> None:
        self.record, self.ax = record, ax
        self.paths = scene.paths(record)
        art = matplotlib_import.load_module("mpl_toolkits.mplot3d.art3d")
        box = scene.view_bounds(record)
        faint = [palette.with_opacity(palette.per_item(color, 1, color), AHEAD) for _, color, _ in self.paths]
        step = self.step = max(1, -(-len(record) // curves.MAX_STATES))
        for (_, _, points), rows in zip(self.paths, faint, strict=True):
            drawn.paths(points[::step], ax, rows, scene.THIN, box)
        if record.sketch.objects:
            drawn.draw(*record.sketch.objects, ax=ax, color=palette.GREY, size=scene.OBJECT)
        self.lines = []
        for label, color, _ in self.paths:
            line = art.Line3D([], [], [], color=color, linewidth=scene.TRACE, solid_capstyle="round")
            line.set(zorder=drawing.ORDER[Strokes], clip_on=False)
            self.lines.append(ax.add_line(line))
            if label:
                handle = matplotlib_import.line_class()([], [], color=color, label=style.plain(label))
                drawing.picture_of(ax).handles.append(handle)
        if drawing.picture_of(ax).handles:
            axes_setup.show_legend(ax, drawing.picture_of(ax).handles)
        axes_setup.fill_page(ax)
        self.bodies = [self._body(name, body) for name, body in record.bodies.items()]
        self.clock = ax.figure.text(0.98, 0.955, "", ha="right", fontsize=10, color=palette.INK)
        self.title = style.plain(record.sketch.title)

    def _body(self, name: str, body: TrajectoryData) -> tuple[TrajectoryData, Shape | None, str, Any, Any]:
        shape, color = body.sketch.shape_of(name, len(body.rows) == 1), scene.body_color(body, name)
        art = matplotlib_import.collections()
        triangles = np.zeros((1, 3, 3)) if shape is None else scene.vertices_at(body, shape, 0)[shape.faces]
        faces = style.surface(triangles, color, scene.SOLID)
        edges = art.Line3DCollection(
            np.zeros((1, 2, 3)), colors=color, linewidths=scene.TRACE if shape is None else scene.THIN
        )
        for artist, kind in ((faces, Faces), (edges, Strokes)):
            self.ax.add_collection3d(artist)
            artist.set(zorder=drawing.ORDER[kind], clip_on=False)
        return body, shape, color, faces, edges

    def show(self, number: int) -> None:
        """Show one state."""
        for (_, _, points), line in zip(self.paths, self.lines, strict=True):
            line.set_data_3d(*points[: number + 1 : self.step].T)
        for body, shape, color, faces, edges in self.bodies:
            if shape is None:
                size = AXES * max(np.ptp(limits) for limits in (self.ax.get_xlim(), self.ax.get_ylim()))
                ends = body.position[number] + size * body.orientation[number].T
                edges.set_segments(np.stack([np.broadcast_to(body.position[number], (3, 3)), ends], 1))
                edges.set_color(palette.AXES)
                faces.set_visible(False)
                continue
            vertices = scene.vertices_at(body, shape, number)
            faces.set_verts(vertices[shape.faces])
            faces.set_facecolor(style.shade_triangles(vertices[shape.faces], color, scene.SOLID))
            edges.set_segments(vertices[shape.edges])
        time = f"t = {self.record.time[number]:.2f} {style.plain(self.record.sketch.units.time)}"
        self.clock.set_text(f"{self.title}    {time}" if self.title else time)


# -- films -----------------------------------------------------------------------------------------------------


def _write_gif(
    path: Path, pictures: Iterator[Array], rate: float, size: tuple[int, int], colors: list[str]
) -> None:  # fmt: skip
    image = _library("PIL.Image", "plot")
    ticks = max(2, round(GIF_TICK / rate))  # players slow down what is faster
    start = next(pictures)
    colored = image.fromarray(np.concatenate([start, _swatches(colors, size[0])])).quantize(GIF_COLORS)
    first = image.fromarray(start).quantize(palette=colored, dither=image.Dither.NONE)
    rest = (image.fromarray(x).quantize(palette=colored, dither=image.Dither.NONE) for x in pictures)
    first.save(path, save_all=True, append_images=rest, duration=ticks * 1000 // GIF_TICK, loop=0, optimize=False)


def _swatches(colors: list[str], width: int) -> Array:
    """Rows of the colors of paths, down to white, for the palette: the first picture has none of them."""
    ends = [palette.per_item(color, 1, color)[:, :3] for color in colors]
    shares = np.repeat(np.linspace(1, 0.25, SHADES), -(-width // SHADES))[:width, None]
    rows = [np.repeat((255 * (1 - shares * (1 - end)))[None], SWATCH, 0) for end in ends]
    return np.concatenate(rows).astype(np.uint8)


def _write_mp4(
    path: Path, pictures: Iterator[Array], rate: float, size: tuple[int, int], colors: list[str]
) -> None:  # fmt: skip
    library = _library("imageio_ffmpeg", "video")
    writer = library.write_frames(
        str(path), size, fps=rate, codec="libx264", quality=QUALITY, macro_block_size=2, ffmpeg_log_level="error"
    )
    writer.send(None)
    try:
        for picture in pictures:
            writer.send(np.ascontiguousarray(picture))
    finally:
        writer.close()


__all__ = ["FORMATS", "animate", "checked_name", "frames"]
