"""Every reader of files on files that are damaged: an error of the package within two seconds, or a result.

`BLADESMITH_FUZZ=5000 python -m pytest tests/fuzz` tries so many of each.
"""

from __future__ import annotations

import io
import json
import os
import random
import re
import shutil
import signal
import tempfile
import time
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import bladesmith as bs
from bladesmith import dynamics, kinematics, poses, reform, tracer
from bladesmith.codegen.algebra.loader import algebra_from_data
from bladesmith.codegen.algebra.schema import load_spec, stock_spec_path
from bladesmith.dispatch.stock_kernels import bundled_folder
from bladesmith.errors import BladesmithError
from bladesmith.interchange import clifford_json, meshes, polylines
from bladesmith.kinematics.task.joint_trajectory import Motion
from bladesmith.mechanics.units import Units

from ..kinematics.mjcf.models import ARM, LOOP
from ..support.checkout import CHECKOUT

COUNT = int(os.environ.get("BLADESMITH_FUZZ", "25"))
#: Seconds that a reader may take; a busy machine is given more before it is stopped.
LIMIT, PATIENCE = 2.0, 20.0
#: Characters of a message.
LONGEST = 4000
EXAMPLES = CHECKOUT / "examples"
#: What is put in: bytes that are Latin-1.
WORDS = [
    word.encode("latin-1")
    for word in (
        "nan", "-inf", "1e308", "1e999999999", "-0", "9" * 400, "-1", "4294967296", "9223372036854775808", "null",
        "true", "[]", "{}", "[" * 500, chr(34), chr(92), chr(0), "\xff\xfe", "\xc3\xa9", "%s", "../..", "/dev/zero",
        "&amp;", "]]>", "a." * 99, "<!DOCTYPE a>", "1_0", "0x1p9", "''", "\r\n", "1/0", "x * x", "",
    )
]  # fmt: skip
NUMBER = re.compile(rb"[-+]?\d+\.?\d*(?:[eE][-+]?\d+)?")

URDF = """<robot name="r"><link name="a"><inertial><mass value="1"/><origin xyz="0 0 1" rpy="0 0 0.1"/>
<inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link><link name="b"/><link name="c"/>
<joint name="j" type="revolute"><parent link="a"/><child link="b"/><origin xyz="0 0 1" rpy="0.1 0 0"/>
<axis xyz="0 1 0"/><limit lower="-1" upper="1" effort="2" velocity="3"/><dynamics damping="0.1"/></joint>
<joint name="k" type="prismatic"><parent link="b"/><child link="c"/><mimic joint="j" multiplier="2" offset="0.1"/>
<axis xyz="1 0 0"/><limit lower="0" upper="1" effort="2" velocity="3"/></joint></robot>"""
SDF = """<sdf version="1.9"><model name="m"><pose>0 0 1 0 0 0</pose>
<link name="a"><inertial><mass>1</mass><inertia><ixx>1</ixx><iyy>1</iyy><izz>1</izz></inertia></inertial></link>
<link name="b"><pose relative_to="a" degrees="true">1 0 0 10 0 0</pose></link>
<joint name="j" type="revolute"><parent>a</parent><child>b</child><axis><xyz expressed_in="a">0 0 1</xyz>
<limit><lower>-1</lower><upper>1</upper></limit></axis></joint>
<frame name="f" attached_to="b"><pose>0 0 1 0 0 0</pose></frame></model></sdf>"""
OBJ = "# a box\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n"
OBJ += "vn 0 0 1\nvt 0.1 0.2\nf 1 2 3\nf 1//1 3//1 4//1\nl 1 2 3\no name\ns off\n"
PLY = """ply
format ascii 1.0
element vertex 4
property float x
property float y
property float z
element face 2
property list uchar int vertex_indices
element edge 2
property int vertex1
property int vertex2
end_header
0 0 0
1 0 0
0 1 0
0 0 1
3 0 1 2
3 0 2 3
0 1
2 3
"""
STL = (
    "solid s\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid s\n"
)


