"""Writing of exported files: everything is checked and printed before the first one is written."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from importlib import import_module
from pathlib import Path

from ..documents.whole_files import replacing
from ..errors import InputError, one_line
from ..optimise.variants import Variant
from .bound import ExportedAlgorithm
from .names import check_names
from .options import LANGUAGES, ExportOptions
from .overwriting import check_overwritten
from .unit import exported_unit


def export(
    items: Sequence[Variant | ExportedAlgorithm], folder: str | Path, options: ExportOptions
) -> list[Path]:  # fmt: skip
    """Write kernels and algorithms as source files of a language.

    Parameters
    ----------
    items : sequence of Variant or ExportedAlgorithm
    folder : path
        Made where it is not there.
    options : ExportOptions

    Returns
    -------
    list of Path
        The files.

    Raises
    ------
    InputError
        If two functions have one name, a name cannot be one in the language, or a file is there that is not this
        export's (nothing has been written then); or the folder cannot be written to.
    """
    try:
        target = Path(folder)
    except TypeError:
        raise InputError(f"files are written to a folder, and {one_line(folder)} names none.") from None
    texts = export_texts(items, options)
    try:
        if not options.overwrite:
            check_overwritten(target, texts)
        target.mkdir(parents=True, exist_ok=True)
        with ExitStack() as stack:  # all are written before the first one has its name
            for file, text in texts.items():
                stack.enter_context(replacing(target / file)).write_text(text, encoding="utf-8", newline="\n")
    except InputError:
        raise
    except (OSError, ValueError) as error:  # ValueError: a null character
        why = error.strerror if isinstance(error, OSError) else None
        raise InputError(f"cannot be written: {why or error}.", where=str(target)) from None
    return [target / file for file in texts]


def export_texts(items: Sequence[Variant | ExportedAlgorithm], options: ExportOptions) -> Mapping[str, str]:
    """The files of `export`, by name."""
    language = LANGUAGES[options.language]
    unit = exported_unit(options.name, items, options.precision, options.source)
    check_names(unit, options.language)
    module = import_module(f".languages.{language.module}", __package__)
    files: Callable[..., Mapping[str, str]] = getattr(module, language.function)
    return files(unit, split=True) if options.split else files(unit)
