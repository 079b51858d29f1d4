"""Joints that turn about a point, and roots that float, as steppers tell their states: rotation vectors."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .spanning_tree import SpanningTree

Array = NDArray[Any]
#: Of a rotor's coefficients (1, e12, e13, e23), the places and signs of the quaternion (w, x, y, z).
PLACES, SIGNS = [0, 3, 2, 1], np.array([1.0, -1.0, 1.0, -1.0])


class BallStates:
    """Coordinates of balls in a state: the compiled steps have them zero, and rotors beside.

    Parameters
    ----------
    tree : SpanningTree
    references : array (4 k,)
        Rotors of the balls in the memory of the steps.
    """

    def __init__(self, tree: SpanningTree, references: Array) -> None:
        self.places = np.flatnonzero(tree.balls >= 0)[:, None] + np.arange(3)
        self._rotors = references[: 4 * len(self.places)].reshape(-1, 4)

    def write(self, own: Array, known: tuple[Array, Array] | None) -> None:
        """Rotation vectors in a state become rotors; those that a step gave are taken as it left them."""
        vectors = own[self.places]
        if known is not None and np.array_equal(vectors, known[0]):
            self._rotors[...] = known[1]
        else:
            half = np.sqrt((vectors * vectors).sum(-1, keepdims=True)) / 2
            parts = np.concatenate([np.cos(half), np.sinc(half / np.pi) / 2 * vectors], -1)
            self._rotors[...] = (SIGNS * parts)[:, PLACES]
        own[self.places] = 0.0

    def read(self, own: Array) -> tuple[Array, Array]:
        """Rotors become rotation vectors (k, 3), of half a turn at most; both, to be known again."""
        rotors = self._rotors.copy()
        parts = rotors[:, PLACES] * SIGNS
        parts *= np.copysign(1.0, parts[:, :1])
        size = np.sqrt((parts[:, 1:] ** 2).sum(-1, keepdims=True))
        angle = 2 * np.arctan2(size, parts[:, :1])
        vectors = parts[:, 1:] * np.divide(angle, size, out=np.full_like(size, 2.0), where=size > 0)
        own[self.places] = vectors
        return vectors, rotors
