"""Arguments and options that commands share, each declared once; what commands say while they work; their files, which
are checked before any work, and named where work is cut short."""

from __future__ import annotations

import os
import sys
import threading
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import click

from ..codegen.progress import Progress, progress_bar
from ..codegen.version import site_page

#: Seconds without a sign of life, after which a command says what it is doing.
PATIENCE = 1.5
PATH = click.Path(path_type=Path)
FOLDER = click.Path(path_type=Path, file_okay=False)
#: Formats of pictures.
IMAGES = "PNG, PDF, SVG. (Extra: plot.)"
COUNT = click.IntRange(min=1)
Decorator = Callable[[Any], Any]


@dataclass(frozen=True)
class Feedback:
    """Messages of a command while it works.

    Parameters
    ----------
    requested : bool, optional
        Progress bars: True shows them, False silences the command, None shows them on a terminal, not in a pipe.
    """

    requested: bool | None

    @property
    def shows_bars(self) -> bool:
        """True if bars and notices are shown."""
        return sys.stderr.isatty() if self.requested is None else self.requested

    def say(self, *lines: str) -> None:
        """Write lines to stderr, unless the command is silenced."""
        for line in lines if self.requested is not False else ():
            click.echo(line, err=True)

    @contextmanager
    def preparing(self, notice: str) -> Iterator[Callable[[], None]]:
        """Say that something is prepared, if the block takes longer than `PATIENCE`; the function calls that off."""
        timer = threading.Timer(PATIENCE, click.echo, (notice,), {"err": True})
        timer.daemon = True
        if self.shows_bars:
            timer.start()
        try:
            yield timer.cancel
        finally:
            timer.cancel()

    @contextmanager
    def progress(self, notice: str, title: str) -> Iterator[Any]:
        """Argument ``progress`` of a run: a bar, with a notice before its first step; False without a bar."""
        if not self.shows_bars:
            yield False
            return
        with self.preparing(notice) as call_off, progress_bar(title) as show:

            def tell(progress: Progress) -> None:
                call_off()
                show(progress)

            yield tell

    def wrote(self, paths: Iterable[Path | None]) -> None:
        """Name the files that were written."""
        self.say(*(f"wrote {path}" for path in paths if path is not None))


def command(example: str, page: str) -> Decorator:
    """A command whose help ends with an example, without the program's name, and with its page of the site."""
    return click.command(epilog=f"Example: bladesmith {example}\n\nMore: {site_page(page)}")


def input_file(name: str) -> Decorator:
    """An argument that is a path of a file to read."""
    return click.argument(name, type=PATH)


def file(*names: str, help: str, **options: Any) -> Decorator:
    """An option that is a path of a file to write; with ``multiple=True`` it may be repeated."""
    return click.option(*names, type=PATH, help=help, **options)


def output_file(default: str | None, help: str, name: str = "output", **options: Any) -> Decorator:
    """The option --output of the main result."""
    return file("--output", "-o", name, default=default, show_default=default is not None, help=help, **options)


def output_folder(default: str) -> Decorator:
    """The option --out of a folder."""
    return click.option("-o", "--out", default=default, show_default=True, type=FOLDER, help="Folder to write.")


def flag(name: str, help: str) -> Decorator:
    """A switch."""
    return click.option(name, is_flag=True, help=help)


def option_with_default(name: str, default: Any, help: str, type: Any = None) -> Decorator:
    """An option with a default that its help tells."""
    return click.option(name, type=type, default=default, show_default=True, help=help)


threads: Decorator = click.option("--threads", type=COUNT, help="Default: all processors.")
feedback: Decorator = click.option(
    "--progress/--quiet",
    "feedback",
    default=None,
    callback=lambda context, parameter, value: Feedback(value),
    help="Show bars, or say nothing of progress and of files written; default: bars on a terminal.",
)


# -- files that commands write ------------------------------------------------------------------------------


def check_outputs(outputs: Sequence[Path], inputs: Sequence[Path], name: str, more: str = "") -> None:
    """Refuse what could not be written.

    Parameters
    ----------
    outputs : sequence of Path
        What is to be written.
    inputs : sequence of Path
        Files that are read, and stay.
    name : str
        What one of them is called, such as "the simulation file".
    more : str
        Which names options choose by themselves, for the error of two that are alike.

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
            raise InputError("two results have this name.", where=str(outputs[i]), remedy=f"Give each its own{more}")


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
