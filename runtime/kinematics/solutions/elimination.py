"""Any arm of six rotations, by elimination (Raghavan and Roth): up to sixteen postures as eigenvalues.

e3 e4 e5 L = ~e2 ~e1 G L for the line L of axis 6, given by a point p and the direction l. Both sides of p, l, p^2,
p . l, p x l and p^2 l - 2 (p . l) p are linear in (1, cos, sin) of each angle: fourteen equations. Eight combinations
of the angles 1 and 2 are eliminated; the six that are left, and their products with the half tangent of angle 4, are
twelve equations in twelve monomials of the half tangents of angles 4 and 5, quadratic in that of angle 3. Half tangents
are taken from angles that are no posture's, so that none is infinite.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .closed_form import rotation_angle
from .subproblems import Array, Line, matrix_about, rotate, rotate_about

#: Angles at which functions of one angle are sampled.
SAMPLES = 2 * np.pi / 3 * np.arange(3)
#: From values at these to coefficients of 1, cos, sin.
TO_SERIES = np.stack([np.full(3, 1 / 3), 2 / 3 * np.cos(SAMPLES), 2 / 3 * np.sin(SAMPLES)])
#: Singular values, relative to the largest, below which equations are dependent.
DEPENDENT = 1e-9
#: Choices of the angles from which half tangents are taken; the best is used.
OFFSETS = 6
#: An arm whose equations are singular is solved beside itself: its axes off by this.
PERTURBATION = 1e-5
#: Condition beyond which equations count as singular.
SINGULAR = 1e11
#: Imaginary parts of half tangents, relative, beyond which a root is no start of a real posture.
COMPLEX = 0.1


def _invariants(p: Array, n: Array) -> Array:
    """The fourteen functions (..., 14) of a point and a direction."""
    square, along = (p * p).sum(-1, keepdims=True), (p * n).sum(-1, keepdims=True)
    return np.concatenate([p, n, square, along, np.cross(p, n), square * n - 2 * along * p], -1)


def _outer_series(lines: Sequence[Line], point: Array, aim: Array) -> Array:
    """Coefficients (..., 14, 9) of ~e2 ~e1 G L in (1, cos, sin) of the angles 1 and 2, about the origin."""
    at = lines[2].point
    first = SAMPLES[:, None] + np.zeros(3)
    second = SAMPLES + np.zeros((3, 1))
    shape = (*point.shape[:-1], 3, 3)
    first, second = (np.broadcast_to(-v, shape) for v in (first, second))
    p = rotate_about(lines[1], second, rotate_about(lines[0], first, point[..., None, None, :])) - at
    n = rotate(lines[1].direction, second, rotate(lines[0].direction, first, aim[..., None, None, :]))
    values = _invariants(p, n)
    series = np.einsum("ai,bj,...ijk->...kab", TO_SERIES, TO_SERIES, values)
    return np.asarray(series.reshape(*series.shape[:-2], 9))


def _inner_series(lines: Sequence[Line]) -> Array:
    """Coefficients (14, 3, 3, 3) of e3 e4 e5 L."""
    third, fourth, fifth = np.meshgrid(SAMPLES, SAMPLES, SAMPLES, indexing="ij")
    p = np.broadcast_to(lines[5].point, (3, 3, 3, 3))
    n = np.broadcast_to(lines[5].direction, (3, 3, 3, 3))
    for line, angle in ((lines[4], fifth), (lines[3], fourth), (lines[2], third)):
        p, n = rotate_about(line, angle, p), rotate(line.direction, angle, n)
    values = _invariants(p - lines[2].point, n)
    return np.asarray(np.einsum("ai,bj,cl,ijlk->kabc", TO_SERIES, TO_SERIES, TO_SERIES, values))


def _half_tangent(offset: float) -> Array:
    """From (1, cos, sin) of an angle to (1, w, w^2), times 1 + w^2, with w = tan((angle - offset)/2)."""
    c, s = np.cos(offset), np.sin(offset)
    # cos = (c (1 - w^2) - 2 s w)/(1 + w^2), sin = (s (1 - w^2) + 2 c w)/(1 + w^2)
    return np.array([[1, 0, 1], [c, -2 * s, -c], [s, 2 * c, -s]])


def elimination_postures(lines: Sequence[Line], turn: Array, shift: Array, length: float, seed: int = 0) -> Array:
    """Starts (N, k, 6) for motions G x = turn x + shift, turn (N, 3, 3).

    Lines are in any unit; ``length`` is that of the arm, ``seed`` of the angles from which half tangents are taken.
    """
    scaled = [Line(line.direction, line.point / length) for line in lines]
    rng = np.random.default_rng(seed)
    found, singular = _postures(scaled, turn, shift / length, rng)
    if not singular.any():
        return found
    more = []
    for _ in range(2):
        beside = []
        for line in scaled:
            direction = line.direction + PERTURBATION * rng.normal(size=3)
            beside.append(Line(direction / np.linalg.norm(direction), line.point + PERTURBATION * rng.normal(size=3)))
        more.append(_postures(beside, turn, shift / length, rng)[0])
    return np.concatenate([found, *more], 1)


def _postures(
    lines: Sequence[Line], turn: Array, shift: Array, rng: np.random.Generator
) -> tuple[Array, Array]:
    """Starts, and where equations are singular."""
    point, aim = turn @ lines[5].point + shift, turn @ lines[5].direction
    outer, inner = _outer_series(lines, point, aim), _inner_series(lines)
    u, s, _ = np.linalg.svd(outer[..., 1:])
    rank = int((s > DEPENDENT * s[..., :1]).sum(-1).min(initial=8))
    null = np.swapaxes(u[..., rank:], -1, -2)  # combinations without the angles 1 and 2
    if rank < 8:
        null = rng.normal(size=(6, 14 - rank)) @ null
    equations = np.einsum("nek,kabc->neabc", null, inner)
    equations[:, :, 0, 0, 0] -= np.einsum("nek,nk->ne", null, outer[..., 0])
    best: tuple[Array, Array] | None = None
    for _ in range(OFFSETS):
        offsets = rng.uniform(-np.pi, np.pi, 3)
        tangents = [_half_tangent(o) for o in offsets]
        polynomials = np.einsum("neabc,ap,bq,cr->nepqr", equations, *tangents)  # powers of w3, w4, w5
        matrices = _dialytic(polynomials)
        condition = np.linalg.cond(matrices[:, 2])
        if best is None or np.median(condition) < np.median(best[1]):
            best = matrices, condition
            kept = offsets
    assert best is not None
    matrices, condition = best
    usable = np.isfinite(condition) & (condition < 1 / np.finfo(float).eps)
    angles = np.full((len(turn), 24, 6), np.nan)
    if usable.any():
        angles[usable] = _angles(lines, matrices[usable], kept, outer[usable], inner, turn[usable])
    return angles, (condition > SINGULAR) | (s[..., -1] < DEPENDENT * s[..., 0])


def _dialytic(polynomials: Array) -> Array:
    """Matrices (N, 3, 12, 12) of powers of w3, on monomials w4^0..3 w5^0..2."""
    n, count = polynomials.shape[:2]
    rows = np.zeros((n, 3, 2, count, 4, 3))
    by_power = np.moveaxis(polynomials, 2, 1)
    rows[:, :, 0, :, :3] = by_power
    rows[:, :, 1, :, 1:] = by_power
    return rows.reshape(n, 3, 2 * count, 12)


def _angles(
    lines: Sequence[Line], matrices: Array, offsets: Array, outer: Array, inner: Array, turn: Array
) -> Array:
    n = len(matrices)
    constant, linear, square = (matrices[:, k] for k in range(3))
    companion = np.zeros((n, 24, 24))
    companion[:, :12, 12:] = np.eye(12)
    companion[:, 12:, :12] = -np.linalg.solve(square, constant)
    companion[:, 12:, 12:] = -np.linalg.solve(square, linear)
    values, vectors = np.linalg.eig(companion)
    vectors = np.swapaxes(vectors, -1, -2)
    halves = np.where((np.abs(values) > 1)[..., None], vectors[..., 12:], vectors[..., :12])
    monomials = halves.reshape(n, 24, 4, 3)
    with np.errstate(all="ignore"):
        fourth = _ratio(monomials[:, :, :-1], monomials[:, :, 1:])
        fifth = _ratio(monomials[..., :-1], monomials[..., 1:])
        tangents = np.stack([values, fourth, fifth], -1)
        is_real = (np.abs(tangents.imag) < COMPLEX * (1 + np.abs(tangents))).all(-1)
    # a pair that rounding made complex is as far apart, to both sides of its real part
    inside = np.where(is_real[..., None], offsets + 2 * np.arctan(tangents.real + tangents.imag), np.nan)
    first, second = _outer_angles(outer, inner, inside)
    arm = matrix_about(lines[0].direction, first) @ matrix_about(lines[1].direction, second)
    for k in range(3):
        arm = arm @ matrix_about(lines[2 + k].direction, inside[..., k])
    sixth = rotation_angle(lines[5].direction, np.swapaxes(arm, -1, -2) @ turn[:, None])
    return np.concatenate([first[..., None], second[..., None], inside, sixth[..., None]], -1)


def _ratio(low: Array, high: Array) -> Array:
    """The factor from monomials to those with one power more."""
    return np.asarray((low.conj() * high).sum((-1, -2)) / (np.abs(low) ** 2).sum((-1, -2)))


def _outer_angles(outer: Array, inner: Array, inside: Array) -> tuple[Array, Array]:
    """Angles 1 and 2 from what the others give, by least squares."""
    series = [np.stack([np.ones_like(a), np.cos(a), np.sin(a)], -1) for a in np.moveaxis(inside, -1, 0)]
    known = np.einsum("kabc,nia,nib,nic->nik", inner, *series) - outer[:, None, :, 0]
    monomials = np.einsum("nmk,nik->nim", np.linalg.pinv(outer[..., 1:]), known)
    # in the order (1, cos 2, sin 2) of 1, of cos 1 and of sin 1, the first left out
    return np.arctan2(monomials[..., 5], monomials[..., 2]), np.arctan2(monomials[..., 1], monomials[..., 0])
