"""Rays against surfaces, compared with plain geometry that shares no formula with the tracer."""

from __future__ import annotations

import math

import mpmath
import numpy as np
import pytest

from bladesmith import cga3d, pga3d, tracer
from bladesmith.curves import Bezier
from bladesmith.errors import InputError, SceneError
from bladesmith.status import Status

from ...oracles.circle_sums import dot, exact
from ...support.tracer.scenes import TUBE, line_direction

U = 2.0**-53
LINE = cga3d.line((0, 0, 0), (0, 0, 1))
CAMERA = tracer.Camera.look_at((0.0, -8.0, 2.0), (0.0, 0.0, 0.5))


def exact_sphere(origin, direction, center, radius):
    """Distances of a line's points on a sphere at 50 digits, nearest first; none where it passes."""
    o, d, c = exact(origin), exact(direction), exact(center)
    q = [a - b for a, b in zip(o, c, strict=True)]
    half, square = dot(q, d), dot(d, d)
    under = half**2 - square * (dot(q, q) - mpmath.mpf(float(radius)) ** 2)
    if under < 0:
        return []
    return [(-half + s * mpmath.sqrt(under)) / mpmath.sqrt(square) for s in (-1, 1)]


# -- spheres, planes, discs ----------------------------------------------------------------------------------


def test_spheres_equal_the_quadratic_at_fifty_digits():
    random = np.random.default_rng(1)
    mpmath.mp.dps = 50
    for scale in (1e-3, 1.0, 1e4):
        sphere = tracer.Sphere(random.normal(size=3) * scale, 0.7 * scale)
        origins = random.normal(size=(60, 3)) * 4 * scale
        directions = (sphere.center - origins + random.normal(size=(60, 3)) * 0.5 * scale) * 3.0
        found = sphere.intersect(origins, directions)
        for i in range(60):
            expected = exact_sphere(origins[i], directions[i], sphere.center, sphere.radius)
            assert found.count[i] == len(expected), (origins[i], directions[i])
            for j, t in enumerate(expected):
                slack = 200 * U * scale * 10 / max(abs(float(expected[1] - expected[0])) / scale, 1e-3)
                assert abs(found.t[i, j] - t) < slack
        assert np.all(found.status == Status.OK)


def test_a_unit_sphere_a_million_away_is_hit_to_a_billionth():
    mpmath.mp.dps = 50
    random = np.random.default_rng(2)
    for center in ([1e6, 0, 0], [0, 0, -1e6], [6e5, 7e5, -4e5]):
        scene = tracer.Scene(CAMERA, [], [tracer.Sphere(center, 1.0)])
        across = random.normal(size=(300, 3))
        across *= (0.9 * random.uniform(size=(300, 1))) / np.linalg.norm(across, axis=1, keepdims=True)
        origins = random.normal(size=(300, 3))
        directions = np.asarray(center) + across - origins
        directions /= np.linalg.norm(directions, axis=1, keepdims=True)
        hits = scene.intersect(origins, directions)
        assert hits.hit.all()
        for i in range(300):
            expected = exact_sphere(origins[i], directions[i], center, 1.0)[0]
            distance = mpmath.norm(mpmath.matrix(exact(hits.point[i])) - mpmath.matrix(exact(center)))
            assert abs(distance - 1) < 1e-9, origins[i]
            assert abs(hits.t[i] - expected) < 1e-9, origins[i]


def test_planes_and_discs_equal_plain_geometry():
    random = np.random.default_rng(3)
    normal = np.array([0.3, -0.4, 1.2])
    unit = normal / np.linalg.norm(normal)
    plane = tracer.Plane(normal, 2.6)  # normal . x = offset for the normal as given
    origins, directions = random.normal(size=(2, 200, 3))
    found = plane.intersect(origins, directions)
    expected = (2.6 - origins @ normal) / (directions @ normal) * np.linalg.norm(directions, axis=1)
    assert found.count.tolist() == [1] * 200
    np.testing.assert_allclose(found.t[:, 0], expected, rtol=1e-11)
    np.testing.assert_allclose(found.point[:, 0] @ normal, 2.6, atol=1e-9)
    np.testing.assert_allclose(np.abs(found.normal[:, 0] @ unit), 1.0, rtol=1e-14)
    assert np.all(np.einsum("ij,ij->i", found.normal[:, 0], directions) <= 0)

    disc = tracer.Disc((1.0, 2.0, 3.0), normal, 0.8)
    directions = np.array([1.0, 2.0, 3.0]) + random.normal(size=(200, 3)) * 0.6 - origins
    found = disc.intersect(origins, directions)
    t = (disc.center - origins) @ unit / (directions @ unit)
    inside = np.linalg.norm(origins + t[:, None] * directions - disc.center, axis=1) < 0.8
    assert 20 < inside.sum() < 180
    np.testing.assert_array_equal(found.count, inside)
    assert np.all(np.isnan(found.t[~inside]))