def motion() -> Any:
    n = 3
    return Motion(
        np.arange(n) / 4, ("q", "s"), np.array([True, False]), np.ones((n, 2)), np.ones((n, 2)), np.ones((n, 3)),
        np.ones((n, 3)), np.ones(n), np.zeros(n, np.uint8), Units("mm", time="min"),
    )  # fmt: skip


def trajectory(path: Path) -> None:
    body = dynamics.RigidBody(1.0, [1.0, 2.0, 2.5], angular_velocity=(1, 2, 3))
    dynamics.Simulation(body).run(0.1, times=np.linspace(0, 0.1, 4)).save(path)


def registration(path: Path) -> None:
    model = reform.Model(lines=bs.cga3d.line(np.eye(3), np.eye(3)[::-1] + 0.1))
    reform.save_registration(path, reform.register(model, model))


def binary_mesh(path: Path) -> None:
    import trimesh

    mesh = trimesh.creation.box()
    mesh.vertex_normals  # noqa: B018  exported then
    mesh.export(path)


def generated_algebra(path: Path) -> bs.Algebra:
    """The algebra of a generated folder of its own, since those of folders are kept."""
    folder = Path(tempfile.mkdtemp(dir=path.parent))
    shutil.copy(path, folder)
    return bs.load_algebra(folder)


Sample = Callable[[Path], Any] | str | Path
POINTS = bs.cga3d.point(np.arange(6.0).reshape(2, 3))
READERS: dict[str, tuple[str, Sample, Callable[[Path], Any]]] = {
    "multivectors": ("x.npz", lambda path: bs.save(path, a=POINTS, b=bs.algebra(2, 1).scalar(2.0)), bs.load),
    "trajectory": ("x.npz", trajectory, dynamics.load_trajectory),
    "motion": ("x.npz", lambda path: motion().save(path), kinematics.load_motion),
    "simulation": ("x.toml", EXAMPLES / "dynamics" / "double_pendulum.toml", dynamics.load_simulation),
    "mechanism": ("x.toml", EXAMPLES / "kinematics" / "four_bar.toml", kinematics.load_mechanism),
    "delta": ("x.toml", EXAMPLES / "kinematics" / "delta.toml", kinematics.load_mechanism),
    "scene": ("x.toml", EXAMPLES / "scenes" / "demo.toml", tracer.Scene.load),
    "spec": ("x.toml", stock_spec_path("pga3d"), lambda path: algebra_from_data(load_spec(path))),
    "algebra": ("manifest.json", bundled_folder("pga3d") / "manifest.json", generated_algebra),
    "model": ("x.json", EXAMPLES / "registration" / "table_query.json", reform.Model.load),
    "registration": ("x.json", registration, reform.load_registration),
    "multivectors of clifford": ("x.json", lambda path: clifford_json.save_json(path, POINTS), clifford_json.load_json),
    "URDF": ("x.urdf", URDF, kinematics.load_urdf),
    "MJCF": ("x.xml", ARM, kinematics.load_mjcf),
    "MJCF with a loop": ("x.xml", LOOP, kinematics.load_mjcf),
    "SDF": ("x.sdf", SDF, kinematics.load_sdf),
    "TUM": ("x.tum", "# t\n0.0 1 2 3 0 0 0 1\n1.5 1 2 3 0.6 0 0 0.8\n", poses.load_tum),
    "OBJ": ("x.obj", OBJ, meshes.load_mesh),
    "PLY": ("x.ply", PLY, meshes.load_mesh),
    "STL": ("x.stl", STL, meshes.load_mesh),
    "binary PLY": ("x.ply", binary_mesh, meshes.load_with_normals),
    "binary STL": ("x.stl", binary_mesh, meshes.load_mesh),
    "GLB": ("x.glb", binary_mesh, meshes.load_with_normals),
    "segments of OBJ": ("x.obj", OBJ, polylines.load_segments),
    "segments of PLY": ("x.ply", PLY, polylines.load_segments),
}


