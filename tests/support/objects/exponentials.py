"""Bivectors at 40 digits, and errors of exponentials against power series."""

import math
from functools import cache
from itertools import product
from typing import Any

import numpy as np

from bladesmith.codegen.algebra.algebra import Algebra, Kind
from bladesmith.codegen.algebra.multivector import Multivector
from bladesmith.codegen.api import KernelFunction
from bladesmith.codegen.rings.protocol import PrecisionRing

from ..formulas import Array, multivector, precise, rows, series_exp, stock
from ..vectors import unit

PRECISE = PrecisionRing(40)
#: The bar: exp(log(R)) and sqrt(R)^2 to this, on the scale of what was read and written.
ROUND_TRIP = 1e-14
ANGLES = (0, 1e-16, 1e-12, 1e-8, 1e-3, 1, math.pi - 1e-9, math.pi, 2 * math.pi - 1e-3, 2 * math.pi - 1e-9)
DILATIONS = (0, 1e-16, 1e-8, 0.1, 5)
SHIFTS = (0, 1e-9, 1, 1e3)
CGA = stock("cga3d")
BIVECTOR, EVEN = CGA.kind("bivector"), CGA.kind("even")


@cache
def compiled(formula: Any, kind: Kind) -> KernelFunction:
    return KernelFunction(formula, (kind,), None, formula.__name__, CGA)


def on_numbers(formula: Any, kind: Kind, values: Any, out: Kind) -> tuple[Array, Array]:
    """The formula itself on NumPy: its value on a kind's blades, and its statuses."""
    result = formula(multivector(kind, values))
    value, status = result if isinstance(result, tuple) else (result, None)
    lead = np.shape(values)[:-1]
    found = np.broadcast_to(rows(out, value), (*lead, out.size))
    codes = np.zeros(lead) if status is None else np.broadcast_to(np.asarray(status.value.scalar()), lead)
    return found, codes


def series_error(kind: Kind, b: Array, target: Kind, r: Array) -> float:
    """|exp(b) - r| on the scale of both."""
    exact = target.values(series_exp(precise(kind, b, PRECISE)))
    return max(abs(float(e - float(v))) for e, v in zip(exact, r, strict=True)) / scale(b, r)


def square_error(kind: Kind, root: Array, r: Array) -> float:
    """|root^2 - r| on the scale of both."""
    x = precise(kind, root, PRECISE)
    exact = kind.values(x * x)
    return max(abs(float(e - float(v))) for e, v in zip(exact, r, strict=True)) / scale(root**2, r)


def scale(a: Array, b: Array) -> float:
    return float(max(np.abs(a).max(), np.abs(b).max()))


def largest(errors: list[float], what: list[Any]) -> float:
    i = int(np.argmax(errors))
    print(f"{errors[i]:.2e} at {what[i]}")
    return errors[i]


class Space:
    """CGA or PGA at 40 digits: what the bivectors under test are made of."""

    def __init__(self, algebra: Algebra) -> None:
        self.one = Multivector(algebra, PRECISE, {0: PRECISE.context.mpf(1)})
        self.null = self.one.basis("ni" if "ni" in algebra.vectors else "e0")
        self.i3 = self.one.basis("e123")

    def number(self, x: float) -> Multivector:
        return self.one.new({0: PRECISE.context.mpf(float(x))})

    def vector(self, v: Any) -> Multivector:
        return self.one.sum(self.number(c) * self.one.basis(f"e{i + 1}") for i, c in enumerate(v))

    def translator(self, t: Any) -> Multivector:
        return 1 - self.vector(t) * self.null / 2

    def screw(self, angle: float, axis: Any, shift: Any, centre: Any) -> Multivector:
        """Rotation about an axis through a centre, plus any translation."""
        t = self.translator(centre)
        return t * (self.vector(axis) * self.i3 * self.number(-angle / 2)) * ~t - self.vector(shift) * self.null / 2

    def scaling(self, g: float, centre: Any) -> Multivector:
        t = self.translator(centre)
        return t * (self.null ^ self.one.basis("no")) * ~t * self.number(-g / 2)


@cache
def similarities() -> tuple[list[Any], Array]:
    """Every angle with every dilation, translations along and across the axis, centres near and far."""
    rng, space, cases, values = np.random.default_rng(7), Space(CGA), [], []
    for k, (angle, g) in enumerate(product(ANGLES, DILATIONS)):
        for j in (k % 4, (k + k // 4 + 1 + k % 3) % 4):
            shift = SHIFTS[j]
            axis = np.array([0.0, 0.0, 1.0]) if (j + k) % 3 == 0 else unit(rng.normal(size=3))
            across = unit(np.cross(axis, rng.normal(size=3)))
            distance = (0, 1, 1e3)[(k + 2 * j) % 3]
            centre = unit(rng.normal(size=3)) * distance
            b = space.screw(angle, axis, (axis, across)[(j + k) % 2] * shift, centre) + space.scaling(g, centre)
            cases.append((angle, g, shift, distance, axis.tolist()))
            values.append([float(v) for v in BIVECTOR.values(b)])
    return cases, np.array(values)
