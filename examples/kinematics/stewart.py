"""A Stewart platform: the lengths of its legs for a pose, its Jacobian, what it reaches.

python examples/kinematics/stewart.py --out kinematics
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from bladesmith import cga3d as cga
from bladesmith.kinematics.io.reader import load_mechanism

HERE = Path(__file__).resolve().parent
LEGS = tuple(f"leg_{i}" for i in range(1, 7))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, default=Path("kinematics"), metavar="FOLDER")
    out = parser.parse_args().out
    out.mkdir(parents=True, exist_ok=True)

    setup = load_mechanism(HERE / "stewart.toml")
    platform, middle = setup.model.mechanism, setup.model.point
    print(platform, "of mobility", platform.mobility())

    there = cga.translator(middle + (0.1, -0.05, 0.12)) * cga.rotor((1, 2, 3), 0.2) * cga.translator(-middle)
    pose = platform.solve_pose(targets={"plate": there.as_kind("motor")}, strict=True)
    legs = np.concatenate([pose.coordinates(name) for name in LEGS])
    print("legs longer by", legs.round(6))
    ends = [joint.conditions()[0].x.parameters() for joint in platform.joints]
    begin = np.array([p.xyz for p in ends[0::3]])
    end = np.array([p.xyz for p in ends[2::3]])
    moved = (there >> cga.point(end)).parameters().xyz
    plain = np.linalg.norm(moved - begin, axis=1) - np.linalg.norm(end - begin, axis=1)
    print("by the distances of their ends: off by", np.abs(legs - plain).max())

    jacobian = platform.jacobian(list(LEGS), "plate")
    print("condition number here", np.linalg.cond(jacobian).round(3))
    space = setup.workspace()
    best = np.unravel_index(np.nanargmin(space.condition), space.condition.shape)
    place = [float(axis[i]) for axis, i in zip((space.x, space.y, space.z), best, strict=True)]
    print(f"{space.reachable.mean():.0%} of the box is reached; best is {place}, with {space.condition[best]:.3f}")
    setup.slices(out / "stewart_slices.png", space)


if __name__ == "__main__":
    main()
