"""Scenes: a camera, lights and surfaces, compiled to one driver that holds what they need, and no more."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import replace
from functools import cached_property, partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..codegen.programs import Program
from ..codegen.programs.scene import SceneNeeds, needs
from ..errors import SceneError
from . import values
from .bands import Sent, sent_by
from .camera import Camera
from .driver import BoundScene
from .engine import Engine, engine_for
from .fixed import Fixed
from .hits import Hits, first_hits
from .layers import checked_names
from .light import Light
from .options import MAX_REFLECTIONS, View, checked_settings, picture_size, picture_view, rays_view
from .pictures import Canvas, on_executor, on_threads, told
from .rows import SceneRows, gathered, row_count
from .single import rounded, rounded_hits, serves_kinds, serves_rays, serves_surfaces
from .surfaces import Surface, names_at, ray_arrays

Array = NDArray[Any]
#: Reflections that are followed where nothing else is said.
REFLECTIONS = 4
#: Linear colors of the sky: pale at the horizon, blue above.
HORIZON, ZENITH = (0.75, 0.82, 0.9), (0.2, 0.35, 0.65)
#: Ways of asking that a scene keeps bound.
KEPT = 4


class Scene(Fixed):
    """What is seen, and from where. Not changed once it is made: another picture is another scene.

    Parameters
    ----------
    camera : Camera
    lights : sequence of Light
    surfaces : sequence of Surface
    horizon, zenith : (3,) arrays
        Linear colors of the sky, at and below the horizon and straight up (e3).
    reflections : int
        Reflections that are followed along one ray, 1000 at most.
    settings : mapping, optional
        Defaults of `render`: width, height, antialias.
    """

    _instead = "Make a new Scene of the same surfaces; nothing is compiled again"

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
        self.lights = values.members(lights, "lights", Light)
        self.surfaces = values.members(surfaces, "surfaces", Surface)
        self.sky = np.array([*values.color(horizon, "horizon"), *values.color(zenith, "zenith")])
        self.reflections = values.whole(reflections, "reflections", 0, MAX_REFLECTIONS)
        self.settings = checked_settings(settings)
        self._bound: dict[Any, BoundScene] = {}
        self._rows: SceneRows | None = None
        self._made = True

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
            rows=row_count(self.surfaces),
        )

    @property
    def program(self) -> Program:
        """The compiled program: ``.source`` is its text."""
        return engine_for(self.needs).program

    @property
    def kernels(self) -> tuple[str, ...]:
        """Names of the compiled kernels."""
        return self.program.kernels

    def _sent(self, how: View) -> Sent:
        """The scene as numbers, for a driver of this process or of another."""
        return sent_by(self, how, self._rows_from)

    def _ready(self, how: View) -> BoundScene:
        """The driver's scene, kept as long as it is asked for in the same few ways."""
        found = self._bound.get(how)
        if found is None:
            sent = self._sent(how)
            found = BoundScene(engine_for(sent.needs), **sent.arguments)
            for oldest in list(self._bound)[: 1 - KEPT]:
                self._bound.pop(oldest, None)
            self._bound[how] = found
        return found

    def _rows_from(self, engine: Engine) -> SceneRows:
        """Rows of constants, made once: every program that has the kinds makes the same."""
        if self._rows is None:
            self._rows = gathered(engine, self.surfaces)
        return self._rows

    def names(self, places: Any = None) -> NDArray[np.str_]:
        """What surfaces are called, by their places: ``scene.names(hits.surface)``.

        Parameters
        ----------
        places : (...) array of int, optional
            Places in `surfaces`; -1 for none. Default: all of them in order.

        Returns
        -------
        (...) array of str
            A surface's name; its kind and place, as in ``sphere [2]``, where it has none; empty for -1.

        Raises
        ------
        SceneError
            For what are no places of surfaces.
        """
        return names_at(self.surfaces, places)

    # -- what it is for ---------------------------------------------------------------------------------

    def intersect(
        self, origins: Any, directions: Any, method: str = "isolate", samples: int = 64, threads: int | None = None
    ) -> Hits:
        """First hits of rays.

        Parameters
        ----------
        origins, directions : (..., 3) arrays
            They broadcast. Directions may have any length. If both are float32, so is the answer; the computation is
            too where that keeps the digits of surfaces and origins: not with evolved surfaces, with others from sizes
            of 1e-9 on and up to places of 1e12.
        method, samples
            As for `Surface.intersect`.
        threads : int, optional

        Returns
        -------
        Hits
        """
        start, direction = ray_arrays(origins, directions)
        how = rays_view(method, samples, start.dtype)
        if start.dtype == np.float64 or (self._served(how) and serves_rays(start)):
            return first_hits(self._ready(how), start, direction, threads)
        wide = self._ready(replace(how, dtype=np.dtype(np.float64)))
        return rounded_hits(first_hits(wide, start.astype(np.float64), direction, threads))

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
        executor: Executor | None = None,
    ) -> Array:
        """The picture in linear light.

        Parameters
        ----------
        width, height : int, optional
            Pixels; default: the scene file's, else 640 by 480.
        threads : int, optional
            Default: all processors; with an executor, of each of its calls, where the default is 1.
        progress : bool or callable
            True: a bar with the remaining time on standard error. A callable gets (pixels done, pixels in all).
        method, samples
            As for `Surface.intersect`.
        antialias : int, optional
            Rays along each side of a pixel.
        dtype : dtype
            float64 or float32; with surfaces, or a camera, that float32 does not serve (evolved surfaces among them)
            the work is done in float64.
        executor : concurrent.futures.Executor, optional
            Bands of rows are its calls: a pool of processes, or a cluster's, as from
            ``dask.distributed.Client(...).get_executor()``. Workers need this package; each compiles the scene's
            program once, into its own cache. The picture is the same to the bit.

        Returns
        -------
        (height, width, 3) array
            Row 0 is the top.

        Raises
        ------
        SceneError
            If an option is wrong, or the picture is larger than the memory there is.
        RenderInterrupted
            On an interrupt; a KeyboardInterrupt whose ``partial`` holds what is done.
        RenderError
            If a worker of the executor fails or ends; with ``partial`` too.
        """
        how = picture_view(self.settings, width, height, ("color",), method, samples, antialias, dtype)
        return self._painted(how, threads, progress, executor)["color"]

    def layers(
        self,
        width: int | None = None,
        height: int | None = None,
        names: Sequence[str] = ("color",),
        threads: int | None = None,
        progress: bool | Callable[[int, int], None] = False,
        *,
        method: str = "isolate",
        samples: int = 64,
        antialias: int | None = None,
        dtype: Any = np.float64,
        executor: Executor | None = None,
    ) -> dict[str, Array]:
        """Several numbers for each pixel, in one pass.

        All but the color are those of the one ray through the middle of the pixel, whatever ``antialias``.

        Parameters
        ----------
        names : sequence of str
            Of these:

            - ``color``: linear light, (h, w, 3), as from `render`;
            - ``normal``: unit normal in the world, on the side that is seen, (h, w, 3); NaN where nothing is;
            - ``depth``: distance from the camera, (h, w); infinite where nothing is;
            - ``alpha``: parameter of the curve of an evolved surface, (h, w); NaN elsewhere;
            - ``cost``: how many surfaces and boxes the ray was compared with, (h, w), int32.
        width, height, threads, progress, method, samples, antialias, dtype, executor
            As for `render`, and so are the errors.

        Returns
        -------
        dict of arrays
            By name, as `save_layers` takes them.
        """
        how = picture_view(self.settings, width, height, checked_names(names), method, samples, antialias, dtype)
        return self._painted(how, threads, progress, executor)

    def size(self, width: int | None = None, height: int | None = None) -> tuple[int, int]:
        """Width and height of the picture: what is given, else the scene file's, else 640 by 480."""
        return picture_size(self.settings, width, height)

    def _served(self, how: View) -> bool:
        """Whether single precision serves the surfaces."""
        if not serves_kinds(self.needs.kinds):
            return False
        return serves_surfaces(self._sent(how).arguments["rows"] if self._rows is None else self._rows)

    def _painted(
        self,
        how: View,
        threads: int | None,
        progress: bool | Callable[[int, int], None],
        executor: Executor | None,
    ) -> dict[str, Array]:
        if how.dtype == np.float32 and not (self._served(how) and serves_rays(self.camera.position)):
            wide = replace(how, dtype=np.dtype(np.float64))
            return rounded(self._painted(wide, threads, progress, executor))
        canvas = Canvas.blank(how.width, how.height, how.layers, how.dtype)
        if executor is None:
            paint = partial(on_threads, self._ready(how), canvas, how.grid, threads)
        else:
            paint = partial(on_executor, self._sent(how), canvas, how.grid, executor, threads)
        with told(progress, how.width * how.height) as tell:
            return paint(tell)
