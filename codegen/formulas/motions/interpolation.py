"""Direct linear interpolation of objects and its rate (thesis 3.3 to 3.5): sums, projected to the blade manifold."""

from __future__ import annotations

from ...algebra.multivector import Multivector, select
from ...trace.derivatives import derivative_formula
from ...trace.outputs import Result, named
from ..objects.blades import (
    Checked,
    cases_of_sum,
    checked_sum,
    project_far_sum,
    project_sum,
    project_to_blade,
    written_size,
)
from ..products.outcome import NOISE, epsilon
from ..products.sizes import product_sizes, sizes


def interpolant(x1: Multivector, x2: Multivector, alpha: Multivector) -> Multivector:
    """S (alpha x1 + (1 - alpha) x2): alpha = 1 is the first object."""
    return project_to_blade(alpha * x1 + (1 - alpha) * x2)


def interpolate(x1: Multivector, x2: Multivector, alpha: Multivector) -> Checked:
    """The interpolant with its status (`blades.project_sum`); points go along the segment between them (3.1)."""
    a, b = alpha * x1, (1 - alpha) * x2
    return project_sum(a + b, written_size(a, b))


def interpolate_far(x1: Multivector, x2: Multivector, alpha: Multivector, distance: Multivector) -> Checked:
    """`interpolate` in coordinates about a local origin: ``distance`` is how far away the objects were given."""
    a, b = alpha * x1, (1 - alpha) * x2
    return project_far_sum(a + b, written_size(a, b), distance)


def interpolate_rate(x1: Multivector, x2: Multivector, alpha: Multivector) -> Checked:
    """Derivative of the interpolant with respect to alpha, generated from `interpolant`; its statuses."""
    return _rate(x1, x2, alpha, None)


def interpolate_far_rate(x1: Multivector, x2: Multivector, alpha: Multivector, distance: Multivector) -> Checked:
    """`interpolate_rate` in coordinates about a local origin."""
    return _rate(x1, x2, alpha, distance)


def _rate(x1: Multivector, x2: Multivector, alpha: Multivector, distance: Multivector | None) -> Checked:
    (rate,) = derivative_formula(interpolant, ["x1", "x2", "alpha"], "alpha", is_scalar=True)(x1, x2, alpha)
    a, b = alpha * x1, (1 - alpha) * x2
    return checked_sum(a + b, cases_of_sum(a + b, written_size(a, b), distance), rate.value)


def orientation(x1: Multivector, x2: Multivector) -> Result:
    """-1 where gamma <x1 x2>_0 < 0 with gamma = x1^2, else +1; rounding noise is no sign. Points have none: +1."""
    product = -x1.scalar_product(~x2)
    one = x1.constant(1)
    if x1.grades == (1,):
        return named("orientation", one)
    noise = NOISE * epsilon(x1) * product_sizes(sizes(x1), sizes(x2))[1]
    return named("orientation", select(product < -noise, -one, one))
