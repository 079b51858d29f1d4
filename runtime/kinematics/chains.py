"""Serial chains of joints that turn, slide or screw: poses as products of exponentials, Jacobians, twists (thesis 7.3).

Axes, tool and frames are given in the world where all joints are at zero. The loops are compiled (`chains_engine`).
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..arrays import rows, truth
from ..calls import finite, raise_first
from ..codegen.errors import AlgebraMismatchError, GradeError, InputError, ShapeError
from ..dynamics.given import number
from ..multivector import Multivector
from ..objects.inputs import chosen
from ..status import Status
from .chains_axes import joined, limits_of, names_of, parts_of
from .chains_engine import AT_ORIGIN, AT_POINT, IN_TOOL, Driver

if TYPE_CHECKING:
    from .chains_engine import Search
    from .chains_inverse import Solution
    from .chains_singular import Singularity

Array = NDArray[Any]
FRAMES = ("world", "tool")


class Chain:
    """A chain of joints from the fixed base to a tool.

    Parameters
    ----------
    axes : Multivector (n,), or list
        Of each joint the twist S that one unit of its coordinate adds, in the world where all are at zero: a unit
        line (of CGA its dual, or the line itself) for a turn in radians, a direction a n for a slide, sums for
        screws; see `revolute_axis`, `prismatic_axis` and `screw_axis`. A joint moves all that comes after it by
        exp(-q S/2).
    tool : motor, optional
        Of the tool's frame, there. Default: the world's own frame.
    names : list of str, optional
        Of the joints. Default: joint_1, joint_2, ...
    limits : array (n, 2), optional
        Least and greatest coordinate of each joint, infinite for none. `inverse` stays within them.
    frames : Multivector (n,) of motors, optional
        Of the links' frames, there; that of a link moves with its joint. Default: the world's own frame for each.
    length : float, optional
        What a radian is worth where turns and lengths are compared. Default: the lengths from joint to joint to tool.

    Attributes
    ----------
    algebra : Algebra
    names : tuple of str
    limits : array (n, 2)
    length : float
    count : int
        n.
    reach : float
        No pose has the tool's origin further from the first joint; infinite if a joint slides without limits.
    freedom : int
        Rank of the Jacobian at poses in general, 6 at most.

    Raises
    ------
    InputError, GradeError, ShapeError, AlgebraMismatchError
        If an axis is no twist or zero, a motor is none, or lengths do not fit.

    Notes
    -----
    A pose is computed as a rotor and a place seen from the first joint, so that a robot far from the world's origin is
    as exact as one there. All joints are one loop over rotors and places, linear in their number, of up to 4096.
    """

    def __init__(
        self,
        axes: Any,
        tool: Multivector | None = None,
        names: Sequence[str] | None = None,
        limits: Any = None,
        *,
        frames: Multivector | None = None,
        length: float | None = None,
    ) -> None:
        self.axes = joined(axes)
        self.algebra, self.count = self.axes.algebra, len(self.axes)
        self.tool = self._motors(tool, "tool", ())
        self.frames = self._motors(frames, "frames", (self.count,))
        self.names = names_of(names, self.count)
        self.limits = limits_of(limits, self.names)
        self._numbers, steps = parts_of(self.axes, self.tool, self.frames, self.names)
        self._searches: dict[Any, Search] = {}
        self.reach = float(steps.sum()) + self._slides()
        own = float(steps.sum()) or self.reach
        self.length = number(length, "length") if length is not None else own if 0 < own < np.inf else 1.0

    def __repr__(self) -> str:
        return f"Chain of {self.count} joints in {self.algebra.name}: {', '.join(self.names[:8])}" + (
            ", ..." if self.count > 8 else ""
        )

    def __getstate__(self) -> dict[str, Any]:
        """All but what is compiled: another process makes that again."""
        return {name: value for name, value in self.__dict__.items() if name != "_driver"}

    def __len__(self) -> int:
        return self.count

    @cached_property
    def _driver(self) -> Driver:
        return Driver(self.algebra.name, self._numbers)

    def _motors(self, given: Multivector | None, what: str, shape: tuple[int, ...]) -> Multivector:
        one = self.algebra.translator(np.zeros(3)).as_kind("motor")
        motor = one if given is None else self.as_motors(given, f"the {what}")
        if given is not None and motor.shape != shape:
            raise ShapeError(f"the {what} have shape {motor.shape}; {shape} is needed.")
        if not np.isfinite(motor.values).all():
            raise InputError(f"the {what} are not finite.")
        return motor if motor.shape == shape else motor._make(
            motor._type, np.broadcast_to(motor._data, (*shape, 8)).copy(), shape, None
        )  # fmt: skip

    def as_motors(self, x: Any, what: str) -> Multivector:
        """x on the blades of motors.

        Raises
        ------
        InputError, AlgebraMismatchError, KindError
        """
        if not isinstance(x, Multivector):
            raise InputError(f"{what}: a {type(x).__name__} is no motor.", remedy="Make it with translator and rotor")
        if x.algebra is not self.algebra:
            raise AlgebraMismatchError(f"{what}: a motor of {x.algebra.name}; the axes belong to {self.algebra.name}.")
        if x.kind.name == "motor":
            return x
        if not set(x.kind.blades) <= set(self.algebra.kind("motor").blades):
            raise GradeError(f"{what}: a {x.kind.name} is no motor.", remedy="See Multivector.as_kind('motor')")
        return x.as_kind("motor")

    def _slides(self) -> float:
        """How far joints may slide, together."""
        advance = np.abs(self._numbers.joints[:, 7])
        far = np.abs(self.limits).max(-1)
        return float(np.where(advance > 0, advance * np.where(advance > 0, far, 0), 0).sum())

    # -- poses and velocities --------------------------------------------------------------------------------

    def coordinates(self, q: ArrayLike, name: str = "q") -> Array:
        """Coordinates (..., n) as the driver takes them.

        Raises
        ------
        InputError, ShapeError
        """
        return np.asarray(rows(q, self.count, name), np.float64)

    def forward(self, q: ArrayLike, all: bool = False, *, strict: bool = False, threads: int | None = 1) -> Multivector:
        """Motor of the tool's frame, exp(-q1 S1/2) ... exp(-qn Sn/2) tool.

        Parameters
        ----------
        q : array (..., n)
        all : bool
            Of every link's frame instead: shape (..., n).
        strict : bool
            Raise for coordinates that are not finite; otherwise their items are NaN and INVALID.
        threads : int, optional
            None: all processors.

        Returns
        -------
        Multivector of motors, shape (...)
        """
        x = self.coordinates(q)
        every = truth(all, "all")
        made = self._driver.forward(x.reshape(-1, self.count), every, threads)
        shape = (*x.shape[:-1], self.count) if every else x.shape[:-1]
        return self._made("motor", made, shape, strict, "forward")

    def jacobian(
        self,
        q: ArrayLike,
        frame: str = "world",
        point: ArrayLike | None = None,
        *,
        status: bool = False,
        strict: bool = False,
        threads: int | None = 1,
    ) -> Any:
        """Matrices (..., 6, n) from joint rates to the tool's turning w (three rows) and velocity v (three rows).

        Parameters
        ----------
        q : array (..., n)
        frame : {"world", "tool"}
            Along whose axes both are. In the world v is that of the tool's point which is at the world's origin, as
            in twists w I3 + v n, in the tool's frame that of the frame's own origin.
        point : array (3,) or (..., 3), optional
            A point of the tool, in its frame, whose velocity v is instead.
        status : bool
            Return codes of `bladesmith.Status` (...), too: INVALID where a coordinate is not finite and the matrix is
            NaN.
        strict : bool
            Raise for the first such item instead.
        """
        x = self.coordinates(q)
        lead = x.shape[:-1]
        number = AT_ORIGIN if chosen(frame, FRAMES, "frame") == "world" and point is None else AT_POINT
        at = np.zeros(3) if point is None else np.asarray(rows(point, 3, "point"), np.float64)
        if at.ndim > 1:
            try:
                at = np.broadcast_to(at, (*lead, 3)).reshape(-1, 3)
            except ValueError:
                raise ShapeError(f"point has shape {at.shape}; (3,) or {(*lead, 3)} is needed.") from None
        made = self._driver.jacobian(
            x.reshape(-1, self.count), IN_TOOL if frame == "tool" else number, at, threads
        ).reshape(*lead, 6, self.count)
        if not (truth(status, "status") or truth(strict, "strict")):
            return made
        codes = np.where(np.isfinite(made).all((-1, -2)), Status.OK, Status.INVALID).astype(np.uint8)
        if strict:
            raise_first(codes, "jacobian")
        return (made, codes[()]) if status else made

    def velocity(
        self, q: ArrayLike, dq: ArrayLike, all: bool = False, *, strict: bool = False, threads: int | None = 1
    ) -> Multivector:
        """Twist of the tool in the world, or of every link (..., n): the joints' own, added up (7.13)."""
        return self._twists(q, dq, 0, all, strict, threads, "velocity")[0]

    def acceleration(
        self,
        q: ArrayLike,
        dq: ArrayLike,
        ddq: ArrayLike = 0,
        all: bool = False,
        *,
        strict: bool = False,
        threads: int | None = 1,
    ) -> Multivector:
        """Rate of `velocity` (..., or (..., n) for every link): with ``ddq`` 0 what the joints' own motion adds.

        An axis moves by (7.14), dS = S x Omega.
        """
        return self._twists(q, dq, ddq, all, strict, threads, "acceleration")[1]

    def _twists(
        self, q: ArrayLike, dq: ArrayLike, ddq: ArrayLike, every: Any, strict: bool, threads: int | None, name: str
    ) -> list[Multivector]:
        x, speeds = self.coordinates(q), self.coordinates(dq, "dq")
        pushes = np.zeros(self.count) if np.ndim(ddq) == 0 and ddq == 0 else self.coordinates(ddq, "ddq")
        try:
            given = np.broadcast_arrays(x, speeds, pushes)
        except ValueError:
            raise ShapeError(f"q, dq and ddq have shapes {x.shape}, {speeds.shape} and {pushes.shape}.") from None
        flat = [values.reshape(-1, self.count) for values in given]
        made = self._driver.twists(flat[0], flat[1], flat[2], truth(every, "all"), threads)
        lead = given[0].shape[:-1]
        shape = (*lead, self.count) if every else lead
        return [self._made("twist", rows_, shape, strict, name) for rows_ in made]

    def _made(self, kind: str, data: Array, shape: tuple[int, ...], strict: bool, name: str) -> Multivector:
        home = self.algebra.kind(kind)
        made = finite(self.algebra.wrap(home, data.reshape(*shape, home.size)))
        if strict:
            raise_first(made._status, name)
        return made

    # -- the other way ---------------------------------------------------------------------------------------

    @cached_property
    def freedom(self) -> int:
        """Rank of the Jacobian at poses in general."""
        from .chains_singular import freedom

        return freedom(self)

    def singularity(self, q: ArrayLike, *, threads: int | None = 1) -> Singularity:
        """How freely the joints move the tool at coordinates (..., n): singular values, rank, what is lost."""
        from .chains_singular import singularity

        return singularity(self, q, threads)

    def inverse(self, targets: Multivector, start: ArrayLike | None = None, **options: Any) -> Solution:
        """Coordinates that bring the tool to motors (...), from starts (..., n).

        Damped Newton steps on the turn that is missing, -2 log of its rotor, and the way, within the limits; where
        they come to rest the search starts again elsewhere. It finds one of several solutions, near the start if it
        can.

        Parameters
        ----------
        targets : Multivector of motors (...)
        start : array (n,) or (..., n), optional
            Default: zero, or where the limits leave that out their middle.
        tolerance : float
            Of the turn that is left, in radians, and of the way, in the chain's `length`. Default: 1e-12.
        iterations, attempts : int
            Steps of each attempt, 60, and how many there are, 32; the first is from ``start``.
        nearest : bool
            Keep the coordinates of least error where the target was not reached, instead of NaN.
        strict : bool
            Raise for the first target that was not reached.
        threads : int, optional
            None: all processors.

        Returns
        -------
        Solution
            ``q, status = chain.inverse(...)``, and more by name.
        """
        from .chains_inverse import inverse

        return inverse(self, targets, start, **options)
