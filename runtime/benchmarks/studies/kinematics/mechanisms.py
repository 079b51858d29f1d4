"""Mobility and Jacobians of growing mechanisms: through their loops, and by the whole constraint matrix."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..study import Case, Errors, Method, Study, swept

Array = NDArray[Any]
BODIES, CELLS = (10.0, 30.0, 100.0, 300.0, 1000.0, 3000.0), (1.0, 3.0, 10.0, 30.0, 100.0, 300.0)
#: Bodies of what is drawn by its time: a multiple of those of a parallelogram.
SIZES = (9, 30, 99, 300, 999)
#: Singular values of a dense matrix take minutes beyond so many bodies.
MOST = 100
#: Singular values below this share of the largest are zero.
ZERO = 1e-9
LOST = 1.0


@dataclass(frozen=True)
class Grown:
    """A mechanism.

    Attributes
    ----------
    bodies : list of str
        The first is fixed.
    joints : list of Revolute
    driven : list of int
        Joints that are inputs.
    axes : array (driven, 3)
        Theirs.
    point : array (3,)
        Of the last body, whose velocity is the output.
    mobility : int
    exact : array (3, driven)
        The Jacobian.
    """

    bodies: list[str]
    joints: list[Any]
    driven: list[int]
    axes: Array
    point: Array
    mobility: int
    exact: Array

    def __len__(self) -> int:
        return 1

    def mechanism(self) -> Any:
        """Assembled."""
        from ...kinematics import Mechanism

        return Mechanism(self.bodies, self.bodies[0], self.joints)


def chain(bodies: float) -> Any:
    """Maker of an open chain: turns about random lines, each some way from the one before."""

    def make(rng: np.random.Generator, count: int) -> Grown:
        from ... import cga3d
        from ...kinematics import Revolute

        n = int(bodies)
        names = [f"body_{i}" for i in range(n + 1)]
        places = np.cumsum(0.3 * rng.normal(size=(n + 1, 3)), axis=0)
        axes = rng.normal(size=(n, 3))
        circles = [cga3d.circle(p, d, 1.0) for p, d in zip(places[:-1], axes, strict=True)]
        joints = [Revolute(names[i], names[i + 1], x) for i, x in enumerate(circles)]
        wide, at = axes.astype(np.longdouble), places.astype(np.longdouble)
        wide /= np.sqrt((wide * wide).sum(-1, keepdims=True))
        columns = np.cross(wide, at[-1] - at[:-1]).T
        return Grown(names, joints, list(range(n)), wide.astype(float), places[-1], n, columns.astype(float))

    return make


def ladder(cells: float) -> Any:
    """Maker of parallelograms in a row, each standing on the rung of the one before: as many loops as freedoms."""

    def make(rng: np.random.Generator, count: int) -> Grown:
        from ... import cga3d
        from ...kinematics import Revolute

        n, up, wide = int(cells), np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0])
        angles = rng.uniform(0.4, np.pi - 0.4, n)
        cranks = 0.3 * np.stack([np.cos(angles), np.sin(angles), 0 * angles], 1)
        feet = np.concatenate([np.zeros((1, 3)), np.cumsum(cranks, axis=0)])
        names, joints, below = ["ground"], [], "ground"
        for i in range(n):
            left, right, rung = (f"{what}_{i}" for what in ("left", "right", "rung"))
            names += [left, right, rung]
            ends = ((below, left, feet[i]), (below, right, feet[i] + wide), (left, rung, feet[i + 1]),
                    (right, rung, feet[i + 1] + wide))  # fmt: skip
            joints += [Revolute(a, b, cga3d.circle(p, up, 1.0)) for a, b, p in ends]
            below = rung
        driven = list(range(0, len(joints), 4))
        return Grown(names, joints, driven, np.tile(up, (n, 1)), feet[-1], n, np.cross(up, np.diff(feet, axis=0)).T)

    return make


@dataclass(frozen=True)
class Family:
    """Mechanisms of one kind, by their number of bodies.

    Attributes
    ----------
    by_size : dict of int to Grown
    """

    by_size: dict[int, Grown]

    def __len__(self) -> int:
        return 1


def family(make: Any, bodies: int) -> Any:
    """Maker of all `SIZES`; each step of growth adds so many bodies."""

    def made(rng: np.random.Generator, count: int) -> Family:
        return Family({size: make(size / bodies)(rng, 1) for size in SIZES})

    return made


# -- methods -----------------------------------------------------------------------------------------------


def chosen(inputs: Grown | Family, size: Any) -> Grown | None:
    """The mechanism itself, or that of a family that has so many bodies."""
    if isinstance(inputs, Family):
        return None if size is None else inputs.by_size[size]
    return inputs if size is None else None


def run(inputs: Grown | Family, size: Any, *, solve: Any) -> tuple[Grown, Any] | None:
    """A mechanism, and what was found."""
    grown = chosen(inputs, size)
    answer = None if grown is None else solve(grown)
    return None if grown is None or answer is None else (grown, answer)


def by_loops(grown: Grown) -> tuple[int, Array]:
    """As users do it: assembled, mobility, Jacobian."""
    mechanism = grown.mechanism()
    joints = [grown.joints[j] for j in grown.driven]
    return mechanism.mobility(), mechanism.jacobian(joints, [(grown.bodies[-1], grown.point)])


def by_singular_values(grown: Grown) -> tuple[int, Array] | None:
    """All twists that the whole matrix allows, from its singular values; speeds of joints and point are linear in
    them."""
    from ... import cga3d
    from ...dynamics import screw_coordinates

    if len(grown.bodies) - 1 > MOST:
        return None
    mechanism = grown.mechanism()
    matrix = mechanism.constraint_matrix().toarray()
    _, values, rows = np.linalg.svd(matrix)
    free = rows[int((values > ZERO * values[0]).sum()) :]
    kind = cga3d.kind("twist")
    twists = screw_coordinates(cga3d.wrap(kind, free.reshape(-1, len(grown.bodies) - 1, 6)))
    twists = np.concatenate([np.zeros((len(free), 1, 6)), twists], 1)  # the fixed body rests
    number = {name: i for i, name in enumerate(grown.bodies)}
    turns = [twists[:, number[grown.joints[j].b], :3] - twists[:, number[grown.joints[j].a], :3] for j in grown.driven]
    speeds = np.einsum("jnk,jk->nj", np.array(turns), grown.axes)
    last = twists[:, -1]
    ends = last[:, 3:] + np.cross(last[:, :3], grown.point)
    return len(free), (np.linalg.pinv(speeds) @ ends).T


def error(found: tuple[Grown, tuple[int, Array]], truth: Any, inputs: Any) -> Errors:
    """Of the Jacobian, relative; infinite if the mobility is wrong. A mechanism knows its own."""
    grown, (mobility, jacobian) = found
    off = float(np.linalg.norm(jacobian - grown.exact) / np.linalg.norm(grown.exact))
    return np.array([off if mobility == grown.mobility and off < LOST else np.inf])


def describe(inputs: Grown | Family, i: int) -> str:
    """How large it is; of a family the last."""
    grown = inputs.by_size[SIZES[-1]] if isinstance(inputs, Family) else inputs
    return f"{len(grown.bodies) - 1} bodies, {len(grown.joints)} joints, mobility {grown.mobility}"


def prepare() -> None:
    """Run both once."""
    for maker in (chain, ladder):
        grown = maker(2.0)(np.random.default_rng(0), 1)
        by_loops(grown), by_singular_values(grown)


def study(bodies: Sequence[float] = BODIES, cells: Sequence[float] = CELLS) -> Study:
    """The study for mechanisms of other sizes."""
    return Study(
        name="mechanisms",
        title="Mobility and Jacobians of growing mechanisms",
        methods=tuple(
            Method(name, partial(run, solve=solve), "bodies", (None, *SIZES), most=1, repeats=0, prepare=prepare)
            for name, solve in (
                ("through loops", by_loops),
                ("singular values of the whole matrix", by_singular_values),
            )
        ),
        cases=(
            Case("chains", family(chain, 1), describe=describe),
            Case("ladders of parallelograms", family(ladder, 3), describe=describe),
            *swept("bodies of a chain", bodies, chain, describe),
            *swept("parallelograms of a ladder", cells, ladder, describe),
        ),
        reference=lambda inputs: None,  # mechanisms know what is right
        error=error,
        unit="relative",
        count=4,
        source="thesis 7.6, (7.22) to (7.25)",
        notes="Points are labelled with how many bodies there are. An item is a mechanism: assembled, mobility, its "
        "Jacobian; circles are made before. The whole matrix is left out beyond "
        f"{MOST} bodies: its time grows with the third power.",
    )


STUDY = study()