def test_rays_that_touch_nothing_and_rays_in_the_plane():
    assert tracer.Plane((0, 0, 1), 1.0).intersect((0, 0, 0), (1, 0, 0)).count == 0
    assert tracer.Plane((0, 0, 1), 0.0).intersect((0, 0, 0), (1, 0, 0)).count == 0
    rim = tracer.Disc((0, 0, 0), (0, 0, 1), 1.0).intersect((-3, 0, 0), (1, 0, 0))
    assert rim.count == 2 and rim.t.tolist() == [2.0, 4.0]
    touching = tracer.Sphere((0, 0, 0), 1.0).intersect((-3, 0, 1), (1, 0, 0))
    assert touching.count == 2 and np.allclose(touching.t, 3.0)


def test_surfaces_of_the_algebra():
    from bladesmith import cga3d as cga

    sphere = tracer.Sphere(cga.sphere((1.0, 2.0, 3.0), 0.5))
    np.testing.assert_allclose([*sphere.center, sphere.radius], [1, 2, 3, 0.5], rtol=1e-14)
    plane = tracer.Plane(cga.plane((0.0, 0.6, 0.8), 1.5))
    np.testing.assert_allclose([*plane.normal, plane.offset], [0, 0.6, 0.8, 1.5], atol=1e-14)
    disc = tracer.Disc(cga.circle((1.0, 0.0, 2.0), (0.0, 0.6, 0.8), 0.7))
    np.testing.assert_allclose([*disc.center, *disc.normal, disc.radius], [1, 0, 2, 0, 0.6, 0.8, 0.7], atol=1e-14)
    given = tracer.EvolvedCircles(Bezier([cga.circle(*c) for c in TUBE]))
    np.testing.assert_allclose(given.parameters, tracer.EvolvedCircles(TUBE).parameters, rtol=0, atol=1e-13)


# -- scenes --------------------------------------------------------------------------------------------------


def test_the_nearest_surface_wins_whatever_its_kind():
    surfaces = [
        tracer.Plane((0, 0, 1), -1.0),
        tracer.Sphere((0, 0, 0), 1.0),
        tracer.Disc((0, 0, 2.0), (0, 0, 1), 0.5),
        tracer.EvolvedCircles(Bezier([((5, 0, 0), (0, 0, 1), 1.0), ((5, 0, 1), (0, 0, 1), 1.0)])),
        tracer.Sphere((5, 0, 0.5), 0.5),
    ]
    scene = tracer.Scene(CAMERA, [], surfaces)
    origins = [(0.2, 0, 5), (0.7, 0, 5), (3, 3, 5), (9, 0, 0.5), (0, 0, 0), (3, 3, 0)]
    directions = [(0, 0, -1), (0, 0, -1), (0, 0, -1), (-1, 0, 0), (0, 0.6, -0.8), (0, 0, 1)]
    hits = scene.intersect(origins, directions)
    assert hits.surface.tolist() == [2, 1, 0, 3, 1, -1]
    np.testing.assert_allclose(hits.t[:5], [3.0, 5 - math.sqrt(0.51), 6.0, 4 - math.sqrt(1.25), 1.0], rtol=1e-14)
    assert hits.hit.tolist() == [True] * 5 + [False]
    assert np.isnan(hits.t[5]) and np.isnan(hits.normal[5]).all()
    assert hits.alpha[3] == pytest.approx(0.5)
    assert np.isnan(hits.alpha[:3]).all()


@pytest.mark.compiles
def test_shapes_broadcast_and_bad_rays_are_marked():
    scene = tracer.Scene(CAMERA, [], [tracer.Sphere((0, 0, 0), 1.0)])
    assert scene.intersect((0, 0, 5), np.zeros((4, 2, 3)) + (0, 0, -1)).t.shape == (4, 2)
    assert scene.intersect(np.zeros((0, 3)), (0, 0, 1)).t.shape == (0,)
    hits = scene.intersect([(0, 0, 5), (np.nan, 0, 5), (0, 0, 5), (0, np.inf, 0)], [(0, 0, -1)] * 2 + [(0, 0, 0)] * 2)
    assert hits.status.tolist() == [Status.OK, Status.INVALID, Status.INVALID, Status.INVALID]
    assert hits.hit.tolist() == [True, False, False, False]
    single = scene.intersect(np.float32([[0, 0.3, 5]]), np.float32([[0, 0, -2]]))
    assert single.t.dtype == np.float32 and single.t[0] == pytest.approx(5 - math.sqrt(0.91), abs=1e-5)
    with pytest.raises(SceneError, match="broadcast"):
        scene.intersect(np.zeros((2, 3)), np.ones((3, 3)))
    with pytest.raises(SceneError, match=r"\(..., 3\) is needed"):
        scene.intersect(np.zeros((3, 2)), (0, 0, 1))


