"""Loads on joints: torques, springs, dampers, friction, limits; forces where a joint translates."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...codegen.errors import InputError
from ...common.validation import finite_array, positive_array, real_array
from ...mechanics.joints.base import Joint
from .loads import ZERO, Load

Array = NDArray[Any]


class JointLoad(Load):
    """Base class of loads along the freedoms of a joint: on its second body, and against its first.

    Attributes
    ----------
    joint : Joint, str or int
        One of the system's joints, its name or its index.
    freedom : int
        Number of the freedom, as in `Trajectory.coordinates`.
    numbers : tuple of str
        Fields that are finite numbers, or one for each simulation of a batch.
    """

    joint: Joint | str | int
    freedom: int = 0
    numbers: ClassVar[tuple[str, ...]]

    @property
    def shapes(self) -> list[tuple[int, ...]]:
        """Batches of its numbers."""
        return [value.shape for value in vars(self).values() if isinstance(value, np.ndarray)]

    def _over_time(self, name: str, like: Array) -> Array:
        """Numbers of each simulation, with an axis for the states."""
        value: Array = getattr(self, name)
        return value[:, None] if value.ndim and np.ndim(like) > 1 else value

    def _check(self, positive: tuple[str, ...]) -> None:
        if not isinstance(self.freedom, int) or isinstance(self.freedom, bool) or self.freedom < 0:
            raise InputError(f"the freedom of a {self.label} is {self.freedom!r}; it is a number from 0.")
        for name in self.numbers:
            what = f"the {name.replace('_', ' ')} of a {self.label}"
            value = getattr(self, name)
            checked = positive_array(value, what, zero=True) if name in positive else finite_array(value, what)
            self._keep(**{name: checked})


@dataclass(frozen=True)
class JointTorque(JointLoad):
    """A constant torque, or a force of a joint that translates. What changes from step to step is for a stepper.

    Parameters
    ----------
    joint : Joint, str or int
    torque : float
    freedom : int
    """

    joint: Joint | str | int
    torque: Array
    freedom: int = 0
    numbers = ("torque",)

    if TYPE_CHECKING:

        def __init__(self, joint: Joint | str | int, torque: ArrayLike, freedom: int = 0) -> None: ...

    def __post_init__(self) -> None:
        self._check(())


@dataclass(frozen=True)
class JointSpring(JointLoad):
    """A spring along a joint's coordinate, -stiffness (x - rest) - damping dx.

    Parameters
    ----------
    joint : Joint, str or int
    stiffness : float
        Torque per radian, or force per length.
    rest : float
        Coordinate where it pulls nowhere.
    damping : float
    freedom : int
    """

    joint: Joint | str | int
    stiffness: Array
    rest: Array = ZERO
    damping: Array = ZERO
    freedom: int = 0
    numbers = ("stiffness", "rest", "damping")

    if TYPE_CHECKING:

        def __init__(
            self, joint: Joint | str | int, stiffness: ArrayLike, rest: ArrayLike = 0.0, damping: ArrayLike = 0.0,
            freedom: int = 0,
        ) -> None: ...  # fmt: skip

    def __post_init__(self) -> None:
        self._check(("stiffness", "damping"))

    def energy(self, coordinate: Array) -> Array:
        """Half the stiffness times the square of the stretch."""
        stiffness, rest = (self._over_time(name, coordinate) for name in ("stiffness", "rest"))
        return np.asarray(stiffness * (coordinate - rest) ** 2 / 2)


@dataclass(frozen=True)
class JointDamper(JointLoad):
    """Viscous friction of a joint, -damping dx.

    Parameters
    ----------
    joint : Joint, str or int
    damping : float
        Torque per radian per second, or force per speed.
    freedom : int
        Of a spherical joint all three are damped alike.
    """

    joint: Joint | str | int
    damping: Array
    freedom: int = 0
    numbers = ("damping",)

    if TYPE_CHECKING:

        def __init__(self, joint: Joint | str | int, damping: ArrayLike, freedom: int = 0) -> None: ...

    def __post_init__(self) -> None:
        self._check(("damping",))


@dataclass(frozen=True)
class JointFriction(JointLoad):
    """Dry friction of a joint, -friction dx/sqrt(dx^2 + speed^2): Coulomb's, without the jump where it stands still.

    A joint that sticks creeps: at a load of a tenth of the friction with a tenth of ``speed``.

    Parameters
    ----------
    joint : Joint, str or int
    friction : float
        Torque, or force, of a joint that moves.
    speed : float
        Speed at which it is 0.7 of that.
    freedom : int
    """

    joint: Joint | str | int
    friction: Array
    speed: Array = 1e-2  # type: ignore[assignment]
    freedom: int = 0
    numbers = ("friction", "speed")

    if TYPE_CHECKING:

        def __init__(
            self, joint: Joint | str | int, friction: ArrayLike, speed: ArrayLike = 1e-2, freedom: int = 0
        ) -> None: ...

    def __post_init__(self) -> None:
        self._check(("friction",))
        self._keep(speed=positive_array(self.speed, "the speed of a JointFriction"))


@dataclass(frozen=True)
class JointLimit(JointLoad):
    """Limits of a joint's coordinate, as springs that press back beyond them.

    Parameters
    ----------
    joint : Joint, str or int
    lower, upper : float
        Infinite ones are none.
    stiffness : float
        Torque per radian, or force per length, beyond a limit.
    damping : float
        While a limit is pressed.
    freedom : int
    """

    joint: Joint | str | int
    lower: Array
    upper: Array
    stiffness: Array
    damping: Array = ZERO
    freedom: int = 0
    numbers = ("stiffness", "damping")

    if TYPE_CHECKING:

        def __init__(
            self, joint: Joint | str | int, lower: ArrayLike, upper: ArrayLike, stiffness: ArrayLike,
            damping: ArrayLike = 0.0, freedom: int = 0,
        ) -> None: ...  # fmt: skip

    def __post_init__(self) -> None:
        self._check(("stiffness", "damping"))
        low, high = (real_array(getattr(self, x), f"the {x} limit of a joint") for x in ("lower", "upper"))
        if not (low <= high).all():  # nor what is not a number
            raise InputError(f"limits of a joint are {low} and {high}; the lower one is below the upper one.")
        self._keep(lower=np.asarray(low, np.float64), upper=np.asarray(high, np.float64))

    def energy(self, coordinate: Array) -> Array:
        """Half the stiffness times the square of what is beyond a limit."""
        low, high, stiffness = (self._over_time(name, coordinate) for name in ("lower", "upper", "stiffness"))
        over = np.maximum(coordinate - high, 0.0) + np.maximum(low - coordinate, 0.0)
        return np.asarray(stiffness * over**2 / 2)
