"""Weights, covariances and robust losses of matched objects, against closed forms, SciPy and statistics of noise."""

from __future__ import annotations

import pickle

import numpy as np
import pytest
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation

from bladesmith import errors, reform
from bladesmith.registration.estimation.objective import LOSSES

from ...support.effort import seeds
from ...support.registration import POSE, apart, fresh, moved, pose
from ...support.vectors import unit

#: Parameters of an object and residuals of a match, by the names of the arguments.
KINDS = {"points": (3, 3), "point_pairs": (6, 6), "lines": (6, 4), "segments": (6, 6), "circles": (7, 6),
         "planes": (4, 3), "spheres": (4, 4)}  # fmt: skip


def covariances(n, k, size, rng):
    """Random covariances of sizes that differ by ten."""
    factor = size * rng.normal(size=(n, k, k)) * rng.uniform(0.2, 2, (n, 1, 1))
    return factor @ factor.swapaxes(1, 2) / k


def with_errors(kind, rows, of, rng):
    """Parameters with errors of these covariances; directions have length 1."""
    found = rows.reshape(len(rows), -1) + np.einsum(
        "nij,nj->ni", np.linalg.cholesky(of), rng.normal(size=(len(rows), of.shape[1]))
    )
    directions = {"lines": slice(3, 6), "circles": slice(3, 6), "planes": slice(0, 3)}.get(kind)
    if directions:
        found[:, directions] = unit(found[:, directions])
    return found.reshape(rows.shape)


@pytest.mark.parametrize("kind", [k if k == "segments" else pytest.param(k, marks=pytest.mark.slow) for k in KINDS])
def test_costs_of_errors_of_the_given_covariances_are_chi_square(kind):
    """Residuals are worth as much as they are uncertain: their sum of squares is their number, less six."""
    size, count = KINDS[kind]
    total = degrees = 0.0
    for seed in seeds(8, 60):
        rng = np.random.default_rng([seed, size, count])
        x = fresh(kind, 60, rng)
        turn, shift, _ = pose(rng)
        of = [covariances(60, size, 1e-3, rng) for _ in range(2)]
        query = reform.Model(
            **{kind: with_errors(kind, moved(kind, x, turn.T, -turn.T @ shift), of[0], rng)}, covariances=of[0]
        )
        reference = reform.Model(**{kind: with_errors(kind, x, of[1], rng)}, covariances=of[1])
        found = reform.register(query, reference)
        assert found.converged
        total, degrees = total + found.cost, degrees + count * found.inliers.sum() - 6
    slack = 4 * np.sqrt(2 / degrees)  # and what is lost to trimming, and to ends that look cut
    assert 0.93 - slack < total / degrees < 1 + slack


def weighted_points(x, y, weights):
    """Rotation and shift of weighted least squares (Kabsch)."""
    a, b = (np.average(v, axis=0, weights=weights) for v in (x, y))
    u, _, vt = np.linalg.svd((x - a).T @ (weights[:, None] * (y - b)))
    turn = (u @ np.diag([1, 1, np.linalg.det(u @ vt)]) @ vt).T
    return turn, b - turn @ a


def noisy_points(seed, n=40, noise=0.01):
    rng = np.random.default_rng(seed)
    y = rng.uniform(-1, 1, (n, 3))
    turn, shift, _ = pose(rng)
    return (y - shift) @ turn + noise * rng.normal(size=y.shape), y, rng


def same_pose(found, turn, shift, tolerance=1e-9):
    matrix = found.motor.to_matrix()
    np.testing.assert_allclose(matrix[:3, :3], turn, atol=tolerance)
    np.testing.assert_allclose(matrix[:3, 3], shift, atol=tolerance)


@pytest.mark.parametrize("of", ["query", "reference", "both", "covariances"])
def test_weights_of_points_are_those_of_least_squares(of):
    x, y, rng = noisy_points(1)
    v, w = rng.uniform(0.1, 3, (2, len(x)))
    eye, sum_of_both = np.eye(3)[None], 1 / (1 / v + 1 / w)
    of_query, of_reference = (eye / z[:, None, None] for z in (v, w))
    given = {
        "query": ({"weights": v}, {}, v),
        "reference": ({}, {"weights": {"points": w}}, w),
        "both": ({"weights": 5 * v}, {"weights": 5 * w}, sum_of_both),
        "covariances": ({"covariances": of_query}, {"covariances": {"points": of_reference}}, sum_of_both),
    }  # fmt: skip
    first, second, total = given[of]
    found = reform.register(reform.Model(points=x, **first), reform.Model(points=y, **second))
    good = np.asarray(found.inliers)
    turn, shift = weighted_points(x[good], y[found.matches["points"][good]], total[good])
    same_pose(found, turn, shift)


