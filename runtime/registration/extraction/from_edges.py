"""Models of the segments of files."""

from __future__ import annotations

import os
from pathlib import Path

from ...interchange.polylines import load_segments
from ..model.model import Model


def model_from_edges(path: str | os.PathLike[str], *, unit: str = "", origin: str = "") -> Model:
    """Read the segments of a file: line elements `l` of .obj, or edge elements of .ply.

    Parameters
    ----------
    path : path
    unit, origin : str
        Texts of the model; default of ``origin``: the file's name.

    Raises
    ------
    InputError
        If the file cannot be read, holds no segments, or one that is not finite: with file and line, or number.
    """
    ends = load_segments(path)
    file = Path(os.fsdecode(path))
    return Model(segments=ends, name=file.stem, unit=unit, origin=origin or file.name)