def test_an_empty_scene_shows_the_sky():
    scene = tracer.Scene(CAMERA, horizon=(0.1, 0.2, 0.3), zenith=(0.1, 0.2, 0.3))
    np.testing.assert_allclose(scene.render(8, 6), np.broadcast_to([0.1, 0.2, 0.3], (6, 8, 3)))


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: tracer.Sphere((0, 0, 0), -0.4), "sphere.radius is -0.4"),
        (lambda: tracer.Sphere((0, 0, math.nan), 1.0), "finite"),
        (lambda: tracer.Sphere((0, 0), 1.0), r"\(3,\) is needed"),
        (lambda: tracer.Plane((0, 0, 0), 1.0), "must not be zero"),
        (lambda: tracer.Disc((0, 0, 0), (0, 0, 1), 0.0), "positive"),
        (lambda: tracer.EvolvedCircles(Bezier(TUBE), material={"colour": 1}), "material"),
        (lambda: tracer.EvolvedCircles([TUBE[0]] * 3), "all the same circle"),
        (lambda: tracer.Material(reflectivity=1.5), "from 0 to 1"),
        (lambda: tracer.Sphere((0, 0, 0), 1.0, material={"checker": (0, 0, 0)}), "planes and discs"),
        (lambda: tracer.Camera.look_at((0, 0, 0), (0, 0, 1)), "parallel"),
        (lambda: tracer.Camera.look_at((0, 0, 0), (0, 0, 0)), "own position"),
        (lambda: tracer.Camera.look_at((0, 0, 0), (0, 1, 0), field_of_view=45.0), "rad"),
        (lambda: tracer.Camera(np.ones(8), 1.0, 1.0, 1.0), "not normalized"),
        (lambda: tracer.Light((0, 0, math.inf)), "finite"),
        (lambda: tracer.Scene(CAMERA, [], ["sphere"]), "surfaces"),
        (lambda: tracer.Scene(CAMERA).render(0, 10), "width"),
        (lambda: tracer.Scene(None), "camera is None; a Camera is needed"),
        (lambda: tracer.Scene(CAMERA, ["lamp"]), r"lights\[0\] is 'lamp'; a Light is needed"),
        (lambda: tracer.Scene(CAMERA, 5), "lights are 5; a list"),
        (lambda: tracer.Scene(CAMERA, reflections=1.5), "reflections is 1.5"),
        (lambda: tracer.Scene(CAMERA).render(4, 4, dtype=int), "float64 or float32"),
        (lambda: tracer.Scene(CAMERA).intersect((0, -8j, 0), (0, 1, 0)), "real numbers"),
        (lambda: tracer.Scene(CAMERA).intersect((0, 0, 0), ("0", "1", "0")), "real numbers"),
        (lambda: tracer.Sphere((0, 0, 0), 1.0).intersect(np.zeros(3, object), (0, 0, 1)), "real numbers"),
        (lambda: tracer.Sphere((0, 0, 0), 1.0).intersect((0, 0, 0), (0, 0, 1), samples="3"), "samples"),
        (lambda: tracer.Sphere((0, 0, 1j), 1.0), "real numbers"),
        (lambda: tracer.Sphere((0, 0, 0), "1"), "a positive number"),
        (lambda: tracer.Disc(np.ones(10) * 1j), "not a circle"),
        (lambda: tracer.Camera(cga3d.point((0, 0, 0)), 1.0, 1.0, 1.0), "not those of a motor"),
        (lambda: tracer.Camera(pga3d.translator((1, 0, 0)), 1.0, 1.0, 1.0), "a motor of cga3d"),
        (lambda: tracer.Camera(cga3d.translator(np.ones((2, 3))), 1.0, 1.0, 1.0), "one item"),
        (lambda: tracer.reflect(LINE, cga3d.point((0, 0, 0)), LINE), "a Surface is needed"),
        (lambda: tracer.reflect(LINE, LINE, tracer.Plane((0, 0, 1), 0.0)), "a point is needed, not line"),
        (lambda: tracer.Sphere((0, 0, 0), 1.0).intersect((0, 0, 0), (0, 0, 1), method="isolated"), "isolate"),
    ],
)
def test_wrong_input_is_refused(make, message):
    with pytest.raises(SceneError, match=message):
        make()


