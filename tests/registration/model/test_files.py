"""Files of models: the same to the last bit, hostile and damaged ones, the examples."""

from __future__ import annotations

import json
import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import bladesmith as bs
from bladesmith import cga3d as cga
from bladesmith import errors
from bladesmith.registration.model.model import Model

from ...support.registration import EXAMPLES, model_of, same_objects

# -- files -------------------------------------------------------------------------------------------------

coordinate = st.floats(-1e60, 1e60, allow_subnormal=True)
vector = st.tuples(coordinate, coordinate, coordinate)
direction = st.tuples(*[st.floats(-1e100, 1e100)] * 3).filter(any)
radius = st.floats(1e-60, 1e60)


@pytest.mark.slow
@settings(max_examples=60, deadline=None)
@given(st.lists(vector, max_size=4), st.lists(st.tuples(vector, direction), max_size=4),
       st.lists(st.tuples(vector, direction, radius), max_size=4),
       st.text(st.characters(codec="utf-8"), max_size=8))  # fmt: skip
def test_files_come_back_the_same_to_the_last_bit(tmp_path_factory, points, lines, circles, name):
    path = tmp_path_factory.mktemp("models") / "m.json"
    rows = [(*c, *n, r) for c, n, r in circles]
    m = Model(points=points, lines=lines, circles=rows, name=name)
    m.save(path)
    again = Model.load(path)
    assert again.counts == m.counts and again.name == name
    for kind, part in m.parameters.items():
        np.testing.assert_array_equal(again.parameters[kind], part)
        np.testing.assert_array_equal(again.objects[kind].values, m.objects[kind].values)


def test_models_that_were_moved_often_come_back_the_same(tmp_path):
    m = model_of(11)
    for _ in range(50):
        m = m.transformed(cga.rotor((1, 2, 3), 0.7))
    assert (np.abs(np.linalg.norm(m.parameters["line"][:, 3:], axis=1) - 1) < 1e-15).all()
    m.save(tmp_path / "m.json")
    again = Model.load(tmp_path / "m.json")
    for kind, rows in m.parameters.items():
        np.testing.assert_array_equal(again.parameters[kind], rows)


def test_files_are_readable_and_in_order(tmp_path):
    m = Model(lines=[[(1, 2, 3), (0, 0, 2)], [(0, 0, 0), (1, 0, 0)]], planes=[(0, 0, 1, 0.1)], name="tïsch", unit="m")
    m.save(tmp_path / "m.json")
    text = (tmp_path / "m.json").read_text(encoding="utf-8")
    assert '"name": "tïsch"' in text
    assert '    {"point": [1.0, 2.0, 3.0], "direction": [0.0, 0.0, 1.0]},\n' in text
    data = json.loads(text)
    assert list(data) == ["format", "version", "name", "unit", "lines", "planes"]
    assert data["planes"] == [{"normal": [0, 0, 1], "offset": 0.1}]


def test_what_cannot_be_written_leaves_the_old_file(tmp_path):
    path = tmp_path / "m.json"
    model_of().save(path)
    before = path.read_bytes()
    for bad in (tmp_path, tmp_path / "no" / "m.json", "a\0b", 7):
        with pytest.raises(errors.InputError):
            model_of(1).save(bad)
    assert path.read_bytes() == before and list(tmp_path.iterdir()) == [path]


WORDS = {
    "HEAD": '"format": "bladesmith-model", "version": 1', "LINE": '{"point": [0, 0, 0], "direction": [0, 0, 1]}',
    "ZEROS": 5000 * "0", "LESSDEEP": 500 * "[" + 500 * "]", "DEEP": 5000 * "[" + 5000 * "]",
}  # fmt: skip


def written(text):
    for word, meaning in WORDS.items():
        text = text.replace(word, meaning)
    return text


HOSTILE = [
    ("", "is not JSON"),
    ("{", "line 1, column 2"),
    ("[1, 2]", "is not a model"),
    ("{}", 'no "format"'),
    ('{"format": "bladesmith-model"}', "version is"),
    ('{"format": "bladesmith-model", "version": 2}', "version is 2; .*newer"),
    ('{"format": "bladesmith-model", "version": true}', "version is true"),
    (
        '{HEAD, "lines": [LINE, LINE, {"point": [0, 0, 0], "direction": [0, 0]}]}',
        r"line 1: lines\[2\]\.direction",
    ),
    (
        '{HEAD, "lines": [LINE, {"point": [0, 0, 0], "direction": [0, 0, 0]}]}',
        r"m\.json, line 1: lines\[1\]\.direction is .*not zero",
    ),
    ('{HEAD, "lines": [{"point": [0, 0, 0]}]}', r"lines\[0\] has no direction"),
    ('{HEAD, "lines": [{"point": [0, 0, 0], "directoin": [0, 0, 1]}]}', "directoin.*did you mean 'direction'"),
    ('{HEAD, "lnes": []}', "lnes.*did you mean 'lines'"),
    ('{HEAD, "lines": {}}', "lines"),
    ('{HEAD, "lines": null}', "lines"),
    ('{HEAD, "lines": [LINE], "lines": []}', "duplicate key 'lines'"),
    ('{HEAD, "points": [{"xyz": [0, 0, NaN]}]}', r"line 1: points\[0\]\.xyz\[2\] is nan; numbers are finite"),
    ('{HEAD, "points": [{"xyz": [0, 0, -Infinity]}]}', r"xyz\[2\] is -inf; numbers are finite"),
    ('{HEAD, "points": [{"xyz": [0, 0, 1e999]}]}', r"points\[0\]\.xyz\[2\]"),
    ('{HEAD, "points": [{"xyz": [0, 0, 1ZEROS]}]}', "number|points"),
    ('{HEAD, "points": [{"xyz": [0, 0, "1"]}]}', r"points\[0\]\.xyz\[2\].*number"),
    ('{HEAD, "points": [{"xyz": [0, 0, true]}]}', r"points\[0\]\.xyz\[2\]"),
    ('{HEAD, "points": [{"xyz": [0, 0, null]}]}', r"points\[0\]\.xyz\[2\]"),
    ('{HEAD, "points": [{"xyz": [0, 0, 1e200]}]}', r"points\[0\]\.xyz"),
    ('{HEAD, "spheres": [{"center": [0, 0, 0], "radius": -1}]}', r"spheres\[0\]\.radius is -1.*positive"),
    ('{HEAD, "spheres": [{"center": [0, 0, 0], "radius": 0}]}', r"spheres\[0\]\.radius"),
    ('{HEAD, "point_pairs": [{"a": [0, 0, 0], "b": [0, 0, 0]}]}', r"point_pairs\[0\]\.b"),
    ('{HEAD, "name": 3}', "name is 3"),
    ('{HEAD, "name": "\\ud800"}', "m.json"),
    ('{HEAD, "lines": DEEP}', "nested too deeply"),
    ('{HEAD, "lines": LESSDEEP}', "lines|nested|recursion"),
]


