"""Joints as shared geometry, mechanisms, chains and robots (thesis chapter 7); each name is loaded when it is used."""

from __future__ import annotations

from ..lazily import lazily

#: Public name -> module of this package that defines it.
_HOMES = {
    "Joint": "joints",
    "Spherical": "joints",
    "Cylindrical": "joints",
    "Planar": "joints",
    "Revolute": "joints",
    "Prismatic": "joints",
    "Universal": "bilinear",
    "Bilinear": "bilinear",
    "Rigid": "joints",
    "Mechanism": "mechanism",
    "FreeMotion": "motions",
    "SelfStress": "motions",
    "Analysis": "analysis",
    "Poses": "solving",
    "Chain": "chains",
    "revolute_axis": "chains_axes",
    "prismatic_axis": "chains_axes",
    "screw_axis": "chains_axes",
    "Solution": "chains_inverse",
    "Singularity": "chains_singular",
    "DeltaRobot": "delta",
    "Workspace": "delta_space",
    "Motion": "delta_motion",
    "load_mechanism": "document",
    "Setup": "setup",
    "picture": "pictures",
    "load_urdf": "urdf",
    "Robot": "urdf",
    "urdf_example": "urdf",
}

__all__ = sorted(_HOMES)

__getattr__, __dir__ = lazily(__name__, _HOMES)
