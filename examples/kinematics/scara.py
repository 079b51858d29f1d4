"""A SCARA from a URDF file: what its gripper can do, a way from place to place, where it works well.

    python examples/kinematics/scara.py --out kinematics

Needs the extra `urdf`.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from bladesmith import kinematics
from bladesmith.kinematics.io.reader import load_mechanism

HERE = Path(__file__).resolve().parent


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, default=Path("kinematics"), metavar="FOLDER")
    out = parser.parse_args().out
    out.mkdir(parents=True, exist_ok=True)

    robot = kinematics.load_urdf(kinematics.urdf_example("scara"))
    mechanism = robot.mechanism({"inner": 0.4, "outer": 0.9, "plunge": 0.05})
    print(mechanism, "of mobility", mechanism.mobility())
    for motion in mechanism.free_motions():
        print(" ", motion.driver, "moves", ", ".join(motion.bodies))
    print("the gripper has", mechanism.allowed_twists("gripper").shape[0], "freedoms: three ways, and turning about e3")

    setup = load_mechanism(HERE / "scara.toml")
    way = setup.motion()
    print("from place to place the joints need", np.abs(way.speeds).max(0).round(3), "of", way.inputs)
    way.save(out / "scara_way.csv")
    space = setup.workspace()
    best = np.nanmin(space.condition)
    print(f"at z = 0.2 it reaches {space.reachable.mean():.0%} of the box, at best with condition number {best:.2f}")
    setup.slices(out / "scara_slices.png", space)
    setup.picture(out / "scara_way.png", setup.motion_with_poses())


if __name__ == "__main__":
    main()
