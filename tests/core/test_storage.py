"""Saving and loading: what comes back, and what a file made to do harm can do (nothing)."""

from __future__ import annotations

import json
import os
import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import bladesmith as bs
from bladesmith.codegen.algebra.loader import data_from_algebra
from bladesmith.common import data_files


def test_round_trips(tmp_path: Path) -> None:
    path = tmp_path / "x.npz"
    points = bs.cga3d.point(np.random.default_rng(0).normal(size=(4, 5, 3)))
    bs.save(path, points)
    again = bs.load(path)
    assert again.algebra is bs.cga3d and again.kind == points.kind and np.array_equal(again.values, points.values)
    spheres = bs.cga3d.sphere(np.zeros((3, 3)), [1.0, -1.0, 2.0])
    single = bs.algebra(2, 1).multivector({"e1": 1.0, "e13": 2.0}, dtype=np.float32)
    bs.save(str(path), s=spheres, single=single, motor=bs.pga3d.rotor([0.0, 0.0, 1.0], 1.0))
    found = bs.load(str(path))
    assert list(found) == ["s", "single", "motor"]
    assert found["s"].status.tolist() == [0, 6, 0] and found["s"].kind == spheres.kind
    assert found["single"].dtype == np.float32 and found["single"].algebra is bs.algebra(2, 1)
    assert found["motor"].algebra is bs.pga3d and found["motor"].kind.name == "rotor"
    assert not [p for p in tmp_path.iterdir() if p != path]  # nothing left beside it


def test_other_algebras(tmp_path: Path) -> None:
    own = bs.Algebra.from_data({**data_from_algebra(bs.algebra(3)), "name": "own", "pseudoscalar": "e132"})
    bs.save(tmp_path / "x.npz", own.e12 * 2.0)
    found = bs.load(tmp_path / "x.npz")
    assert found["e12"] == 2 and found.algebra.name == "own" and found.algebra.pseudoscalar_sign == -1
    assert bs.load(tmp_path / "x.npz").algebra is found.algebra


def test_constraints_are_checked_again(tmp_path: Path) -> None:
    path = tmp_path / "x.npz"
    bs.save(path, bs.cga3d.sphere([0.0, 0.0, 0.0], 1.0))
    stored = dict(np.load(path))
    stored["x.values"] = stored["x.values"] * 2
    np.savez(path, **stored)
    assert bs.load(path).kind.is_layout


class Exploit:
    def __reduce__(self) -> Any:
        return os.mkdir, ("harm",)


def header(**changes: Any) -> np.ndarray:
    entry = {
        "algebra": "cl3_0_0", "vectors": ["1", "2", "3"], "metric": [["1", "0", "0"], ["0", "1", "0"], ["0", "0", "1"]],
        "pseudoscalar": None, "kind": None, "blades": ["e1", "e2"],
    }  # fmt: skip
    text = json.dumps({"format": 1, "single": True, "items": {"x": {**entry, **changes}}})
    return np.frombuffer(text.encode(), np.uint8)


HARMFUL: dict[str, Any] = {
    "pickled values": {"bladesmith": header(), "x.values": np.array([Exploit(), 1], object)},
    "pickled header": {"bladesmith": np.array([Exploit()], object), "x.values": np.ones(2)},
    "no header": {"x.values": np.ones(2)},
    "header of floats": {"bladesmith": np.ones(4), "x.values": np.ones(2)},
    "header no JSON": {"bladesmith": np.frombuffer(b"{", np.uint8), "x.values": np.ones(2)},
    "other format": {"bladesmith": np.frombuffer(b'{"format": 9}', np.uint8)},
    "no dictionary": {"bladesmith": np.frombuffer(b"[1]", np.uint8)},
    "name no identifier": {"bladesmith": header(algebra="a; import os"), "x.values": np.ones(2)},
    "vector no identifier": {"bladesmith": header(vectors=["1", "2", "__x__"]), "x.values": np.ones(2)},
    "metric no numbers": {"bladesmith": header(metric=[["os", "0", "0"]] * 3), "x.values": np.ones(2)},
    "metric of other size": {"bladesmith": header(metric=[["1"]]), "x.values": np.ones(2)},
    "huge algebra": {"bladesmith": header(vectors=[str(i) for i in range(99)]), "x.values": np.ones(2)},
    "unknown blades": {"bladesmith": header(blades=["e1", "e9"]), "x.values": np.ones(2)},
    "blade twice": {"bladesmith": header(blades=["e1", "e1"]), "x.values": np.ones(2)},
    "values of other size": {"bladesmith": header(), "x.values": np.ones(3)},
    "values of text": {"bladesmith": header(), "x.values": np.array(["a", "b"])},
    "no values": {"bladesmith": header()},
    "status of other shape": {"bladesmith": header(), "x.values": np.ones(2), "x.status": np.zeros(4, np.uint8)},
}


