"""Facets from files and arrays: normals, areas, large meshes, bad input."""

from __future__ import annotations

import logging
import time

import numpy as np
import pytest
import trimesh

import bladesmith as bs
from bladesmith import tracer
from bladesmith.errors import InputError, SceneError
from bladesmith.interchange.meshes import load_mesh, vertex_normals
from bladesmith.tracer.surfaces.triangles import Facets, Mesh

from ...support.tracer.facets import ONE, TRIANGLE, first

# -- files ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("ending", [".obj", ".ply", ".stl", ".glb"])
def test_meshes_from_files(tmp_path, ending):
    ball = trimesh.creation.icosphere(subdivisions=2)
    path = tmp_path / f"ball{ending}"
    ball.export(path)
    surface = Mesh(path, scale=2.0)
    assert len(surface) == len(ball.faces)
    assert surface.dropped_faces == 0
    found = surface.intersect((0, -5, 0), (0.01, 1, 0.02))
    assert found.count == 2
    assert abs(np.linalg.norm(found.point[0]) - 2) < 0.1
    smooth = Mesh(path, smooth=True)
    assert np.abs(smooth.normals - smooth.vertices / np.linalg.norm(smooth.vertices, axis=1)[:, None]).max() < 0.05


def test_normals_of_a_file_are_used(tmp_path):
    path = tmp_path / "one.obj"
    path.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0.6 0 0.8\nvn 0 0 1\nvn 0 0.6 0.8\nf 1//1 2//2 3//3\n")
    surface = Mesh(path, smooth=True)
    order = np.lexsort(surface.vertices.T)
    wanted = {(0, 0, 0): (0.6, 0, 0.8), (1, 0, 0): (0, 0, 1), (0, 1, 0): (0, 0.6, 0.8)}
    for i in order:
        assert np.allclose(surface.normals[i], wanted[tuple(surface.vertices[i].astype(int))])


def test_means_of_normals_do_not_depend_on_how_polygons_are_cut():
    """At the corner of a cube with one face in two triangles and the others in one: angles count, not triangles."""
    corner = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1.0]])
    faces = np.array([[0, 2, 1], [0, 3, 2], [0, 1, 4], [0, 4, 3]])
    from bladesmith.interchange.meshes import Mesh as Triangles

    normal = vertex_normals(Triangles(corner, faces))[0]
    assert np.allclose(normal, -np.ones(3) / np.sqrt(3), atol=1e-15)


def test_triangles_of_files_without_an_area_are_left_out(tmp_path, caplog):
    path = tmp_path / "thin.obj"
    path.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 2 0 0\nf 1 2 3\nf 1 2 4\n")
    with caplog.at_level(logging.WARNING, "bladesmith"):
        surface = Mesh(path)
    assert (len(surface), surface.dropped_faces) == (1, 1)
    assert "1 of 2 triangles have no area" in caplog.text


def test_a_sheet_with_two_sides_has_normals(tmp_path):
    path = tmp_path / "sheet.obj"
    path.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 3 2\n")
    surface = Mesh(path, smooth=True)
    assert np.allclose(np.abs(surface.normals), [0, 0, 1])


def test_files_that_are_no_meshes(tmp_path):
    with pytest.raises(InputError, match="no such file"):
        Mesh(tmp_path / "none.obj")
    (tmp_path / "broken.glb").write_bytes(b"glTF nothing")
    with pytest.raises(InputError, match="cannot be read as a mesh"):
        Mesh(tmp_path / "broken.glb")
    (tmp_path / "one.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 0\nf 1//1 2//1 3//1\n")
    with pytest.raises(InputError, match="normal of vertex"):
        Mesh(tmp_path / "one.obj", smooth=True)
    with pytest.raises(SceneError, match="mesh.scale"):
        Mesh(tmp_path / "one.obj", scale=0.0)


