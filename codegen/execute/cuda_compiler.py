"""Printed CUDA texts compiled with NVRTC, through the cache."""

from __future__ import annotations

import base64
import hashlib
import json
from collections.abc import Mapping, Sequence

from ..build import text_cache
from ..targets.cuda.printer import MAIN, with_headers
from .nvrtc import DEFAULT_ARCH, OPTIONS, CompiledText, architectures, compile_text, version

#: Digits of the digest in the name of an entry of the cache.
_DIGITS = 24


def compile_source(files: Mapping[str, str], arch: str = DEFAULT_ARCH, options: Sequence[str] = ()) -> CompiledText:
    """Compile generated files with NVRTC; see `nvrtc.compile_text`.

    Raises
    ------
    MissingExtraError
        If NVRTC is not installed.
    CompileError
        If it refuses the source.
    """
    texts = with_headers(files)
    return compile_text(texts.pop(MAIN), texts, MAIN, arch, options)


def compile_cached(files: Mapping[str, str], arch: str, options: Sequence[str] = ()) -> bytes:
    """The image of generated files, from the cache or compiled now; see `compile_source`."""
    sources = with_headers(files)
    parts = [sorted(sources.items()), arch, [*OPTIONS, *options], version()]
    name = hashlib.sha256(json.dumps(parts).encode()).hexdigest()[:_DIGITS]
    text = text_cache.read(f"cuda_{name}", f"{arch}.txt")
    if text is None:
        image = compile_source(files, arch, options).image
        text_cache.write(f"cuda_{name}", {f"{arch}.txt": base64.b64encode(image).decode()})
        return image
    text_cache.touch(f"cuda_{name}")
    return base64.b64decode(text)


def device_arch(capability: int) -> str:
    """The arch to compile for on a GPU of this capability: machine code, or PTX where NVRTC is older."""
    supported = architectures()
    return f"sm_{capability}" if capability in supported else f"compute_{max(a for a in supported if a < capability)}"
