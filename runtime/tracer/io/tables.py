"""Tables of scene files: camera, lights, sky, picture, and all kinds of surfaces but those along curves.

`evolved_tables` has the surfaces along curves.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field

from ...common.documents import Positive, Table, Vector3
from ...common.validation import short_repr
from ...errors import InputError, SceneError
from ..scene.camera import Camera
from ..scene.defaults import HORIZON, MAX_GRID, MAX_REFLECTIONS, MAX_SIDE, REFLECTIONS, ZENITH
from ..surfaces import Disc, Material, Plane, Sphere, Surface

NotNegative = Annotated[float, Field(ge=0.0)]
Fraction = Annotated[float, Field(ge=0.0, le=1.0)]
Color = tuple[NotNegative, NotNegative, NotNegative]
#: Coefficients of a motor on 1, e12, e13, e1 n_inf, e23, e2 n_inf, e3 n_inf, e123 n_inf.
Motor = tuple[float, float, float, float, float, float, float, float]


class CameraTable(Table):
    """A camera, by positions or by the motor of thesis 4.3; the field of view is vertical, in degrees."""

    position: Vector3 | None = None
    look_at: Vector3 | None = None
    up: Vector3 = (0.0, 0.0, 1.0)
    field_of_view: Annotated[float, Field(gt=0.0, lt=180.0)] = 45.0
    motor: Motor | None = None
    focal_length: Positive = 1.0
    x_max: Positive | None = None
    y_max: Positive | None = None

    PLACES: ClassVar = ("position", "look_at", "up", "field_of_view")
    LENS: ClassVar = ("motor", "focal_length", "x_max", "y_max")

    def camera(self) -> Camera:
        """The camera.

        Raises
        ------
        SceneError
            With a text that begins with the invalid key.
        """
        by_motor = "motor" in self.model_fields_set
        others = [key for key in (self.PLACES if by_motor else self.LENS) if key in self.model_fields_set]
        if others:
            one, other = _enumerate_keys(self.PLACES), _enumerate_keys(self.LENS)
            raise SceneError(f"{others[0]} belongs to the other definition of a camera: give {one}, or {other}.")
        if not by_motor:
            position, target = _require(self, "position"), _require(self, "look_at")
            return Camera.look_at(position, target, self.up, math.radians(self.field_of_view))
        return Camera(_require(self, "motor"), self.focal_length, self.x_max, _require(self, "y_max"))


class LightTable(Table):
    """A point light."""

    position: Vector3
    color: Color = (1.0, 1.0, 1.0)


class SkyTable(Table):
    """Colors of rays that hit no surface."""

    horizon: Color = HORIZON
    zenith: Color = ZENITH


class RenderTable(Table):
    """Defaults of the picture."""

    width: Annotated[int, Field(ge=1, le=MAX_SIDE)] | None = None
    height: Annotated[int, Field(ge=1, le=MAX_SIDE)] | None = None
    antialias: Annotated[int, Field(ge=1, le=MAX_GRID)] | None = None
    reflections: Annotated[int, Field(ge=0, le=MAX_REFLECTIONS)] = REFLECTIONS


class SurfaceTable(Table):
    """Keys of all surfaces: a name, and those of `Material`."""

    name: Annotated[str, Field(min_length=1, max_length=200)] | None = None
    color: Color = (0.8, 0.8, 0.8)
    ambient: NotNegative = 0.1
    diffuse: NotNegative = 0.8
    specular: NotNegative = 0.3
    shininess: Positive = 32.0
    reflectivity: Fraction = 0.0

    def material(self) -> Material:
        """Material of the surface."""
        return Material(**{key: getattr(self, key) for key in Material.__dataclass_fields__ if hasattr(self, key)})

    def surface(self, folder: Path) -> Surface:
        """Make the surface; paths are relative to the folder.

        Raises
        ------
        BladesmithError
            With a text that begins with the invalid key, if there is one.
        """
        raise NotImplementedError


class FlatTable(SurfaceTable):
    """Further keys of planes and discs: a checkered pattern."""

    checker: Color | None = None
    checker_size: Positive = 1.0


class PlaneTable(FlatTable):
    """The plane normal . x = offset."""

    kind: Literal["plane"]
    normal: Vector3
    offset: float = 0.0

    def surface(self, folder: Path) -> Surface:
        return Plane(self.normal, self.offset, material=self.material())


class SphereTable(SurfaceTable):
    """A sphere."""

    kind: Literal["sphere"]
    center: Vector3
    radius: Positive

    def surface(self, folder: Path) -> Surface:
        return Sphere(self.center, self.radius, material=self.material())


class DiscTable(FlatTable):
    """A disc; the thesis renders circles as their discs."""

    kind: Literal["disc", "circle"]
    center: Vector3
    normal: Vector3
    radius: Positive

    def surface(self, folder: Path) -> Surface:
        return Disc(self.center, self.normal, self.radius, material=self.material())


class FacetsTable(SurfaceTable):
    """Triangles."""

    kind: Literal["facets"]
    vertices: Annotated[list[Vector3], Field(min_length=3)]
    faces: Annotated[list[tuple[int, int, int]], Field(min_length=1)] = [(0, 1, 2)]
    normals: list[Vector3] | None = None

    def surface(self, folder: Path) -> Surface:
        from ..surfaces.triangles import Facets

        if "faces" not in self.model_fields_set and len(self.vertices) != 3:
            raise SceneError(f"vertices are {len(self.vertices)}; faces are needed unless there are 3.")
        return Facets(self.vertices, self.faces, normals=self.normals, material=self.material())


class MeshTable(SurfaceTable):
    """Triangles of a file."""

    kind: Literal["mesh"]
    path: Annotated[str, Field(min_length=1)]
    scale: Positive = 1.0
    smooth: bool = False

    def surface(self, folder: Path) -> Surface:
        from ..surfaces.triangles import Mesh

        if "\0" in self.path:
            raise SceneError("path has a null character.")
        try:
            return Mesh(folder / self.path, scale=self.scale, smooth=self.smooth, material=self.material())
        except InputError as error:
            if error.where is None:
                raise
            raise SceneError(f"path is {short_repr(self.path)}: {error.what}", remedy=error.remedy) from None


def _require(table: Table, key: str) -> Any:
    """Value of a key that the chosen definition requires."""
    value = getattr(table, key)
    if value is None:
        raise SceneError(f"{key} is missing.")
    return value


def _enumerate_keys(keys: Iterable[str]) -> str:
    *most, last = keys
    return f"{', '.join(most)} and {last}"
