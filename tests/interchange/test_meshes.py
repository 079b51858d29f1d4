"""Meshes from files: edges once each, the angles at them, damaged files named; the published mesh of the example."""

from __future__ import annotations

import hashlib
import json
import os
import runpy
import struct
import sys

import numpy as np
import pytest

import bladesmith as bs
from bladesmith import cga3d as cga
from bladesmith.errors import InputError, MissingExtraError, ShapeError
from bladesmith.interchange import meshes
from bladesmith.interchange.meshes import Mesh, load_mesh, mesh_lines

from ..support.checkout import CHECKOUT

pytest.importorskip("trimesh")
EXAMPLES = CHECKOUT / "examples"
AIRPLANE = EXAMPLES / "meshes" / "airplane.ply"

CUBE = np.array([(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)], float)
SQUARES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
TRIANGLES = np.array([t for a, b, c, d in SQUARES for t in ((a, b, c), (a, c, d))])


def write_obj(path, vertices, faces):
    lines = [f"v {x} {y} {z}" for x, y, z in vertices] + ["f " + " ".join(str(i + 1) for i in f) for f in faces]
    path.write_text("\n".join(lines) + "\n")
    return path


def write_ply(path, vertices, faces):
    head = f"ply\nformat ascii 1.0\nelement vertex {len(vertices)}\n"
    head += "".join(f"property double {axis}\n" for axis in "xyz")
    head += f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    rows = [f"{x} {y} {z}" for x, y, z in vertices] + [f"{len(f)} " + " ".join(map(str, f)) for f in faces]
    path.write_text(head + "\n".join(rows) + "\n")
    return path


def write_stl(path, vertices, faces):
    """Binary, in single precision: each triangle has corners of its own."""
    body = b"".join(struct.pack("<12fH", 0, 0, 0, *np.asarray(vertices, np.float32)[list(f)].ravel(), 0) for f in faces)
    path.write_bytes(b"cube".ljust(80) + struct.pack("<I", len(faces)) + body)
    return path


def write_glb(path, vertices, faces):
    """Single precision, half as large, in a node that doubles and moves it; the cube moves back."""
    corners = np.asarray((np.asarray(vertices) + 1) / 2, "<f4").tobytes()
    places = np.asarray(faces, "<u4").tobytes()
    scene = {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "scale": [2, 2, 2], "translation": [-1, -1, -1]}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": len(vertices), "type": "VEC3"},
            {"bufferView": 1, "componentType": 5125, "count": 3 * len(faces), "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": len(corners)},
            {"buffer": 0, "byteOffset": len(corners), "byteLength": len(places)},
        ],
        "buffers": [{"byteLength": len(corners) + len(places)}],
    }  # fmt: skip
    text = json.dumps(scene).encode()
    text += b" " * (-len(text) % 4)
    body = corners + places
    chunks = struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", len(body), 0x004E4942) + body
    path.write_bytes(struct.pack("<III", 0x46546C67, 2, 12 + len(chunks)) + chunks)
    return path


WRITERS = {".obj": write_obj, ".ply": write_ply, ".stl": write_stl, ".glb": write_glb}


@pytest.mark.parametrize("suffix", WRITERS)
def test_a_cube_from_every_format(suffix, tmp_path):
    mesh = load_mesh(WRITERS[suffix](tmp_path / f"cube{suffix}", CUBE, TRIANGLES))
    assert mesh.name == "cube" and mesh.vertices.shape == (8, 3) and mesh.faces.shape == (12, 3)
    assert mesh.edges.shape == (18, 2, 3)  # 12 and a diagonal of each side
    lengths = np.linalg.norm(mesh.edges[:, 1] - mesh.edges[:, 0], axis=1)
    np.testing.assert_allclose(np.sort(lengths), [1.0] * 12 + [np.sqrt(2)] * 6)
    np.testing.assert_allclose(np.sort(mesh.edge_angles), [0.0] * 6 + [np.pi / 2] * 12, atol=1e-7)
    lines, segments = mesh_lines(mesh, sharp=1.0)
    assert lines.kind.name == "line" and lines.shape == (12,) and segments.shape == (12, 2, 3)
    ends = cga.point(segments)
    assert np.abs((ends ^ lines[:, None]).values).max() < 1e-12  # the ends are on the lines


