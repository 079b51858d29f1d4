"""Light, shadow and mirrors in pictures: each against what the geometry of the scene says."""

from __future__ import annotations

import math

import numpy as np
import pytest

from bladesmith import tracer

from ...support.tracer.scenes import BLACK, CAMERA, dark

MATT = {"specular": 0.0, "ambient": 0.0, "diffuse": 1.0}


def test_light_follows_lambert():
    surface = tracer.Plane((0, 0, 1), 0.0, material=MATT)
    scene = dark(CAMERA, [tracer.Light((3, 4, 5), (0.5, 1.0, 2.0))], [surface])
    origins, directions = CAMERA.rays(20, 15)
    image, hits = scene.render(20, 15), scene.intersect(origins, directions)
    towards = np.array([3, 4, 5]) - hits.point
    cosine = towards[..., 2] / np.linalg.norm(towards, axis=-1)
    expected = np.where(hits.hit, cosine * 0.8, 0.0)
    for channel, strength in enumerate((0.5, 1.0, 2.0)):
        np.testing.assert_allclose(image[..., channel], expected * strength, atol=1e-9)


def test_highlights_follow_blinn():
    material = {"color": (0, 0, 0), "specular": 1.0, "shininess": 12.5}
    scene = dark(CAMERA, [tracer.Light((1, -3, 5))], [tracer.Sphere((0, 0, 1), 1.0, material=material)])
    origins, directions = CAMERA.rays(40, 30)
    hits = scene.intersect(origins, directions)
    lamp = np.array([1, -3, 5]) - hits.point
    lamp /= np.linalg.norm(lamp, axis=-1, keepdims=True)
    half = lamp - directions
    cosine = np.einsum("ijk,ijk->ij", half, hits.normal) / np.linalg.norm(half, axis=-1)
    lit = hits.hit & (np.einsum("ijk,ijk->ij", lamp, hits.normal) > 0) & (cosine > 0)
    expected = np.where(lit, np.maximum(cosine, 1e-300) ** 12.5, 0.0)
    np.testing.assert_allclose(scene.render(40, 30)[..., 1], np.nan_to_num(expected), atol=1e-7)


def test_shadows_fall_away_from_the_light():
    floor = tracer.Plane((0, 0, 1), 0.0, material=MATT)
    ball = tracer.Sphere((0, 0, 1), 0.5, material=MATT)
    lit = dark(CAMERA, [tracer.Light((0, 0, 9))], [floor, ball])
    hits = lit.intersect(*CAMERA.rays(60, 45))
    image = lit.render(60, 45)[..., 0]
    on_floor = hits.hit & (hits.surface == 0)
    shadow_radius = 9 * 0.5 / math.sqrt(8**2 - 0.5**2)  # the cone from the lamp around the ball, on the floor
    distance = np.hypot(hits.point[..., 0], hits.point[..., 1])
    np.testing.assert_array_equal(image[on_floor] == 0, distance[on_floor] < shadow_radius)
    assert (image[on_floor] == 0).sum() > 10


def test_a_lamp_behind_a_surface_lights_and_shadows_nothing():
    floor = tracer.Plane((0, 0, 1), 0.0, material=MATT)
    below = dark(CAMERA, [tracer.Light((0, 0, -3))], [floor])
    assert np.all(below.render(20, 15) == 0)
    beyond = dark(CAMERA, [tracer.Light((0, 0, 3))], [floor, tracer.Sphere((0, 0, 5), 0.5, material=MATT)])
    alone = dark(CAMERA, [tracer.Light((0, 0, 3))], [floor])
    hits = beyond.intersect(*CAMERA.rays(20, 15))
    seen = hits.surface == 0  # the ball is farther than the lamp: no shadow
    np.testing.assert_array_equal(beyond.render(20, 15)[seen], alone.render(20, 15)[seen])


def test_mirrors_show_what_the_reflected_ray_sees():
    mirror = tracer.Plane((0, 0, 1), 0.0, material={"reflectivity": 1.0})
    ball = tracer.Sphere((0, 0, 1.5), 0.7, material={"color": (1, 0, 0), "ambient": 1.0, "diffuse": 0, "specular": 0})
    scene = dark(CAMERA, [], [mirror, ball])
    assert "cga3d_reflected_direction" in scene.kernels
    origins, directions = CAMERA.rays(60, 45)
    hits = scene.intersect(origins, directions)
    flipped = directions * (1, 1, -1)
    second = scene.intersect(np.where(hits.hit[..., None], hits.point, origins) + 1e-9 * flipped, flipped)
    expected = (hits.surface == 1) | ((hits.surface == 0) & (second.surface == 1))
    np.testing.assert_array_equal(scene.render(60, 45)[..., 0] == 1.0, expected)
    assert ((hits.surface == 0) & (second.surface == 1)).sum() > 20
    without = dark(CAMERA, [], [mirror], reflections=0).render(60, 45)
    np.testing.assert_allclose(without[hits.surface == 0], 0.08)  # its own ambient light


