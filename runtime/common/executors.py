"""Work in pieces on the workers of an executor: threads, processes, a cluster.

What all pieces of a job have in common, its task, is serialized once; workers cache it, and pieces name it by a digest.
Workers load or compile what they need themselves. A piece has the same result as here, bit for bit, so that neither the
number of workers nor their order changes a result.
"""

from __future__ import annotations

import pickle
import threading
from abc import ABC, abstractmethod
from collections import OrderedDict
from collections.abc import Callable, Collection, Iterable, Mapping
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, CancelledError, Executor, Future, wait
from contextlib import suppress
from dataclasses import dataclass
from hashlib import sha256
from typing import Any, ClassVar
from uuid import uuid4

from numpy.typing import NDArray

from ..codegen.errors import BladesmithError, ExecutorError, InputError
from ..codegen.interrupts import deferred_interrupts
from ..codegen.version import __version__
from .parallel import POLL
from .validation import invalid, short_repr

#: Assumed number of workers of an executor that does not report it.
DEFAULT_WORKERS = 4
#: Pieces for each worker, so that none waits long for another.
PIECES_PER_WORKER = 4
#: Largest number of calls of a piece whose workers fail.
MAX_TRIES = 2
#: Tasks that a worker caches.
CACHED_TASKS = 2
#: Remedy of an invalid executor.
REMEDY = "Give an open concurrent.futures.Executor"


class Task(ABC):
    """Data that all pieces of a job share. Instances can be pickled."""

    #: Whether each thread of a worker has a state of its own.
    per_thread: ClassVar[bool] = False

    @abstractmethod
    def prepare(self) -> Any:
        """State from which a worker computes pieces."""

    def source(self) -> str:
        """Text of the program, which is the same for workers; empty if that does not matter."""
        return ""


@dataclass(frozen=True)
class Payload:
    """A task in bytes, with its digest."""

    data: bytes
    digest: str
    per_thread: bool

    @classmethod
    def of(cls, task: Task) -> Payload:
        """Serialize a task once, so that it is cheap to send many times.

        Raises
        ------
        InputError
            If it cannot be serialized.
        """
        try:
            content = pickle.dumps(task)
        except Exception as error:  # users' objects raise anything
            what = f"this cannot be sent to workers: {_one_line(error)}."
            raise InputError(what, remedy="Leave out executor=") from error
        data = b"\n".join((__version__.encode(), _digest(task).encode(), content))
        return cls(data, sha256(data).hexdigest(), task.per_thread)


def _digest(task: Task) -> str:
    source = task.source()
    return sha256(source.encode()).hexdigest() if source else ""


@dataclass
class _Piece:
    index: int
    function: Callable[..., Any]
    arguments: tuple[Any, ...]
    name: str
    tries: int = 0
    attached: bool = True


