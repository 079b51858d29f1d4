"""Vertices of meshes and their normals, against the surface at 50 digits."""

from __future__ import annotations

import mpmath as mp
import numpy as np
import pytest

from bladesmith.curves import Bezier
from bladesmith.tracer.meshing import mesh_of
from bladesmith.tracer.surfaces.evolved import EvolvedCircles, EvolvedPointPairs

from ...oracles.sequences import dot
from ...support.tracer.meshes import BENT, RIBBON
from ...support.tracer.scenes import TUBE

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
