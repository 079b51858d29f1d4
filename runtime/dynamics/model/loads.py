"""What acts on bodies: gravity, wrenches that are constant or functions, springs, dampers."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from ..codegen.errors import InputError
from ..multivector import Multivector
from .functions import arity
from .given import body_number, check_body, check_coefficients, finite, kept, positive, shown, vectors

Wrench = Multivector | Callable[..., Any]


class Load:
    """Anything that acts on a body; ``body`` is its place in a `System`, 0 where there is but one."""

    body: int | str = 0

    @property
    def label(self) -> str:
        """For messages."""
        return type(self).__name__

    def _keep(self, **values: Any) -> None:
        """Fields as checked arrays; they do not change when the caller's do."""
        for name, value in values.items():
            object.__setattr__(self, name, kept(value))


@dataclass(frozen=True)
class Gravity(Load):
    """The same acceleration for all bodies, everywhere.

    Parameters
    ----------
    acceleration : array (3,)
        In the world.
    """

    acceleration: Any

    def __post_init__(self) -> None:
        self._keep(acceleration=vectors(self.acceleration, "gravity's acceleration"))


@dataclass(frozen=True)
class BodyWrench(Load):
    """A wrench in the body's frame (origin at the centre of mass), turning and moving with the body.

    Parameters
    ----------
    wrench : Multivector or callable
        A constant, or a function of ``(time)`` or ``(time, motor, twist)`` that returns one; the motor is the body's
        pose, the twist is in its frame. The function is called for every stage of every step.
    body : int or str
        Which body of a `System`.
    """

    wrench: Wrench
    body: int | str = 0

    def __post_init__(self) -> None:
        _check(self.wrench, "the body wrench", self.body)


@dataclass(frozen=True)
class WorldWrench(Load):
    """A wrench of the world, moments about the world's origin; parameters as of `BodyWrench`."""

    wrench: Wrench
    body: int | str = 0

    def __post_init__(self) -> None:
        _check(self.wrench, "the world wrench", self.body)


@dataclass(frozen=True)
class Spring(Load):
    """A spring between a point of a body and one of the world, or of another body.

    Parameters
    ----------
    point : array (3,)
        In the body's frame (origin at the centre of mass).
    anchor : array (3,)
        In the world, or in the frame of the other body.
    stiffness : float
        Force per length.
    length : float
        At rest.
    damping : float
        Force per rate of its length.
    body, other : int or str
        Bodies of a `System`; other None: the world.
    """

    point: Any
    anchor: Any
    stiffness: Any
    length: Any = 0.0
    damping: Any = 0.0
    body: int | str = 0
    other: int | str | None = None

    def __post_init__(self) -> None:
        check_body(self.body, "the spring's body")
        check_body(self.other, "the spring's other body", world=True)
        self._keep(
            point=vectors(self.point, "the spring's point"),
            anchor=vectors(self.anchor, "the spring's anchor"),
            stiffness=finite(self.stiffness, "the spring's stiffness"),
            length=positive(self.length, "the spring's length", zero=True),
            damping=positive(self.damping, "the spring's damping", zero=True),
        )


@dataclass(frozen=True)
class Damper(Load):
    """Drag in proportion to the body's angular velocity and to the velocity of its centre of mass.

    Parameters
    ----------
    angular : float
        Moment per angular velocity.
    linear : float
        Force per velocity.
    body : int or str
        Which body of a `System`.
    """

    angular: Any = 0.0
    linear: Any = 0.0
    body: int | str = 0

    def __post_init__(self) -> None:
        check_body(self.body, "the damper's body")
        self._keep(
            angular=positive(self.angular, "the angular damping", zero=True),
            linear=positive(self.linear, "the linear damping", zero=True),
        )


def _check(wrench: Any, what: str, body: Any) -> None:
    if isinstance(wrench, type) or not (callable(wrench) or isinstance(wrench, Multivector)):
        raise InputError(
            f"{what} is {shown(wrench)}; a multivector or a function of time, or of time, motor and twist, is needed."
        )
    check_body(body, f"the body of {what}")
    if callable(wrench):
        arity(wrench, what)
    else:
        check_coefficients(wrench, what)


def check_loads(loads: Sequence[Any], names: Sequence[str]) -> None:
    """Check the loads of a simulation of bodies with these names.

    Raises
    ------
    InputError
        If one is no load, acts on a body that is not there, or on nothing: which.
    """
    for i, load in enumerate(loads):
        if not isinstance(load, Load):
            known = "Gravity, BodyWrench, WorldWrench, Spring, Damper"
            raise InputError(f"loads[{i}] is {shown(load)}, no load; there are: {known}.")
        what = f"loads[{i}] ({load.label})"
        body = body_number(load.body, names, what)
        if isinstance(load, Spring) and body_number(load.other, names, what) == body:
            raise InputError(
                f"{what} is between two points of one body: it moves nothing.",
                remedy="Name another body with other=, or leave it out for the world",
            )
