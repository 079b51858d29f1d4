"""Parameters of virtual-power constraints as the compiled driver reads them: wrenches and their rates."""

from __future__ import annotations

from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from ...codegen.errors import InputError
from ...common.finite_differences import Differences
from ...mechanics.arguments import coefficients, multivector_of
from ..model.constraints import Function, VirtualPower
from .body_parameters import one_state
from .callbacks import arity
from .data import Assembly, DriverConstraint, item_of

Array = NDArray[Any]


def pack_power(assembly: Assembly, constraint: VirtualPower, body: int, other: int) -> None:
    """Add constant wrenches that have no power."""
    wrenches: Any = constraint.wrenches
    for wrench in list(wrenches) if wrenches.__class__ in (list, tuple) or wrenches.shape else [wrenches]:
        local = ~assembly.frame_motor(other) >> multivector_of(wrench, assembly.algebra, "a wrench")
        packed = DriverConstraint(constraint, "twist", body, other, 1, power=True)
        packed.object_offset = assembly.append(coefficients(local, "twist", "a wrench"))
        packed.target_offset = assembly.append([0.0])
        assembly.driver_constraints.append(packed)


def pack_power_function(
    assembly: Assembly, constraint: VirtualPower, body: int, other: int, duration: float
) -> None:  # fmt: skip
    """Add wrenches that are a function of time or state."""
    if assembly.size > 1:
        raise InputError(
            f"{constraint.label} has a function; that is for one simulation, not for a batch of {assembly.size}."
        )
    wrenches = _WrenchFunction(assembly, constraint, body, other, duration)
    state = np.concatenate([np.ravel(assembly.frames[body].pose.values)[:8], np.zeros(6)])
    for i in range(len(wrenches(0.0, state)[0])):
        packed = DriverConstraint(constraint, "twist", body, other, 1, power=True)

        def one(item: int, t: float, state: Array, i: int = i) -> Array:
            values, rates = wrenches(t, state)
            return np.concatenate([values[i], rates[i], np.zeros(6 + 3 + 1)])

        packed.callback = assembly.callbacks.add(one, constraint.label, 3 * 6 + 3 + 1)
        assembly.driver_constraints.append(packed)


class _WrenchFunction:
    """Wrenches of a function and their rates, (n, 6) each, in the driver's frame; the last value is cached."""

    def __init__(self, assembly: Assembly, constraint: VirtualPower, body: int, other: int, duration: float) -> None:
        self._assembly, self._body = assembly, body
        self._frame = item_of(assembly.frame_motor(other), 0)
        self._function = cast(Function, constraint.wrenches)
        self._count = arity(self._function, "the wrenches")
        self._duration = duration
        self._last: dict[tuple[float, bytes], tuple[Array, Array]] = {}
        self._differences: Differences | None = None

    def __call__(self, t: float, state: Array) -> tuple[Array, Array]:
        key = (t, state.tobytes())
        value = self._last.get(key)  # the driver evaluates each wrench separately
        if value is None:
            value = self._evaluate(t, state)
            self._last.clear()  # another thread may do so too
            self._last[key] = value
        return value

    def _evaluate(self, t: float, state: Array) -> tuple[Array, Array]:
        if self._count == 1:
            value = self._function(t)
        else:
            value = self._function(t, *one_state(self._assembly, self._body, 0, state))
        if isinstance(value, tuple) and len(value) == 2:
            return self._rows(value[0]), self._rows(value[1])
        if self._count != 1:
            raise InputError("wrenches that depend on the state come with their rates: return (T, dT).")
        if self._differences is None:
            self._differences = Differences(lambda t: self._rows(self._function(t)), (0.0, self._duration))
        return self._rows(value), self._differences(t)[1]

    def _rows(self, wrenches: Any) -> Array:
        """Coefficients (n, 6) of wrenches of the world."""
        local = ~self._frame >> multivector_of(wrenches, self._assembly.algebra, "the wrenches")
        return np.atleast_2d(coefficients(local, "twist", "the wrenches"))


__all__ = ["pack_power", "pack_power_function"]
