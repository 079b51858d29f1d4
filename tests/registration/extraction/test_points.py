"""Models of point clouds: what points were sampled from is found again, from any seed, at any size and place."""

from __future__ import annotations

import numpy as np
import pytest

from bladesmith import cga3d as cga
from bladesmith import errors
from bladesmith.registration.extraction.from_points import CloudFit, CloudInterrupted, model_from_points
from bladesmith.registration.model.model import Model

pytestmark = pytest.mark.peers

NOISE = 0.003
TRUTH = Model(
    planes=[(0, 0, 1, 0), (1, 0, 0, 2)], spheres=[(0, 0, 2, 0.7)], lines=[[(-2, -2, 1), (0, 4, 1.5)]],
    circles=[(0, 0, 4, 0, 0, 1, 1.0)],
)  # fmt: skip


def cloud(seed=0, noise=NOISE, others=300):
    """Points of `TRUTH` and some of nothing; the number of each point's object, -1 for none."""
    rng = np.random.default_rng(seed)
    sheet = lambda n, o, u, v: o + rng.uniform(-1, 1, (n, 1)) * u + rng.uniform(-1, 1, (n, 1)) * v  # noqa: E731
    e = np.eye(3)
    ball = rng.normal(size=(1200, 3))
    a, t = rng.uniform(0, 2 * np.pi, 500), rng.uniform(0, 1, (400, 1))
    parts = {
        ("plane", 0): sheet(2000, 0 * e[0], 2 * e[0], 2 * e[1]),
        ("plane", 1): sheet(1200, 2 * e[0] + e[2], 2 * e[1], e[2]),
        ("sphere", 0): 2 * e[2] + 0.7 * ball / np.linalg.norm(ball, axis=1, keepdims=True),
        ("line", 0): np.array([-2, -2, 1]) + t * np.array([0, 4, 1.5]),
        ("circle", 0): 4 * e[2] + np.stack([np.cos(a), np.sin(a), 0 * a], 1),
    }
    xyz = np.concatenate([*parts.values()])
    xyz = np.concatenate([xyz + noise * rng.normal(size=xyz.shape), rng.uniform(-3, 5, (others, 3))])
    labels = [np.full(len(p), TRUTH.slices[k].start + i) for (k, i), p in parts.items()]
    return xyz, np.concatenate([*labels, np.full(others, -1)])


def assert_found(model, tolerance):
    assert model.counts == TRUTH.counts
    both = Model(**{f"{kind}s": [x, model.objects[kind]] for kind, x in TRUTH.objects.items()})
    same = both.duplicates(tolerance)
    for kind, place in both.slices.items():
        n = TRUTH.counts[kind]
        np.testing.assert_array_equal(np.sort(same[place][n:]), place.start + np.arange(n))


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, 1])
def test_what_was_sampled_is_found(seed):
    xyz, labels = cloud(seed)
    fit = model_from_points(xyz, 0.01, seed=seed, details=True)
    assert isinstance(fit, CloudFit) and fit.complete
    assert_found(fit.model, 0.01)
    for kind, place in fit.model.slices.items():
        for number in range(place.start, place.stop):
            mine = labels[fit.labels == number]
            counts = np.bincount(mine + 1, minlength=len(TRUTH) + 1)[1:]
            assert counts.argmax() in range(TRUTH.slices[kind].start, TRUTH.slices[kind].stop)
            assert counts.max() > 0.97 * len(mine) and counts.max() > 0.97 * (labels == counts.argmax()).sum()
            assert NOISE / 2 < fit.rms[number] < 2 * NOISE


@pytest.mark.slow
def test_exact_points_give_exact_objects_anywhere():
    xyz, _ = cloud(2, noise=0.0, others=0)
    found = model_from_points(xyz, 1e-6, min_points=200)
    assert_found(found, 1e-10)
    far = model_from_points(1e-3 * xyz + 1e4, 1e-7, min_points=200)
    assert_found(far.in_frame((1e4, 1e4, 1e4), 1e-3), 1e-5)


