"""`bladesmith mesh`: the surfaces of a scene file as triangle meshes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from . import options


@options.command("mesh scene.toml -o surface.glb --rings 128 --segments 64 --caps", "geometry/meshes")
@options.input_file("scene")
@options.output_file("surface.glb", "A .glb, .obj, .ply or .stl file; a .glb keeps names and colors.")
@click.option("--surface", type=click.IntRange(min=0), multiple=True, help="Number of a surface, from 0; default: all.")
@options.option_with_default("--rings", 64, "Bands along curves.", options.COUNT)
@options.option_with_default("--segments", 64, "Quads around, or across.", options.COUNT)
@click.option("--caps/--no-caps", default=False, help="Close the open ends of tubes; default: no.")
@click.option("--extent", type=float, help="Side of the squares that stand for planes; default: around the rest.")
@options.option_with_default("--scale", 1.0, "Factor on positions: 0.001 for millimetres.")
def command(scene: Path, output: Path, surface: tuple[int, ...], scale: float, **settings: Any) -> None:
    """Write the surfaces of a scene file as triangle meshes with normals, for other programs."""
    from ..common.files import output_path
    from ..tracer import Scene
    from ..tracer.meshing.scenes import scene_meshes
    from ..tracer.meshing.triangle_mesh import CONTENT, save_meshes

    output_path(output, *CONTENT)
    options.check_outputs([output], [scene], "the scene file")
    loaded = Scene.load(scene)
    meshes = scene_meshes(loaded, surface or None, **settings)
    save_meshes(output, meshes, scale=scale)
    count = sum(len(mesh.faces) for mesh, _ in meshes)
    click.echo(f"{output}: {len(meshes)} surfaces, {count} triangles", err=True)
