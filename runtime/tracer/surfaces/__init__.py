"""Surfaces of scenes."""

from __future__ import annotations

from .base import LEAST_SAMPLES, Intersections, Surface, ray_arrays
from .evolved import EvolvedCircles
from .flats import Disc, Plane, Sphere
from .material import Material

__all__ = [
    "LEAST_SAMPLES",
    "Disc",
    "EvolvedCircles",
    "Intersections",
    "Material",
    "Plane",
    "Sphere",
    "Surface",
    "ray_arrays",
]
