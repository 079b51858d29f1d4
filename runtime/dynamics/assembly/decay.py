"""How fast the loads of an assembly damp motions, at most: what makes explicit steps short."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.algorithms.dynamics.records import Body, Coupling, Spring
from ...codegen.programs.dynamics.loads import LAW_PLACES
from ...mechanics.twists import rotational_mask
from .data import Assembly

Array = NDArray[Any]


def fastest_decay(assembly: Assembly) -> float:
    """Rate per second by which dampers and damped springs slow bodies down, the fastest one of a batch.

    Of free bodies: that of a damper between two is by both of their masses.
    """
    numbers = assembly.parameters
    angular = rotational_mask(assembly.algebra)
    drag = LAW_PLACES["drag"].first

    def inverses(body: int) -> tuple[Array, Array]:
        """Largest inverses of moments of inertia and of masses (n,); none of the world."""
        if body < 0:
            return np.zeros(len(numbers)), np.zeros(len(numbers))
        first, count = Body.extent("inverse")
        row = numbers[:, Body.size * body + first : Body.size * body + first + count]
        return row[:, angular].max(-1), row[:, ~angular].max(-1)

    def drags(at: int) -> tuple[Array, Array]:
        return numbers[:, at + drag], numbers[:, at + drag + 1]

    rates = [np.zeros(len(numbers))]
    for i in range(len(assembly.bodies)):
        turning, moving = drags(Body.size * i + Body.offsets["laws"])
        rates += [x * y for x, y in zip((turning, moving), inverses(i), strict=True)]
    at = assembly.spring_offset
    for ends in assembly.springs:
        rates.append(numbers[:, at + Spring.offsets["damping"]] * sum(inverses(body)[1] for body in ends))
        at += Spring.size
    for ends in assembly.couplings:
        turning, moving = drags(at + Coupling.offsets["laws"])
        spins, masses = zip(*(inverses(body) for body in ends), strict=True)
        rates += [turning * sum(spins), moving * sum(masses)]
        at += Coupling.size
    return float(np.max(rates))
