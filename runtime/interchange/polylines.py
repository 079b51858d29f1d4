"""Segments of files: line elements `l` of OBJ, edge elements of PLY. Readers of meshes drop them."""

from __future__ import annotations

import os
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..codegen.errors import InputError
from ..common.files import as_path
from ..common.validation import short_repr

Array = NDArray[Any]
#: Formats that are read, by the end of the name.
FORMATS = (".obj", ".ply")
#: Names of the two vertices of an edge of PLY.
EDGE = ("vertex1", "vertex2")
#: Formats of PLY.
FORMS = ("ascii", "binary_little_endian", "binary_big_endian")
#: Types of numbers of PLY, old and new names.
TYPES = {
    **dict(char="i1", uchar="u1", short="i2", ushort="u2", int="i4", uint="u4", float="f4", double="f8"),
    **dict(int8="i1", uint8="u1", int16="i2", uint16="u2", int32="i4", uint32="u4", float32="f4", float64="f8"),
}

#: Numbers of vertices beyond this one are of no file.
LARGEST_INDEX = 1 << 53


def load_segments(path: str | os.PathLike[str]) -> Array:
    """Ends (n, 2, 3) of the segments of a file, in its order; those without a length are left out.

    Parameters
    ----------
    path : path
        .obj: the stretches of its elements `l`; .ply: its elements `edge`, with `vertex1` and `vertex2`. Faces
        and points are ignored.

    Raises
    ------
    InputError
        If the file cannot be read, has no segments, a coordinate is not finite, or a vertex is not there: with the line
        where there is one.
    """
    file = as_path(path, "segments are read from")
    if file.suffix.lower() not in FORMATS:
        ending = file.suffix or "a name without an ending"
        raise InputError(f"segments are read from {', '.join(FORMATS)}, not {ending}.", where=str(file))
    try:
        content = file.read_bytes()
    except OSError as error:
        raise InputError(f"the file cannot be read ({error.strerror})", where=str(file)) from None
    vertices, pairs = _obj(content, file) if file.suffix.lower() == ".obj" else _ply(content, file)
    bad = (pairs < 0) | (pairs >= len(vertices))
    if bad.any():
        i = int(bad.any(1).argmax())
        raise InputError(f"edge {i} is between the vertices {pairs[i].tolist()}; there are {len(vertices)}.",
                         where=str(file))  # fmt: skip
    ends = vertices[pairs]
    good = np.isfinite(ends).all((1, 2))
    if not good.all():
        raise InputError(f"segment {int((~good).argmax())} is not finite.", where=str(file))
    ends = ends[(ends[:, 0] != ends[:, 1]).any(1)]
    if not len(ends):
        raise InputError("the file holds no segments with a length: elements `l` of OBJ, or `edge` of PLY.",
                         where=str(file),
                         remedy="bladesmith.reform.model_from_mesh makes lines of the edges of faces")  # fmt: skip
    return np.asarray(ends)


# -- PLY -----------------------------------------------------------------------------------------------------------


@dataclass
class _Element:
    """An element of PLY: its number of rows, and its properties: name and type, of lists also that of the length."""

    name: str
    count: int
    properties: list[tuple[str, str, str | None]] = field(default_factory=list)

    @property
    def has_lists(self) -> bool:
        """True if rows may differ in length."""
        return any(length is not None for _, _, length in self.properties)


def _ply(content: bytes, file: Path) -> tuple[Array, Array]:
    """Vertices (v, 3), and indices (n, 2) of edges."""
    form, elements, body = _header(content, file)
    found: dict[str, Any] = {}
    for element in elements:
        read = _rows_of_text if form == "ascii" else _rows_of_bytes
        try:
            rows, body = read(body, element, {"binary_big_endian": ">"}.get(form, "<"))
        except (ValueError, IndexError, OverflowError):
            what = f"the file ends, or has no numbers, in its element {element.name}"
            raise InputError(f"{what} of {element.count} rows.", where=str(file)) from None
        found[element.name] = rows
        if "vertex" in found and "edge" in found:
            break
    vertices = _columns(found, "vertex", ("x", "y", "z"), file)
    if "edge" not in found:
        return vertices, np.empty((0, 2), np.int64)
    pairs = _columns(found, "edge", EDGE, file)
    if not ((pairs == np.round(pairs)) & (np.abs(pairs) <= LARGEST_INDEX)).all():
        raise InputError("the vertices of the edges are no integers, or too large.", where=str(file))
    return vertices, pairs.astype(np.int64)


def _columns(found: dict[str, Any], element: str, names: tuple[str, ...], file: Path) -> Array:
    """Numbers (n, k) of some properties of an element."""
    if not set(names) <= set(found.get(element, {})):
        raise InputError(f"the file has no element {element} with {', '.join(names)}.", where=str(file))
    return np.stack([np.asarray(found[element][name], np.float64) for name in names], 1)


