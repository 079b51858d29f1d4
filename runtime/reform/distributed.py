"""A registration's trials and refinements in pieces over the workers of an executor: threads, processes, a cluster.

Workers find or compile the driver themselves, and keep the models that they were sent: a piece names them by a digest,
and only to a worker that has not seen them does it go again, with them. Each piece gives what it gives here, bit for
bit, so that neither the number of workers nor their order changes a result.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Executor, Future, wait
from contextlib import suppress
from dataclasses import dataclass, field, replace
from hashlib import sha256
from typing import Any
from uuid import uuid4

import numpy as np
from numpy.typing import NDArray

from .. import parallel
from ..errors import BladesmithError, InputError
from .sides import Closeness, Side
from .stages import SETTLED
from .trials import Chosen, Lot, Tried
from .worker import TRIED, Sent, work

Array = NDArray[Any]
#: Samples that are worth a call, some ten milliseconds; and objects to be laid on others, over all motors of a call.
SAMPLES, OBJECTS = 1 << 11, 1 << 17
#: Models of at most this many bytes go along with every piece: that is cheaper than to ask whether they are known.
CARRIED = 1 << 16
#: Lots of sets for each worker that are sent ahead; workers where the executor does not tell how many it has.
AHEAD, UNTOLD = 2, 4
#: Calls of a piece whose worker ended, at most.
TRIES = 2
REMEDY = "Give an open concurrent.futures.Executor"


class WorkerError(BladesmithError):
    """A worker of an executor failed or ended, and did so again."""


@dataclass
class _Piece:
    """A call: its place among the others, its own items, and how often it was tried."""

    place: int
    arguments: tuple[Any, ...]
    tries: int = 0
    carries: bool = False


@dataclass
class SharedScene:
    """A scene (see `engine.Scene`) whose samples and refinements are shared over an executor.

    Attributes
    ----------
    local : Scene
        The same here, which does what is too little to be shared.
    sent : Sent
    executor : concurrent.futures.Executor
    """

    local: Any
    sent: Sent
    executor: Executor
    _closeness: Closeness = field(default_factory=lambda: Closeness((0.0, 0.0, 0.0), 0.0))
    _packed: tuple[str, bytes] | None = field(default=None, repr=False)
    _trials: _Calls | None = field(default=None, repr=False)

    @property
    def asked(self) -> int:
        """Query objects that are looked at."""
        return int(self.local.asked)

    def ask(self, kinds: Array, rows: Array) -> None:
        """Look at other query objects."""
        self.local.ask(kinds, rows)
        self.sent, self._packed = replace(self.sent, kinds=kinds, rows=rows), None

    def closeness(self, given: Closeness) -> None:
        """From now on."""
        self.local.closeness(given)
        self._closeness = given
        if self._trials is not None:
            self._trials.drop()
            self._trials = None

    def samples(self, kinds: Array, query: Array, reference: Array, signs: Array, residual: float) -> Any:
        """As of `engine.Scene`."""
        return self._shared("samples", (kinds, query, reference, signs), (residual,), SAMPLES)

    @property
    def ahead(self) -> int:
        """Lots that are sent before it is known whether they are needed."""
        return AHEAD * workers(self.executor)

    def send(self, chosen: Chosen, place: int, lots: list[Lot], tolerance: float, residual: float) -> None:
        """Have lots of sets tried that a search has chosen (see `trials.Trials`); others are dropped when closeness
        changes."""
        if self.sent.chosen is not chosen:
            self.sent, self._packed = replace(self.sent, chosen=chosen), None
        if self._trials is None:
            self._trials = _Calls(self, TRIED)
        self._trials.send(_Piece(place, (lots, tolerance, residual)))

    def collected(self, places: Sequence[int]) -> Tried:
        """What the lots gave that were sent for these places."""
        assert self._trials is not None
        return Tried.joined(self._trials.collected(places))

    def refine(self, motors: Array, rounds: int, settled: float = SETTLED) -> Any:
        """As of `engine.Scene`."""
        grain = max(1, OBJECTS // max(self.asked * max(rounds, 1), 1))
        return self._shared("refine", (motors,), (rounds, settled), grain)

    def __getattr__(self, name: str) -> Any:
        """Stages that are not shared."""
        if name.startswith("_") or name == "local":
            raise AttributeError(name)
        return getattr(self.local, name)

    def _shared(self, stage: str, arrays: tuple[Array, ...], others: tuple[Any, ...], grain: int) -> Any:
        """A stage on items in pieces of at least ``grain``, joined in their order."""
        n = len(arrays[0])
        count = n // grain
        if count < 2:
            return getattr(self.local, stage)(*arrays, *others)
        edges = [n * i // count for i in range(count + 1)]
        pieces = [
            _Piece(i, (*(a[begin:end] for a in arrays), *others))
            for i, (begin, end) in enumerate(zip(edges[:-1], edges[1:], strict=True))
        ]
        found = _Calls(self, stage).run(pieces)
        return tuple(np.concatenate(parts) for parts in zip(*found, strict=True))

    def payload(self) -> tuple[str, bytes]:
        """Digest and bytes of the models."""
        if self._packed is None:
            packed = self.sent.packed()
            self._packed = sha256(packed).hexdigest(), packed
        return self._packed


class _Calls:
    """The calls of one stage: sent, waited for, and sent again where that helps."""

    def __init__(self, scene: SharedScene, stage: str) -> None:
        self._scene, self._stage, self._name = scene, stage, uuid4().hex
        self._digest, self._payload = scene.payload()
        self._pending: dict[Future[Any], _Piece] = {}
        self._found: dict[int, Any] = {}

    def run(self, pieces: list[_Piece]) -> list[Any]:
        """What each piece gives, in their order."""
        for piece in pieces:
            self.send(piece)
        return self.collected(range(len(pieces)))

    def send(self, piece: _Piece) -> None:
        """Have a piece done."""
        piece.carries = len(self._payload) <= CARRIED
        try:
            self._send(piece)
        except BaseException:
            self.drop()
            raise

    def collected(self, places: Sequence[int]) -> list[Any]:
        """What the pieces of some places give; they are waited for."""
        missing = {place for place in places if place not in self._found}
        try:
            while missing:
                done, _ = wait(self._pending, timeout=parallel.POLL, return_when=FIRST_COMPLETED)
                for future in done:
                    piece = self._pending.pop(future)
                    result = self._result(future, piece)
                    if result is not None:
                        self._found[piece.place] = result
                        missing.discard(piece.place)
        except BaseException:
            self.drop()
            raise
        return [self._found.pop(place) for place in places]

    def drop(self) -> None:
        """What is not needed any more."""
        for future in self._pending:
            future.cancel()

    def _send(self, piece: _Piece) -> None:
        payload = self._payload if piece.carries else None
        name = f"{self._name} {piece.place} {piece.tries} {piece.carries}"
        try:
            future = self._scene.executor.submit(
                work, self._digest, payload, self._scene._closeness, self._stage, piece.arguments, name
            )
        except Exception as error:  # shut down, or broken
            if piece.tries or isinstance(error, BrokenExecutor):
                raise _ended(error) from error
            raise InputError(f"the executor takes no work: {_told(error)}.", remedy=REMEDY) from None
        if not isinstance(future, Future):
            raise InputError(f"the executor takes no work: submit gives a {type(future).__name__}.", remedy=REMEDY)
        self._pending[future] = piece

    def _result(self, future: Future[Any], piece: _Piece) -> Any:
        """What a piece gave; None if it was sent again."""
        try:
            result = future.result()
        except BladesmithError:
            raise
        except Exception as error:  # whatever executors raise for workers that die
            piece.tries += 1
            if piece.tries >= TRIES:
                raise _ended(error) from error
            self._send(piece)
            return None
        if result is None:
            piece.carries = True
            self._send(piece)
        return result


def shared(
    executor: Any, scene: Any, backend: str, sides: tuple[Side, Side], asked: tuple[Array, Array], threads: int | None
) -> SharedScene:
    """A scene that shares its work over an executor.

    Parameters
    ----------
    executor : concurrent.futures.Executor
    scene : Scene
        Of these models, here.
    backend : str
    sides : (Side, Side)
        Query and reference.
    asked : (array, array)
        Kinds and rows of the query objects that are looked at.
    threads : int, optional
        Of each worker. Default: one.

    Raises
    ------
    InputError
        If it is no executor.
    """
    submit: Callable[..., Any] | None = getattr(executor, "submit", None)
    if isinstance(executor, type) or not callable(submit):
        shown = executor.__name__ if isinstance(executor, type) else f"a {type(executor).__name__}"
        raise InputError(f"the executor takes no work: it is {shown}.", remedy=REMEDY)
    count = 1 if threads is None else parallel.thread_count(threads)
    return SharedScene(scene, Sent(backend, count, *sides, *asked), executor)


def workers(executor: Any) -> int:
    """How many calls an executor does at a time, where it tells: pools and the executors of dask do."""
    client = getattr(executor, "_client", None)
    with suppress(Exception):
        count = sum(client.ncores().values()) if client is not None else executor._max_workers
        return max(1, int(count))
    return UNTOLD


def _ended(error: Exception) -> WorkerError:
    return WorkerError(
        f"workers failed: {_told(error)}.",
        remedy="See their own output; without executor= the registration runs here",
    )


def _told(error: Exception) -> str:
    """An error on one line."""
    return f"{type(error).__name__}{f': {error}' if str(error) else ''}".rstrip(".")


__all__ = ["SharedScene", "WorkerError", "shared"]
