"""Makes table.json and table_query.json: 22 lines of a table as in figure 5.1 of the thesis, and the same moved.

    python examples/registration/make_table.py [--seed 5] [--noise 0] [--folder .]

The four edges of the top, four edges of each of four legs and two rails: 16 of 22 lines are parallel. A half turn about
e3 takes the table to itself, so that two motors take the query to the table.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

import bladesmith as bs
from bladesmith import registration

HERE = Path(__file__).resolve().parent
#: Metres: half sides of the top and its height; half distances of the legs, half of a leg's side, height of the rails.
HALF, HEIGHT = (0.7, 0.4), 0.75
LEGS, HALF_LEG, RAIL = (0.62, 0.32), 0.03, 0.15
CGA = bs.cga3d


def table() -> registration.Model:
    """The table about the origin, standing on the plane e1 e2."""
    x, y = HALF
    corners = np.array([(x, y, HEIGHT), (-x, y, HEIGHT), (-x, -y, HEIGHT), (x, -y, HEIGHT)])
    top = [(a, b - a) for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True)]
    signs = [(i, j) for i in (1, -1) for j in (1, -1)]
    legs = [
        ((sx * LEGS[0] + i * HALF_LEG, sy * LEGS[1] + j * HALF_LEG, 0.0), (0.0, 0.0, 1.0))
        for sx, sy in signs
        for i, j in signs
    ]
    rails = [((0.0, sign * LEGS[1], RAIL), (1.0, 0.0, 0.0)) for sign in (1, -1)]
    lines = np.round(np.array([(*a, *b) for a, b in [*top, *legs, *rails]], float), 12) + 0.0
    return registration.Model(
        lines=lines.reshape(-1, 2, 3), name="table", unit="m",
        origin="a table as in figure 5.1 of the thesis, by examples/registration/make_table.py",
    )  # fmt: skip


def moved(model: registration.Model, seed: int, noise: float) -> tuple[registration.Model, bs.Multivector]:
    """The table turned and moved anyhow, its lines shuffled and some turned round; and the motor that takes it back."""
    random = np.random.default_rng(seed)
    motor = CGA.translator(random.normal(size=3)) * CGA.rotor(random.normal(size=3), random.uniform(0, np.pi))
    rows = model.transformed(motor).parameters["line"][random.permutation(len(model))].reshape(-1, 2, 3)
    rows[:, 1] *= random.choice([-1.0, 1.0], (len(model), 1))
    rows += noise * random.normal(size=rows.shape)
    shift, angle = (
        np.array2string(np.asarray(v), precision=3) for v in (motor.to_matrix()[:3, 3], motor.parameters().angle)
    )
    origin = f"the table turned by {angle} rad and moved by {shift}, noise {noise:g}, seed {seed}; make_table.py"
    return registration.Model(lines=rows, name="table, moved", unit="m", origin=origin), ~motor


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seed", type=int, default=5)
    parser.add_argument("--noise", type=float, default=0.0, help="standard deviation of points and directions")
    parser.add_argument("--folder", type=Path, default=HERE)
    arguments = parser.parse_args()
    reference = table()
    query, back = moved(reference, arguments.seed, arguments.noise)
    reference.save(arguments.folder / "table.json")
    query.save(arguments.folder / "table_query.json")
    print(f"{reference!r}, {query!r}\nfrom the query to the table: {back}")


if __name__ == "__main__":
    main()
