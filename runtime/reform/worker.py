"""What workers of an executor do for a registration: lots of sets that they try, and stages of a scene, on models that
they keep once sent.
"""

from __future__ import annotations

import pickle
import threading
from collections import OrderedDict
from dataclasses import dataclass
from functools import cached_property
from hashlib import sha256
from typing import Any

from numpy.typing import NDArray

from ..codegen.programs.reform import in_order, reform_program
from ..codegen.version import __version__
from ..errors import BladesmithError
from .backends import backend_of
from .sides import Closeness, Side
from .trials import Chosen, Trials

Array = NDArray[Any]
#: Pairs of models that each thread of a worker keeps.
KEPT = 2
#: The stage that is one of `Trials`; the others are of scenes.
TRIED = "tried"


@dataclass(frozen=True, eq=False)
class Sent:
    """Two models as numbers, without what computes with them.

    Attributes
    ----------
    backend : str
    threads : int
        Of each worker.
    query, reference : Side
    kinds, rows : int32 arrays (n,)
        Query objects that are looked at.
    chosen : Chosen, optional
        For a search.
    """

    backend: str
    threads: int
    query: Side
    reference: Side
    kinds: Array
    rows: Array
    chosen: Chosen | None = None

    def packed(self) -> bytes:
        """The same as bytes, which are cheap to send many times."""
        program = _program_digest(tuple(self.query.rows))
        return pickle.dumps((__version__, program, pickle.dumps(self)))


class Known:
    """Models that were sent, and what computes with them here."""

    def __init__(self, sent: Sent) -> None:
        self._sent, self._made = sent, backend_of(sent.backend)
        self.scene = self._made.scene(sent.query, sent.reference, sent.kinds, sent.rows, sent.threads)

    @cached_property
    def trials(self) -> Trials:
        """For a search."""
        sent = self._sent
        assert sent.chosen is not None
        driver = self._made.driver(tuple(sent.query.rows), sent.threads)
        return Trials(self.scene, driver, sent.query.rows, sent.reference.rows, sent.chosen)


class _Kept(threading.local):
    """Models that this thread keeps: what computes with them has a state, which threads do not share."""

    def __init__(self) -> None:
        self.models: OrderedDict[str, Known] = OrderedDict()


_kept = _Kept()


def work(
    digest: str, payload: bytes | None, closeness: Closeness, stage: str, arguments: tuple[Any, ...], _call: str = ""
) -> Any:
    """What a worker is called for: a stage of a scene on some of its items, or lots of sets that are tried; None if it
    has to be sent the models.

    Clusters take calls with equal arguments for one: the name of the call keeps those of two registrations apart, so
    that neither is cancelled, or fails, with the other.
    """
    models = _kept.models
    if digest not in models:
        if payload is None:
            return None
        models[digest] = Known(_unpacked(payload))
        while len(models) > KEPT:
            models.popitem(last=False)
    models.move_to_end(digest)
    known = models[digest]
    known.scene.closeness(closeness)
    return getattr(known.trials if stage == TRIED else known.scene, stage)(*arguments)


def _unpacked(payload: bytes) -> Sent:
    version, program, content = pickle.loads(payload)
    if version != __version__:
        raise BladesmithError(f"a worker has bladesmith {__version__}, the models come from {version}.")
    sent: Sent = pickle.loads(content)
    if program != _program_digest(tuple(sent.query.rows)):
        raise BladesmithError(f"a worker has another bladesmith {version} than the one that the models come from.")
    return sent


def _program_digest(kinds: tuple[str, ...]) -> str:
    """What tells the formulas of two installations apart."""
    return sha256(reform_program(in_order(kinds)).source.encode()).hexdigest()


__all__ = ["Sent", "work"]
