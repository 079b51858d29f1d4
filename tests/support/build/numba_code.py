"""Printed Python of whole programs in tests: run as it is, without a compiler; and machine code that numba keeps."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cffi import FFI

from bladesmith.codegen.execute import in_place, items, numba_cache
from bladesmith.codegen.execute.numba_callbacks import C_TYPE

from ..checkout import TEST_CACHE

#: Names of texts by what numba makes of them: numbers of 64 bits. Places are compared with no bound.
_WORDS = {"float": np.float64, "int": np.int64, "U": lambda place: place}


class PlainModule:
    """A printed text as Python has it, in place of `numba_cache.CachedModule`: the same bits, a thousand times slower.

    Compiling a program takes numba half a minute. What it makes of the text of algorithms, all kinds of their nodes,
    tests/codegen/ir compares; what remains to be tested of a program is its text.
    """

    def __init__(self, name: str, source: str, signatures: Mapping[str, Any]) -> None:
        self._names: dict[str, Any] = {"__name__": name}
        exec(compile(source, f"<{name}>", "exec"), self._names)
        self._names |= _WORDS
        if "user_values" in self._names:
            self._names["user_values"] = _user_values

    def __getitem__(self, function: str) -> Callable[..., None]:
        run = self._names[function]

        def quiet(*arguments: Any) -> None:
            with np.errstate(all="ignore"):
                run(*arguments)

        return quiet


def _user_values(handle: Any, which: Any, item: Any, t: Any, state: Any, state_at: Any, out: Any, out_at: Any) -> int:
    ffi = FFI()
    call = ffi.cast(C_TYPE.replace("int(", "int (*)(", 1), int(handle))
    places = (ffi.from_buffer("double[]", x) + int(at) for x, at in ((state, state_at), (out, out_at)))
    return int(call(int(which), int(item), float(t), *places))


@contextmanager
def numba_text_as_python() -> Iterator[None]:
    """While this lasts, programs that are loaded for numba are `PlainModule`. Caches of programs are the caller's."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(numba_cache, "CachedModule", PlainModule)
        for module in (items, in_place):
            patch.setattr(module, "numba_signature", lambda _: None)
        yield


@contextmanager
def shared_numba_code(folder: Path) -> Iterator[None]:
    """While the cache is in ``folder``, numba finds there what other tests compiled, by the digest of its text.

    What is compiled meanwhile goes to the others. Programs of C in ``folder`` stay its own.
    """
    folder.mkdir(parents=True, exist_ok=True)
    for kept in Path(TEST_CACHE).glob("numba_*"):
        with suppress(FileExistsError):
            (folder / kept.name).symlink_to(kept, target_is_directory=True)
    yield
    Path(TEST_CACHE).mkdir(parents=True, exist_ok=True)
    for made in folder.glob("numba_*"):
        if not made.is_symlink():
            with suppress(OSError):  # another process was faster, or the caches are on two disks
                os.rename(made, Path(TEST_CACHE, made.name))
