"""Trajectories in files: what is written comes back, what is none is refused, and nothing is half written."""

from __future__ import annotations

import csv
import json
import re
import zipfile

import numpy as np
import pytest

import bladesmith as bs
from bladesmith import dynamics
from bladesmith.dynamics.plotting import curves
from bladesmith.dynamics.results.trajectory_data import OF_BODIES
from bladesmith.dynamics.results.trajectory_files import archive
from bladesmith.errors import InputError, SimulationError

from ...support.checkout import CHECKOUT


def same(a, b):
    for key in ("time", "position", "orientation", "velocity", "angular_velocity", "energy", "violation"):
        assert np.asarray(getattr(a, key)).tobytes() == np.asarray(getattr(b, key)).tobytes(), key
    for key in ("motor", "momentum", "reaction"):
        assert getattr(a, key).isclose(getattr(b, key)).all(), key
    for key in ("ending", "status", "integrator", "message", "steps"):
        assert getattr(a, key) == getattr(b, key), key


def test_a_trajectory_comes_back_to_the_last_bit(swing, tmp_path):
    setup, found = swing
    found.save(tmp_path / "a.npz", setup.sketch)
    again = dynamics.load_trajectory(tmp_path / "a.npz")
    same(again, found)
    assert again.motor.values.tobytes() == found.motor.as_kind("motor").values.tobytes()
    assert again.sketch.traces[0].label == "tip" and again.sketch.units == setup.sketch.units
    (own,), (kept,) = setup.sketch.shapes.values(), again.sketch.shapes.values()
    for part in ("vertices", "faces", "gyration", "edges"):
        assert np.array_equal(getattr(own, part), getattr(kept, part))
    assert all(x.isclose(y) for x, y in zip(setup.sketch.objects, again.sketch.objects, strict=True))
    again.save(tmp_path / "b.npz")
    same(dynamics.load_trajectory(tmp_path / "b.npz"), found)
    with np.load(tmp_path / "a.npz", allow_pickle=False) as arrays:
        tip = found.orientation @ [0, 0, 0.5] + found.position
        assert np.allclose(arrays["traces"][0], tip, atol=1e-15)
        assert np.array_equal(arrays["reaction"], found.reaction.values)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a.npz", "b.npz"]


