"""Renders every scene of this folder, and the drawings beside some of them, as the figures of thesis chapter 4.

    python examples/tracing/render.py --out tracing

A scene is a picture of `bladesmith render`. Some figures also show the scene from outside, or its mesh.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.colors import LightSource
from mpl_toolkits.mplot3d.art3d import Line3DCollection, Poly3DCollection

from bladesmith import tracer

HERE = Path(__file__).resolve().parent
#: Scenes that are drawn from outside, with their camera; and the one whose mesh is drawn with flat facets.
OUTSIDE = ("figure_4_11", "figure_4_16", "figure_4_17")
FLAT, TEXTURED = "figure_4_18", "figure_4_15"
#: How far the camera's pyramid is drawn, and half of the cube that is shown, in units of the scene.
PYRAMID, HALF = 1.8, 2.2


def axes() -> plt.Axes:
    """An empty stage."""
    stage = plt.figure(figsize=(4.2, 3.6)).add_axes((0, 0, 1, 1), projection="3d")
    stage.set_axis_off()
    return stage


def put(stage: plt.Axes, mesh: tracer.TriangleMesh, colors: np.ndarray, lines: bool = False) -> None:
    """A mesh with one color per triangle, lit by its own facets; edges are drawn, or covered by their triangles."""
    corners = mesh.vertices[mesh.faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
    light = LightSource(azdeg=225, altdeg=40).shade_normals(normals, fraction=1.0)
    shade = 0.45 + 0.55 * np.clip(light, 0, 1)
    faces = colors * shade[:, None]
    edges = 0.7 * faces if lines else faces
    stage.add_collection3d(Poly3DCollection(corners, facecolors=faces, edgecolors=edges, linewidths=0.3))


def frame(stage: plt.Axes, points: np.ndarray) -> None:
    """Equal scales around points."""
    low, high = points.min(axis=0), points.max(axis=0)
    middle, half = (low + high) / 2, (high - low).max() / 2
    sides = np.maximum((high - low) / 2, half / 4)
    for axis, x, side in zip("xyz", middle, sides, strict=True):
        getattr(stage, f"set_{axis}lim")(x - side, x + side)
    stage.set_box_aspect(tuple(sides), zoom=1.05)


def outside(scene: tracer.Scene, path: Path) -> None:
    """The scene and its camera, from the side."""
    stage, seen = axes(), []
    for surface in scene.surfaces:
        mesh = surface.mesh(extent=HALF) if surface.kind == "plane" else surface.mesh(48, 32)
        put(stage, mesh, np.broadcast_to(surface.material.color, (len(mesh.faces), 3)))
        seen.append(mesh.vertices)
    origins, directions = scene.camera.rays(2, 2)
    eye, ends = origins[0, 0], origins + PYRAMID * directions
    corners = ends[[0, 0, 1, 1], [0, 1, 1, 0]]
    stage.add_collection3d(Line3DCollection([(eye, corner) for corner in corners], colors="black", linewidths=1))
    stage.add_collection3d(Line3DCollection([np.vstack([corners, corners[:1]])], colors="black", linewidths=1))
    axis = directions.mean(axis=(0, 1))
    stage.add_collection3d(Line3DCollection([(eye, eye + 2 * PYRAMID * axis)], colors="red", linewidths=1))
    frame(stage, np.vstack([*seen, eye[None]]))
    stage.view_init(elev=20, azim=-35)
    stage.figure.savefig(path, dpi=100)
    plt.close(stage.figure)


def flat(scene: tracer.Scene, path: Path) -> None:
    """The mesh of the first surface, every triangle of one shade."""
    stage, surface = axes(), scene.surfaces[0]
    mesh = surface.mesh(20, 28)
    put(stage, mesh, np.broadcast_to(surface.material.color, (len(mesh.faces), 3)), lines=True)
    frame(stage, mesh.vertices)
    stage.view_init(elev=20, azim=-90)
    stage.figure.savefig(path, dpi=100)
    plt.close(stage.figure)


def textured(scene: tracer.Scene, path: Path) -> None:
    """The mesh of the first surface with squares in its own coordinates (u, v)."""
    stage, surface = axes(), scene.surfaces[0]
    mesh = surface.mesh(24 * surface.curve.segments, 48)  # whole quadrilaterals to a square
    u, v = mesh.uv[mesh.faces].mean(axis=1).T
    dark = (np.floor(8 * u) + np.floor(4 * v)) % 2 == 1
    put(stage, mesh, np.where(dark[:, None], (0.15, 0.35, 0.25), (0.85, 0.80, 0.65)))
    frame(stage, mesh.vertices)
    stage.view_init(elev=20, azim=-90)
    stage.figure.savefig(path, dpi=100)
    plt.close(stage.figure)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=Path("tracing"), help="folder to write; default: ./tracing")
    parser.add_argument("--only", nargs="*", metavar="NAME", help="these scenes only, e.g. figure_4_16")
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    for file in sorted(HERE.glob("figure_*.toml")):
        if arguments.only and file.stem not in arguments.only:
            continue
        scene = tracer.Scene.load(file)
        tracer.save_image(arguments.out / f"{file.stem}.png", scene.render(progress=sys.stderr.isatty()))
        if file.stem in OUTSIDE:
            outside(scene, arguments.out / f"{file.stem}_outside.png")
        if file.stem == FLAT:
            flat(scene, arguments.out / f"{file.stem}_flat.png")
        if file.stem == TEXTURED:
            textured(scene, arguments.out / f"{file.stem}_textured.png")
        print(file.stem)


if __name__ == "__main__":
    main()
