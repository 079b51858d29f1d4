"""What holds bodies: objects pinned between two frames, paths, linear functions, incidences, virtual power.

Each is A[~S V S] = H: V an object of the world (or of another body), S the motor of the body, A linear (thesis 6.7 to
6.10). For virtual power, V is a wrench that must find no power.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..codegen.errors import InputError
from ..multivector import Multivector

Array = NDArray[Any]
Function = Callable[..., Any]


class Constraint:
    """Anything that takes freedom from a body.

    Attributes
    ----------
    body : int or str
        Which body of a `System`.
    other : int, str or None
        The body in whose frame the other object is; None: the world.
    """

    body: int | str = 0
    other: int | str | None = None

    @property
    def label(self) -> str:
        """For messages."""
        return type(self).__name__


@dataclass(frozen=True)
class Pin(Constraint):
    """An object of the body that stays where an object of the world is (thesis 6.7, 6.8).

    Parameters
    ----------
    body_object : Multivector
        In the body's frame: a point, point pair, direction, flat point, line, circle, plane or sphere of CGA; a point,
        direction, line or plane of PGA.
    world_object : Multivector, optional
        The same object in the world; where it is at the start, if left out.
    body, other : int or str
        Bodies of a `System`; other None: the world.
    """

    body_object: Multivector
    world_object: Multivector | None = None
    body: int | str = 0
    other: int | str | None = None

    def __post_init__(self) -> None:
        _object(self.body_object, "the body's object")
        if self.world_object is not None:
            _object(self.world_object, "the world's object")


@dataclass(frozen=True)
class PinPath(Constraint):
    """Objects that move, in the body or in the world, pinned to each other (thesis 6.9).

    Parameters
    ----------
    body_object, world_object : Multivector or callable
        Constant, or a function of time that returns the object, or ``(V, dV, ddV)`` with its derivatives. Of a
        function that returns the object alone they are found by differences, to about 1e-12 and 1e-9 of its size.
    body, other : int or str
        Bodies of a `System`; other None: the world.
    """

    body_object: Multivector | Function
    world_object: Multivector | Function
    body: int | str = 0
    other: int | str | None = None

    def __post_init__(self) -> None:
        _object_or_function(self.body_object, "the body's object")
        _object_or_function(self.world_object, "the world's object")


@dataclass(frozen=True)
class PinLinear(Constraint):
    """A linear function of an object of the world, as the body sees it, that has a given value (thesis 6.10).

    Parameters
    ----------
    function : callable
        A[X], linear, of multivectors.
    world_object : Multivector or callable
        V: constant or a function of time, as for `PinPath`.
    target : Multivector, float or callable
        H with A[~R V R] = H(t): constant or a function of time that returns H or ``(H, dH, ddH)``.
    body, other : int or str
        Bodies of a `System`; other None: the world.
    """

    function: Function
    world_object: Multivector | Function
    target: Any = 0
    body: int | str = 0
    other: int | str | None = None

    def __post_init__(self) -> None:
        if not callable(self.function):
            raise InputError(f"the linear function is a {type(self.function).__name__}; a function is needed.")
        _object_or_function(self.world_object, "the world's object")


@dataclass(frozen=True)
class Incidence(Constraint):
    """A point of the body that stays on an object of the world.

    Parameters
    ----------
    body_point : Multivector
        In the body's frame.
    world_object : Multivector or callable
        A line, plane, circle or sphere, constant or a function of time, as for `PinPath`.
    body, other : int or str
        Bodies of a `System`; other None: the world.
    """

    body_point: Multivector
    world_object: Multivector | Function
    body: int | str = 0
    other: int | str | None = None

    def __post_init__(self) -> None:
        _object(self.body_point, "the body's point")
        _object_or_function(self.world_object, "the world's object")


@dataclass(frozen=True)
class VirtualPower(Constraint):
    """Wrenches that find no power on the body's motion (thesis 6.6): constraints on velocities.

    Parameters
    ----------
    wrenches : Multivector (n,), sequence, or callable
        Wrenches of the world, moments about its origin; a function of time, or of time, motor and twist, returns them,
        or ``(T, dT)`` with their rates.
    body, other : int or str
        Bodies of a `System`; other None: the world.
    """

    wrenches: Any
    body: int | str = 0
    other: int | str | None = None

    def __post_init__(self) -> None:
        wrenches = self.wrenches
        if isinstance(wrenches, Sequence):
            if not wrenches:
                raise InputError("VirtualPower has no wrenches; one or more are needed.")
            for i, wrench in enumerate(wrenches):
                _object(wrench, f"wrench {i}")
        else:
            _object_or_function(wrenches, "the wrenches")
            if getattr(wrenches, "shape", None) == (0,):
                raise InputError("VirtualPower has no wrenches; one or more are needed.")


def _object(x: Any, what: str) -> None:
    if not isinstance(x, Multivector):
        raise InputError(f"{what} is a {type(x).__name__}; a multivector is needed.")
    if not np.isfinite(x.values).all():
        raise InputError(f"{what} is not finite.")
    if not np.any(x.values):
        raise InputError(f"{what} is zero, and pins nothing.")


def _object_or_function(x: Any, what: str) -> None:
    if not callable(x):
        _object(x, what)
