"""Derivatives of algorithms from differences of their text with many digits."""

from __future__ import annotations

from typing import Any

import mpmath
import numpy as np

DIGITS = 60


def precise() -> Any:
    """Numbers of many digits."""
    context = mpmath.mp.clone()
    context.dps = DIGITS
    return context


def flat(found: Any) -> Any:
    """All numbers of one item's results."""
    items = found if isinstance(found, tuple) else (found,)
    return np.concatenate([np.ravel(np.asarray(v, dtype=object)) for v in items])


def differences(function: Any, item: Any, directions: dict[str, Any], context: Any) -> Any:
    """Central differences of the text with many digits."""
    names = [p.name for p in function.text.parameters if p.access != "out"]
    h = context.mpf(10) ** -20

    def moved(sign: int) -> Any:
        arguments = []
        for name, value in zip(names, item, strict=True):
            if name in directions:
                values, steps = np.asarray(value, object), np.asarray(directions[name], object)
                moved_value = np.empty(values.shape, object)
                for k in np.ndindex(values.shape):
                    moved_value[k] = context.mpf(float(values[k])) + sign * h * context.mpf(float(steps[k]))
                value = moved_value if values.ndim else moved_value[()]
            arguments.append(value)
        return flat(function.reference(*arguments, numbers=context))

    return [float(v) for v in (moved(1) - moved(-1)) / (2 * h)]
