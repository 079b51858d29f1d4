"""NPZ files that are cut, bent or of something else give input errors with their name, documents likewise."""

import io
import json
import tracemalloc
import zipfile

import numpy as np
import pytest

import bladesmith as bs
from bladesmith import dynamics, kinematics
from bladesmith.codegen.algebra.loader import algebra_from_data
from bladesmith.common import data_files
from bladesmith.dynamics.results import trajectory_files
from bladesmith.errors import InputError, SpecError
from bladesmith.kinematics.task.joint_trajectory import Motion
from bladesmith.mechanics.units import Units

from ..support.checkout import CHECKOUT


def motion():
    n, k = 5, 2
    random = np.random.default_rng(3)
    return Motion(
        np.arange(n) / 4, ("q", "slide"), np.array([True, False]), random.normal(size=(n, k)),
        random.normal(size=(n, k)), random.normal(size=(n, 3)), random.normal(size=(n, 3)), random.normal(size=n),
        np.arange(n, dtype=np.uint8), Units("mm", time="min"),
    )  # fmt: skip


def trajectory():
    body = dynamics.RigidBody(1.0, [1.0, 2.0, 2.5], angular_velocity=(1, 2, 3))
    return dynamics.Simulation(body).run(0.1, times=np.linspace(0, 0.1, 4))


KINDS = {
    "multivector": (lambda path: bs.save(path, bs.cga3d.point(np.ones((3, 3)))), bs.load),
    "trajectory": (lambda path: trajectory().save(path), dynamics.load_trajectory),
    "motion": (lambda path: motion().save(path), kinematics.load_motion),
}


@pytest.fixture(params=KINDS, scope="module")
def stored(request, tmp_path_factory):
    save, load = KINDS[request.param]
    path = tmp_path_factory.mktemp("stored") / "x.npz"
    save(path)
    return path, load


def read(path, load):
    """True if it is read: a damaged file raises nothing but an error that names it."""
    try:
        load(path)
    except InputError as error:
        assert str(path) in str(error) and "\n" not in str(error)
        return False
    return True


def test_a_motion_comes_back_to_the_last_bit(tmp_path):
    motion().save(tmp_path / "m.npz")
    back, sent = kinematics.load_motion(tmp_path / "m.npz"), motion()
    assert back.inputs == sent.inputs and back.units == sent.units
    for name in ("turning", "time", "coordinates", "speeds", "position", "velocity", "condition", "status"):
        mine, theirs = getattr(back, name), getattr(sent, name)
        assert mine.dtype == theirs.dtype and mine.tobytes() == theirs.tobytes()


def test_files_of_others_are_refused(stored, tmp_path):
    path, load = stored
    assert read(path, load)
    for other in KINDS:
        if load is not KINDS[other][1]:
            KINDS[other][0](tmp_path / "other.npz")
            assert not read(tmp_path / "other.npz", load)
    np.savez(tmp_path / "plain.npz", time=np.arange(3))
    np.save(tmp_path / "plain.npy", np.arange(3))
    np.savez(tmp_path / "pickle.npz", bladesmith=np.array([{}], object))
    (tmp_path / "empty.npz").write_bytes(b"")
    for name in ("plain.npz", "plain.npy", "pickle.npz", "empty.npz", "missing.npz"):
        assert not read(tmp_path / name, load)
    for bad in (3, None, "a\0b", tmp_path):
        with pytest.raises(InputError):
            load(bad)


def test_cut_files_are_refused(stored, tmp_path):
    path, load = stored
    good = path.read_bytes()
    for length in np.linspace(0, len(good) - 1, 60).astype(int):
        (tmp_path / "cut.npz").write_bytes(good[:length])
        assert not read(tmp_path / "cut.npz", load)


@pytest.mark.parametrize("seed", range(8))
def test_bent_files_are_read_or_refused(stored, tmp_path, seed):
    path, load = stored
    random = np.random.default_rng(seed)
    for _ in range(40):
        bent = bytearray(path.read_bytes())
        for at in random.integers(len(bent), size=random.integers(1, 4)):
            bent[at] = random.integers(256)
        (tmp_path / "bent.npz").write_bytes(bent)
        read(tmp_path / "bent.npz", load)


def test_bent_headers_are_read_or_refused(stored, tmp_path):
    """Every item of a header in turn is missing, or something else."""
    path, load = stored
    with np.load(path) as archive:
        arrays = dict(archive)
    header = json.loads(arrays.pop("bladesmith").tobytes())
    assert data_files.npz_bytes(arrays, header, compressed=load is not bs.load) == path.read_bytes()
    for key in header:
        for value in (None, 3, -1.5, "x", [], [[]], {}, {"x": 1}, ["x"] * 9, True):
            bent = {k: v for k, v in header.items() if k != key} if value is None else {**header, key: value}
            (tmp_path / "bent.npz").write_bytes(data_files.npz_bytes(arrays, bent))
            read(tmp_path / "bent.npz", load)
    for array in arrays:
        for value in (np.zeros(0), np.zeros((2, 2), int), np.array("x"), np.full(1000, np.nan)):
            (tmp_path / "bent.npz").write_bytes(data_files.npz_bytes({**arrays, array: value}, header))
            read(tmp_path / "bent.npz", load)


