"""Sensitivities to parameters by name, as directions for the compiled driver.

It integrates a tangent of the motion along each; all derivatives are exact, none is a difference.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from ...codegen.errors import InputError, suggest
from ...common.validation import as_text, as_tuple
from ..assembly.callbacks import arity
from ..assembly.data import Assembly
from ..model.constraints import VirtualPower
from .parameters import Directions, Parameters

_COMPONENT = re.compile(r"^(.*)\[(\d+)\]$")


def as_names(value: Any) -> tuple[str, ...]:
    """Names of parameters without repetition, from one or several.

    Raises
    ------
    InputError
        If one is not a string.
    """
    names = as_tuple(value, "the sensitivities", str)
    return tuple(dict.fromkeys(as_text(name, f"sensitivities[{i}]") for i, name in enumerate(names)))


def directions_of(
    assembly: Assembly, loads: Sequence[Any], names: Sequence[str], duration: float, splits: bool = False
) -> tuple[dict[str, slice], Directions | None]:
    """Directions of parameters by name: the slice of each, and all of them; without names there are none.

    ``splits``: the motion is made of turns about principal axes, which a body must keep.

    Raises
    ------
    InputError
        If there is no such parameter, or the motion depends on what cannot be differentiated.
    """
    if not names:
        return {}, None
    _check_functions(assembly)
    by_name = Parameters(assembly, loads, duration, splits).by_name()
    slices: dict[str, slice] = {}
    parts: list[Directions] = []
    for name in names:
        part = _part(name, by_name)
        begin = sum(x.count for x in parts)
        slices[name] = slice(begin, begin + part.count)
        parts.append(part)
    joined = (np.concatenate([getattr(x, field) for x in parts], 1) for field in ("numbers", "start", "sizes"))
    return slices, Directions(*joined)


def _part(name: str, by_name: Mapping[str, Callable[[], Directions]]) -> Directions:
    """Directions of a parameter, or of one of its components."""
    if name in by_name:
        return by_name[name]()
    match = _COMPONENT.match(name)
    if match and match[1] in by_name:
        part, j = by_name[match[1]](), int(match[2])
        if j < part.count:
            return part.component(j)
        count = f"{part.count} components, from 0" if part.count > 1 else "one component, 0"
        raise InputError(f"{match[1]} has {count}: {name!r} is not among them.")
    raise InputError(
        f"{name!r} is not a parameter of this simulation.{suggest(name, by_name)}",
        remedy=f"There are: {', '.join(by_name)}",
    )


def _check_functions(assembly: Assembly) -> None:
    """Check that loads and constraints do not depend on the state; functions of time do not vary."""
    powers = [c.wrenches for c in assembly.constraints if isinstance(c, VirtualPower) and callable(c.wrenches)]
    if assembly.depends_on_state or any(arity(wrenches, "the wrenches") == 3 for wrenches in powers):
        raise InputError(
            "sensitivities go through loads and constraints that are constant or functions of time, not through "
            "functions of the state.",
            remedy="Springs, gravity, dampers and other drag are loads of their own",
        )
