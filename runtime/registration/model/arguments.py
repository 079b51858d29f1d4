"""Validation of arguments of the stages of a registration: models or batches, motors, numbers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ...codegen.errors import InputError
from ...codegen.programs.registration.registration import KINDS
from ...common.validation import as_instance, invalid, positive_float
from ...core.geometry.motors import motors_from
from ...core.multivector import Multivector
from ...core.registry import stock_algebra
from ...objects.arguments import as_objects
from ..result import Registration
from .model import Model
from .parameters import PLURALS

#: Of ``length``: with more, or the inverse of more, costs of positions or those of directions are rounding.
LARGEST_LENGTH = 1e12


def as_length(value: Any) -> float:
    """Length that a rotation by one radian is equivalent to, in units of the models' size.

    Raises
    ------
    InputError
        If it is no positive number, or one that leaves nothing of positions or of directions.
    """
    length = positive_float(value, "length")
    if not 1 / LARGEST_LENGTH <= length <= LARGEST_LENGTH:
        limits = f"{1 / LARGEST_LENGTH:g} to {LARGEST_LENGTH:g}"
        raise InputError(f"length is {length:g} times the models' size; {limits} is possible.")
    return length


def as_model(x: Any, what: str) -> Model:
    """Convert a model, a batch, batches by kind, or a list of objects of any kinds to a model.

    Raises
    ------
    InputError
        If it cannot be converted, or is empty.
    """
    if isinstance(x, list | tuple) and len({o.kind for o in x if isinstance(o, Multivector)}) > 1:
        x = _group_by_kind(x, what)
    if isinstance(x, Mapping):
        names = {name: plural for kind, plural in PLURALS.items() for name in (kind, plural)}
        if unknown := [key for key in x if key not in names]:
            raise InputError(
                f"{what}: {unknown[0]!r} is not a kind of object; there are: {', '.join(PLURALS.values())}."
            )
        given: dict[str, Any] = {names[key]: part for key, part in x.items()}
        model = Model(**given)
    elif isinstance(x, Model):
        model = x
    else:
        batch = as_objects(x, what).reshape(-1)
        kind = next((k for k in KINDS if k == batch.kind.name), None)
        if kind is None:
            raise InputError(f"{what} are of the kind {batch.kind.name}, which models do not contain.")
        single: dict[str, Any] = {PLURALS[kind]: batch}
        model = Model(**single)
    if not len(model):
        raise InputError(f"{what} are empty; a match needs at least one object.")
    return model


def _group_by_kind(objects: Sequence[Any], what: str) -> dict[str, list[Multivector]]:
    """Objects of several kinds by kind, each in their order."""
    groups: dict[str, list[Multivector]] = {}
    for i, x in enumerate(objects):
        kind = as_objects(x, f"{what}[{i}]").kind.name
        if kind not in PLURALS:
            raise InputError(f"{what}[{i}] is of the kind {kind}, which models do not contain.")
        groups.setdefault(kind, []).append(x)
    return groups


def model_pair(query: Any, reference: Any) -> tuple[Model, Model]:
    """Convert two arguments to models that have a kind in common.

    Raises
    ------
    InputError
        If a model is empty, or the models have no kind in common.
    """
    first, second = as_model(query, "the query's objects"), as_model(reference, "the reference's objects")
    check_common_kind(first, second)
    return first, second


def check_common_kind(query: Model, reference: Model) -> None:
    """Raise if two models have no kind of object in common.

    Raises
    ------
    InputError
    """
    if not set(query.counts) & set(reference.counts):
        names = (", ".join(PLURALS[k] for k in model.counts) for model in (query, reference))
        both = {"line", "segment"} <= {*query.counts, *reference.counts}
        raise InputError("the models have no kind of object in common: {} and {}.".format(*names),
                         remedy="Give both as lines, or both as segments" if both else None)  # fmt: skip


def check_same_models(result: Registration, query: Model | None = None, reference: Model | None = None) -> None:
    """Raise if models cannot be those that were registered: the query has as many objects of each kind, the reference
    all that are matched.

    Raises
    ------
    InputError
    """
    for name, value, expected in (
        ("result", result, Registration), ("query", query, Model), ("reference", reference, Model),
    ):  # fmt: skip
        if value is not None or name == "result":
            as_instance(value, f"the {name}", expected, f"a reform.{expected.__name__}")
    matches = {key: rows for key, rows in result.matches.items() if len(rows)}
    query_counts = {key: len(rows) for key, rows in matches.items()}
    needed = {key: int(rows.max()) + 1 for key, rows in matches.items()}
    for model, name in ((query, "query"), (reference, "reference")):
        counts = {} if model is None else {PLURALS[kind]: n for kind, n in model.counts.items()}
        for key in () if model is None else sorted({*query_counts, *counts}, key=list(PLURALS.values()).index):
            have, wanted_count = counts.get(key, 0), (query_counts if model is query else needed).get(key, 0)
            if have < wanted_count or (model is query and have != wanted_count):
                least = "" if model is query else "at least "
                what = f"the {key.replace('_', ' ')} of the models are not those that were registered"
                difference = f"the {name} has {have}, and the result is of {least}{wanted_count}"
                raise InputError(f"{what}: {difference}.", remedy="Give the models that register() was given")


def as_motor(x: Any, name: str) -> Multivector:
    """One motor of `cga3d`, from a motor of cga3d or pga3d, or a matrix (4, 4).

    Raises
    ------
    InputError, ShapeError, AlgebraMismatchError, GradeError, KindError
    """
    motor = motors_from(x, stock_algebra("cga3d"), name).as_kind("motor")
    if motor.shape != ():
        raise invalid(x, name, "one motor")
    if not np.isfinite(motor._data).all():
        raise InputError(f"{name} is not finite, or no rigid motion; one motor is needed.")
    return motor
