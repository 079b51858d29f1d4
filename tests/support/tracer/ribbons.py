"""Surfaces between point pairs, and rays near them."""

from __future__ import annotations

import numpy as np

from bladesmith.tracer.surfaces.evolved import EvolvedPointPairs

from ...oracles import ribbons as rs

LINEAR = [((-1.0, -0.5, -1.0), (1.0, -0.5, -1.0)), ((-0.8, 0.6, 1.0), (1.0, 0.2, 1.2))]


def random_pairs(random, degree):
    return [tuple(random.normal(size=(2, 3))) for _ in range(degree + 1)]


def on_a_circle(random, degree):
    """Chords of a unit circle in a random plane, either crossing or side by side."""
    angles = np.sort(random.uniform(0, 2 * np.pi, size=2 * degree + 2))
    axes = np.linalg.qr(random.normal(size=(3, 3)))[0]
    points = np.stack([np.cos(angles), np.sin(angles)], -1) @ axes[:2]
    return [(points[i], points[-1 - i]) for i in range(degree + 1)], axes[2]


def surface_of(pairs):
    surface = EvolvedPointPairs([(tuple(a), tuple(b)) for a, b in pairs], align=True)
    return surface, rs.Oracle(pairs, surface.flipped)


def rays_near(random, count, center=0.0):
    origins = random.normal(size=(count, 3)) * 3
    return origins + center, random.normal(size=(count, 3)) * 0.4 - origins
