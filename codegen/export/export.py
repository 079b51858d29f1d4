"""Writing of exported files: everything is checked and printed before the first one is written."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from importlib import import_module
from pathlib import Path

from ..errors import InputError
from ..optimise.variants import Variant
from .bound import ExportedAlgorithm
from .names import check_names
from .unit import exported_unit

#: Languages by what users call them: the module of `languages` that prints them, the function, precisions.
_LANGUAGES = {
    "c99": ("c99", "c99_files", ("f64", "f32")),
    "cpp": ("cpp", "cpp_files", ("f64", "f32")),
    "glsl": ("glsl", "glsl_files", ("f32",)),
    "rust": ("rust.printer", "rust_files", ("f64", "f32")),
    "js": ("js.printer", "js_files", ("f64",)),
}
#: What files can be exported in.
LANGUAGES = tuple(_LANGUAGES)
_PRECISIONS = {"float64": "f64", "float32": "f32"}


def export(
    items: Sequence[Variant | ExportedAlgorithm],
    language: str,
    folder: str | Path,
    name: str,
    dtype: str = "",
    *,
    split: bool = False,
) -> list[Path]:
    """Write kernels and algorithms as source files of a language.

    Parameters
    ----------
    items : sequence of Variant or ExportedAlgorithm
    language : str
        One of `LANGUAGES`.
    folder : path
        Made where it is not there.
    name : str
        Of the files, and before or around all names in them.
    dtype : {"", "float64", "float32"}
        Of the numbers. Default: what is usual in the language. C++ has templates for both.
    split : bool
        Of C99: a header that declares the functions, and a source file that defines them; else one header is all.

    Returns
    -------
    list of Path
        The files.

    Raises
    ------
    InputError
        If there is no such language or precision, two functions have one name, or a name cannot be one there (nothing
        has been written then); or the folder cannot be written to.
    """
    texts = export_texts(items, language, name, dtype, split=split)
    target = Path(folder)
    try:
        target.mkdir(parents=True, exist_ok=True)
        for file, text in texts.items():
            part = target / f"{file}.part"
            part.write_text(text, encoding="utf-8")
            part.replace(target / file)
    except OSError as error:
        raise InputError(f"cannot be written: {error.strerror or error}.", where=str(target)) from None
    return [target / file for file in texts]


def export_texts(
    items: Sequence[Variant | ExportedAlgorithm], language: str, name: str, dtype: str = "", *, split: bool = False
) -> Mapping[str, str]:
    """The files of `export`, by name."""
    if not isinstance(name, str):
        raise InputError(f"the name of the file is {name!r}, and no text.")
    if language not in _LANGUAGES:
        raise InputError(f"there is no language {language!r}.", remedy=f"Choose one of {', '.join(LANGUAGES)}.")
    module, function, precisions = _LANGUAGES[language]
    precision = _PRECISIONS.get(dtype) if dtype else precisions[0]
    if precision not in precisions:
        known = ", ".join(d for d, p in _PRECISIONS.items() if p in precisions)
        raise InputError(f"{language} has no numbers of type {dtype!r}.", remedy=f"There are: {known}.")
    if split and language != "c99":
        raise InputError(f"{language} has no header apart from its functions.", remedy="Leave split to c99.")
    unit = exported_unit(name, items, precision)
    check_names(unit, language)
    files: Callable[..., Mapping[str, str]] = getattr(import_module(f".languages.{module}", __package__), function)
    return files(unit, split=True) if split else files(unit)
