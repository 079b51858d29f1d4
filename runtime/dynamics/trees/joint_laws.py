"""Loads of joints as the algorithms of trees take them: a torque and a law for each freedom."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.algorithms.trees.motion_records import JointLaw
from ...codegen.errors import InputError
from ...mechanics.system import System
from ..model.joint_loads import JointDamper, JointFriction, JointLimit, JointLoad, JointSpring, JointTorque
from .spanning_tree import SpanningTree

Array = NDArray[Any]


def joint_laws(system: System, tree: SpanningTree, loads: Sequence[Any], size: int) -> tuple[Array, Array]:
    """Laws (size, n) of all freedoms, and constant torques (size, n).

    Raises
    ------
    InputError
        If a load is of a freedom that there is not, or two are that only one can be.
    """
    laws, torques = JointLaw.zeros(size, tree.count), np.zeros((size, tree.count))
    laws.lower, laws.upper, laws.slip = -np.inf, np.inf, 1.0
    used = set[tuple[type, int]]()
    for i, load in enumerate(loads):
        if not isinstance(load, JointLoad):
            continue
        places, start = _freedoms(system, tree, load, f"loads[{i}] ({load.label})")
        for j in places:
            if (type(load), j) in used and isinstance(load, (JointFriction, JointLimit)):
                raise InputError(f"loads[{i}] ({load.label}) is the second one of its freedom; one can be there.")
            used.add((type(load), j))
            law = laws[:, j]
            match load:
                case JointTorque():
                    torques[:, j] += load.torque
                case JointSpring():
                    pull = law.stiffness * law.rest + load.stiffness * (load.rest - start)
                    total = law.stiffness + load.stiffness
                    law.rest = np.divide(pull, total, out=np.zeros(size), where=total > 0)
                    law.stiffness, law.damping = total, law.damping + load.damping
                case JointDamper():
                    law.damping = law.damping + load.damping
                case JointFriction():
                    law.friction, law.slip = load.friction, load.speed
                case JointLimit():
                    law.lower, law.upper = load.lower - start, load.upper - start
                    law.stop_stiffness, law.stop_damping = load.stiffness, load.damping
    return np.asarray(laws), torques


def _freedoms(system: System, tree: SpanningTree, load: JointLoad, what: str) -> tuple[list[int], float]:
    """Coordinates that a load acts along, and the joint's at the start."""
    index = system.joint_index(load.joint)
    joint = tree.of_joint(index)
    if joint is None:
        raise InputError(
            f"{what}: {system.joints[index].label} closes a loop, which is cut there.",
            remedy="Take the loads of another joint of the loop; or list this joint before others",
        )
    count = len(joint.freedoms.axes)
    if load.freedom >= count:
        label = system.joints[index].label
        raise InputError(f"{what}: {label} has {count} freedoms, and none has the number {load.freedom}.")
    if joint.freedoms.is_ball:
        if not isinstance(load, JointDamper):
            raise InputError(
                f"{what}: {system.joints[index].label} turns about a point, and has no coordinate to act along.",
                remedy="Damp it by a JointDamper, or take a load of bodies",
            )
        return [joint.first + k for k in range(3)], 0.0
    at = count - 1 - load.freedom if joint.is_reversed else load.freedom
    return [joint.first + at], float(system.joint_coordinates[index])
