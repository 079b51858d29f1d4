"""Render jobs: chunks of pixels over threads, or bands of rows over an executor."""

from __future__ import annotations

from concurrent.futures import Executor
from typing import Any

from numpy.typing import NDArray

from ...codegen.interrupts import keep_partial
from ...common import parallel
from ...common.executors import Payload, fill_rows
from ...common.progress import Report
from .canvas import Canvas, RenderError, RenderInterrupted
from .driver import BoundScene
from .row_bands import RenderTask, bands, render_band

Array = NDArray[Any]
#: Least pixels of a chunk: several at once are at most half of it.
MIN_PIXELS = 16


def on_threads(bound: BoundScene, canvas: Canvas, grid: int, threads: int | None, report: Report) -> dict[str, Array]:
    """Paint the picture on threads of this process, chunk after chunk in reading order."""
    loop, done = bound.painter(canvas.width, canvas.height, canvas.arrays), canvas.done.reshape(-1)

    def part(begin: int, end: int) -> None:
        loop(begin, end)
        done[begin:end] = True

    with keep_partial(canvas.partial, RenderInterrupted):
        chunk = max(MIN_PIXELS, bound.engine.chunk // (grid * grid))
        parallel.run(part, canvas.width * canvas.height, threads, chunk, report)
    return canvas.arrays


def on_executor(
    task: RenderTask, canvas: Canvas, grid: int, executor: Executor, threads: int | None, report: Report
) -> dict[str, Array]:
    """Paint the picture in bands of rows, each a call of the executor.

    Raises
    ------
    RenderError
        If a worker fails or ends.
    InputError
        If the executor takes no work.
    """
    payload, size = Payload.of(task), (canvas.width, canvas.height)
    threads = parallel.thread_count(1 if threads is None else threads)
    pieces = {rows: (size, rows, threads) for rows in bands(*size, grid, len(payload.data))}

    def done(begin: int, end: int, count: int) -> None:
        canvas.done[begin:end] = True
        report(count * canvas.width)

    with keep_partial(canvas.partial, RenderInterrupted, RenderError):
        fill_rows(executor, payload, render_band, pieces, "rows", canvas.arrays, done)
    return canvas.arrays
