"""Registration of models made of points, point pairs, lines, circles, planes and spheres (thesis chapter 5)."""

from __future__ import annotations

from .clouds import CloudFit, CloudInterrupted, model_from_points
from .meshes import model_from_mesh
from .model import Model
from .picture import draw_model, picture
from .record import load_registration, save_registration
from .register import register
from .result import PerItem, Registration, Step

__all__ = [
    "CloudFit",
    "CloudInterrupted",
    "Model",
    "PerItem",
    "Registration",
    "Step",
    "draw_model",
    "load_registration",
    "model_from_mesh",
    "model_from_points",
    "picture",
    "register",
    "save_registration",
]