def test_a_table_holds_the_same_numbers(swing, tmp_path):
    setup, found = swing
    found.save(tmp_path / "a.csv", setup.sketch)
    with open(tmp_path / "a.csv", newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    column = lambda *names: np.array([[float(row[name]) for name in names] for row in rows])  # noqa: E731
    assert np.array_equal(column("t [s]")[:, 0], found.time)
    assert np.array_equal(column("x [m]", "y [m]", "z [m]"), found.position)
    assert np.array_equal(column(*(f"r{i}{j}" for i in "123" for j in "123")), found.orientation.reshape(-1, 9))
    assert np.array_equal(column("w1 [rad/s]", "w2 [rad/s]", "w3 [rad/s]"), found.angular_velocity)
    assert np.array_equal(column("energy [J]")[:, 0], found.energy)
    reaction = dynamics.wrench_parts(found.reaction)
    assert np.array_equal(column("fx [N]", "fy [N]", "fz [N]"), reaction.force)
    assert np.array_equal(column("mx [N m]", "my [N m]", "mz [N m]"), reaction.moment)
    assert np.allclose(column("tip x [m]", "tip y [m]", "tip z [m]"), found.orientation @ [0, 0, 0.5] + found.position)


@pytest.mark.compiles
def test_several_bodies_and_batches_come_back(tmp_path):
    setup = dynamics.load_simulation(CHECKOUT / "examples" / "dynamics" / "double_pendulum.toml")
    found = setup.run(times=[0.1, 0.2])
    found.save(tmp_path / "two.npz", setup.sketch)
    again = dynamics.load_trajectory(tmp_path / "two.npz")
    assert list(again.bodies) == ["upper", "lower"]
    for name in again.bodies:
        same(again.bodies[name], found.bodies[name])
        same(again[name], found[name])
    refusals = []
    for each in (found, again):
        assert each.energy.shape == each.time.shape
        for key in (*OF_BODIES, "path"):
            with pytest.raises(InputError, match="is of 2 bodies: upper, lower. Ask one of them, as trajectory") as one:
                each.path((0, 0, 1)) if key == "path" and each is again else getattr(each, key.replace("path", "motor"))
            refusals.append(str(one.value))
        with pytest.raises(InputError, match="no body 'uper'; there are: upper, lower. .did you mean 'upper'"):
            each["uper"]
    assert len(set(refusals)) == 1
    found.save(tmp_path / "two.csv")
    rows = (tmp_path / "two.csv").read_text().splitlines()
    assert (
        rows[0].startswith("body,t [s],") and [row.split(",")[0] for row in rows[1:]] == ["upper"] * 3 + ["lower"] * 3
    )

    body = dynamics.RigidBody([1.0, 2.0, 3.0], (1, 2, 2.5), velocity=(1, 0, 0), algebra=bs.pga3d)
    many = dynamics.Simulation(body).run(0.1, times=[0.05, 0.1])
    dynamics.save(tmp_path / "many.npz", many)
    again = dynamics.load_trajectory(tmp_path / "many.npz")
    assert again.batch == (3,) and np.array_equal(again.position, many.position) and list(again.ending) == ["ok"] * 3
    assert again.motor.algebra is bs.pga3d
    assert np.array_equal(again[1].position, many.position[1])
    dynamics.save(tmp_path / "many.csv", many)
    assert len((tmp_path / "many.csv").read_text().splitlines()) == 10
    for refused in (curves.plot, dynamics.picture):
        with pytest.raises(InputError, match="these are 3 simulations; a picture shows one"):
            refused(many)
    with pytest.raises(InputError, match="none has the number 3"):
        again[3]


def test_files_that_are_no_trajectories_are_refused(swing, tmp_path):
    setup, found = swing
    good = archive(dynamics.as_record(found, setup.sketch))
    path = tmp_path / "x.npz"

    def with_arrays(**arrays):
        path.write_bytes(good)
        with np.load(path) as stored:
            kept = {name: stored[name] for name in stored.files}
        header = json.loads(kept["bladesmith"].tobytes())
        for key, value in arrays.pop("header", {}).items():
            header[key] = value
        kept["bladesmith"] = np.frombuffer(json.dumps(header).encode(), np.uint8)
        np.savez(path, **{k: v for k, v in {**kept, **arrays}.items() if v is not None})

    cases = {
        "energy is an array": lambda: with_arrays(energy=np.zeros(3)),
        "it has no motor": lambda: with_arrays(motor=None),
        "its version is 9; this release reads 1": lambda: with_arrays(header={"version": 9}),
        "its header is damaged": lambda: with_arrays(header={"algebra": "os.system"}),
        "on other blades": lambda: with_arrays(header={"blades": {"motor": ["1"], "twist": []}}),
        "name vertices that are not there": lambda: with_arrays(**{"shape.0.faces": np.array([[0, 1, 999]])}),
        "is not a color": lambda: with_arrays(header={"colors": {"body": "url(x)"}}),
        "is not a file that": lambda: path.write_bytes(good[: len(good) // 2]),
        "is not a file that trajectory.save": lambda: np.savez(path, time=np.array([object()], dtype=object)),
    }
    for says, make in cases.items():
        make()
        with pytest.raises(InputError) as error:
            dynamics.load_trajectory(path)
        assert says in str(error.value) and str(path) in str(error.value)
    with pytest.raises(InputError, match="cannot be read: No such file"):
        dynamics.load_trajectory(tmp_path / "none.npz")
    assert zipfile.is_zipfile(path)


def test_what_cannot_be_written_leaves_what_was_there(swing, tmp_path, monkeypatch):
    setup, found = swing
    path = tmp_path / "a.npz"
    found.save(path)
    before = path.read_bytes()

    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("os.replace", full)
    with pytest.raises(InputError, match=r"a.npz: cannot be written: No space left on device"):
        found.save(path)
    monkeypatch.undo()
    assert path.read_bytes() == before and [p.name for p in tmp_path.iterdir()] == ["a.npz"]
    for name, says in (("a.txt", "trajectories are written as .npz or .csv"), ("no/a.npz", "No such file")):
        with pytest.raises(InputError, match=re.escape(says)):
            found.save(tmp_path / name)
    with pytest.raises(InputError, match="a trajectory is needed"):
        dynamics.save(path, [])
    with pytest.raises(InputError, match="the sketch names the body 'arm'; there are: body"):
        found.save(path, dynamics.Sketch(traces=[dynamics.Trace((0, 0, 0), body="arm")]))


@pytest.mark.compiles
def test_the_trajectory_so_far_of_a_failure_is_one(tmp_path):
    body = dynamics.RigidBody(1.0, (1, 1, 1))

    def wrench(time):
        return dynamics.wrench((np.nan if time > 0.5 else 1.0, 0, 0), 0)

    with pytest.raises(SimulationError) as error:
        dynamics.Simulation(body, [dynamics.WorldWrench(wrench)]).run(1.0, step=0.01, strict=True)
    record = dynamics.as_record(error.value.trajectory)
    assert 10 < len(record) < 60 and np.isfinite(record.position).all()
    record.save(tmp_path / "so_far.npz")
    same(dynamics.load_trajectory(tmp_path / "so_far.npz"), record)
