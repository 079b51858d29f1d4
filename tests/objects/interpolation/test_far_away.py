"""Blends of objects far from the origin, on a local frame where it gains digits."""

from __future__ import annotations

import numpy as np
import pytest

from bladesmith import Status, objects
from bladesmith import cga3d as cga

from ...support.objects.blends import FAR, KINDS, drawn


@pytest.mark.parametrize("kind", ["point", *KINDS])
def test_far_from_the_origin(kind: str) -> None:
    """Built from parameters at 1e6, interpolants, means and rates keep 1e-9 of the objects' own size.

    Positions are multiples of 2^-20, so that they are the same near and far.
    """
    rng = np.random.default_rng(25)
    c, d = (np.round(rng.uniform(-1, 1, (2, 40, 3)) * 2**20) / 2**20), rng.normal(size=(2, 40, 3))
    d /= np.linalg.norm(d, axis=-1, keepdims=True)
    r = rng.uniform(0.7, 1.4, (2, 40))
    made = {
        "point": lambda i, o: cga.point(c[i] + o),
        "point_pair": lambda i, o: cga.point_pair(c[i] + o, c[i] + np.array([1.0, 0.5, 0]) + o),
        "line": lambda i, o: cga.line(c[i] + o, d[i]),
        "circle": lambda i, o: cga.circle(c[i] + o, d[i], r[i]),
        "plane": lambda i, o: cga.plane(d[i], (d[i] * (c[i] + o)).sum(-1)),
        "sphere": lambda i, o: cga.sphere(c[i] / 4 + o, r[i]),
    }[kind]
    for compute in (
        lambda i, o: objects.interpolate(made(0, o), made(1, o), alpha=0.4),
        lambda i, o: objects.average([made(0, o), made(1, o)], align=True),
    ):
        near, far = compute(0, 0.0), compute(0, FAR)
        assert np.array_equal(near.status, far.status) and np.all(near.status == Status.OK)
        if kind in ("line", "plane"):  # read at the local origin
            far = cga.translator(-FAR) >> far
            assert np.abs(far.values - near.values).max() < 2e-9
            continue
        for name, one, other in zip(near.parameters()._fields, near.parameters(), far.parameters(), strict=True):
            shift = FAR if name in ("xyz", "a", "b", "center") else 0.0
            assert np.abs(other - shift - one).max() < 4e-9, name
    slope = objects.interpolate_derivative(made(0, FAR), made(1, FAR), alpha=0.4)
    assert np.allclose(
        (cga.translator(-FAR) >> slope).values[..., 0],
        objects.interpolate_derivative(made(0, 0.0), made(1, 0.0), alpha=0.4).values[..., 0],
        atol=1e-3,
    )


@pytest.mark.parametrize("kind", ["point", *KINDS])
@pytest.mark.parametrize("method", ["direct", "rotor"])
def test_ends_are_the_objects_however_far_the_other_is(kind: str, method: str) -> None:
    near, far = drawn(kind, 20, 5), drawn(kind, 20, 6, FAR)
    for one, two in ((near, far), (far, near), (far[0], near), (near, far[0])):
        alpha = np.array([1.0, 0.5, 0.0])[:, None]
        found = objects.interpolate(one, two, alpha=alpha, method=method)
        assert (found[0].values == one.values).all()
        assert method == "rotor" or (found[::2].status == Status.OK).all()
        sign = np.where((found[2].values == two.values).all(-1), 1, -1)
        assert (found[2].values == sign[:, None] * two.values).all() and (method == "rotor" or (sign == 1).all())
        flipped = objects.align(two, one)[1]
        aligned = objects.interpolate(one, two, alpha=0.0, align=True)
        assert (aligned.values == np.where(flipped, -1, 1)[:, None] * two.values).all()
        assert (objects.interpolate(one, two, alpha=1, method=method).values == one.values).all()


def test_far_sums_keep_the_digits_that_they_have() -> None:
    """A sum of coefficients of size c^2/r knows radii to (c/r)^2 rounding units; no more is lost."""
    for kind in ("circle", "sphere", "point_pair", "line", "point"):
        near, far = drawn(kind, 20, 36), drawn(kind, 20, 36, FAR / 10)
        found = objects.project_to_blade(2.0 * far)
        assert np.all(found.status == Status.OK) and found.kind == near.kind
        if kind in ("circle", "sphere"):
            assert np.allclose(found.parameters().radius, near.parameters().radius, rtol=1e-4)
        expected = far.values / np.abs(far.values).max(-1, keepdims=True)
        assert np.abs(found.values / np.abs(found.values).max(-1, keepdims=True) - expected).max() < 1e-5


def test_frames_are_made_only_where_they_gain() -> None:
    from bladesmith.objects.rotors import local_origin

    near, far = drawn("circle", 10, 26), drawn("circle", 10, 26, FAR)
    assert local_origin.frame(near) is None
    frame = local_origin.frame(far)
    assert frame is not None and np.abs(frame.origin - FAR).max() < 10
    seen = frame.to_local(far)
    assert seen.kind == far.kind and np.abs(seen.values).max() < 100
    assert np.allclose(frame.to_world(seen).parameters().radius, near.parameters().radius, rtol=1e-12)
    both = local_origin.frame(far, shared=True)
    assert both is not None and both.origin.shape == (3,)
    mixed = objects.average([far[0], cga.line(FAR, [1, 2, 3])])  # a round and a flat share the local origin
    expected = objects.average([near[0], cga.line([0, 0, 0], [1, 2, 3])])
    assert np.allclose(mixed.parameters().center - FAR, expected.parameters().center, atol=1e-8)