@pytest.mark.parametrize("kind", ["points", "lines", "segments", "planes", "spheres"])
def test_an_object_of_no_weight_is_matched_and_does_not_count(kind):
    rng = np.random.default_rng(3)
    reference = fresh(kind, 20, rng)
    query = reference.copy()
    query[:5] += 1e-3 * rng.normal(size=query[:5].shape)
    weights = np.r_[np.zeros(5), np.ones(15)]
    found = reform.register(
        reform.Model(**{kind: query}, weights=weights).transformed(~POSE), reform.Model(**{kind: reference})
    )
    assert apart(found.motor, POSE) < 1e-11


@pytest.mark.parametrize("kind", ["points", "segments"])
def test_an_object_three_times_is_one_of_three_times_the_weight(kind):
    rng = np.random.default_rng(4)
    reference = fresh(kind, 15, rng)
    query = reference + 3e-3 * rng.normal(size=reference.shape)
    whole = reform.Model(**{kind: reference})
    often = reform.Model(**{kind: np.concatenate([query, query[:4], query[:4]])}, weights=np.ones(23))
    heavy = reform.Model(**{kind: query}, weights=np.r_[np.full(4, 3.0), np.ones(11)])
    a, b = (reform.register(m.transformed(~POSE), whole) for m in (often, heavy))
    assert a.inliers.all() and b.inliers.all()
    assert apart(a.motor, b.motor) < (1e-9 if kind == "points" else 3e-4)  # what is held along segments is not the same


@pytest.mark.parametrize("size", [1e-6, 1e6])
def test_the_unit_of_length_does_not_matter(size):
    rng = np.random.default_rng(5)
    x = fresh("segments", 20, rng)
    y, cov = x + 0.01 * rng.normal(size=x.shape), covariances(20, 6, 0.01, rng)
    found, scaled = (
        reform.register(reform.Model(segments=k * y, covariances=k * k * cov), reform.Model(segments=k * x))
        for k in (1.0, size)
    )
    assert found.converged and scaled.converged and np.isclose(found.cost, scaled.cost, rtol=1e-6)
    assert (np.asarray(found.matches) == np.asarray(scaled.matches)).all()


@pytest.mark.parametrize("loss", ["huber", "soft_l1", "cauchy", "tukey"])
def test_losses_are_minimized(loss):
    """Covariances fix the scale: the minimum is that which SciPy finds from the losses' definitions."""
    x, y, rng = noisy_points(6, noise=0.01)
    x[:6] += 0.02 * rng.normal(size=(6, 3))
    found = reform.register(reform.Model(points=x, covariances=1e-4 * np.eye(3)), reform.Model(points=y), loss=loss)
    good = np.asarray(found.inliers)
    a, b = x[good], y[found.matches["points"][good]]
    factor = {"huber": 1.345, "soft_l1": 1.5, "cauchy": 2.385, "tukey": 4.685}[loss]
    rho = {
        "huber": lambda z: np.where(z < 1, z, 2 * np.sqrt(np.maximum(z, 1)) - 1),
        "soft_l1": lambda z: 2 * (np.sqrt(1 + z) - 1),
        "cauchy": lambda z: np.log(1 + z),
        "tukey": lambda z: (1 - np.where(z < 1, 1 - z, 0) ** 3) / 3,
    }[loss]
    matrix = found.motor.to_matrix()

    def cost(p):
        turn = Rotation.from_rotvec(p[:3] / 100).as_matrix() @ matrix[:3, :3]
        z = ((a @ turn.T + matrix[:3, 3] + p[3:] / 100 - b) ** 2).sum(1) / 1e-4 / (3 * factor**2)
        return 3 * factor**2 * rho(z).sum()

    best = minimize(cost, np.zeros(6), tol=1e-13)
    assert np.isclose(found.cost, cost(np.zeros(6)), rtol=1e-9) and found.cost <= best.fun * (1 + 1e-8)


@pytest.mark.slow
def test_a_robust_loss_does_better_where_errors_have_long_tails():
    squares = dict.fromkeys(LOSSES, 0.0)
    for seed in seeds(12, 100):
        rng = np.random.default_rng(seed)
        reference = fresh("segments", 60, rng)
        query = reference + 3e-3 * rng.standard_t(2, size=reference.shape)
        for loss in LOSSES:
            found = reform.register(
                reform.Model(segments=query).transformed(~POSE), reform.Model(segments=reference), loss=loss
            )
            squares[loss] += apart(found.motor, POSE) ** 2
    assert all(squares[loss] < 0.95 * squares["linear"] for loss in ("huber", "cauchy", "tukey"))


