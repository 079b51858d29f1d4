"""Results of registration in files, and in words."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest

import bladesmith as bs
from bladesmith import registration
from bladesmith.errors import InputError
from bladesmith.registration import summary

from ...support.registration import POSE, full_disk, mixed, noisy_lines, random_lines, same, tables, unrelated

CGA = bs.cga3d


@pytest.mark.parametrize("models", [tables, noisy_lines, unrelated, lambda: (mixed(3).transformed(~POSE), mixed(3))])
def test_results_come_back_the_same_to_the_last_bit(models, tmp_path):
    query, reference = models()
    result = registration.register(query, reference)
    place = tmp_path / "result.json"
    registration.save_registration(place, result, query, reference, seed=0, backend="c")
    same(registration.load_registration(place), result)
    data = json.loads(place.read_text(), parse_constant=pytest.fail)  # no NaN, no Infinity
    assert data["settings"] == {"seed": 0, "backend": "c"} and data["query"]["lines"] == query.counts["line"]
    assert data["made_by"]["bladesmith"] == bs.__version__


def test_a_file_has_all_that_another_program_needs(tmp_path):
    """Its matrix lays the query on what it says was matched; numbers of JSON and NumPy alone."""
    reference = mixed(4)
    query = reference.transformed(~POSE).subset(np.random.default_rng(1).permutation(len(reference)))
    registration.save_registration(tmp_path / "r.json", registration.register(query, reference))
    data = json.loads((tmp_path / "r.json").read_text())
    matrix = np.array(data["motor"]["matrix"])
    for key, kind in (("points", "point"), ("spheres", "sphere"), ("circles", "circle")):
        places, wanted = query.parameters[kind][:, :3], reference.parameters[kind][data["matches"][key]][:, :3]
        np.testing.assert_allclose(places @ matrix[:3, :3].T + matrix[:3, 3], wanted, atol=1e-12)
    assert dict(zip(data["motor"]["blades"], data["motor"]["coefficients"], strict=True)) == pytest.approx(
        {
            b: s * POSE[b]
            for s in [np.sign(POSE["1"] * data["motor"]["coefficients"][0])]
            for b in data["motor"]["blades"]
        }
    )
    assert data["covariance"]["blades"] == ["e12", "e13", "e1ni", "e23", "e2ni", "e3ni"]


def test_similarities_in_files(tmp_path):
    """The matrix holds the scale, of the pose and of others that serve; the motor comes back."""
    query, reference = tables()
    query = query.in_frame((0, 0, 0), 2.0)
    result = registration.register(query, reference, similarity=True)
    assert result.ambiguous and result.scale == pytest.approx(2, rel=1e-12)
    registration.save_registration(tmp_path / "r.json", result, query, reference)
    same(registration.load_registration(tmp_path / "r.json"), result)
    data = json.loads((tmp_path / "r.json").read_text())
    for motor, found in zip([result.motor, *result.ambiguous], [data["motor"], *data["ambiguous"]], strict=True):
        here = (motor >> CGA.point((2, 4, 6))).parameters().xyz
        np.testing.assert_allclose((np.array(found["matrix"]) @ (1, 2, 3, 1))[:3], here, rtol=1e-12)
    assert "\npose:        scale by 2, turn by " in "\n" + str(result)
    assert summary.pose_text(CGA.dilator(2.0) * POSE).startswith("scale by 2, turn by 114.592 degrees")


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda d: d.pop("motor"), r"r.json: motor is missing"),
        (lambda d: d.update(format="bladesmith-model"), r'r.json: is not a registration: it has no "format"'),
        (lambda d: d.update(version=2), r"r.json: version is 2; this release reads version 1"),
        (lambda d: d["motor"]["coefficients"].pop(), r"r.json, line 1: motor.coefficients has 7 numbers; 8 are needed"),
        (lambda d: d["motor"].update(blades=["e1"] * 8), r"r.json, line 1: motor.blades are not those of a motor"),
        (lambda d: d["covariance"]["rows"].pop(), r"r.json, line 1: covariance has 5 rows; 6 are needed"),
        (lambda d: d["covariance"]["rows"][0].pop(), r"line 1: covariance.rows\[0\] has 5 numbers; 6 are needed"),
        (lambda d: d["matches"]["lines"].append(1.5), r"r.json, line 1: matches.lines\[22\] is 1.5; "),
        (lambda d: d["history"][0].update(hits="x"), r"r.json, line 1: history\[0\].hits is \"x\"; "),
        (lambda d: d.update(center=[0, 0.5]), r"r.json, line 1: center has 2 numbers; 3 are needed"),
        (lambda d: d.update(costs=1), r"r.json, line 1: costs is not a known key; did you mean 'cost'"),
    ],
)  # fmt: skip
def test_hostile_files_are_told_with_path_and_key(change, message, tmp_path):
    place = tmp_path / "r.json"
    registration.save_registration(place, registration.register(*tables()))
    data = json.loads(place.read_text())
    change(data)
    place.write_text(json.dumps(data))
    with pytest.raises(InputError, match=message):
        registration.load_registration(place)


def test_what_cannot_be_saved_leaves_the_old_file(tmp_path, monkeypatch):
    result, place = registration.register(*tables()), tmp_path / "r.json"
    place.write_text("old")
    for wrong, message in [
        ({"seed": np.arange(3)}, "the setting seed is array"),
        ({"seed": object()}, "is an object"),
    ]:
        with pytest.raises(InputError, match=message):
            registration.save_registration(place, result, **wrong)
    with pytest.raises(InputError, match="the result is .*; a Registration is needed"):
        registration.save_registration(place, {})
    with pytest.raises(InputError, match="cannot be written: No such file"):
        registration.save_registration(tmp_path / "no" / "r.json", result)
    monkeypatch.setattr("os.replace", full_disk)
    with pytest.raises(InputError, match="cannot be written: No space left"):
        registration.save_registration(place, result)
    assert [p.name for p in tmp_path.iterdir()] == ["r.json"] and place.read_text() == "old"


def test_models_that_were_not_registered_are_refused(tmp_path):
    """By their kinds and counts: a file that names others would mislead."""
    query, reference = noisy_lines()
    result, place = registration.register(query, reference), tmp_path / "r.json"
    more = registration.Model(lines=random_lines(43, np.random.default_rng(1)))
    mixed_in = registration.Model(lines=query.parameters["line"].reshape(-1, 2, 3), points=[(0, 0, 0)])
    points = registration.Model(points=np.zeros((40, 3)))
    for models, message in [
        ((more, reference), "the lines of the models .* the query has 43, and the result is of 40"),
        ((mixed_in, reference), "the points of the models .* the query has 1, and the result is of 0"),
        ((points,), "the points of the models .* the query has 40, and the result is of 0"),
        ((query, query.subset({"lines": range(10)})), "the reference has 10, and the result is of at least"),
        ((query, points), "the lines of the models .* the reference has 0, and the result is of at least"),
        ((reference.parameters, reference), "the query is .*; a reform.Model is needed"),
    ]:
        with pytest.raises(InputError, match=message):
            registration.save_registration(place, result, *models)
    assert not place.exists()
    registration.save_registration(place, result, query, mixed_in)  # the reference may hold what the query has not
    registration.save_registration(place, result, query)
    registration.save_registration(place, result, None, reference)


def test_poses_in_words():
    random = np.random.default_rng(2)
    for _ in range(20):
        axis, angle, shift = random.normal(size=3), random.uniform(-7, 7), random.normal(size=3)
        motor = CGA.translator(shift) * CGA.rotor(axis, angle)
        found, turn = summary.axis_angle(motor)
        assert 0 <= turn <= math.pi
        rotation = motor.to_matrix()[:3, :3]
        np.testing.assert_allclose(rotation @ found, found, atol=1e-12)
        assert np.trace(rotation) == pytest.approx(1 + 2 * math.cos(turn), abs=1e-12)
    assert (
        summary.pose_text(CGA.translator((1, 0, 1e-17)).as_kind("motor"), " m") == "no turn, then move by (1, 0, 0) m"
    )


def test_deviations_are_those_of_poses_drawn_from_the_covariance():
    query, reference = noisy_lines()
    result = registration.register(query, reference)
    random = np.random.default_rng(3)
    twists = random.multivariate_normal(np.zeros(6), result.covariance, 4000)
    matrices = CGA.wrap(CGA.kind("twist"), twists).exp().to_matrix()
    turn = np.stack([matrices[:, 2, 1], matrices[:, 0, 2], matrices[:, 1, 0]], 1)  # small: as vectors
    there = matrices[:, :3, :3] @ result.center + matrices[:, :3, 3]
    wanted = [np.sqrt(np.linalg.eigvalsh(np.cov(x.T))[-1]) for x in (turn, there)]
    np.testing.assert_allclose(result.deviations, wanted, rtol=0.1)
    drawn = np.cov(np.hstack([turn, matrices[:, :3, 3]]).T)
    scale = np.sqrt(np.outer(np.diag(drawn), np.diag(drawn)))
    np.testing.assert_allclose(result.pose_covariance / scale, drawn / scale, atol=0.1)


def test_summary_says_what_is_to_be_relied_on():
    query, reference = tables()
    text = summary.summary(registration.register(query, reference), "m")
    for part in ("22 of 22 lines", "converged:   yes", "10^-", "other pose", " m\n", "degrees and"):
        assert part in text
    query, reference = unrelated()
    text = str(registration.register(query, reference))
    assert "converged:   no: " in text and "of 12 points" in text
