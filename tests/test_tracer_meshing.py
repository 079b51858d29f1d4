"""Meshes of surfaces: on the surface, with its normals, closed where it is, and the same in other programs."""

from __future__ import annotations

import json
import struct

import mpmath as mp
import numpy as np
import pytest
import trimesh
from click.testing import CliRunner
from hypothesis import given, settings
from hypothesis import strategies as st

from bladesmith import tracer
from bladesmith.cli.mesh import command
from bladesmith.curves import Bezier, KochanekBartels, RationalBezier
from bladesmith.errors import InputError, SceneError
from bladesmith.tracer.meshing import TriangleMesh, mesh_of
from bladesmith.tracer.meshing.rings import carried
from bladesmith.tracer.meshing.scenes import scene_meshes
from bladesmith.tracer.surfaces.evolved import EvolvedCircles, EvolvedPointPairs
from bladesmith.tracer.surfaces.facets import Facets

TUBE = [((0.0, 0.0, 0.0), (0.0, 0.0, 1.0), 1.0), ((0.0, 1.0, 2.0), (0.0, 0.5, 1.0), 0.6)]
BENT = [*TUBE, ((0.5, 2.0, 3.0), (0.2, 1.0, 0.4), 0.8), ((1.5, 3.0, 2.5), (1.0, 1.0, 0.1), 0.5)]
RIBBON = [((0.0, 0.0, 0.0), (1.0, 0.0, 0.0)), ((0.0, 1.0, 1.0), (1.0, 2.0, 0.5)), ((0.3, 2.5, 1.0), (1.2, 3.0, 1.5))]


def necklace(count=6, bend=0.2):
    """Circles around a closed curve that does not lie in a plane: carried around it, rings come back turned."""
    angles = 2 * np.pi * np.arange(count) / count
    return [
        ((3 * np.cos(a), 3 * np.sin(a), bend * np.sin(2 * a + 0.3)), (-np.sin(a), np.cos(a), bend * np.cos(3 * a)),
         0.8 + 0.2 * np.sin(a))
        for a in angles
    ]  # fmt: skip


def face_normals(mesh):
    a, b, c = (mesh.vertices[mesh.faces[:, i]] for i in range(3))
    normals = np.cross(b - a, c - a)
    return normals / np.linalg.norm(normals, axis=1, keepdims=True)


def agreement(mesh):
    """The least cosine between a triangle's normal and those at its corners."""
    return np.einsum("fi,fci->fc", face_normals(mesh), mesh.vertex_normals[mesh.faces]).min()


def as_trimesh(mesh):
    return trimesh.Trimesh(mesh.vertices, mesh.faces)


# -- the surface to 50 digits: skew matrices on e1 e2 e3 e+ e-, nothing of bladesmith's ---------------------

METRIC = mp.diag([1, 1, 1, 1, -1])
INFINITY = mp.matrix([0, 0, 0, 1, 1])


def vector(x):
    return mp.matrix([mp.mpf(float(v)) for v in x])


def point(x):
    square = (x.T * x)[0]
    return mp.matrix([*x, (square - 1) / 2, (square + 1) / 2])


def wedge(a, b):
    return a * b.T - b * a.T


def bivector(control):
    """A point pair A ^ B, or the dual S* ^ P* of a circle, of square +1 or -1."""
    if len(control) == 2:
        a, b = map(vector, control)
        return wedge(point(a), point(b)) * (2 / ((b - a).T * (b - a))[0])
    center, normal, radius = vector(control[0]), vector(control[1]), mp.mpf(float(control[2]))
    normal /= mp.norm(normal)
    sphere = (point(center) - radius**2 / 2 * INFINITY) / radius
    plane = mp.matrix([*normal, 0, 0]) + (normal.T * center)[0] * INFINITY
    return wedge(sphere, plane)


def projected(total, is_pair):
    """The nearest blade: of the two commuting ones that a bivector is the sum of."""
    f = total * METRIC
    second = f * f
    trace2 = sum(second[i, i] for i in range(5)) / 2
    fourth = second * second
    trace4 = sum(fourth[i, i] for i in range(5)) / 2
    root = mp.sqrt(2 * trace4 - trace2**2)
    first, other = ((trace2 + root) / 2, (trace2 - root) / 2) if is_pair else ((trace2 - root) / 2, (trace2 + root) / 2)
    blade = (f * second - other * f) / (first - other)
    return blade * METRIC / mp.sqrt(abs(first))


def located(blade):
    """Centre, unit axis and radius of M ^ H/r."""
    axis = blade * METRIC * INFINITY
    sphere = blade * METRIC * axis
    weight = -(sphere.T * METRIC * INFINITY)[0]
    size = mp.norm(axis[:3])
    return sphere[:3] / weight, axis[:3] / size, 1 / size


def place(controls, alpha):
    """Centre, axis and radius of a Bezier curve's object, and their derivatives, by differences at 50 digits."""
    degree = len(controls) - 1
    unit = [bivector(c) for c in controls]

    def at(t):
        total = mp.zeros(5)
        for k, c in enumerate(unit):
            total += mp.binomial(degree, k) * t**k * (1 - t) ** (degree - k) * c
        return located(projected(total, len(controls[0]) == 2))

    t, h = mp.mpf(float(alpha)), mp.mpf(10) ** -16
    before, here, after = at(t - h), at(t), at(t + h)
    return here, [(b - a) / (2 * h) for a, b in zip(before, after, strict=True)]


