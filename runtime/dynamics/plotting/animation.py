"""Films of trajectories, whole or not at all: GIF, MP4, and a page that needs no network.

Frames are drawn by matplotlib; a page draws its own.
"""

from __future__ import annotations

import math
import os
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .. import plot as drawn
from ..errors import InputError, MissingExtraError
from ..files import failures_named, replacing_by_suffix
from ..plot import backend, drawing, figures, pages, palette
from ..plot import checks as given
from ..plot.outlines import Faces, Strokes
from . import pictures, plots
from .record import Record, recorded
from .shapes import Shape
from .sketch import Sketch

if TYPE_CHECKING:
    from collections.abc import Callable

    from .trajectory import Trajectory

Array = NDArray[Any]
FORMATS = (".gif", ".mp4", ".html")
#: Pictures in a second of a film, dots of its sides, and how many pictures it may have.
RATE, SIZE, MOST_FRAMES = 25.0, (640, 520), 20_000
#: Seconds that a film of a very short or very long motion takes.
SHORTEST, LONGEST = 4.0, 20.0
DOTS = 100
#: Colours of a GIF; players count its pictures in hundredths of a second.
GIF_COLORS, GIF_TICK = 128, 100
#: Shades of each path's colour that a GIF has, and the weight of each: rows of dots.
SHADES, SWATCH = 4, 24
#: Of 10.
QUALITY = 7
#: Opacity of the part of a path that is still to come.
AHEAD = 0.15
#: Length of the axes that stand for a body without a shape, as a share of the view.
AXES = 0.12


