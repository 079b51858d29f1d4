"""Simulations of a ball, and errors of one line that refuse what they are given."""

from __future__ import annotations

import warnings
from typing import Any

import pytest

from bladesmith import cga3d, dynamics
from bladesmith.errors import (
    BladesmithError,
)

TIP = cga3d.point([0.0, 0, 0.5])
PLANE = cga3d.plane([0.0, 0, 1], 0.5)
WRENCH = dynamics.wrench([0.0, 0, 1], [0.1, 0, 0])
GRAVITY = dynamics.Gravity([0.0, 0, -9.81])
SHORT = 0.01


def ball(**options: Any) -> Any:
    return dynamics.RigidBody(1.0, [1.0, 2.0, 2.5], **options)


def simulation(*acting: Any, **options: Any) -> Any:
    return dynamics.Simulation(ball(), *acting, **options)


def refused(make: Any, says: str, kind: type[BladesmithError] = BladesmithError) -> BladesmithError:
    """The error, of one line, without a warning on the way."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(kind) as error:
            make()
    assert says in str(error.value) and "\n" not in str(error.value)
    return error.value


def failing(*given: Any) -> Any:
    raise ZeroDivisionError("oh")
