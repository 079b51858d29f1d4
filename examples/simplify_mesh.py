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
from bladesmith.interchange.meshes import Mesh, load_mesh, mesh_lines

AIRPLANE = Path(__file__).parent / "meshes" / "airplane.ply"
SIZE = 10.0
INK, ACCENT = "#30363c", "#c0392b"


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


def draw(before: np.ndarray, after: np.ndarray, titles: tuple[str, str], path: Path) -> None:
    """Both drawings side by side."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
    from mpl_toolkits.mplot3d.art3d import Line3DCollection

    figure = Figure(figsize=(13, 5.5), layout="constrained")
    FigureCanvasAgg(figure)
    center = before.reshape(-1, 3)
    low, high = center.min(0), center.max(0)
    for place, (segments, title, color) in enumerate(zip((before, after), titles, (INK, ACCENT), strict=True)):
        ax = figure.add_subplot(1, 2, place + 1, projection="3d")
        ax.add_collection3d(Line3DCollection(segments, colors=color, linewidths=0.8))
        ax.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]), title=title)
        ax.set_box_aspect(tuple(high - low), zoom=1.25)
        ax.view_init(35, -60)
        ax.set_axis_off()
    figure.savefig(path, dpi=120)


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
    titles = f"{len(lines)} lines", f"{len(counts)} lines, at most {counts.max()} in one"
    draw(segments, placed(segments, merged.objects[merged.groups]), titles, arguments.output)
    print(f"wrote {arguments.output}")


if __name__ == "__main__":
    main()
