"""Constraints: objects pinned between two frames, paths, linear functions, incidences, virtual power.

Each is A[~S V S] = H: V an object of the world (or of another body), S the motor of the body, A linear (thesis 6.7 to
6.10). For virtual power, V is a wrench whose power is zero.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, Self

from ...codegen.errors import InputError
from ...common.callbacks import GuardedCallback, check_arity
from ...common.deprecation import renamed_attribute, renamed_keywords
from ...common.validation import as_function, as_instance
from ...core.multivector import Multivector
from ...mechanics.arguments import body_number, check_body
from ..assembly.callbacks import arity
from .constraint_checks import (
    check_alike,
    check_moving,
    check_moving_or_path,
    check_object,
    check_point,
    check_target,
    check_value,
    check_wrenches,
    guarded_path,
)

Function = Callable[..., Any]


class Constraint:
    """Base class of constraints on the motion of a body.

    Attributes
    ----------
    body : int or str
        Name or index of a body of a `System`.
    other : int, str or None
        Body in whose frame the other object is; None: the world.
    """

    body: int | str = 0
    other: int | str | None = None

    @property
    def label(self) -> str:
        """Name of its type, for messages."""
        return type(self).__name__

    def with_guarded_callbacks(self) -> Self:
        """This constraint with functions whose failures are reported: see `GuardedCallback`."""
        return self

    def _check_bodies(self) -> None:
        check_body(self.body, f"the body of {self.label}")
        check_body(self.other, f"the other body of {self.label}", world=True)


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
        self._check_bodies()
        check_moving(self.body_object, "the body's object")
        if self.world_object is not None:
            check_moving(self.world_object, "the world's object")
            check_alike(self.body_object, self.world_object)


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
        self._check_bodies()
        check_moving_or_path(self.body_object, "the body's object")
        check_moving_or_path(self.world_object, "the world's object")

    def with_guarded_callbacks(self) -> Self:
        objects = {"body_object": "the body's object", "world_object": "the world's object"}
        return replace(self, **{name: guarded_path(getattr(self, name), what) for name, what in objects.items()})


@renamed_keywords(target="H")
@dataclass(frozen=True)
class PinLinear(Constraint):
    """A linear function of an object of the world, as the body sees it, that has a given value (thesis 6.10).

    Parameters
    ----------
    function : callable
        A[X], linear, of multivectors.
    world_object : Multivector or callable
        V: constant or a function of time, as for `PinPath`.
    H : Multivector, float or callable
        A[~R V R] = H(t): constant or a function of time that returns H or ``(H, dH, ddH)``.
    body, other : int or str
        Bodies of a `System`; other None: the world.
    """

    function: Function
    world_object: Multivector | Function
    H: Multivector | float | Function = 0
    body: int | str = 0
    other: int | str | None = None
    target = renamed_attribute("H")

    def __post_init__(self) -> None:
        as_function(self.function, "the linear function")
        self._check_bodies()
        check_arity(self.function, (1,), "the linear function", "a function of one multivector")
        check_moving_or_path(self.world_object, "the world's object")
        if callable(self.H):
            check_arity(self.H, (1,), "the target", "a value or a function of time")
        else:
            check_value(self.H, "the target")

    def with_guarded_callbacks(self) -> Self:
        target = GuardedCallback(self.H, "the target", check_target) if callable(self.H) else self.H
        function = GuardedCallback(self.function, f"the function of {self.label}")
        return replace(
            self, function=function, world_object=guarded_path(self.world_object, "the world's object"), H=target
        )


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
        self._check_bodies()
        check_moving(self.body_point, "the body's point")
        check_point(self.body_point)
        check_moving_or_path(self.world_object, "the world's object")

    def with_guarded_callbacks(self) -> Self:
        return replace(self, world_object=guarded_path(self.world_object, "the world's object"))


@dataclass(frozen=True)
class VirtualPower(Constraint):
    """Wrenches without power on the body's motion (thesis 6.6): constraints on velocities.

    Parameters
    ----------
    wrenches : Multivector (n,), sequence, or callable
        Wrenches of the world, moments about its origin; a function of time, or of time, motor and twist, returns them,
        or ``(T, dT)`` with their rates.
    body, other : int or str
        Bodies of a `System`; other None: the world.
    """

    wrenches: Multivector | Sequence[Multivector] | Function
    body: int | str = 0
    other: int | str | None = None

    def __post_init__(self) -> None:
        self._check_bodies()
        wrenches = self.wrenches
        if callable(wrenches):
            arity(wrenches, "the function of the wrenches")
            return
        if isinstance(wrenches, Multivector) and len(wrenches.shape) > 1:
            raise InputError(f"the wrenches have shape {wrenches.shape}; one, or a row of them, is meant.")
        several = isinstance(wrenches, Sequence) and not isinstance(wrenches, str)
        if several or isinstance(wrenches, Multivector) and wrenches.shape:
            if not len(wrenches):
                raise InputError("VirtualPower has no wrenches; one or more are needed.")
            for i, wrench in enumerate(wrenches):
                check_object(wrench, f"wrench {i}")
        else:
            check_object(wrenches, "the wrench")
        if several:
            object.__setattr__(self, "wrenches", tuple(wrenches))

    def with_guarded_callbacks(self) -> Self:
        if not callable(self.wrenches):
            return self
        return replace(self, wrenches=GuardedCallback(self.wrenches, "the wrenches", check_wrenches))


#: Where an object is given in place of a constraint.
_PINNED = "An object that stays is dynamics.Pin(point)"


def check_constraints(constraints: Sequence[Any], names: Sequence[str]) -> None:
    """Check the constraints of a simulation of bodies with these names.

    Raises
    ------
    InputError
        If one is not a constraint, or its bodies do not exist or are the same.
    """
    for i, c in enumerate(constraints):
        needed = "a Pin, PinPath, PinLinear, Incidence or VirtualPower"
        as_instance(c, f"constraints[{i}]", Constraint, needed, remedy=_PINNED if isinstance(c, Multivector) else None)
        what = f"constraints[{i}] ({c.label})"
        if body_number(c.body, names, what) == body_number(c.other, names, what):
            raise InputError(f"{what} is between a body and itself; it takes a body and something else.")
