"""Loads on bodies: gravity, wrenches that are constant or functions, springs, and laws of a body's motion."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

from numpy.typing import ArrayLike, NDArray

from ...codegen.errors import InputError
from ...common.validation import as_function, as_instance, finite_array, positive_array
from ...core.multivector import Multivector
from ...mechanics.arguments import GRAVITY, body_number, check_body, check_coefficients, frozen_copy, vectors
from ..assembly.callbacks import arity

Array = NDArray[Any]
Wrench = Multivector | Callable[..., Any]
#: Default of fields that are arrays once they are checked.
ZERO: Any = 0.0


class Load:
    """Base class of loads; ``body`` is the name or index of a body of a `System`, 0 if there is one."""

    body: int | str = 0

    @property
    def label(self) -> str:
        """Name of its type, for messages."""
        return type(self).__name__

    def _keep(self, **values: Any) -> None:
        """Set fields to read-only copies of arrays."""
        for name, value in values.items():
            object.__setattr__(self, name, frozen_copy(value))


@dataclass(frozen=True)
class Gravity(Load):
    """Uniform acceleration of all bodies.

    Parameters
    ----------
    acceleration : array (3,)
        Acceleration in the world; that of the Earth, along -z, by default.
    """

    acceleration: Array = GRAVITY  # type: ignore[assignment]

    if TYPE_CHECKING:  # what is an array later may be given as numbers

        def __init__(self, acceleration: ArrayLike = GRAVITY) -> None: ...

    def __post_init__(self) -> None:
        self._keep(acceleration=vectors(self.acceleration, "gravity's acceleration", f"Give a vector, e.g. {GRAVITY}"))


@dataclass(frozen=True)
class BodyWrench(Load):
    """A wrench in the body's frame (origin at the center of mass), which moves with the body.

    Parameters
    ----------
    wrench : Multivector or callable
        A constant, or a function of ``(time)`` or ``(time, motor, twist)`` that returns one; the motor is the body's
        pose, the twist is in its frame. The function is called for every stage of every step.
    body : int or str
        Name or index of a body of a `System`.
    """

    wrench: Wrench
    body: int | str = 0

    def __post_init__(self) -> None:
        _check(self.wrench, "the body wrench", self.body)


@dataclass(frozen=True)
class WorldWrench(Load):
    """A wrench of the world, moments about the world's origin; parameters as those of `BodyWrench`."""

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
        In the body's frame (origin at the center of mass).
    anchor : array (3,)
        In the world, or in the frame of the other body.
    stiffness : float
        Force per length.
    length : float
        Length at rest.
    damping : float
        Force per rate of its length.
    body, other : int or str
        Bodies of a `System`; other None: the world.
    """

    point: Array
    anchor: Array
    stiffness: Array
    length: Array = ZERO
    damping: Array = ZERO
    body: int | str = 0
    other: int | str | None = None

    if TYPE_CHECKING:

        def __init__(
            self, point: ArrayLike, anchor: ArrayLike, stiffness: ArrayLike, length: ArrayLike = 0.0,
            damping: ArrayLike = 0.0, body: int | str = 0, other: int | str | None = None,
        ) -> None: ...  # fmt: skip

    def __post_init__(self) -> None:
        check_body(self.body, "the spring's body")
        check_body(self.other, "the spring's other body", world=True)
        self._keep(
            point=vectors(self.point, "the spring's point"),
            anchor=vectors(self.anchor, "the spring's anchor"),
            stiffness=finite_array(self.stiffness, "the spring's stiffness"),
            length=positive_array(self.length, "the spring's length", zero=True),
            damping=positive_array(self.damping, "the spring's damping", zero=True),
        )


class BodyLaw(Load):
    """Base class of loads whose wrench is a law of `codegen.formulas.mechanics.laws`; fields are its numbers, in order.

    All else follows from the class: what programs have, tables in files, batches, and parameters of sensitivities,
    which are called by ``kind``. Numbers of several loads of one body are added.

    Attributes
    ----------
    law, kind : str
        The law, and what files and messages call the load.
    numbers : dict of str to tuple
        What each number is, for messages, and the exponents of mass, length and time in its unit.
    """

    other: int | str | None = None
    law: ClassVar[str]
    kind: ClassVar[str]
    numbers: ClassVar[dict[str, tuple[str, tuple[int, int, int]]]]

    def __post_init__(self) -> None:
        name = self.kind.replace("_", " ")
        check_body(self.body, f"the {name}'s body")
        check_body(self.other, f"the {name}'s other body", world=True)
        self._keep(**{n: positive_array(getattr(self, n), what, zero=True) for n, (what, _) in self.numbers.items()})


@dataclass(frozen=True)
class Damper(BodyLaw):
    """Drag in proportion to the body's angular velocity and to the velocity of its center of mass.

    Parameters
    ----------
    angular : float
        Moment per angular velocity.
    linear : float
        Force per velocity.
    body, other : int or str
        Bodies of a `System`; other None: the world. Of two bodies the motion of the one as the other sees it counts, at
        its center of mass, and the other takes the counter-force.
    """

    angular: Array = ZERO
    linear: Array = ZERO
    body: int | str = 0
    other: int | str | None = None

    law, kind = "drag", "damper"
    numbers = {"angular": ("the angular damping", (1, 2, -1)), "linear": ("the linear damping", (1, 0, -1))}

    if TYPE_CHECKING:

        def __init__(
            self, angular: ArrayLike = 0.0, linear: ArrayLike = 0.0, body: int | str = 0,
            other: int | str | None = None,
        ) -> None: ...  # fmt: skip


@dataclass(frozen=True)
class QuadraticDrag(BodyLaw):
    """Drag in proportion to the squares of the body's angular velocity and of the velocity of its center of mass.

    Parameters
    ----------
    angular : float
        Moment per square of the angular velocity.
    linear : float
        Force per square of the velocity.
    body, other : int or str
        Bodies of a `System`; other None: the world. Of two bodies the motion of the one as the other sees it counts, at
        its center of mass, and the other takes the counter-force.
    """

    angular: Array = ZERO
    linear: Array = ZERO
    body: int | str = 0
    other: int | str | None = None

    law, kind = "quadratic_drag", "quadratic_drag"
    numbers = {"angular": ("the angular drag", (1, 2, 0)), "linear": ("the linear drag", (1, -1, 0))}

    if TYPE_CHECKING:

        def __init__(
            self, angular: ArrayLike = 0.0, linear: ArrayLike = 0.0, body: int | str = 0,
            other: int | str | None = None,
        ) -> None: ...  # fmt: skip


#: All of them.
BODY_LAWS: tuple[type[BodyLaw], ...] = tuple(BodyLaw.__subclasses__())


def load_names() -> list[str]:
    """Names of the types of loads."""
    return [each.__name__ for each in (Gravity, BodyWrench, WorldWrench, Spring, *BODY_LAWS)]


def _check(wrench: Any, what: str, body: Any) -> None:
    if not isinstance(wrench, Multivector):
        as_function(wrench, what, "a multivector or a function of time, or of time, motor and twist,")
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
        If one is not a load, or acts on a body that does not exist, or on nothing.
    """
    for i, load in enumerate(loads):
        *others, last = load_names()
        as_instance(load, f"loads[{i}]", Load, f"a {', '.join(others)} or {last}")
        if hasattr(load, "joint"):
            continue
        what = f"loads[{i}] ({load.label})"
        body = body_number(load.body, names, what)
        if isinstance(load, (Spring, BodyLaw)) and body_number(load.other, names, what) == body:
            raise InputError(
                f"{what} is between one body and itself: it moves nothing.",
                remedy="Name another body with other=, or leave it out for the world",
            )
