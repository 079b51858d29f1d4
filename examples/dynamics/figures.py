"""Draws the figures of thesis chapter 6 from the simulation files beside it: figures 6.3 to 6.5, and a double pendulum.

    python examples/dynamics/figures.py --out dynamics --pages

Needs the extra `plot`. With --pages every motion is also written as a page to turn and to play.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from bladesmith import dynamics

HERE = Path(__file__).resolve().parent
FIGURES = {
    "figure_6_3": "flipping_cuboid",
    "figure_6_4_left": "sliding_pendulum",
    "figure_6_4_right": "spinning_cone",
    "figure_6_5_left": "pendulum_on_sphere",
    "figure_6_5_right": "pendulum_on_circle",
    "double_pendulum": "double_pendulum",
}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, default=Path("dynamics"), metavar="FOLDER")
    parser.add_argument("--pages", action="store_true", help="write pages to play, too")
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    for figure, name in FIGURES.items():
        setup = dynamics.load_simulation(HERE / f"{name}.toml")
        record = dynamics.as_record(setup.run(), setup.sketch)
        record.picture(options.out / f"{figure}.png")
        if options.pages:
            record.animate(options.out / f"{figure}.html")
        if figure == "figure_6_4_right":
            record.plot(options.out / "figure_6_4_right_curves.png")


if __name__ == "__main__":
    main()
