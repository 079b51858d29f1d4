"""Mobility and Jacobians of growing mechanisms: through their loops, and by the whole constraint matrix."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from ....dynamics import screw_coordinates
from ....kinematics import Mechanism, Revolute
from ...harness.algebras import cga3d
from ...harness.study import Array, Case, Errors, Method, Study, sweep_cases

BODIES, CELLS = (10.0, 30.0, 100.0, 300.0, 1000.0, 3000.0), (1.0, 3.0, 10.0, 30.0, 100.0, 300.0)
#: Bodies of what is drawn by its time: a multiple of those of a parallelogram.
SIZES = (9, 30, 99, 300, 999)
#: Singular values of a dense matrix take minutes beyond so many bodies.
MOST = 100
#: Singular values below this fraction of the largest are zero.
ZERO = 1e-9
LOST = 1.0


@dataclass(frozen=True)
class GrownMechanism:
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
        Point of the last body, whose velocity is the output.
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

    def mechanism(self) -> Mechanism:
        """Assembled."""
        return Mechanism(self.bodies, self.bodies[0], self.joints)


def chain(rng: np.random.Generator, _: int, bodies: float) -> GrownMechanism:
    """An open chain: revolute joints about random lines, each at some distance from the one before."""
    n = int(bodies)
    names = [f"body_{i}" for i in range(n + 1)]
    positions = np.cumsum(0.3 * rng.normal(size=(n + 1, 3)), axis=0)
    axes = rng.normal(size=(n, 3))
    circles = [cga3d.circle(p, d, 1.0) for p, d in zip(positions[:-1], axes, strict=True)]
    joints = [Revolute(names[i], names[i + 1], x) for i, x in enumerate(circles)]
    wide, at = axes.astype(np.longdouble), positions.astype(np.longdouble)
    wide /= np.sqrt((wide * wide).sum(-1, keepdims=True))
    columns = np.cross(wide, at[-1] - at[:-1]).T
    return GrownMechanism(names, joints, list(range(n)), wide.astype(float), positions[-1], n, columns.astype(float))


def ladder(rng: np.random.Generator, _: int, cells: float) -> GrownMechanism:
    """Parallelograms in a row, each standing on the rung of the one before: as many loops as freedoms."""
    n, up, wide = int(cells), np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0])
    angles = rng.uniform(0.4, np.pi - 0.4, n)
    cranks = 0.3 * np.stack([np.cos(angles), np.sin(angles), 0 * angles], 1)
    feet = np.concatenate([np.zeros((1, 3)), np.cumsum(cranks, axis=0)])
    names, joints, below = ["ground"], [], "ground"
    for i in range(n):
        left, right, rung = (f"{part}_{i}" for part in ("left", "right", "rung"))
        names += [left, right, rung]
        ends = ((below, left, feet[i]), (below, right, feet[i] + wide), (left, rung, feet[i + 1]),
                (right, rung, feet[i + 1] + wide))  # fmt: skip
        joints += [Revolute(a, b, cga3d.circle(p, up, 1.0)) for a, b, p in ends]
        below = rung
    jacobian = np.cross(up, np.diff(feet, axis=0)).T
    return GrownMechanism(names, joints, list(range(0, len(joints), 4)), np.tile(up, (n, 1)), feet[-1], n, jacobian)


@dataclass(frozen=True)
class Family:
    """Mechanisms of one kind, by their number of bodies.

    Attributes
    ----------
    by_size : dict of int to GrownMechanism
    """

    by_size: dict[int, GrownMechanism]

    def __len__(self) -> int:
        return 1


def family(rng: np.random.Generator, _: int, make: Any, bodies: int) -> Family:
    """All `SIZES`; each step of growth adds so many bodies."""
    return Family({size: make(rng, 1, size / bodies) for size in SIZES})


# -- methods -----------------------------------------------------------------------------------------------


def mechanism_of(inputs: GrownMechanism | Family, size: Any) -> GrownMechanism | None:
    """The mechanism itself, or the one of a family with ``size`` bodies."""
    if isinstance(inputs, Family):
        return None if size is None else inputs.by_size[size]
    return inputs if size is None else None


def run(inputs: GrownMechanism | Family, size: Any, *, solve: Any) -> tuple[GrownMechanism, Any] | None:
    """A mechanism, and the answer of a method."""
    grown = mechanism_of(inputs, size)
    answer = None if grown is None else solve(grown)
    return None if grown is None or answer is None else (grown, answer)


def by_loops(grown: GrownMechanism) -> tuple[int, Array]:
    """Public functions: assembly, mobility, Jacobian."""
    mechanism = grown.mechanism()
    joints = [grown.joints[j] for j in grown.driven]
    return mechanism.mobility(), mechanism.jacobian(joints, [(grown.bodies[-1], grown.point)])


def by_singular_values(grown: GrownMechanism) -> tuple[int, Array] | None:
    """All twists that the whole matrix allows, from its singular values; speeds of joints and point are linear in
    them."""
    if len(grown.bodies) - 1 > MOST:
        return None
    mechanism = grown.mechanism()
    matrix = mechanism.constraint_matrix().toarray()
    _, values, rows = np.linalg.svd(matrix)
    null_space = rows[int((values > ZERO * values[0]).sum()) :]
    kind = cga3d.kind("twist")
    twists = screw_coordinates(cga3d.wrap(kind, null_space.reshape(-1, len(grown.bodies) - 1, 6)))
    twists = np.concatenate([np.zeros((len(null_space), 1, 6)), twists], 1)  # the fixed body rests
    number = {name: i for i, name in enumerate(grown.bodies)}
    driven = (grown.joints[j] for j in grown.driven)
    angular = [twists[:, number[joint.b], :3] - twists[:, number[joint.a], :3] for joint in driven]
    speeds = np.einsum("jnk,jk->nj", np.array(angular), grown.axes)
    last = twists[:, -1]
    ends = last[:, 3:] + np.cross(last[:, :3], grown.point)
    return len(null_space), (np.linalg.pinv(speeds) @ ends).T


def error(answer: tuple[GrownMechanism, tuple[int, Array]], truth: Any, inputs: Any) -> Errors:
    """Relative error of the Jacobian; infinite if the mobility is wrong."""
    grown, (mobility, jacobian) = answer
    off = float(np.linalg.norm(jacobian - grown.exact) / np.linalg.norm(grown.exact))
    return np.array([off if mobility == grown.mobility and off < LOST else np.inf])


def describe(inputs: GrownMechanism | Family, i: int) -> str:
    """Size of a mechanism, or of the last one of a family."""
    grown = inputs.by_size[SIZES[-1]] if isinstance(inputs, Family) else inputs
    return f"{len(grown.bodies) - 1} bodies, {len(grown.joints)} joints, mobility {grown.mobility}"


def prepare() -> None:
    """Run both once."""
    for maker in (chain, ladder):
        grown = maker(np.random.default_rng(0), 1, 2.0)
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
            Case("chains", partial(family, make=chain, bodies=1)),
            Case("ladders of parallelograms", partial(family, make=ladder, bodies=3)),
            *sweep_cases("bodies of a chain", bodies, chain),
            *sweep_cases("parallelograms of a ladder", cells, ladder),
        ),
        reference=lambda inputs: None,  # mechanisms know what is right
        error=error,
        describe=describe,
        unit="relative",
        count=4,
        source="thesis 7.6, (7.22) to (7.25)",
        notes="Points are labelled with how many bodies there are. An item is a mechanism: assembled, mobility, its "
        "Jacobian; circles are made before. The whole matrix is left out beyond "
        f"{MOST} bodies: its time grows with the third power.",
    )


STUDY = study()