@pytest.mark.slow
def test_a_large_mesh_is_ready_at_once():
    ball = trimesh.creation.icosphere(subdivisions=6)
    faces = np.concatenate([ball.faces, ball.faces + len(ball.vertices)])
    vertices = np.concatenate([ball.vertices, ball.vertices * 2])
    first(Facets(TRIANGLE, ONE), (0, 0, -1), (0, 0, 1))  # compiled
    best = np.inf
    for _ in range(3):
        start = time.process_time()  # other programs do not count
        found = first(Facets(vertices, faces), (0, 0, 0), (0.1, 0.2, 0.3))
        best = min(best, time.process_time() - start)
    assert found.hit
    assert best < 1.0


# -- bad input -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("vertices", "faces", "options", "message"),
    [
        (TRIANGLE[:, :2], ONE, {}, r"vertices has shape \(3, 2\)"),
        ("abc", ONE, {}, "real numbers are needed"),
        ([[0, 0, 0], [1, np.nan, 0], [0, 1, 0]], ONE, {}, r"vertices\[1, 1\] is nan"),
        (TRIANGLE, [[0, 1, 3]], {}, r"faces\[0\] is \[0, 1, 3\]; indices of 3 vertices"),
        (TRIANGLE, [[0, 1, 2], [0, -1, 2]], {}, r"faces\[1\]"),
        (TRIANGLE, [[0.0, 1.0, 2.0]], {}, "whole numbers"),
        (TRIANGLE, [[0, 1, 2, 0]], {}, "Split polygons"),
        (TRIANGLE, [[0, 1, 2], [0, 1, 1]], {}, r"faces\[1\] is \[0, 1, 1\], a triangle without an area"),
        ([[0, 0, 0], [1, 1, 1], [2, 2, 2]], ONE, {}, "without an area"),
        (TRIANGLE, ONE, {"normals": np.ones((2, 3))}, r"normals has shape \(2, 3\); \(3, 3\) is needed"),
        (TRIANGLE, ONE, {"normals": [[0, 0, 1], [0, 0, 0], [0, 0, 1]]}, r"normals\[1\] is zero"),
        (TRIANGLE * 1e80, ONE, {}, "another unit"),
        (TRIANGLE * 1e-80, ONE, {}, "another unit"),
        (TRIANGLE, ONE, {"material": {"checker": (1, 1, 1)}}, "checker"),
    ],
)
def test_bad_facets_are_named(vertices, faces, options, message):
    with pytest.raises(SceneError, match=message):
        Facets(vertices, faces, **options)


def test_rays_that_are_none_have_a_status():
    surface = Facets(TRIANGLE, ONE)
    found = first(surface, [[0.2, 0.2, 1], [np.nan, 0, 0], [0, 0, 1]], [[0, 0, -1], [0, 0, 1], [0, 0, 0.0]])
    assert found.status.tolist() == [bs.Status.OK, bs.Status.INVALID, bs.Status.INVALID]
    assert found.hit.tolist() == [True, False, False]


def test_no_faces_are_no_surface_to_meet():
    empty = Facets(TRIANGLE, np.zeros((0, 3), int))
    assert not first(empty, (0.2, 0.2, 1), (0, 0, -1)).hit


def test_arrays_are_copies_that_cannot_be_written():
    given = TRIANGLE.copy()
    surface = Facets(given, ONE)
    given[0] = 9
    assert np.array_equal(surface.vertices, TRIANGLE)
    with pytest.raises(ValueError, match="read-only"):
        surface.vertices[0] = 1


@pytest.mark.compiles
def test_shapes_smooth_and_flat_in_one_picture():
    ball = trimesh.creation.icosphere(subdivisions=2)
    surfaces = [
        Facets(ball.vertices, ball.faces),
        Facets(ball.vertices + [2.5, 0, 0], ball.faces, normals=ball.vertices, material={"reflectivity": 0.3}),
        tracer.Plane((0, 0, 1), -1.0),
    ]
    camera = tracer.Camera.look_at((1, -8, 2), (1, 0, 0))
    image = tracer.Scene(camera, [tracer.Light((4, -6, 8))], surfaces).render(48, 32)
    assert np.isfinite(image).all()
    assert load_mesh  # the reader that `Mesh` shares with registration
