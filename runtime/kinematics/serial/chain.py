"""Serial chains of revolute, prismatic and screw joints: poses as products of exponentials, Jacobians, twists.

Thesis 7.3. Axes, tool and frames are given in the world where all joints are at zero.
"""

from __future__ import annotations

from concurrent.futures import Executor
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...codegen.errors import ShapeError
from ...common.progress import ProgressOption
from ...common.validation import as_bool
from ...core.multivector import Multivector
from .data import SerialChainData
from .inverse import Solution, inverse
from .singularity import Singularity, singularity

Array = NDArray[Any]


class Chain(SerialChainData):
    """A chain of joints from the fixed base to a tool.

    Parameters
    ----------
    axes : Multivector (n,), or list
        Twist S of each joint for a unit of its coordinate, in the world where all are at zero: a unit line (of CGA its
        dual, or the line itself) for a rotation in radians, a direction a n for a translation, sums for screws; see
        `revolute_axis`, `prismatic_axis` and `screw_axis`. A joint moves all links after it by exp(-q S/2).
    tool : motor, optional
        Motor of the tool's frame, there. Default: the world's own frame.
    names : list of str, optional
        Names of the joints. Default: joint_1, joint_2, ...
    limits : array (n, 2), optional
        Least and greatest coordinate of each joint, infinite for none. `inverse` stays within them.
    frames : Multivector (n,) of motors, optional
        Motors of the links' frames, there; the frame of a link moves with its joint. Default: the world's frame.
    length : float, optional
        Length that a radian counts as where angles and lengths are compared. Default: the sum of the distances from
        joint to joint to tool.
    target : {"c", "numba"}
        What runs the loops: the results have the same bits. Where there is no C compiler, "c" is numba, too.

    Attributes
    ----------
    algebra : Algebra
    names : tuple of str
    limits : array (n, 2)
    length : float
    count : int
        n.
    reach : float
        Largest distance of the tool's origin from the first joint; infinite if a joint translates without limits.
    freedom : int
        Rank of the Jacobian at generic poses, 6 at most.

    Raises
    ------
    InputError, GradeError, ShapeError, AlgebraMismatchError
        If an axis is not a twist or is zero, a motor is not valid, or lengths do not match.

    Notes
    -----
    A pose is computed as a rotor and a position relative to the first joint, so that a robot far from the origin of the
    world is as exact as one there. All joints, up to 4096, are one loop over rotors and positions.
    """

    def velocity(
        self, q: ArrayLike, dq: ArrayLike, all: bool = False, *, strict: bool = False, threads: int | None = None
    ) -> Multivector:
        """Twist of the tool in the world, or of every link (..., n): the sum of the joints' twists (7.13)."""
        return self._twists(q, dq, 0, all, strict, threads, "velocity")[0]

    def acceleration(
        self,
        q: ArrayLike,
        dq: ArrayLike,
        ddq: ArrayLike = 0,
        all: bool = False,
        *,
        strict: bool = False,
        threads: int | None = None,
    ) -> Multivector:
        """Rate of `velocity` (..., or (..., n) for every link): with ``ddq`` 0 the part from the joint rates alone.

        An axis moves by (7.14), dS = S x Omega.
        """
        return self._twists(q, dq, ddq, all, strict, threads, "acceleration")[1]

    def _twists(
        self, q: ArrayLike, dq: ArrayLike, ddq: ArrayLike, every: Any, strict: bool, threads: int | None, name: str
    ) -> list[Multivector]:
        x, speeds = self.coordinates(q), self.coordinates(dq, "dq")
        pushes = np.zeros(self.count) if np.ndim(ddq) == 0 and ddq == 0 else self.coordinates(ddq, "ddq")
        try:
            operands = np.broadcast_arrays(x, speeds, pushes)
        except ValueError:
            raise ShapeError(f"q, dq and ddq have shapes {x.shape}, {speeds.shape} and {pushes.shape}.") from None
        flat = [values.reshape(-1, self.count) for values in operands]
        results = self.driver.twists(flat[0], flat[1], flat[2], as_bool(every, "all"), threads)
        lead = operands[0].shape[:-1]
        shape = (*lead, self.count) if every else lead
        return [self.wrap("twist", twists, shape, strict, name) for twists in results]

    # -- inverse kinematics and singularities --------------------------------------------------------------

    def singularity(self, q: ArrayLike, *, threads: int | None = None) -> Singularity:
        """Singular values and rank of the Jacobian at coordinates (..., n), and the directions that are lost."""
        return singularity(self, q, threads)

    def inverse(
        self, targets: Multivector, start: ArrayLike | None = None, *, tolerance: float = 1e-12, iterations: int = 60,
        attempts: int = 32, nearest: bool = False, strict: bool = False, threads: int | None = None,
        progress: ProgressOption = False, executor: Executor | None = None,
    ) -> Solution:  # fmt: skip
        """Coordinates that bring the tool to motors (...), from starts (..., n).

        Damped Newton steps on the rotation error, -2 log of its rotor, and the position error, within the limits; where
        they stall the search restarts elsewhere. It finds one of several solutions, near the start if it can. A target
        that it does not find is NOT_CONVERGED: more attempts may find it. UNREACHABLE is proved: the last joint would
        be further from the first joint than all lengths and translations together, or nearer than the longest length
        less the others; or joints with parallel axes do not allow its height or rotation.

        Parameters
        ----------
        targets : Multivector of motors (...)
        start : array (n,) or (..., n), optional
            Default: zero, or the middle of the limits where they exclude zero.
        tolerance : float
            Remaining rotation, in radians, and distance, in the chain's `length`.
        iterations, attempts : int
            Steps of each attempt, and number of attempts; the first is from ``start``. Some reachable poses are missed
            with the defaults; their fraction depends on the arm (docs/kinematics.md).
        nearest : bool
            Keep the coordinates of least error where the target was not reached, instead of NaN.
        strict : bool
            Raise for the first target that was not reached.
        threads : int, optional
            Default: the package's (`bladesmith.set_threads`); with an executor those of each call, one by default.
        progress : bool or callable
            True: a bar on standard error. A callable gets a `bladesmith.Progress` of targets.
        executor : concurrent.futures.Executor, optional
            Searches for parts of a batch on its workers; the results have the same bits.

        Returns
        -------
        Solution
            ``q, status = chain.inverse(...)``, and more by name.

        Raises
        ------
        ExecutorError
            If workers of the executor fail or end, and do so again.
        Interrupted
            On an interrupt. As that of an `ExecutorError`, its ``partial`` is the solution so far: NaN and
            NOT_CONVERGED for targets that were not looked at.
        """
        return inverse(
            self, targets, start, tolerance, iterations, attempts, nearest, strict, threads, progress, executor
        )
