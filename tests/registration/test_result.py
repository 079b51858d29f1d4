"""Results of registration: matches and inliers used as arrays over all objects, and read by kind."""

import pickle

import numpy as np
import pytest

from bladesmith import registration

from ..support.registration import POSE, apart, lines_and_planes


def found():
    reference = lines_and_planes()
    return registration.register(reference.transformed(~POSE).subset(range(2, 18)), reference)


def test_matches_and_inliers_are_used_as_arrays_over_all_objects():
    result = found()
    right = np.r_[2:12, 0:6]
    matches, inliers = result.matches, result.inliers
    assert apart(result.motor, POSE) < 1e-12
    assert np.array_equal(np.array(matches), right) and matches.tolist() == right.tolist()
    assert (matches == right).all() and not (matches != right).any() and (right == matches).all()
    assert (matches >= 0).sum() == inliers.sum() == np.sum(inliers) == len(matches) == matches.size == 16
    assert matches.shape == (16,) and matches.dtype == np.int64 and inliers.dtype == bool
    assert inliers.all() and inliers.mean() == 1.0 and not (~inliers).any() and (inliers & (matches > 0)).sum() == 15
    assert matches[0] == 2 and matches[-1] == 5 and matches[inliers].max() == matches.max() == 11
    assert np.where(matches < 0, 0, matches).dtype == np.int64 and (matches + 1).sum() == right.sum() + 16


def test_matches_are_read_by_kind_and_cannot_be_changed_by_accident():
    matches = found().matches
    assert matches["lines"].tolist() == matches["line"].tolist() == list(range(2, 12))
    assert "lines" in matches and "plane" in matches and "circles" not in matches
    assert 11 in matches and -1 not in matches
    assert [(kind, len(values)) for kind, values in matches.items()] == [("lines", 10), ("planes", 6)]
    assert dict(matches).keys() == dict(matches.items()).keys() == {"lines", "planes"}
    with pytest.raises(ValueError, match="read-only"):
        matches.sort()
    with pytest.raises(TypeError):
        matches += 1
    with pytest.raises(AttributeError, match="PerItem has no attribute 'rows'"):
        matches.rows  # noqa: B018
    again = pickle.loads(pickle.dumps(matches))
    assert (again == matches).all() and again.keys() == matches.keys()
    array = np.array(matches)
    array[0] = -1  # a copy
    assert matches[0] == 2
