"""Twists, wrenches and the products of screws (thesis 6.2, 6.3), and the forms that others give to forces (6.2.5).

A twist is w I3 + v n with the velocity v of the frame's origin, a wrench f I3 + tau n with the moment tau about it:
dual lines and their sums in CGA, lines and theirs in PGA. Formulas for the motion of a body are in `mechanics`.
"""

from __future__ import annotations

from typing import NamedTuple

from ...algebra.multivector import Multivector
from ...status import Status
from ...trace.outputs import Result, named, row
from ..mechanics.mechanics import screw_of
from ..objects.conformal import point
from ..objects.euclidean import attached_part, coordinates, cross, direction_of, dot, null_vector, vector
from ..products.outcome import is_finite, outcome, where_or_nan
from .screws import direction_part, line_of, rejection, twist_of

# -- as numbers --------------------------------------------------------------------------------------------


def moment_about(wrench: Multivector, point: Multivector) -> Multivector:
    """tau - p x f: the moment about a point."""
    return attached_part(wrench) - cross(point, direction_part(wrench))


def screw_row(screw: Multivector, name: str = "screw") -> Result:
    """(a, b) of a I3 + b n as six numbers."""
    return row([*coordinates(direction_part(screw)), *coordinates(attached_part(screw))], name)


class ScrewRow(NamedTuple):
    """(a, b) of a I3 + b n."""

    a1: Multivector
    a2: Multivector
    a3: Multivector
    b1: Multivector
    b2: Multivector
    b3: Multivector


def screw_of_row(screw: ScrewRow) -> Multivector:
    """a I3 + b n of six numbers."""
    return screw_of(vector(screw[:3]), vector(screw[3:]))


# -- products ----------------------------------------------------------------------------------------------


def screw_cross(a: Multivector, b: Multivector) -> Multivector:
    """(A x C, A x D + B x C) of screws (A, B) and (C, D): less their commutator (6.2.3)."""
    return -a.commutator(b)


def killing_form(a: Multivector, b: Multivector) -> Multivector:
    """4 <A B>_0, the trace of both adjoints' product (the sign printed in 6.2.3 is the other one)."""
    return 4 * a.scalar_product(b)


# -- forces in other hands (6.2.5) -------------------------------------------------------------------------


def force_along(line: Multivector, intensity: Multivector) -> Multivector:
    """The wrench of a force along a unit line."""
    return intensity * twist_of(line)


def line_of_wrench(wrench: Multivector) -> Multivector:
    """The sum of lines that a wrench is: its undual in CGA, itself in PGA."""
    return line_of(wrench)


def wrench_of_vector(force: Multivector, at: Multivector) -> Multivector:
    """(X ^ F ^ n_inf) I5 of a force F = f + alpha n_inf at a point X (Lasenby, Lasenby and Doran; CGA)."""
    return (at ^ force ^ null_vector(force)).dual()


def vector_of_wrench(wrench: Multivector) -> tuple[Result, Result, Result, Result]:
    """F = f, the point X nearest the origin on the wrench's axis, and the couple h f n that they leave over (CGA).

    SINGULAR: a couple has no such point. INVALID: not finite.
    """
    f, tau = direction_part(wrench), attached_part(wrench)
    unit, scale = direction_of(f)
    acts = scale > 0
    across = rejection(tau * scale, unit)
    place = cross(unit, across)
    left_over = dot(tau, unit) * unit * where_or_nan(acts, wrench.constant(1))
    finite = is_finite(wrench)
    return (
        named("force", f * where_or_nan(acts, wrench.constant(1))),
        named("point", point(place)),
        named("couple", left_over * null_vector(wrench)),
        outcome(wrench, (~finite, Status.INVALID), (~acts, Status.SINGULAR)),
    )


def ideal_line(a: Multivector) -> Multivector:
    """Gunn's line at infinity e0 a (PGA): since e0 a = -a e0, the couple of the moment -a."""
    return null_vector(a) * a
