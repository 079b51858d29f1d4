"""Files that commands write: checked before any work, and named where work is cut short."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from pathlib import Path


def check_outputs(outputs: Sequence[Path], inputs: Sequence[Path], name: str) -> None:
    """Refuse what could not be written.

    Parameters
    ----------
    outputs : sequence of Path
        What is to be written.
    inputs : sequence of Path
        Files that are read, and stay.
    name : str
        What one of them is called, such as "the simulation file".

    Raises
    ------
    InputError
        For the first output that is a folder or in none, may not be written, is an input, or is given twice.
    """
    from ..errors import InputError

    for output in outputs:
        if output.is_dir() or not output.absolute().parent.is_dir():
            what = "it is a folder" if output.is_dir() else f"there is no folder {output.parent}"
            raise InputError(f"{what}.", where=str(output))
        if not os.access(output if output.exists() else output.absolute().parent, os.W_OK):
            raise InputError("cannot be written: no permission.", where=str(output))
        if any(output.exists() and x.exists() and output.samefile(x) for x in inputs):
            raise InputError(f"the result would take the place of {name}.", where=str(output))
    absolute = [output.absolute() for output in outputs]
    for i, output in enumerate(absolute):
        if output in absolute[:i]:
            raise InputError("two results have this name.", where=str(outputs[i]))


def partial_name(output: Path) -> Path:
    """The name for a part of a result: image.partial.png for image.png."""
    return output.with_name(f"{output.stem}.partial{output.suffix}")


def save_partial(outputs: Sequence[Path], save: Callable[[Path], Sequence[Path] | None]) -> str:
    """Save what there is under partial names; the end of the line about it.

    Parameters
    ----------
    outputs : sequence of Path
        Names of the whole results.
    save : callable
        ``save(path)``; it may return the paths that it wrote, if these are others.
    """
    from ..errors import BladesmithError

    saved: list[Path] = []
    try:
        for path in map(partial_name, outputs):
            saved += save(path) or [path]
    except (OSError, BladesmithError) as error:
        return f"; it could not be written: {error.strerror or error if isinstance(error, OSError) else error}"
    return f": {', '.join(map(str, saved))}" if saved else ""