def mutate(good: bytes, rng: random.Random) -> bytes:
    """A file with one to four damages."""
    data = bytearray(good)
    for _ in range(rng.choice([1, 1, 1, 2, 4])):
        at = rng.randrange(len(data) + 1)
        end = min(len(data), at + rng.choice([1, 4, 30, 300]))
        numbers = list(NUMBER.finditer(data))
        match rng.randrange(7):
            case 0 if at < len(data):
                data[at] ^= 1 << rng.randrange(8)
            case 1:
                del data[at : end if rng.random() < 0.7 else None]
            case 2:
                data[at:at] = data[at:end] * rng.choice([1, 2, 200])
            case 3:
                other = rng.randrange(len(data) + 1)
                data[at:end] = data[other : other + end - at]
            case 4:
                data[at:at] = rng.choice(WORDS)
            case 5 | 6 if numbers:
                number = rng.choice(numbers)
                data[number.start() : number.end()] = rng.choice(WORDS)
    return bytes(data)


def damaged(good: bytes, name: str, rng: random.Random) -> bytes:
    """A damaged file; an NPZ file also in its header or an array, below what its checksums see."""
    if not name.endswith(".npz") or rng.random() < 0.3:
        return mutate(good, rng)
    with np.load(io.BytesIO(good)) as archive:
        arrays = dict(archive)
    key = rng.choice(["bladesmith", "bladesmith", *arrays])
    arrays[key] = np.frombuffer(mutate(arrays[key].tobytes(), rng), np.uint8)
    if key != "bladesmith":
        dtype = rng.choice(["<f8", ">f8", "<i8", "<f4", "|S8", "<c16", "|u1"])
        arrays[key] = arrays[key][: len(arrays[key]) // 16 * 16].view(dtype)
    out = io.BytesIO()
    np.savez(out, **arrays)
    return out.getvalue()


@contextmanager
def stopped() -> Iterator[None]:
    """A reader that goes on for long is stopped, where there are alarms."""

    def stop(*_: object) -> None:
        raise AssertionError("the reader does not end")

    if not hasattr(signal, "setitimer"):
        yield
        return
    before = signal.signal(signal.SIGALRM, stop)
    signal.setitimer(signal.ITIMER_REAL, PATIENCE)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)


@pytest.mark.slow
@pytest.mark.parametrize("reader", READERS)
def test_damaged_files_are_read_or_refused(reader: str, tmp_path: Path) -> None:
    name, sample, read = READERS[reader]
    path = tmp_path / name
    if callable(sample):
        sample(path)
    else:
        path.write_bytes(sample.read_bytes() if isinstance(sample, Path) else sample.encode())
    read(path)
    good, refused, faults = path.read_bytes(), 0, []
    for seed in range(COUNT):
        bad = damaged(good, name, random.Random(f"{reader} {seed}"))
        path.write_bytes(bad)
        start, fault = time.process_time(), ""
        try:
            with stopped(), warnings.catch_warnings():
                warnings.simplefilter("ignore")
                read(path)
        except BladesmithError as error:
            refused += 1
            if "\n" in str(error) or len(str(error)) > LONGEST:
                fault = f"says {str(error)[:LONGEST]!r}"
        except (Exception, AssertionError) as error:
            fault = f"raises {type(error).__name__}: {str(error)[:200]}"
        if (took := time.process_time() - start) > LIMIT:
            fault += f" takes {took:.1f} s"
        if fault:
            kept = tmp_path / f"bad-{seed}-{name}"
            kept.write_bytes(bad)
            faults.append(f"{kept} {fault}")
    assert not faults, "\n".join(faults[:20])
    assert refused > COUNT / 20, "the damages do not damage"


def test_damages_are_the_same_each_time() -> None:
    first, again = ([mutate(b"[1.5, 2]" * 9, random.Random(i)) for i in range(20)] for _ in range(2))
    assert first == again and len(set(first)) > 15 and json.loads("[1.5, 2]") == [1.5, 2]
