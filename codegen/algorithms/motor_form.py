"""Quadratic forms of motors: where one is least among motors, and how stiff one of twists is.

A form is the upper half of a symmetric 8 x 8 matrix, row by row. Linear algebra only: a motor is q + q' with q of the
rotation and q' of the translation; q' is eliminated, and q is the eigenvector of the least eigenvalue of what is left.
"""

from __future__ import annotations

from ..ir.loops.algorithm import Algorithm as algorithm
from ..ir.loops.language import INFINITY, Out, Real, Vector, empty, int_zeros
from .dense import cholesky, least_eigenvector, solve_cholesky, substitute_forward
from .registration_layout import MOTOR, TWIST

#: Coefficients of each of a motor's two parts.
HALF = 4
#: Numbers of a form.
FORM = 36
#: What is added to the eliminated part, relative to its size: flats leave one direction of it free.
REGULARIZATION = 1e-14
#: Distance of the two least eigenvalues, relative to the form's size, below which the rotation is free.
GAP = 1e-10


@algorithm
def minimize_form(form: Vector[FORM], minimizer: Out[Vector[MOTOR]]) -> Real:
    """Where a form is least for a unit q, as q and q', and the form there; negative if it leaves the rotation free.

    Coefficients are in the order of the form: those of q, then those of q'.
    """
    outer = empty(HALF, HALF)
    cross = empty(HALF, HALF)
    inner = empty(HALF, HALF)
    at = 0
    for i in range(MOTOR):
        for j in range(i, MOTOR):
            if j < HALF:
                outer[i, j] = outer[j, i] = form[at]
            elif i < HALF:
                cross[i, j - HALF] = form[at]
            else:
                inner[i - HALF, j - HALF] = inner[j - HALF, i - HALF] = form[at]
            at += 1
    trace = 0.0
    for i in range(HALF):
        trace += inner[i, i]
    for i in range(HALF):
        inner[i, i] += REGULARIZATION * trace
    cholesky(inner)
    reduced = empty(HALF, HALF)
    for i in range(HALF):
        reduced[i][:] = cross[i]
        substitute_forward(inner, reduced[i])
    for i in range(HALF):
        for j in range(HALF):
            for k in range(HALF):
                outer[i, j] -= reduced[i, k] * reduced[j, k]
    least, gap = least_eigenvector(outer, minimizer[:HALF])
    for i in range(HALF):
        minimizer[HALF + i] = 0.0
        for k in range(HALF):
            minimizer[HALF + i] -= cross[k, i] * minimizer[k]
    solve_cholesky(inner, minimizer[HALF:])
    if not gap > GAP * trace:
        return -1.0
    return least if least > 0.0 else 0.0


@algorithm
def least_pivot(form: Vector[FORM]) -> Real:
    """The least pivot of a form of twists: zero if a motion is free.

    Twists are motors without the first and the last coefficient, those of 1 and the pseudoscalar.
    """
    a = empty(MOTOR, MOTOR)
    at = 0
    for p in range(MOTOR):
        for q in range(p, MOTOR):
            a[p, q] = a[q, p] = form[at]
            at += 1
    left = int_zeros(TWIST)
    for p in range(TWIST):
        left[p] = p + 1
    least = INFINITY
    for count in range(TWIST, 0, -1):
        top = 0
        for p in range(1, count):
            top = p if a[left[p], left[p]] > a[left[top], left[top]] else top
        t = left[top]
        pivot = a[t, t]
        least = pivot if pivot < least else least
        if not pivot > 0.0:
            return 0.0
        left[top] = left[count - 1]
        for p in range(count - 1):
            for q in range(count - 1):
                a[left[p], left[q]] -= a[left[p], t] * a[t, left[q]] / pivot
    return least
