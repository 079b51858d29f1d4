"""Bands of a picture's rows as pieces of work for other processes: what is sent, and what a worker does with it."""

from __future__ import annotations

import pickle
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from hashlib import sha256
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..codegen.programs.scene import SceneNeeds, with_method
from ..codegen.version import __version__
from ..errors import BladesmithError
from .driver import LIGHT_SIZE, BoundScene
from .engine import Engine, engine_for
from .layers import LAYERS
from .rows import SceneRows

if TYPE_CHECKING:
    from .options import View
    from .scene import Scene

Array = NDArray[Any]
#: Rays that are worth a call of an executor: some ten milliseconds.
RAYS_PER_BAND = 1 << 14
#: Pieces of one picture, and bytes that all of them together carry, as far as the fewest pieces allow it.
FEWEST, MOST, BYTES_IN_ALL = 16, 512, 1 << 28
#: Scenes that a worker keeps bound.
KEPT = 2


@dataclass(frozen=True, eq=False)
class Sent:
    """A scene as numbers, without its compiled program, and what of it is wanted.

    Attributes
    ----------
    needs : SceneNeeds
        The program, which each worker compiles or finds in its own cache.
    arguments : mapping
        Of `BoundScene`, besides the engine.
    layers : tuple of str
    """

    needs: SceneNeeds
    arguments: Mapping[str, Any]
    layers: tuple[str, ...]

    def packed(self) -> bytes:
        """The same as bytes, which are cheap to send many times."""
        return pickle.dumps((__version__, _digest(engine_for(self.needs), self.needs), pickle.dumps(self)))


def sent_by(scene: Scene, how: View, rows_from: Callable[[Engine], SceneRows]) -> Sent:
    """A scene as numbers, for one way of asking; ``rows_from`` makes or knows its rows of constants."""
    wanted = with_method(scene.needs, how.method)
    wanted = replace(wanted, single=how.dtype == np.float32, layers=any(name != "color" for name in how.layers))
    rows = rows_from(engine_for(wanted))
    if wanted.tree:
        rows.tree(engine_for(wanted))  # built once, here
    arguments = {
        "rows": rows,
        "dtype": how.dtype,
        "materials": np.array([s.material.row(s.flat_normal) for s in scene.surfaces]),
        "lights": np.array([[*light.position, *light.color] for light in scene.lights]).reshape(-1, LIGHT_SIZE),
        "camera": scene.camera.constants(how.width, how.height) if how.width else None,
        "sky": scene.sky,
        "depth": scene.reflections,
        "grid": how.grid,
        "method": how.method,
        "samples": how.samples,
    }
    return Sent(wanted, arguments, how.layers)


def bands(width: int, height: int, grid: int, payload: int) -> list[tuple[int, int]]:
    """Ranges of rows [begin, end): long enough to be worth a call, few if each carries much."""
    most = max(FEWEST, min(MOST, BYTES_IN_ALL // max(payload, 1)))
    count = max(1, min(height, most, width * height * grid * grid // RAYS_PER_BAND))
    edges = [height * i // count for i in range(count + 1)]
    return list(zip(edges[:-1], edges[1:], strict=True))


def render_band(
    payload: bytes, size: tuple[int, int], rows: tuple[int, int], threads: int, _picture: str = ""
) -> dict[str, Array]:
    """What a worker is called for: some rows of a picture, all layers that are wanted.

    Clusters take calls with equal arguments for one: the name of the picture keeps those of two renders apart, so that
    neither is cancelled, or fails, with the other.
    """
    from .. import parallel

    bound, layers = _unpacked(payload)
    (width, height), (begin, end) = size, rows
    arrays = {name: LAYERS[name].empty(end - begin, width, bound.dtype) for name in layers}
    paint, first = bound.painter(width, height, arrays, begin * width), begin * width
    parallel.run(lambda a, b: paint(first + a, first + b), (end - begin) * width, threads)
    return arrays


@lru_cache(KEPT)
def _unpacked(payload: bytes) -> tuple[BoundScene, tuple[str, ...]]:
    """The scene bound to a program of this process."""
    version, digest, content = pickle.loads(payload)
    if version != __version__:
        raise BladesmithError(f"a worker has bladesmith {__version__}, the scene comes from {version}")
    sent: Sent = pickle.loads(content)
    engine = engine_for(sent.needs)
    own = _digest(engine, sent.needs)
    if digest and own and digest != own:
        raise BladesmithError(f"a worker has another bladesmith {version} than the one that the scene comes from")
    return BoundScene(engine, **sent.arguments), sent.layers


def _digest(engine: Engine, wanted: SceneNeeds) -> str:
    """What tells programs apart; empty for the general one, which machines without a compiler use."""
    return sha256(engine.program.source.encode()).hexdigest() if engine.needs == wanted else ""