def _header(content: bytes, file: Path) -> tuple[str, list[_Element], bytes]:
    """Format, elements, and what follows the header."""
    head, separator, body = content.partition(b"\nend_header")
    lines = [line.split() for line in head.decode("ascii", "replace").splitlines()]
    form, elements, where = "", list[_Element](), ""
    try:
        for number, words in enumerate(lines, 1):
            where = f"{file}, line {number}"
            match words:
                case ["format", name, _]:
                    form = name
                case ["element", name, count]:
                    elements.append(_Element(name, int(count)))
                    if elements[-1].count < 0:
                        raise ValueError
                case ["property", "list", length, kind, name]:
                    elements[-1].properties.append((name, TYPES[kind], TYPES[length]))
                case ["property", kind, name]:
                    elements[-1].properties.append((name, TYPES[kind], None))
    except (KeyError, ValueError, IndexError):
        raise InputError(f"{' '.join(words)!r} is not a line of a header of PLY.", where=where) from None
    if not lines or lines[0] != ["ply"] or not separator or form not in FORMS:
        raise InputError("the file is not PLY: its header is not whole, or of another format.", where=str(file))
    return form, elements, body.partition(b"\n")[2]


def _rows_of_text(body: bytes, element: _Element, _: str) -> tuple[Any, bytes]:
    """Columns of an element whose rows are lines, and what follows; lists are left out."""
    *lines, body = body.split(b"\n", element.count) if element.count else [body]
    if len(lines) < element.count:
        lines, body = [*lines, body], b""
    rows = [line.split() for line in lines]
    if len(rows) < element.count:
        raise ValueError
    if element.has_lists:
        return {}, body
    names = [name for name, _, _ in element.properties]
    table = np.array([[float(word) for word in row[: len(names)]] for row in rows]).reshape(element.count, len(names))
    return {name: table[:, i] for i, name in enumerate(names)}, body


def _rows_of_bytes(body: bytes, element: _Element, order: str) -> tuple[Any, bytes]:
    """Columns of an element of numbers as bytes, and what follows; lists are left out."""
    if not element.has_lists:
        record = np.dtype([(name, order + kind) for name, kind, _ in element.properties])
        rows = np.frombuffer(body, record, element.count) if element.count else np.empty(0, record)
        return {name: rows[name] for name in record.names or ()}, body[element.count * record.itemsize :]
    place = 0
    for _ in range(element.count):
        for _, kind, length in element.properties:
            count = 1
            if length is not None:
                count = int(np.frombuffer(body, order + length, 1, place)[0])
                if count < 0:  # else the reader would go back, and never end
                    raise ValueError
                place += np.dtype(length).itemsize
            place += count * np.dtype(kind).itemsize
    if place > len(body):
        raise ValueError
    return {}, body[place:]


# -- OBJ -----------------------------------------------------------------------------------------------------------


def _obj(content: bytes, file: Path) -> tuple[Array, Array]:
    """Vertices (v, 3), and indices (n, 2) of the stretches of polylines."""
    text = content.decode("utf-8-sig", "replace").replace("\\\r\n", " ").replace("\\\n", " ")
    vertices: list[list[float]] = []
    pairs: list[tuple[int, int]] = []
    for number, line in enumerate(text.splitlines(), 1):
        kind, *words = line.split("#", 1)[0].split() or [""]
        where = f"{file}, line {number}"
        if kind == "v":
            vertices.append(_position(words, where))
        elif kind == "l":
            indices = [_index(word, len(vertices), where) for word in words]
            if len(indices) < 2:
                raise InputError("a line has two vertices or more.", where=where)
            pairs += zip(indices, indices[1:], strict=False)
    return np.array(vertices, np.float64).reshape(-1, 3), np.array(pairs, np.int64).reshape(-1, 2)


def _position(words: list[str], where: str) -> list[float]:
    try:
        x, y, z = (float(word) for word in words[:3])
    except ValueError:
        raise InputError(f"a vertex is {short_repr(' '.join(words))}; three numbers are needed.", where=where) from None
    return [x, y, z]


def _index(word: str, count: int, where: str) -> int:
    """Index of a vertex: from 1 on, or from the last one back; behind a slash there is one of a texture."""
    try:
        given = int(word.split("/")[0])
    except ValueError:
        raise InputError(f"a line has the vertex {short_repr(word)}; an integer is needed.", where=where) from None
    if given == 0 or not -count <= given <= LARGEST_INDEX:
        raise InputError(f"a line has the vertex {given}; {count} vertices stand before it.", where=where)
    return given - 1 if given > 0 else count + given
