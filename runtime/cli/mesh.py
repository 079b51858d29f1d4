"""`bladesmith mesh`: the surfaces of a scene file as triangle meshes."""

from __future__ import annotations

from pathlib import Path

import click


@click.command(epilog="Example: bladesmith mesh scene.toml -o surface.glb --rings 128 --segments 64 --caps")
@click.argument("scene", type=click.Path(path_type=Path))
@click.option(
    "--output",
    "-o",
    type=click.Path(path_type=Path),
    default="surface.glb",
    show_default=True,
    help="A .glb, .obj, .ply or .stl file; a .glb keeps names and colors.",
)
@click.option("--surface", type=click.IntRange(min=0), multiple=True, help="Number of a surface, from 0; default: all.")
@click.option("--rings", type=click.IntRange(min=1), default=64, show_default=True, help="Bands along curves.")
@click.option("--segments", type=click.IntRange(min=1), default=64, show_default=True, help="Quads around, or across.")
@click.option("--caps/--no-caps", default=False, help="Close the open ends of tubes; default: no.")
@click.option("--extent", type=float, help="Side of the squares that stand for planes; default: around the rest.")
@click.option("--scale", type=float, default=1.0, show_default=True, help="Factor on positions: 0.001 for millimetres.")
def command(
    scene: Path,
    output: Path,
    surface: tuple[int, ...],
    rings: int,
    segments: int,
    caps: bool,
    extent: float | None,
    scale: float,
) -> None:
    """Write the surfaces of a scene file as triangle meshes with normals, for other programs."""
    from ..errors import InputError
    from ..tracer import Scene
    from ..tracer.meshing.saving import check_format, save_meshes
    from ..tracer.meshing.scenes import scene_meshes

    check_format(output)
    if not output.absolute().parent.is_dir():
        raise InputError(f"there is no folder {output.parent}.", where=str(output))
    loaded = Scene.load(scene)
    meshes = scene_meshes(loaded, surface or None, rings, segments, caps=caps, extent=extent)
    save_meshes(output, meshes, scale=scale)
    count = sum(len(mesh.faces) for mesh, _ in meshes)
    click.echo(f"{output}: {len(meshes)} surfaces, {count} triangles", err=True)
