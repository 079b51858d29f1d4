"""Linear relations of joints at many poses: a joint that follows others is driven with them."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ....codegen.errors import InputError
from ..arguments import check_coordinates
from ..structure import Assembly

Array = NDArray[Any]


def add_followers(mechanism: Assembly, driven: dict[int, Array]) -> dict[int, Array]:
    """Coordinates (..., f) of driven joints, and of those that follow them.

    Raises
    ------
    InputError
        If a coupling has a joint that is not driven, and none of the others says where it goes.
    """
    found = dict(driven)
    for j, terms in followers(mechanism, driven):
        found[j] = sum((ratio * found[leader][..., k, None] for leader, k, ratio in terms), np.zeros(1))
    return found


def followers(mechanism: Assembly, driven: Iterable[int]) -> list[tuple[int, list[tuple[int, int, float]]]]:
    """Joints that follow driven ones: each with the joints, freedoms and ratios of its displacement.

    Raises
    ------
    InputError
    """
    known, rest, found = set(driven), list(mechanism._couplings), []
    while rest:
        ready = [row for row in rest if len({j for j, _ in row} - known) <= 1]
        if not ready:
            names = [mechanism.joint_names[j] for j, _ in rest[0]]
            raise InputError(
                f"{' and '.join(dict.fromkeys(names))} are coupled, and not driven at these poses.",
                remedy=f"Drive all of them but one, such as {names[-1]!r}",
            )
        for row in ready:
            rest.remove(row)
            for j in {j for j, _ in row} - known:
                own = {k: c for (i, k), c in row.items() if i == j}
                if mechanism._joints[j].mobility != 1 or not own[0]:
                    raise InputError(
                        f"the coordinates of {mechanism.joint_names[j]} do not follow from those that are driven.",
                        remedy=f"Drive {mechanism.joint_names[j]!r}",
                    )
                check_coordinates(mechanism, j)
                found.append((j, [(i, k, -c / own[0]) for (i, k), c in row.items() if i != j]))
                known.add(j)
    return found
