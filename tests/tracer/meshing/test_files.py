"""Meshes in files, by the command, and what is refused."""

from __future__ import annotations

import json
import struct

import numpy as np
import pytest
import trimesh

from bladesmith import tracer
from bladesmith.cli import main
from bladesmith.errors import InputError, SceneError
from bladesmith.tracer.meshing import TriangleMesh, mesh_of
from bladesmith.tracer.meshing.scenes import scene_meshes
from bladesmith.tracer.surfaces.evolved import EvolvedCircles, EvolvedPointPairs

from ...support.tracer.meshes import RIBBON, as_trimesh, face_normals
from ...support.tracer.scenes import CAMERA, TUBE

# -- files -------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def small():
    return EvolvedCircles(TUBE).mesh(6, 8)


def read_obj(path):
    """Positions, normals, texture and corners by lines, without any reader."""
    rows = {"v": [], "vn": [], "vt": [], "f": []}
    for line in path.read_text().splitlines():
        key, *fields = line.split() or [""]
        assert key in rows or key == ""
        if key:
            rows[key].append([[int(i) for i in f.split("/")] for f in fields] if key == "f" else [*map(float, fields)])
    return {key: np.array(value) for key, value in rows.items()}


def read_glb(path):
    """The description, and an accessor's numbers."""
    data = path.read_bytes()
    length = struct.unpack("<I", data[12:16])[0]
    tree, body = json.loads(data[20 : 20 + length]), data[28 + length :]

    def numbers(i):
        accessor = tree["accessors"][i]
        view = tree["bufferViews"][accessor["bufferView"]]
        width = {"SCALAR": 1, "VEC2": 2, "VEC3": 3}[accessor["type"]]
        kind = {5126: "<f4", 5125: "<u4"}[accessor["componentType"]]
        start = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
        return np.frombuffer(body, kind, accessor["count"] * width, start).reshape(-1, width)

    return tree, numbers


def test_obj(tmp_path, small):
    small.save(tmp_path / "tube.obj")
    rows = read_obj(tmp_path / "tube.obj")
    corners = rows["f"] - 1
    assert np.allclose(rows["v"][corners[..., 0]], small.vertices[small.faces], rtol=0, atol=1e-15)
    assert np.allclose(rows["vt"][corners[..., 1]], small.uv[small.faces], rtol=0, atol=1e-15)
    assert np.allclose(rows["vn"][corners[..., 2]], small.vertex_normals[small.faces], rtol=0, atol=1e-15)
    again = trimesh.load(tmp_path / "tube.obj", process=False)
    assert np.allclose(again.vertex_normals, small.vertex_normals)
    assert np.allclose(again.visual.uv, small.uv)


def test_obj_keeps_the_digits_of_small_things(tmp_path, small):
    small.save(tmp_path / "tube.obj", scale=1e-9)
    rows = read_obj(tmp_path / "tube.obj")
    assert np.allclose(rows["v"], small.vertices * 1e-9, rtol=0, atol=1e-23)
    assert np.allclose(rows["vn"], small.vertex_normals, rtol=0, atol=1e-15)


def test_ply(tmp_path, small):
    small.save(tmp_path / "tube.ply")
    again = trimesh.load(tmp_path / "tube.ply", process=False)
    assert np.allclose(again.vertices, small.vertices, atol=1e-6)
    assert np.array_equal(again.faces, small.faces)
    data = (tmp_path / "tube.ply").read_bytes()
    head = data[: data.index(b"end_header\n") + 11]
    assert b"property float nx" in head
    row = np.dtype([("x", "<f4", 3), ("n", "<f4", 3), ("uv", "<f8", 2)])
    body = np.frombuffer(data, row, len(small.vertices), len(head))
    assert np.allclose(body["n"], small.vertex_normals, atol=1e-6)
    assert np.allclose(body["uv"], small.uv, atol=1e-6)


def test_stl(tmp_path, small):
    small.save(tmp_path / "tube.stl")
    data = (tmp_path / "tube.stl").read_bytes()
    rows = np.frombuffer(data[84:], np.dtype([("n", "<f4", 3), ("x", "<f4", (3, 3)), ("tag", "<u2")]))
    assert np.allclose(rows["x"], small.vertices[small.faces], atol=1e-6)
    assert np.allclose(rows["n"], face_normals(small), atol=1e-5)


