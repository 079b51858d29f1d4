"""Curves of geometric objects: Bezier, rational, Hermite, Kochanek-Bartels, interpolating (thesis 3.12.1 and 4.8).

A curve adds up multivectors (its raw values) and projects the sums to blades; t = 0 is its first object.
"""

from __future__ import annotations

from .base import Curve
from .bezier import Bezier, Hermite, RationalBezier
from .splines import Interpolating, KochanekBartels

__all__ = ["Bezier", "Curve", "Hermite", "Interpolating", "KochanekBartels", "RationalBezier"]
