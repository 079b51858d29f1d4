"""Cache of compiled kernels: one folder per key, written once, checked whenever it is read.

An entry is built in a temporary sibling and renamed into place under a lock that the operating system drops
when a process dies. What is compiled, and how, is not known here: see build.py.
"""

from __future__ import annotations

import atexit
import contextlib
import errno
import hashlib
import json
import logging
import os
import shutil
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from threading import Lock

from filelock import FileLock, Timeout

from ..errors import CompileError

DIRECTORY_VARIABLE = "BLADESMITH_CACHE_DIR"
LIMIT_BYTES = 512 * 2**20  # a stock scene takes about 0.3 MB: room for many, and no surprise on a small disk
LIBRARY_SUFFIX = ".pyd" if os.name == "nt" else ".so"
OBJECT_SUFFIX = ".o"

RECORD = "entry.json"
_LOCKS = "locks"
_FAILED = "failed"
#: Folder of what the compiler of the package ziglang keeps: its runtime libraries.
ZIG = "zig"
_log = logging.getLogger("bladesmith")
_private_lock = Lock()
_private: list[Path] = []  # the private directory, once one had to be made


@dataclass(frozen=True)
class Entry:
    """One compiled library, or a part of some, in the cache."""

    stem: str
    folder: Path
    size: int
    used: float

    @property
    def library(self) -> Path:
        """The shared library, where the entry is one."""
        return self.folder / (self.stem + LIBRARY_SUFFIX)


def directory() -> Path:
    """The directory of the cache: `BLADESMITH_CACHE_DIR`, or the user's cache directory."""
    chosen = os.environ.get(DIRECTORY_VARIABLE)
    if chosen:
        return Path(chosen).expanduser().absolute()
    from platformdirs import user_cache_dir

    return Path(user_cache_dir("bladesmith", appauthor=False))


def folder_of(name: str) -> Path:
    """A folder in the cache that belongs to a tool."""
    return (_private[0] if _private else directory()) / name


def is_writable(root: Path) -> bool:
    """Try whether files can be made in the directory, or in the one that it would be made in: found out by trying.

    Permissions say too little: nobody can make a file in `/proc`, or on a disk that is mounted read-only.
    """
    nearest = next(path for path in (root, *root.parents) if os.path.exists(path))
    try:
        with tempfile.TemporaryFile(dir=nearest):
            return True
    except OSError:
        return False


def fetch(stem: str, build: Callable[[Path], Mapping[str, object]], suffix: str = LIBRARY_SUFFIX) -> Path:
    """Path of the library `stem`, from the cache, or built into it.

    Parameters
    ----------
    stem
        Name of the entry: an identifier that ends in a digest of everything that changes the library.
    build
        Called with an empty folder, in which it leaves the library `stem` + `suffix` and anything else
        worth keeping. Returns facts for the entry's record.
    suffix
        Of the file: LIBRARY_SUFFIX, or OBJECT_SUFFIX for what libraries are linked from.

    Raises
    ------
    CompileError
        As raised by `build`; its folder is kept, and the error names it. Or no directory has room.
    """
    root = directory()
    if library := _library_if_intact(root / stem, suffix):
        return library
    try:
        if not _private:  # else the directory could not be written: that is not tried again
            try:
                return _fetch_in(root, stem, build, suffix)
            except OSError as error:
                _make_private_directory(root, error)
        return _fetch_in(_private[0], stem, build, suffix)
    except OSError as error:
        raise CompileError(
            f"cannot be written, and neither can the directory for temporary files: {error.strerror or error}",
            where=str(root),
            remedy=f"Set {DIRECTORY_VARIABLE} to a directory that can be written, on a disk with room",
        ) from None


def find(stem: str) -> Path | None:
    """Path of the library `stem`, where the cache holds it."""
    return _library_if_intact(directory() / stem, LIBRARY_SUFFIX)


def entries() -> list[Entry]:
    """Entries of the cache, most recently used first."""
    return sorted(_entries(directory()), key=lambda entry: -entry.used)


def clear() -> tuple[int, int]:
    """Remove every entry that no process is building. Returns the number of entries and of bytes removed."""
    root = directory()
    removed = size = 0
    for entry in _entries(root):
        if _remove_unless_busy(root, entry.stem):
            removed += 1
            size += entry.size
    for folder in _listing(root):
        if folder.name.startswith("."):
            _remove_unless_busy(root, folder.name.split(".")[1])
    for name in (_FAILED, ZIG):
        shutil.rmtree(root / name, ignore_errors=True)
    return removed, size


def discard(stem: str) -> None:
    """Remove an entry that turned out to be unusable."""
    for root in (directory(), *_private):
        with contextlib.suppress(OSError), _lock(root, stem):
            _remove(root / stem)


def _fetch_in(root: Path, stem: str, build: Callable[[Path], Mapping[str, object]], suffix: str) -> Path:
    if library := _library_if_intact(root / stem, suffix):
        return library
    with _lock(root, stem):
        if library := _library_if_intact(root / stem, suffix, warn=True):
            return library
        _remove_leftovers(root, stem)
        outer = Path(tempfile.mkdtemp(prefix=f".{stem}.", dir=root))
        work = outer / stem  # for all whom the umask lets in: what `mkdtemp` makes is for nobody else
        try:
            work.mkdir()
            record = dict(build(work))
            _write_record(work, work / (stem + suffix), record)
            os.replace(work, root / stem)
        except CompileError as error:
            _keep_failed(root, stem, work, error)
            raise
        finally:
            shutil.rmtree(outer, ignore_errors=True)
    _prune(root, stem)
    return root / stem / (stem + suffix)