@pytest.mark.parametrize("case", sorted(HARMFUL))
def test_files_that_are_not_ours(case: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    np.savez("x.npz", **HARMFUL[case])
    with pytest.raises(bs.errors.InputError, match="x.npz"):
        bs.load("x.npz")
    assert not Path("harm").exists()


def test_kinds_from_files_are_names_only(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    np.savez("x.npz", **{"bladesmith": header(kind="no such kind"), "x.values": np.ones(2)})
    assert bs.load("x.npz").kind.is_layout


def test_damaged_and_missing_files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(bs.errors.InputError, match="missing.npz.*No such file"):
        bs.load("missing.npz")
    Path("text.npz").write_text("not an archive")
    Path("pickle.npz").write_bytes(pickle.dumps(Exploit()))
    bs.save("cut.npz", bs.algebra(2).e1)
    Path("cut.npz").write_bytes(Path("cut.npz").read_bytes()[:200])
    for name in ("text.npz", "pickle.npz", "cut.npz"):
        with pytest.raises(bs.errors.InputError, match=name):
            bs.load(name)
    np.save("array.npy", np.ones(3))
    with pytest.raises(bs.errors.InputError, match="array.npy"):
        bs.load("array.npy")
    assert not Path("harm").exists()


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="shell scripts and pipes are those of POSIX")
def test_a_pipe_is_not_waited_for(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "x.npz")
    for path in (tmp_path / "x.npz", tmp_path):
        with pytest.raises(bs.errors.InputError, match=r"is not a file\. NPZ is read at any place"):
            bs.load(path)


def test_an_interrupted_save_leaves_the_old_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "x.npz"
    bs.save(path, bs.algebra(2).e1)
    before = path.read_bytes()

    def interrupted(*_: Any, **__: Any) -> None:
        raise KeyboardInterrupt

    for owner, name in ((data_files.npy, "write_array_header_1_0"), (os, "replace")):
        with monkeypatch.context() as patched:
            patched.setattr(owner, name, interrupted)
            with pytest.raises(KeyboardInterrupt):
                bs.save(path, bs.algebra(2).e2)
    assert path.read_bytes() == before and list(tmp_path.iterdir()) == [path]


def test_what_cannot_be_saved(tmp_path: Path) -> None:
    with pytest.raises(bs.errors.InputError, match="a multivector is needed"):
        bs.save(tmp_path / "x.npz", np.ones(3))  # type: ignore[arg-type]
    with pytest.raises(bs.errors.InputError, match="one multivector"):
        bs.save(tmp_path / "x.npz")


def test_places_that_cannot_be_written(tmp_path: Path) -> None:
    x = bs.cga3d.point([1.0, 2.0, 3.0])
    for path in (tmp_path, tmp_path / "missing" / "x.npz"):
        with pytest.raises(bs.errors.InputError, match="cannot be written") as caught:
            bs.save(path, x)
        assert str(caught.value).startswith(f"{path}: ")
    (tmp_path / "text.npz").write_bytes(b"no archive")
    with pytest.raises(bs.errors.InputError) as caught:
        bs.load(tmp_path / "text.npz")
    assert "pickle" not in str(caught.value)