@pytest.mark.parametrize("text, message", HOSTILE, ids=range(len(HOSTILE)))
def test_hostile_files_are_told_with_path_and_key(tmp_path, text, message):
    (tmp_path / "m.json").write_text(written(text))
    with pytest.raises(errors.InputError, match=message) as caught:
        Model.load(tmp_path / "m.json")
    assert str(caught.value).startswith(str(tmp_path / "m.json")) and "\n" not in str(caught.value)
    assert len(str(caught.value)) < 400 + len(str(tmp_path))


@settings(max_examples=60, deadline=None)
@given(st.binary(max_size=40), st.integers(0, 300))
def test_damaged_files_are_input_errors_or_models(tmp_path_factory, junk, at):
    path = tmp_path_factory.mktemp("damaged") / "m.json"
    model_of(1, n=1).save(path)
    good = path.read_bytes()
    path.write_bytes(good[:at] + junk + good[at + len(junk) :])
    try:
        Model.load(path)
    except errors.InputError as error:
        assert "m.json" in str(error)


def test_what_is_no_file(tmp_path):
    (tmp_path / "latin.json").write_bytes(b'{"name": "\xe9"}')
    for bad in (tmp_path, tmp_path / "none.json", "a\0b", 7, None, tmp_path / "latin.json"):
        with pytest.raises(errors.InputError):
            Model.load(bad)
    bs.save(tmp_path / "m.npz", **model_of().objects)
    with pytest.raises(errors.InputError, match="bladesmith.load"):
        Model.load(tmp_path / "m.npz")
    stored = bs.load(tmp_path / "m.npz")
    same_objects(Model(**{f"{kind}s": x for kind, x in stored.items()}).objects, model_of().objects)


def test_a_byte_order_mark_and_whole_numbers_are_fine(tmp_path):
    (tmp_path / "m.json").write_text(written('\ufeff{HEAD, "lines": [LINE]}'), encoding="utf-8")
    assert len(Model.load(tmp_path / "m.json")) == 1


@pytest.mark.slow
def test_large_files(tmp_path):
    m = Model(lines=np.random.default_rng(0).normal(size=(20_000, 2, 3)))
    m.save(tmp_path / "m.json")
    np.testing.assert_array_equal(Model.load(tmp_path / "m.json").parameters["line"], m.parameters["line"])


# -- examples ----------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_the_table_is_made_by_its_script(tmp_path):
    script = [sys.executable, str(EXAMPLES / "make_table.py"), "--folder", str(tmp_path)]
    subprocess.run(script, check=True, capture_output=True)
    assert (tmp_path / "table.json").read_text() == (EXAMPLES / "table.json").read_text()
    made, kept = (Model.load(folder / "table_query.json").parameters["line"] for folder in (tmp_path, EXAMPLES))
    np.testing.assert_allclose(made, kept, atol=1e-14)


def test_the_examples():
    table, query = (Model.load(EXAMPLES / f"{name}.json") for name in ("table", "table_query"))
    assert table.counts == query.counts == {"line": 22}
    along = np.abs(table.parameters["line"][:, 3:] @ table.parameters["line"][:, 3:].T)
    assert (along > 1 - 1e-12).sum(1).max() == 16
    for axis, angle in (((0, 0, 1), np.pi), ((0, 0, 1), 0.3), ((1, 0, 0), np.pi)):
        other = table.transformed(cga.rotor(axis, angle))
        both = Model(lines=[table.lines, other.lines]).duplicates()[22:]
        assert (both < 22).all() == (axis == (0, 0, 1) and angle == np.pi)
    airplane = Model.load(EXAMPLES / "airplane.json")
    assert len(airplane) >= 1000 and "PyVista" in airplane.origin and "MIT" in airplane.origin
    assert (EXAMPLES / "airplane.json").stat().st_size < 400_000
    np.testing.assert_array_equal(airplane.duplicates(1e-6), np.arange(len(airplane)))
