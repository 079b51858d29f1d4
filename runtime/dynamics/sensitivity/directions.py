"""Sensitivities that a user asks for by name, as directions for the compiled driver.

It carries a tangent of the motion along each; all derivatives are exact, none is a difference.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..codegen.errors import InputError, suggest
from .assembly import Assembly
from .constraints import VirtualPower
from .functions import arity
from .given import several, shown
from .parameters import Directions, Parameters

_COMPONENT = re.compile(r"^(.*)\[(\d+)\]$")


@dataclass
class Asked:
    """The parameters that a user named, and where each stands among the directions."""

    places: dict[str, slice]
    directions: Directions


def given_names(value: Any) -> tuple[str, ...]:
    """Names of parameters as a user gives them: one or several, each once.

    Raises
    ------
    InputError
        If one is no name.
    """
    names = several(value, str, "the sensitivities")
    for i, name in enumerate(names):
        if not isinstance(name, str):
            raise InputError(f"sensitivities[{i}] is {shown(name)}; a parameter is asked for by name.")
    return tuple(dict.fromkeys(names))


def check_refused(**options: bool) -> None:
    """Raise `InputError` for options of a run that do not go with sensitivities."""
    if given := [name for name, value in options.items() if value]:
        raise InputError(
            f"sensitivities do not go together with {' and '.join(given)}: they are those of a start that obeys its "
            "constraints, at fixed times, computed in this process.",
            remedy=f"Leave out {' and '.join(f'{name}=' for name in given)}",
        )


def directions_of(made: Assembly, loads: Sequence[Any], names: Sequence[str], duration: float) -> Asked:
    """Directions of parameters by name.

    Raises
    ------
    InputError
        If there is no such parameter, or the motion depends on what cannot be differentiated.
    """
    _check_functions(made)
    known = Parameters(made, loads, duration).by_name()
    places: dict[str, slice] = {}
    parts: list[Directions] = []
    for name in names:
        part = _part(name, known)
        begin = sum(x.count for x in parts)
        places[name] = slice(begin, begin + part.count)
        parts.append(part)
    joined = (np.concatenate([getattr(x, field) for x in parts], 1) for field in ("numbers", "start", "sizes"))
    return Asked(places, Directions(*joined))


def _part(name: str, known: Mapping[str, Callable[[], Directions]]) -> Directions:
    if name in known:
        return known[name]()
    match = _COMPONENT.match(name)
    if match and match[1] in known:
        part, j = known[match[1]](), int(match[2])
        if j < part.count:
            return part.component(j)
        count = f"{part.count} components, from 0" if part.count > 1 else "one component, 0"
        raise InputError(f"{match[1]} has {count}: {name!r} is none of them.")
    raise InputError(
        f"{name!r} is no parameter of this simulation.{suggest(name, known)}", remedy=f"There are: {', '.join(known)}"
    )


def _check_functions(made: Assembly) -> None:
    """Functions of time do not vary; of what functions of the state do nothing is known."""
    asked = [c for c in made.constraints if isinstance(c, VirtualPower) and callable(c.wrenches)]
    if made.functions_of_state or any(arity(c.wrenches, "the wrenches") == 3 for c in asked):
        raise InputError(
            "sensitivities go through loads and constraints that are constant or functions of time, not through "
            "functions of the state.",
            remedy="Springs, dampers and gravity are loads of their own",
        )
