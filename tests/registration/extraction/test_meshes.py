"""Models of meshes: planes and lines of solids that are known, however they are cut into triangles."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from bladesmith import errors
from bladesmith.interchange.meshes import Mesh, load_mesh
from bladesmith.registration.extraction.from_mesh import model_from_mesh
from bladesmith.registration.model.model import Model

from ...support.checkout import CHECKOUT

AIRPLANE = CHECKOUT / "examples" / "meshes" / "airplane.ply"
SIDES = (2.0, 3.0, 4.0)


def mesh_of(solid, scale=1.0, shift=0.0):
    return Mesh(np.asarray(solid.vertices) * scale + shift, np.asarray(solid.faces))


def box_model():
    """Planes and lines of a box about the origin."""
    x, y, z = np.array(SIDES) / 2
    planes = [(*n, d) for n, d in zip(np.eye(3), (x, y, z), strict=True)] + [
        (*-n, d) for n, d in zip(np.eye(3), (x, y, z), strict=True)
    ]
    signs = [(i, j) for i in (1, -1) for j in (1, -1)]
    lines = [[(0, i * y, j * z), (1, 0, 0)] for i, j in signs]
    lines += [[(i * x, 0, j * z), (0, 1, 0)] for i, j in signs] + [[(i * x, j * y, 0), (0, 0, 1)] for i, j in signs]
    return Model(planes=planes, lines=lines)


def are_the_same(a, b, tolerance=1e-9):
    """Whether each object of one is one of the other, once."""
    assert a.counts == b.counts
    both = Model(**{f"{kind}s": [x, b.objects[kind]] for kind, x in a.objects.items()})
    same = both.duplicates(tolerance)
    for kind, place in both.slices.items():
        n = a.counts[kind]
        np.testing.assert_array_equal(np.sort(same[place][n:]), place.start + np.arange(n))


@pytest.mark.parametrize("cuts", [0, 1, 3])
@pytest.mark.parametrize("scale, shift", [(1.0, 0.0), (1e-5, 0.0), (1e6, 0.0), (1.0, 1e5)])
def test_a_box_has_six_planes_and_twelve_lines(cuts, scale, shift):
    solid = trimesh.creation.box(extents=SIDES)
    for _ in range(cuts):
        solid = solid.subdivide()
    found = model_from_mesh(mesh_of(solid, scale, shift))
    are_the_same(found.in_frame((shift,) * 3, scale), box_model())
    assert (found.in_frame((shift,) * 3, scale).parameters["plane"][:, 3] > 0).all()  # normals look outward


def test_the_order_and_orientation_of_faces_do_not_matter():
    solid = trimesh.creation.box(extents=SIDES).subdivide().subdivide()
    rng = np.random.default_rng(0)
    faces = rng.permutation(np.asarray(solid.faces))
    turned = rng.random(len(faces)) < 0.4
    faces[turned] = faces[turned][:, ::-1]
    are_the_same(model_from_mesh(Mesh(solid.vertices, faces)), box_model())


def test_planes_and_lines_that_do_not_touch_are_one():
    first = trimesh.creation.box(extents=(1, 1, 1))
    second = first.copy()
    second.apply_translation((5, 0, 0))
    both = trimesh.util.concatenate([first, second])
    found = model_from_mesh(mesh_of(both))
    assert found.counts == {"line": 4 + 8 + 8, "plane": 4 + 4}
    np.testing.assert_array_equal(found.duplicates(1e-6), np.arange(len(found)))


def test_a_noisy_box_within_the_tolerance():
    solid = trimesh.creation.box(extents=SIDES).subdivide().subdivide()
    rng = np.random.default_rng(3)
    noisy = Mesh(solid.vertices + rng.normal(size=solid.vertices.shape) * 5e-4, solid.faces)
    found = model_from_mesh(noisy, tolerance=2e-3)
    are_the_same(found, box_model(), 5e-3)


def test_a_smooth_sphere_has_no_lines_and_flat_patches_only():
    solid = trimesh.creation.icosphere(subdivisions=3)
    with pytest.raises(errors.InputError, match="min_size"):
        model_from_mesh(mesh_of(solid), planes=False, angle=np.radians(15))
    found = model_from_mesh(mesh_of(solid), min_size=0.0, tolerance=1e-9)
    assert found.counts == {"plane": len(solid.faces)}  # no two facets are in one plane
    coarse = model_from_mesh(mesh_of(solid), min_size=0.0, tolerance=0.01)
    assert coarse.counts["plane"] < len(solid.faces) / 3
    assert (np.abs(coarse.parameters["plane"][:, 3] - 0.98) < 0.025).all()


def test_borders_are_lines():
    sheet = Mesh(np.array([(0.0, 0, 0), (2, 0, 0), (2, 1, 0), (0, 1, 0)]), np.array([(0, 1, 2), (0, 2, 3)]))
    found = model_from_mesh(sheet)
    assert found.counts == {"line": 4, "plane": 1}
    assert model_from_mesh(sheet, lines=False).counts == {"plane": 1}
    assert model_from_mesh(sheet, planes=False, min_size=0.75).counts == {"line": 2}  # of length 2; the others 1


def test_a_file_and_its_text(tmp_path):
    found = model_from_mesh(AIRPLANE, angle=np.radians(5), min_size=0.0, tolerance=5e-4, unit="mm", origin="PyVista")
    assert len(found) >= 1000 and found.name == "airplane" and found.unit == "mm" and found.origin == "PyVista"
    kept = Model.load(AIRPLANE.parent.parent / "registration" / "airplane.json")
    are_the_same(kept, found, 1e-9)
    np.testing.assert_array_equal(found.duplicates(1e-6), np.arange(len(found)))
    fewer = model_from_mesh(AIRPLANE, min_size=0.1)
    assert 10 < len(fewer) < len(found) / 3


def test_each_line_lies_along_edges_and_each_plane_on_faces():
    mesh = load_mesh(AIRPLANE)
    size = np.ptp(mesh.vertices, axis=0).max()
    found = model_from_mesh(mesh, angle=np.radians(10), tolerance=1e-3, min_size=0.01)
    corners = mesh.vertices[mesh.faces]
    for normal in found.parameters["plane"]:
        away = np.abs(corners @ normal[:3] - normal[3]).max(1)
        assert away.min() <= 1e-3 * size
    ends = mesh.edges
    for row in found.parameters["line"]:
        apart = ends - row[:3]
        across = np.linalg.norm(apart - (apart @ row[3:])[..., None] * row[3:], axis=-1).max(1)
        assert across.min() <= 1e-3 * size


@pytest.mark.parametrize("options, message", [
    ({"angle": -0.1}, "angle"), ({"angle": 2.0}, "angle"), ({"min_size": np.nan}, "min_size"),
    ({"tolerance": -1}, "tolerance"), ({"angle": "x"}, "angle"),
    ({"planes": False, "lines": False}, "no plane or line"),
])  # fmt: skip
def test_options_are_checked(options, message):
    with pytest.raises(errors.InputError, match=message):
        model_from_mesh(mesh_of(trimesh.creation.box()), **options)


def test_what_is_no_mesh(tmp_path):
    for bad in (tmp_path / "none.ply", tmp_path, 7, tmp_path / "a.txt"):
        with pytest.raises(errors.InputError):
            model_from_mesh(bad)
    with pytest.raises(errors.InputError, match="no faces"):
        model_from_mesh(Mesh(np.zeros((3, 3)), np.zeros((0, 3), int)))
    with pytest.raises(errors.InputError, match="one point"):
        model_from_mesh(Mesh(np.zeros((3, 3)), np.array([[0, 1, 2]])))


def test_faces_without_area_and_edges_without_length_are_left_out():
    corners = np.array([(0.0, 0, 0), (2, 0, 0), (2, 1, 0), (0, 1, 0), (2, 1, 0), (1, 0, 0)])
    sheet = Mesh(corners, np.array([(0, 1, 2), (0, 2, 3), (2, 4, 2), (2, 4, 3), (0, 5, 1)]))
    found = model_from_mesh(sheet)
    assert found.counts["plane"] == 1 and np.isfinite(found.parameters["line"]).all()


def test_without_trimesh_the_extra_is_named(monkeypatch):
    import sys

    monkeypatch.setitem(sys.modules, "trimesh", None)
    monkeypatch.setitem(sys.modules, "trimesh.graph", None)
    with pytest.raises(errors.MissingExtraError, match="mesh"):
        model_from_mesh(Mesh(np.eye(3), np.array([[0, 1, 2]])))
