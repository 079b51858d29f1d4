"""How fast loads damp motions of trees, at most: what makes explicit steps short."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.algorithms.chain_records import Joint
from ...codegen.algorithms.trees.motion_records import JointLaw, TreeBody
from ..assembly.data import Assembly
from ..assembly.decay import fastest_decay
from ..integration.integrators import MAX_IMPLICIT
from .parameters import UPPER, TreeParameters
from .spanning_tree import SpanningTree

Array = NDArray[Any]
#: Time constants of the fastest decay in a run from which on "auto" is implicit: chains of 2 to 24 rods take as long by
#: either at 1500 to 3000 of them, 48 at 3000 to 6000 (bodies under constraints, whose steps cost more, at 1e5).
STIFF = 3e3
#: Freedoms up to which "auto" is implicit: derivatives and factors of all of them are kept for each stage.
MOST_FREEDOMS = 200


def is_stiff(decay: float, freedoms: int, duration: float) -> bool:
    """Whether a run is so many times as long as the fastest decay that implicit steps take less time.

    Beyond 24 freedoms by time constants for each of them, because an implicit step costs the square of their number at
    least, and an explicit one their number.
    """
    return freedoms <= MOST_FREEDOMS and decay * duration > STIFF * max(1.0, freedoms / MAX_IMPLICIT)


def fastest_decay_of_tree(tree: SpanningTree, assembly: Assembly, parameters: TreeParameters) -> float:
    """Rate per second by which loads slow joints down, the fastest one of a batch.

    Laws of joints act between two bodies as if these were free, with their moments of inertia about the axis; limits
    count with their damping, dry friction with its slope at rest.
    """
    each = parameters.each
    laws, bodies = JointLaw.view(each["joint_laws"]), TreeBody.view(each["bodies"])
    damping = laws.damping + laws.stop_damping + laws.friction / laws.slip
    if not damping.any():
        return fastest_decay(assembly)
    turns = np.asarray(Joint.view(each["joints"]).rotation) != 0
    tensors = np.zeros((*bodies.shape[:-1], 3, 3))
    tensors[..., UPPER[0], UPPER[1]] = tensors[..., UPPER[1], UPPER[0]] = bodies.tensor
    about = np.einsum("ji,sbik,jk->sjb", tree.axes, tensors, tree.axes)
    along = np.einsum("ji,sbi->sjb", tree.axes, bodies.center)
    square = (np.asarray(bodies.center) ** 2).sum(-1)[:, None]
    mass = np.asarray(bodies.mass)[:, None]
    inverse = 1.0 / np.where(turns[..., None], about - mass * (square - along**2), mass)
    inverse = np.concatenate([inverse, np.zeros((*inverse.shape[:-1], 1))], -1)  # of the world, which is -1
    own = np.arange(tree.count)
    rates = damping * (inverse[:, own, tree.ends[:, 0]] + inverse[:, own, tree.ends[:, 1]])
    return max(fastest_decay(assembly), float(rates.max()))
