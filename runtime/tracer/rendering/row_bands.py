"""Render tasks for other processes: a scene's constants as bytes, and the bands of rows that a worker renders."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from numpy.typing import NDArray

from ...codegen.programs.tracer.scene_needs import SceneNeeds
from ...common import parallel
from ...common.executors import Task
from .aov_layers import LAYERS
from .driver import BoundScene
from .engines import Engine
from .program import engine_of

Array = NDArray[Any]
#: Smallest number of rays that is worth a call of an executor: some ten milliseconds.
RAYS_PER_BAND = 1 << 14
#: Smallest limit for the number of bands of a picture, however large the payload of each is.
MIN_BANDS = 16
#: Largest number of bands of a picture.
MAX_BANDS = 512
#: Largest total payload of all bands in bytes, unless `MIN_BANDS` bands carry more.
MAX_BYTES = 1 << 28


@dataclass(frozen=True, eq=False)
class RenderTask(Task):
    """Serializable render task: the constants of a scene, the key of its program, and the requested layers.

    Attributes
    ----------
    needs : SceneNeeds
        Key of the program, which each worker compiles or loads from its own cache.
    arguments : mapping
        Arguments of `BoundScene` besides the engine.
    layers : tuple of str
    target : {"c", "numba", "cuda"}
        What runs the loops.
    """

    needs: SceneNeeds
    arguments: Mapping[str, Any]
    layers: tuple[str, ...]
    target: str = "c"

    def engine(self) -> Engine:
        """The program of this process."""
        return engine_of(self.needs, self.target)

    def prepare(self) -> tuple[BoundScene, tuple[str, ...]]:
        """Bind the scene to a program of this process; also return its layers."""
        return BoundScene(self.engine(), **self.arguments), self.layers

    def source(self) -> str:
        """Text of the program; empty for the general one, which machines without a compiler use."""
        engine = self.engine()
        return engine.program.source if engine.needs == self.needs else ""


def bands(width: int, height: int, grid: int, payload: int) -> list[tuple[int, int]]:
    """Split the rows into ranges [begin, end): long enough to be worth a call, few if the payload is large."""
    most = max(MIN_BANDS, min(MAX_BANDS, MAX_BYTES // max(payload, 1)))
    count = max(1, min(height, most, width * height * grid * grid // RAYS_PER_BAND))
    edges = [height * i // count for i in range(count + 1)]
    return list(zip(edges[:-1], edges[1:], strict=True))


def render_band(
    state: tuple[BoundScene, tuple[str, ...]], size: tuple[int, int], rows: tuple[int, int], threads: int
) -> dict[str, Array]:
    """Render some rows of a picture, all requested layers: the function that a worker calls."""
    bound, layers = state
    (width, height), (begin, end) = size, rows
    arrays = {name: LAYERS[name].empty(end - begin, width, bound.dtype) for name in layers}
    paint, first = bound.painter(width, height, arrays, begin * width), begin * width
    parallel.run(lambda a, b: paint(first + a, first + b), (end - begin) * width, threads)
    return arrays
