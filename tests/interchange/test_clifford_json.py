"""JSON files of the package `clifford`: written by one, read by the other."""

import json
from functools import cache
from typing import Any

import numpy as np
import pytest

import bladesmith as bs
from bladesmith import cga3d as cga
from bladesmith import errors
from bladesmith.interchange import clifford_json

from ..oracles.clifford_layouts import Imported, clifford

clifford_io = Imported("clifford.io")


@cache
def layout() -> Any:
    return clifford.Cl(4, 1)[0]


def circles(rng, n=5):
    return cga.circle(rng.normal(size=(n, 3)), rng.normal(size=(n, 3)), rng.uniform(0.1, 2, n))


@pytest.mark.slow
def test_clifford_reads_what_we_write(tmp_path):
    ours = circles(np.random.default_rng(1))
    clifford_json.save_json(tmp_path / "c.json", ours)
    data, metric, names, support = clifford_io.read_json_file(tmp_path / "c.json")
    assert data.shape == (5, 32) and support is None and list(names) == ["e1", "e2", "e3", "e4", "e5"]
    np.testing.assert_array_equal(np.diag(metric), [1, 1, 1, 1, -1])
    for row, x in zip(data, ours, strict=True):
        theirs = layout().MultiVector(row)
        np.testing.assert_allclose((theirs * theirs).value[0], 1, rtol=1e-13)  # still unit circles over there
        back = bs.from_clifford(theirs, algebra=cga).as_kind("circle")
        np.testing.assert_allclose(back.values, x.values, rtol=1e-15, atol=1e-15)


@pytest.mark.slow
def test_we_read_what_clifford_writes(tmp_path):
    values = np.random.default_rng(2).normal(size=(3, 32))
    clifford_io.write_json_file(tmp_path / "a.json", values, layout().metric, layout().basis_names)
    found = clifford_json.load_json(tmp_path / "a.json")
    assert found.algebra is bs.algebra(4, 1, 0) and found.shape == (3,)
    for x, row in zip(found, values, strict=True):
        np.testing.assert_array_equal(x.to_clifford(layout()).value, row)
    turned = tmp_path / "t.json"
    clifford_io.write_json_file(turned, values, layout().metric, layout().basis_names, transpose=True)
    np.testing.assert_array_equal(clifford_json.load_json(turned).values, found.values)


def test_round_trip_into_the_null_basis(tmp_path):
    ours = circles(np.random.default_rng(3))
    clifford_json.save_json(tmp_path / "c.json", ours)
    back = clifford_json.load_json(tmp_path / "c.json", cga).normalized("circle")
    np.testing.assert_allclose(back.values, ours.values, rtol=1e-14, atol=1e-15)
    one = tmp_path / "one.json"
    clifford_json.save_json(one, ours[0])
    assert clifford_json.load_json(one).shape == (1,)


@pytest.mark.parametrize(
    "change",
    [
        {"version": "9"},
        {"metric": [[1, 1], [0, 1]]},
        {"metric": [[4, 0], [0, 1]]},
        {"dataset": {"data": [[1, 2, 3]], "transpose": False, "sparse": False}},
        {"dataset": {"data": [[1, 2, 3, float("nan")]], "transpose": False, "sparse": False}},
        {"dataset": {"data": [[1, 2], [3]], "transpose": False, "sparse": False}},
        {"dataset": {"data": [[1, 2, 3, 4]], "transpose": False, "sparse": True}},
        {"dataset": {"data": [[10**400, 0, 0, 0]], "transpose": False, "sparse": False}},
        {"dataset": {"data": None, "transpose": False, "sparse": False}},
        {"dataset": 7},
    ],
)
def test_damaged_files_are_refused_with_their_name(tmp_path, change):
    good = {
        "version": "0.0.1",
        "dataset": {"data": [[1, 2, 3, 4]], "transpose": False, "sparse": False, "support": []},
        "metric": [[1, 0], [0, 1]],
        "basis_names": ["e1", "e2"],
    }
    path = tmp_path / "x.json"
    path.write_text(json.dumps(good))
    assert clifford_json.load_json(path).algebra is bs.algebra(2, 0, 0)
    path.write_text(json.dumps(good | change))
    with pytest.raises(errors.BladesmithError, match="x.json"):
        clifford_json.load_json(path)


def test_a_batch_of_no_items_comes_back(tmp_path):
    clifford_json.save_json(tmp_path / "x.json", circles(np.random.default_rng(4), 4)[:0])
    assert clifford_json.load_json(tmp_path / "x.json", cga).shape == (0,)


def test_what_cannot_be_a_file(tmp_path):
    with pytest.raises(errors.InputError, match="cannot be read"):
        clifford_json.load_json(tmp_path / "none.json")
    (tmp_path / "text.json").write_text("{not json")
    with pytest.raises(errors.InputError, match="text.json"):
        clifford_json.load_json(tmp_path / "text.json")
    (tmp_path / "deep.json").write_text("[" * 100_000)
    with pytest.raises(errors.InputError, match="deep.json"):
        clifford_json.load_json(tmp_path / "deep.json")
    for call in (clifford_json.load_json, lambda path: clifford_json.save_json(path, cga.e1)):
        with pytest.raises(errors.InputError, match="a file, and None names none"):
            call(None)
    with pytest.raises(errors.InputError, match="algebra is 'cga3d'"):
        clifford_json.load_json(tmp_path / "none.json", algebra="cga3d")
    with pytest.raises(errors.InputError, match="Reshape"):
        clifford_json.save_json(tmp_path / "x.json", circles(np.random.default_rng(4), 4).reshape(2, 2))
    with pytest.raises(errors.InputError, match="not finite"):
        clifford_json.save_json(tmp_path / "x.json", cga.circle((0, 0, 0), (0, 0, 1), -1.0))
    assert not (tmp_path / "x.json").exists()
