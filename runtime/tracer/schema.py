"""Scene files, and scenes made from them; every error says file, line, key and remedy."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Annotated, Any, TypeVar

import numpy as np
from pydantic import Field

from ..codegen.programs.surface_kinds import SurfaceKind, surface_kind
from ..errors import BladesmithError, MissingExtraError, SceneError
from ..tomlread import Document, Table, read_document
from .evolved_tables import EvolvedCirclesTable, EvolvedPointPairsTable, read_beziers
from .light import Light
from .scene import Scene
from .segments import Segments
from .spans import checked
from .surfaces import Surface
from .surfaces.evolved import EvolvedSurface, quietly, tell_turned
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
from .values import shown

T = TypeVar("T")
AnySurface = Annotated[
    PlaneTable | SphereTable | DiscTable | FacetsTable | MeshTable | EvolvedCirclesTable | EvolvedPointPairsTable,
    Field(discriminator="kind"),
]
#: What messages about objects put before the name of a value; in a file the path says it.
_OBJECTS = ("camera", "plane", "sphere", "disc", "facets", "mesh", "material", "light")
_KEY = re.compile(r"(?P<key>[A-Za-z_]\w*(?:\.[A-Za-z_]\w*|\[\d+\])*):? (?P<rest>.*)", re.DOTALL)


class SceneTable(Table):
    """A scene file."""

    camera: CameraTable
    lights: list[LightTable] = []
    surfaces: list[AnySurface] = []
    sky: SkyTable = SkyTable()
    render: RenderTable = RenderTable()


def load_scene(path: str | os.PathLike[str]) -> Scene:
    """Read and check a scene file.

    Raises
    ------
    SceneError
        If it cannot be read, is no TOML, does not fit the schema, or means nothing: with file, line and key.
    """
    try:
        file = Path(os.fsdecode(path))
    except TypeError:
        raise SceneError(f"a scene is read from a file, and {shown(path)} names none.") from None
    if "\0" in str(file):
        raise SceneError(f"the name {shown(path)} has a null character.")
    document = read_document(str(file), SceneTable, SceneError)
    table, folder = document.contents, file.parent
    camera = _made(document, ("camera",), table.camera.camera)
    with quietly():
        curves = read_beziers(table.surfaces)
        surfaces = [_surface(document, i, folder, curves.get(i)) for i in range(len(table.surfaces))]
    tell_turned(document.name, surfaces)
    _refuse_unreal(document, surfaces)
    lights = [
        _made(document, ("lights", i), partial(Light, light.position, light.color))
        for i, light in enumerate(table.lights)
    ]
    settings = {key: value for key, value in table.render if value is not None and key != "reflections"}
    sky = {"horizon": table.sky.horizon, "zenith": table.sky.zenith}
    reflections = table.render.reflections
    make = partial(Scene, camera, lights, surfaces, **sky, reflections=reflections, settings=settings)
    return _made(document, ("sky",), make)


def _surface(document: Document[SceneTable], i: int, folder: Path, segments: Segments | None) -> Surface:
    table = document.contents.surfaces[i]
    known = {} if segments is None else {"segments": segments}
    surface = _made(document, ("surfaces", i), partial(table.surface, folder, **known))
    surface.name = table.name
    return surface


def _refuse_unreal(document: Document[SceneTable], surfaces: Sequence[Surface]) -> None:
    """Curves that are no curves of real objects are told with their line, not when the first ray comes."""
    members: dict[str, dict[int, EvolvedSurface]] = {}
    for i, surface in enumerate(surfaces):
        if isinstance(surface, EvolvedSurface):
            members.setdefault(surface.program_kind, {})[i] = surface
    for name, found in members.items():
        first = next(iter(found))
        kind = _made(document, ("surfaces", first), partial(_kind, name, found[first]))
        rows = [surface.parameters for surface in found.values()]
        ids = np.repeat(list(found), [len(part) for part in rows])
        _made(document, (), partial(checked, kind, np.concatenate(rows), ids, surfaces))


def _kind(name: str, surface: EvolvedSurface) -> SurfaceKind:
    try:
        return surface_kind(name)
    except SceneError as error:
        remedy = "Use curve = 'kochanek_bartels' or 'interpolating' for many controls"
        raise SceneError(f"controls are {len(surface.flipped)}: {error.what}", remedy=remedy) from None


def _made(document: Document[SceneTable], path: tuple[Any, ...], make: Callable[[], T]) -> T:
    """What the schema cannot see (a normal of length zero): its error gets a file, a line and a key."""
    try:
        return make()
    except MissingExtraError:
        raise
    except BladesmithError as error:
        inner, text = _place(document, path, error.what)
        where = f"{error.where}: " if error.where else ""
        raise document.error((*path, *inner), where + text, error.remedy) from None


def _place(document: Document[SceneTable], path: tuple[Any, ...], what: str) -> tuple[tuple[Any, ...], str]:
    """The key of a table that a message begins with, and the rest of the message; else the message."""
    table: Any = document.contents
    for part in path:
        table = table[part] if isinstance(part, int) else getattr(table, part)
    found = _KEY.fullmatch(what)
    if found is not None:
        parts = [int(p) if p.isdigit() else p for p in re.findall(r"[A-Za-z_]\w*|\d+", found["key"])]
        inner = tuple(part for part in parts if part not in _OBJECTS)
        if inner and inner[0] in getattr(type(table), "model_fields", ()):
            return inner, found["rest"]
    return (), f"is refused: {what}" if path else what
