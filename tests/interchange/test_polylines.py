"""Segments of OBJ and PLY: as written by plain text and bytes, and damaged files named."""

from __future__ import annotations

import struct

import numpy as np
import pytest

from bladesmith import reform
from bladesmith.errors import InputError
from bladesmith.interchange.polylines import load_segments

V = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0.5), (-2, 3.25, 1e-3)])
PAIRS = np.array([(0, 1), (1, 2), (3, 0)])


def ply(form, vertex="double", faces=False):
    """A PLY file of V and PAIRS: text, or bytes of either order."""
    head = [
        "ply",
        f"format {form} 1.0",
        "comment by hand, without an end_header",
        "element vertex 4",
        *(f"property {vertex} {x}" for x in "xyz"),
    ]
    head += ["element face 1", "property list uchar int vertex_indices"] if faces else []
    head += ["element edge 3", "property int vertex1", "property int vertex2", "property uchar red", "end_header", ""]
    start = "\n".join(head).encode()
    if form == "ascii":
        rows = [" ".join(map(repr, row)) for row in V.tolist()] + (["3 0 1 2"] if faces else [])
        return start + "\n".join([*rows, *(f"{a} {b} 7" for a, b in PAIRS.tolist())]).encode() + b"\n"
    order, number = {"binary_little_endian": "<", "binary_big_endian": ">"}[form], {"double": "d", "float": "f"}[vertex]
    data = b"".join(struct.pack(f"{order}3{number}", *row) for row in V)
    data += struct.pack(f"{order}B3i", 3, 0, 1, 2) if faces else b""
    return start + data + b"".join(struct.pack(f"{order}2iB", *row, 7) for row in PAIRS.tolist())


@pytest.mark.parametrize("form", ["ascii", "binary_little_endian", "binary_big_endian"])
@pytest.mark.parametrize("vertex", ["double", "float"])
@pytest.mark.parametrize("faces", [False, True])
def test_edges_of_ply(form, vertex, faces, tmp_path):
    (tmp_path / "x.ply").write_bytes(ply(form, vertex, faces))
    found = load_segments(tmp_path / "x.ply")
    np.testing.assert_allclose(found, V[PAIRS], rtol=0 if vertex == "double" else 1e-7)


def test_lines_of_obj(tmp_path):
    file = tmp_path / "Drawing.OBJ"
    text = "# by hand\nv 0 0 0\nv 1 0 0 1.0\nvt 0 0\nl 1 2/1 \\\n 3\n"
    text += "v 1 1 .5\nv -2 3.25 1e-3 # last\nl -1 1\nl 2 2\nf 1 2 3\n"
    for ending in ("\n", "\r\n"):
        file.write_bytes(text.replace("\n", ending).encode("utf-8-sig"))
        np.testing.assert_array_equal(load_segments(file), V[PAIRS])
    model = reform.model_from_edges(file, unit="m")
    assert (model.name, model.unit, model.origin, len(model)) == ("Drawing", "m", "Drawing.OBJ", 3)


OBJ = {
    "v 0 0 0\nl 1\n": "line 2: a line has two vertices", "v 0 0 0\nl 1 b\n": "line 2: .*'b'.*integer",
    "v 0 0 0\nl 0 1\n": "line 2: a line has the vertex 0", "v 0 0 0\nl -2 1\n": "line 2: .*vertex -2; 1 vertices stand",
    "v 0 0 0\nl 1 3\n": r"vertices \[0, 2\]; there are 1", "v 0 0\n": "line 1: a vertex is '0 0'; three numbers",
    "v 0 0 nan\nv 1 1 1\nl 1 2\n": "segment 0 is not finite", "v 0 0 0\n": "no segments.*model_from_mesh",
    "": "no segments", "v 0 0 0\nl 1 1\n": "no segments with a length",
    "v 0 0 0\nl 1 99999999999999999999\n": "line 2: a line has the vertex 9999",
}  # fmt: skip


@pytest.mark.parametrize("text", OBJ)
def test_what_is_wrong_in_obj_has_its_line(text, tmp_path):
    (tmp_path / "x.obj").write_text(text)
    with pytest.raises(InputError, match=OBJ[text]):
        load_segments(tmp_path / "x.obj")


PLY = {
    b"": "not PLY",
    b"ply\n": "not PLY",
    ply("ascii")[:-20]: "element edge of 3 rows",
    ply("binary_little_endian")[:-9]: "element edge of 3 rows",
    ply("ascii")[:-30].replace(b"4",
    b"9"): "element vertex of 9",
    ply("ascii").replace(b"vertex1",
    b"from"): "no element edge with vertex1, vertex2",
    ply("ascii").replace(b"\n3 0 7",
    b"\n9 0 7"): r"vertices \[9, 0\]; there are 4",
    ply("ascii").replace(b"\n3 0 7",
    b"\n0.5 0 7"): "no integers",
    ply("ascii").replace(b"edge",
    b"curve"): "no segments",
    ply("ascii").replace(b"3.25",
    b"inf"): "segment 2 is not finite",
    ply("ascii").replace(b"uchar",
    b"text"): "line 11: 'property text",
    ply("ascii").replace(b"ascii",
    b"utf8"): "not PLY",
    ply("ascii").replace(b"edge 3",
    b"edge -3"): "line 8: 'element edge -3' is not a line of a header",
    ply("binary_big_endian", faces=True).replace(b"face 1",
    b"face 9999"): "element face of 9999 rows",
    ply("ascii").replace(b"\n3 0 7",
    b"\n1e300 0 7"): "no integers, or too large",
    b"ply\nformat binary_little_endian 1.0\nelement face 1000000000000\nproperty list int uchar vertex_indices\n"
    b"end_header\n\xfc\xff\xff\xff": "element face of 1000000000000 rows",  # lists of -4 bytes: one step back
}  # fmt: skip


@pytest.mark.parametrize("number", range(len(PLY)))
def test_what_is_wrong_in_ply(number, tmp_path):
    content, message = list(PLY.items())[number]
    (tmp_path / "x.ply").write_bytes(content)
    with pytest.raises(InputError, match=message):
        load_segments(tmp_path / "x.ply")


def test_what_is_no_drawing(tmp_path):
    with pytest.raises(InputError, match=r"from \.obj, \.ply, not \.stl"):
        load_segments("x.stl")
    with pytest.raises(InputError, match="cannot be read"):
        load_segments(tmp_path / "none.obj")
    with pytest.raises(InputError, match="names none"):
        load_segments(3)
