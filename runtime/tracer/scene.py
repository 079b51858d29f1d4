"""Scenes: a camera, lights and surfaces, compiled to one driver that holds what they need, and no more."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from ..codegen.programs import Program
from ..codegen.programs.scene import SceneNeeds, needs, with_method
from ..errors import SceneError
from . import values
from .camera import Camera
from .driver import LIGHT_SIZE, BoundScene, Rows
from .engine import Engine, engine_for
from .rows import gathered
from .surfaces import LEAST_SAMPLES, Surface, ray_arrays

Array = NDArray[Any]
T = TypeVar("T")
#: Reflections that are followed where nothing else is said.
REFLECTIONS = 4
WIDTH, HEIGHT = 640, 480
#: Pixels of a side and rays per pixel beyond which a picture is a mistake.
MAX_SIDE, MAX_GRID = 65536, 64
#: Linear colors of the sky: pale at the horizon, blue above.
HORIZON, ZENITH = (0.75, 0.82, 0.9), (0.2, 0.35, 0.65)


class Light:
    """A lamp at a point, of the same brightness at every distance."""

    def __init__(self, position: Any, color: Any = (1.0, 1.0, 1.0)) -> None:
        self.position = values.finite(position, "light.position", 3)
        self.color = values.color(color, "light.color")


@dataclass(frozen=True, eq=False)
class Hits:
    """The first points that rays meet.

    Attributes
    ----------
    hit : (...) array of bool
    t : (...) array
        Distance from the ray's origin; NaN where nothing is hit, like the others.
    point, normal : (..., 3) arrays
        The normal has length 1 and looks to where the ray comes from.
    surface : (...) array of int
        Position in the scene's list of surfaces, -1 for none.
    alpha : (...) array
        Parameter t of the surface's curve, where it has one.
    status : (...) array of `bladesmith.Status`
        `INVALID` for a ray that is not finite or has no direction; `SINGULAR` for one that lies in an evolved
        surface or meets all of its circles, of which no single point can be told.
    """

    hit: Array
    t: Array
    point: Array
    normal: Array
    surface: Array
    alpha: Array
    status: Array


class Scene:
    """What is seen, and from where. Not changed once it is made: another picture is another scene.

    Parameters
    ----------
    camera : Camera
    lights : sequence of Light
    surfaces : sequence of Surface
    horizon, zenith : (3,) arrays
        Linear colors of the sky, at and below the horizon and straight up (e3).
    reflections : int
        Reflections that are followed along one ray.
    settings : mapping, optional
        Defaults of `render`: width, height, antialias.
    """

    def __init__(
        self,
        camera: Camera,
        lights: Sequence[Light] = (),
        surfaces: Sequence[Surface] = (),
        *,
        horizon: Any = HORIZON,
        zenith: Any = ZENITH,
        reflections: int = REFLECTIONS,
        settings: Mapping[str, int] | None = None,
    ) -> None:
        if not isinstance(camera, Camera):
            raise SceneError(f"camera is {type(camera).__name__}, which is no Camera.")
        self.camera = camera
        self.lights = _members(lights, "lights", Light)
        self.surfaces = _members(surfaces, "surfaces", Surface)
        self.sky = np.array([*values.color(horizon, "horizon"), *values.color(zenith, "zenith")])
        self.reflections = values.whole(reflections, "reflections", 0)
        self.settings = dict(settings or {})
        self._bound: dict[Any, BoundScene] = {}
        self._rows: dict[str, Rows] | None = None

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Scene:
        """Read a scene file (docs/scenes.md).

        Raises
        ------
        SceneError
            With file, line and key.
        """
        from .schema import load_scene

        return load_scene(path)

    def __getstate__(self) -> dict[str, Any]:
        """Without what is bound to compiled code, so that scenes can be pickled and copied."""
        return {**self.__dict__, "_bound": {}, "_rows": None}

    # -- what is compiled -------------------------------------------------------------------------------

    @cached_property
    def needs(self) -> SceneNeeds:
        """What this scene is made of: the key of its program."""
        return needs(
            [surface.program_kind for surface in self.surfaces],
            reflection=self.reflections > 0 and any(s.material.reflectivity > 0 for s in self.surfaces),
            checker=any(s.material.checker is not None for s in self.surfaces),
        )

    @property
    def program(self) -> Program:
        """The compiled program: ``.source`` is its text."""
        return self._engine(self.needs).program

    @property
    def kernels(self) -> tuple[str, ...]:
        """Names of the compiled kernels."""
        return self.program.kernels

    def _engine(self, wanted: SceneNeeds) -> Engine:
        return engine_for(wanted)

    def _ready(self, method: str, samples: int, dtype: Any, camera: Array | None = None, grid: int = 1) -> BoundScene:
        """The driver's scene, kept as long as it is asked for in the same way."""
        samples = values.whole(samples, "samples", LEAST_SAMPLES)
        single = _is_single(dtype)
        key = (method, samples, single, grid, None if camera is None else camera.tobytes())
        if key not in self._bound:
            wanted = with_method(self.needs, method)
            if single:
                wanted = replace(wanted, single=True)
            engine = self._engine(wanted)
            self._bound[key] = BoundScene(
                engine,
                self._rows_from(engine),
                dtype,
                materials=np.array([s.material.row(s.flat_normal) for s in self.surfaces]),
                lights=np.array([[*light.position, *light.color] for light in self.lights]).reshape(-1, LIGHT_SIZE),
                camera=camera,
                sky=self.sky,
                depth=self.reflections,
                grid=grid,
                method=method,
                samples=samples,
            )
        return self._bound[key]

    def _rows_from(self, engine: Engine) -> dict[str, Rows]:
        """Rows of constants, made once: every program that has the kinds makes the same."""
        if self._rows is None:
            self._rows = gathered(engine, self.surfaces)
        return self._rows

    # -- what it is for ---------------------------------------------------------------------------------

    def intersect(
        self, origins: Any, directions: Any, method: str = "isolate", samples: int = 64, threads: int | None = None
    ) -> Hits:
        """First hits of rays.

        Parameters
        ----------
        origins, directions : (..., 3) arrays
            They broadcast. Directions may have any length. If both are float32, so is the computation.
        method, samples
            As for `Surface.intersect`.
        threads : int, optional

        Returns
        -------
        Hits
        """
        start, direction = ray_arrays(origins, directions)
        found = self._ready(method, samples, start.dtype).first(start, direction, threads)
        return Hits(hit=found["surface"] >= 0, **found)

    def render(
        self,
        width: int | None = None,
        height: int | None = None,
        threads: int | None = None,
        progress: bool | Callable[[int, int], None] = False,
        *,
        method: str = "isolate",
        samples: int = 64,
        antialias: int | None = None,
        dtype: Any = np.float64,
    ) -> Array:
        """The picture in linear light.

        Parameters
        ----------
        width, height : int, optional
            Pixels; default: the scene file's, else 640 by 480.
        threads : int, optional
            Default: all processors.
        progress : bool or callable
            True: a bar on standard error. A callable gets (pixels done, pixels in all).
        method, samples
            As for `Surface.intersect`.
        antialias : int, optional
            Rays along each side of a pixel.
        dtype : dtype
            float64 or float32.

        Returns
        -------
        (height, width, 3) array
            Row 0 is the top.
        """
        columns = self._setting(width, "width", WIDTH, MAX_SIDE)
        rows = self._setting(height, "height", HEIGHT, MAX_SIDE)
        grid = self._setting(antialias, "antialias", 1, MAX_GRID)
        bound = self._ready(method, samples, dtype, self.camera.constants(columns, rows), grid)
        with ExitStack() as stack:
            return bound.render(columns, rows, threads, _progress(progress, columns * rows, stack))

    def _setting(self, value: int | None, name: str, default: int, most: int) -> int:
        return values.whole(self.settings.get(name, default) if value is None else value, name, 1, most)


def _members(given: Any, name: str, kind: type[T]) -> tuple[T, ...]:
    """The members of a list, each of the class that it must be."""
    try:
        members = tuple(given)
    except TypeError:
        raise SceneError(f"{name} is {type(given).__name__}; a list is needed.") from None
    for i, member in enumerate(members):
        if not isinstance(member, kind):
            raise SceneError(f"{name}[{i}] is {type(member).__name__}, which is no {kind.__name__}.")
    return members


def _is_single(dtype: Any) -> bool:
    try:
        found = np.dtype(dtype)
    except TypeError:
        found = None
    if found is None or found not in (np.float32, np.float64):
        raise SceneError(f"dtype is {dtype!r}; it is float64 or float32.")
    return bool(found == np.float32)


def _progress(wanted: bool | Callable[[int, int], None], total: int, stack: ExitStack) -> Callable[[int], None] | None:
    if wanted is False or wanted is None:
        return None
    if wanted is True:
        from tqdm import tqdm

        bar = stack.enter_context(tqdm(total=total, unit="px", unit_scale=True, desc="render"))
        return lambda done: bar.update(done) and None
    count = 0

    def tell(done: int) -> None:
        nonlocal count
        count += done
        wanted(count, total)

    return tell
