"""Pages that need no network: one HTML file with its style, its script and its data in it, and a policy that lets it do
nothing else. Whatever a name of a user holds, it is text.
"""

from __future__ import annotations

import base64
import hashlib
import json
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..codegen.targets.templates import render, template_text

#: What a page may do: run its own scripts and style itself.
_POLICY = (
    "default-src 'none'; script-src {scripts}; style-src 'unsafe-inline'; img-src data: blob:; "
    "base-uri 'none'; form-action 'none'"
)


def page_json(data: Any) -> str:
    """JSON that no HTML parser takes for anything else."""
    text = json.dumps(data, allow_nan=False, separators=(",", ":"))
    for sign in "<>&":
        text = text.replace(sign, f"\\u{ord(sign):04x}")
    return text


def encode_array(values: NDArray[Any], dtype: Any) -> dict[str, str]:
    """Type and base64 text of an array, little-endian, as plotly and the pages' own scripts read them."""
    array = np.ascontiguousarray(values, np.dtype(dtype).newbyteorder("<"))
    name = f"{array.dtype.kind}{array.dtype.itemsize}"
    return {"dtype": name, "bdata": base64.b64encode(array.tobytes()).decode("ascii")}


def index_type(count: int) -> Any:
    """Smallest type of indices of so many vertices."""
    return np.uint16 if count <= np.iinfo(np.uint16).max else np.uint32


def render_page(name: str, title: str, note: str, data: str, library: str = "") -> str:
    """A page from the templates ``name``.html.j2, .css and .js.

    Parameters
    ----------
    name : str
    title, note : str
    data : str
        Result of `page_json`.
    library : str
        A script that runs before the page's own.
    """
    style, script = (template_text(f"{name}.{kind}") for kind in ("css", "js"))
    scripts = [text for text in (library, script) if text]
    policy = _POLICY.format(scripts=" ".join(_hash(text) for text in scripts))
    return render(f"{name}.html.j2", policy=policy, title=title, note=note, style=style, data=data, scripts=scripts)


def _hash(script: str) -> str:
    digest = hashlib.sha256(script.encode()).digest()
    return f"'sha256-{base64.b64encode(digest).decode('ascii')}'"


__all__ = ["encode_array", "index_type", "page_json", "render_page"]
