"""Registration of models made of points, point pairs, lines, circles, planes and spheres (thesis chapter 5)."""

from __future__ import annotations

from .clouds import CloudFit, CloudInterrupted, model_from_points
from .estimate import Estimate, estimate_rotor
from .iterate import iterate
from .matching import Matching, cost_matrix, match
from .meshes import model_from_mesh
from .model import Model
from .picture import draw_model, picture
from .record import load_registration, save_registration
from .register import register
from .result import PerItem, Registration, Step

__all__ = [
    "CloudFit",
    "CloudInterrupted",
    "Estimate",
    "Matching",
    "Model",
    "PerItem",
    "Registration",
    "Step",
    "cost_matrix",
    "draw_model",
    "estimate_rotor",
    "iterate",
    "load_registration",
    "match",
    "model_from_mesh",
    "model_from_points",
    "picture",
    "register",
    "save_registration",
]
