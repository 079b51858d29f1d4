"""What users hand to the stages of a registration, checked: models or plain batches, motors, numbers."""

from __future__ import annotations

import math
from collections.abc import Mapping
from operator import index
from typing import Any

from ..codegen.errors import InputError
from ..codegen.programs.reform import KINDS
from ..multivector import Multivector
from ..objects.inputs import as_objects, number
from .model import Model
from .parameters import PLURALS


def as_model(x: Any, what: str) -> Model:
    """A model of a model, of a plain batch, or of batches by kind.

    Raises
    ------
    InputError
        If it is none, or empty.
    """
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


def both(query: Any, reference: Any) -> tuple[Model, Model]:
    """Two models that have a kind in common.

    Raises
    ------
    InputError
        If a model is empty, or they have none.
    """
    first, second = as_model(query, "the query's objects"), as_model(reference, "the reference's objects")
    if not set(first.counts) & set(second.counts):
        names = (", ".join(PLURALS[k] for k in model.counts) for model in (first, second))
        raise InputError("the models have no kind of object in common: {} and {}.".format(*names))
    return first, second


def positive(value: Any, name: str) -> float:
    """A positive finite number.

    Raises
    ------
    InputError
    """
    found = number(value, name)
    if not 0 < found < math.inf:
        raise InputError(f"{name} is {found:g}; a positive number is needed.")
    return found


def count(value: Any, name: str) -> int:
    """A positive whole number.

    Raises
    ------
    InputError
    """
    try:
        found = index(value)
    except TypeError:
        found = 0
    if found < 1 or isinstance(value, bool):
        raise InputError(f"{name} is {value!r}; a positive whole number is needed.")
    return found


def as_motor(x: Any, name: str) -> Multivector:
    """One motor of `cga3d`.

    Raises
    ------
    InputError
    """
    if not isinstance(x, Multivector) or "ni" not in x.algebra.vectors or x.shape != ():
        raise InputError(f"{name} is {type(x).__name__}; one motor of cga3d is needed.")
    return x.as_kind("motor")
