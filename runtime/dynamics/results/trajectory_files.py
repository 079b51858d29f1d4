"""Files of trajectories: NPZ and CSV, whole or not at all, read without executing anything (docs/simulations.md)."""

from __future__ import annotations

import csv
import io
import json
import os
import platform
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..codegen.errors import BladesmithError, InputError
from ..codegen.version import __version__
from ..files import failures_named, write_atomically
from ..loading import stock_algebra
from .given import output_file, shown
from .record import OF_BODIES, Record, recorded
from .screws import wrench_parts
from .shapes import Shape
from .sketch import Sketch, Trace, Units

if TYPE_CHECKING:
    from .trajectory import Trajectory

Array = NDArray[Any]
VERSION = 1
#: Name of the array that holds the header, and how long one may be.
HEADER, LONGEST_HEADER = "bladesmith", 1_000_000
#: Arrays of all bodies together.
OF_ALL = ("energy", "violation")
#: Formats, by the end of the name.
FORMATS = (".npz", ".csv")
_WRONG = "is no file that trajectory.save() wrote"


# -- writing ---------------------------------------------------------------------------------------------------


def save(trajectory: Trajectory | Record, path: str | os.PathLike[str], sketch: Sketch | None = None) -> None:
    """Write a trajectory, whole or not at all.

    Parameters
    ----------
    trajectory : Trajectory or Record
    path
        ``.npz``: arrays, which `load_trajectory` reads; ``.csv``: a table with a header and units.
    sketch : Sketch, optional
        Shapes, traces and units to store with it.

    Raises
    ------
    InputError
        If the name ends in neither, or the file cannot be written.
    """
    file = checked_name(path)
    record = recorded(trajectory, sketch)
    data: str | bytes = table_text(record) if file.suffix.lower() == ".csv" else archive(record)
    with failures_named(file):
        write_atomically(file, data)


def checked_name(path: Any) -> Path:
    """A path that a trajectory can be written to.

    Raises
    ------
    InputError
        If it is none, or ends in no known format.
    """
    return output_file(path, "a trajectory", "trajectories", FORMATS)


def archive(record: Record) -> bytes:
    """The bytes of an NPZ file."""
    names, sketch = list(record.rows), record.sketch
    single = len(names) == 1
    stored: dict[str, Array] = {"time": record.time, **{key: getattr(record, key) for key in OF_ALL}}
    for key in OF_BODIES:
        arrays = [record.rows[name][key] for name in names]
        stored[key] = arrays[0] if single else np.stack(arrays)
    if sketch.traces and not record.batch:
        stored["traces"] = np.stack([_trace_path(record, trace) for trace in sketch.traces])
    for i, shape in enumerate(sketch.shapes.values()):
        for part in ("vertices", "faces", "gyration", "edges"):
            stored[f"shape.{i}.{part}"] = getattr(shape, part)
    text = json.dumps(_header(record))
    stored[HEADER] = np.frombuffer(text.encode(), np.uint8)
    buffer = io.BytesIO()
    np.savez_compressed(buffer, **stored)  # type: ignore[arg-type]  # numpy's stubs take ** for allow_pickle
    return buffer.getvalue()


def _header(record: Record) -> dict[str, Any]:
    home, sketch = stock_algebra(record.algebra), record.sketch
    blades = {kind: [home.blade_name(b) for b in home.kind(kind).blades] for kind in ("motor", "twist")}
    return {
        "format": "trajectory", "version": VERSION, "algebra": record.algebra, "blades": blades,
        "names": list(record.rows), "integrator": record.integrator, "message": record.message,
        "status": np.asarray(record.status).tolist(), "steps": np.asarray(record.steps).tolist(),
        "made_by": {"bladesmith": __version__, "numpy": np.__version__, "python": platform.python_version()},
        "units": {"length": sketch.units.length, "mass": sketch.units.mass, "time": sketch.units.time},
        "title": sketch.title, "view": list(sketch.view), "shown": sketch.shown, "colors": dict(sketch.colors),
        "traces": [
            {"point": t.point.tolist(), "label": t.label, "color": t.color, "body": t.body} for t in sketch.traces
        ],
        "shapes": [{"body": name, "volume": shape.volume} for name, shape in sketch.shapes.items()],
        "objects": [
            {"blades": [str(b) for b in x.blades], "coefficients": x.values.tolist()} for x in sketch.objects
        ],
    }  # fmt: skip


