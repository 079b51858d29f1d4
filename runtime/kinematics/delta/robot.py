"""The Delta robot (thesis 7.7): kinematics both ways, Jacobians and poses, in batches.

e3 points from the base to the workspace; the arms' directions s_1 = e1, s_2, s_3 run counter-clockwise about it.
The formulas are in `codegen.formulas`: `delta`, `delta_rates` and `delta_frame`.
"""

from __future__ import annotations

import math
from fractions import Fraction
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..arrays import truth
from ..codegen.errors import InputError, ShapeError
from ..objects.inputs import chosen
from . import delta_calls as calls
from .delta_answers import ELBOWS, answer, why, why_at

if TYPE_CHECKING:
    from ..dynamics.system import System
    from ..multivector import Multivector
    from .delta_geometry import JointObjects, Pose
    from .delta_motion import Motion
    from .delta_singular import Singularity
    from .delta_space import Workspace
    from .mechanism import Mechanism

Array = NDArray[Any]
#: Of a unit of length: its inverse is a number, too.
LARGEST_EXPONENT = 1000
ROOTS, METHODS = ("far", "near"), ("direct", "screw")


class DeltaRobot:
    """A Delta robot: three arms on a base, each an upper arm on a motor and two parallel forearm rods.

    Parameters
    ----------
    base_radius : float
        From the centre of the base to the motors' axes.
    effector_radius : float
        From the centre of the platform to the middle between the lower ends of an arm's rods.
    upper_arm, forearm : float
        Their lengths. Any unit of length serves, also 1e-6 or 1e3 of them.

    Raises
    ------
    InputError
        If a length is not positive, or the arms are too short to reach the platform anywhere.

    Notes
    -----
    Elbows are named by the platform's place on the e3 side of the base: "outer" is the elbow further from the e3 axis,
    the thesis's choice. It goes on being the same posture, into which the arm can move without being stretched, where
    the platform is on the other side. So is "far" the position further along e3, the thesis's choice, as long as the
    elbows run counter-clockwise about e3.

    Examples
    --------
    >>> from bladesmith import kinematics
    >>> robot = kinematics.DeltaRobot(0.4, 0.1, 0.5, 1.0)
    >>> theta = robot.inverse([0.1, -0.05, 0.9])
    >>> robot.forward(theta).round(12)
    array([ 0.1 , -0.05,  0.9 ])
    """

    def __init__(self, base_radius: float, effector_radius: float, upper_arm: float, forearm: float) -> None:
        self.base_radius = calls.length(base_radius, "base_radius")
        self.effector_radius = calls.length(effector_radius, "effector_radius")
        self.upper_arm = calls.length(upper_arm, "upper_arm")
        self.forearm = calls.length(forearm, "forearm")
        reach = abs(self.base_radius - self.effector_radius)
        if reach > self.upper_arm + self.forearm:
            raise InputError(
                f"upper_arm and forearm are {self.upper_arm + self.forearm:.6g} long together; base and platform "
                f"are {reach:.6g} apart everywhere.",
                remedy="Make the arms longer, or the radii more alike",
            )
        exponent = min(max(math.frexp(self.forearm)[1], -LARGEST_EXPONENT), LARGEST_EXPONENT)
        unit = math.ldexp(1.0, exponent)  # a power of two: nothing is rounded
        lengths = (self.base_radius - self.effector_radius, self.upper_arm, self.forearm)
        rest = Fraction(self.base_radius) - Fraction(self.effector_radius) - Fraction(lengths[0])
        self._row = np.array([*(x / unit for x in lengths), 1 / unit, unit, float(rest) / unit])
        self._plates = np.array([self.base_radius / unit, self.effector_radius / unit])

    # -- poses -------------------------------------------------------------------------------------------------

    def inverse(
        self,
        y: Any,
        elbow: Any = "outer",
        *,
        precise: bool = False,
        status: bool = False,
        strict: bool = False,
        threads: int | None = None,
    ) -> Any:
        """Angles of the motors for positions of the platform (7.7.2).

        Parameters
        ----------
        y : array (..., 3)
            Centre of the platform.
        elbow : "outer", "inner", or three of them
            Which elbow, of all arms or of each.
        precise : bool
            All digits next to singular poses, too, where angles otherwise have half of them; twice the time.
        status : bool
            Return (theta, status).
        strict : bool
            Raise for the first position that is not reached.
        threads : int, optional
            Default: as `bladesmith.set_threads` says, at first one.

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
        places = calls.rows(y, "y")
        sides = calls.signs(elbow, ELBOWS, "elbow")
        formula = "delta.inverse_precise" if truth(precise, "precise") else "delta.inverse"
        (theta,), codes = calls.evaluate(formula, [places, self._row, sides], threads)
        return answer(theta, codes, status, strict, "inverse", why_at(self, places, sides))

    def forward(
        self,
        theta: Any,
        root: str = "far",
        *,
        precise: bool = False,
        status: bool = False,
        strict: bool = False,
        threads: int | None = None,
    ) -> Any:
        """Positions of the platform for angles of the motors (7.7.2).

        Parameters
        ----------
        theta : array (..., 3)
        root : "far" or "near"
            Which of the two points where the forearms can meet.
        precise, status, strict, threads
            As of `inverse`.

        Returns
        -------
        array (..., 3), or (array, status)
            NaN where there is none. `UNREACHABLE`: the forearms do not meet. `SINGULAR`: two of them start at one
            point.
        """
        angles = calls.rows(theta, "theta")
        formula = "delta.forward_precise" if truth(precise, "precise") else "delta.forward"
        (y,), codes = calls.evaluate(formula, [angles, self._row, self._side(root)], threads)
        return answer(y, codes, status, strict, "forward", why(self, angles, root))

    def arm_status(self, y: Any, elbow: Any = "outer") -> Any:
        """`Status` of each arm (..., 3): `OK`, `UNREACHABLE`, `SINGULAR` or `INVALID`; see `inverse`."""
        operands = [calls.rows(y, "y"), self._row, calls.signs(elbow, ELBOWS, "elbow")]
        (codes,), _ = calls.evaluate("delta.arm_codes", operands)
        return codes.astype(np.uint8)

    # -- Jacobians ---------------------------------------------------------------------------------------------

    def forward_jacobian(
        self,
        theta: Any,
        method: str = "direct",
        root: str = "far",
        *,
        status: bool = False,
        strict: bool = False,
        threads: int | None = None,
    ) -> Any:
        """J with dy = J dtheta (7.7.5).

        Parameters
        ----------
        theta : array (..., 3)
        method : "direct" or "screw"
            The derivative of the solution, or the rods' forces on twists of arms and platform (7.7.4).
        root, status, strict, threads
            As of `forward`.

        Returns
        -------
        array (..., 3, 3), or (array, status)
            `SINGULAR`: the forearms lie in one plane, and the platform is free across it; see `singularity`.
        """
        angles, side = calls.rows(theta, "theta"), self._side(root)
        if chosen(method, METHODS, "method") == "screw":
            from .delta_screws import forward_jacobian

            jacobian, codes = forward_jacobian(self, angles, root)
        else:
            jacobian, codes = self._matrices("delta_rates.forward_jacobian", [angles, self._row, side], threads)
        return answer(jacobian, codes, status, strict, "forward_jacobian", why(self, angles, root))

    def inverse_jacobian(
        self,
        y: Any,
        method: str = "direct",
        elbow: Any = "outer",
        *,
        status: bool = False,
        strict: bool = False,
        threads: int | None = None,
    ) -> Any:
        """J* with dtheta = J* dy (7.7.5), the inverse of J; parameters as of `inverse` and `forward_jacobian`.

        `SINGULAR`: an arm is stretched or folded, and its forearm's direction is lost to the platform; see
        `singularity`.
        """
        places, sides = calls.rows(y, "y"), calls.signs(elbow, ELBOWS, "elbow")
        if chosen(method, METHODS, "method") == "screw":
            from .delta_screws import inverse_jacobian

            jacobian, codes = inverse_jacobian(self, places, elbow)
        else:
            jacobian, codes = self._matrices("delta_rates.inverse_jacobian", [places, self._row, sides], threads)
        return answer(jacobian, codes, status, strict, "inverse_jacobian", why_at(self, places, sides))

    # -- the whole robot ---------------------------------------------------------------------------------------

    def pose(self, theta: Any, root: str = "far") -> Pose:
        """All points of the robot at some angles: shoulders, elbows, wrists, ends of the rods (7.7.3)."""
        from .delta_geometry import pose

        return pose(self, self.forward(theta, root, precise=True), calls.rows(theta, "theta"))

    def pose_at(self, y: Any, elbow: Any = "outer") -> Pose:
        """All points of the robot at some positions of the platform."""
        from .delta_geometry import pose

        return pose(self, calls.rows(y, "y"), self.inverse(y, elbow, precise=True))

    def joint_objects(self, theta: Any, root: str = "far") -> JointObjects:
        """The geometry that its bodies share (7.7.3): the circles P_1, P_4, P_7 and the points of the ball joints."""
        from .delta_geometry import joint_objects

        return joint_objects(self, self.pose(theta, root))

    def joint_objects_at(self, y: Any, elbow: Any = "outer") -> JointObjects:
        """`joint_objects` for positions of the platform."""
        from .delta_geometry import joint_objects

        return joint_objects(self, self.pose_at(y, elbow))

    def motor_twists(self) -> Multivector:
        """Unit twists (3,) of the upper arms about their motors' axes: theta_i' of them move arm i (7.7.4)."""
        from .delta_geometry import motor_twists

        return motor_twists(self)

    def mechanism(self, theta: Any, root: str = "far") -> Mechanism:
        """The robot at one pose as a mechanism: ten bodies and the base, fifteen joints (7.7.3).

        Raises
        ------
        SingularError
            If there is no pose at these angles.
        ShapeError
            For other than one pose.
        """
        from .delta_geometry import BASE, BODIES
        from .mechanism import Mechanism

        angles = calls.rows(theta, "theta")
        if angles.shape != (3,):
            raise ShapeError(f"theta has shape {angles.shape}; a mechanism is one pose, (3,).")
        self.forward(angles, root, strict=True)
        made = Mechanism(bodies=list(BODIES), fixed=BASE)
        for joint in self.joint_objects(theta, root).joints():
            made.add(joint)
        return made

    def singularity(self, theta: Any, root: str = "far") -> Singularity:
        """How near poses are to singular ones, and the directions that are lost or left free there."""
        from .delta_singular import singularity

        return singularity(self, calls.rows(theta, "theta"), self.forward(theta, root))

    def singularity_at(self, y: Any, elbow: Any = "outer") -> Singularity:
        """`singularity` for positions of the platform."""
        from .delta_singular import singularity

        return singularity(self, self.inverse(y, elbow), calls.rows(y, "y"))

    def workspace(
        self, bounds: Any = None, points: Any = 41, elbow: Any = "outer", threads: int | None = None
    ) -> Workspace:
        """A box sampled: what is reached, and how well; see `Workspace`."""
        from .delta_space import workspace

        return workspace(self, bounds, points, elbow, threads)

    def trajectory(self, path: Any, times: Any, elbow: Any = "outer") -> Motion:
        """Angles, speeds and accelerations of the motors for a path of the platform; see `Motion`."""
        from .delta_motion import trajectory

        return trajectory(self, path, times, elbow)

    def system(self, theta: Any, masses: Any = (1.0, 0.3, 2.0), root: str = "far") -> System:
        """The robot at one pose as bodies and joints, for `dynamics.Simulation`; see `delta_system.system`."""
        from .delta_system import system

        return system(self, theta, masses, root)

    # -- inside ------------------------------------------------------------------------------------------------

    def _side(self, root: str) -> Array:
        return np.array(1.0 if chosen(root, ROOTS, "root") == ROOTS[0] else -1.0)

    def _matrices(self, formula: str, given: list[Array], threads: int | None) -> tuple[Array, Array]:
        (found,), codes = calls.evaluate(formula, given, threads)
        assert codes is not None
        return found.reshape(*found.shape[:-1], 3, 3), codes

    def __repr__(self) -> str:
        lengths = ("base_radius", "effector_radius", "upper_arm", "forearm")
        return f"DeltaRobot({', '.join(f'{name}={getattr(self, name):.6g}' for name in lengths)})"


__all__ = ["ELBOWS", "METHODS", "ROOTS", "DeltaRobot"]