def test_the_same_seed_gives_the_same_model():
    xyz, _ = cloud(3, others=0)
    one, other = (model_from_points(xyz, 0.01, kinds=("plane",), seed=7, details=True) for _ in range(2))
    np.testing.assert_array_equal(one.labels, other.labels)
    np.testing.assert_array_equal(one.model.parameters["plane"], other.model.parameters["plane"])
    assert one.model.counts == {"plane": 2}


def test_points_of_the_algebra_and_one_kind_by_name():
    xyz, _ = cloud(4, others=0)
    found = model_from_points(cga.point(xyz[-500:]), 0.01, kinds="circle", max_objects=1, unit="m", origin="a ring")
    assert found.counts == {"circle": 1} and found.unit == "m" and found.origin == "a ring"


def test_a_circle_is_no_plane_and_a_plane_no_line():
    xyz, _ = cloud(5, others=0)
    ring, sheet = xyz[-500:], xyz[:2000]
    assert model_from_points(ring, 0.01).counts == {"circle": 1}
    assert model_from_points(sheet, 0.01).counts == {"plane": 1}
    assert len(model_from_points(sheet, 0.01, kinds=("line", "circle"))) == 0


def test_clouds_without_objects():
    rng = np.random.default_rng(6)
    assert len(model_from_points(np.empty((0, 3)), 0.01)) == 0
    assert len(model_from_points(np.zeros((50, 3)), 0.01)) == 0
    assert len(model_from_points(rng.normal(size=(400, 3)), 1e-4)) == 0
    assert len(model_from_points(rng.normal(size=(3, 3)), 0.01)) == 0
    fit = model_from_points(rng.normal(size=(10, 3)), 1e-3, details=True)
    assert (fit.labels == -1).all() and len(fit.rms) == 0


def test_an_interrupt_keeps_what_is_found():
    xyz, _ = cloud(7)
    told = []

    def stop(progress):
        told.append((progress.done, progress.total))
        if len(told) == 2:
            raise KeyboardInterrupt

    with pytest.raises(CloudInterrupted) as caught:
        model_from_points(xyz, 0.01, progress=stop)
    partial = caught.value.partial
    assert isinstance(caught.value, KeyboardInterrupt) and not partial.complete
    assert len(partial.model) == 2 and told[1] == ((partial.labels >= 0).sum(), len(xyz))


def test_the_bar_is_on_standard_error(capsys, monkeypatch):
    monkeypatch.setattr("bladesmith.codegen.progress.PATIENCE", 0)
    xyz, _ = cloud(8, others=0)
    model_from_points(xyz[:1000], 0.01, kinds=("plane",), progress=True)
    out, err = capsys.readouterr()
    assert not out and "objects" in err


@pytest.mark.parametrize("options, message", [
    ({"tolerance": 0.0}, "tolerance"), ({"tolerance": np.nan}, "tolerance"), ({"tolerance": "x"}, "tolerance"),
    ({"kinds": ("cube",)}, "cube"), ({"kinds": ()}, "empty"), ({"min_points": 3}, "min_points"),
    ({"min_points": 2.5}, "min_points"), ({"max_objects": -1}, "max_objects"),
    ({"seed": -1}, "seed"), ({"seed": "a"}, "seed"),
])  # fmt: skip
def test_options_are_checked(options, message):
    with pytest.raises(errors.InputError, match=message):
        model_from_points(np.zeros((30, 3)), **{"tolerance": 0.1, **options})


@pytest.mark.parametrize("points", [np.zeros((3, 2)), [(0, 0, np.nan)], "abc", np.zeros((2, 3), complex)])
def test_what_is_no_cloud(points):
    with pytest.raises(errors.InputError, match="points"):
        model_from_points(points, 0.1)


def test_without_scikit_image_the_extra_is_named(monkeypatch):
    import sys

    monkeypatch.setitem(sys.modules, "skimage.measure", None)
    with pytest.raises(errors.MissingExtraError, match="clouds"):
        model_from_points(np.zeros((30, 3)), 0.1)
