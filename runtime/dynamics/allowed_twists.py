"""Admissible twists of constraints: twists of the world that move no pinned object."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..codegen.errors import InputError, ShapeError
from ..common.validation import as_instance, as_tuple
from ..core.multivector import Multivector
from ..mechanics.rigid_body import RigidBody
from .assembly.assemble import assemble
from .assembly.callbacks import arity
from .integration import driver as engine
from .integration import integrators
from .model.constraints import Constraint, Incidence, Pin, PinLinear, PinPath, VirtualPower, check_constraints

Array = NDArray[Any]
#: Relative size of singular values of constraints that count as zero.
RANK_RTOL = 1e-9


def allowed_twists(constraint: Constraint | Sequence[Constraint], body: RigidBody | None = None) -> Multivector:
    """Basis of the twists that constraints allow, in the world's frame (thesis 6.8).

    Parameters
    ----------
    constraint : Constraint or sequence
        Constraints of a body to the world.
    body : RigidBody, optional
        Body at its start; default: one whose frame is the world's.

    Returns
    -------
    Multivector (mobility,)
        Twists w I3 + v n about the world's origin; orthonormal by the kinetic energy of the body (mass and
        moments one by default).

    Raises
    ------
    InputError
        If a constraint is not valid or is between two bodies, or no object determines the algebra.
    """
    if constraint is None:
        raise InputError("the constraint is None; a constraint or a list of them is needed.")
    constraints = as_tuple(constraint, "the constraints", Constraint)
    check_constraints(constraints, ["body"])
    if body is None:
        body = RigidBody(1.0, [1.0, 1.0, 1.0], algebra=_algebra(constraints))
    if as_instance(body, "the body", RigidBody).shape not in ((), (1,)):
        raise ShapeError(f"there are {body.shape[0]} bodies; the twists of one are computed.")
    assembly = assemble([body], ["body"], [], constraints, 1.0, False)
    driver = engine.Driver(assembly, integrators.Method("rk4", 1.0, integrators.RTOL, 0.0), "exponential", False, 0.0)
    frame = assembly.frames[0]
    motors = frame.pose.as_kind("motor", check=False).values.reshape(1, 8)
    values = driver.evaluate(0.0, motors, np.zeros((1, 6)))
    roots = np.sqrt(1 / assembly.parameters[0, :6])
    rows = values["matrix"] * roots
    norms = np.linalg.norm(rows, axis=-1, keepdims=True)
    rows = np.divide(rows, norms, out=np.zeros_like(rows), where=norms > 0)
    _, singular, basis = np.linalg.svd(rows)
    rank = int((singular > RANK_RTOL * max(singular.max(initial=0.0), 1.0)).sum())
    algebra = assembly.algebra
    twists = algebra.wrap(algebra.kind("twist"), np.ascontiguousarray(basis[rank:] * roots))
    return (assembly.shift * frame.pose).as_kind("motor", check=False) >> twists


def _algebra(constraints: Sequence[Constraint]) -> Any:
    """Algebra of the first object; functions of the state cannot be evaluated without a body."""
    unknown = ""
    for c in constraints:
        match c.with_guarded_callbacks():
            case Pin() | PinPath() as guarded:
                parts = [guarded.body_object, guarded.world_object]
            case PinLinear() | Incidence() as guarded:
                parts = [guarded.world_object, getattr(guarded, "body_point", None)]
            case VirtualPower() as guarded if (
                callable(guarded.wrenches) and arity(guarded.wrenches, "the wrenches") == 3
            ):
                unknown = guarded.label
                continue
            case VirtualPower() as guarded:
                wrenches: Any = guarded.wrenches
                parts = list(wrenches) if isinstance(wrenches, tuple) else [wrenches]
            case _:
                parts = []
        for x in parts:
            x = x(0.0) if callable(x) else x
            x = x[0] if isinstance(x, tuple) else x
            if isinstance(x, Multivector):
                return x.algebra
    if unknown:
        raise InputError(
            f"{unknown} depends on the state, and no body is given.",
            remedy="Give one, as in body=RigidBody(1.0, [1, 1, 1])",
        )
    return None
