"""Newton and Euler by plain three-vectors: accelerations and reactions of rigid bodies held by geometric conditions.

No geometric algebra. A condition is a few rows on (v, w) of the body in the world's axes: what they times (v, w) must
be, and what they times (a, dw) must be. Batches (n, ...) throughout; equations are solved in extended precision.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

LONG = np.longdouble


def dot(a, b):
    return (a * b).sum(-1)


def times(matrix, vector):
    return np.einsum("...ij,...j->...i", matrix, vector)


@dataclass
class State:
    """n bodies: mass (n,), tensors (n, 3, 3) in body axes, place x (n, 3), turn (n, 3, 3), velocities v, w (n, 3) of
    the centre of mass and of turning, in the world's axes.
    """

    mass: np.ndarray
    tensor: np.ndarray
    x: np.ndarray
    turn: np.ndarray
    v: np.ndarray
    w: np.ndarray

    @property
    def inertia(self):
        """In the world's axes, in extended precision."""
        turn = self.turn.astype(LONG)
        return turn @ self.tensor.astype(LONG) @ np.swapaxes(turn, -1, -2)

    def arm(self, p):
        """From the centre of mass to a point of the body."""
        return times(self.turn, p)

    def velocity(self, p):
        return self.v + np.cross(self.w, self.arm(p))

    def bend(self, p):
        """w x (w x r): of the acceleration of a point of the body what is left when a and dw are zero."""
        return np.cross(self.w, np.cross(self.w, self.arm(p)))


@dataclass
class Rows:
    """Rows (n, k, 6) on (v, w), their values (n, k), and those on accelerations (n, k)."""

    matrix: np.ndarray
    value: np.ndarray
    second: np.ndarray

    def __add__(self, other):
        pairs = zip((self.matrix, self.value, self.second), (other.matrix, other.value, other.second), strict=True)
        return Rows(*(np.concatenate(pair, 1) for pair in pairs))


def _stacked(rows):
    """Rows from (linear part, angular part, value, second) each."""
    n = max(len(np.atleast_2d(r[1])) for r in rows)
    linear, angular = (np.stack([np.broadcast_to(r[i], (n, 3)) for r in rows], 1) for i in (0, 1))
    value, second = (np.stack([np.broadcast_to(r[i], (n,)) for r in rows], 1) for i in (2, 3))
    return Rows(np.concatenate([linear, angular], 2), value, second)


def across(m):
    """Two unit vectors (n, 3) each, across m and each other."""
    other = np.where(np.abs(m) == np.abs(m).min(-1, keepdims=True), 1.0, 0.0)
    first = np.cross(m, other)
    first /= np.linalg.norm(first, axis=-1, keepdims=True)
    second = np.cross(m, first)
    return first, second / np.linalg.norm(second, axis=-1, keepdims=True)


REST = np.zeros(3)


def point_along(s, p, e, c=(REST, REST, REST), slid=(REST, REST)):
    """e . P = e . c for directions e that rest; c moves, and the point slides within the body, with these rates."""
    r, bend = s.arm(p), s.bend(p)
    slip = 2 * np.cross(s.w, times(s.turn, slid[0])) + times(s.turn, slid[1])
    slide = times(s.turn, slid[0])
    return _stacked([(d, np.cross(r, d), dot(d, c[1] - slide), dot(d, c[2] - bend - slip)) for d in e])


def point_held(s, p, c=(REST, REST, REST), slid=(REST, REST)):
    """P = c."""
    return point_along(s, p, np.eye(3), c, slid)


def direction_held(s, d, m=(None, REST, REST)):
    """A direction of the body stays m, which may turn: two rows."""
    u = times(s.turn, d)
    bend = np.cross(s.w, np.cross(s.w, u))
    return _stacked([(REST, np.cross(u, e), dot(e, m[1]), dot(e, m[2] - bend)) for e in across(u)])


def on_line(s, p, m, c=(REST, REST, REST)):
    """(P - c) x m = 0; m and c are a direction and a point with their first two derivatives."""
    gap, rate = s.x + s.arm(p) - c[0], s.velocity(p) - c[1]
    rows = []
    for e in across(m[0]):
        d = np.cross(m[0], e)
        value = dot(d, c[1]) - dot(e, np.cross(gap, m[1]))
        turning = 2 * np.cross(rate, m[1]) + np.cross(gap, m[2])
        rows.append((d, np.cross(s.arm(p), d), value, dot(d, c[2] - s.bend(p)) - dot(e, turning)))
    return _stacked(rows)


def on_plane(s, p, n, c=(REST, REST, REST)):
    """n . (P - c) = 0, with derivatives likewise."""
    gap, rate = s.x + s.arm(p) - c[0], s.velocity(p) - c[1]
    value = dot(n[0], c[1]) - dot(n[1], gap)
    second = dot(n[0], c[2] - s.bend(p)) - 2 * dot(n[1], rate) - dot(n[2], gap)
    return _stacked([(n[0], np.cross(s.arm(p), n[0]), value, second)])


