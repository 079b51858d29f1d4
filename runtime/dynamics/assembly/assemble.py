"""From bodies, loads and constraints to the parameters of the compiled driver."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ...codegen.errors import AlgebraMismatchError, GradeError, InputError, KindError, ShapeError
from ...core.multivector import Multivector
from ...mechanics.rigid_body import RigidBody
from ..model import loads as load_types
from ..model.constraints import Constraint, Pin
from ..model.joint_loads import JointLoad
from .body_parameters import loads_present, pack_bodies, pack_functions, pack_springs
from .constraint_parameters import pack_constraint
from .data import Assembly
from .pin_frames import pin_frame, principal_frame


def assemble(
    bodies: Sequence[RigidBody],
    names: Sequence[str],
    loads: Sequence[Any],
    constraints: Sequence[Constraint],
    duration: float,
    null_space: bool,
) -> Assembly:
    """Assemble a simulation.

    Parameters
    ----------
    duration : float
        End of the time in which functions are evaluated.
    null_space : bool
        Treat pins that never move by motions in their null space only, where that is possible.
    """
    algebra = bodies[0].algebra
    constraints = [c.with_guarded_callbacks() for c in constraints]
    shape = _shape(bodies, loads)
    fixed = bool(constraints) and len(bodies) == 1 and all(type(c) is Pin and c.other is None for c in constraints)
    if null_space and fixed:
        frames, origin = pin_frame(bodies[0], constraints)
        mode = "subspace"
    else:
        origin = np.mean([np.broadcast_to(b.position, (*shape, 3)) for b in bodies], 0)
        frames = [principal_frame(b, origin) for b in bodies]
        mode = "constrained" if constraints else "free"
    loads = [load for load in loads if not isinstance(load, JointLoad)]
    size = shape[0] if shape else 1
    assembly = Assembly(algebra, tuple(bodies), tuple(names), size, bool(shape), frames, origin, mode)
    assembly.constraints = tuple(constraints)
    pack_bodies(assembly, loads)
    pack_springs(assembly, loads)
    pack_functions(assembly, loads)
    for i, constraint in enumerate(constraints):
        try:
            pack_constraint(assembly, constraint, duration)
        except (InputError, GradeError, ShapeError, KindError, AlgebraMismatchError) as error:
            where = error.where or f"constraint {i} ({constraint.label})"
            raise type(error)(error.what, where=where, remedy=error.remedy) from error.__cause__
    assembly.loads = loads_present(loads)
    return assembly


def _shape(bodies: Sequence[RigidBody], loads: Sequence[Any]) -> tuple[int, ...]:
    """Common batch of bodies and loads, () or (n,)."""
    shapes = [b.shape for b in bodies]
    for load in loads:
        match load:
            case load_types.Spring():
                shapes += [load.point.shape[:-1], load.anchor.shape[:-1]]
                shapes += [x.shape for x in (load.stiffness, load.length, load.damping)]
            case load_types.BodyLaw():
                shapes += [getattr(load, name).shape for name in load.numbers]
            case JointLoad():
                shapes += load.shapes
            case load_types.Gravity():
                shapes.append(load.acceleration.shape[:-1])
            case load_types.BodyWrench() | load_types.WorldWrench():
                shapes += [load.wrench.shape] if isinstance(load.wrench, Multivector) else []
            case _:
                names = ", ".join(load_types.load_names())
                raise InputError(f"a load is a {type(load).__name__}; there are: {names}.")
    try:
        shape = np.broadcast_shapes(*shapes)
    except ValueError:
        raise ShapeError(f"bodies and loads have batches {sorted(set(shapes))} that do not broadcast.") from None
    if len(shape) > 1:
        raise ShapeError(f"bodies and loads have shape {shape}; one simulation, or a batch (n,), is meant.")
    if shape == (0,):
        raise ShapeError("the batch of bodies and loads is empty: there is nothing to simulate.")
    return shape
