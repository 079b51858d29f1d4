"""Surfaces of scenes."""

from __future__ import annotations

from .base import LEAST_SAMPLES, MOST_SAMPLES, Intersections, Surface, names_at, ray_arrays
from .evolved import EvolvedCircles, EvolvedPointPairs
from .facets import Facets, Mesh
from .flats import Disc, Plane, Sphere
from .material import Material

__all__ = [
    "LEAST_SAMPLES",
    "MOST_SAMPLES",
    "Disc",
    "EvolvedCircles",
    "EvolvedPointPairs",
    "Facets",
    "Intersections",
    "Material",
    "Mesh",
    "Plane",
    "Sphere",
    "Surface",
    "names_at",
    "ray_arrays",
]