def _trace_path(record: Record, trace: Trace) -> Array:
    return record.bodies[trace.body or record.name].path(trace.point)


def table_text(record: Record) -> str:
    """The text of a CSV file: a row for each state; of several bodies or simulations, one for each of them."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    many, batch = len(record.rows) > 1, bool(record.batch)
    lead = [*(["simulation"] if batch else []), *(["body"] if many else [])]
    writer.writerow([*lead, *(f"{name} [{unit}]" if unit else name for name, unit in _columns(record))])
    parts = [(str(i), record[i]) for i in range(record.batch[0])] if batch else [("", record)]
    for number, part in parts:
        for name, own in part.bodies.items():
            before = [*([number] if batch else []), *([name] if many else [])]
            writer.writerows([*before, *map(repr, row)] for row in _rows(own).tolist())
    return text.getvalue()


def _columns(record: Record) -> Iterator[tuple[str, str]]:
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


def _rows(own: Record) -> Array:
    momentum, reaction = wrench_parts(own.momentum), wrench_parts(own.reaction)
    traces = [_trace_path(own, trace) for trace in own.sketch.traces]
    columns = [
        own.time[:, None], own.position, own.orientation.reshape(-1, 9), own.velocity, own.angular_velocity,
        momentum.force, momentum.moment, own.energy[:, None], reaction.force, reaction.moment,
        own.violation[:, None], *traces,
    ]  # fmt: skip
    return np.concatenate(columns, 1)


# -- reading ---------------------------------------------------------------------------------------------------


def load_trajectory(path: str | os.PathLike[str]) -> Record:
    """Read a trajectory that was saved as NPZ: the same arrays to the last bit.

    Raises
    ------
    InputError
        If the file cannot be read, is damaged, or holds something else.
    """
    if not isinstance(path, str | bytes | os.PathLike):
        raise InputError(f"a trajectory is read from a file, and {shown(path)} names none.")
    try:
        file = Path(os.fsdecode(path))
        with np.load(file, allow_pickle=False) as archive_file:
            stored = {name: archive_file[name] for name in archive_file.files}
        return _restored(stored)
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror or error}.", where=str(path)) from None
    except BladesmithError as error:
        raise InputError(str(error), where=str(path)) from None
    except (
        ValueError,
        KeyError,
        TypeError,
        AttributeError,
        IndexError,
        EOFError,
        RecursionError,
        zipfile.BadZipFile,
    ) as error:
        detail = "" if "pickle" in str(error) else f" ({error})"  # NumPy advises what must not be done
        raise InputError(f"{_WRONG}{detail}.", where=str(path)) from None


def _restored(stored: dict[str, Array]) -> Record:
    raw = stored[HEADER]
    if raw.dtype != np.uint8 or raw.ndim != 1 or raw.size > LONGEST_HEADER:
        raise ValueError("its header is of another type")
    header = json.loads(raw.tobytes())
    if header["format"] != "trajectory" or header["version"] != VERSION:
        raise InputError(
            f"its format is {header['format']!r}, version {header['version']!r}; this release reads version {VERSION}.",
            remedy="A newer release of bladesmith may read it",
        )
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
    status, steps = header["status"], header["steps"]
    return Record(
        str(header["algebra"]), time, rows, common["energy"], common["violation"], str(header["integrator"]),
        np.array(status) if isinstance(status, list) else str(status), str(header["message"]),
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


__all__ = ["archive", "checked_name", "load_trajectory", "save", "table_text"]