def test_squares_are_read_as_triangles(tmp_path):
    assert load_mesh(write_obj(tmp_path / "cube.obj", CUBE, SQUARES)).faces.shape == (12, 3)


def test_the_lines_of_a_cube_merge_to_its_twelve_edges():
    subdivided = [(a + (b - a) * s / 4, a + (b - a) * (s + 1) / 4) for a, b in cube_edges() for s in range(4)]
    starts, ends = np.array(subdivided).transpose(1, 0, 2)
    found = bs.objects.merge_similar(cga.line_through(starts, ends), 1e-6)
    assert sorted(found.counts) == [4] * 12


def cube_edges():
    return [(a, b) for i, a in enumerate(CUBE) for b in CUBE[i + 1 :] if np.abs(a - b).sum() == 1]


def test_angles_at_edges():
    """A roof of a known slope, its gable open; turned faces do not matter."""
    for slope in (0.0, 0.3, 1.2, 3.0):
        a, b = (0.0, 0.0, 0.0), (1.0, 0.0, 0.0)
        left, right = (0.3, -1.0, 0.0), (0.7, np.cos(slope), -np.sin(slope))
        for faces in ([(0, 1, 2), (0, 1, 3)], [(0, 1, 2), (1, 0, 3)]):
            mesh = Mesh(np.array([a, b, left, right]), np.array(faces))
            ridge = np.flatnonzero((mesh.edge_vertices == (0, 1)).all(1))
            assert mesh.edge_angles[ridge] == pytest.approx(slope, abs=1e-7)
            assert np.isinf(np.delete(mesh.edge_angles, ridge)).all() and len(mesh.edges) == 5
            assert mesh_lines(mesh, sharp=0.5)[0].shape == (4 + (slope > 0.5),)


def test_three_faces_at_an_edge_are_as_sharp_as_the_sharpest():
    vertices = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1)], float)
    mesh = Mesh(vertices, np.array([(0, 1, 2), (0, 1, 3), (0, 1, 4)]))
    assert mesh.edge_angles[0] == pytest.approx(np.pi / 2)


def test_triangles_without_area_are_left_out(tmp_path, caplog):
    vertices = np.vstack([CUBE, CUBE[0], (0.5, 0.5, 0.0)])
    faces = [*TRIANGLES, (0, 8, 3), (0, 0, 1), (0, 9, 6)]  # a repeated position, a repeated corner, three on a line
    mesh = load_mesh(write_ply(tmp_path / "cube.ply", vertices, faces))
    assert mesh.dropped_faces == 3 and mesh.faces.shape == (12, 3) and mesh.edges.shape == (18, 2, 3)
    assert "3 of 15 triangles have no area" in caplog.text
    assert (mesh_lines(mesh)[0].status == bs.Status.OK).all()
    with pytest.raises(InputError, match="all triangles"):
        load_mesh(write_ply(tmp_path / "flat.ply", vertices, faces[12:]))


def test_names_of_any_kind(tmp_path):
    for name in ("two words.obj", "Größe 立方.obj", "a.b.OBJ"):
        path = write_obj(tmp_path / name, CUBE, TRIANGLES)
        for given in (path, str(path), os.fsencode(path)):
            assert load_mesh(given).faces.shape == (12, 3)


def test_comments_of_another_encoding(tmp_path):
    path = write_obj(tmp_path / "cube.obj", CUBE, TRIANGLES)
    path.write_bytes("# Würfel\no Größe\n".encode("latin-1") + path.read_bytes())
    assert load_mesh(path).faces.shape == (12, 3)
    path = write_obj(tmp_path / "marked.obj", CUBE, TRIANGLES)
    path.write_text(path.read_text(encoding="utf-8"), encoding="utf-8-sig")  # as editors of Windows begin files
    assert load_mesh(path).faces.shape == (12, 3)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("unit", [1e-300, 1e-170, 1e100, 1e200, 1e300])
