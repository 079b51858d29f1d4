"""k-means of objects: clusters that are known, as in figures 3.15 and 3.16, against a plain loop, and bad input."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import bladesmith as bs
from bladesmith import cga3d as cga
from bladesmith import errors
from bladesmith.objects.clustering import kmeans as clusters
from bladesmith.objects.clustering.kmeans import kmeans
from bladesmith.objects.rotors.costs import cost_matrix

from ..support.clusters import same_partition

CENTERS = np.array([[0.0, 0, 0], [4, 1, 0], [-2, 3, 2]])
AXES = np.array([[1.0, 0, 0], [0, 1, 1], [1, 1, -1]])
NOISE = 0.03


def noisy(kind: str, n: int, seed: int = 0, flip: bool = False) -> tuple[Any, np.ndarray]:
    """n noisy copies of three objects, and which one each is of; every other one turned round where ``flip``."""
    r = np.random.default_rng(seed)
    label = np.arange(n) % 3
    r.shuffle(label)
    a, b = (p[label] + NOISE * r.normal(size=(n, 3)) for p in (CENTERS, AXES))
    if flip:
        b[::2] *= -1
    size = 1 + NOISE * r.normal(size=n)
    made = {
        "point": lambda: cga.point(a),
        "point_pair": lambda: cga.point_pair(a - b, a + b),
        "line": lambda: cga.line(a, b),
        "circle": lambda: cga.circle(a, b, size),
        "plane": lambda: cga.plane(b, (b * (a + label[:, None] * AXES[label])).sum(-1)),
        "sphere": lambda: cga.sphere(a, size),
    }
    return made[kind](), label


@pytest.mark.parametrize("kind", ["point", "point_pair", "line", "circle", "plane", "sphere"])
@pytest.mark.parametrize("flip", [False, True])
def test_three_noisy_objects_are_recovered(kind: str, flip: bool) -> None:
    x, truth = noisy(kind, 90, flip=flip)
    found = kmeans(x, 3)
    labels, centroids = found
    assert same_partition(labels, truth) and found.converged and found.status == bs.Status.OK
    assert centroids.kind == x.kind and centroids.shape == (3,) and not np.any(centroids.status)
    values = cost_matrix(x, centroids, align=True)
    np.testing.assert_array_equal(labels, values.argmin(1))
    assert found.cost == pytest.approx(values.min(1).sum(), rel=1e-9)
    clean, _ = noisy(kind, 3, 1)
    assert cost_matrix(clean, centroids, align=True).min(1).max() < 0.1  # noise 0.03, some units from the origin


def test_centroids_are_where_the_objects_are() -> None:
    x, truth = noisy("circle", 3000)
    labels, centroids = kmeans(x, 3, seed=4)
    found = centroids.parameters()
    order = [labels[truth == i][0] for i in range(3)]
    np.testing.assert_allclose(found.center[order], CENTERS, atol=0.01)
    np.testing.assert_allclose(found.radius[order], 1.0, atol=0.01)
    normal = AXES / np.linalg.norm(AXES, axis=1, keepdims=True)
    np.testing.assert_allclose(np.abs((found.normal[order] * normal).sum(1)), 1.0, atol=1e-3)


def plain_kmeans(x: Any, centroids: Any, align: bool) -> tuple[np.ndarray, Any]:
    """The printed algorithm, object by object; centroids move only where that saves, empty clusters start again."""
    rows, middle = x.values, centroids.values.copy()
    kind = x.kind

    def costs(data: np.ndarray) -> np.ndarray:
        return cost_matrix(x, cga.multivector(data, blades=x.blades).as_kind(kind), align=align)

    while True:
        values = costs(middle)
        labels = values.argmin(1)
        new = middle.copy()
        for j in range(len(middle)):
            total = np.zeros(rows.shape[1])
            for row in rows[labels == j]:
                sign = cga.multivector(row, blades=x.blades).scalar_product(cga.multivector(middle[j], blades=x.blades))
                total += -row if align and sign["1"] < 0 else row
            unit = cga.multivector(total, blades=x.blades).normalized(kind)
            new[j] = unit.values
        worse = [
            costs(new)[labels == j, j].sum() > values[labels == j, j].sum() or np.isnan(new[j]).any()
            for j in range(len(middle))
        ]
        new[worse] = middle[worse]
        empty = [j for j in range(len(middle)) if not (labels == j).any()]
        new[empty] = rows[np.argsort(-values.min(1))[: len(empty)]]
        if np.abs(new - middle).max() < 1e-12:
            return labels, middle
        middle = new


@pytest.mark.parametrize("align", [False, True])
def test_against_a_plain_loop(align: bool) -> None:
    x, _ = noisy("line", 40, 3, flip=True)
    found = kmeans(x, 5, seed=2, init="random", align=align, tolerance=0)
    start = x[np.sort(np.random.default_rng(2).choice(40, 5, replace=False))]
    labels, middle = plain_kmeans(x, start, align)
    np.testing.assert_array_equal(found.labels, labels)
    np.testing.assert_allclose(found.centroids.values, middle, atol=1e-10)


def test_only_some_centroids_move_and_the_labels_are_those_of_all() -> None:
    x, _ = noisy("line", 600, 5)
    found = kmeans(x, 12, init="random", tolerance=0)
    values = cost_matrix(x, found.centroids, align=True)
    np.testing.assert_array_equal(found.labels, values.argmin(1))
    assert found.converged and 2 < found.iterations < clusters.MAX_ITERATIONS


def test_the_cost_never_rises() -> None:
    r = np.random.default_rng(8)
    x = cga.circle(r.normal(size=(300, 3)), r.normal(size=(300, 3)), r.uniform(0.5, 2, 300))
    costs = [kmeans(x, 8, init="random", iterations=i, tolerance=0).cost for i in range(1, 12)]
    assert all(after <= before * (1 + 1e-12) for before, after in zip(costs, costs[1:], strict=False))
    assert costs[-1] < costs[0]


def test_flats_and_rounds_in_one_clustering() -> None:
    r = np.random.default_rng(9)
    lines = cga.line(NOISE * r.normal(size=(20, 3)), AXES[0] + NOISE * r.normal(size=(20, 3)))
    circles = cga.circle(CENTERS[1] + NOISE * r.normal(size=(30, 3)), [0, 1, 1], 1 + NOISE * r.normal(size=30))
    labels, centroids = kmeans([lines, circles], 2)
    assert len(set(labels[:20])) == len(set(labels[20:])) == 1 and labels[0] != labels[-1]
    assert centroids.kind == cga.kind("circle")
    assert bs.cga3d.classify(centroids[int(labels[-1])]) == "circle"


def test_orientation_counts_only_when_asked() -> None:
    line = cga.line(NOISE * np.random.default_rng(1).normal(size=(20, 3)), [1, 0, 0])
    both = [line, (-1 * line).normalized("line")]
    assert kmeans(both, 1).cost < 1
    labels, _ = kmeans(both, 2, align=False)
    assert same_partition(labels, np.repeat([0, 1], 20))


def test_weights() -> None:
    x, truth = noisy("line", 60, 6)
    counts = np.random.default_rng(0).integers(0, 4, 60)
    counts[0] = 1
    weighted = kmeans(x, 3, weights=counts, tolerance=0)
    repeated = kmeans(x[np.repeat(np.arange(60), counts)], 3, tolerance=0)
    assert same_partition(weighted.labels, truth)
    order = cost_matrix(weighted.centroids, repeated.centroids, align=True).argmin(1)
    same = cost_matrix(weighted.centroids, repeated.centroids[order], align=True)
    assert np.diag(same).max() < 1e-20
    assert weighted.cost == pytest.approx(repeated.cost, rel=1e-9)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("unit", [1e-320, 1e-300, 2.0**-40, 1e300, 1e308])
def test_the_unit_of_weights_does_not_matter(unit: float) -> None:
    x, _ = noisy("circle", 60, 6)
    one, other = kmeans(x, 4), kmeans(x, 4, weights=np.full(60, unit))
    np.testing.assert_array_equal(one.labels, other.labels)
    np.testing.assert_allclose(one.centroids.values, other.centroids.values, rtol=1e-12, atol=1e-12)
    if 1e-300 < unit < 1e300:
        assert other.cost == pytest.approx(one.cost * unit, rel=1e-12)


@pytest.mark.filterwarnings("error")
def test_objects_without_weight_that_no_centroid_reaches() -> None:
    x, _ = noisy("circle", 6)
    run = clusters.Clustering(x, 3, np.array([0.0, 1, 1, 1, 1, 1]), "positive", True, 1)
    new = x.values[:3].copy()
    run._reseed(new, np.zeros(6, np.int64), np.array([np.inf, 1.0, 5.0, 2.0, 3.0, 4.0]))
    np.testing.assert_array_equal(new, x.values[[0, 2, 5]])  # the two empty ones: the costliest that count


def test_the_same_for_any_number_of_threads_and_any_run() -> None:
    x, _ = noisy("circle", 3000, 2)
    one, two, again = (kmeans(x, 7, seed=3, threads=t) for t in (1, 2, 2))
    for other in (two, again):
        np.testing.assert_array_equal(one.labels, other.labels)
        np.testing.assert_array_equal(one.centroids.values, other.centroids.values)
        assert one.cost == other.cost
    assert not np.array_equal(one.labels, kmeans(x, 7, seed=4).labels)


def test_a_cluster_without_objects_starts_again_at_the_farthest() -> None:
    x = cga.line([[0, 0, 0], [0, 0.1, 0], [0, 5, 0], [0, 5.1, 0], [0, 9, 0]], [1, 0, 0])
    run = clusters.Clustering(x, 3, None, "positive", True, 1)
    start = x[np.array([0, 0, 3])]  # the second of two equal centroids gets nothing
    labels, _, cost, _, converged = list(run.iterations(start, 50, 0.0))[-1]
    assert converged and same_partition(labels, np.array([0, 0, 1, 1, 2])) and cost < 0.01


def test_ties_go_to_the_first_centroid_whichever_moved() -> None:
    x, centroids = cga.point([[0.0, 0, 0]]), cga.point([[-1.0, 0, 0], [1, 0, 0], [0, 1, 0]])
    run = clusters.Clustering(cga.point(np.zeros((3, 3))), 3, None, "positive", True, 1)
    run.x = x
    for moved in ([True, False, False], [False, True, False], [True, True, False], [True, True, True]):
        labels, cost = run._reassign(centroids, np.array(moved), np.array([1]), np.array([0.75]))
        assert labels.tolist() == ([0] if moved[0] else [1 if moved != [False, True, False] else 0]) and cost == 0.75


def test_fewer_different_objects_than_clusters() -> None:
    x = cga.line(np.zeros((6, 3)), [1, 0, 0])
    for init in clusters.STARTS:
        found = kmeans(x, 4, init=init)
        assert found.converged and found.cost < 1e-20 and not np.isnan(found.centroids.values).any()
    every = kmeans(x, 6)
    assert every.centroids.shape == (6,)


def test_sums_that_vanish_keep_the_centroid() -> None:
    x = cga.plane([[1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0]], 0.0)
    found = kmeans(x, 1, align=False)
    assert np.isfinite(found.centroids.values).all() and found.converged


def test_far_from_the_origin() -> None:
    x, truth = noisy("circle", 90)
    near = kmeans(x, 3)
    far = cga.circle(x.parameters().center + 1e6, x.parameters().normal, x.parameters().radius)
    found = kmeans(far, 3)
    assert same_partition(found.labels, truth)
    centers = found.centroids.parameters().center - 1e6
    expected = near.centroids.parameters().center
    distance = np.linalg.norm(centers[:, None] - expected, axis=-1)
    assert distance.min(1).max() < 0.02


@pytest.mark.slow
def test_single_precision() -> None:
    x, truth = noisy("line", 90)
    found = kmeans(x.astype(np.float32), 3)
    assert same_partition(found.labels, truth) and found.centroids.dtype == np.float32


def test_shapes_and_progress() -> None:
    x, _ = noisy("line", 24)
    told: list[tuple[int, int]] = []
    found = kmeans(x.reshape(4, 6), 3, init="random", progress=lambda p: told.append((p.done, p.total)))
    assert found.labels.shape == (4, 6) and told and told[0] == (1, clusters.MAX_ITERATIONS)
    np.testing.assert_array_equal(found.labels.ravel(), kmeans(x, 3, init="random").labels)


def test_iterations_that_run_out_are_told() -> None:
    x, _ = noisy("line", 300, 7)
    found = kmeans(x, 12, init="random", iterations=1, tolerance=0)
    assert not found.converged and found.status == bs.Status.NOT_CONVERGED and found.iterations == 1


LINES = cga.line(np.eye(3), np.eye(3)[::-1])


@pytest.mark.parametrize(
    ("arguments", "error", "message"),
    [
        ({"k": 4}, errors.InputError, "4 clusters of 3 objects"),
        ({"k": 0}, errors.InputError, "k is 0; a positive whole number"),
        ({"k": 1.5}, errors.InputError, "k is 1.5; a positive whole number"),
        ({"X": cga.line(np.empty((0, 3)), np.empty((0, 3)))}, errors.InputError, "no objects"),
        (
            {"X": cga.line([[0, 0, 0], [0, 0, 0], [np.nan, 0, 0]], [1, 0, 0])},
            errors.InputError,
            "object 2 is not an object",
        ),
        ({"X": [LINES, cga.plane([1, 0, 0], 1.0)]}, errors.GradeError, "same grade"),
        ({"weights": [1, 1]}, errors.ShapeError, "weights has shape"),
        ({"weights": [1, -1, 1]}, errors.InputError, r"weights\[1\] is -1.0"),
        ({"weights": [0, 0, 0]}, errors.InputError, "all weights are zero"),
        ({"init": np.zeros(2)}, errors.InputError, "one of k-means"),
        ({"cost": ["positive"]}, errors.InputError, "one of positive, thesis"),
        ({"tolerance": "small"}, errors.InputError, "tolerance is 'small'; a number of at least 0 and less than 1"),
        ({"tolerance": None}, errors.InputError, "tolerance is None"),
        ({"tolerance": np.nan}, errors.InputError, "tolerance is nan"),
        ({"tolerance": 10**400}, errors.InputError, "a number of at least 0 and less than 1"),
        ({"align": np.zeros(2)}, errors.InputError, "align is array"),
        ({"progress": np.zeros(2)}, errors.InputError, "progress is array"),
        ({"init": "kmeans++"}, errors.InputError, "did you mean 'k-means\\+\\+'"),
        ({"cost": "printed"}, errors.InputError, "positive, thesis"),
        ({"iterations": 0}, errors.InputError, "iterations is 0"),
        ({"tolerance": -1.0}, errors.InputError, "tolerance is -1.0"),
        ({"seed": -1}, errors.InputError, "seed is -1"),
        ({"threads": 0}, errors.InputError, "a whole number from 1"),
    ],
)
def test_bad_input(arguments: dict[str, Any], error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        kmeans(**{"X": LINES, "k": 2, **arguments})
