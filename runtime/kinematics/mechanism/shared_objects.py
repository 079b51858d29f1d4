"""Objects that the bodies of a joint share, as matrices and rows in the frame of a mechanism."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...core.geometry.scaling import in_units
from ...core.multivector import Multivector
from ...mechanics.joints.base import Condition, Joint
from ...mechanics.motion_closed_kinds import layout_of, matrix_of, on_layout
from ...mechanics.twists import commutator_matrix
from .structure import Assembly

Array = NDArray[Any]


@dataclass(frozen=True)
class SharedObjects:
    """Objects that the bodies of a joint share, in the mechanism's frame and unit.

    Attributes
    ----------
    layouts : tuple of str
    coefficients : list of array (k,)
    matrices : list of array (m, k)
        Linear functions A with B(X, Y) = A Y; identities where the objects are one.
    rates : list of array (m, 6)
        Rates of the conditions for unit twists.
    varying : bool
    """

    layouts: tuple[str, ...]
    coefficients: list[Array]
    matrices: list[Array]
    rates: list[Array]
    varying: bool


def shared_objects(mechanism: Assembly, joint: Joint) -> SharedObjects:
    """The objects of a joint."""
    conditions = joint.conditions()
    parts = [_object(mechanism, joint, c) for c in conditions]
    varying = any(c.product is not None for c in conditions)
    return SharedObjects(
        tuple(p[0] for p in parts), [p[1] for p in parts], [p[2] for p in parts], [p[3] for p in parts], varying
    )


def _object(mechanism: Assembly, joint: Joint, c: Condition) -> tuple[str, Array, Array, Array]:
    algebra, frame = mechanism.algebra, mechanism.frame
    away = ~algebra.translator(frame.center)

    def in_frame(x: Multivector) -> Multivector:
        local = in_units(away >> x, frame.unit)
        return local / float(np.abs(local.values).max())

    y = in_frame(c.y)
    layout = layout_of([y], joint.label)
    if c.product is None:
        matrix = np.eye(algebra.kind(layout).size)
    else:
        product, x = c.product, in_frame(c.x)
        matrix = matrix_of(lambda v: product(x, v), algebra, layout, joint.label)
    rates = matrix @ commutator_matrix(y, layout)
    size = np.linalg.norm(rates)
    return layout, on_layout(y, layout), matrix / size, rates / size
