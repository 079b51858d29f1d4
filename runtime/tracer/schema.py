"""The schema of scene files, and scenes made from them; every error says file, line and key."""

from __future__ import annotations

import math
import os
import re
from typing import Annotated, Any, Literal

from pydantic import Field

from ..errors import SceneError
from ..tomlread import Document, Positive, Table, Vector3, read_document
from .camera import Camera
from .scene import HORIZON, MAX_GRID, MAX_SIDE, REFLECTIONS, ZENITH, Light, Scene
from .surfaces import Disc, EvolvedCircles, Material, Plane, Sphere, Surface

NotNegative = Annotated[float, Field(ge=0.0)]
Share = Annotated[float, Field(ge=0.0, le=1.0)]
Color = tuple[NotNegative, NotNegative, NotNegative]


class CameraTable(Table):
    """Where the camera stands; the angle is vertical, in degrees."""

    position: Vector3
    look_at: Vector3
    up: Vector3 = (0.0, 0.0, 1.0)
    field_of_view: Annotated[float, Field(gt=0.0, lt=180.0)] = 45.0


class LightTable(Table):
    """A lamp."""

    position: Vector3
    color: Color = (1.0, 1.0, 1.0)


class SkyTable(Table):
    """What rays see that hit nothing."""

    horizon: Color = HORIZON
    zenith: Color = ZENITH


class RenderTable(Table):
    """Defaults of the picture."""

    width: Annotated[int, Field(ge=1, le=MAX_SIDE)] | None = None
    height: Annotated[int, Field(ge=1, le=MAX_SIDE)] | None = None
    antialias: Annotated[int, Field(ge=1, le=MAX_GRID)] | None = None
    reflections: Annotated[int, Field(ge=0, le=1000)] = REFLECTIONS


class SurfaceTable(Table):
    """What all surfaces have: the keys of `Material`."""

    color: Color = (0.8, 0.8, 0.8)
    ambient: NotNegative = 0.1
    diffuse: NotNegative = 0.8
    specular: NotNegative = 0.3
    shininess: Positive = 32.0
    reflectivity: Share = 0.0

    def material(self) -> Material:
        """The look of the surface."""
        return Material(**{key: getattr(self, key) for key in Material.__dataclass_fields__ if hasattr(self, key)})

    def surface(self) -> Surface:
        """The surface."""
        raise NotImplementedError


class FlatTable(SurfaceTable):
    """Planes and discs may be checkered."""

    checker: Color | None = None
    checker_size: Positive = 1.0


class PlaneTable(FlatTable):
    """normal . x = offset."""

    kind: Literal["plane"]
    normal: Vector3
    offset: float = 0.0

    def surface(self) -> Surface:
        return Plane(self.normal, self.offset, material=self.material())


class SphereTable(SurfaceTable):
    """A sphere."""

    kind: Literal["sphere"]
    center: Vector3
    radius: Positive

    def surface(self) -> Surface:
        return Sphere(self.center, self.radius, material=self.material())


class DiscTable(FlatTable):
    """A disc."""

    kind: Literal["disc"]
    center: Vector3
    normal: Vector3
    radius: Positive

    def surface(self) -> Surface:
        return Disc(self.center, self.normal, self.radius, material=self.material())


class CircleTable(Table):
    """A control object."""

    center: Vector3
    normal: Vector3
    radius: Positive


class EvolvedCirclesTable(SurfaceTable):
    """The surface between two circles."""

    kind: Literal["evolved_circles"]
    curve: Literal["bezier"] = "bezier"
    controls: Annotated[list[CircleTable], Field(min_length=2, max_length=2)]
    align: bool = True

    def surface(self) -> Surface:
        circles = [(c.center, c.normal, c.radius) for c in self.controls]
        return EvolvedCircles(circles, align=self.align, material=self.material())


AnySurface = Annotated[PlaneTable | SphereTable | DiscTable | EvolvedCirclesTable, Field(discriminator="kind")]


class SceneTable(Table):
    """A scene file."""

    camera: CameraTable
    lights: list[LightTable] = []
    surfaces: list[AnySurface] = []
    sky: SkyTable = SkyTable()
    render: RenderTable = RenderTable()


def load_scene(path: str | os.PathLike[str]) -> Scene:
    """Read and check a scene file."""
    document = read_document(str(path), SceneTable, SceneError)
    table = document.contents
    camera = _made(document, ("camera",), lambda: _camera(table.camera))
    surfaces = [_made(document, ("surfaces", i), s.surface) for i, s in enumerate(table.surfaces)]
    lights = [Light(light.position, light.color) for light in table.lights]
    settings = {key: value for key, value in table.render if value is not None and key != "reflections"}
    return Scene(
        camera,
        lights,
        surfaces,
        horizon=table.sky.horizon,
        zenith=table.sky.zenith,
        reflections=table.render.reflections,
        settings=settings,
    )


def _camera(table: CameraTable) -> Camera:
    return Camera.look_at(table.position, table.look_at, table.up, math.radians(table.field_of_view))


#: What messages about objects call them; in a file the path says it.
_OBJECTS = ("camera", "plane", "sphere", "disc", "material", "light")


def _made(document: Document[SceneTable], path: tuple[Any, ...], make: Any) -> Any:
    """What the schema cannot see (a normal of length zero): its error gets a file and a line."""
    try:
        return make()
    except SceneError as error:
        key, _, rest = error.what.partition(" ")
        parts = re.findall(r"[A-Za-z_]+|\d+", key)
        inner = [int(part) if part.isdigit() else part for part in parts if part not in _OBJECTS]
        raise document.error((*path, *inner), rest) from None
