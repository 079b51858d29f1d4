"""Draws the figures of thesis chapter 5: the table and its copy, what the stages make of them, mixed random models; and
the room of the segments.

    python examples/registration/figures.py --out registration

Needs the extra `plot`.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

import bladesmith as bs
from bladesmith import plot, registration

HERE = Path(__file__).resolve().parent
CGA = bs.cga3d
BLACK, RED, BLUE, GREEN = plot.palette.INK, plot.palette.RED, plot.palette.BLUE, plot.palette.GREEN
#: Displacements of the table: with the first half of its lines are nearest to themselves; from the second iterative
#: matching ends in a wrong place.
NEAR, FAR = 16, 173
VIEW, PAGE = (18.0, -62.0), (6.4, 4.8)


def displaced(model: registration.Model, seed: int, shift: float, angles: tuple[float, float]) -> registration.Model:
    """A model turned and moved by some amount."""
    random = np.random.default_rng(seed)
    return model.transformed(
        CGA.translator(shift * random.normal(size=3)) * CGA.rotor(random.normal(size=3), random.uniform(*angles))
    )


def page(text: str, right: int | None = None, count: int = 0) -> object:
    """Empty axes with a line of text."""
    ax = plot.axes(VIEW, PAGE)
    said = text if right is None else f"{text}: {right} of {count} lines are matched with themselves"
    ax.figure.text(0.98, 0.95, said, ha="right", fontsize=9, color=BLACK)
    return ax


def by_match(right: np.ndarray) -> dict[str, list[str]]:
    """Green where a line is matched with itself, black elsewhere."""
    return {"lines": [GREEN if hit else BLACK for hit in right]}


def tables(folder: Path) -> None:
    """Figures 5.1 to 5.5."""
    table = registration.Model.load(HERE / "table.json")
    own, count = np.arange(len(table)), len(table)
    query = displaced(table, NEAR, 0.25, (0.15, 0.5))

    ax = page("The table and a transformation of it")
    registration.draw_model(table, ax, BLACK, "reference")
    plot.save(folder / "figure_5_1.png", registration.draw_model(query, ax, RED, "query"))

    matches = np.asarray(registration.match(query, table, cost="thesis").indices)
    ax = page("Proximity", int((matches == own).sum()), count)
    registration.draw_model(table, ax, by_match(matches == own))
    plot.save(folder / "figure_5_2.png", registration.draw_model(query, ax, RED, "query", width=0.8))

    for number, method in (("5_3", "optimize"), ("5_4", "direct")):
        motor = registration.estimate_rotor(query, table.subset({"lines": matches}), method)
        ax = page({"optimize": "Least cost over these matches", "direct": "Algorithm 1 on these matches"}[method])
        registration.draw_model(table, ax, BLACK, "reference")
        registration.draw_model(query, ax, BLUE, "query, moved", motor=motor)
        plot.save(folder / f"figure_{number}.png", registration.draw_model(query, ax, RED, "query", width=0.6))

    query = displaced(table, FAR, 0.5, (0.5, 1.6))
    stuck = registration.iterate(query, table, robust=False)
    right = np.asarray(stuck.matches) == own
    ax = page("Iterative matching is stuck", int(right.sum()), count)
    registration.draw_model(table, ax, by_match(right))
    plot.save(folder / "figure_5_5.png", registration.draw_model(query, ax, BLUE, "query, moved", motor=stuck.motor))
    found = registration.register(query, table)
    registration.picture(found, query, table, folder / "figure_5_5_registered.png", view=VIEW)


def mixed(folder: Path) -> None:
    """Figure 5.6: lines and planes, and their transformation."""
    random = np.random.default_rng(1)
    lines = np.stack([random.uniform(-1, 1, (10, 3)), random.normal(size=(10, 3))], 1)
    planes = np.hstack([random.normal(size=(6, 3)), random.uniform(-0.7, 0.7, (6, 1))])
    query = registration.Model(lines=lines, planes=planes)
    reference = query.transformed(CGA.translator((4, 1, 0.5)) * CGA.rotor((1, 2, 3), 1.9))
    registration.picture(
        registration.register(query, reference), query, reference, folder / "figure_5_6.png", view=VIEW
    )


def room(folder: Path) -> None:
    """The scan of a room, its edges as segments, and what registration makes of it."""
    reference = registration.model_from_edges(HERE / "room.obj", unit="m")
    query = registration.model_from_edges(HERE / "room_scan.ply", unit="m")
    registration.picture(registration.register(query, reference), query, reference, folder / "room.png")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, default=Path("registration"), metavar="FOLDER")
    folder = parser.parse_args().out
    folder.mkdir(parents=True, exist_ok=True)
    tables(folder)
    mixed(folder)
    room(folder)


if __name__ == "__main__":
    main()