# -- the camera ----------------------------------------------------------------------------------------------


def test_rays_go_through_pixel_centres():
    camera = tracer.Camera.look_at((1.0, -4.0, 2.0), (0.0, 1.0, 1.0), field_of_view=0.8)
    origins, directions = camera.rays(40, 30)
    assert origins.shape == directions.shape == (30, 40, 3)
    np.testing.assert_allclose(origins, np.broadcast_to([1.0, -4.0, 2.0], origins.shape), atol=1e-14)
    np.testing.assert_allclose(np.linalg.norm(directions, axis=-1), 1.0, rtol=1e-14)
    forward = np.array([-1.0, 5.0, -1.0]) / math.sqrt(27)
    right = np.cross(forward, (0, 0, 1))
    right /= np.linalg.norm(right)
    up = np.cross(right, forward)
    half = math.tan(0.4)
    for row, column in ((0, 0), (29, 39), (10, 20)):
        x = (2 * (column + 0.5) / 40 - 1) * half * 40 / 30
        y = (1 - 2 * (row + 0.5) / 30) * half
        expected = forward + x * right + y * up
        np.testing.assert_allclose(directions[row, column], expected / np.linalg.norm(expected), atol=1e-14)


def test_a_camera_by_its_motor():
    from bladesmith import cga3d as cga

    looked = tracer.Camera.look_at((3.0, -4.0, 2.0), (0.0, 1.0, 1.0))
    given = tracer.Camera(looked.motor, looked.focal_length, 2 * looked.y_max, looked.y_max)
    np.testing.assert_allclose(given.rays(20, 10)[1], looked.rays(20, 10)[1], atol=1e-15)
    plain = tracer.Camera(cga.translator((1.0, 2.0, 3.0)) * cga.rotor((0, 0, 1), 0.0), 1.0, 1.0, 1.0)
    np.testing.assert_allclose(plain.position, [1, 2, 3], atol=1e-15)
    np.testing.assert_allclose(plain.rays(1, 1)[1][0, 0], [0, 1, 0], atol=1e-15)


def test_cameras_stand_by_rotors_and_translators():
    from bladesmith import cga3d as cga

    for part, motor in (
        (cga.translator((0, -8, 0)), cga.translator((0, -8, 0)) * cga.rotor((0, 0, 1), 0.0)),
        (cga.rotor((0, 0, 1), 0.4), cga.translator((0, 0, 0)) * cga.rotor((0, 0, 1), 0.4)),
    ):
        np.testing.assert_allclose(
            tracer.Camera(part, 1, 0.5, 0.5).motor, tracer.Camera(motor, 1, 0.5, 0.5).motor, atol=1e-15
        )


def test_a_number_of_threads_is_checked():
    for wrong in (0, -1, 1.5, "2"):
        with pytest.raises(InputError, match="threads is"):
            tracer.Scene(CAMERA).render(4, 4, threads=wrong)


# -- reflection ----------------------------------------------------------------------------------------------


def test_reflected_lines():
    """Against mirror images of directions, and in spheres against the printed (4.7)."""
    from bladesmith import cga3d as cga

    random = np.random.default_rng(14)
    surfaces = [
        tracer.Plane((0.1, 0.2, 1.0), 0.3),
        tracer.Disc((0, 0, 0.1), (0.2, 0.1, -1), 5.0),
        tracer.Sphere((0, 0, 0), 1.0),
        tracer.EvolvedCircles(Bezier(TUBE)),
    ]
    for surface in surfaces:
        origins = random.normal(size=(30, 3)) * 0.2 + (0.5, 0.3, 4)
        directions = random.normal(size=(30, 3)) * 0.3 - origins
        found = surface.intersect(origins, directions)
        some = found.count > 0
        assert some.sum() > 10
        points, normals = found.point[some, 0], found.normal[some, 0]
        directions = directions[some] / np.linalg.norm(directions[some], axis=1, keepdims=True)
        lines = cga.line(origins[some], directions)
        reflected = tracer.reflect(lines, cga.point(points), surface)
        along = 2 * np.einsum("ij,ij->i", directions, normals)[:, None] * normals
        expected = cga.line(points, directions - along)
        np.testing.assert_allclose(reflected.values, expected.values, atol=1e-9)
        if isinstance(surface, tracer.Sphere):
            s, x = cga.sphere(surface.center, surface.radius), cga.point(points)
            inverted = (s * lines * s).grade(3)
            printed = (-1 * ((x | inverted) ^ cga.ni)).grade(3)
            again = cga.line(points, line_direction(printed))
            np.testing.assert_allclose(again.values, expected.values, atol=1e-9)
