"""What all exports share: their options, with what they mean and may be, and how docstrings describe them.

Light on purpose: commands and classes import it before anything is exported.
"""

from __future__ import annotations

import inspect
import re
import sys
import textwrap
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

from ..errors import InputError, one_line, suggest


@dataclass(frozen=True)
class Language:
    """What files can be exported in.

    Attributes
    ----------
    module, function : str
        What prints its files: a module of `languages`, and a function there.
    precisions : tuple of str
        Of numbers, the usual one first.
    has_split : bool
        Whether declarations may stand apart from definitions.
    """

    module: str
    function: str
    precisions: tuple[str, ...] = ("f64", "f32")
    has_split: bool = False


#: By what users call them.
LANGUAGES = {
    "c99": Language("c99", "c99_files", has_split=True),
    "cpp": Language("cpp", "cpp_files"),
    "rust": Language("rust.printer", "rust_files"),
    "js": Language("js.printer", "js_files", ("f64",)),
    "glsl": Language("glsl", "glsl_files", ("f32",)),
}
#: Types of numbers by what users call them.
PRECISIONS = {"float64": "f64", "float32": "f32"}
#: What docstrings say of each option, and of what there is in every export.
_TEXTS = {
    "language": "language : {" + ", ".join(f'"{name}"' for name in LANGUAGES) + "}",
    "folder": "folder : path\n    Where files are written to; made where it is not there.",
    "name": "name : str, optional\n    Of the files, and before or around all names in them.",
    "dtype": 'dtype : {"float64", "float32"}, optional\n'
    "    Of the numbers. Default: what is usual in the language. C++ has templates for both.",
    "split": "split : bool\n"
    "    Of C99: a header that declares the functions, and a source file that defines them; else all is in the header.",
    "overwrite": "overwrite : bool\n"
    "    Also a file that is there already and is not this export's: of another source, with functions that the new\n"
    "    one has not, or not written by this package. The same export is written again without it.",
    "files": "Returns\n-------\nlist of Path\n    The files.",
    "refusals": "If there is no such language or precision, the language cannot say it or have a name, a file is\n"
    "there that is not this export's, or the folder cannot be written to. Nothing has been written then.",
}  # fmt: skip
_F = TypeVar("_F", bound=Callable[..., Any])


def describes_options(export: _F) -> _F:
    """Complete a docstring: a line such as ``{dtype}`` becomes what the option means, ``{files}`` what is returned."""
    if text := inspect.getdoc(export):
        export.__doc__ = re.sub(
            r"^( *)\{(\w+)\}$", lambda found: textwrap.indent(_TEXTS[found[2]], found[1]), text, flags=re.MULTILINE
        )
    return export


def source_of(function: Any, name: str) -> str:
    """Module and name of what a user declared; of a script the same, whether it is run or imported."""
    module = function.__module__
    if module == "__main__":
        module = Path(getattr(sys.modules[module], "__file__", None) or module).stem
    return f"{module}:{name}"


@dataclass(frozen=True)
class ExportOptions:
    """How files are written; what the options mean is said in `_TEXTS`.

    ``source`` names what is exported, as the files say: those of one source are written again.

    Raises
    ------
    InputError
        If there is no such language or type of numbers, or the language has no declarations apart.
    """

    language: str
    name: str
    dtype: str = ""
    split: bool = False
    overwrite: bool = False
    source: str = ""

    def __post_init__(self) -> None:
        if not isinstance(self.name, str):
            raise InputError(f"the name of the file is {one_line(self.name)}, and no text.")
        if not isinstance(self.language, str) or self.language not in LANGUAGES:
            raise InputError(
                f"there is no language {one_line(self.language)}{suggest(self.language, LANGUAGES)}.",
                remedy=f"Choose one of {', '.join(LANGUAGES)}.",
            )
        known = [d for d, p in PRECISIONS.items() if p in LANGUAGES[self.language].precisions]
        if self.dtype and self.dtype not in known:
            raise InputError(
                f"{self.language} has no numbers of type {one_line(self.dtype)}.",
                remedy=f"There are: {', '.join(known)}.",
            )
        for name, flag in (("split", self.split), ("overwrite", self.overwrite)):
            if not isinstance(flag, bool):
                raise InputError(f"{name} is {one_line(flag)}; True or False is needed.")
        if self.split and not LANGUAGES[self.language].has_split:
            raise InputError(
                f"{self.language} has no header apart from its functions.", remedy="Leave split to c99."
            )  # fmt: skip

    @property
    def precision(self) -> str:
        """Of the numbers, "f64" or "f32"."""
        return PRECISIONS[self.dtype] if self.dtype else LANGUAGES[self.language].precisions[0]
