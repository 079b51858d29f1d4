"""Surfaces of scenes: planes, spheres, discs, triangles, and surfaces evolved along curves."""

from __future__ import annotations

from .base import LEAST_SAMPLES, MOST_SAMPLES, Intersections, Surface, names_at, ray_arrays
from .evolved import EvolvedCircles, EvolvedPointPairs
from .material import Material
from .planes_spheres_discs import Disc, Plane, Sphere
from .triangles import Facets, Mesh

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