def test_glb(tmp_path, small):
    small.save(tmp_path / "tube.glb")
    tree, numbers = read_glb(tmp_path / "tube.glb")
    attributes = tree["meshes"][0]["primitives"][0]["attributes"]
    assert set(attributes) == {"POSITION", "NORMAL", "TEXCOORD_0"}
    assert np.allclose(numbers(attributes["POSITION"]), small.vertices, atol=1e-6)
    assert np.allclose(numbers(attributes["NORMAL"]), small.vertex_normals, atol=1e-6)
    assert np.allclose(numbers(attributes["TEXCOORD_0"]) * [1, -1] + [0, 1], small.uv, atol=1e-6)  # v counts down there
    assert np.array_equal(numbers(tree["meshes"][0]["primitives"][0]["indices"]).reshape(-1, 3), small.faces)
    again = trimesh.load(tmp_path / "tube.glb", force="mesh")
    assert again.area == pytest.approx(as_trimesh(small).area, rel=1e-5)


def test_a_glb_far_away_keeps_its_shape(tmp_path):
    shift = np.array([1e6, -2e6, 5e5])
    mesh = EvolvedCircles([(np.array(c) + shift, n, r) for c, n, r in TUBE]).mesh(6, 8)
    mesh.save(tmp_path / "far.glb")
    tree, numbers = read_glb(tmp_path / "far.glb")
    matrix = np.array(tree["nodes"][-1]["matrix"]).reshape(4, 4).T
    local = numbers(tree["meshes"][0]["primitives"][0]["attributes"]["POSITION"])
    assert np.abs(local.astype(float) + matrix[:3, 3] - mesh.vertices).max() < 1e-6


def test_files_are_written_whole_or_not_at_all(tmp_path, small):
    with pytest.raises(InputError, match=r"\.obj, \.ply, \.stl or \.glb, not \.fbx"):
        small.save(tmp_path / "tube.fbx")
    with pytest.raises(InputError, match="a text or a path is needed"):
        small.save(3)
    with pytest.raises(InputError, match="nowhere.*cannot be written: No such file"):
        small.save(tmp_path / "nowhere" / "tube.obj")
    with pytest.raises(SceneError, match="scale"):
        small.save(tmp_path / "tube.obj", scale=-1.0)
    assert not list(tmp_path.iterdir())
    with pytest.raises(SceneError, match="no triangles"):
        TriangleMesh(small.vertices, small.faces[:0], small.vertex_normals).save(tmp_path / "none.obj")


def test_what_is_written_is_read_by_the_tracer(tmp_path, ring):
    from bladesmith.tracer.surfaces.triangles import Mesh

    mesh = ring.mesh(96, 32)
    for ending in (".obj", ".glb", ".ply"):
        mesh.save(tmp_path / f"ring{ending}")
        surface = Mesh(tmp_path / f"ring{ending}", smooth=True)
        origin = np.array([3.0, 0.2, 6.0])
        found, exact = surface.intersect(origin, (0, 0, -1)), ring.intersect(origin, (0, 0, -1))
        assert found.count == exact.count
        assert abs(found.t[0] - exact.t[0]) < 5e-3
        assert found.normal[0] @ exact.normal[0] > 0.999


# -- scenes, the command -----------------------------------------------------------------------------------

SCENE = """
[camera]
position = [0.0, -8.0, 2.0]
look_at = [0.0, 0.0, 0.0]

[[surfaces]]
kind = "plane"
normal = [0, 0, 1]
offset = -1.0
color = [0.5, 0.5, 0.5]

[[surfaces]]
kind = "sphere"
center = [1.5, 0.0, 0.5]
radius = 0.5
color = [1.0, 0.2, 0.0]

[[surfaces]]
kind = "evolved_circles"
controls = [
    { center = [0, 0, 0], normal = [0, 0, 1], radius = 1.0 },
    { center = [0, 1, 2], normal = [0, 0.5, 1], radius = 0.6 },
]
color = [0.2, 0.4, 0.8]
"""


def test_the_command_writes_all_surfaces_with_names_and_colors(tmp_path):
    (tmp_path / "scene.toml").write_text(SCENE)
    target = tmp_path / "out.glb"
    assert main.run(["mesh", str(tmp_path / "scene.toml"), "-o", str(target), "--rings", "8"]) == 0
    tree, numbers = read_glb(target)
    names = ["0 plane", "1 sphere", "2 evolved circles"]
    assert sorted(mesh["name"] for mesh in tree["meshes"]) == names
    wanted = {"0 plane": (0.5, 0.5, 0.5), "1 sphere": (1, 0.2, 0), "2 evolved circles": (0.2, 0.4, 0.8)}
    for mesh in tree["meshes"]:
        primitive = mesh["primitives"][0]
        assert {"POSITION", "NORMAL"} <= set(primitive["attributes"])
        lengths = np.linalg.norm(numbers(primitive["attributes"]["NORMAL"]), axis=1)
        assert np.allclose(lengths, 1, atol=1e-6)
        color = tree["materials"][primitive["material"]]["pbrMetallicRoughness"]["baseColorFactor"]
        assert np.allclose(color[:3], wanted[mesh["name"]], atol=1 / 255)
    plane = next(mesh for mesh in tree["meshes"] if mesh["name"] == "0 plane")
    corners = numbers(plane["primitives"][0]["attributes"]["POSITION"])
    assert np.allclose(corners[:, 2], -1)
    assert (corners[:, :2].min(0) < [-1, -1]).all()  # it lies under the rest
    assert (corners[:, :2].max(0) > [2, 1.6]).all()


