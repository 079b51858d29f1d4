"""Dynamics of one motion at a time, for control loops: arrays that are bound once, calls of some microseconds."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...codegen.errors import InputError
from ...common.validation import real_array
from .tree import Tree

Array = NDArray[Any]


class BoundDynamics:
    """Dynamics of a chain or robot, one motion in a call; made by `JointDynamics.bound`.

    Arguments are arrays (n,) of float64 (others are converted, which takes longer). Results are arrays of the object's
    own, which the next call of the same method overwrites: copy what is to be kept. Not for several threads at once.
    """

    def __init__(self, tree: Tree, gravity: Array) -> None:
        if tree.is_shared:
            raise InputError(
                "joints share coordinates: one motion at a time is for joints with a coordinate each.",
                remedy="Call the methods of the robot itself",
            )
        n, self._order = tree.count, tree.movers
        self._shape, self._tree = (n,), tree
        self._q_shape = (tree.coordinate_count,)
        self._x = tree.positions(tree.neutral).copy()
        self._speeds, self._third, self._zero = np.zeros((3, n))
        self._forces, self._accelerations, self._matrix = np.zeros(n), np.zeros(n), np.zeros((n, n))
        motion = [gravity, self._x, self._speeds, self._third]
        driver = tree.driver
        self._kept = motion
        self._inverse, _ = driver.bind("inverse_dynamics", 1, [*motion, self._forces[None]])
        self._forward, _ = driver.bind("forward_dynamics", 1, [*motion, self._accelerations[None]])
        self._mass, _ = driver.bind("mass_matrix", 0, [self._x, self._matrix[None]])
        self._results = np.zeros((2, n)), np.zeros((n, n))
        self._grid = None if self._order is None else np.ix_(self._order, self._order)

    def inverse_dynamics(self, q: ArrayLike, qd: ArrayLike, qdd: ArrayLike) -> Array:
        """Forces (n,) of the joints that a motion takes."""
        self._take(q, qd, qdd, "qdd")
        self._inverse(0, 1)
        return self._forces if self._order is None else self._restored(self._forces, 0)

    def bias_forces(self, q: ArrayLike, qd: ArrayLike) -> Array:
        """Forces (n,) of the joints at zero acceleration."""
        return self.inverse_dynamics(q, qd, self._zero)

    def gravity_torques(self, q: ArrayLike) -> Array:
        """Forces (n,) of the joints that hold the links at rest."""
        return self.inverse_dynamics(q, self._zero, self._zero)

    def forward_dynamics(self, q: ArrayLike, qd: ArrayLike, tau: ArrayLike) -> Array:
        """Accelerations (n,) under forces of the joints; not finite where a joint moves nothing that has an inertia."""
        self._take(q, qd, tau, "tau")
        self._forward(0, 1)
        return self._accelerations if self._order is None else self._restored(self._accelerations, 1)

    def mass_matrix(self, q: ArrayLike) -> Array:
        """The matrix (n, n) of forces for a unit of acceleration of each joint."""
        if type(q) is not np.ndarray or q.shape != self._q_shape:
            q = real_array(q, "q", self._q_shape)
        self._x[...] = q if self._order is None else self._tree.positions(q)
        self._mass(0, 1)
        if self._grid is None:
            return self._matrix
        result = self._results[1]
        result[self._grid] = self._matrix
        return result

    def _take(self, q: Any, qd: Any, third: Any, name: str) -> None:
        """Copy a motion into the arrays that are bound."""
        shape, q_shape = self._shape, self._q_shape
        if not (
            type(q) is type(qd) is type(third) is np.ndarray and q.shape == q_shape and qd.shape == shape == third.shape
        ):
            given = (q, "q", q_shape), (qd, "qd", shape), (third, name, shape)
            q, qd, third = (real_array(*each[:2], each[2]) for each in given)
        order = self._order
        if order is not None:
            q, qd, third = self._tree.positions(q), qd[order], third[order]
        self._x[...] = q
        self._speeds[...] = qd
        self._third[...] = third

    def _restored(self, values: Array, which: int) -> Array:
        result: Array = self._results[0][which]
        result[self._order] = values
        return result