def animate(
    trajectory: Trajectory | Record,
    path: str | os.PathLike[str],
    *,
    sketch: Sketch | None = None,
    speed: float | None = None,
    rate: float = RATE,
    size: tuple[int, int] = SIZE,
    view: tuple[float, float] | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> None:
    """Write a film, or an interactive page.

    Parameters
    ----------
    trajectory : Trajectory or Record
    path
        ``.gif`` and ``.mp4`` are films; ``.html`` is one file to turn and to play that needs no network.
    sketch : Sketch, optional
        What is shown; default: what was stored with the trajectory.
    speed : float, optional
        Units of time that pass in a second; default: 1 where a film takes 4 to 20 seconds then, else what it takes.
    rate : float
        Pictures in a second.
    size : (width, height)
        Dots of a film.
    view : (elevation, azimuth), optional
        Degrees; default: the sketch's.
    progress : callable, optional
        Called with the number of pictures that are done, and of all.

    Raises
    ------
    InputError
        If it is a batch, the name has another ending, or the file cannot be written.
    MissingExtraError
        If a film is asked for and matplotlib (extra `plot`) or, for MP4, imageio-ffmpeg (extra `video`) is missing.
    """
    place = checked_name(path)
    record = plots.single(recorded(trajectory, sketch))
    if not len(record):
        raise InputError("a trajectory without states has no film.")
    pace = default_speed(record) if speed is None else given.positive(speed, "speed")
    angles = record.sketch.view if view is None else given.pair(view, "view")
    if place.suffix.lower() == ".html":
        from .page import write_page

        write_page(record, place, pace, angles)
        return
    numbers = frame_numbers(record, pace, given.positive(rate, "rate"))
    write: Any = _write_gif if place.suffix.lower() == ".gif" else _write_mp4
    shots = _told(frames(record, numbers, _even(size), angles), len(numbers), progress)
    try:
        with failures_named(place), replacing_by_suffix(place) as temporary:  # writers go by the suffix
            write(temporary, shots, rate, _even(size), [color for _, color, _ in pictures.paths(record)])
    finally:
        shots.close()


def checked_name(path: Any) -> Path:
    """A path that a film can be written to, and the libraries for it are there.

    Raises
    ------
    InputError, MissingExtraError
    """
    try:
        file = Path(os.fsdecode(path))
    except TypeError:
        raise InputError(f"a film is written to a file, and {path!r} names none.") from None
    suffix = file.suffix.lower()
    if "\0" in str(file) or suffix not in FORMATS:
        raise InputError(f"films are {', '.join(FORMATS[:-1])}, pages {FORMATS[-1]}.", where=str(file))
    if suffix != ".html":
        backend.figure_class()
        _library("PIL.Image", "plot") if suffix == ".gif" else _library("imageio_ffmpeg", "video")
    return file


def _library(name: str, extra: str) -> Any:
    try:
        return import_module(name)
    except ImportError:
        raise MissingExtraError(extra, "A film") from None


def default_speed(record: Record) -> float:
    """Units of time in a second: 1, unless a film would be very short or very long."""
    duration = float(record.time[-1] - record.time[0])
    return max(duration / LONGEST, min(1.0, duration / SHORTEST)) or 1.0


def frame_numbers(record: Record, speed: float, rate: float) -> Array:
    """The stored state of each picture.

    Raises
    ------
    InputError
        If there are too many.
    """
    start, end = float(record.time[0]), float(record.time[-1])
    count = (end - start) / speed * rate
    if count > MOST_FRAMES:
        raise InputError(
            f"the film has {count:.3g} pictures; at most {MOST_FRAMES} are drawn.", remedy="Raise the speed"
        )
    times = start + np.arange(math.floor(count) + 1) * speed / rate
    after = np.clip(np.searchsorted(record.time, times), 1, max(1, len(record) - 1))
    nearer = np.abs(record.time[after - 1] - times) <= np.abs(record.time[np.minimum(after, len(record) - 1)] - times)
    return np.minimum(np.where(nearer, after - 1, after), len(record) - 1)


def _even(size: Any) -> tuple[int, int]:
    """Sides in dots, even: video codecs want pairs."""
    width, height = (given.whole(int(x), "size", 16, 8192) for x in given.pair(size, "size"))
    return width - width % 2, height - height % 2


def _told(shots: Iterator[Array], count: int, progress: Callable[[int, int], None] | None) -> Any:
    for i, each in enumerate(shots, 1):
        yield each
        if progress is not None:
            progress(i, count)


# -- pictures --------------------------------------------------------------------------------------------------


def frames(record: Record, numbers: Array, size: tuple[int, int], view: tuple[float, float]) -> Iterator[Array]:
    """Pictures (height, width, 3) of some states: bodies as they are, paths as far as they have come."""
    ax = drawn.axes(view, (size[0] / DOTS, size[1] / DOTS))
    figure: Any = ax.figure
    figure.set_dpi(DOTS)
    canvas = backend.imported("matplotlib.backends.backend_agg").FigureCanvasAgg(figure)
    stage = _Stage(record, ax)
    for number in numbers.tolist():
        stage.show(number)
        canvas.draw()
        yield np.asarray(canvas.buffer_rgba())[..., :3].copy()


class _Stage:
    """What moves in a picture."""

    def __init__(self, record: Record, ax: Any) -> None:
        self.record, self.ax = record, ax
        self.paths = pictures.paths(record)
        art = backend.imported("mpl_toolkits.mplot3d.art3d")
        box = pictures.room(record)
        faint = [palette.faded(palette.per_item(color, 1, color), AHEAD) for _, color, _ in self.paths]
        step = self.step = max(1, -(-len(record) // plots.MOST))
        for (_, _, points), rows in zip(self.paths, faint, strict=True):
            drawn.paths(points[::step], ax, rows, pictures.THIN, box)
        if record.sketch.objects:
            drawn.draw(*record.sketch.objects, ax=ax, color=palette.GREY, size=pictures.OBJECT)
        self.lines = []
        for label, color, _ in self.paths:
            line = art.Line3D([], [], [], color=color, linewidth=pictures.TRACE, solid_capstyle="round")
            line.set(zorder=drawing.ORDER[Strokes], clip_on=False)
            self.lines.append(ax.add_line(line))
            if label:
                handle = backend.line_class()([], [], color=color, label=figures.plain(label))
                drawing.picture_of(ax).handles.append(handle)
        if drawing.picture_of(ax).handles:
            pages.show_legend(ax, drawing.picture_of(ax).handles)
        pages.fill_page(ax)
        self.bodies = [self._body(name, own) for name, own in record.bodies.items()]
        self.clock = ax.figure.text(0.98, 0.955, "", ha="right", fontsize=10, color=palette.INK)
        self.title = figures.plain(record.sketch.title)

    def _body(self, name: str, own: Record) -> tuple[Record, Shape | None, str, Any, Any]:
        shape, color = own.sketch.shape_of(name, len(own.rows) == 1), pictures.body_color(own, name)
        art = backend.collections()
        triangles = np.zeros((1, 3, 3)) if shape is None else pictures.placed(own, shape, 0)[shape.faces]
        faces = figures.surface(triangles, color, pictures.SOLID)
        edges = art.Line3DCollection(
            np.zeros((1, 2, 3)), colors=color, linewidths=pictures.TRACE if shape is None else pictures.THIN
        )
        for artist, kind in ((faces, Faces), (edges, Strokes)):
            self.ax.add_collection3d(artist)
            artist.set(zorder=drawing.ORDER[kind], clip_on=False)
        return own, shape, color, faces, edges

    def show(self, number: int) -> None:
        """Everything at one state."""
        for (_, _, points), line in zip(self.paths, self.lines, strict=True):
            line.set_data_3d(*points[: number + 1 : self.step].T)
        for own, shape, color, faces, edges in self.bodies:
            if shape is None:
                size = AXES * max(np.ptp(limits) for limits in (self.ax.get_xlim(), self.ax.get_ylim()))
                ends = own.position[number] + size * own.orientation[number].T
                edges.set_segments(np.stack([np.broadcast_to(own.position[number], (3, 3)), ends], 1))
                edges.set_color(palette.AXES)
                faces.set_visible(False)
                continue
            vertices = pictures.placed(own, shape, number)
            faces.set_verts(vertices[shape.faces])
            faces.set_facecolor(figures.shaded(vertices[shape.faces], color, pictures.SOLID))
            edges.set_segments(vertices[shape.edges])
        time = f"t = {self.record.time[number]:.2f} {figures.plain(self.record.sketch.units.time)}"
        self.clock.set_text(f"{self.title}    {time}" if self.title else time)


# -- films -----------------------------------------------------------------------------------------------------


def _write_gif(
    path: Path, shots: Iterator[Array], rate: float, size: tuple[int, int], colors: list[str]
) -> None:  # fmt: skip
    image = _library("PIL.Image", "plot")
    ticks = max(2, round(GIF_TICK / rate))  # players slow down what is faster
    start = next(shots)
    colored = image.fromarray(np.concatenate([start, _swatches(colors, size[0])])).quantize(GIF_COLORS)
    first = image.fromarray(start).quantize(palette=colored, dither=image.Dither.NONE)
    rest = (image.fromarray(x).quantize(palette=colored, dither=image.Dither.NONE) for x in shots)
    first.save(path, save_all=True, append_images=rest, duration=ticks * 1000 // GIF_TICK, loop=0, optimize=False)


def _swatches(colors: list[str], width: int) -> Array:
    """Rows of the colours of paths, down to white: at the start of a film there is none of them in the picture."""
    ends = [palette.per_item(color, 1, color)[:, :3] for color in colors]
    shares = np.repeat(np.linspace(1, 0.25, SHADES), -(-width // SHADES))[:width, None]
    rows = [np.repeat((255 * (1 - shares * (1 - end)))[None], SWATCH, 0) for end in ends]
    return np.concatenate(rows).astype(np.uint8)


def _write_mp4(
    path: Path, shots: Iterator[Array], rate: float, size: tuple[int, int], colors: list[str]
) -> None:  # fmt: skip
    library = _library("imageio_ffmpeg", "video")
    writer = library.write_frames(
        str(path), size, fps=rate, codec="libx264", quality=QUALITY, macro_block_size=2, ffmpeg_log_level="error"
    )
    writer.send(None)
    try:
        for picture in shots:
            writer.send(np.ascontiguousarray(picture))
    finally:
        writer.close()


__all__ = ["FORMATS", "animate", "checked_name", "frames"]
