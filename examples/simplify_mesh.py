"""Simplify the line drawing of a mesh (thesis 3.12.2): lines on its sharp edges, similar ones merged, before and after.

    python simplify_mesh.py [mesh.obj|ply|stl] [--sharp 12] [--threshold 0.02] [--output simplified.png]

Costs depend on the unit of length: the mesh is first scaled to the size 10, centred.
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path

import numpy as np

import bladesmith as bs
from bladesmith import plot
from bladesmith.interchange.meshes import Mesh, load_mesh, mesh_lines

AIRPLANE = Path(__file__).parent / "meshes" / "airplane.ply"
SIZE = 10.0


def scaled(mesh: Mesh) -> Mesh:
    """The mesh with its longest side of `SIZE`, about the origin."""
    low, high = mesh.vertices.min(0), mesh.vertices.max(0)
    vertices = (mesh.vertices - (low + high) / 2) * (SIZE / (high - low).max())
    return Mesh(vertices, mesh.faces, mesh.name)


def placed(segments: np.ndarray, lines: bs.Multivector) -> np.ndarray:
    """Each segment's ends projected on its line, X -> (X . L) L: a line has no ends of its own to draw."""
    ends = bs.cga3d.point(segments)
    carrier = lines[:, None]
    feet = (ends | carrier) | carrier
    weight = -(feet | bs.cga3d.ni).values
    return np.stack([feet[name] for name in ("e1", "e2", "e3")], -1) / weight


def draw(before: np.ndarray, after: np.ndarray, path: Path) -> None:
    """Both drawings side by side."""
    corners = before.reshape(-1, 3)
    view = corners.min(0), corners.max(0)
    left, right = plot.panels(1, 2, view=(35, -60), size=(9.6, 4.0), frame=False)
    plot.paths(before, ax=left, color=plot.palette.INK, size=0.6, extent=view)
    plot.paths(after, ax=right, color=plot.palette.RED, size=0.6, extent=view)
    plot.save(path, right)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("mesh", nargs="?", type=Path, default=AIRPLANE)
    parser.add_argument("--sharp", type=float, default=12.0, help="least angle between faces, in degrees")
    parser.add_argument("--threshold", type=float, default=0.02, help="greatest cost of lines that are merged")
    parser.add_argument("--output", type=Path, default=Path("simplified.png"))
    arguments = parser.parse_args()

    mesh = scaled(load_mesh(arguments.mesh))
    lines, segments = mesh_lines(mesh, sharp=np.radians(arguments.sharp))
    print(f"{mesh.name}: {len(mesh.faces)} triangles, {len(mesh.edges)} edges, {len(lines)} sharp ones")
    start = time.perf_counter()
    merged = bs.objects.merge_similar(lines, arguments.threshold)
    seconds = time.perf_counter() - start
    counts, costs = merged.counts, merged.evaluations
    print(f"{len(lines)} lines became {len(counts)} in {seconds:.3f} s ({costs} costs, {len(lines) ** 2 // 2} pairs)")
    print(f"at most {counts.max()} lines became one")
    draw(segments, placed(segments, merged.objects[merged.groups]), arguments.output)
    print(f"wrote {arguments.output}")


if __name__ == "__main__":
    main()
