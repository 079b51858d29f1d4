"""Multivectors in .npz files. Reading one never executes anything: plain arrays and a header of plain data.

A file says which algebra its coefficients belong to by the algebra's metric, never by expressions.
"""

from __future__ import annotations

import io
import json
import os
import zipfile
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np

from . import loading
from .algebras import Algebra
from .codegen.algebra import validated_identifier
from .codegen.catalogue import STOCK
from .codegen.errors import BladesmithError, InputError, KindError
from .files import write_atomically
from .multivector import Multivector

FORMAT = 1
#: Name of the array that holds the header, and what a single multivector is stored under.
HEADER, SINGLE = "bladesmith", "x"
#: A header is some hundred characters per multivector; a longer one is not ours.
LONGEST_HEADER = 1_000_000


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
        if not isinstance(x, Multivector):
            raise InputError(f"{name} is a {type(x).__name__}; save takes multivectors.")
        header["items"][name] = _described(x)
        stored[f"{name}.values"] = x.values
        if x._status is not None:
            stored[f"{name}.status"] = x._status
    stored[HEADER] = np.frombuffer(json.dumps(header).encode(), np.uint8)
    buffer = io.BytesIO()
    np.savez(buffer, **stored)
    try:
        write_atomically(Path(path), buffer.getvalue())
    except OSError as error:
        raise InputError(f"cannot be written: {error.strerror or error}", where=str(path)) from None


def _described(x: Multivector) -> dict[str, Any]:
    a = x.algebra
    return {
        "algebra": a.name,
        "vectors": list(a.vectors),
        "metric": [[str(g) for g in row] for row in a.metric],
        "pseudoscalar": a.pseudoscalar_name,
        "kind": None if x.kind.is_layout else x.kind.name,
        "blades": [str(b) for b in x.blades],
    }


def load(path: str | os.PathLike[str]) -> Any:
    """What `save` wrote: a multivector, or a dictionary of them.

    A kind's constraints are checked again; coefficients that do not satisfy them come back as a layout.

    Raises
    ------
    InputError
        If the file is missing, damaged, or not one of ours.
    """
    try:
        with np.load(path, allow_pickle=False) as file:
            stored = {name: file[name] for name in file.files}
        header = _header(stored)
        found = {name: _restored(stored, name, entry) for name, entry in header["items"].items()}
        return found[SINGLE] if header["single"] else found
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror or error}", where=str(path)) from None
    except BladesmithError as error:
        raise InputError(str(error), where=str(path)) from None
    except (ValueError, KeyError, TypeError, AttributeError, EOFError, zipfile.BadZipFile) as error:
        detail = "" if "pickle" in str(error) else f" ({error})"  # NumPy advises what must not be done
        raise InputError(f"not a file that save() wrote{detail}", where=str(path)) from None


def _header(stored: dict[str, Any]) -> dict[str, Any]:
    raw = stored[HEADER]
    if raw.dtype != np.uint8 or raw.ndim != 1 or raw.size > LONGEST_HEADER:
        raise ValueError("its header is of another type")
    header = json.loads(raw.tobytes())
    if header["format"] != FORMAT:
        raise ValueError(f"its format is {header['format']}, not {FORMAT}")
    return header  # type: ignore[no-any-return]


def _restored(stored: dict[str, Any], name: str, entry: dict[str, Any]) -> Multivector:
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
    known = loading.stock_algebra(name) if name in STOCK else loading.algebra(*new.signature)
    same = (known.vectors, known.metric, known.pseudoscalar_sign) == (new.vectors, new.metric, new.pseudoscalar_sign)
    return known if same else loading.plain_algebra(new)


def _metric(entry: dict[str, Any]) -> list[list[Any]]:
    return [[Fraction(str(g)) for g in row] for row in entry["metric"]]
