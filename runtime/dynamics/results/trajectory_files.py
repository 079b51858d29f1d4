"""Files of trajectories (docs/motion/simulations.md): NPZ and CSV, whole or not at all; reading executes nothing."""

from __future__ import annotations

import os
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from ...common.data_files import FORMATS, csv_text, npz_bytes, producer_versions, read_npz
from ...common.deprecation import reordered
from ...common.files import output_path, write_file
from ...core.registry import stock_algebra
from ...mechanics.screws import wrench_parts
from ...mechanics.shapes import Shape
from ...mechanics.units import Units
from .figure_spec import Sketch, Trace
from .trajectory_data import OF_BODIES, TrajectoryData, TrajectorySource, data_of, starts_with_trajectory

Array = NDArray[Any]
D = TypeVar("D", bound=TrajectoryData)
VERSION = 1
#: Arrays of all bodies together.
OF_ALL = ("energy", "violation")


# -- writing ---------------------------------------------------------------------------------------------------


@reordered("trajectory", "path", "sketch", when=starts_with_trajectory)
def save(path: str | os.PathLike[str], trajectory: TrajectorySource, sketch: Sketch | None = None) -> None:
    """Write a trajectory, whole or not at all.

    Parameters
    ----------
    path
        ``.npz``: arrays, which `load_trajectory` reads; ``.csv``: a table with a header and units.
    trajectory : Trajectory or Record
    sketch : Sketch, optional
        Shapes, traces and units to store with it.

    Raises
    ------
    InputError
        If the name ends in neither, or the file cannot be written.
    """
    file = checked_name(path)
    record = data_of(trajectory, sketch)
    write_file(file, table_text(record) if file.suffix.lower() == ".csv" else archive(record))


def checked_name(path: Any) -> Path:
    """Path of a trajectory to write.

    Raises
    ------
    InputError
        If it is not a path, or its suffix is not known.
    """
    return output_path(path, "a trajectory", "trajectories", FORMATS)


def archive(record: TrajectoryData) -> bytes:
    """Bytes of an NPZ file."""
    names, sketch = list(record.rows), record.sketch
    single = len(names) == 1
    stored: dict[str, Array] = {"time": record.time, **{key: getattr(record, key) for key in OF_ALL}}
    for key in OF_BODIES:
        arrays = [record.rows[name][key] for name in names]
        stored[key] = arrays[0] if single else np.stack(arrays)
    if sketch.traces and not record.batch:
        stored["traces"] = np.stack([record.path_of(trace) for trace in sketch.traces])
    for i, shape in enumerate(sketch.shapes.values()):
        for part in ("vertices", "faces", "gyration", "edges"):
            stored[f"shape.{i}.{part}"] = getattr(shape, part)
    return npz_bytes(stored, _header(record))


def _header(record: TrajectoryData) -> dict[str, Any]:
    home, sketch = stock_algebra(record.algebra), record.sketch
    blades = {kind: [home.blade_name(b) for b in home.kind(kind).blades] for kind in ("motor", "twist")}
    return {
        "format": "trajectory", "version": VERSION, "algebra": record.algebra, "blades": blades,
        "names": list(record.rows), "integrator": record.integrator, "message": record.message,
        "status": np.asarray(record.ending).tolist(), "steps": np.asarray(record.steps).tolist(),
        "made_by": producer_versions(),
        "units": {"length": sketch.units.length, "mass": sketch.units.mass, "time": sketch.units.time},
        "title": sketch.title, "view": list(sketch.view), "shown": sketch.shown, "colors": dict(sketch.colors),
        "traces": [
            {"point": np.asarray(t.point).tolist(), "label": t.label, "color": t.color, "body": t.body}
            for t in sketch.traces
        ],
        "shapes": [{"body": name, "volume": shape.volume} for name, shape in sketch.shapes.items()],
        "objects": [
            {"blades": [str(b) for b in x.blades], "coefficients": x.values.tolist()} for x in sketch.objects
        ],
    }  # fmt: skip


def table_text(record: TrajectoryData) -> str:
    """Text of a CSV file: a row for each state of each body and simulation."""
    many, batch = len(record.rows) > 1, bool(record.batch)
    lead = [("simulation", "")] * batch + [("body", "")] * many
    parts = [(str(i), record[i]) for i in range(record.batch[0])] if batch else [("", record)]
    rows = (
        [*[number] * batch, *[name] * many, *row]
        for number, part in parts
        for name, data in part.bodies.items()
        for row in _rows(data).tolist()
    )
    return csv_text([*lead, *_columns(record)], rows)


def _columns(record: TrajectoryData) -> Iterator[tuple[str, str]]:
    units = record.sketch.units
    yield "t", units.time
    yield from ((c, units.length) for c in "xyz")
    yield from ((f"r{i}{j}", "") for i in "123" for j in "123")
    yield from ((f"v{c}", units.velocity) for c in "xyz")
    yield from ((f"w{i}", units.angular_velocity) for i in "123")
    yield from ((f"p{c}", units.momentum) for c in "xyz")
    yield from ((f"l{c}", units.angular_momentum) for c in "xyz")
    yield "energy", units.energy
    yield from ((f"f{c}", units.force) for c in "xyz")
    yield from ((f"m{c}", units.moment) for c in "xyz")
    yield "violation", ""
    for i, trace in enumerate(record.sketch.traces):
        yield from ((f"{trace.label or f'trace {i + 1}'} {c}", units.length) for c in "xyz")


