"""Where the coefficients of a kernel stand in its arguments and results, in the notation that all languages share."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from .unit import Entry, Slot


@dataclass(frozen=True)
class Result:
    """What a kernel returns.

    Attributes
    ----------
    slot : Slot or None
        The only result, a struct or a number; None: a struct of its own with the results of `fields`.
    fields : tuple of Slot
    """

    slot: Slot | None
    fields: tuple[Slot, ...]


def result_of(entry: Entry) -> Result:
    """How a kernel's results are returned."""
    first = entry.outputs[0]
    if len(entry.outputs) == 1 and (first.struct is not None or first.size == 0):
        return Result(first, ())
    return Result(None, entry.outputs)


def places_of(entry: Entry, result: str, name: Callable[[str], str] = str) -> dict[str, Sequence[str]]:
    """Texts of the places of all coefficients, by the array of the kernel's function.

    Parameters
    ----------
    entry : Entry
        A kernel.
    result : str
        The variable that is returned.
    name : callable
        Gives the name of an argument in the language.
    """
    own = result_of(entry)
    found: dict[str, Sequence[str]] = {s.array: _places(s, name(s.array)) for s in entry.inputs}
    for slot in entry.outputs:
        found[slot.array] = _places(slot, result if own.slot else f"{result}.{slot.name}")
    return found


def _places(slot: Slot, name: str) -> list[str]:
    if slot.struct is not None:
        return [f"{name}.{field}" for field in slot.struct.fields]
    return [f"{name}[{k}]" for k in range(slot.size)] if slot.size else [name]
