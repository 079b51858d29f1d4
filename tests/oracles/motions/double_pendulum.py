"""Two rods in a plane, one below the other, by Lagrange's equations."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

#: Masses, moments of inertia about the centers, and half the length of the rods.
MASS, MOMENT, HALF = np.array([1.0, 2.0]), np.array([0.3, 0.4]), 0.5


def double_pendulum(gravity: Any, torques: Callable[[Any, Any], Any] | None = None) -> Callable[[float, Any], Any]:
    """Rates of the angles from the vertical, about y, and of their rates (4,).

    ``torques`` (2,) of both joints from their coordinates, of a rod against the one above it, and the rates of these.
    """

    def rates(_: float, y: Any) -> Any:
        p, w = y[:2], y[2:]
        coupling = MASS[1] * HALF * np.cos(p[0] - p[1])
        own = MOMENT + MASS * HALF**2 + np.array([MASS[1], 0.0])
        matrix = np.diag(own) + coupling * np.array([[0.0, 1.0], [1.0, 0.0]])
        swing = MASS[1] * HALF * np.sin(p[0] - p[1])
        lever = np.array([MASS[0] * HALF + MASS[1], MASS[1] * HALF])
        right = lever * (gravity[2] * np.sin(p) - gravity[0] * np.cos(p)) + swing * np.array([-(w[1] ** 2), w[0] ** 2])
        if torques is not None:
            first, second = torques(np.array([p[0], p[1] - p[0]]), np.array([w[0], w[1] - w[0]]))
            right += [first - second, second]
        return np.concatenate([w, np.linalg.solve(matrix, right)])

    return rates
