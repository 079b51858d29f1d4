"""Pictures in pieces: tiles over threads, bands of rows over an executor, and what is left of interrupted ones."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from concurrent.futures import FIRST_COMPLETED, Executor, Future, wait
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any
from uuid import uuid4

import numpy as np
from numpy.typing import NDArray

from .. import parallel
from ..errors import BladesmithError, InputError, SceneError
from . import memory, values
from .bands import Sent, bands, render_band
from .driver import RAYS_PER_CHUNK, BoundScene
from .layers import LAYERS

Array = NDArray[Any]
Progress = Callable[[int], None]
#: Bytes beside a layer's own: of each pixel, that it is done; of each channel, its number in a file that is written.
PER_PIXEL, PER_CHANNEL = 1, 4


@dataclass(frozen=True, eq=False)
class PartialPicture:
    """What there is of a picture that was not finished.

    Attributes
    ----------
    layers : dict
        Arrays as from `Scene.layers`; NaN, or -1 in ``cost``, where nothing was rendered.
    done : (height, width) array of bool
        Pixels that were rendered.
    """

    layers: dict[str, Array]
    done: NDArray[np.bool_]

    @property
    def image(self) -> Array:
        """The color, (height, width, 3)."""
        return self.layers["color"]

    @property
    def share(self) -> float:
        """Share of the pixels that were rendered."""
        return float(self.done.mean())


class RenderInterrupted(KeyboardInterrupt):
    """An interrupt during a render; what was done until then is in ``partial``, a `PartialPicture`."""

    def __init__(self, partial: PartialPicture) -> None:
        super().__init__(f"interrupted with {partial.share:.0%} of the picture done")
        self.partial = partial


class RenderError(BladesmithError):
    """A worker of an executor failed or ended; what the others did is in ``partial``, a `PartialPicture`."""

    def __init__(self, what: str, *, partial: PartialPicture, remedy: str | None = None) -> None:
        super().__init__(what, remedy=remedy)
        self.partial = partial


@dataclass(frozen=True, eq=False)
class Canvas:
    """The arrays of a picture that is being made, and which of its pixels are done."""

    width: int
    height: int
    arrays: dict[str, Array]
    done: NDArray[np.bool_] = field(repr=False)

    @classmethod
    def blank(cls, width: int, height: int, names: tuple[str, ...], dtype: Any) -> Canvas:
        """Room for the layers.

        Raises
        ------
        SceneError
            If there is not enough memory: before anything is allocated.
        """
        check_memory(width, height, names, dtype)
        try:
            arrays = {name: LAYERS[name].empty(height, width, dtype) for name in names}
            return cls(width, height, arrays, np.zeros((height, width), bool))
        except MemoryError:
            raise SceneError(_too_large(width, height, names, dtype)) from None

    def partial(self) -> PartialPicture:
        """What is done; the rest is marked."""
        for name, array in self.arrays.items():
            array[~self.done] = LAYERS[name].missing
        return PartialPicture(self.arrays, self.done)


def check_memory(width: int, height: int, names: tuple[str, ...], dtype: Any) -> None:
    """Refuse a picture that is larger than the memory there is."""
    free = memory.available()
    if free is not None and _bytes(width, height, names, dtype) > free:
        raise SceneError(f"{_too_large(width, height, names, dtype)}; {memory.readable(free)} are free.")


def _bytes(width: int, height: int, names: tuple[str, ...], dtype: Any) -> int:
    wanted = [LAYERS[name] for name in names]
    each = sum(layer.bytes_per_pixel(dtype) + PER_CHANNEL * len(layer.channels) for layer in wanted)
    return width * height * (PER_PIXEL + each)


def _too_large(width: int, height: int, names: tuple[str, ...], dtype: Any) -> str:
    needed = memory.readable(_bytes(width, height, names, dtype))
    return f"a picture of {width} x {height} pixels takes {needed} of memory"


@contextmanager
def _reachable(canvas: Canvas) -> Iterator[None]:
    """An interrupt hands on what is done."""
    try:
        yield
    except KeyboardInterrupt:
        raise RenderInterrupted(canvas.partial()) from None


def on_threads(
    bound: BoundScene, canvas: Canvas, grid: int, threads: int | None, progress: Progress | None
) -> dict[str, Array]:
    """Paint the picture on threads of this process, which take chunk after chunk in reading order."""
    loop, done = bound.painter(canvas.width, canvas.height, canvas.arrays), canvas.done.reshape(-1)

    def part(begin: int, end: int) -> None:
        loop(begin, end)
        done[begin:end] = True

    with _reachable(canvas):
        chunk = max(1, RAYS_PER_CHUNK // (grid * grid))
        parallel.run(part, canvas.width * canvas.height, threads, chunk, progress)
    return canvas.arrays


def on_executor(
    sent: Sent, canvas: Canvas, grid: int, executor: Executor, threads: int | None, progress: Progress | None
) -> dict[str, Array]:
    """Paint the picture in bands of rows, each a call of the executor.

    Raises
    ------
    RenderError
        If a worker fails or ends.
    InputError
        If the executor takes no work.
    """
    payload, picture = sent.packed(), uuid4().hex
    threads = parallel.thread_count(1 if threads is None else threads)
    pending: dict[Future[dict[str, Array]], tuple[int, int]] = {}
    with _reachable(canvas):
        try:
            for rows in bands(canvas.width, canvas.height, grid, len(payload)):
                pending[_submitted(executor, payload, (canvas.width, canvas.height), rows, threads, picture)] = rows
            while pending:
                done, _ = wait(pending, timeout=parallel.POLL, return_when=FIRST_COMPLETED)
                for future in done:
                    rows = pending.pop(future)
                    _take(canvas, rows, future)
                    if progress:
                        progress((rows[1] - rows[0]) * canvas.width)
        finally:
            for future in pending:
                future.cancel()
    return canvas.arrays


@contextmanager
def told(wanted: bool | Callable[[int, int], None], total: int) -> Iterator[Progress | None]:
    """What is told of newly done pixels: a bar, a user's function of (done, total), or nothing."""
    if not isinstance(wanted, bool | np.bool_ | None) and not callable(wanted):
        raise InputError(
            f"progress is {values.shown(wanted)}; it is True, False or a function of (pixels done, pixels in all)."
        )
    if wanted is not None and not callable(wanted) and wanted:
        from tqdm import tqdm

        with tqdm(total=total, unit="px", unit_scale=True, desc="render") as bar:
            yield lambda done: bar.update(done) and None
    elif callable(wanted):
        user, count = wanted, 0

        def tell(done: int) -> None:
            nonlocal count
            count += done
            user(count, total)

        yield tell
    else:
        yield None


