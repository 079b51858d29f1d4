"""Specialisation key of a dynamics driver."""

from __future__ import annotations

from dataclasses import dataclass, replace

from ...errors import InputError
from .loads import LAW_PLACES

ALGEBRAS = ("cga3d", "pga3d")
#: Loads that have kernels of their own; "user" are functions that the driver calls.
LOADS = ("gravity", "body_wrench", "world_wrench", *LAW_PLACES, "spring", "coupling", "user")
METHODS = ("chart", "rk4", "cf4", "midpoint", "composition", "adaptive", "implicit", "taylor")
CHARTS = ("exponential", "bortz", "cayley", "outer")
MODES = ("free", "subspace", "constrained")
#: Numbers of 64 bits in a wide vector.
LANES = 4


@dataclass(frozen=True)
class DynamicsConfig:
    """Algebra, number of bodies, loads, constraints and method of a simulation.

    Parameters
    ----------
    algebra : str
    bodies : int
    mode : {"free", "subspace", "constrained"}
        No constraints; pins of one body that never move, which leave it a group of motions; or any others.
    loads : tuple of str
        Of `LOADS`.
    layouts : tuple of str
        Kinds of the algebra, on whose blades pinned objects are.
    rows : int
        Equations of all constraints.
    method : str
        Of `METHODS`.
    chart : str
        Of `CHARTS`.
    callbacks : bool
        Whether functions of users are called.
    tangents, functions : int
        Directions of parameters along which the trajectory is differentiated; functions of users, where there are any
        directions.
    springs, constraints : int
        How many there are; of methods alone that keep something for each.
    turning : bool
        Whether pins leave one body all turns about a point, along whose axes there are no products of inertia.
    lanes : int
        Directions whose rates are computed at once, in C for wide vectors.
    """

    algebra: str = "cga3d"
    bodies: int = 1
    mode: str = "free"
    loads: tuple[str, ...] = ()
    layouts: tuple[str, ...] = ()
    rows: int = 0
    method: str = "rk4"
    chart: str = "exponential"
    callbacks: bool = False
    tangents: int = 0
    functions: int = 0
    springs: int = 0
    constraints: int = 0
    turning: bool = False
    lanes: int = 1

    @property
    def in_flight(self) -> bool:
        """True where nothing but gravity acts on one body that is free, or held at a point: its rotation is integrated
        by itself, unless series of its tangents are asked for."""
        free = self.mode == "free" and self.method in ("rk4", "taylor")
        held = self.mode == "subspace" and self.method == "taylor" and self.turning
        has_tangents = self.method == "taylor" and self.tangents > 0
        return self.bodies == 1 and (free or held) and set(self.loads) <= {"gravity"} and not has_tangents

    @property
    def with_lanes(self) -> DynamicsConfig:
        """The same with as many lanes as it gains from: methods in a chart step all directions together."""
        return replace(self, lanes=LANES) if self.tangents > 1 and self.method in ("chart", "adaptive") else self

    @property
    def columns(self) -> int:
        """Tangents in a state of a chart: as many as fill all lanes."""
        return -(-self.tangents // self.lanes) * self.lanes

    def check(self) -> None:
        """Raise `InputError` for what no driver has."""
        for what, value, known in (
            ("algebra", self.algebra, ALGEBRAS), ("mode", self.mode, MODES), ("integrator", self.method, METHODS),
            ("map", self.chart, CHARTS), *(("load", load, LOADS) for load in self.loads),
        ):  # fmt: skip
            if value not in known:
                raise InputError(f"{value!r} is not a {what} of the dynamics driver; there are: {', '.join(known)}.")
