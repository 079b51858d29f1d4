"""Pages that need no network: one HTML file with its style, its script and its data in it, and a policy that lets it do
nothing else. Whatever a name of a user holds, it is text.
"""

from __future__ import annotations

import base64
import hashlib
import html
import json
from importlib import resources
from typing import Any

import numpy as np
from numpy.typing import NDArray

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


def render_page(folder: str, name: str, title: str, note: str, data: str, library: str = "") -> str:
    """A page from ``name``.html, .css and .js of a package's folder.

    Parameters
    ----------
    folder
        The package, such as ``"bladesmith.tracer.data"``.
    name
    title, note
        Texts, which are escaped here.
    data
        What `page_json` made.
    library
        A script that runs before the page's own.
    """
    files = resources.files(folder)
    page, style, script = (
        files.joinpath(f"{name}.{kind}").read_text(encoding="utf-8") for kind in ("html", "css", "js")
    )
    scripts = [text for text in (library, script) if text]
    policy = _POLICY.format(scripts=" ".join(_hash(text) for text in scripts))
    slots = {
        "policy": html.escape(policy), "title": html.escape(title), "note": html.escape(note),
        "style": style, "data": data, "library": library, "script": script,
    }  # fmt: skip
    head, *rest = page.split("{{")  # each slot once: what is filled in is never read again
    pieces = [head]
    for piece in rest:
        slot, _, after = piece.partition("}}")
        pieces += [slots[slot], after]
    return "".join(pieces)


def _hash(script: str) -> str:
    digest = hashlib.sha256(script.encode()).digest()
    return f"'sha256-{base64.b64encode(digest).decode('ascii')}'"


__all__ = ["encode_array", "index_type", "page_json", "render_page"]