def test_the_command_writes_one_surface_and_refuses_others(tmp_path, capsys):
    (tmp_path / "scene.toml").write_text(SCENE)
    arguments = ["mesh", str(tmp_path / "scene.toml"), "-o", str(tmp_path / "one.stl")]
    assert main.run([*arguments, "--surface", "2", "--caps"]) == 0
    assert trimesh.load(tmp_path / "one.stl").is_watertight
    assert main.run([*arguments, "--surface", "7"]) == main.BAD_INPUT
    assert "no surface 7; the scene has 3" in capsys.readouterr().err
    assert main.run(["mesh", "--help"]) == 0
    assert "Example: bladesmith mesh" in capsys.readouterr().out
    assert main.run([*arguments[:3], str(tmp_path / "one.xyz")]) == main.BAD_INPUT


def test_errors_name_the_surface():
    lines = EvolvedCircles([((0, 0, 0), (0, 0, 1), 1.0), ((4, 0, 0), (0, 0, -1), 1.0)])
    camera = tracer.Camera.look_at((0, -5, 0), (0, 0, 0))
    scene = tracer.Scene(camera, [], [tracer.Sphere((0, 0, 0), 1.0), lines])
    with pytest.raises(SceneError, match=r"surfaces\[1\]: the surface has circles that become lines"):
        scene_meshes(scene)
    with pytest.raises(InputError, match="no surfaces"):
        scene_meshes(tracer.Scene(camera))


# -- bad input ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"rings": 0}, "rings is 0"),
        ({"segments": 2}, "segments is 2"),
        ({"segments": 2.5}, "segments is 2.5"),
        ({"rings": 1 << 20, "segments": 1 << 20}, "quads have more than"),
    ],
)
def test_bad_counts_are_refused(arguments, message):
    with pytest.raises(SceneError, match=message):
        EvolvedCircles(TUBE).mesh(**arguments)


def test_few_quads_are_enough():
    mesh = EvolvedCircles(TUBE).mesh(1, 3, caps=True)
    assert as_trimesh(mesh).is_watertight
    assert len(EvolvedPointPairs(RIBBON[:2]).mesh(1, 1).faces) == 2


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"vertices": np.zeros((3, 2))}, "vertices"),
        ({"vertices": np.full((4, 3), np.nan)}, r"vertices\[0, 0\] is nan; a finite number"),
        ({"vertex_normals": np.zeros((4, 3))}, "unit vectors"),
        ({"vertex_normals": np.zeros((3, 3))}, r"\(4, 3\)"),
        ({"uv": np.zeros((4, 3))}, r"\(4, 2\)"),
        ({"faces": [[0, 1, 4]]}, "indices of 4 vertices run from 0"),
        ({"faces": [[0.0, 1.0, 2.0]]}, "whole numbers"),
    ],
)
def test_bad_meshes_are_refused(changes, message):
    good = {"vertices": np.eye(4, 3), "faces": [[0, 1, 2]], "vertex_normals": np.tile([0, 0, 1.0], (4, 1)), "uv": None}
    TriangleMesh(**good)
    with pytest.raises(SceneError, match=message):
        TriangleMesh(**{**good, **changes})


def test_arrays_cannot_be_written(small):
    for array in (small.vertices, small.faces, small.vertex_normals, small.uv):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0


def test_what_is_no_surface():
    with pytest.raises(SceneError, match="surface is .*; a Surface is needed"):
        mesh_of("tube")


def test_meshes_of_scenes_keep_names() -> None:
    from bladesmith.tracer.meshing.scenes import scene_meshes

    surfaces = [tracer.Sphere((0, 0, 0), 1), tracer.Sphere((3, 0, 0), 1)]
    surfaces[1].name = "moon"
    names = [mesh.name for mesh, _ in scene_meshes(tracer.Scene(CAMERA, [], surfaces), None, 4, 4)]
    assert names == ["0 sphere", "1 moon"]
