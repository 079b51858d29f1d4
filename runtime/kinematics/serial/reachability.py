"""Poses that no coordinates of a chain reach, whatever the search finds: proved by lengths, heights and rotations.

Limits of joints that rotate are not used, and those of joints that translate only by their largest distance from zero:
a proof holds for any coordinates within the limits.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...core.multivector import Multivector
from .axes import translation_ranges
from .data import SerialChainData

Array = NDArray[Any]
#: Distance of a pose beyond its bound at least, as a fraction of all lengths: they and their sums are rounded.
REACH_MARGIN = 1e-9
#: Axes with at most this sine are parallel: together they change heights by less than the margin.
PARALLEL = 1e-13


def is_beyond(chain: SerialChainData, goals: Multivector, tolerance: float) -> NDArray[np.bool_]:
    """Mask (m,) of the motors that provably no coordinates bring the tool to, within a tolerance as in `Chain.inverse`.

    The pose of the tool gives that of the last joint. Its distance from the first joint is at most the sum of all
    lengths between them and all translations, and at least the longest length less the others. Along an axis to which
    the first joints are parallel, only the joints after them raise it. If all rotating joints are parallel, so is the
    tool's image of their axis.
    """
    joints, hand = chain.parameters.joints, chain.parameters.tool[:3]
    offsets, axes, rotations = joints[:, :3], joints[:, 3:6], joints[:, 6]
    home, goal = chain.algebra.matrix(chain.tool), chain.algebra.matrix(goals)
    rotation = goal[:, :3, :3] @ home[:3, :3].T  # of the tool from its pose where all joints are at zero
    position = goal[:, :3, 3] - rotation @ hand - chain.parameters.base
    lengths, slides = np.linalg.norm(offsets, axis=-1), translation_ranges(chain.parameters, chain.limits)
    distance, last = np.linalg.norm(position, axis=-1), float(np.linalg.norm(hand))
    most = lengths.sum() + slides.sum()
    slack = REACH_MARGIN * (most + last + distance) + tolerance * (chain.length + last)
    beyond = (distance > most + slack) | (distance < 2 * lengths.max() - most - slack)
    rotating = np.flatnonzero(rotations != 0)
    for a in axes[rotating[:1]] if len(rotating) else np.eye(3):
        leaves = rotating[np.linalg.norm(np.cross(axes[rotating], a), axis=-1) > PARALLEL]
        count = int(leaves[0]) if len(leaves) else chain.count  # joints that rotate about a, or not at all
        if not len(leaves):
            beyond |= np.linalg.norm(rotation @ a - a, axis=-1) > REACH_MARGIN + tolerance
        rises = np.abs(axes[:count] @ a)
        raised = (slides[:count][rises > 0] * rises[rises > 0]).sum()
        free = raised + lengths[count + 1 :].sum() + slides[count:].sum()
        beyond |= np.abs(position @ a - (offsets[: count + 1] @ a).sum()) > free + slack
    is_motion = np.abs((rotation * rotation).sum((-2, -1)) - 3) <= REACH_MARGIN  # others prove nothing
    return np.asarray(beyond & is_motion & np.isfinite(distance))


__all__ = ["REACH_MARGIN", "is_beyond"]
