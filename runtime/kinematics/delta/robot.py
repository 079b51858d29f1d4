"""The Delta robot (thesis 7.7): kinematics both ways, Jacobians and poses, in batches.

e3 points from the base to the workspace; the arms' directions s_1 = e1, s_2, s_3 run counter-clockwise about it.
The formulas are in `codegen.formulas`: `delta`, `delta_rates` and `delta_frame`.
"""

from __future__ import annotations

from concurrent.futures import Executor
from os import PathLike
from typing import TYPE_CHECKING, Any, Literal, overload

from numpy.typing import NDArray

from ...common.progress import ProgressOption
from ...common.validation import as_bool, as_choice, real_array
from ...core.multivector import Multivector
from ...dispatch.item_statuses import array_result
from ...dispatch.multivector_data import Statuses
from ...mechanics.system import System
from ..exporting.delta import ExportedDeltaRobot
from . import geometry, solutions
from .diagnostics import explain_angles, explain_positions, forward_strictly
from .evaluation import item
from .geometry import BASE, BODIES, JointObjects, Pose
from .screw_jacobians import forward_jacobian, inverse_jacobian
from .singularity import Singularity, singularity
from .solutions import ELBOWS, ROOTS, SIGNS
from .system import system
from .trajectory import Motion, trajectory
from .workspace import Workspace, workspace

if TYPE_CHECKING:
    from ...plot.matplotlib_import import Axes3D
    from ..mechanism.mechanism import Mechanism

Array = NDArray[Any]
#: Methods of the Jacobians.
METHODS = ("direct", "screw")