class Calls:
    """Calls of an executor for the pieces of a job: sent, waited for, and sent again where that helps.

    Parameters
    ----------
    executor : concurrent.futures.Executor
    payload : Payload
    attached : bool
        Send the task with each piece; otherwise only to workers that do not know it.

    Raises
    ------
    InputError
        If it is not an executor.
    """

    def __init__(self, executor: Executor, payload: Payload, attached: bool = True) -> None:
        check_executor(executor)
        self._executor, self._payload, self._attached = executor, payload, attached
        self._name = uuid4().hex
        self._pending: dict[Future[Any], _Piece] = {}

    def send(self, index: int, function: Callable[..., Any], arguments: tuple[Any, ...], name: str) -> None:
        """Submit a piece: a worker calls ``function(state, *arguments)``; its result is not None.

        Parameters
        ----------
        index : int
        function : callable
            Of a module.
        arguments : tuple
        name : str
            What is lost if it fails, in the plural: "rows 3 to 7".

        Raises
        ------
        InputError
            If the executor takes no work.
        """
        try:
            self._submit(_Piece(index, function, arguments, name, attached=self._attached))
        except BaseException:
            self.drop()
            raise

    def wait(self, indices: Collection[int], done: Callable[[int, Any], None]) -> None:
        """Wait for pieces; ``done(index, result)`` is called as each of them, and of others, is finished.

        Raises
        ------
        ExecutorError
            If workers fail, or end, twice.
        """
        missing = set(indices)
        try:
            with deferred_interrupts() as tell:
                while missing:
                    tell()
                    finished, _ = wait(self._pending, timeout=POLL, return_when=FIRST_COMPLETED)
                    for future in finished:
                        piece = self._pending.pop(future)
                        result = self._result(future, piece)
                        if result is not None:
                            missing.discard(piece.index)
                            done(piece.index, result)
        except BaseException:
            for future, piece in self._pending.items():  # nothing that is finished is lost; the first error counts
                with suppress(BaseException):
                    if future.done() and (result := future.result()) is not None:
                        done(piece.index, result)
            self.drop()
            raise

    def drop(self) -> None:
        """Cancel all pending calls."""
        for future in self._pending:
            future.cancel()

    def _submit(self, piece: _Piece) -> None:
        payload = self._payload
        # clusters merge calls with equal arguments: with a name neither is cancelled, or fails, with another
        name = f"{self._name} {piece.index} {piece.tries} {piece.attached}"
        data = payload.data if piece.attached else None
        try:
            future = self._executor.submit(
                run_piece, payload.digest, data, payload.per_thread, piece.function, piece.arguments, name
            )
        except BrokenExecutor as error:  # a worker ended meanwhile: as where it ends later
            future = Future()
            future.set_exception(error)
        except Exception as error:  # shut down, or not an executor at all
            if piece.tries:
                raise _failure(piece, error) from error
            raise InputError(f"the executor takes no work: {_one_line(error)}.", remedy=REMEDY) from None
        if not isinstance(future, Future):
            raise InputError(f"the executor takes no work: submit gives {short_repr(future)}.", remedy=REMEDY)
        self._pending[future] = piece

    def _result(self, future: Future[Any], piece: _Piece) -> Any:
        """Result of a piece; None if it was sent again."""
        try:
            result = future.result()
        except BladesmithError:
            raise
        except Exception as error:  # whatever executors raise for workers that die
            piece.tries += 1
            if piece.tries >= MAX_TRIES or isinstance(error, CancelledError):
                raise _failure(piece, error) from error
            self._submit(piece)
            return None
        if result is None and piece.attached:
            raise _failure(piece, InputError("the executor gives None for its result"))
        if result is None:
            piece.attached = True
            self._submit(piece)
        return result


def run_pieces(
    executor: Executor,
    payload: Payload,
    function: Callable[..., Any],
    pieces: Iterable[tuple[tuple[Any, ...], str]],
    done: Callable[[int, Any], None],
) -> None:
    """Run all pieces of a job, arguments and name of each: see `Calls`."""
    calls, count = Calls(executor, payload), 0
    for arguments, name in pieces:
        calls.send(count, function, arguments, name)
        count += 1
    calls.wait(range(count), done)


def fill_rows(
    executor: Executor,
    task: Task | Payload,
    function: Callable[..., Mapping[str, NDArray[Any]]],
    pieces: Mapping[tuple[int, int], tuple[Any, ...]],
    name: str,
    arrays: Mapping[str, NDArray[Any]],
    done: Callable[[int, int, int], None],
) -> None:
    """Fill rows of arrays by pieces, arguments by range of rows; then ``done(begin, end, number of rows so far)``."""
    parts, count = list(pieces), 0

    def copy(index: int, results: Mapping[str, NDArray[Any]]) -> None:
        nonlocal count
        begin, end = parts[index]
        for key, rows in results.items():
            arrays[key][begin:end] = rows
        count += end - begin
        done(begin, end, count)

    named = [(arguments, f"{name} {begin} to {end - 1}") for (begin, end), arguments in pieces.items()]
    run_pieces(executor, Payload.of(task) if isinstance(task, Task) else task, function, named, copy)


