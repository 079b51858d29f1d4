"""Serial chains of revolute, prismatic and screw joints: poses as products of exponentials, Jacobians, twists.

Thesis 7.3. Axes, tool and frames are given in the world where all joints are at zero.
"""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Executor
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...codegen.errors import InputError, ShapeError
from ...codegen.export.options import ExportOptions, describes_options
from ...common.progress import ProgressOption
from ...common.validation import as_bool
from ...core.multivector import Multivector
from ...mechanics.screws import geometry
from ..solutions.postures import Postures, all_solutions
from .axes import join_axes, prismatic_axis, revolute_axis
from .data import SerialChainData
from .denavit_hartenberg import dh_frames
from .inverse import Solution, inverse
from .singularity import Singularity, singularity

if TYPE_CHECKING:
    from ...core.multivector import Algebra

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
    coordinates : list of int, optional
        Index of the coordinate that moves each joint, where joints follow others: names and limits are then those of
        the coordinates, and an axis is for a unit of its coordinate. `inverse` needs a coordinate for each joint.
    target : {"c", "numba", "cuda"}
        What runs the loops: the results have the same bits. Where there is no C compiler, "c" is numba, too; "cuda"
        needs a GPU, copies there and back, and pays for very many poses.

    Attributes
    ----------
    algebra : Algebra
    names : tuple of str
    limits : array (n, 2)
    length : float
    count, joint_count : int
        Of coordinates, n, and of joints, which are as many unless some share a coordinate.
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

    @classmethod
    def from_dh(
        cls, rows: Any, convention: str = "standard", angles: str = "radians", joints: str | None = None, *,
        tool: Multivector | None = None, names: Sequence[str] | None = None, limits: Any = None,
        algebra: Algebra | None = None, target: str = "c",
    ) -> Self:  # fmt: skip
        """A chain from a table of Denavit and Hartenberg's numbers.

        Parameters
        ----------
        rows : array (n, 4), or list of mappings
            a, alpha, d, theta of each joint, in this order or by name (those left out are zero): lengths in the user's
            unit, angles as ``angles`` says. Theta, and d of a joint that translates, are where the coordinate is zero.
        convention : {"standard", "modified"}
            Standard: Rot z(theta) Trans z(d) Trans x(a) Rot x(alpha), the joint at the frame before. Modified (Craig):
            Rot x(alpha) Trans x(a) Rot z(theta) Trans z(d), the joint behind alpha and a.
        angles : {"radians", "degrees"}
        joints : str, optional
            A letter for each, R where it rotates and P where it translates. Default: all rotate.
        tool : motor, optional
            Of the tool in the last frame. Default: that frame.
        names, limits, target
            As of `Chain`; limits of rotations are in radians.
        algebra : Algebra, optional
            `bladesmith.cga3d` (default) or `pga3d`.

        Returns
        -------
        Chain
            In the frame of the table's base; `frames` are those of its links.

        Raises
        ------
        InputError, ShapeError
        """
        home = geometry(algebra)
        axes, links, translates = dh_frames(rows, convention, angles, joints)
        twists = [
            prismatic_axis(frame[:3, 2], home) if slides else revolute_axis(frame[:3, 3], frame[:3, 2], home)
            for frame, slides in zip(axes, translates, strict=True)
        ]
        frames = home.motor_from_matrix(links, strict=True).as_kind("motor")
        end = frames[len(links) - 1] if tool is None else (frames[len(links) - 1] * tool).as_kind("motor")
        return cls(join_axes(twists), end, names, limits, frames=frames, target=target)

    @describes_options
    def export(
        self, language: str, folder: str | Path, name: str = "robot", *, dtype: str = "", split: bool = False,
        overwrite: bool = False,
    ) -> list[Path]:  # fmt: skip
        """Write the chain as a source file that needs nothing of this package; see :doc:`/algebra/export`.

        It has the functions ``motor``, ``matrix`` (4, 4) of the tool's frame, and ``jacobian`` (6, n) of its origin
        along the world's axes, with the same bits as `forward` and `jacobian`; nothing is allocated.

        Parameters
        ----------
        {language}
        {folder}
        {name}
        {dtype}
        {split}
        {overwrite}

        {files}

        Raises
        ------
        InputError
            If joints share coordinates.
            {refusals}
        """
        from ...codegen.export.export import export
        from ..exporting.chains import chain_items

        options = ExportOptions(
            language, name, dtype, split, overwrite, f"a chain of the joints {', '.join(self.names)}"
        )
        if self.count != self.joint_count:
            raise InputError("joints that share a coordinate are not exported.", remedy="Give each joint one.")
        items = chain_items(self.algebra.name, self.parameters, self.names, self.limits, name)
        return export(items, folder, options)

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
        shape = (*lead, self.joint_count) if every else lead
        return [self.wrap("twist", twists, shape, strict, name) for twists in results]

    # -- inverse kinematics and singularities --------------------------------------------------------------

    def singularity(self, q: ArrayLike, *, threads: int | None = None) -> Singularity:
        """Singular values and rank of the Jacobian at coordinates (..., n), and the directions that are lost."""
        return singularity(self, q, threads)

    def inverse(
        self, targets: Multivector | ArrayLike, start: ArrayLike | None = None, *, tolerance: float = 1e-12,
        iterations: int = 60, attempts: int = 256, nearest: bool = False, strict: bool = False,
        threads: int | None = None, progress: ProgressOption = False, executor: Executor | None = None,
    ) -> Solution:  # fmt: skip
        """Coordinates that bring the tool to motors (...), from starts (..., n).

        Damped Newton steps on the rotation error, -2 log of its rotor, and the position error, within the limits; where
        they stall the search restarts elsewhere, where poses are nearest to the target first. It finds one of several
        solutions, near the start if it can. A target that it does not find is NOT_CONVERGED: more attempts may find it;
        by how much it was missed is in the result, with ``nearest`` its coordinates, too. UNREACHABLE is proved: the
        last joint would be further from the first joint than all lengths and translations together, or nearer than the
        longest length less the others; or joints with parallel axes do not allow its height or rotation.

        Parameters
        ----------
        targets : Multivector of motors (...), or array (..., 4, 4)
            Motors of cga3d or pga3d, as `bladesmith.poses` makes them, or homogeneous matrices.
        start : array (n,) or (..., n), optional
            Default: zero, or the middle of the limits where they exclude zero.
        tolerance : float
            Remaining rotation, in radians, and distance, in the chain's `length`.
        iterations, attempts : int
            Steps of each attempt, and number of attempts; the first is from ``start``. Some reachable poses at which
            arms are singular are missed with the defaults (:doc:`/motion/kinematics`).
        nearest : bool
            Keep the coordinates of least error where the target was not reached, instead of NaN: the least of
            angle^2 + (distance / length)^2 that the attempts find, which then take three times as long.
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

    def all_solutions(
        self,
        pose: Multivector | ArrayLike,
        *,
        tolerance: float = 1e-10,
        method: str | None = None,
        strict: bool = False,
    ) -> Postures:
        """Every posture of an arm of six rotations at motors (...), up to sixteen each.

        Arms with a wrist (the last or the first three axes meet in a point) and with three parallel axes (2, 3, 4 or
        3, 4, 5) are solved in closed form, others by an elimination that leads to eigenvalues. Each posture is then
        brought to the pose by Newton's method on the arm itself, so that axes that meet or are parallel to 1e-4 only,
        as in many files, cost no digits.

        Parameters
        ----------
        pose : Multivector of motors (...), or array (..., 4, 4)
            As the targets of `inverse`.
        tolerance : float
            Remaining rotation, in radians, and distance, in the chain's `length`.
        method : {"wrist", "parallel", "elimination"}, optional
            Default: the first that the arm allows.
        strict : bool
            Raise for the first pose without a posture.

        Returns
        -------
        Postures
            Angles within the limits: by whole turns as near to zero as these allow.

        Raises
        ------
        InputError
            If the chain has not six rotations, or not the closed form that ``method`` names.

        Notes
        -----
        Where the tool rests while joints move (a stretched wrist) postures are a family, of which one is given and
        marked as singular. Next to such poses postures within 1e-7 of each other may be given as one.
        """
        return all_solutions(self, pose, tolerance, method, strict)