def test_in_any_unit(unit, tmp_path):
    mesh = load_mesh(write_ply(tmp_path / "cube.ply", CUBE * unit, TRIANGLES))
    assert mesh.faces.shape == (12, 3)
    np.testing.assert_allclose(np.sort(mesh.edge_angles), [0.0] * 6 + [np.pi / 2] * 12, atol=1e-7)


def test_meshes_from_arrays():
    mesh = Mesh(CUBE.tolist(), TRIANGLES.tolist())
    assert mesh.edges.shape == (18, 2, 3) and mesh_lines(mesh, sharp=1.0)[0].shape == (12,)
    empty = Mesh(np.zeros((0, 3)), np.zeros((0, 3), int))
    assert mesh_lines(empty)[0].shape == (0,) and mesh_lines(empty, sharp=1.0)[0].shape == (0,)
    for vertices, faces, error, message in (
        (CUBE[:, :2], TRIANGLES, ShapeError, r"vertices has shape \(8, 2\)"),
        (CUBE, TRIANGLES[:, :2], ShapeError, r"faces has shape \(12, 2\)"),
        (CUBE, TRIANGLES + 0.5, InputError, "faces holds float64"),
        (CUBE, TRIANGLES - 1, InputError, r"faces\[0\] is .* run from 0"),
        (CUBE, TRIANGLES + 1, InputError, "indices of 8 vertices"),
        (np.where(CUBE, np.nan, 0), TRIANGLES, InputError, r"vertices\[1, 2\] is nan"),
        ("cube", TRIANGLES, InputError, "real numbers"),
    ):
        with pytest.raises(error, match=message):
            Mesh(vertices, faces)


@pytest.mark.filterwarnings("error")
def test_sides_without_length_have_no_line_and_no_angle():
    mesh = Mesh(CUBE, np.array([(0, 0, 1), (0, 0, 2)]))
    lines, _ = mesh_lines(mesh)
    assert (lines.status != bs.Status.OK).sum() == 1
    assert not np.isnan(mesh.edge_angles).any()


