"""Small texts in the cache, beside the compiled libraries: written in one step, checked whenever they are read.

A group of texts is one entry of the cache (see cache.py): listed, cleared and dropped as a whole.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import secrets
import time
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path

from . import cache, source_digest

_DIGITS = 24


def read(group: str, name: str) -> str | None:
    """A text, or None where there is none that is what was written."""
    with contextlib.suppress(OSError, UnicodeDecodeError):
        content = cache.regular_bytes(_folder(group) / name)
        sealed, _, body = content.partition(b"\n")
        if sealed.decode() == hashlib.sha256(body).hexdigest():
            return body.decode()
    return None


def write(group: str, texts: Mapping[str, str]) -> None:
    """Keep texts by name. Where the cache cannot be written, nothing is kept: they can be made again."""
    folder = _folder(group)
    with contextlib.suppress(OSError):
        folder.mkdir(parents=True, exist_ok=True)
        for name, text in texts.items():
            body = text.encode()
            _put(folder / name, hashlib.sha256(body).hexdigest().encode() + b"\n" + body)
        if not (folder / cache.RECORD).exists():
            _put(folder / cache.RECORD, json.dumps({"name": group, "built": time.time()}).encode())


def made_once(stem: str, sources: Iterable[str], name: str, make: Callable[[], str]) -> str:
    """A text that is made once for each state of the sources that it depends on.

    Parameters
    ----------
    stem : str
        Beginning of the group's name.
    sources : iterable of str
        As for `source_digest.digest`. Where there is no digest the text is made anew.
    name : str
        In the group.
    make : callable
        Makes it.
    """
    digest = source_digest.digest(sources)
    group = digest and _group(stem, digest)
    found = read(group, name) if group else None
    if found is None:
        found = make()
        if group:
            write(group, {name: found})
    elif group:
        touch(group)
    return found


def is_made(stem: str, sources: Iterable[str], name: str) -> bool:
    """Whether `made_once` has the text."""
    digest = source_digest.digest(sources)
    return digest is not None and read(_group(stem, digest), name) is not None


def touch(group: str) -> None:
    """Note that a group was used: the cache drops what was not for longest."""
    with contextlib.suppress(OSError):
        os.utime(_folder(group) / cache.RECORD)


def _group(stem: str, digest: str) -> str:
    return f"{stem}_{digest[:_DIGITS]}"


def _folder(group: str) -> Path:
    return cache.directory() / f"text_{group}"


def _put(path: Path, content: bytes) -> None:
    """Other processes see the whole file or none; of two that write at once, the last one stays."""
    part = path.parent / f".{secrets.token_hex(8)}"  # not by tempfile, whose files nobody else may read
    try:
        part.write_bytes(content)
        os.replace(part, path)
    except OSError:
        with contextlib.suppress(OSError):
            os.unlink(part)
        raise
