"""Statics, screws and rigid-body dynamics in CGA and PGA (thesis chapter 6).

Twists and wrenches are bivectors of `bladesmith.cga3d` or `pga3d`; each name is loaded when it is first used.
"""

from __future__ import annotations

from ..lazily import lazily

#: Public name -> module of this package that defines it.
_HOMES = {
    "twist": "screws",
    "wrench": "screws",
    "couple": "screws",
    "twist_parts": "screws",
    "wrench_parts": "screws",
    "velocity_at": "screws",
    "moment_about": "screws",
    "power": "screws",
    "reciprocal": "screws",
    "screw_cross": "screws",
    "killing_form": "screws",
    "screw": "screws",
    "screw_coordinates": "screws",
    "screw_from_coordinates": "screws",
    "resultant": "statics",
    "equilibrium": "statics",
    "force_along": "statics",
    "line_of_wrench": "statics",
    "wrench_of_vector": "statics",
    "vector_of_wrench": "statics",
    "ideal_line": "statics",
    "Inertia": "inertia",
    "mass_properties": "solids",
    "map_motor": "maps",
    "map_rate": "maps",
    "RigidBody": "bodies",
    "Gravity": "loads",
    "BodyWrench": "loads",
    "WorldWrench": "loads",
    "Spring": "loads",
    "Damper": "loads",
    "Pin": "constraints",
    "PinPath": "constraints",
    "PinLinear": "constraints",
    "Incidence": "constraints",
    "VirtualPower": "constraints",
    "allowed_twists": "freedom",
    "Event": "events",
    "Simulation": "simulation",
    "System": "system",
    "Trajectory": "trajectory",
    "Setup": "document",
    "load_simulation": "document",
    "Record": "record",
    "load_trajectory": "files",
    "recorded": "record",
    "Shape": "shapes",
    "box": "shapes",
    "cone": "shapes",
    "cylinder": "shapes",
    "rod": "shapes",
    "sphere": "shapes",
    "Sketch": "sketch",
    "Trace": "sketch",
    "Units": "sketch",
    "animate": "animation",
    "picture": "pictures",
    "plot": "plots",
    "save": "files",
}

__all__ = sorted(_HOMES)

__getattr__, __dir__ = lazily(__name__, _HOMES)