def test_facing_mirrors_end():
    mirrors = [tracer.Plane((0, 1, 0), y, material={"reflectivity": 0.9, "ambient": 1.0}) for y in (-9.0, 3.0)]
    image = dark(CAMERA, [], mirrors, reflections=200).render(10, 8)
    assert np.isfinite(image).all() and image.max() < 1


@pytest.mark.parametrize("count", [0, 1, 2, 5])
def test_reflections_are_counted(count):
    """Between a white and a black mirror, each reflection adds its share until the last mirror shows only itself."""
    share = 0.7
    look = {"reflectivity": share, "ambient": 1.0, "diffuse": 0.0, "specular": 0.0}
    mirrors = [tracer.Plane((0, 1, 0), y, material={**look, "color": c}) for y, c in ((3, (1, 1, 1)), (-9, BLACK))]
    camera = tracer.Camera.look_at((0, -8, 0), (0, 0, 0))
    image = dark(camera, [], mirrors, reflections=count).render(5, 5)
    shares = [(1 - share) * share**k for k in range(count)] + [share**count]
    np.testing.assert_allclose(image[2, 2], sum(shares[::2]), rtol=1e-12)


def test_without_lamps_there_is_ambient_light_alone():
    material = {"color": (0.2, 0.4, 0.8), "ambient": 0.5}
    scene = dark(CAMERA, [], [tracer.Sphere((0, 0, 1), 1.0, material=material)])
    image, hits = scene.render(20, 15), scene.intersect(*CAMERA.rays(20, 15))
    np.testing.assert_allclose(image[hits.hit], np.broadcast_to((0.1, 0.2, 0.4), image[hits.hit].shape))
    assert np.all(image[~hits.hit] == 0)


INSIDES = [
    tracer.Sphere((0, 0, 0), 2.0, material=MATT),
    tracer.EvolvedCircles([((0, -3, 0), (0, 1, 0), 2.0), ((0, 3, 0), (0, 1, 0), 2.0)], material=MATT),
]


@pytest.mark.parametrize("surface", INSIDES, ids=["sphere", "tube"])
def test_surfaces_are_lit_from_the_side_that_is_seen(surface):
    camera = tracer.Camera.look_at((0.1, 0.2, 0.3), (0, 5, 1))
    hits = tracer.Scene(camera, [], [surface]).intersect(*camera.rays(24, 18))
    lamp = np.array([-0.5, 0.4, 0.2])
    towards = lamp - hits.point
    cosine = np.einsum("ijk,ijk->ij", towards, hits.normal) / np.linalg.norm(towards, axis=-1)
    inside = dark(camera, [tracer.Light(lamp)], [surface]).render(24, 18)[..., 0]
    assert hits.hit.sum() > 30 and (cosine[hits.hit] > 0).all()
    np.testing.assert_allclose(inside[hits.hit], 0.8 * cosine[hits.hit], atol=1e-9)
    outside = dark(camera, [tracer.Light((0, 0, 9))], [surface]).render(24, 18)
    assert np.all(outside == 0)


def test_a_lamp_inside_a_sphere_stays_inside():
    scene = dark(CAMERA, [tracer.Light((0, 0, 1))], [tracer.Plane((0, 0, 1), 0.0, material=MATT), INSIDES[0]])
    hits = scene.intersect(*CAMERA.rays(40, 30))
    outside = hits.hit & (np.linalg.norm(hits.point, axis=-1) > 2 - 1e-9)
    assert outside.sum() > 300 and np.all(scene.render(40, 30)[outside] == 0)


@pytest.mark.parametrize("far", [0.0, 1e6])
@pytest.mark.parametrize("seed", range(6))
def test_a_lamp_on_a_surface_is_not_in_its_shadow(seed, far):
    """A lamp on a sphere lights what lies before the tangent plane there: no speckles of chance."""
    rng = np.random.default_rng(seed)
    normal = rng.normal(size=3) * (1, 1, 0.5) + (0, 0, -1)
    normal /= np.linalg.norm(normal)
    shift = np.array([far, -far, 0.0])
    ball = tracer.Sphere(shift + (0, 0, 1.5), 0.5, material=MATT)
    lamp = shift + (0, 0, 1.5) + 0.5 * normal
    camera = tracer.Camera.look_at(shift + (0, -8, 2), shift + (0, 0, 1))
    scene = dark(camera, [tracer.Light(lamp)], [tracer.Plane((0, 0, 1), 0.0, material=MATT), ball])
    image, hits = scene.render(60, 45)[..., 0], scene.intersect(*camera.rays(60, 45))
    floor = hits.hit & (hits.surface == 0)
    before = (hits.point - lamp) @ normal
    sure = floor & (np.abs(before) > 1e-3)
    np.testing.assert_array_equal(image[sure] > 0, before[sure] > 0)
    assert (image[sure] > 0).sum() > 100 and (image[hits.surface == 1] == 0).all()


