"""How objects show themselves in notebooks: their mathematics or text, and a small picture where they have one.

What draws is above what is drawn: the package sets `painter`, which loads matplotlib at the first picture.
"""

from __future__ import annotations

import binascii
import sys
import warnings
from collections.abc import Callable, Container
from io import BytesIO
from typing import Any

#: Draws an object as axes of matplotlib; None where there is nothing to see. Set by the package.
painter: Callable[[Any], Any] | None = None
#: Resolution of the pictures.
DOTS_PER_INCH = 64
PNG, MARKDOWN = "image/png", "text/markdown"


class Displayed:
    """Base of what notebooks show with a picture, beside its text or its LaTeX."""

    __slots__ = ()

    def _repr_mimebundle_(
        self, include: Container[str] | None = None, exclude: Container[str] | None = None
    ) -> dict[str, str]:
        """The picture, and it below the mathematics; nothing where there is no picture: the other forms are shown."""
        wanted = [t for t in (PNG, MARKDOWN) if (include is None or t in include) and t not in (exclude or ())]
        png = _png_of(self) if wanted and _shows_pictures() else ""
        if not png:
            return {}
        latex = getattr(self, "_repr_latex_", None)
        caption = latex() if latex is not None else f"`{self!r}`"
        page = f"{caption}\n\n![{type(self).__name__}](data:{PNG};base64,{png})"
        return {t: {PNG: png, MARKDOWN: page}[t] for t in wanted}


def _png_of(thing: Displayed) -> str:
    """The picture in base64; empty without one, whatever the reason: to look at an object must not fail."""
    if painter is None:
        return ""
    file = BytesIO()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            axes = painter(thing)
            if axes is None:
                return ""
            axes.figure.savefig(file, format="png", dpi=DOTS_PER_INCH)
    except Exception:
        return ""
    return binascii.b2a_base64(file.getvalue(), newline=False).decode("ascii")


def _shows_pictures() -> bool:
    """Not in a terminal, where IPython asks for the same bundle and throws the picture away."""
    ipython = sys.modules.get("IPython")
    shell = None if ipython is None else ipython.get_ipython()
    return shell is None or PNG in shell.display_formatter.active_types
