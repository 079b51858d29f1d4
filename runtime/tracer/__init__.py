"""Ray tracing of planes, spheres, discs and surfaces evolved between circles (thesis chapter 4)."""

from __future__ import annotations

from .camera import Camera
from .image import save_image
from .reflection import reflect
from .scene import Hits, Light, Scene
from .surfaces import Disc, EvolvedCircles, Intersections, Material, Plane, Sphere, Surface

__all__ = [
    "Camera",
    "Disc",
    "EvolvedCircles",
    "Hits",
    "Intersections",
    "Light",
    "Material",
    "Plane",
    "Scene",
    "Sphere",
    "Surface",
    "reflect",
    "save_image",
]
