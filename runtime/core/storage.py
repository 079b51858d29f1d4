"""Multivectors in .npz files. Reading one never executes anything: plain arrays and a header of plain data.

A file says which algebra its coefficients belong to by the algebra's metric, never by expressions.
"""

from __future__ import annotations

import os
from typing import Any

import numpy as np

from ..codegen.algebra.blades import metric_entry, validated_identifier
from ..codegen.algebra.loader import PRESETS, STOCK
from ..codegen.errors import InputError, KindError
from ..common.data_files import read_npz, write_npz
from ..common.files import as_path
from ..common.validation import as_instance
from . import registry
from .multivector import Algebra, Multivector

FORMAT = 1
#: What a single multivector is stored under.
SINGLE = "x"


def save(path: str | os.PathLike[str], *items: Multivector, **named: Multivector) -> None:
    """Write one multivector, or several by name, to an .npz file.

    The file is written beside its place and renamed: an interruption leaves no half of it. `InputError` where it
    cannot be written.

    Parameters
    ----------
    path : path
        Written as it is given, without adding a suffix.
    *items : Multivector
        One, which `load` gives back as it is.
    **named : Multivector
        Several, which `load` gives back as a dictionary.
    """
    if len(items) + bool(named) != 1:
        raise InputError("save takes one multivector, or several by name: save(path, a=a, b=b).")
    entries = named or {SINGLE: items[0]}
    header: dict[str, Any] = {"format": FORMAT, "single": not named, "items": {}}
    stored: dict[str, Any] = {}
    for name, x in entries.items():
        as_instance(x, name, Multivector, "a multivector")
        header["items"][name] = _describe(x)
        stored[f"{name}.values"] = x.values
        if x._status is not None:
            stored[f"{name}.status"] = x._status
    write_npz(as_path(path, "multivectors are written to"), stored, header)


def _describe(x: Multivector) -> dict[str, Any]:
    a = x.algebra
    return {
        "algebra": a.name,
        "vectors": list(a.vectors),
        "metric": [[str(g) for g in row] for row in a.metric],
        "pseudoscalar": a.pseudoscalar_name,
        "kind": None if x.kind.is_layout else x.kind.name,
        "blades": [str(b) for b in x.blades],
    }


def load(path: str | os.PathLike[str]) -> Multivector | dict[str, Multivector]:
    """Read a file of `save`: a multivector, or a dictionary of them.

    A kind's constraints are checked again; coefficients that do not satisfy them come back as a layout.

    Raises
    ------
    InputError
        If the file is missing, damaged, or not one of ours.
    """
    return read_npz(path, "a multivector", "save", {"format": FORMAT}, _build)


def _build(header: dict[str, Any], stored: dict[str, Any]) -> Multivector | dict[str, Multivector]:
    items = {name: _restore(stored, name, entry) for name, entry in header["items"].items()}
    return items[SINGLE] if header["single"] else items


def _restore(stored: dict[str, Any], name: str, entry: dict[str, Any]) -> Multivector:
    algebra = _algebra(entry)
    x = algebra.multivector(stored[f"{name}.values"], blades=[str(b) for b in entry["blades"]])
    status = stored.get(f"{name}.status")
    if status is not None:
        if status.dtype != np.uint8 or status.shape != x.shape:
            raise ValueError("its statuses do not fit its values")
        x = x._make(x._type, x._data, x.shape, status)
    if entry["kind"] is None:
        return x
    try:
        return x.as_kind(str(entry["kind"]))
    except KindError:
        return x


def _algebra(entry: dict[str, Any]) -> Algebra:
    """The stock or orthonormal algebra of this metric, else a plain one: kinds never come from a file."""
    name = validated_identifier(entry["algebra"], "the algebra's name")
    new = Algebra(name, [str(v) for v in entry["vectors"]], _metric(entry), entry["pseudoscalar"])
    known = registry.stock_algebra(name) if name in (*STOCK, *PRESETS) else registry.algebra(*new.signature)
    same = (known.vectors, known.metric, known.pseudoscalar_sign) == (new.vectors, new.metric, new.pseudoscalar_sign)
    return known if same else registry.plain_algebra(new)


def _metric(entry: dict[str, Any]) -> list[list[Any]]:
    return [[metric_entry(g) for g in row] for row in entry["metric"]]
