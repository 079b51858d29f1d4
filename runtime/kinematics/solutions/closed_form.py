"""Arms of six rotations in closed form: three axes of a wrist that meet, or three parallel ones.

e1 e2 e3 e4 e5 e6 = G, where e_i rotates about the axis i as it is at zero. A wrist's center c is moved by e1 e2 e3
alone: that ~e1 G c and e3 c differ by a rotation about axis 2 are two equations in the angles 1 and 3. Parallel axes
2, 3, 4 leave heights along them alone: that of a point and of the direction of axis 6 are two equations in the angles
1 and 5. An arm whose first three axes meet, or with axes 3, 4, 5 parallel, is solved from its other end.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .subproblems import (
    Array,
    Line,
    angle_between,
    crossing,
    linear_in_angle,
    matrix_about,
    rotate,
    rotate_about,
    two_angles,
)

#: Angles, and distances relative to the length of the arm, up to which axes count as parallel or meeting. Makers' files
#: round right angles to 1e-5; postures are brought to the true axes afterwards.
NEARLY = 1e-4


def common_point(lines: Sequence[Line], length: float) -> Array | None:
    """The point where lines meet that are not all parallel; None if they do not."""
    projectors = [np.eye(3) - np.outer(line.direction, line.direction) for line in lines]
    total = np.sum(projectors, axis=0)
    if np.linalg.svd(total, compute_uv=False)[-1] < NEARLY:
        return None
    point = np.linalg.solve(total, np.sum([p @ line.point for p, line in zip(projectors, lines, strict=True)], axis=0))
    gaps = [np.linalg.norm(p @ (point - line.point)) for p, line in zip(projectors, lines, strict=True)]
    return np.asarray(point) if max(gaps) < NEARLY * length else None


def are_parallel(lines: Sequence[Line]) -> bool:
    """Whether all lines have one direction, or the opposite one."""
    return all(np.linalg.norm(np.cross(lines[0].direction, line.direction)) < NEARLY for line in lines[1:])


def _circle(line: Line, x: Array, sign: float = 1.0) -> tuple[Array, Array, Array]:
    """Point (..., 3) of a rotation about a line by an angle: center + cos first + sin second."""
    around = x - line.point
    center = (around @ line.direction)[..., None] * line.direction
    first = around - center
    return line.point + center, first, sign * first @ crossing(line.direction).T


def wrist_postures(lines: Sequence[Line], center: Array, turn: Array, moved: Array) -> Array:
    """Starts (..., k, 6) of an arm whose last three axes meet.

    Parameters
    ----------
    lines : sequence of six Line
    center : array (3,)
        Where the last three meet.
    turn : array (..., 3, 3)
        Rotation of G.
    moved : array (..., 3)
        G c.
    """
    axis, at = lines[1]
    # y = ~e1 G c by the angle 1, x = e3 c by the angle 3: heights along axis 2, and distances from a point of it
    y0, y1, y2 = (v - at if i == 0 else v for i, v in enumerate(_circle(lines[0], moved, -1.0)))
    x0, x1, x2 = (v - at if i == 0 else v for i, v in enumerate(_circle(lines[2], center)))
    a = np.stack([
        np.stack([y1 @ axis, y2 @ axis], -1), 2 * np.stack([(y0 * y1).sum(-1), (y0 * y2).sum(-1)], -1),
    ], -2)  # fmt: skip
    b = -np.array([[x1 @ axis, x2 @ axis], [2 * x0 @ x1, 2 * x0 @ x2]])
    d = np.stack([x0 @ axis - y0 @ axis, x0 @ x0 + x1 @ x1 - (y0**2).sum(-1) - (y1**2).sum(-1)], -1)
    first, third = two_angles(a, np.broadcast_to(b, a.shape), d)
    y = y0[..., None, :] + np.cos(first)[..., None] * y1[..., None, :] + np.sin(first)[..., None] * y2[..., None, :]
    x = x0 + np.cos(third)[..., None] * x1 + np.sin(third)[..., None] * x2
    second = angle_between(axis, x, y)
    arm = matrix_about(lines[0].direction, first) @ matrix_about(axis, second) @ matrix_about(lines[2].direction, third)
    hand = np.swapaxes(arm, -1, -2) @ turn[..., None, :, :]
    fourth, fifth, sixth = wrist_angles([line.direction for line in lines[3:]], hand)
    position = [np.broadcast_to(v[..., None], fifth.shape) for v in (first, second, third)]
    found = np.stack([*position, fourth, fifth, sixth], -1)
    return _flat(found)


def _flat(found: Array) -> Array:
    """Starts (..., a, b, 6) as (..., a b, 6)."""
    return found.reshape(*found.shape[:-3], found.shape[-3] * found.shape[-2], 6)


def wrist_angles(axes: Sequence[Array], hand: Array) -> tuple[Array, Array, Array]:
    """Both triples of angles (..., 2) whose rotations about three axes make a rotation (..., 3, 3).

    Where the outer axes are aligned the first angle is zero, one of a family.
    """
    a, b, c = axes
    goal = hand @ c
    along = (c @ b) * b
    across = c - along
    second = linear_in_angle(
        np.broadcast_to(a @ across, goal.shape[:-1]), np.broadcast_to(a @ np.cross(b, across), goal.shape[:-1]),
        goal @ a - a @ along,
    )  # fmt: skip
    swung = rotate(b, second, np.broadcast_to(c, (*second.shape, 3)))
    target = np.broadcast_to(goal[..., None, :], swung.shape)
    first = angle_between(a, swung, target)
    left = np.swapaxes(matrix_about(a, first) @ matrix_about(b, second), -1, -2) @ hand[..., None, :, :]
    return first, second, rotation_angle(c, left)


def rotation_angle(axis: Array, matrix: Array) -> Array:
    """Angle of the rotation about an axis that is nearest to a matrix (..., 3, 3)."""
    side = np.cross(np.eye(3)[np.abs(axis).argmin()], axis)
    side = side / np.linalg.norm(side)
    other = np.cross(axis, side)
    sine = matrix @ side @ other - matrix @ other @ side
    return np.asarray(np.arctan2(sine, matrix @ side @ side + matrix @ other @ other))


def parallel_postures(lines: Sequence[Line], turn: Array, shift: Array) -> Array:
    """Starts (..., k, 6) of an arm with axes 2, 3 and 4 parallel, for G x = turn x + shift."""
    h = lines[1].direction
    signs = [float(np.sign(line.direction @ h)) for line in lines[1:4]]
    tip = lines[5]
    goal, aim = turn @ tip.point + shift, turn @ tip.direction
    y0, y1, y2 = _circle(lines[0], goal, -1.0)
    n0, n1, n2 = _circle(Line(lines[0].direction, np.zeros(3)), aim, -1.0)
    x0, x1, x2 = _circle(lines[4], tip.point)
    m0, m1, m2 = _circle(Line(lines[4].direction, np.zeros(3)), tip.direction)
    a = np.stack([np.stack([y1 @ h, y2 @ h], -1), np.stack([n1 @ h, n2 @ h], -1)], -2)
    b = -np.array([[x1 @ h, x2 @ h], [m1 @ h, m2 @ h]])
    d = np.stack([x0 @ h - y0 @ h, m0 @ h - n0 @ h], -1)
    first, fifth = two_angles(a, np.broadcast_to(b, a.shape), d)
    # seen from the tool, h is where axis 5 and axis 6 leave it
    inner = rotate(lines[4].direction, -fifth, np.broadcast_to(h, (*fifth.shape, 3)))
    outer = rotate(lines[0].direction, first, np.broadcast_to(h, (*first.shape, 3)))
    outer = np.einsum("...ji,...kj->...ki", turn, outer)
    sixth = angle_between(tip.direction, outer, inner)
    # what is left is e2 e3 e4: a rotation about h and where it takes axis 4
    back = np.swapaxes(matrix_about(lines[4].direction, fifth) @ matrix_about(tip.direction, sixth), -1, -2)
    before = np.swapaxes(matrix_about(lines[0].direction, first), -1, -2)
    middle = before @ turn[..., None, :, :] @ back
    total = rotation_angle(h, middle)
    elbow = lines[3].point
    x = rotate_about(lines[4], -fifth, np.broadcast_to(elbow, (*fifth.shape, 3)))
    x = rotate_about(tip, -sixth, x)
    x = np.einsum("...ij,...kj->...ki", turn, x) + shift[..., None, :]
    x = rotate_about(lines[0], -first, x)
    return _planar(lines, signs, x, total, first, fifth, sixth)


def _planar(
    lines: Sequence[Line], signs: Sequence[float], reached: Array, total: Array, first: Array, fifth: Array,
    sixth: Array,
) -> Array:  # fmt: skip
    """Angles of three parallel axes of which the last is brought to points (..., 3), and the whole rotation."""
    h, at = lines[1].direction, lines[1].point
    goal = reached - at
    goal = goal - (goal @ h)[..., None] * h
    c0, c1, c2 = _circle(Line(h, lines[2].point), lines[3].point)
    c0 = c0 - at
    c0 = c0 - (c0 @ h) * h
    third = linear_in_angle(
        np.broadcast_to(2 * c0 @ c1, goal.shape[:-1]), np.broadcast_to(2 * c0 @ c2, goal.shape[:-1]),
        (goal**2).sum(-1) - c0 @ c0 - c1 @ c1,
    )  # fmt: skip
    x = c0 + np.cos(third)[..., None] * c1 + np.sin(third)[..., None] * c2
    second = angle_between(h, x, np.broadcast_to(goal[..., None, :], x.shape))
    fourth = total[..., None] - second - third
    outer = [np.broadcast_to(v[..., None], third.shape) for v in (first, fifth, sixth)]
    found = np.stack(
        [outer[0], signs[0] * second, signs[1] * third, signs[2] * fourth, outer[1], outer[2]], -1
    )
    return _flat(found)
