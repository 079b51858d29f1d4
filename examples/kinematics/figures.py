"""Draws the mechanisms of the files beside it, along their paths, and slices of their workspaces.

    python examples/kinematics/figures.py --out kinematics

Needs the extras `plot` and `urdf`.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from bladesmith.kinematics.io.reader import load_mechanism

HERE = Path(__file__).resolve().parent
FIGURES = ("delta", "four_bar", "stewart", "arm", "scara")
WORKSPACES = ("delta", "stewart", "scara")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, default=Path("kinematics"), metavar="FOLDER")
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    for name in FIGURES:
        setup = load_mechanism(HERE / f"{name}.toml")
        setup.picture(options.out / f"{name}.png", setup.motion_with_poses())
        if name in WORKSPACES:
            setup.slices(options.out / f"{name}_workspace.png")


if __name__ == "__main__":
    main()