class DeltaRobot(ExportedDeltaRobot):
    """A Delta robot: three arms on a base, each an upper arm on a motor and two parallel forearm rods.

    Parameters
    ----------
    base_radius : float
        From the center of the base to the motors' axes.
    effector_radius : float
        From the center of the platform to the middle between the lower ends of an arm's rods.
    upper_arm, forearm : float
        Their lengths, in any unit.

    Raises
    ------
    InputError
        If a length is not positive, or the arms are too short to reach the platform anywhere.

    Notes
    -----
    Elbows are named by the platform's place on the e3 side of the base: "outer" is the elbow further from the e3 axis,
    the thesis's choice. It goes on being the same posture, into which the arm can move without being stretched, where
    the platform is on the other side.

    Angles have two positions, mirror images in the plane of the three elbows, each moved inwards by the platform's
    radius. "far" is the one farther along e3 (7.7.1), on that plane's e3 side, and "near" the other: ``forward`` of
    ``inverse`` of a position is that position with the root on whose side it is. Where the plane becomes parallel to
    e3 both are equally far, and "far" passes from one to the other with a jump. "positive" and "negative" are named by
    the sign of `Singularity.volume`, which changes at forward singularities only, where the two are one. Each is
    continuous in the angles: the assembly mode that the robot stays in as its motors move. "far" is "positive" where
    the moved elbows, seen along e3, run counter-clockwise or lie in one line.

    Examples
    --------
    >>> from bladesmith import kinematics
    >>> robot = kinematics.DeltaRobot(0.4, 0.1, 0.5, 1.0)
    >>> theta = robot.inverse([0.1, -0.05, 0.9])
    >>> robot.forward(theta).round(12)
    array([ 0.1 , -0.05,  0.9 ])
    """

    # -- poses -------------------------------------------------------------------------------------------------

    @overload
    def inverse(
        self, y: Any, elbow: Any = ..., *, precise: bool = ...,
        status: Literal[False] = ..., strict: bool = ..., threads: int | None = ...,
    ) -> Array: ...  # fmt: skip
    @overload
    def inverse(
        self, y: Any, elbow: Any = ..., *, precise: bool = ...,
        status: Literal[True], strict: bool = ..., threads: int | None = ...,
    ) -> tuple[Array, Statuses]: ...  # fmt: skip
    def inverse(
        self,
        y: Any,
        elbow: Any = "outer",
        *,
        precise: bool = False,
        status: bool = False,
        strict: bool = False,
        threads: int | None = None,
    ) -> Array | tuple[Array, Statuses]:
        """Angles of the motors for positions of the platform (7.7.2).

        Parameters
        ----------
        y : array (..., 3)
            Center of the platform.
        elbow : "outer", "inner", or three of them
            Posture of all arms, or of each.
        precise : bool
            Full accuracy next to singular poses, too, where angles otherwise have half of the digits; twice the time.
        status : bool
            Return (theta, status).
        strict : bool
            Raise for the first position that cannot be reached.
        threads : int, optional
            Default: the package's (`bladesmith.set_threads`).

        Returns
        -------
        array (..., 3), or (array, status)
            Angles from s_i towards e3, in (-pi, pi]; NaN where there are none. `UNREACHABLE`: an arm does not reach;
            `arm_status` says which. `SINGULAR`: a wrist is on its motor's axis, and any angle would do. Positions
            within rounding of the boundary are reached.

        Raises
        ------
        InputError, ShapeError
            For bad arguments.
        SingularError
            With ``strict``, naming the position and the arm.
        """
        if precise is status is strict is False and threads is None:
            usual = item(self._bound, "delta.inverse", y, self.parameters, elbow, SIGNS)
            if usual is not None:
                return usual  # type: ignore[no-any-return]
        positions, elbows = real_array(y, "y", (..., 3)), solutions.elbow_signs(elbow)
        theta, codes = solutions.inverse(self, positions, elbows, as_bool(precise, "precise"), threads)
        return array_result(theta, codes, "inverse", status, strict, 1, explain_positions(self, positions, elbows))

    @overload
    def forward(
        self, theta: Any, root: str = ..., *, precise: bool = ...,
        status: Literal[False] = ..., strict: bool = ..., threads: int | None = ...,
    ) -> Array: ...  # fmt: skip
    @overload
    def forward(
        self, theta: Any, root: str = ..., *, precise: bool = ...,
        status: Literal[True], strict: bool = ..., threads: int | None = ...,
    ) -> tuple[Array, Statuses]: ...  # fmt: skip
    def forward(
        self,
        theta: Any,
        root: str = "far",
        *,
        precise: bool = False,
        status: bool = False,
        strict: bool = False,
        threads: int | None = None,
    ) -> Array | tuple[Array, Statuses]:
        """Positions of the platform for angles of the motors (7.7.2).

        Parameters
        ----------
        theta : array (..., 3)
            Angles of the arms, in radians.
        root : "far", "near", "positive" or "negative"
            The one of the two points where the forearms can meet that is farther along e3, or the other; or the one
            with a positive or negative volume of the forearms, continuous in theta. See `DeltaRobot`.
        precise, status, strict, threads
            As in `inverse`.

        Returns
        -------
        array (..., 3), or (array, status)
            NaN where there is none. `UNREACHABLE`: the forearms do not meet. `SINGULAR`: two of them start at one
            point.
        """
        if precise is status is strict is False and threads is None:
            usual = item(self._bound, "delta.forward", theta, self.parameters, root, ROOTS)
            if usual is not None:
                return usual  # type: ignore[no-any-return]
        angles = real_array(theta, "theta", (..., 3))
        y, codes = solutions.forward(self, angles, root, as_bool(precise, "precise"), threads)
        return array_result(y, codes, "forward", status, strict, 1, explain_angles(self, angles, root))

    def arm_status(self, y: Any, elbow: Any = "outer") -> Array:
        """`Status` of each arm (..., 3): `OK`, `UNREACHABLE`, `SINGULAR` or `INVALID`; see `inverse`."""
        return solutions.arm_codes(self, real_array(y, "y", (..., 3)), solutions.elbow_signs(elbow))

    # -- Jacobians ---------------------------------------------------------------------------------------------

    @overload
    def forward_jacobian(
        self, theta: Any, method: str = ..., root: str = ..., *,
        status: Literal[False] = ..., strict: bool = ..., threads: int | None = ...,
    ) -> Array: ...  # fmt: skip
    @overload
    def forward_jacobian(
        self, theta: Any, method: str = ..., root: str = ..., *,
        status: Literal[True], strict: bool = ..., threads: int | None = ...,
    ) -> tuple[Array, Statuses]: ...  # fmt: skip
    def forward_jacobian(
        self,
        theta: Any,
        method: str = "direct",
        root: str = "far",
        *,
        status: bool = False,
        strict: bool = False,
        threads: int | None = None,
    ) -> Array | tuple[Array, Statuses]:
        """J with dy = J dtheta (7.7.5).

        Parameters
        ----------
        theta : array (..., 3)
            Angles of the arms, in radians.
        method : "direct" or "screw"
            The derivative of the solution, or the rods' forces on twists of arms and platform (7.7.4).
        root, status, strict, threads
            As in `forward`.

        Returns
        -------
        array (..., 3, 3), or (array, status)
            `SINGULAR`: the forearms lie in one plane, and the platform is free across it; see `singularity`.
        """
        if method.__class__ is str and method == "direct" and status is strict is False and threads is None:
            usual = item(self._bound, "delta_rates.forward_jacobian", theta, self.parameters, root, ROOTS)
            if usual is not None:
                return usual.reshape(3, 3)  # type: ignore[no-any-return]
        angles, weights = real_array(theta, "theta", (..., 3)), solutions.root_weights(root)
        if as_choice(method, "method", METHODS) == "screw":
            jacobian, codes = forward_jacobian(self, angles, root)
        else:
            operands = [angles, self.parameters, weights]
            jacobian, codes = solutions.jacobians("delta_rates.forward_jacobian", operands, threads)
        reason = explain_angles(self, angles, root)
        return array_result(jacobian, codes, "forward_jacobian", status, strict, 2, reason)

    @overload
    def inverse_jacobian(
        self, y: Any, method: str = ..., elbow: Any = ..., *,
        status: Literal[False] = ..., strict: bool = ..., threads: int | None = ...,
    ) -> Array: ...  # fmt: skip
    @overload
    def inverse_jacobian(
        self, y: Any, method: str = ..., elbow: Any = ..., *,
        status: Literal[True], strict: bool = ..., threads: int | None = ...,
    ) -> tuple[Array, Statuses]: ...  # fmt: skip
    def inverse_jacobian(
        self,
        y: Any,
        method: str = "direct",
        elbow: Any = "outer",
        *,
        status: bool = False,
        strict: bool = False,
        threads: int | None = None,
    ) -> Array | tuple[Array, Statuses]:
        """J* with dtheta = J* dy (7.7.5), the inverse of J; parameters as in `inverse` and `forward_jacobian`.

        `SINGULAR`: an arm is stretched or folded, and its forearm's direction is lost to the platform; see
        `singularity`.
        """
        if method.__class__ is str and method == "direct" and status is strict is False and threads is None:
            usual = item(self._bound, "delta_rates.inverse_jacobian", y, self.parameters, elbow, SIGNS)
            if usual is not None:
                return usual.reshape(3, 3)  # type: ignore[no-any-return]
        positions, elbows = real_array(y, "y", (..., 3)), solutions.elbow_signs(elbow)
        if as_choice(method, "method", METHODS) == "screw":
            jacobian, codes = inverse_jacobian(self, positions, elbows)
        else:
            operands = [positions, self.parameters, elbows]
            jacobian, codes = solutions.jacobians("delta_rates.inverse_jacobian", operands, threads)
        reason = explain_positions(self, positions, elbows)
        return array_result(jacobian, codes, "inverse_jacobian", status, strict, 2, reason)

    # -- points, bodies and motions -------------------------------------------------------------------------------

    def pose(self, theta: Any, root: str = "far") -> Pose:
        """All points of the robot at some angles: shoulders, elbows, wrists, ends of the rods (7.7.3)."""
        return geometry.pose(self, self.forward(theta, root, precise=True), real_array(theta, "theta", (..., 3)))

    def pose_at(self, y: Any, elbow: Any = "outer") -> Pose:
        """All points of the robot at some positions of the platform."""
        return geometry.pose(self, real_array(y, "y", (..., 3)), self.inverse(y, elbow, precise=True))

    def joint_objects(self, theta: Any, root: str = "far") -> JointObjects:
        """Objects that the bodies share (7.7.3): the circles P_1, P_4, P_7 and the points of the ball joints."""
        return geometry.joint_objects(self, self.pose(theta, root))

    def joint_objects_at(self, y: Any, elbow: Any = "outer") -> JointObjects:
        """`joint_objects` for positions of the platform."""
        return geometry.joint_objects(self, self.pose_at(y, elbow))

    def motor_twists(self) -> Multivector:
        """Unit twists (3,) of the upper arms about their motors' axes: theta_i' of them move arm i (7.7.4)."""
        return geometry.motor_twists(self)

    def mechanism(self, theta: Any, root: str = "far") -> Mechanism:
        """The robot at one pose as a mechanism: ten bodies and the base, fifteen joints (7.7.3).

        Raises
        ------
        SingularError
            If there is no pose at these angles.
        ShapeError
            If theta is not one pose.
        """
        from ..mechanism.mechanism import Mechanism

        angles = real_array(theta, "theta", (3,))
        forward_strictly(self, angles, root)
        mechanism = Mechanism(bodies=list(BODIES), fixed=BASE)
        for joint in self.joint_objects(theta, root).joints():
            mechanism.add(joint)
        return mechanism

    def singularity(self, theta: Any, root: str = "far") -> Singularity:
        """Singularity measures of poses, and the directions that are lost or free there; see `Singularity`."""
        return singularity(self, real_array(theta, "theta", (..., 3)), self.forward(theta, root))

    def singularity_at(self, y: Any, elbow: Any = "outer") -> Singularity:
        """`singularity` for positions of the platform."""
        return singularity(self, self.inverse(y, elbow), real_array(y, "y", (..., 3)))

    def workspace(
        self, bounds: Any = None, points: Any = 41, elbow: Any = "outer", threads: int | None = None, *,
        progress: ProgressOption = False, executor: Executor | None = None,
    ) -> Workspace:  # fmt: skip
        """Samples of a box: reachable positions and their conditioning; see `Workspace`.

        Parameters
        ----------
        bounds : array (3, 2), optional
            Least and greatest coordinate along e1, e2, e3. Default: the box that the arms might reach on the e3 side of
            the base.
        points : int, or three of them
            Samples along each side.
        elbow
            As of `inverse`.
        threads : int, optional
            Default: the package's (`bladesmith.set_threads`). Workers of an executor use one each.
        progress : bool or callable
            True: a bar on standard error. A callable gets a `bladesmith.Progress` of positions.
        executor : concurrent.futures.Executor, optional
            Evaluates parts of the box on its workers; the results have the same bits.

        Raises
        ------
        InputError, ShapeError
            For bounds that are not a box, or numbers of samples that are not positive or too large.
        ExecutorError
            If workers of the executor fail or end, and do so again.
        Interrupted
            On an interrupt. As that of an `ExecutorError`, its ``partial`` is the samples so far: not reachable, NaN
            and INVALID where none was taken.
        """
        return workspace(self, bounds, points, elbow, threads, progress, executor)

    def trajectory(self, path: Any, times: Any, elbow: Any = "outer") -> Motion:
        """Angles, speeds and accelerations of the motors for a path of the platform.

        Parameters
        ----------
        path : callable or array (n, 3)
            Position (3,) of the platform at a time, or (y, dy, ddy) with its derivatives, which are else differences of
            order eight. Or positions at ``times``, at least six: a spline of degree five goes through them.
        times : array (n,)
            Increasing.
        elbow
            As of `inverse`.

        Raises
        ------
        InputError, ShapeError
            If the times do not increase, or the path is neither.
        """
        return trajectory(self, path, times, elbow)

    def picture(self, theta: Any = None, path: str | PathLike[str] | None = None, **options: Any) -> Axes3D:
        """Draw the robot at angles, or with ``y=`` at positions; options as of `delta.plots.picture`."""
        from .plots import picture

        return picture(self, theta, path, **options)

    def system(self, theta: Any, masses: Any = (1.0, 0.3, 2.0), root: str = "far") -> System:
        """The robot at one pose as rigid bodies and joints, for `dynamics.Simulation`; see `System`."""
        return system(self, theta, masses, root)


__all__ = ["ELBOWS", "METHODS", "ROOTS", "DeltaRobot"]