def test_the_header_is_checked_before_arrays_are_unpacked(tmp_path, monkeypatch):
    """A file of another release may hold anything: nothing of it is read but the header."""
    header = {"format": "trajectory", "version": 2}
    (tmp_path / "x.npz").write_bytes(data_files.npz_bytes({"time": np.zeros(3)}, header))
    unpacked = []
    read = data_files._read_array
    monkeypatch.setattr(data_files, "_read_array", lambda archive, key: unpacked.append(key) or read(archive, key))
    with pytest.raises(InputError, match="its version is 2; this release reads 1. A newer release"):
        dynamics.load_trajectory(tmp_path / "x.npz")
    assert unpacked == ["bladesmith"]
    long = {"format": "trajectory", "version": 1, "title": "x" * data_files.MAX_HEADER}
    (tmp_path / "x.npz").write_bytes(data_files.npz_bytes({}, long))
    with pytest.raises(InputError, match="its header is too long"):
        dynamics.load_trajectory(tmp_path / "x.npz")
    assert unpacked == ["bladesmith"]


def described(shape, dtype="<f8"):
    """An array's description without the array."""
    text = io.BytesIO()
    np.lib.format.write_array_header_1_0(text, {"descr": dtype, "fortran_order": False, "shape": shape})
    return text.getvalue()


@pytest.mark.parametrize("items", [10**8, 10**15])
def test_memory_is_taken_only_for_what_a_file_can_hold(tmp_path, items):
    """Zeros that unpack to a thousand times their size, and descriptions of arrays that are not there."""
    bs.save(tmp_path / "x.npz", bs.cga3d.point(np.ones((3, 3))))
    with np.load(tmp_path / "x.npz") as archive:
        header = archive["bladesmith"]
    for size in (0, min(8 * items, 100_000_000)):
        path = tmp_path / f"{size}.npz"
        with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as file:
            file.writestr("bladesmith.npy", described(header.shape, "|u1") + header.tobytes())
            file.writestr("x.values.npy", described((items // 10, 10)) + bytes(size))
        tracemalloc.start()
        try:
            with pytest.raises(InputError, match="unpack to 100 MB" if size else "has not the size that it says"):
                bs.load(path)
            assert tracemalloc.get_traced_memory()[1] < 2_000_000
        finally:
            tracemalloc.stop()


@pytest.mark.parametrize("number", ["1e999999999", "9" * 5000, "1/0", "nan", "0x1", "1_0"])
def test_metrics_of_files_are_plain_fractions(tmp_path, number):
    """`Fraction` would compute a power of ten of any size."""
    bs.save(tmp_path / "x.npz", bs.algebra(2).scalar(1.0))
    with np.load(tmp_path / "x.npz") as archive:
        arrays = dict(archive)
    header = json.loads(arrays.pop("bladesmith").tobytes())
    header["items"]["x"]["metric"][0][0] = number
    (tmp_path / "x.npz").write_bytes(data_files.npz_bytes(arrays, header))
    with pytest.raises(InputError, match="an entry of the metric is"):
        bs.load(tmp_path / "x.npz")
    with pytest.raises(SpecError, match="an entry of the metric is"):
        algebra_from_data({"name": "a", "vectors": ["1"], "metric": [["1", "1", number]]})


def test_writers_take_the_path_first_and_warn_of_the_old_order(tmp_path, monkeypatch):
    monkeypatch.setattr("bladesmith.common.deprecation._warned", set())
    run = trajectory()
    dynamics.save(tmp_path / "new.npz", run)
    with pytest.warns(FutureWarning, match=r"save\(\) with its arguments in this order"):
        dynamics.save(run, tmp_path / "old.npz")
    assert (tmp_path / "new.npz").read_bytes() == (tmp_path / "old.npz").read_bytes()
    dynamics.animate(tmp_path / "new.html", run)
    with pytest.warns(FutureWarning, match=r"animate\(\) with its arguments in this order"):
        dynamics.animate(run, tmp_path / "old.html")
    assert (tmp_path / "new.html").read_bytes() == (tmp_path / "old.html").read_bytes()


DOCUMENTS = [
    ("dynamics", dynamics.load_simulation),
    ("kinematics", kinematics.load_mechanism),
    ("scenes", bs.tracer.Scene.load),
    ("registration", bs.reform.Model.load),
]


def documents():
    for folder, load in DOCUMENTS:
        found = sorted(x for x in (CHECKOUT / "examples" / folder).iterdir() if x.suffix in (".toml", ".json"))
        yield from ((path, load) for path in found[:2])


@pytest.mark.parametrize(("path", "load"), [pytest.param(p, x, id=p.name) for p, x in documents()])
def test_cut_and_bent_documents_are_read_or_refused(path, load, tmp_path):
    random, good = np.random.default_rng(1), path.read_bytes()[:6000]
    place = tmp_path / path.name
    for length in random.integers(len(good), size=15):
        place.write_bytes(good[:length])
        read(place, load)
    for _ in range(25):
        bent = bytearray(good)
        for at in random.integers(len(bent), size=2):
            bent[at] = random.integers(256)
        place.write_bytes(bent)
        read(place, load)


def test_a_table_has_units_and_all_digits():
    text = data_files.csv_text([("t", "s"), ("status", "")], [[0.1 + 0.2, "OK"], [float("nan"), "a,b"]])
    assert text == 't [s],status\n0.30000000000000004,OK\nnan,"a,b"\n'
    assert trajectory_files.FORMATS == data_files.FORMATS
