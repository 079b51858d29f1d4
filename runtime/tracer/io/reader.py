"""Reader of scene files; every error has file, line, key and remedy."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Annotated, TypeVar

import numpy as np
from pydantic import Field

from ...codegen.programs.tracer.surface_kinds import surface_kind
from ...codegen.programs.tracer.surfaces.kind import SurfaceKind
from ...common.documents import Document, Table, read_document
from ...common.files import as_path
from ...errors import SceneError
from ..scene.light import Light
from ..surfaces import Surface
from ..surfaces.evolved import EvolvedSurface, suppress_flip_warnings, warn_flipped
from ..sweeps.local_segments import Segments
from ..sweeps.real_intervals import with_real_intervals
from .evolved_tables import EvolvedCirclesTable, EvolvedPointPairsTable, read_beziers
from .tables import (
    CameraTable,
    DiscTable,
    FacetsTable,
    LightTable,
    MeshTable,
    PlaneTable,
    RenderTable,
    SkyTable,
    SphereTable,
)

T = TypeVar("T")
AnySurface = Annotated[
    PlaneTable | SphereTable | DiscTable | FacetsTable | MeshTable | EvolvedCirclesTable | EvolvedPointPairsTable,
    Field(discriminator="kind"),
]


class SceneTable(Table):
    """A scene file."""

    camera: CameraTable
    lights: list[LightTable] = []
    surfaces: list[AnySurface] = []
    sky: SkyTable = SkyTable()
    render: RenderTable = RenderTable()


def load_scene(path: str | os.PathLike[str], make_scene: Callable[..., T]) -> T:
    """Read and check a scene file.

    Parameters
    ----------
    path : path
    make_scene : callable
        `Scene`, or a class derived from it.

    Raises
    ------
    SceneError
        If the file cannot be read, is not TOML, does not fit the schema, or has invalid values; with file, line and
        key.
    """
    file = as_path(path, "a scene is read from", SceneError)
    document = read_document(file, SceneTable, SceneError)
    table, folder = document.contents, file.parent
    camera = document.build(("camera",), table.camera.camera)
    with suppress_flip_warnings():
        curves = read_beziers(table.surfaces)
        surfaces = [_surface(document, i, folder, curves.get(i)) for i in range(len(table.surfaces))]
    warn_flipped(document.name, surfaces)
    _refuse_unreal(document, surfaces)
    lights = [
        document.build(("lights", i), partial(Light, light.position, light.color))
        for i, light in enumerate(table.lights)
    ]
    settings = {key: value for key, value in table.render if value is not None and key != "reflections"}
    sky = {"horizon": table.sky.horizon, "zenith": table.sky.zenith}
    reflections = table.render.reflections
    make = partial(make_scene, camera, lights, surfaces, **sky, reflections=reflections, settings=settings)
    return document.build(("sky",), make)


def _surface(document: Document[SceneTable], i: int, folder: Path, segments: Segments | None) -> Surface:
    table = document.contents.surfaces[i]
    options = {} if segments is None else {"segments": segments}
    surface = document.build(("surfaces", i), partial(table.surface, folder, **options))
    surface.name = table.name
    return surface


def _refuse_unreal(document: Document[SceneTable], surfaces: Sequence[Surface]) -> None:
    """Refuse curves with imaginary objects, with the line in the file, rather than at the first ray."""
    members: dict[str, dict[int, EvolvedSurface]] = {}
    for i, surface in enumerate(surfaces):
        if isinstance(surface, EvolvedSurface):
            members.setdefault(surface.program_kind, {})[i] = surface
    for name, family in members.items():
        first = next(iter(family))
        kind = document.build(("surfaces", first), partial(_kind, name, family[first]))
        rows = [surface.parameters for surface in family.values()]
        ids = np.repeat(list(family), [len(part) for part in rows])
        document.build((), partial(with_real_intervals, kind, np.concatenate(rows), ids, surfaces))


def _kind(name: str, surface: EvolvedSurface) -> SurfaceKind:
    try:
        return surface_kind(name)
    except SceneError as error:
        remedy = "Use curve = 'kochanek_bartels' or 'interpolating' for many controls"
        raise SceneError(f"controls are {len(surface.flipped)}: {error.what}", remedy=remedy) from None
