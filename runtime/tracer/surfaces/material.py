"""Materials: the Blinn-Phong model with mirror reflection, as one row of numbers for the driver."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...codegen.programs.tracer.records import MATERIAL
from ...common.validation import as_choice, as_instance
from ...errors import SceneError
from ..scene import values

Array = NDArray[Any]


@dataclass(frozen=True, eq=False)
class Material:
    """Parameters of the Blinn-Phong model with mirror reflection.

    Attributes
    ----------
    color : (3,) array
        Linear red, green, blue.
    ambient, diffuse, specular : float
        Factors of the ambient color, of Lambert's law, and of the highlight (which is white).
    shininess : float
        Exponent of the highlight.
    reflectivity : float
        Fraction of the visible light that comes from the mirror image, 0 to 1.
    checker : (3,) array or None
        Second color of a pattern of squares, on planes and discs.
    checker_size : float
        Side of a square.
    """

    color: ArrayLike = (0.8, 0.8, 0.8)
    ambient: float = 0.1
    diffuse: float = 0.8
    specular: float = 0.3
    shininess: float = 32.0
    reflectivity: float = 0.0
    checker: ArrayLike | None = None
    checker_size: float = 1.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "color", values.color(self.color, "material.color"))
        if self.checker is not None:
            object.__setattr__(self, "checker", values.color(self.checker, "material.checker"))
        for name in ("ambient", "diffuse", "specular"):
            object.__setattr__(
                self, name, values.number(getattr(self, name), f"material.{name}", 0.0, values.BRIGHTEST)
            )
        object.__setattr__(self, "shininess", values.positive(self.shininess, "material.shininess"))
        object.__setattr__(self, "checker_size", values.positive(self.checker_size, "material.checker_size"))
        mirror = values.number(self.reflectivity, "material.reflectivity", 0.0, 1.0)
        object.__setattr__(self, "reflectivity", mirror)

    def row(self, normal: Array | None) -> Array:
        """Row of constants for the driver; the squares lie in the plane perpendicular to the normal."""
        row = MATERIAL.zeros()
        row.color = row.second = self.color
        row.ambient, row.diffuse, row.specular = self.ambient, self.diffuse, self.specular
        row.shininess, row.reflectivity = self.shininess, self.reflectivity
        if self.checker is not None:
            if normal is None:
                raise SceneError("material.checker is for planes and discs.")
            row.second = self.checker
            row.across = np.array(perpendicular_basis(normal)) / self.checker_size
        return np.asarray(row)


def perpendicular_basis(normal: Array) -> tuple[Array, Array]:
    """Two unit vectors perpendicular to a normal, right-handed with it; e1 and e2 for the normal e3."""
    first = np.eye(3)[1 if abs(normal[1]) < 0.9 else 2]
    u = np.cross(first, normal)
    u = u / np.linalg.norm(u)
    return u, np.cross(normal, u)


def as_material(value: Material | Mapping[str, Any] | None) -> Material:
    if value is None or isinstance(value, Material):
        return value or Material()
    given = as_instance(value, "material", Mapping, "a Material or a mapping", SceneError)
    for key in given:
        as_choice(key, "a key of material", Material.__dataclass_fields__, SceneError)
    return Material(**given)