def test_uncertainty_goes_with_the_objects(tmp_path):
    rng = np.random.default_rng(7)
    cov = {"points": covariances(4, 3, 1, rng), "planes": covariances(3, 4, 1, rng), "segments": np.eye(6)}
    given = {"points": rng.normal(size=(4, 3)), "planes": rng.normal(size=(3, 4))}
    model = reform.Model(**given, segments=rng.normal(size=(2, 2, 3)), covariances=cov)
    model.save(tmp_path / "m.json")
    for again in (reform.Model.load(tmp_path / "m.json"), pickle.loads(pickle.dumps(model))):
        assert all((again.covariances[k] == v).all() for k, v in model.covariances.items())
    np.testing.assert_array_equal(model.subset({"points": [2, 0]}).covariances["point"], cov["points"][[2, 0]])
    there = model.transformed(POSE).transformed(~POSE)
    for kind, values in model.covariances.items():
        np.testing.assert_allclose(there.covariances[kind], values, atol=1e-12)
    # the parameters of a moved plane vary as those of planes that are moved do
    step = 1e-6 * rng.normal(size=4)
    step[:3] -= (step[:3] @ model.parameters["plane"][0, :3]) * model.parameters["plane"][0, :3]
    rows = [
        reform.Model(planes=model.parameters["plane"][:1] + s).transformed(POSE).parameters["plane"][0]
        for s in (step, -step)
    ]
    one = reform.Model(planes=model.parameters["plane"][:1], covariances=np.outer(step, step)[None]).transformed(POSE)
    np.testing.assert_allclose(
        one.covariances["plane"][0], np.outer(rows[0] - rows[1], rows[0] - rows[1]) / 4, atol=1e-17
    )
    weighted = reform.Model(points=np.eye(3), weights=[1, 2, 3])
    weighted.save(tmp_path / "w.json")
    assert reform.Model.load(tmp_path / "w.json").weights["point"].tolist() == [1, 2, 3]
    assert weighted.covariances is None and model.weights is None


POINTS = np.eye(3)
BAD = [
    (dict(weights=[1, 2]), r"weights has shape \(2,\)"), (dict(weights=[1, -1, 1]), r"weight of points\[1\] is -1"),
    (dict(weights=[1, np.nan, 1]), r"weights\[1\] is nan"), (dict(weights={"points": np.inf}), r"is inf"),
    (dict(weights=[0, 0, 0]), "all zero"), (dict(weights={"lines": 1}), "'lines', which the model does not have"),
    (dict(weights=np.ones(3), covariances=np.eye(3)), "both given"), (dict(covariances=np.eye(2)), r"shape \(2, 2\)"),
    (dict(covariances=0 * np.eye(3)), r"points\[0\] is zero"), (dict(covariances=-np.eye(3)), "negative variance"),
    (dict(covariances=np.triu(np.ones((3, 3)))), "not symmetric"), (dict(covariances=np.nan * np.eye(3)), "nan"),
    (dict(segments=[[(0, 0, 0), (1, 1, 1)]], covariances={"points": np.eye(3)}), "not of the model's segments"),
    (dict(segments=[[(0, 0, 0), (1, 1, 1)]], covariances=np.eye(3)), "2 kinds of object"),
]  # fmt: skip


@pytest.mark.parametrize("given, message", BAD)
def test_what_is_no_uncertainty_is_refused(given, message):
    with pytest.raises(errors.InputError, match=message):
        reform.Model(points=POINTS, **given)


def test_it_is_said_where_no_match_counts():
    x, y, _ = noisy_points(9)
    found = reform.register(reform.Model(points=x, covariances=1e-16 * np.eye(3)), reform.Model(points=y), loss="tukey")
    assert not found.converged and "no match counts" in found.message


def test_weights_and_covariances_do_not_mix():
    x, y, _ = noisy_points(8)
    with pytest.raises(errors.InputError, match="one model has weights and the other covariances"):
        reform.register(reform.Model(points=x, weights=np.ones(40)), reform.Model(points=y, covariances=np.eye(3)))
    with pytest.raises(errors.InputError, match="weights of the query are all zero"):
        model = reform.Model(points=x, weights=np.r_[0, np.ones(39)]).subset([0])
        reform.register(model, reform.Model(points=y))
    with pytest.raises(errors.InputError, match="loss is 'hubber'.*huber"):
        reform.register(reform.Model(points=x), reform.Model(points=y), loss="hubber")