def _submitted(executor: Executor, *arguments: Any) -> Future[dict[str, Array]]:
    remedy = "Give an open concurrent.futures.Executor."
    if isinstance(executor, type) or not callable(getattr(executor, "submit", None)):
        raise InputError(f"the executor takes no work: it is {values.shown(executor)}.", remedy=remedy)
    try:
        found = executor.submit(render_band, *arguments)
    except Exception as error:  # shut down, broken, or no executor at all
        raise InputError(f"the executor takes no work: {error}.", remedy=remedy) from None
    if not isinstance(found, Future):
        raise InputError(f"the executor takes no work: submit gives {values.shown(found)}.", remedy=remedy)
    return found


def _take(canvas: Canvas, rows: tuple[int, int], future: Future[dict[str, Array]]) -> None:
    """Copy a finished band into the picture."""
    begin, end = rows
    try:
        found = future.result()
    except BladesmithError:
        raise
    except Exception as error:  # whatever executors raise for workers that die
        raise RenderError(
            f"rows {begin} to {end - 1} were not rendered: {type(error).__name__}{f': {error}' if str(error) else ''}",
            partial=canvas.partial(),
            remedy="See the worker's own output; `error.partial` holds the rows that are done",
        ) from error
    for name, array in found.items():
        canvas.arrays[name][begin:end] = array
    canvas.done[begin:end] = True


__all__ = [
    "Canvas",
    "PartialPicture",
    "RenderError",
    "RenderInterrupted",
    "check_memory",
    "on_executor",
    "on_threads",
    "told",
]
