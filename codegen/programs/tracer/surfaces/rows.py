"""Rows of numbers of surfaces along curves and of rays on them: where their parts are, and their kernels."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

from ... import KernelSpec


class Span(NamedTuple):
    """Where a part of a row of numbers begins and ends."""

    begin: int
    end: int


def spans(layout: Iterable[tuple[str, int]]) -> dict[str, Span]:
    """Parts of a row that follow each other, from their names and lengths."""
    found, first = {}, 0
    for name, size in layout:
        found[name] = Span(first, first + size)
        first += size
    return found


class CircleRows(NamedTuple):
    """The rows that finders take, and their kernels.

    Attributes
    ----------
    label : str
        Of the kind of surface.
    meets, origin, direction, shared : Span
        Of a ray with controls and products; of the ray itself, in the frame, for bounds on errors only; room for the
        polynomial of circles that lie on one sphere.
    unit, radius : int
        Places in the surface's row of constants: length of the frame's unit, radius of the sphere around it.
    bound, spans, norm, kappa, controls, products, sizes : Span
        Of the row of constants; the sphere's radius is the last number of `bound`.
    degree, squares : int
        Of the curve and of Q.
    printed : int
        Degree of the printed polynomial.
    ends_at_one : bool
        Whether the last sample is exactly 1.
    """

    label: str
    meets: Span
    origin: Span
    direction: Span
    shared: Span
    unit: int
    radius: int
    bound: Span
    spans: Span
    norm: Span
    kappa: Span
    controls: Span
    products: Span
    sizes: Span
    degree: int
    squares: int
    printed: int
    ends_at_one: bool
    polynomial: KernelSpec
    condition: KernelSpec
    rate: KernelSpec
    condition_bound: KernelSpec
    polynomial_bound: KernelSpec
    shared_meets: KernelSpec
    shared_polynomial: KernelSpec
    shared_condition: KernelSpec
    shared_condition_bound: KernelSpec
    shared_bound: KernelSpec
    published_polynomial: KernelSpec
    meet: KernelSpec
    square_term: KernelSpec
    kappa_term: KernelSpec
    product_term: KernelSpec
    sizes_of: KernelSpec
    nearest: KernelSpec
    approach: KernelSpec
    ray: KernelSpec
    point: KernelSpec
    sphere: KernelSpec
    polish: KernelSpec
    normal: KernelSpec


class PairRows(NamedTuple):
    """The rows that finders take, and their kernels.

    Attributes
    ----------
    label : str
        Of the kind of surface.
    pairs : int
        Coefficients of B, at the beginning of the meets; those of E follow.
    meets, other, written, other_kappa : Span
        Of a ray: coefficients of the meets, which f is made of; room for what p is made of, which is something else
        where E vanishes, and for absolute values of the meets with what rounding may have added to them.
    unit, radius : int
        Places in the surface's row of constants: length of the frame's unit, radius of the sphere around it.
    bound, spans, norm, kappa, controls, products, sizes, levers : Span
        Of the row of constants; the sphere's radius is the last number of `bound`.
    weight : float
        Largest Bernstein coefficient of w.
    is_free : bool
        Whether the surface begins and ends with sums that are no pairs.
    printed : int
        Degree of the printed polynomial.
    ends_at_one : bool
        Whether the last sample is exactly 1.
    """

    label: str
    pairs: int
    meets: Span
    other: Span
    written: Span
    other_kappa: Span
    unit: int
    radius: int
    bound: Span
    spans: Span
    norm: Span
    kappa: Span
    controls: Span
    products: Span
    sizes: Span
    levers: Span
    weight: float
    is_free: bool
    printed: int
    ends_at_one: bool
    polynomial: KernelSpec
    condition: KernelSpec
    condition_bound: KernelSpec
    polynomial_bound: KernelSpec
    closed_alpha: KernelSpec | None
    published_polynomial: KernelSpec
    meet: KernelSpec
    constants: KernelSpec
    approach: KernelSpec
    ray: KernelSpec
    point: KernelSpec
    position: KernelSpec
    ends: KernelSpec
    polish: KernelSpec
    normal: KernelSpec