def cross(a, b):
    return mp.matrix([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


def dot(a, b):
    return sum(x * y for x, y in zip(a, b, strict=True))


@pytest.fixture
def digits():
    with mp.workdps(50):
        yield


def few(mesh, count, seed=0):
    return np.random.default_rng(seed).choice(len(mesh.vertices), count, replace=False)


@pytest.mark.parametrize("controls", [TUBE, BENT[:3], BENT], ids=["linear", "quadratic", "cubic"])
def test_vertices_of_circles_and_their_normals_to_fifty_digits(digits, controls):
    mesh = mesh_of(EvolvedCircles(Bezier(controls)), 12, 24)
    for i in few(mesh, 12):
        (center, axis, radius), (moved, turned, grown) = place(controls, mesh.uv[i, 1])
        spoke = vector(mesh.vertices[i]) - center
        assert abs(mp.norm(spoke) - radius) < 1e-14
        assert abs(dot(spoke, axis)) < 1e-14
        spoke /= mp.norm(spoke)
        velocity = moved + grown * spoke - radius * dot(turned, spoke) * axis
        normal = cross(cross(axis, spoke), velocity)
        cosine = dot(normal, vector(mesh.vertex_normals[i])) / mp.norm(normal)
        assert 1 - abs(cosine) < 1e-12
        assert cosine > 0  # outwards: along the circle, then along the curve


@pytest.mark.parametrize("count", [2, 3])
def test_vertices_of_point_pairs_and_their_normals_to_fifty_digits(digits, count):
    controls = RIBBON[:count]
    mesh = mesh_of(EvolvedPointPairs(Bezier(controls)), 12, 8)
    for i in few(mesh, 12):
        share = mp.mpf(float(mesh.uv[i, 0]))
        (center, axis, half), (moved, turned, grown) = place(controls, mesh.uv[i, 1])
        along = (2 * share - 1) * half
        assert mp.norm(center + along * axis - vector(mesh.vertices[i])) < 1e-14
        velocity = moved + (2 * share - 1) * (grown * axis + half * turned)
        normal = cross(axis, velocity)
        cosine = dot(normal, vector(mesh.vertex_normals[i])) / mp.norm(normal)
        assert 1 - abs(cosine) < 1e-12
        assert cosine > 0


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


@pytest.fixture(scope="module")
def ring():
    return EvolvedCircles(KochanekBartels(necklace(), closed=True))


def test_a_closed_tube_is_watertight(ring):
    mesh = ring.mesh(120, 40)
    solid = as_trimesh(mesh)
    assert solid.is_watertight
    assert solid.is_winding_consistent
    assert solid.is_volume
    assert solid.euler_number == 0  # a torus
    assert agreement(mesh) > 0.9
    welded = mesh.welded()
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
    total, wanted = carried(steps), []
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
    welded = mesh.welded()
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
        assert len(mesh.welded().vertices) == 13 * 16
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
    with pytest.raises(InputError, match=r"\.obj, \.ply, \.stl, \.glb, not \.fbx"):
        small.save(tmp_path / "tube.fbx")
    with pytest.raises(InputError, match="names none"):
        small.save(3)
    with pytest.raises(OSError, match="nowhere"):
        small.save(tmp_path / "nowhere" / "tube.obj")
    with pytest.raises(SceneError, match="scale"):
        small.save(tmp_path / "tube.obj", scale=-1.0)
    assert not list(tmp_path.iterdir())
    with pytest.raises(SceneError, match="no triangles"):
        TriangleMesh(small.vertices, small.faces[:0], small.vertex_normals).save(tmp_path / "none.obj")


def test_what_is_written_is_read_by_the_tracer(tmp_path, ring):
    from bladesmith.tracer.surfaces.facets import Mesh

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
    done = CliRunner().invoke(command, [str(tmp_path / "scene.toml"), "-o", str(target), "--rings", "8"])
    assert done.exit_code == 0, done.output
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


def test_the_command_writes_one_surface_and_refuses_others(tmp_path):
    (tmp_path / "scene.toml").write_text(SCENE)
    arguments = [str(tmp_path / "scene.toml"), "-o", str(tmp_path / "one.stl"), "--surface", "2", "--caps"]
    assert CliRunner().invoke(command, arguments).exit_code == 0
    assert trimesh.load(tmp_path / "one.stl").is_watertight
    failed = CliRunner().invoke(command, [*arguments[:3], "--surface", "7"])
    assert isinstance(failed.exception, InputError)
    assert "no surface 7; the scene has 3" in str(failed.exception)
    assert "Example: bladesmith mesh" in CliRunner().invoke(command, ["--help"]).output
    failed = CliRunner().invoke(command, [arguments[0], "-o", str(tmp_path / "one.xyz")])
    assert isinstance(failed.exception, InputError)


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
        ({"rings": 1 << 20, "segments": 1 << 20}, "more than a mesh can have"),
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
        ({"vertices": np.full((4, 3), np.nan)}, r"vertices\[0\] is not finite"),
        ({"vertex_normals": np.zeros((4, 3))}, "unit vectors"),
        ({"vertex_normals": np.zeros((3, 3))}, r"\(4, 3\)"),
        ({"uv": np.zeros((4, 3))}, r"\(4, 2\)"),
        ({"faces": [[0, 1, 4]]}, "not there"),
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
    with pytest.raises(SceneError, match="a str is no surface"):
        mesh_of("tube")