def damaged(tmp_path):
    """Name of a file, its bytes, and what is said of it."""
    cube = write_ply(tmp_path / "whole.ply", CUBE, TRIANGLES).read_bytes()
    stl = write_stl(tmp_path / "whole.stl", CUBE, TRIANGLES).read_bytes()
    return [
        ("empty.ply", b"", "cannot be read|no triangles"),
        ("empty.obj", b"", "cannot be read|no triangles"),
        ("empty.stl", b"", "cannot be read|no triangles"),
        ("text.ply", b"this is no mesh\n" * 9, "cannot be read|no triangles"),
        ("noise.stl", bytes(range(256)), "cannot be read|no triangles|a finite number|no area|without an area"),
        ("cut.ply", cube[: len(cube) // 2], "cannot be read|no triangles|run from 0"),
        ("cut.stl", stl[:200], "cannot be read|no triangles"),
        ("cloud.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\n", "no triangles|cannot be read"),
        ("missing.obj", b"v 0 0 0\nv 1 0 0\nf 1 2 9\n", "cannot be read|run from 0"),
        ("missing.ply", cube.replace(b"3 0 1 3\n", b"3 0 1 99\n"), "cannot be read|run from 0"),
        ("nan.ply", cube.replace(b"0.0 0.0 1.0\n", b"0.0 nan 1.0\n"), "a finite number"),
    ]


def test_damaged_files_are_named(tmp_path):
    for name, content, message in damaged(tmp_path):
        path = tmp_path / name
        path.write_bytes(content)
        with pytest.raises(InputError, match=message) as caught:
            load_mesh(path)
        assert name in str(caught.value)


def test_what_is_no_mesh_file_is_named(tmp_path):
    with pytest.raises(InputError, match="no such file"):
        load_mesh(tmp_path / "none.ply")
    with pytest.raises(InputError, match=r"\.obj, \.ply, \.stl, \.glb, not \.png"):
        load_mesh(tmp_path / "picture.png")
    with pytest.raises(InputError, match="a name without an ending"):
        load_mesh(tmp_path)
    with pytest.raises(InputError, match="no such file"):
        load_mesh("x" * 5000 + ".ply")
    for path in (None, 3, [], np.zeros(3)):
        with pytest.raises(InputError, match="names none"):
            load_mesh(path)
    for sharp in (-0.1, 4.0, np.nan, "much", 1j, np.zeros(2)):
        with pytest.raises(InputError, match="sharp"):
            mesh_lines(Mesh(CUBE, TRIANGLES), sharp=sharp)


def test_the_extra_is_named(tmp_path, monkeypatch):
    path = write_obj(tmp_path / "cube.obj", CUBE, TRIANGLES)
    monkeypatch.setitem(sys.modules, "trimesh", None)
    with pytest.raises(MissingExtraError, match=r"bladesmith\[mesh\]"):
        load_mesh(path)


# -- the published one -----------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def airplane():
    if not AIRPLANE.is_file():
        pytest.skip("the examples are not here")
    return load_mesh(AIRPLANE)


def test_the_mesh_is_the_published_one(airplane):
    digest = hashlib.sha256(AIRPLANE.read_bytes()).hexdigest()
    assert digest in (AIRPLANE.parent / "README.md").read_text("utf-8")
    assert airplane.vertices.shape == (1335, 3) and airplane.faces.shape == (2452, 3)
    assert len(airplane.edges) == 3789 and airplane.dropped_faces == 0


def test_its_angles_are_those_between_the_normals(airplane):
    """Of consistently turned faces: another way to the same angles."""
    a, b, c = (airplane.vertices[airplane.faces[:, i]] for i in range(3))
    normal = np.cross(b - a, c - a)
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    faces_at = {}
    for number, face in enumerate(airplane.faces):
        for i in range(3):
            faces_at.setdefault(tuple(sorted((face[i], face[i - 1]))), []).append(number)
    for pair, angle in zip(airplane.edge_vertices, airplane.edge_angles, strict=True):
        at = faces_at[tuple(pair)]
        if len(at) == 1:
            assert angle == np.inf
        else:
            between = np.arccos(np.clip(normal[at[0]] @ normal[at[1]], -1, 1))
            assert angle == pytest.approx(between, abs=1e-6)


def test_merged_lines_stay_near_the_edges_that_they_stand_for(airplane):
    size = np.ptp(airplane.vertices, axis=0).max()
    mesh = Mesh(airplane.vertices / size * 10, airplane.faces)
    lines, segments = mesh_lines(mesh, sharp=0.2)
    threshold = 1e-3
    found, groups = bs.objects.merge_similar(lines, threshold)
    assert len(lines) > 1000 and len(found) < 0.9 * len(lines)
    point, along = found.parameters()
    offset = segments - point[groups][:, None]
    across = offset - np.einsum("nij,nj->ni", offset, along[groups])[..., None] * along[groups][:, None]
    assert np.median(np.linalg.norm(across, axis=-1)) < np.sqrt(threshold)


def test_the_example_runs(airplane, tmp_path, monkeypatch, capsys):
    pytest.importorskip("matplotlib")
    monkeypatch.setattr(sys, "argv", ["simplify_mesh.py", "--output", str(tmp_path / "picture.png")])
    runpy.run_path(str(EXAMPLES / "simplify_mesh.py"), run_name="__main__")
    said = capsys.readouterr().out
    assert "3789 edges" in said and "lines became" in said
    assert (tmp_path / "picture.png").stat().st_size > 20_000


def test_formats_are_those_that_are_tested():
    assert set(WRITERS) == set(meshes.FORMATS)
