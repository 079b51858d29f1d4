"""How certain the objects of a model are: relative weights, or covariances of their parameters."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.errors import InputError
from ...common.validation import real_array, short_repr
from .parameters import LARGEST, PLURALS, SIZES, row_jacobian

Array = NDArray[np.float64]
#: Rounding of covariances: of their symmetry, and of variances that are not negative, relative to the largest.
ROUNDING = 1e-9
#: Kinds of two positions, whose covariances may be given for each end: (n, 2, 3, 3).
TWO_ENDS = ("point_pair", "segment")


@dataclass(frozen=True)
class Uncertainty:
    """Weights, or covariances, by kind; neither for objects that are equally certain.

    Attributes
    ----------
    weights : mapping of kind to array (n,)
        Inverse variances, but for a common factor: of every kind, or of none.
    covariances : mapping of kind to array (n, k, k)
        Covariances of the parameters, directions having length 1: of every kind, or of none.
    """

    weights: Mapping[str, Array] = field(default_factory=dict)
    covariances: Mapping[str, Array] = field(default_factory=dict)

    def __bool__(self) -> bool:
        return bool(self.weights or self.covariances)

    def select(self, parts: Mapping[str, Any]) -> Uncertainty:
        """Those of some objects, by masks, indices or slices of kinds."""
        return self._map(lambda kind, values: values[parts[kind]], parts)

    def transformed(self, scale: float, rotation: Array, translation: Array) -> Uncertainty:
        """Those of objects that are moved: x -> scale rotation x + translation."""

        def move(kind: str, covariances: Array) -> Array:
            jacobian = row_jacobian(kind, scale, rotation, translation)
            return np.asarray(jacobian @ covariances @ jacobian.T)

        moved = {kind: move(kind, part) for kind, part in self.covariances.items()}
        return Uncertainty(self.weights, moved)

    def _map(self, change: Callable[[str, Array], Array], kinds: Mapping[str, Any]) -> Uncertainty:
        parts = ({k: change(k, x) for k, x in part.items() if k in kinds} for part in (self.weights, self.covariances))
        return Uncertainty(*parts)


def validated_uncertainty(weights: Any, covariances: Any, counts: Mapping[str, int]) -> Uncertainty:
    """Weights or covariances of objects, as `Model` takes them.

    Raises
    ------
    InputError
    """
    if weights is not None and covariances is not None:
        remedy = "Give covariances alone: an object of half the covariance weighs twice as much"
        raise InputError("weights and covariances are both given.", remedy=remedy)
    if weights is not None:
        return Uncertainty(weights=_weights(weights, counts))
    return Uncertainty(covariances={} if covariances is None else _covariances(covariances, counts))


def _by_kind(given: Any, counts: Mapping[str, int], what: str) -> dict[str, Any]:
    """What is given for kinds, by their names."""
    names = {name: kind for kind, plural in PLURALS.items() for name in (kind, plural)}
    for key in given:
        if key not in names or names[key] not in counts:
            there = ", ".join(PLURALS[kind] for kind in counts) or "none"
            missing = f"{what} are given for {short_repr(key)}, which the model does not have"
            raise InputError(f"{missing}; there are: {there}.")
    return {names[key]: part for key, part in given.items()}


def _weights(given: Any, counts: Mapping[str, int]) -> dict[str, Array]:
    if not isinstance(given, Mapping):
        array = _numbers(given, "weights", (sum(counts.values()),))
        ends = np.cumsum(list(counts.values()))[:-1]
        found = dict(zip(counts, np.split(array, ends), strict=True))
    else:
        parts = _by_kind(given, counts, "weights")
        found = {k: _numbers(parts.get(k, 1.0), f"weights[{PLURALS[k]!r}]", (n,)) for k, n in counts.items()}
    rule = "a weight is positive, or zero for an object that does not count"
    for kind, values in found.items():
        _check_each(values >= 0, values, f"the weight of {PLURALS[kind]}", rule)
    if counts and not any(values.any() for values in found.values()):
        raise InputError("the weights are all zero: no object counts.", remedy="Give positive ones")
    return found


def _covariances(given: Any, counts: Mapping[str, int]) -> dict[str, Array]:
    if not isinstance(given, Mapping):
        if len(counts) != 1:
            raise InputError(f"covariances are an array, and the model has {len(counts)} kinds of object.",
                             remedy="Give a mapping of kinds to arrays")  # fmt: skip
        given = {next(iter(counts)): given}
    parts, found = _by_kind(given, counts, "covariances"), {}
    for kind, n in counts.items():
        if kind not in parts:
            raise InputError(f"covariances are given, but not of the model's {PLURALS[kind].replace('_', ' ')}.",
                             remedy="Give them for all kinds, or weights")  # fmt: skip
        found[kind] = _covariances_of(parts[kind], kind, n)
    return found


def _covariances_of(given: Any, kind: str, n: int) -> Array:
    name, k = f"covariances[{PLURALS[kind]!r}]", SIZES[kind]
    array = np.asarray(real_array(given, name), np.float64)
    if kind in TWO_ENDS and array.shape[-3:] == (2, 3, 3):
        ends, array = array, np.zeros((*array.shape[:-3], k, k))
        array[..., :3, :3], array[..., 3:, 3:] = ends[..., 0, :, :], ends[..., 1, :, :]
    array = _numbers(array, name, (n, k, k))
    for bad, rule in (
        (np.abs(array - array.swapaxes(1, 2)).max((1, 2), initial=0) > ROUNDING * _largest(array), "is not symmetric"),
        (_largest(array) == 0, "is zero; an object that is exact has no covariance, and its model none"),
        (np.linalg.eigvalsh(array)[:, 0] < -ROUNDING * _largest(array), "has a negative variance along some direction"),
    ):
        if bad.any():
            raise InputError(f"the covariance of {PLURALS[kind]}[{int(bad.argmax())}] {rule}.")
    return np.asarray((array + array.swapaxes(1, 2)) / 2)


def _largest(matrices: Array) -> Array:
    return np.asarray(np.abs(matrices).max((1, 2), initial=0))


def _numbers(given: Any, name: str, shape: tuple[int, ...]) -> Array:
    """Finite numbers of a shape; a single item is that of all."""
    array = np.asarray(real_array(given, name), np.float64)
    if array.shape not in (shape, shape[1:]):
        raise InputError(f"{name} has shape {array.shape}; {shape} is needed, or {shape[1:]} for all.")
    array = np.array(np.broadcast_to(array, shape))
    _check_each(np.abs(array.reshape(len(array), -1)).max(1, initial=0) <= LARGEST, array, name,
                f"numbers are finite, and go to {LARGEST:g}")  # fmt: skip
    return array


def _check_each(good: NDArray[np.bool_], values: Array, name: str, rule: str) -> None:
    if not good.all():
        i = int((~good).argmax())
        raise InputError(f"{name}[{i}] is {values[i].tolist()}; {rule}.")
