"""What constraints leave free: twists of the world that move no pinned object."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..codegen.errors import InputError, ShapeError
from ..multivector import Multivector
from . import engine, methods
from .assembly import assemble
from .bodies import RigidBody
from .constraints import Constraint, Incidence, Pin, PinLinear, PinPath, VirtualPower, check_constraints
from .functions import arity
from .given import several, shown

Array = NDArray[Any]
#: Share of a row that counts as rounding.
NOISE = 1e-9


def allowed_twists(constraint: Constraint | Sequence[Constraint], body: RigidBody | None = None) -> Multivector:
    """A basis of the twists that constraints leave free, in the world's frame (thesis 6.8).

    Parameters
    ----------
    constraint : Constraint or sequence
        Held against the world.
    body : RigidBody, optional
        At its start's pose; a body whose frame is the world's, if left out.

    Returns
    -------
    Multivector (mobility,)
        Twists w I3 + v n about the world's origin; orthonormal by the kinetic energy of the body (of mass and moments
        one, if left out).

    Raises
    ------
    InputError
        If a constraint is none or between two bodies, or nothing says of which algebra twists are.
    """
    if constraint is None:
        raise InputError("the constraint is None; a constraint or a list of them is needed.")
    given = several(constraint, Constraint, "the constraints")
    check_constraints(given, ["body"])
    if body is None:
        body = RigidBody(1.0, [1.0, 1.0, 1.0], algebra=_algebra(given))
    if not isinstance(body, RigidBody):
        raise InputError(f"the body is {shown(body)}; a RigidBody is needed.")
    if body.shape not in ((), (1,)):
        raise ShapeError(f"there are {body.shape[0]} bodies; the twists of one are asked for.")
    made = assemble([body], ["body"], [], given, 1.0, False)
    driver = engine.Driver(made, methods.Method("rk4", 1.0, methods.RTOL, 0.0), "exponential", False, 0.0)
    frame = made.frames[0]
    motors = frame.pose.as_kind("motor", check=False).values.reshape(1, 8)
    found = driver.look(0.0, motors, np.zeros((1, 6)))
    roots = np.sqrt(1 / made.numbers[0, :6])
    rows = found["matrix"] * roots
    norms = np.linalg.norm(rows, axis=-1, keepdims=True)
    rows = np.divide(rows, norms, out=np.zeros_like(rows), where=norms > 0)
    _, values, basis = np.linalg.svd(rows)
    rank = int((values > NOISE * max(values.max(initial=0.0), 1.0)).sum())
    algebra = made.algebra
    twists = algebra.wrap(algebra.kind("twist"), np.ascontiguousarray(basis[rank:] * roots))
    return (made.shift * frame.pose).as_kind("motor", check=False) >> twists


def _algebra(constraints: Sequence[Constraint]) -> Any:
    """That of the first object; of functions of the state nothing is known without a body."""
    unknown = ""
    for c in constraints:
        match c.asked():
            case Pin() | PinPath() as own:
                parts = [own.body_object, own.world_object]
            case PinLinear() | Incidence() as own:
                parts = [own.world_object, getattr(own, "body_point", None)]
            case VirtualPower() as own if callable(own.wrenches) and arity(own.wrenches, "the wrenches") == 3:
                unknown = own.label
                continue
            case VirtualPower() as own:
                parts = list(own.wrenches) if isinstance(own.wrenches, tuple) else [own.wrenches]
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
