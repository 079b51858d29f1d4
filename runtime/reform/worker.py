"""What workers of an executor do for a registration: stages of a scene, on models that they keep once sent."""

from __future__ import annotations

import pickle
import threading
from collections import OrderedDict
from dataclasses import dataclass
from hashlib import sha256
from typing import Any

from numpy.typing import NDArray

from ..codegen.programs.reform import in_order, reform_program
from ..codegen.version import __version__
from ..errors import BladesmithError
from .backends import backend_of
from .engine import Closeness, Side

Array = NDArray[Any]
#: Pairs of models that each thread of a worker keeps.
KEPT = 2


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
    """

    backend: str
    threads: int
    query: Side
    reference: Side
    kinds: Array
    rows: Array

    def packed(self) -> bytes:
        """The same as bytes, which are cheap to send many times."""
        program = _program_digest(tuple(self.query.rows))
        return pickle.dumps((__version__, program, pickle.dumps(self)))

    def scene(self) -> Any:
        """What computes with them here."""
        made = backend_of(self.backend)
        return made.scene(self.query, self.reference, self.kinds, self.rows, self.threads)


class _Known(threading.local):
    """Models that this thread keeps: what computes with them has a state, which threads do not share."""

    def __init__(self) -> None:
        self.scenes: OrderedDict[str, Any] = OrderedDict()


_known = _Known()


def work(
    digest: str, payload: bytes | None, closeness: Closeness, stage: str, arguments: tuple[Any, ...], _call: str = ""
) -> tuple[Array, ...] | None:
    """What a worker is called for: a stage of a scene on some of its items; None if it has to be sent the models.

    Clusters take calls with equal arguments for one: the name of the call keeps those of two registrations apart, so
    that neither is cancelled, or fails, with the other.
    """
    scenes = _known.scenes
    if digest not in scenes:
        if payload is None:
            return None
        scenes[digest] = _unpacked(payload).scene()
        while len(scenes) > KEPT:
            scenes.popitem(last=False)
    scenes.move_to_end(digest)
    scene = scenes[digest]
    scene.closeness(closeness)
    found: tuple[Array, ...] = getattr(scene, stage)(*arguments)
    return found


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
