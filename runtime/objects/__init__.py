"""Geometric objects: rotors between them, blends, averages, costs, clusters, screws, fits (thesis chapters 2 and 3).

Functions take batches of objects of `bladesmith.cga3d` and give batches; each is loaded when it is first used.
"""

from __future__ import annotations

from ..lazily import lazily

#: Public name -> module of this package that defines it.
_HOMES = {
    "rotor_between": "rotors",
    "mirror_between": "rotors",
    "trs_rotor": "rotors",
    "project_to_blade": "blends",
    "interpolate": "blends",
    "interpolate_derivative": "blends",
    "average": "blends",
    "align": "blends",
    "common_sphere": "spheres",
    "orthogonal_sphere": "spheres",
    "enclosing_sphere": "enclosing",
    "rotor_cost": "costs",
    "cost_matrix": "costs",
    "kmeans": "clusters",
    "merge_similar": "merging",
    "closest_point": "closest",
    "screw": "screws",
    "screw_bivector": "screws",
    "screw_motor": "screws",
    "screw_of_lines": "screws",
    "sphere_weights": "weights",
    "join": "subspaces",
    "meet": "subspaces",
    "factorise": "subspaces",
    "factorize": "subspaces",
    "is_blade": "subspaces",
    "fit_line": "fits",
    "fit_circle": "fits",
    "fit_plane": "fits",
    "fit_sphere": "fits",
}

__all__ = sorted(_HOMES)

__getattr__, __dir__ = lazily(__name__, _HOMES)
