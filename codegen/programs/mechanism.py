"""The driver of one mechanism: its poses by Newton's method, and Jacobians by an elimination made for it.

It depends on what hangs on what, by joints of how many freedoms, and on what is asked for; lengths and places are
numbers that come later.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

from ..errors import InputError
from ..formulas import joints, mechanics, pins
from . import Declared, Program, program, stock_algebra
from .dynamics import ALGEBRAS
from .plan import Numbered, elimination, numbered, path

_HEADERS = (
    "platform.h", "instance.h", "instance_end.h", "elementary.h", "mechanism_types.h", "dynamics_solve.h",
)  # fmt: skip


@dataclass(frozen=True)
class Link:
    """A body, and the joint towards its parent; parents come first.

    Parameters
    ----------
    parent : int
        -1: the fixed body.
    free : int
        Coordinates: those of the joint, or 6 where a joint of varying freedoms is written as rows instead.
    rows : int
        What the joint forbids; 0 for a link with 6 coordinates.
    layouts : tuple of str
        Of the objects that it shares.
    driven : bool
        Whether its coordinates are given.
    """

    parent: int
    free: int
    rows: int
    layouts: tuple[str, ...]
    driven: bool = False


@dataclass(frozen=True)
class Cut:
    """A joint that closes a loop.

    Parameters
    ----------
    a, b : int
        Its bodies; -1: the fixed one.
    rows : int
    layouts : tuple of str
    varying : bool
        Whether what it forbids changes with the pose, as the first body sees it.
    """

    a: int
    b: int
    rows: int
    layouts: tuple[str, ...]
    varying: bool = False


@dataclass(frozen=True)
class Target:
    """A pose that a body is to have, or a place for a point of it: 6 rows, or 3."""

    body: int
    rows: int


@dataclass(frozen=True)
class Needs:
    """What one mechanism has, and what is asked of it.

    Parameters
    ----------
    algebra : str
    links : tuple of Link
    cuts : tuple of Cut
    targets : tuple of Target
    columns : int
        Speeds of targets that are inputs of a Jacobian; those of driven links come before.
    outputs : tuple of int
        Bodies whose twists are asked for.
    coordinates : tuple of int
        Links whose speeds are asked for.
    """

    algebra: str
    links: tuple[Link, ...]
    cuts: tuple[Cut, ...] = ()
    targets: tuple[Target, ...] = ()
    columns: int = 0
    outputs: tuple[int, ...] = ()
    coordinates: tuple[int, ...] = ()

    def check(self) -> None:
        """Raise `InputError` for what no driver has."""
        if self.algebra not in ALGEBRAS:
            raise InputError(f"mechanisms are compiled in {' and '.join(ALGEBRAS)}, not in {self.algebra!r}.")


@cache
def mechanism_program(needs: Needs) -> Program:
    """The program of mechanisms that have just this."""
    needs.check()
    algebra = stock_algebra(needs.algebra)
    places = numbered(needs, {name: algebra.kind(name).size for name in algebra.kinds})
    motor = algebra.kind("motor").blades
    names = [*(link.layouts for link in needs.links), *(cut.layouts for cut in needs.cuts)]
    layouts = sorted({name for own in names for name in own})
    plan = elimination(needs, places)
    gone = {*places.driven, *(j for step in plan for j in range(step.first, step.first + step.free))}
    asked = [places.links[b].first + k for b in needs.coordinates for k in range(needs.links[b].free)]
    values = {
        "title": f"A mechanism of {len(needs.links)} bodies in {needs.algebra}",
        "layouts": layouts,
        "prefix": needs.algebra,
        "identity": [int(not b) for b in motor],
        "largest": max([6, *(algebra.kind(name).size for name in layouts)]),
        "p": places,
        "plan": plan,
        "columns": needs.columns,
        "outputs_rows": 6 * len(needs.outputs) + len(asked),
        "body_outputs": [(6 * i, path(needs.links, body)) for i, body in enumerate(needs.outputs)],
        "joint_outputs": [(6 * len(needs.outputs) + i, column) for i, column in enumerate(asked)],
        "kept_columns": [j for j in range(places.columns) if j not in gone],
    }
    return program(
        f"mechanism_{needs.algebra}_{len(needs.links)}", _declared(needs, layouts), "c/mechanism.c.j2",
        "c/mechanism_types.h", _HEADERS, values, options=("-O2",),
    )  # fmt: skip


def _declared(needs: Needs, layouts: list[str]) -> list[Declared]:
    found: list[Declared] = []

    def add(formula: object, kinds: str, named: str = "") -> None:
        found.append(Declared(formula, tuple(kinds.split(", ")), named, needs.algebra))  # type: ignore[arg-type]

    for formula in (joints.composed, joints.relative):
        add(formula, "motor, motor")
    add(joints.stepped, "twist, motor")
    add(joints.carrying, "motor")
    add(mechanics.adjoint, "motor")
    if any(x.rows == 6 for x in needs.targets):
        add(joints.way, "motor, motor")
    if any(x.rows == 3 for x in needs.targets):
        add(joints.point_rates, "position")
        add(joints.moved_point, "motor, position")
    for name in layouts:
        add(joints.placed, f"motor, layout {name}", f"placed_{name}")
    for name in sorted({name for cut in needs.cuts if cut.varying for name in cut.layouts}):
        add(pins.moved_rates, f"layout {name}", f"moved_rates_{name}")
    return found


__all__ = ["Cut", "Link", "Needs", "Numbered", "Target", "mechanism_program"]
