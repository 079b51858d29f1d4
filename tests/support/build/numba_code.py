"""Machine code that numba keeps, shared by tests whose caches hold nothing else."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from ..checkout import TEST_CACHE


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
