"""A four-bar linkage in CGA and in PGA: what its loop leaves and asks for twice, and the rocker's swing.

python examples/kinematics/four_bar.py --out kinematics
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from bladesmith import cga3d as cga
from bladesmith import kinematics
from bladesmith import pga3d as pga
from bladesmith.kinematics.plotting import picture

A, B, C, D = (0.0, 0.0, 0.0), (0.0, 1.0, 0.0), (3.0, 2.5, 0.0), (3.5, 0.0, 0.0)
PINS = (("motor", "frame", "crank", A), ("pin 1", "crank", "coupler", B), ("pin 2", "coupler", "rocker", C),
        ("hinge", "frame", "rocker", D))  # fmt: skip
UP = (0.0, 0.0, 1.0)


def linkage(flat: bool) -> kinematics.Mechanism:
    """Hinges are circles in CGA; in PGA a line and a point of it."""
    made = kinematics.Mechanism(["frame", "crank", "coupler", "rocker"], fixed="frame")
    for name, a, b, place in PINS:
        shared = (pga.line(place, UP), pga.point(place)) if flat else (cga.circle(place, UP, 0.2),)
        made.add(kinematics.Revolute(a, b, *shared), name)
    return made


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, default=Path("kinematics"), metavar="FOLDER")
    out = parser.parse_args().out
    out.mkdir(parents=True, exist_ok=True)

    bars = linkage(flat=False)
    print(f"mobility {bars.mobility()}, rank {bars.rank()} of {bars.constraint_matrix().shape[0]} constraints;",
          f"{len(bars.self_stresses())} of them are there twice: it is a flat mechanism in space")  # fmt: skip
    ratio = bars.jacobian("motor", "hinge")[0, 0]
    flat = linkage(flat=True).jacobian("motor", "hinge")[0, 0]
    print(f"the rocker turns {ratio:.6f} times as fast as the crank; in PGA {flat:.6f}")

    around = bars.solve_pose({"motor": np.linspace(0, 2 * np.pi, 181)}, path=True, strict=True)
    swing = np.degrees(around.coordinates("hinge")[:, 0])
    print(f"while the crank goes around the rocker swings from {swing.min():.2f} to {swing.max():.2f} degrees")
    print(f"after one turn it is back to {abs(swing[-1]):.2g} degrees; loops close to {around.residual.max():.2g}")

    tip = cga.point((1.2, 3.2, 0.0))
    trace = (around["coupler"] >> tip).parameters().xyz
    shown = [0, 45, 90, 135]
    poses = [bars.at({name: around[name][i] for name in bars.moving}) for i in shown]
    picture.picture(
        poses, out / "four_bar_poses.png", tool="coupler", position=trace[shown], trace=trace, view=(68, -85)
    )  # fmt: skip


if __name__ == "__main__":
    main()
