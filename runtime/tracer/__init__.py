"""Ray tracing of planes, spheres, discs, facets and surfaces evolved along curves (thesis chapter 4)."""

from __future__ import annotations

from .camera import Camera
from .hits import Hits
from .image import save_image, save_layers
from .light import Light
from .meshing import TriangleMesh, mesh_of
from .pictures import PartialPicture, RenderError, RenderInterrupted
from .reflection import normal_line, reflect, tangent_line
from .scene import Scene
from .surfaces import (
    Disc,
    EvolvedCircles,
    EvolvedPointPairs,
    Facets,
    Intersections,
    Material,
    Mesh,
    Plane,
    Sphere,
    Surface,
)
from .view import view

__all__ = [
    "Camera",
    "Disc",
    "EvolvedCircles",
    "EvolvedPointPairs",
    "Facets",
    "Hits",
    "Intersections",
    "Light",
    "Material",
    "Mesh",
    "PartialPicture",
    "Plane",
    "RenderError",
    "RenderInterrupted",
    "Scene",
    "Sphere",
    "Surface",
    "TriangleMesh",
    "mesh_of",
    "normal_line",
    "reflect",
    "save_image",
    "save_layers",
    "tangent_line",
    "view",
]
