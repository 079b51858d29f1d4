"""Meshes of surfaces: their shape, closed curves, joints and tips, far away, and under another ray tracer."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from bladesmith import tracer
from bladesmith.curves import Bezier, KochanekBartels, RationalBezier
from bladesmith.errors import SceneError
from bladesmith.tracer.meshing.tubes import cumulative_products
from bladesmith.tracer.surfaces.evolved import EvolvedCircles, EvolvedPointPairs
from bladesmith.tracer.surfaces.triangles import Facets

from ...support.tracer.meshes import BENT, agreement, as_trimesh, face_normals, necklace
from ...support.tracer.scenes import TUBE

# -- shapes whose volume is known --------------------------------------------------------------------------


def test_one_band_between_equal_circles_is_a_prism():
    surface = EvolvedCircles([((0, 0, 0), (0, 0, 1), 1.0), ((0, 0, 2), (0, 0, 1), 1.0)])
    mesh = surface.mesh(1, 96, caps=True)
    assert mesh.volume == pytest.approx(96 / 2 * np.sin(2 * np.pi / 96) * 2, rel=1e-14)
    assert as_trimesh(mesh).is_watertight
    assert as_trimesh(mesh).is_winding_consistent
    ends = mesh.vertex_normals[np.abs(mesh.vertex_normals[:, 2]) == 1]
    assert len(ends) == 2 * 98  # flat lids, with corners of their own
    assert not as_trimesh(surface.mesh()).is_watertight


@pytest.mark.parametrize("direction", [1.0, -1.0])
def test_coaxial_circles_make_a_zone_of_a_sphere(direction):
    """They are on one sphere, and so is everything between; volumes converge with the square of the number of quads."""
    low, high, r1, r2 = -0.5, 1.5, 2.0, 1.0
    surface = EvolvedCircles([((0, 0, low), (0, 0, direction), r1), ((0, 0, high), (0, 0, direction), r2)])
    height = high - low
    middle = (r2**2 - r1**2 + high**2 - low**2) / (2 * height)
    radius = np.hypot(r1, middle - low)
    exact = np.pi * height * (3 * r1**2 + 3 * r2**2 + height**2) / 6
    errors = []
    for n in (32, 64, 128):
        mesh = surface.mesh(n, n, caps=True)
        errors.append(exact - mesh.volume)
    assert errors[0] / errors[1] == pytest.approx(4, rel=0.01)
    assert errors[1] / errors[2] == pytest.approx(4, rel=0.01)
    assert 0 < errors[2] < 1e-3 * exact
    plain = surface.mesh(16, 16)
    spokes = plain.vertices - [0, 0, middle]
    assert np.abs(np.linalg.norm(spokes, axis=1) - radius).max() < 1e-14
    assert np.abs(spokes / radius - plain.vertex_normals).max() < 1e-13  # outwards, whichever way the circles turn


def test_concentric_circles_make_a_flat_ring():
    mesh = EvolvedCircles([((0, 0, 0), (0, 0, 1), 1.0), ((0, 0, 0), (0, 0, 1), 3.0)]).mesh(8, 32)
    assert np.abs(mesh.vertices[:, 2]).max() < 1e-15
    assert np.allclose(np.abs(mesh.vertex_normals), [0, 0, 1])
    assert agreement(mesh) > 0.999


def test_a_sphere_a_disc_a_plane():
    ball = tracer.Sphere((1, 2, 3), 2.0).mesh(48, 96)
    assert as_trimesh(ball).is_watertight
    assert ball.volume == pytest.approx(4 / 3 * np.pi * 8, rel=3e-3)
    assert np.allclose((ball.vertices - [1, 2, 3]) / 2, ball.vertex_normals)
    assert agreement(ball) > 0.99
    disc = tracer.Disc((1, 2, 3), (0, 1, 1), 2.0).mesh(segments=48)
    assert agreement(disc) > 1 - 1e-12
    assert as_trimesh(disc).area == pytest.approx(48 / 2 * np.sin(2 * np.pi / 48) * 4)
    patch = tracer.Plane((0, 3, 4), 10.0).mesh(extent=3.0, center=(5, 5, 5))
    assert np.allclose(patch.vertices @ [0, 0.6, 0.8], 2.0)
    assert as_trimesh(patch).area == pytest.approx(9)
    assert agreement(patch) > 1 - 1e-12
    with pytest.raises(SceneError, match="extent"):
        tracer.Plane((0, 0, 1), 0.0).mesh()


def test_triangles_stay_what_they_are():
    ball = trimesh.creation.icosphere(subdivisions=1)
    flat = Facets(ball.vertices, ball.faces).mesh()
    assert len(flat.vertices) == 3 * len(ball.faces)
    assert np.allclose(face_normals(flat), flat.vertex_normals[flat.faces[:, 0]])
    smooth = Facets(ball.vertices, ball.faces, normals=ball.vertices).mesh()
    assert np.array_equal(smooth.faces, ball.faces)
    assert np.allclose(smooth.vertex_normals, ball.vertices)


# -- closed curves -----------------------------------------------------------------------------------------


def test_a_closed_tube_is_watertight(ring):
    mesh = ring.mesh(120, 40)
    solid = as_trimesh(mesh)
    assert solid.is_watertight
    assert solid.is_winding_consistent
    assert solid.is_volume
    assert solid.euler_number == 0  # a torus
    assert agreement(mesh) > 0.9
    welded = mesh.weld()
    assert trimesh.Trimesh(welded.vertices, welded.faces, process=False).is_watertight
    assert len(welded.vertices) == 120 * 40


def test_the_volume_of_a_closed_tube_is_what_rays_measure(ring):
    """The exact surface, cut by parallel rays: lengths inside times the area of a ray."""
    mesh = ring.mesh(240, 120)
    x, y = np.meshgrid(*[(np.arange(100) + 0.5) / 100 * 9 - 4.5] * 2)
    origins = np.stack([x, y, np.full_like(x, -5)], -1).reshape(-1, 3)
    found = ring.intersect(origins, (0, 0, 1))
    count = found.count
    assert (count % 2 == 0).mean() > 0.999
    even = count % 2 == 0
    signs = np.where(np.arange(found.t.shape[-1]) % 2, 1.0, -1.0)
    inside = np.nansum(np.where(np.isnan(found.t), 0.0, found.t) * signs, axis=1)[even].sum() * (9 / 100) ** 2
    assert mesh.volume == pytest.approx(inside, rel=1e-2)


def test_the_texture_runs_through_the_seams(ring):
    """The last row is the first in every bit and at the same u, and so is the last column."""
    mesh = ring.mesh(60, 24)
    rows = mesh.vertices.reshape(-1, 25, 3)
    u, v = mesh.uv.reshape(-1, 25, 2)[..., 0], mesh.uv.reshape(-1, 25, 2)[..., 1]
    assert np.array_equal(rows[0], rows[-1])
    assert np.array_equal(rows[:, 0], rows[:, -1])
    assert (v[0] == 0).all()
    assert (v[-1] == 6).all()
    assert (u[:, 0] == 0).all()
    assert (u[:, -1] == 1).all()
    assert np.array_equal(mesh.vertex_normals.reshape(-1, 25, 3)[0], mesh.vertex_normals.reshape(-1, 25, 3)[-1])


def test_quads_are_not_twisted(ring):
    """Around the closed curve the rings come back turned; that turn is spread evenly, and nothing is added to it."""
    rows = ring.mesh(240, 24).vertices.reshape(-1, 25, 3)[:, :-1]
    centers = rows.mean(1)
    spokes = rows[:, 0] - centers
    spokes /= np.linalg.norm(spokes, axis=1, keepdims=True)
    axes = np.cross(rows[:, 0] - centers, rows[:, 6] - centers)
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    turns = []
    for i in range(len(rows) - 1):
        a, b = axes[i], axes[i + 1]
        v = np.cross(a, b)  # Rodrigues: the smallest rotation from a to b
        carried_ = spokes[i] + np.cross(v, spokes[i]) + np.cross(v, np.cross(v, spokes[i])) / (1 + a @ b)
        turns.append(np.arctan2(np.cross(carried_, spokes[i + 1]) @ b, carried_ @ spokes[i + 1]))
    assert abs(np.sum(turns)) > 0.01  # this curve has a turn to take back
    assert np.abs(np.sum(turns)) <= np.pi
    assert np.ptp(turns) < 1e-9  # each takes the same part of it


def test_open_tubes_are_carried_without_any_turn():
    rows = EvolvedCircles(Bezier(BENT)).mesh(64, 24).vertices.reshape(-1, 25, 3)[:, :-1]
    centers = rows.mean(1)
    spokes = rows[:, 0] - centers
    axes = np.cross(rows[:, 0] - centers, rows[:, 6] - centers)
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    spokes /= np.linalg.norm(spokes, axis=1, keepdims=True)
    for i in range(len(rows) - 1):
        v = np.cross(axes[i], axes[i + 1])
        moved = spokes[i] + np.cross(v, spokes[i]) + np.cross(v, np.cross(v, spokes[i])) / (1 + axes[i] @ axes[i + 1])
        assert np.linalg.norm(moved - spokes[i + 1]) < 1e-12


def test_products_of_rotors_are_those_of_a_loop():
    from bladesmith import cga3d

    rng = np.random.default_rng(4)
    steps = cga3d.rotor(rng.normal(size=(37, 3)), rng.uniform(-2, 2, 37))
    total, wanted = cumulative_products(steps), []
    running = None
    for i in range(37):
        running = steps[i] if running is None else steps[i] * running
        wanted.append(np.asarray(running.as_kind("rotor", check=False).values))
    assert np.abs(np.asarray(total.values) - wanted).max() < 1e-14


def test_a_closed_ribbon():
    angles = 2 * np.pi * np.arange(7) / 7
    a = np.stack([2 * np.cos(angles), 2 * np.sin(angles), -0.5 + 0 * angles], 1)
    b = np.stack([2.5 * np.cos(angles), 2.5 * np.sin(angles), 0.5 + 0 * angles], 1)
    from bladesmith import cga3d

    mesh = EvolvedPointPairs(KochanekBartels(cga3d.point_pair(a, b), closed=True)).mesh(70, 6)
    welded = mesh.weld()
    assert len(welded.vertices) == 70 * 7
    assert agreement(mesh) > 0.9


# -- joints, tips, gaps ------------------------------------------------------------------------------------


def test_smooth_joints_share_vertices_and_sharp_ones_have_two_normals():
    controls = necklace()[:4]
    smooth = EvolvedCircles(KochanekBartels(controls)).mesh(12, 16)
    sharp = EvolvedCircles(KochanekBartels(controls, continuity=-0.8)).mesh(12, 16)
    assert len(smooth.vertices) == 13 * 17
    assert len(sharp.vertices) == 15 * 17
    for mesh in (smooth, sharp):
        assert len(mesh.faces) == 12 * 16 * 2
        assert len(mesh.weld().vertices) == 13 * 16
        assert agreement(mesh) > 0.3


def test_a_cone_has_a_tip():
    mesh = EvolvedPointPairs([((0, 0, 0), (1, 0, 0)), ((0, 0, 0), (0, 1, 1))]).mesh(32, 8)
    tip = np.linalg.norm(mesh.vertices, axis=1) < 1e-14
    assert tip.any()
    assert len(np.unique(mesh.vertices[tip], axis=0)) == 1
    assert agreement(mesh) > 0.99
    assert np.isfinite(mesh.vertex_normals).all()
    assert len(mesh.faces) == 32 * (2 * 8 - 1)  # one triangle for each band at the tip


def test_what_is_imaginary_is_refused_or_left_out():
    zone = np.sqrt(1 - 0.81)
    opposed = [((0, 0, 0.9), (0, 0, 1), zone), ((0, 0, -0.9), (0, 0, -1), zone)]
    with pytest.raises(SceneError, match=r"alpha from 0\.05 to 0\.95"):
        EvolvedCircles(opposed, align=False).mesh()
    mesh = EvolvedCircles(opposed, align=False, gaps=True).mesh(32, 24)
    assert np.abs(np.linalg.norm(mesh.vertices, axis=1) - 1).max() < 1e-12
    alpha = mesh.uv[:, 1]
    assert not ((alpha > 0.0501) & (alpha < 0.9499)).any()
    assert ((alpha < 0.05 + 1e-6) | (alpha > 0.95 - 1e-6)).all()
    tips = np.abs(np.abs(mesh.vertices[:, 2]) - 1) < 1e-6
    assert tips.any()  # the rings shrink to the poles
    assert np.einsum("ij,ij->i", mesh.vertices, mesh.vertex_normals).min() > 0.999  # both parts outwards
    assert agreement(mesh) > 0.9


def test_a_circle_that_becomes_a_line_names_the_interval():
    surface = EvolvedCircles([((0, 0, 0), (0, 0, 1), 1.0), ((4, 0, 0), (0, 0, -1), 1.0)])
    with pytest.raises(SceneError, match=r"become lines.*alpha = 0\.48\d* and 0\.51"):
        surface.mesh(64, 16)


# -- far away ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "curve", [lambda c: c, lambda c: KochanekBartels(c), lambda c: RationalBezier(c, [1, 2, 1, 3])]
)
def test_far_from_the_origin(curve):
    """The same mesh 1e6 away: positions to their rounding, normals to theirs."""
    shift = np.array([1e6, -2e6, 5e5])
    far = [(np.array(c) + shift, n, r) for c, n, r in BENT]
    near_mesh, far_mesh = EvolvedCircles(curve(BENT)).mesh(24, 16), EvolvedCircles(curve(far)).mesh(24, 16)
    assert np.abs(far_mesh.vertices - shift - near_mesh.vertices).max() < 1e-9
    assert np.abs(far_mesh.vertex_normals - near_mesh.vertex_normals).max() < 1e-8


@given(st.floats(-7, 7), st.floats(-1e4, 1e4))
@settings(max_examples=15, deadline=None)
def test_any_size_anywhere(power, shift):
    size = 10.0**power
    controls = [(np.array(c) * size + shift * size, n, r * size) for c, n, r in TUBE]
    mesh, wanted = EvolvedCircles(controls).mesh(6, 8), EvolvedCircles(TUBE).mesh(6, 8)
    assert np.abs((mesh.vertices - shift * size) / size - wanted.vertices).max() < 1e-11
    assert np.abs(mesh.vertex_normals - wanted.vertex_normals).max() < 1e-9


# -- an independent ray tracer on the mesh -----------------------------------------------------------------


@pytest.mark.peers
def test_embree_on_the_mesh_meets_the_surface():
    """Points on the tessellation come near those on the surface with the square of the number of quads."""
    from trimesh.ray.ray_pyembree import RayMeshIntersector

    surface = EvolvedCircles(TUBE)
    rng = np.random.default_rng(3)
    origins = rng.normal(size=(3000, 3)) * 0.3 + [3.0, 0.5, 1.0]
    directions = np.array([0.0, 0.5, 1.0]) + rng.normal(size=(3000, 3)) * 0.15 - origins
    camera = tracer.Camera.look_at((3, 0.5, 1), (0, 0.5, 1))
    exact = tracer.Scene(camera, [], [surface]).intersect(origins, directions)
    medians = []
    for n in (32, 64):
        mesh = as_trimesh(surface.mesh(n, n))
        place_, ray, _ = RayMeshIntersector(mesh).intersects_location(origins, directions, multiple_hits=False)
        both = exact.hit[ray]
        medians.append(np.median(np.linalg.norm(place_ - exact.point[ray], axis=1)[both]))
    assert medians[0] / medians[1] == pytest.approx(4, rel=0.25)
    assert medians[1] < 2e-3


@pytest.mark.parametrize("count", [2, 3])
def test_caps_close_circles_that_share_a_point(count):
    """All pass through (1, 0, 0), where they turn about e2: the rings there are one vertex, those of the lids too."""
    controls = []
    for angle in np.linspace(0, 1.2, count):
        axis, across = (np.sin(angle), 0.0, np.cos(angle)), np.array([np.cos(angle), 0.0, -np.sin(angle)])
        controls.append((tuple(np.array([1.0, 0.0, 0.0]) - across), axis, 1.0))
    mesh = tracer.EvolvedCircles(controls).mesh(16, 24, caps=True).weld()
    sides = np.sort(np.concatenate([mesh.faces[:, [i, (i + 1) % 3]] for i in range(3)]), axis=1)
    edges, used = np.unique(sides, axis=0, return_counts=True)
    assert (used == 2).all() and len(np.unique(mesh.faces)) - len(edges) + len(mesh.faces) == 2


@pytest.mark.parametrize("along", [(1.0, 0.0, 0.0), (0.3, 0.5, -0.2)])
@pytest.mark.parametrize("start", [0.0, 1.0])
def test_pairs_within_one_line_sweep_nothing(along, start):
    ends = [start + t * np.array(along) for t in (0, 4, 1, 2)]
    surface = tracer.EvolvedPointPairs([tuple(map(tuple, ends[:2])), tuple(map(tuple, ends[2:]))])
    with pytest.raises(SceneError, match="the surface is a line: it has no area"):
        surface.mesh(4, 4)


@pytest.mark.parametrize("radius", [1e-7, 1e-10])
def test_circles_that_rounding_eats_are_called_so(radius):
    """They are real, and no control is to be flipped."""
    surface = tracer.EvolvedCircles([((0, 0, 0), (0, 0, 1), 1.0), ((0, 0, 1), (0, 0, 1), radius)])
    with pytest.raises(SceneError, match="circles that are lost to rounding.*between alpha = 0.875 and 1"):
        surface.mesh(8, 8)
