"""What users hand to the stages of a registration, checked: models or plain batches, motors, numbers."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from operator import index
from typing import Any

import numpy as np

from ..codegen.errors import InputError
from ..codegen.programs.reform import KINDS
from ..multivector import Multivector
from ..objects.inputs import as_objects, number
from .model import Model
from .parameters import PLURALS
from .result import Registration


def as_model(x: Any, what: str) -> Model:
    """A model of a model, of a plain batch, of batches by kind, or of a list of objects of any kinds.

    Raises
    ------
    InputError
        If it is none, or empty.
    """
    if isinstance(x, list | tuple) and len({o.kind for o in x if isinstance(o, Multivector)}) > 1:
        x = _by_kind(x, what)
    if isinstance(x, Mapping):
        names = {name: plural for kind, plural in PLURALS.items() for name in (kind, plural)}
        if unknown := [key for key in x if key not in names]:
            raise InputError(f"{what}: {unknown[0]!r} is no kind of object; there are: {', '.join(PLURALS.values())}.")
        given: dict[str, Any] = {names[key]: part for key, part in x.items()}
        model = Model(**given)
    elif isinstance(x, Model):
        model = x
    else:
        batch = as_objects(x, what).reshape(-1)
        kind = next((k for k in KINDS if k == batch.kind.name), None)
        if kind is None:
            raise InputError(f"{what} are a {batch.kind.name}, which is no kind of a model.")
        single: dict[str, Any] = {PLURALS[kind]: batch}
        model = Model(**single)
    if not len(model):
        raise InputError(f"{what} are empty; there is nothing to match.")
    return model


def _by_kind(objects: Sequence[Any], what: str) -> dict[str, list[Multivector]]:
    """Objects of several kinds, those of each kind in their order."""
    found: dict[str, list[Multivector]] = {}
    for i, x in enumerate(objects):
        kind = as_objects(x, f"{what}[{i}]").kind.name
        if kind not in PLURALS:
            raise InputError(f"{what}[{i}] is a {kind}, which is no kind of a model.")
        found.setdefault(kind, []).append(x)
    return found


def both(query: Any, reference: Any) -> tuple[Model, Model]:
    """Two models that have a kind in common.

    Raises
    ------
    InputError
        If a model is empty, or they have none.
    """
    first, second = as_model(query, "the query's objects"), as_model(reference, "the reference's objects")
    check_common(first, second)
    return first, second


def check_common(query: Model, reference: Model) -> None:
    """Whether two models have a kind of object in common.

    Raises
    ------
    InputError
    """
    if not set(query.counts) & set(reference.counts):
        names = (", ".join(PLURALS[k] for k in model.counts) for model in (query, reference))
        raise InputError("the models have no kind of object in common: {} and {}.".format(*names))


def check_belongs(result: Registration, query: Model | None = None, reference: Model | None = None) -> None:
    """Whether models may be those that were registered: as many objects of each kind in the query, and in the
    reference all that matches name.

    Raises
    ------
    InputError
    """
    for name, value, wanted in (
        ("result", result, Registration), ("query", query, Model), ("reference", reference, Model),
    ):  # fmt: skip
        if not isinstance(value, wanted) and (value is not None or name == "result"):
            raise InputError(f"the {name} is a {type(value).__name__}; a reform.{wanted.__name__} is needed.")
    matches = {key: rows for key, rows in result.matches.items() if len(rows)}
    known = {key: len(rows) for key, rows in matches.items()}
    needed = {key: int(rows.max()) + 1 for key, rows in matches.items()}
    for model, name in ((query, "query"), (reference, "reference")):
        counts = {} if model is None else {PLURALS[kind]: n for kind, n in model.counts.items()}
        for key in () if model is None else sorted({*known, *counts}, key=list(PLURALS.values()).index):
            have, wanted_count = counts.get(key, 0), (known if model is query else needed).get(key, 0)
            if have < wanted_count or (model is query and have != wanted_count):
                least = "" if model is query else "at least "
                what = f"the {key.replace('_', ' ')} of the models are not those that were registered"
                told = f"the {name} has {have}, and the result is of {least}{wanted_count}"
                raise InputError(f"{what}: {told}.", remedy="Give the models that register() was given")


def positive(value: Any, name: str) -> float:
    """A positive finite number.

    Raises
    ------
    InputError
    """
    if isinstance(value, bool | np.bool_ | str | bytes):
        raise InputError(f"{name} is {value!r}; a positive number is needed.")
    found = number(value, name)
    if not 0 < found < math.inf:
        raise InputError(f"{name} is {found:g}; a positive number is needed.")
    return found


def count(value: Any, name: str, least: int = 1, most: int | None = None) -> int:
    """A positive whole number, or one that is not less than ``least``, nor more than ``most``.

    Raises
    ------
    InputError
    """
    try:
        found = index(value)
    except TypeError:
        found = least - 1
    if found < least or isinstance(value, bool) or (most is not None and found > most):
        wanted = "a positive whole number" if least == 1 else f"a whole number of at least {least}"
        wanted = wanted if most is None else f"a whole number from {least} to {most}"
        raise InputError(f"{name} is {value!r}; {wanted} is needed.")
    return found


def as_motor(x: Any, name: str) -> Multivector:
    """One motor of `cga3d`.

    Raises
    ------
    InputError
    """
    if not isinstance(x, Multivector) or "ni" not in x.algebra.vectors or x.shape != ():
        raise InputError(f"{name} is {type(x).__name__}; one motor of cga3d is needed.")
    found = x.as_kind("motor")
    if not np.isfinite(found._data).all():
        raise InputError(f"{name} is not finite; one motor of cga3d is needed.")
    return found
