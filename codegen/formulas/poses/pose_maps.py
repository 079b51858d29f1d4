"""Exponential, logarithm and adjoint of poses, on rows of twists (w, v).

The pose exp(-phi/2), phi = w I3 + v n, is where a body gets in a unit of time that moves with the twist phi from the
identity.
"""

from __future__ import annotations

from ...algebra.multivector import Multivector
from ...trace.outputs import Result, row
from ..motions.maps import exponential_motor
from ..motions.screws import direction_part
from ..motions.twists import ScrewRow, screw_of_row, screw_row
from ..objects.euclidean import attached_part, coordinates
from ..products.exponentials import log_motor
from .poses import finite_pose


def exp_pose(twist: ScrewRow) -> tuple[Multivector, Result]:
    """exp(-phi/2). INVALID: not finite."""
    return finite_pose(exponential_motor(screw_of_row(twist)))


def log_pose(x: Multivector) -> tuple[Result, Result]:
    """The row of phi with exp(-phi/2) = x; angle and statuses as of `log_motor`."""
    b, status = log_motor(x)
    return screw_row(-2 * b, "twist"), status


def adjoint_matrix(x: Multivector) -> Result:
    """Matrix (6, 6) of phi -> x phi ~x on (w, v), row by row: from twists of the body to those of the world."""
    return matrix_of_columns([(x >> e).grade(2) for e in unit_twists(x)])


def unit_twists(like: Multivector) -> list[Multivector]:
    one, zero = like.constant(1), like.new({})
    return [screw_of_row(ScrewRow(*(one if i == j else zero for j in range(6)))) for i in range(6)]


def _numbers(twist: Multivector) -> list[Multivector]:
    return [*coordinates(direction_part(twist)), *coordinates(attached_part(twist))]


def matrix_of_columns(columns: list[Multivector]) -> Result:
    rows = zip(*map(_numbers, columns), strict=True)
    return row([entry for entries in rows for entry in entries], "matrix")
