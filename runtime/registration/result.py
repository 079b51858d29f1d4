"""What a registration returns."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.lib.mixins import NDArrayOperatorsMixin
from numpy.typing import NDArray

from ..multivector import Multivector

Array = NDArray[Any]


class PerItem(NDArrayOperatorsMixin):
    """One value for each object of a model, by its number over all kinds, or by kind: ``matches["lines"]``.

    Otherwise it is used as the array over all objects, which is not changed: ``matches >= 0``, ``inliers.mean()``.

    Parameters
    ----------
    values : mapping of kind to array (n,)
        In the order of the kinds of a model.
    """

    def __init__(self, values: Mapping[str, Array]) -> None:
        self._values = dict(values)
        self._all = np.concatenate(list(self._values.values())) if self._values else np.empty(0, np.int64)
        self._all.setflags(write=False)

    def __getitem__(self, key: Any) -> Any:
        if isinstance(key, str):
            name = key if key in self._values else key.removesuffix("s")
            if name not in self._values:
                raise KeyError(f"{key}; there are: {', '.join(f'{k}s' for k in self._values)}")
            return self._values[name]
        return self._all[key]

    def __len__(self) -> int:
        return len(self._all)

    def __iter__(self) -> Any:
        return iter(self._all)

    def __array__(self, dtype: Any = None, copy: Any = None) -> Array:
        return np.array(self._all, dtype) if copy is not False else np.asarray(self._all, dtype)

    def __array_ufunc__(self, ufunc: Any, method: str, *given: Any, **options: Any) -> Any:
        if any(isinstance(x, PerItem) for x in options.get("out", ())):
            return NotImplemented
        return getattr(ufunc, method)(*(x._all if isinstance(x, PerItem) else x for x in given), **options)

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_") or not hasattr(np.ndarray, name):
            raise AttributeError(f"a {type(self).__name__} has no attribute {name!r}")
        return getattr(self._all, name)

    def __contains__(self, item: Any) -> bool:
        return item in self._values or item in self.keys() if isinstance(item, str) else bool((self._all == item).any())

    __hash__ = None  # type: ignore[assignment]

    def keys(self) -> list[str]:
        """Kinds, plural."""
        return [f"{kind}s" for kind in self._values]

    def items(self) -> list[tuple[str, Array]]:
        """Kinds, plural, each with its own values."""
        return [(f"{kind}s", values) for kind, values in self._values.items()]

    def __repr__(self) -> str:
        return f"PerItem({', '.join(f'{k}s={v!r}' for k, v in self._values.items())})"


@dataclass(frozen=True)
class Step:
    """What was done: its name, at which tolerance, motors tried so far, objects laid on others, and the cost."""

    name: str
    tolerance: float
    candidates: int
    hits: int
    cost: float


@dataclass(frozen=True)
class Registration:
    """The pose of a query in a reference.

    Attributes
    ----------
    motor : Multivector
        Takes the query to the reference, of a similarity the query that was scaled; <R>_0 >= 0.
    matches : PerItem of int
        For each query object the row of its counterpart among the reference's of the same kind, -1 for none. The
        nearest one counts: objects that the query has twice have the same counterpart.
    inliers : PerItem of bool
        Whether it has one.
    cost : float
        Sum of the positive rotor costs of the matches, in the reference's frame (``center``, ``unit``).
    history : list of Step
    converged : bool
        The pose, or one of ``ambiguous``, is to be believed: chance does not explain it, it stands out against
        motors that contradict it, and the matches leave no motion free. Models of two lines or three points, which
        nothing confirms, never are. See ``message`` and ``doubt``.
    covariance : array (6, 6)
        Of the twist b in exp(b) motor, in the world and on the blades of the kind ``twist`` (e12, e13, e1ni, e23, e2ni,
        e3ni). Scaled for the number of matches, so that b' C^-1 b < 12.59 holds for the true pose with a probability
        of 95 %, if the errors of the matches are independent; how large they are, the matches tell. With fewer than
        about 8 matches the region is very large. NaN if nothing was found.
    ambiguous : list of Multivector
        Other motors that lay about as many objects on others (85 %, less one): those of symmetric models, and of parts
        that the reference has several times. Each pose once, 63 at most. Where more than 24 serve, or what comes next
        is nearly as good, ``converged`` is False.
    undetermined : Multivector, shape (m,)
        Twists, in the reference's world, of motions that the matches leave free, or know no better than a fifth of a
        radian or of the models' size; empty for a determined pose.
    scale : float
        Of a similarity s: a point x goes to motor (s x), scaled about the world's origin. Else 1.
    doubt : float
        log10 of how many motors as good as this one chance alone would give, or, if that is more, of the probability
        of its lead over others, on such a scale that -4 is the limit of both.
    threshold : float
        Distance, in the models' unit of length, up to which objects were matched.
    center, unit : array (3,), float
        Where costs are measured from, and the length that counts as 1.
    message : str
        Why it is not converged, or that it was interrupted; else empty.
    """

    motor: Multivector
    matches: PerItem
    inliers: PerItem
    cost: float
    history: list[Step]
    converged: bool
    covariance: Array
    ambiguous: list[Multivector] = field(default_factory=list)
    undetermined: Multivector | None = None
    scale: float = 1.0
    doubt: float = 0.0
    threshold: float = 0.0
    center: Array = field(default_factory=lambda: np.zeros(3))
    unit: float = 1.0
    message: str = ""
