"""Scenes: a camera, lights and surfaces, rendered by a driver compiled for exactly their needs."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import replace
from functools import cached_property, partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.programs import Program
from ...codegen.programs.tracer.records import LIGHT
from ...codegen.programs.tracer.scene import needs, with_method
from ...codegen.programs.tracer.scene_needs import SceneNeeds
from ...common.deprecation import renamed_keywords
from ...common.progress import ProgressOption, open_progress
from ...common.validation import as_instance
from ...errors import SceneError
from ..rendering.aov_layers import check_layer_names
from ..rendering.canvas import Canvas
from ..rendering.driver import BoundScene
from ..rendering.engines import Engine
from ..rendering.hits import Hits, first_hits
from ..rendering.precision import (
    hits_to_single,
    single_suffices_for_kinds,
    single_suffices_for_rays,
    single_suffices_for_surfaces,
    to_single,
)
from ..rendering.program import engine_for, engine_of
from ..rendering.render_jobs import on_executor, on_threads
from ..rendering.row_bands import RenderTask
from ..rendering.surface_tables import SurfaceTables, build_surface_tables, row_count
from ..surfaces import Surface, names_at, ray_arrays
from . import values
from .camera import Camera
from .defaults import HORIZON, MAX_REFLECTIONS, REFLECTIONS, ZENITH
from .immutable import Immutable
from .light import Light
from .render_options import RenderOptions, check_settings, picture_options, picture_size, ray_options

Array = NDArray[Any]
#: Largest number of combinations of options that a scene keeps bound to a driver.
MAX_BOUND = 4


class Scene(Immutable):
    """A camera, lights and surfaces. Immutable: another picture needs another scene.

    Parameters
    ----------
    camera : Camera
    lights : sequence of Light
    surfaces : sequence of Surface
    horizon, zenith : (3,) arrays
        Linear colors of the sky, at and below the horizon and straight up (e3).
    reflections : int
        Largest number of reflections along one ray, up to 1000.
    settings : mapping, optional
        Defaults of `render`: width, height, antialias.
    """

    _replacement_hint = "Make a new Scene of the same surfaces; nothing is compiled again"

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
        self.camera = as_instance(camera, "camera", Camera, error=SceneError)
        self.lights = values.members(lights, "lights", Light)
        self.surfaces = values.members(surfaces, "surfaces", Surface)
        self.sky = np.array([*values.color(horizon, "horizon"), *values.color(zenith, "zenith")])
        self.reflections = values.whole(reflections, "reflections", 0, MAX_REFLECTIONS)
        self.settings = check_settings(settings)
        self._bound: dict[Any, BoundScene] = {}
        self._rows: SurfaceTables | None = None
        self._frozen = True

    def __repr__(self) -> str:
        return f"<Scene: {len(self.surfaces)} surfaces, {len(self.lights)} lights, {self.camera!r}>"

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Scene:
        """Read a scene file (:doc:`/geometry/scenes`).

        Raises
        ------
        SceneError
            With file, line and key.
        """
        from ..io.reader import load_scene

        return load_scene(path, cls)

    def __getstate__(self) -> dict[str, Any]:
        """State without objects bound to compiled code, so that scenes can be pickled and copied."""
        return {**self.__dict__, "_bound": {}, "_rows": None}

    # -- the compiled program ---------------------------------------------------------------------------

    @cached_property
    def needs(self) -> SceneNeeds:
        """Kinds of surfaces and effects of this scene: the key of its program."""
        return needs(
            [surface.program_kind for surface in self.surfaces],
            reflection=self.reflections > 0 and any(s.material.reflectivity > 0 for s in self.surfaces),
            checker=any(s.material.checker is not None for s in self.surfaces),
            rows=row_count(self.surfaces),
        )

    @property
    def program(self) -> Program:
        """Compiled program; ``.source`` is its text."""
        return engine_for(self.needs).program

    @property
    def kernels(self) -> tuple[str, ...]:
        """Names of the compiled kernels."""
        return self.program.kernels

    def _needs_of(self, options: RenderOptions) -> SceneNeeds:
        """Key of the program for these options."""
        needed = with_method(self.needs, options.method)
        layers = any(name != "color" for name in options.layers)
        return replace(needed, single=options.dtype == np.float32, layers=layers)

    def _task(self, options: RenderOptions) -> RenderTask:
        """The scene's constants for a driver of this process or of another."""
        needed = self._needs_of(options)
        engine = engine_of(needed, options.target)
        rows = self._rows_from(engine)
        if needed.tree:
            rows.tree(engine)  # built once, here
        arguments = {
            "rows": rows,
            "dtype": options.dtype,
            "materials": np.array([s.material.row(s.flat_normal) for s in self.surfaces]),
            "lights": np.array([[*light.position, *light.color] for light in self.lights]).reshape(-1, LIGHT.size),
            "camera": self.camera.constants(options.width, options.height) if options.width else None,
            "sky": self.sky,
            "depth": self.reflections,
            "grid": options.grid,
            "method": options.method,
            "samples": options.samples,
        }
        return RenderTask(needed, arguments, options.layers, options.target)

    def _bound_scene(self, options: RenderOptions) -> BoundScene:
        """Scene bound to a driver, cached for the last few combinations of options."""
        bound = self._bound.get(options)
        if bound is None:
            task = self._task(options)
            bound = BoundScene(task.engine(), **task.arguments)
            for oldest in list(self._bound)[: 1 - MAX_BOUND]:
                self._bound.pop(oldest, None)
            self._bound[options] = bound
        return bound

    def _rows_from(self, engine: Engine) -> SurfaceTables:
        """Tables of constants, built once: every program that has the kinds gives the same."""
        if self._rows is None:
            self._rows = build_surface_tables(engine, self.surfaces)
        return self._rows

    @renamed_keywords(places="indices")
    def names(self, indices: Any = None) -> NDArray[np.str_]:
        """Names of surfaces by their indices: ``scene.names(hits.surface)``.

        Parameters
        ----------
        indices : (...) array of int, optional
            Indices into `surfaces`; -1 for none. Default: all of them in order.

        Returns
        -------
        (...) array of str
            The surface's name; without one its kind and index, as in ``sphere [2]``; empty for -1.

        Raises
        ------
        SceneError
            For values that are not indices of surfaces.
        """
        return names_at(self.surfaces, indices)

    # -- intersections and pictures ---------------------------------------------------------------------

    def intersect(
        self,
        origins: Any,
        directions: Any,
        method: str = "isolate",
        samples: int = 64,
        threads: int | None = None,
        *,
        target: str = "c",
    ) -> Hits:
        """First hits of rays.

        Parameters
        ----------
        origins, directions : (..., 3) arrays
            They broadcast. Directions may have any length. If both are float32, so is the result; the computation is
            too where that keeps the digits of surfaces and origins: not with evolved surfaces; with others for sizes
            from 1e-9 and coordinates up to 1e12.
        method, samples
            As for `Surface.intersect`.
        threads : int, optional
            Default: the package's (`bladesmith.set_threads`).
        target : {"c", "numba", "cuda"}
            As for `render`.

        Returns
        -------
        Hits
        """
        start, direction = ray_arrays(origins, directions)
        options = ray_options(method, samples, start.dtype, target)
        if start.dtype == np.float64 or (self._single_suffices(options) and single_suffices_for_rays(start)):
            return first_hits(self._bound_scene(options), start, direction, threads)
        wide = self._bound_scene(replace(options, dtype=np.dtype(np.float64)))
        return hits_to_single(first_hits(wide, start.astype(np.float64), direction, threads))

    def render(
        self,
        width: int | None = None,
        height: int | None = None,
        threads: int | None = None,
        progress: ProgressOption = False,
        *,
        method: str = "isolate",
        samples: int = 64,
        antialias: int | None = None,
        dtype: Any = np.float64,
        executor: Executor | None = None,
        target: str = "c",
    ) -> Array:
        """Render the picture in linear light.

        Parameters
        ----------
        width, height : int, optional
            Pixels; default: the scene file's, else 640 by 480.
        threads : int, optional
            Default: the package's (`bladesmith.set_threads`); with an executor those of each call, one by default.
        progress : bool or callable
            True: a bar with the remaining time on standard error. A callable gets a `bladesmith.Progress` of pixels.
        method, samples
            As for `Surface.intersect`.
        antialias : int, optional
            Rays along each side of a pixel.
        dtype : dtype
            float64 or float32; the work is done in float64 if float32 does not suffice for the surfaces (evolved
            surfaces among them) or the camera.
        executor : concurrent.futures.Executor, optional
            Renders bands of rows, one in each call: a pool of processes, or a cluster's, as from
            ``dask.distributed.Client(...).get_executor()``. Workers need this package; each compiles the scene's
            program once, into its own cache. The picture is the same to the bit.
        target : {"c", "numba", "cuda"}
            What runs the loops: "cuda" a graphics processor. The picture has the same bits in float64; numba computes
            in float64 alone. Where there is neither a C compiler nor a program from the install, "c" is numba, too.

        Returns
        -------
        (height, width, 3) array
            Row 0 is the top.

        Raises
        ------
        SceneError
            If an option is not valid, or the picture is larger than the available memory.
        RenderInterrupted
            On an interrupt; an `errors.Interrupted` whose ``partial`` holds the finished part.
        RenderError
            If a worker of the executor fails or ends; with ``partial`` too.
        """
        options = picture_options(self.settings, width, height, ("color",), method, samples, antialias, dtype, target)
        return self._paint(options, threads, progress, executor)["color"]

    def layers(
        self,
        width: int | None = None,
        height: int | None = None,
        names: Sequence[str] = ("color",),
        threads: int | None = None,
        progress: ProgressOption = False,
        *,
        method: str = "isolate",
        samples: int = 64,
        antialias: int | None = None,
        dtype: Any = np.float64,
        executor: Executor | None = None,
        target: str = "c",
    ) -> dict[str, Array]:
        """Render several layers in one pass.

        All but the color belong to the one ray through the center of the pixel, whatever ``antialias``.

        Parameters
        ----------
        names : sequence of str
            Some of these:

            - ``color``: linear light, (h, w, 3), as from `render`;
            - ``normal``: unit normal in the world, on the visible side, (h, w, 3); NaN where no surface is hit;
            - ``depth``: distance from the camera, (h, w); infinite where no surface is hit;
            - ``alpha``: parameter of the curve of an evolved surface, (h, w); NaN elsewhere;
            - ``cost``: number of intersection tests of the ray with surfaces and boxes, (h, w), int32.
        width, height, threads, progress, method, samples, antialias, dtype, executor, target
            As for `render`, and so are the errors. With a tree over many surfaces ``cost`` depends on the target.

        Returns
        -------
        dict of arrays
            By name, as `save_layers` takes them.
        """
        options = picture_options(
            self.settings, width, height, check_layer_names(names), method, samples, antialias, dtype, target
        )
        return self._paint(options, threads, progress, executor)

    def size(self, width: int | None = None, height: int | None = None) -> tuple[int, int]:
        """Width and height of the picture: the arguments, else those of the scene file, else 640 by 480."""
        return picture_size(self.settings, width, height)

    def _single_suffices(self, options: RenderOptions) -> bool:
        """Test whether the program has single precision, and it suffices for the surfaces."""
        if not single_suffices_for_kinds(self.needs.kinds) or options.target == "numba":
            return False
        rows = self._task(options).arguments["rows"] if self._rows is None else self._rows
        return single_suffices_for_surfaces(rows) and engine_for(self._needs_of(options)).is_c

    def _paint(
        self,
        options: RenderOptions,
        threads: int | None,
        progress: ProgressOption,
        executor: Executor | None,
    ) -> dict[str, Array]:
        if options.dtype == np.float32 and not (
            self._single_suffices(options) and single_suffices_for_rays(self.camera.position)
        ):
            wide = replace(options, dtype=np.dtype(np.float64))
            return to_single(self._paint(wide, threads, progress, executor))
        canvas = Canvas.blank(options.width, options.height, options.layers, options.dtype)
        if executor is None:
            paint = partial(on_threads, self._bound_scene(options), canvas, options.grid, threads)
        else:
            paint = partial(on_executor, self._task(options), canvas, options.grid, executor, threads)
        with open_progress(progress, "render", "pixels", options.width * options.height) as report:
            return paint(report)
