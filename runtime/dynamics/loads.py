"""What acts on bodies: gravity, wrenches that are constant or functions, springs, dampers."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from ..codegen.errors import InputError
from ..multivector import Multivector
from .given import finite, positive, vectors

Wrench = Multivector | Callable[..., Any]


class Load:
    """Anything that acts on a body; ``body`` is its place in a `System`, 0 where there is but one."""

    body: int | str = 0


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
        found = vectors(self.acceleration, "gravity's acceleration")
        object.__setattr__(self, "acceleration", found)


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
        _check(self.wrench)


@dataclass(frozen=True)
class WorldWrench(Load):
    """A wrench of the world, moments about the world's origin; parameters as of `BodyWrench`."""

    wrench: Wrench
    body: int | str = 0

    def __post_init__(self) -> None:
        _check(self.wrench)


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
        object.__setattr__(self, "point", vectors(self.point, "the spring's point"))
        object.__setattr__(self, "anchor", vectors(self.anchor, "the spring's anchor"))
        object.__setattr__(self, "stiffness", finite(self.stiffness, "the spring's stiffness"))
        object.__setattr__(self, "length", positive(self.length, "the spring's length", zero=True))
        object.__setattr__(self, "damping", positive(self.damping, "the spring's damping", zero=True))


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
        object.__setattr__(self, "angular", positive(self.angular, "the angular damping", zero=True))
        object.__setattr__(self, "linear", positive(self.linear, "the linear damping", zero=True))


def _check(wrench: Any) -> None:
    if not (callable(wrench) or isinstance(wrench, Multivector)):
        raise InputError(
            f"a wrench is a {type(wrench).__name__}; a multivector or a function of time, or of time, motor and twist, "
            "is needed."
        )
