"""Computations on objects without a scene: elements, frames, distances, invariants."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.algorithms.registration_layout import ELEMENT, INVARIANTS, MOTOR, POSITION, TWIST
from ...codegen.programs.registration.registration import DIRECTED, KINDS, in_order
from .interface import algorithms_of
from .model_rows import CenterRule, MatchCriterion, integers, reals, settings_of

Array = NDArray[Any]
#: Pairs that are worth another thread.
PAIRS = 8192
#: Matches that are, where each has an eigenproblem.
MATCHES = 256


class Driver:
    """Functions of objects of some kinds.

    Parameters
    ----------
    kinds : tuple of str
    threads : int, optional
    backend : str
        A name of `interface.BACKENDS`.
    """

    def __init__(self, kinds: tuple[str, ...], threads: int | None = None, backend: str = "c") -> None:
        self._algorithms = algorithms_of(backend, in_order(kinds))
        self._threads = threads

    def elements(self, kind: str, rows: Array) -> Array:
        """Positions, directions and radii (n, 7) of unit objects."""
        element = np.empty((len(rows), ELEMENT))
        each = {"row": reals(rows), "element": element}
        self._algorithms.run("elements", len(rows), each, {"kind": KINDS.index(kind)}, ("element",))
        return element

    def to_frame(self, kind: str, rows: Array, origin: Array) -> Array:
        """Coefficients (n, k) of objects in a frame at an origin (3,)."""
        found = np.empty(rows.shape)
        shared = {"kind": KINDS.index(kind), "origin": reals(origin)}
        self._algorithms.run("to_frame", len(rows), {"row": reals(rows), "found": found}, shared, ("found",))
        return found

    def motors_to_world(self, motors: Array, to: Array, back: Array) -> Array:
        """Motors (n, 8) of the world, from motors of a frame at ``back`` to a frame at ``to``."""
        found = np.empty((len(motors), MOTOR))
        each, shared = {"motor": reals(motors), "found": found}, {"to": reals(to), "back": reals(back)}
        self._algorithms.run("motors_to_world", len(motors), each, shared, ("found",))
        return found

    def twists_to_world(self, twists: Array, origin: Array) -> Array:
        """Twists (n, 6) of the world, from twists of a frame at an origin."""
        found = np.empty((len(twists), TWIST))
        each = {"twist": reals(twists), "found": found}
        self._algorithms.run("twists_to_world", len(twists), each, {"origin": reals(origin)}, ("found",))
        return found

    def step(self, motor: Array, twist: Array) -> Array:
        """The motor next to (1 + twist) motor."""
        found = np.empty(MOTOR)
        self._algorithms.run("step", 1, {}, {"motor": reals(motor), "twist": reals(twist), "found": found}, ("found",))
        return found

    def squared_distances(
        self, kind: str, a: Array, b: Array, criterion: MatchCriterion, signs: Array | None = None
    ) -> Array:
        """Weighted squared distances (..) of elements (.., 7), which broadcast. ``signs`` are relative orientations;
        without them, the criterion decides if both are allowed.
        """
        if signs is not None:
            a = a.copy()
            a[..., POSITION : 2 * POSITION] *= np.asarray(signs)[..., None]
            criterion = replace(criterion, align=False)
        shape = np.broadcast_shapes(a.shape, b.shape)
        a, b = (reals(x if x.shape == shape else np.broadcast_to(x, shape)) for x in (a, b))
        n = a.size // ELEMENT
        each = {"a": a.reshape(n, ELEMENT), "b": b.reshape(n, ELEMENT)}
        shared = {"settings": settings_of(criterion), "directed": np.array([float(kind in DIRECTED)])}
        (squares,) = self._algorithms.run("squared_distances", n, each, shared, (), self._threads, PAIRS)
        found: Array = squares.reshape(a.shape[:-1])
        return found

    def influences(self, rates: Array, whiten: Array) -> tuple[Array, Array, Array]:
        """Influences (n, 6) of matches on a twist, by their rates (n, 28) and whitened modes (6, 6); traces of their
        informations, and sums of squares of these.
        """
        each = {"rates": reals(rates), "influence": np.empty((len(rates), TWIST))}
        traces, squares = self._algorithms.run(
            "influences", len(rates), each, {"whiten": reals(whiten)}, ("influence",), self._threads, MATCHES
        )
        return each["influence"], traces, squares

    def robust_center(self, kinds: Array, elements: Array, rule: CenterRule) -> Array:
        """Center (3,) of least squared distances from all objects except outliers, by their kinds and elements."""
        n, point = len(elements), np.empty(POSITION)
        workspace = {"squares": np.empty(n), "ordered": np.empty(n), "near": np.empty(n, np.int64), "point": point}
        inputs = {"object_kinds": integers(kinds), "elements": reals(elements)}
        shared = {**inputs, **rule._asdict(), **workspace}
        self._algorithms.run("robust_center", 1, {}, shared, tuple(workspace))
        return point

    def invariants_of_all(
        self, kinds: tuple[str, str], rows: tuple[Array, Array], indices: tuple[Array, Array]
    ) -> tuple[Array, Array]:
        """Invariants (4, n) of all pairs of some objects of two kinds, of one kind each pair once, and where those of
        each object of the first kind begin.
        """
        n, m = map(len, indices)
        starts = np.arange(1, n + 1) if kinds[0] == kinds[1] else np.zeros(n, np.int64)
        ends = np.cumsum(m - starts)
        begins = ends - (m - starts)
        found = np.empty(INVARIANTS * (int(ends[-1]) if n else 0))
        each = {"row": integers(indices[0]), "start": starts, "begin": begins}
        shared: dict[str, Any] = {"first_kind": KINDS.index(kinds[0]), "second_kind": KINDS.index(kinds[1])}
        shared |= {"first_rows": reals(rows[0]).reshape(-1), "second_rows": reals(rows[1]).reshape(-1)}
        shared |= {"second": integers(indices[1]), "found": found}
        grain = max(1, PAIRS // max(m, 1))
        self._algorithms.run("invariants_of_all", n, each, shared, ("found",), self._threads, grain)
        return found.reshape(INVARIANTS, -1), begins

    def invariants(self, kinds: tuple[str, str], rows: tuple[Array, Array], indices: tuple[Array, Array]) -> Array:
        """Invariants (n, 4) of pairs of objects, by their indices in rows; kinds in the order of `KINDS`."""
        n = len(indices[0])
        found = np.empty((n, INVARIANTS))
        each = {"first": integers(indices[0]), "second": integers(indices[1]), "found": found}
        shared: dict[str, Any] = {"first_kind": KINDS.index(kinds[0]), "second_kind": KINDS.index(kinds[1])}
        shared |= {"first_rows": reals(rows[0]).reshape(-1), "second_rows": reals(rows[1]).reshape(-1)}
        self._algorithms.run("invariants", n, each, shared, ("found",), self._threads, PAIRS)
        return found
