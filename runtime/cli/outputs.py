"""Files that commands write: checked before any work, and named where work is cut short."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path


def check_places(places: Sequence[Path], inputs: Sequence[Path], name: str) -> None:
    """Refuse what could not be written.

    Parameters
    ----------
    places : sequence of Path
        What is to be written.
    inputs : sequence of Path
        Files that are read, and stay.
    name : str
        What one of them is called, such as "the simulation file".

    Raises
    ------
    InputError
        For the first place that is a folder or in none, may not be written, is an input, or is given twice.
    """
    from ..errors import InputError

    for place in places:
        if place.is_dir() or not place.absolute().parent.is_dir():
            what = "it is a folder" if place.is_dir() else f"there is no folder {place.parent}"
            raise InputError(f"{what}.", where=str(place))
        if not os.access(place if place.exists() else place.absolute().parent, os.W_OK):
            raise InputError("cannot be written: no permission.", where=str(place))
        if any(place.exists() and x.exists() and place.samefile(x) for x in inputs):
            raise InputError(f"the result would take the place of {name}.", where=str(place))
    absolute = [place.absolute() for place in places]
    for i, place in enumerate(absolute):
        if place in absolute[:i]:
            raise InputError("two results have this name.", where=str(places[i]))


def partial_name(place: Path) -> Path:
    """The name for a part of a result: image.partial.png for image.png."""
    return place.with_name(f"{place.stem}.partial{place.suffix}")
