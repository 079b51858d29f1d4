"""Results of registrations: values per object, steps, the registration itself."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.lib.mixins import NDArrayOperatorsMixin
from numpy.typing import NDArray

from ..core.multivector import Multivector
from ..status import Status
from .estimation.gauge_freedom import generators
from .summary import deviations, summary

Array = NDArray[Any]


class PerItem(NDArrayOperatorsMixin):
    """One value for each object of a model, by its index over all kinds, or by kind: ``matches["lines"]``.

    In other respects it is a read-only array over all objects: ``matches >= 0``, ``inliers.mean()``.

    Parameters
    ----------
    values : mapping of kind to array (n,)
        Values in the order of the kinds of a model.
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
        """Kinds, plural, each with its values."""
        return [(f"{kind}s", values) for kind, values in self._values.items()]

    def __repr__(self) -> str:
        return f"PerItem({', '.join(f'{k}s={v!r}' for k, v in self._values.items())})"


@dataclass(frozen=True)
class Step:
    """A step of a registration: its name, tolerance, number of motors tried so far, number of inliers, and cost."""

    name: str
    tolerance: float
    candidates: int
    hits: int
    cost: float

    def __str__(self) -> str:
        return f"{self.hits} objects within {self.tolerance:.2g} of the size"


@dataclass(frozen=True)
class Registration:
    """The pose of a query in a reference.

    Attributes
    ----------
    motor : Multivector
        Motor from the query to the reference (for a similarity: from the scaled query), with <R>_0 >= 0.
    matches : PerItem of int
        Row of each query object's counterpart among the reference's objects of the same kind, -1 for none. The
        counterpart is the nearest one: duplicates in the query have the same counterpart.
    inliers : PerItem of bool
        True for each query object that has a counterpart.
    cost : float
        Sum of the positive rotor costs of the matches, in the reference's frame (``center``, ``unit``).
    history : list of Step
    converged : bool
        True if the pose, or one of ``ambiguous``, is reliable: it is significant, clearly better than motors that
        contradict it, and the matches leave no motion free. Models of two lines or three points are never significant:
        no further object confirms their pose. See ``message`` and ``doubt``.
    covariance : array (6, 6)
        Covariance of the twist b in exp(b) motor, in the world and on the blades of the kind ``twist`` (e12, e13, e1ni,
        e23, e2ni, e3ni). Scaled for the number of matches, so that b' C^-1 b < 12.59 holds for the true pose with a
        probability of 95 %, if the errors of the matches are independent; their size is estimated from the matches.
        Where fewer than about 8 matches carry the cost, the region holds the true pose and is very large: of few
        matches, or of small circles among lines and planes, unless models have covariances. NaN without a pose.
    ambiguous : list of Multivector
        Other motors with about as many inliers (85 %, less one): those of symmetric models, and of parts that the
        reference has several times. Each pose once, 63 at most. If more than 24 are equivalent, or the next best one
        is nearly as good, ``converged`` is False.
    undetermined : Multivector, shape (m,)
        Twists, in the reference's world, of motions that the matches leave free, or determine no better than to a fifth
        of a radian or of the models' size; empty for a determined pose.
    scale : float
        Scale s of a similarity: a point x goes to motor (s x), scaled about the world's origin. Else 1.
    doubt : float
        log10 of the expected number of false alarms: of motors that are as good as this one by chance. Or, if that is
        more, of the probability of its lead over others, scaled so that -4 is the limit of both.
    threshold : float
        Largest distance of a match, in the models' unit of length.
    center, unit : array (3,), float
        Origin and unit of length of costs.
    message : str
        Reason why it has not converged, or "interrupted"; else empty.
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

    def __str__(self) -> str:
        return summary(self)

    @property
    def pose_covariance(self) -> Array:
        """Covariance (6, 6) of a small motion in the world after the pose: its rotation vector, in radians, then its
        translation, in the models' unit."""
        rows = np.linalg.inv(generators(self.motor.algebra))  # a twist as rotation vector and translation of the origin
        return np.asarray(rows.T @ self.covariance @ rows)

    @property
    def deviations(self) -> tuple[float, float]:
        """The worst standard deviations: of the rotation, in radians, and of ``center``, in the models' unit."""
        return deviations(self)

    @property
    def status(self) -> Status:
        """OK; NOT_UNIQUE: one of the ``ambiguous`` poses, or motions are left free; NOT_CONVERGED: not reliable."""
        if self.ambiguous or (self.undetermined is not None and self.undetermined.size):
            return Status.NOT_UNIQUE
        return Status.OK if self.converged else Status.NOT_CONVERGED
