"""Makes airplane.json: lines and planes of a published mesh.

    python examples/registration/make_airplane.py [--angle 5] [--least 0] [--output airplane.json]

Deterministic. Needs the extra `mesh`.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from bladesmith import registration

HERE = Path(__file__).resolve().parent
MESH = HERE.parent / "meshes" / "airplane.ply"
ORIGIN = (
    "airplane.ply of the package PyVista 0.49.1 (pyvista/examples), MIT licence, The PyVista Developers; "
    "lines and planes by examples/registration/make_airplane.py"
)
#: Corners are nearer to their plane or line than this, in sizes of the airplane.
TOLERANCE = 5e-4


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--angle", type=float, default=5.0, help="least angle at a sharp edge, in degrees")
    parser.add_argument("--least", type=float, default=0.0, help="shortest line, in sizes of the airplane")
    parser.add_argument("--output", type=Path, default=HERE / "airplane.json")
    arguments = parser.parse_args()

    angle = np.radians(arguments.angle)
    model = registration.model_from_mesh(
        MESH, angle=angle, min_size=arguments.least, tolerance=TOLERANCE, origin=ORIGIN
    )
    model.save(arguments.output)
    print(f"{model!r}: {len(model)} objects, {arguments.output.stat().st_size / 1000:.0f} kB")


if __name__ == "__main__":
    main()