def _library_if_intact(folder: Path, suffix: str, warn: bool = False) -> Path | None:
    """The library of an entry, when it is what was recorded. Anything else counts as no entry."""
    library = folder / (folder.name + suffix)
    try:
        record = json.loads(regular_bytes(folder / RECORD))
        content = regular_bytes(library)
        if len(content) == record["size"] and hashlib.sha256(content).hexdigest() == record["sha256"]:
            with contextlib.suppress(OSError):
                os.utime(folder / RECORD)
            return library
    except (OSError, ValueError, KeyError, TypeError, RecursionError):
        pass
    if warn and os.path.lexists(folder):
        _log.warning("cache entry %s is damaged; building it again", folder)
    return None


def regular_bytes(path: Path) -> bytes:
    """Contents of a file, never of a pipe or a device, which have no end.

    Raises
    ------
    OSError
        If there is no such file, or it cannot be read.
    """
    if not path.is_file():
        raise OSError(errno.ENOENT, os.strerror(errno.ENOENT), str(path))
    return path.read_bytes()


def _write_record(work: Path, library: Path, record: dict[str, object]) -> None:
    content = library.read_bytes()
    record |= {"size": len(content), "sha256": hashlib.sha256(content).hexdigest(), "built": time.time()}
    (work / RECORD).write_text(json.dumps(record, indent=1) + "\n", encoding="utf-8")


def _lock(root: Path, stem: str, timeout: float = -1) -> FileLock:
    (root / _LOCKS).mkdir(parents=True, exist_ok=True)
    return FileLock(root / _LOCKS / f"{stem}.lock").acquire(timeout=timeout).lock


def _remove_leftovers(root: Path, stem: str) -> None:
    """Under the lock: a damaged entry, and the half-built folders of processes that were killed."""
    _remove(root / stem)
    for folder in root.glob(f".{stem}.*"):
        shutil.rmtree(folder, ignore_errors=True)


def _remove(folder: Path) -> None:
    """Take an entry out of sight in one step, then delete it: a reader never sees half of one."""
    if not os.path.lexists(folder):  # a link that leads nowhere is in the way as well
        return
    grave = Path(tempfile.mkdtemp(prefix=f".{folder.name}.", dir=folder.parent))
    os.replace(folder, grave / folder.name)
    shutil.rmtree(grave, ignore_errors=True)


def _remove_unless_busy(root: Path, stem: str) -> bool:
    try:
        with _lock(root, stem, timeout=0):
            _remove_leftovers(root, stem)
        return True
    except (OSError, Timeout):
        return False


def _keep_failed(root: Path, stem: str, work: Path, error: CompileError) -> None:
    """Put aside what would not compile, one folder per key, so that the error can name a file to look at."""
    if error.source is None or error.source.parent != work:
        return  # that of a part, which is put aside under its own key
    kept = root / _FAILED / stem
    with contextlib.suppress(OSError):
        kept.parent.mkdir(exist_ok=True)
        shutil.rmtree(kept, ignore_errors=True)
        os.replace(work, kept)
        error.set_folder(kept)


def _listing(root: Path) -> Iterator[Path]:
    with contextlib.suppress(OSError):
        yield from sorted(path for path in root.iterdir() if path.is_dir())


def _entries(root: Path) -> Iterator[Entry]:
    for folder in _listing(root):
        with contextlib.suppress(OSError):  # an entry that another process removes meanwhile
            used = (folder / RECORD).stat().st_mtime
            size = sum(path.stat().st_size for path in folder.rglob("*"))
            yield Entry(folder.name, folder, size, used)


def _prune(root: Path, keep: str) -> None:
    """Drop the entries unused for longest when the cache has grown over its limit."""
    found = sorted(_entries(root), key=lambda entry: entry.used)
    excess = sum(entry.size for entry in found) - LIMIT_BYTES
    for entry in found:
        if excess <= 0:
            return
        if entry.stem != keep and _remove_unless_busy(root, entry.stem):
            excess -= entry.size


def _make_private_directory(root: Path, error: OSError) -> None:
    """Make a directory of this process alone, for when the cache cannot be used. Says so once."""
    with _private_lock:
        if not _private:
            folder = Path(tempfile.mkdtemp(prefix="bladesmith-"))
            atexit.register(_remove_private, folder, os.getpid())
            _private.append(folder)
            _log.warning(
                "cache directory %s cannot be used (%s); what this process compiles goes to %s and is lost "
                "at its end. Set %s to a directory that can be written.",
                root, error.strerror or error, folder, DIRECTORY_VARIABLE,
            )  # fmt: skip


def _remove_private(folder: Path, owner: int) -> None:
    if os.getpid() == owner:  # not in a forked child, whose parent still uses it
        shutil.rmtree(folder, ignore_errors=True)