def fill_parts(
    executor: Executor | None,
    task: Task,
    function: Callable[..., Mapping[str, NDArray[Any]]],
    columns: Iterable[NDArray[Any]],
    name: str,
    arrays: Mapping[str, NDArray[Any]],
    report: Callable[[int], None],
    grain: int,
) -> None:
    """Fill rows of arrays from the same rows of ``columns``, in parts: on an executor's workers, or without one here.

    Parameters
    ----------
    function : callable
        ``function(state, *rows of columns)`` gives rows of arrays by name.
    report : callable
        Gets the number of rows so far.
    grain : int
        Rows of a part: that many here, about so many at least on workers.
    """
    columns = list(columns)
    n = len(columns[0])
    if executor is not None:
        pieces = {(a, b): tuple(column[a:b] for column in columns) for a, b in ranges(executor, n, grain)}
        fill_rows(executor, task, function, pieces, name, arrays, lambda a, b, count: report(count))
        return
    state = task.prepare()
    for begin in range(0, n, grain):
        end = min(begin + grain, n)
        for key, rows in function(state, *(column[begin:end] for column in columns)).items():
            arrays[key][begin:end] = rows
        report(end)


def ranges(executor: Executor, n: int, grain: int = 1) -> list[tuple[int, int]]:
    """Ranges [begin, end) of n items, of about ``grain`` at least: some for each worker."""
    check_executor(executor)
    count = max(1, min(n // grain, PIECES_PER_WORKER * workers(executor)))
    edges = [n * i // count for i in range(count + 1)]
    return list(zip(edges[:-1], edges[1:], strict=True))


def check_executor(executor: Any) -> None:
    """Check that a value has what executors have.

    Raises
    ------
    InputError
        If it has not.
    """
    if isinstance(executor, type) or not callable(getattr(executor, "submit", None)):
        raise invalid(executor, "executor", "an open concurrent.futures.Executor")


def workers(executor: Any) -> int:
    """Number of workers of an executor, if it reports it: pools and the executors of dask do."""
    client = getattr(executor, "_client", None)
    with suppress(Exception):
        count = sum(client.ncores().values()) if client is not None else executor._max_workers
        return max(1, int(count))
    return DEFAULT_WORKERS


def _failure(piece: _Piece, error: Exception) -> ExecutorError:
    return ExecutorError(
        f"{piece.name} were not computed: {_one_line(error)}.",
        remedy="See the workers' own output; without executor= the work is done here",
    )


def _one_line(error: Exception) -> str:
    return " ".join(f"{type(error).__name__}{f': {error}' if str(error) else ''}".split()).rstrip(".")


# -- workers ---------------------------------------------------------------------------------------------------


class _Cache:
    """States of the latest tasks, by their digests."""

    def __init__(self) -> None:
        self._states: OrderedDict[str, Any] = OrderedDict()
        self._lock = threading.Lock()

    def state(self, digest: str, data: bytes | None) -> Any:
        """The state of a task; None if it is not known and not sent."""
        with self._lock:
            if digest in self._states:
                self._states.move_to_end(digest)
                return self._states[digest]
        if data is None:
            return None
        state = _unpack(data).prepare()
        with self._lock:
            self._states[digest] = state
            while len(self._states) > CACHED_TASKS:
                self._states.popitem(last=False)
        return state


class _ThreadCache(_Cache, threading.local):
    """States for each thread."""


_of_process, _of_thread = _Cache(), _ThreadCache()


def run_piece(
    digest: str,
    data: bytes | None,
    per_thread: bool,
    function: Callable[..., Any],
    arguments: tuple[Any, ...],
    _name: str,
) -> Any:
    """Compute a piece on a worker; None if its task is not known here."""
    state = (_of_thread if per_thread else _of_process).state(digest, data)
    return None if state is None else function(state, *arguments)


def _unpack(data: bytes) -> Task:
    version, digest, content = data.split(b"\n", 2)  # plain, so that nothing of another version is unpickled
    if version.decode() != __version__:
        raise BladesmithError(f"a worker has bladesmith {__version__}, the work comes from {version.decode()}.")
    task: Task = pickle.loads(content)
    own = _digest(task)
    if digest and own and digest.decode() != own:
        raise BladesmithError(f"a worker has another bladesmith {__version__} than the one that the work comes from.")
    return task


__all__ = [
    "Calls",
    "Payload",
    "Task",
    "check_executor",
    "fill_parts",
    "fill_rows",
    "ranges",
    "run_piece",
    "run_pieces",
    "workers",
]