def at_distance(s, p, c, half=(0.0, 0.0)):
    """|P - c|^2 = d^2, of which half has these two derivatives."""
    gap, rate = s.x + s.arm(p) - c[0], s.velocity(p) - c[1]
    second = half[1] - dot(rate, rate) + dot(gap, c[2] - s.bend(p))
    return _stacked([(gap, np.cross(s.arm(p), gap), half[0] + dot(gap, c[1]), second)])


def at_angle(s, d, n, h=(0.0, 0.0)):
    """(R d) . n = h(t); n moves, h has these two derivatives."""
    u = times(s.turn, d)
    rate, bend = np.cross(s.w, u), np.cross(s.w, np.cross(s.w, u))
    second = h[1] - dot(bend, n[0]) - 2 * dot(rate, n[1]) - dot(u, n[2])
    return _stacked([(REST, np.cross(u, n[0]), h[0] - dot(u, n[1]), second)])


def knife_edge(s, p, d):
    """A point of the body does not move along d of the body."""
    u = times(s.turn, d)
    second = -dot(np.cross(s.w, u), s.velocity(p)) - dot(u, s.bend(p))
    return _stacked([(u, np.cross(s.arm(p), u), 0.0, second)])


def rolling(s, radius, n):
    """A sphere about the centre of mass rolls on a plane with normal n that rests."""
    r = -radius * n
    return _stacked([(e, np.cross(r, e), 0.0, 0.0) for e in np.eye(3)])


def powerless(s, force, moment):
    """A wrench of the world that rests, its moment about the world's origin, finds no power."""
    angular = moment - np.cross(s.x, force)
    return _stacked([(force, angular, 0.0, dot(force, np.cross(s.w, s.v)))])


# -- solution ------------------------------------------------------------------------------------------------


def solved(a, b):
    """x of a x = b (n, k, k), (n, k): elimination with pivots, in the precision of a and b."""
    a, b = a.copy(), b.copy()
    n, k = b.shape
    each = np.arange(n)
    for i in range(k):
        best = i + np.abs(a[:, i:, i]).argmax(1)
        for x in (a, b):
            x[each, best], x[:, i] = x[:, i].copy(), x[each, best].copy()
        for j in range(i + 1, k):
            share = a[:, j, i] / a[:, i, i]
            a[:, j] -= share[:, None] * a[:, i]
            b[:, j] -= share * b[:, i]
    for i in reversed(range(k)):
        b[:, i] = (b[:, i] - (a[:, i, i + 1 :] * b[:, i + 1 :]).sum(1)) / a[:, i, i]
    return b


def mass_inverse(s):
    """(n, 6, 6) on forces and moments about the centres of mass."""
    n = len(s.mass)
    inverse = np.zeros((n, 6, 6), LONG)
    inertia = s.inertia
    for j in range(3):
        inverse[:, j, j] = 1 / s.mass.astype(LONG)
        inverse[:, 3:, 3 + j] = solved(inertia, np.broadcast_to(np.eye(3, dtype=LONG)[j], (n, 3)))
    return inverse


def admissible(s, rows):
    """The state with the velocities next to its own that the rows allow; rest where rounding alone is left of them."""
    given = np.concatenate([s.v, s.w], 1)
    wrong = times(rows.matrix, given) - rows.value
    found = given - times(np.linalg.pinv(rows.matrix), wrong)
    rounding = 64 * np.finfo(float).eps * np.linalg.norm(given, axis=1, keepdims=True)
    found = np.where(np.linalg.norm(found, axis=1, keepdims=True) <= rounding, 0.0, found)
    return State(s.mass, s.tensor, s.x, s.turn, found[:, :3], found[:, 3:])


def motion(s, force, moment, rows=None):
    """Accelerations (a, dw), and force and moment (about the centre of mass) of the reaction; n of each.

    Parameters
    ----------
    force, moment : array (n, 3)
        Of the loads, the moment about the centre of mass.
    """
    w = s.w.astype(LONG)
    loads = np.concatenate([force.astype(LONG), moment.astype(LONG) - np.cross(w, times(s.inertia, w))], 1)
    inverse = mass_inverse(s)
    free = times(inverse, loads)
    pull = np.zeros_like(loads)
    if rows is not None:
        matrix = rows.matrix.astype(LONG)
        turned = np.swapaxes(matrix, 1, 2)
        multipliers = solved(matrix @ inverse @ turned, rows.second.astype(LONG) - times(matrix, free))
        pull = times(turned, multipliers)
    found = free + times(inverse, pull)
    return found[:, :3], found[:, 3:], pull[:, :3], pull[:, 3:]
