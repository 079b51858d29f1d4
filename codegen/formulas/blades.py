"""The blade manifold: norms, normalisation, and the projection of a pure-grade multivector to the nearest blade."""

from __future__ import annotations

from ..multivector import Multivector, select, sqrt


def norm_squared(x: Multivector) -> Multivector:
    """<x ~x>_0."""
    return x.scalar_product(~x)


def principal_root(s0: Multivector, s4: Multivector, norm: Multivector) -> tuple[Multivector, Multivector]:
    """Factors (p, q) with sqrt(s0 + s4) = p + q s4, for norm = [[s0 + s4]] (thesis 4.10).

    p^2 = (s0 + norm)/2, q = 1/(2 p). For s0 < 0 that sum cancels: then q is found first, from
    p^2 = s4^2/(2 (norm - s0)), and neither branch subtracts equal numbers.
    """
    direct = sqrt((norm + s0) / 2)
    other = sqrt((norm - s0) / 2)
    root = sqrt(-(s4 * s4).grade(0))
    positive = s0 >= 0
    p = select(positive, direct, root / (2 * other))
    q = select(positive, 1 / (2 * direct), other / root)
    return p, q


def blade_projector(x: Multivector) -> Multivector:
    """Projector S with S x a unit blade, for a pure-grade x (thesis 3.5, 4.11, 4.12).

    Sigma = -x ~x = s0 + s4; S is the conjugate of the principal square root of Sigma over its norm. Where s4^2
    vanishes by the blades of x (lines, planes, spheres), that is (1 - s4/(2 s0))/sqrt(s0).
    """
    sigma = -(x * ~x)
    s0, s4 = sigma.grade(0), sigma.grade(4)
    if not (s4 * s4).terms:
        return (1 - s4 / (2 * s0)) / sqrt(s0)
    norm = sqrt(s0 * s0 - s4 * s4)
    p, q = principal_root(s0, s4, norm)
    return (p - q * s4) / norm


def project_to_blade(x: Multivector) -> Multivector:
    """S x: the unit blade that a pure-grade x stands for."""
    return blade_projector(x) * x
