"""What a mechanism is to its algorithms: links, loop-closing joints, targets, inputs and outputs."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Link:
    """A body, and the joint towards its parent; parents come first.

    Parameters
    ----------
    body : int
        Its place among the motors of an item.
    parent : int
        -1: the fixed body.
    free : int
        Coordinates: those of the joint, or 6 where a joint of varying freedoms is written as rows instead.
    rows : int
        What the joint forbids; 0 for a link with 6 coordinates.
    layouts : tuple of str
        Of the objects that it shares.
    driven : tuple of bool
        Of each coordinate that is given, whether it is the same after a whole turn.
    measured : bool
        Whether those given are coordinates; else they are displacements.
    """

    body: int
    parent: int
    free: int
    rows: int
    layouts: tuple[str, ...]
    driven: tuple[bool, ...] = ()
    measured: bool = False


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
class Output:
    """Requested speeds: the twist of a body, 6 rows; the velocity of a point of it, 3; or of its coordinates, 0."""

    body: int
    rows: int


@dataclass(frozen=True)
class MechanismConfig:
    """Links, cuts and targets of a mechanism, and its inputs and outputs.

    Parameters
    ----------
    algebra : str
    links : tuple of Link
    cuts : tuple of Cut
    targets : tuple of Target
    columns : int
        Speeds of targets that are inputs of a Jacobian; those of driven links come before.
    outputs : tuple of Output
    inputs : tuple of int
        Place of each driven coordinate among the inputs of a Jacobian; default: that of its column.
    """

    algebra: str
    links: tuple[Link, ...]
    cuts: tuple[Cut, ...] = ()
    targets: tuple[Target, ...] = ()
    columns: int = 0
    outputs: tuple[Output, ...] = ()
    inputs: tuple[int, ...] = ()