def _rows(data: TrajectoryData) -> Array:
    momentum, reaction = wrench_parts(data.momentum), wrench_parts(data.reaction)
    traces = [data.path_of(trace) for trace in data.sketch.traces]
    columns = [
        data.time[:, None], data.position, data.orientation.reshape(-1, 9), data.velocity, data.angular_velocity,
        momentum.force, momentum.moment, data.energy[:, None], reaction.force, reaction.moment,
        data.violation[:, None], *traces,
    ]  # fmt: skip
    return np.concatenate(columns, 1)


# -- reading ---------------------------------------------------------------------------------------------------


def read_trajectory(path: str | os.PathLike[str], record_type: type[D]) -> D:
    """Read a trajectory that was saved as NPZ: the same arrays to the last bit.

    Raises
    ------
    InputError
        If the file cannot be read, is damaged, or holds something else.
    """
    expected = {"format": "trajectory", "version": VERSION}
    return read_npz(path, "a trajectory", "trajectory.save", expected, partial(_data_of_arrays, record_type))


def _data_of_arrays(record_type: type[D], header: dict[str, Any], stored: dict[str, Array]) -> D:
    names = [str(x) for x in header["names"]]
    if header["algebra"] not in ("cga3d", "pga3d") or not names or len(set(names)) < len(names):
        raise ValueError("its header is damaged")
    home = stock_algebra(header["algebra"])
    for kind in ("motor", "twist"):
        if header["blades"][kind] != [home.blade_name(b) for b in home.kind(kind).blades]:
            raise ValueError(f"the coefficients of a {kind} are on other blades")
    time = _numbers(stored, "time", (len(stored["time"]),))
    lead = stored["energy"].shape[:-1]
    if len(lead) > 1:
        raise ValueError("energy has another shape")
    common = {key: _numbers(stored, key, (*lead, len(time))) for key in OF_ALL}
    rows: dict[str, dict[str, Array]] = {name: {} for name in names}
    for key, tail in OF_BODIES.items():
        shape = (*lead, len(time), *tail)
        values = _numbers(stored, key, shape if len(names) == 1 else (len(names), *shape))
        for i, name in enumerate(names):
            rows[name][key] = values if len(names) == 1 else values[i]
    ending, steps = header["status"], header["steps"]
    return record_type(
        str(header["algebra"]), time, rows, common["energy"], common["violation"], str(header["integrator"]),
        np.array(ending) if isinstance(ending, list) else str(ending), str(header["message"]),
        np.array(steps) if isinstance(steps, list) else int(steps), _sketch(header, stored, names),
    )  # fmt: skip


def _numbers(stored: dict[str, Array], key: str, shape: tuple[int, ...]) -> Array:
    if key not in stored:
        raise ValueError(f"it has no {key}")
    values = stored[key]
    if values.dtype != np.float64 or values.shape != shape:
        raise ValueError(f"{key} is an array of {values.dtype} of shape {values.shape}, where {shape} is needed")
    return values


def _sketch(header: dict[str, Any], stored: dict[str, Array], names: list[str]) -> Sketch:
    home = stock_algebra(header["algebra"])
    shapes = {str(x["body"]): _shape(stored, i, float(x["volume"])) for i, x in enumerate(header["shapes"])}
    traces = [Trace(x["point"], str(x["label"]), x["color"], x["body"]) for x in header["traces"]]
    if any(t.body is not None and t.body not in names for t in traces):
        raise ValueError("a trace belongs to no body")
    objects = [
        home.multivector(np.array(x["coefficients"], np.float64), blades=[str(b) for b in x["blades"]])
        for x in header["objects"]
    ]
    units = Units(**{key: str(header["units"][key]) for key in ("length", "mass", "time")})
    elevation, azimuth = (float(x) for x in header["view"])
    shown = None if header["shown"] is None else tuple(float(x) for x in header["shown"])
    return Sketch(shapes, traces, objects, header["colors"], units, str(header["title"]), (elevation, azimuth), shown)


def _shape(stored: dict[str, Array], i: int, volume: float) -> Shape:
    parts = [stored[f"shape.{i}.{part}"] for part in ("vertices", "faces", "gyration", "edges")]
    vertices, faces, gyration, edges = parts
    for name, array, width, kind in (
        ("vertices", vertices, 3, "f"),
        ("faces", faces, 3, "i"),
        ("edges", edges, 2, "i"),
    ):
        if array.dtype.kind != kind or array.ndim != 2 or array.shape[1] != width:
            raise ValueError(f"the {name} of a shape have another shape")
        if kind == "i" and array.size and not 0 <= array.min() <= array.max() < len(vertices):
            raise ValueError(f"the {name} of a shape name vertices that are not there")
    return Shape(vertices, faces, volume, gyration, edges)


__all__ = ["archive", "checked_name", "read_trajectory", "save", "table_text"]