def test_a_lamp_in_the_plane_of_a_floor_lights_what_stands_on_it():
    floor = tracer.Plane((0.1, -0.2, 1), 0.3, material=MATT)
    lamp = np.array([-2.0, -3.0, 0.0])
    lamp[2] = 0.3 - lamp[:2] @ (0.1, -0.2)  # normal . x = offset
    ball = tracer.Sphere((0, 0, 1), 0.6, material=MATT)
    scene = dark(CAMERA, [tracer.Light(lamp)], [floor, ball])
    image, hits = scene.render(60, 45)[..., 0], scene.intersect(*CAMERA.rays(60, 45))
    assert np.all(image[hits.surface == 0] == 0)
    towards = lamp - hits.point
    cosine = np.einsum("ijk,ijk->ij", towards, hits.normal) / np.linalg.norm(towards, axis=-1)
    seen = hits.surface == 1
    np.testing.assert_allclose(image[seen], 0.8 * np.maximum(cosine[seen], 0), atol=1e-9)
    assert (image[seen] > 0).sum() > 30


def test_squares_alternate():
    material = {"color": (1, 1, 1), "checker": BLACK, "checker_size": 0.5, "ambient": 1.0, "diffuse": 0, "specular": 0}
    scene = dark(CAMERA, [], [tracer.Plane((0, 0, 1), 0.0, material=material)])
    hits = scene.intersect(*CAMERA.rays(50, 40))
    cells = np.floor(hits.point[..., 0] / 0.5) + np.floor(hits.point[..., 1] / 0.5)
    inside = np.abs(hits.point[..., :2] / 0.5 - np.round(hits.point[..., :2] / 0.5)).min(axis=-1) > 1e-6
    near = hits.hit & inside & (hits.t < 100)
    white = scene.render(50, 40)[..., 0] == 1.0
    parity = white[near] == (cells[near] % 2 == 0)
    assert parity.all() or not parity.any()


def test_the_sky_is_the_horizons_from_there_down():
    camera = tracer.Camera.look_at((0, 0, 0), (0, 5, 0))
    horizon, zenith = np.array([0.2, 0.4, 0.6]), np.array([1.0, 0.3, 0.1])
    image = tracer.Scene(camera, horizon=horizon, zenith=zenith).render(30, 20)
    up = camera.rays(30, 20)[1][..., 2:]
    assert (up < -0.1).any() and (up > 0.1).any()
    np.testing.assert_allclose(image, horizon + np.maximum(up, 0) * (zenith - horizon), atol=1e-12)


def test_no_surface_shadows_itself_however_far_the_camera_is():
    """Points are misplaced by roundings of the way to them, not of where they are."""
    distance = 1e7
    camera = tracer.Camera.look_at((0, 0, distance), (0, 0, 0), (0, 1, 0), field_of_view=3 / distance)
    slope = tracer.Plane((0.3, 0.2, 1), 0.0, material=MATT)
    image = dark(camera, [tracer.Light((-30, 50, 100))], [slope]).render(40, 30)
    assert image.min() > 0.3


@pytest.mark.compiles
@pytest.mark.parametrize("dtype", [np.float64, np.float32])
@pytest.mark.parametrize("center", [(0.0, 0.0, 0.0), (0.0, 0.0, -1.0), (1000.0, 0.0, 0.0)])
def test_a_camera_on_a_sphere_sees_it_only_below(center, dtype):
    """Its first point of every ray is the camera, to rounding: half of the pixels above the horizon saw it."""
    ball = tracer.Sphere(center, 1.0)
    for up in np.array([[0, 0, 1], [1, 2, 2]]) / [[1], [3]]:
        position = center + up
        for turn in (1, -1):
            camera = tracer.Camera.look_at(position, position + turn * up, up=(0, 1, 0), field_of_view=2.2)
            depth = tracer.Scene(camera, [], [ball]).layers(48, 32, ["depth"], dtype=dtype)["depth"]
            slope = camera.rays(48, 32)[1] @ up
            above, below = slope > 0.01, slope < -0.01
            assert np.isinf(depth[above]).all() and (above.all() if turn > 0 else below.all())
            np.testing.assert_allclose(depth[below], -2 * slope[below], rtol=1e-9 if dtype == np.float64 else 2e-2)
