"""Mechanisms for tests, and what says the same of them without any geometric algebra: six-vectors and 50 digits.

A twist is (w, v): the turning, and the velocity of what is at the world's origin.
"""

from __future__ import annotations

import mpmath
import numpy as np
from scipy.spatial.transform import Rotation

from bladesmith import cga3d as cga
from bladesmith import kinematics as kin
from bladesmith import pga3d as pga

MP = mpmath.mp.clone()
MP.dps = 50
ALGEBRAS = {"cga": cga, "pga": pga}
AXIS = np.array([0.0, 0.0, 1.0])


def hinge(a, b, place, axis):
    """A revolute joint of CGA about an axis through a place."""
    return kin.Revolute(a, b, cga.circle(place, axis, 0.2))


# -- six-vectors ---------------------------------------------------------------------------------------------------


def columns(algebra):
    """Coefficients (6, 6) of the twists of unit w, then v: w I3 + v n, multiplied out by hand."""
    names, blades = list(algebra.vectors), algebra.kind("twist").blades
    bit = {name: 1 << i for i, name in enumerate(names)}
    null = "ni" if "ni" in bit else "0"
    found = np.zeros((6, 6))
    for k, (i, j) in enumerate((("2", "3"), ("3", "1"), ("1", "2"))):  # e1 e123 = e23, and so on
        found[blades.index(bit[i] | bit[j]), k] = 1 if names.index(i) < names.index(j) else -1
        own = str(k + 1)
        found[blades.index(bit[own] | bit[null]), 3 + k] = 1 if names.index(own) < names.index(null) else -1
    return found


def twist(algebra, six):
    """The multivector of (..., 6) numbers (w, v)."""
    return algebra.wrap(algebra.kind("twist"), np.ascontiguousarray(np.asarray(six, float) @ columns(algebra).T))


def six(x):
    """(w, v) of a twist."""
    return x.as_kind("twist").values @ columns(x.algebra)


def turn(axis, place):
    """Turning about an axis (..., 3) through a place."""
    axis, place = np.broadcast_arrays(np.asarray(axis, float), np.asarray(place, float))
    return np.concatenate([axis, np.cross(place, axis)], -1)


def slide(way):
    """Sliding along a way."""
    return np.concatenate([np.zeros_like(way), way], -1)


def shift(place):
    """The matrix of twists seen from a place: (w, v + w x place)."""
    x, y, z = place
    found = np.eye(6)
    found[3:, :3] = -np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return found


def velocity(six_vector, place):
    """Of a point that goes with a body."""
    return six_vector[..., 3:] + np.cross(six_vector[..., :3], place)


def rank(matrix, share=1e-9):
    """By dense singular values."""
    values = np.linalg.svd(matrix, compute_uv=False)
    return int((values > share * values.max(initial=0)).sum())


def full_matrix(mechanism, unit=1.0):
    """The thesis's own constraints, X x (W_i - W_j) = 0 for each shared X, by geometric products of multivectors."""
    rows = []
    for joint in mechanism.joints:
        for condition in joint.conditions():
            x = condition.x
            algebra = x.algebra
            block = []
            for k in range(6):
                e = twist(algebra, np.eye(6)[k] * (1 if k < 3 else unit))
                rate = (x * e - e * x) / 2
                values = np.zeros(1 << len(algebra.vectors))
                values[list(rate.kind.blades)] = rate.values
                block.append(values)
            block = np.stack(block, 1)
            row = np.zeros((len(block), 6 * len(mechanism.moving)))
            for body, sign in ((joint.a, 1), (joint.b, -1)):
                if body != mechanism.fixed:
                    at = 6 * mechanism.moving.index(body)
                    row[:, at : at + 6] += sign * block / np.abs(block).max()
            rows.append(row)
    return np.concatenate(rows)


# -- mechanisms ----------------------------------------------------------------------------------------------------


def line_joint(algebra, a, b, place, axis, radius=1.0):
    """A revolute joint in either algebra."""
    if algebra is pga:
        return kin.Revolute(a, b, pga.line(place, axis), pga.point(place))
    return kin.Revolute(a, b, cga.circle(place, axis, radius))


def four_bar(places, algebra=cga, axes=AXIS, radius=1.0):
    """Revolute joints at four places (4, 3): ground to crank, to coupler, to rocker, to ground."""
    bodies = ["ground", "crank", "coupler", "rocker"]
    m = kin.Mechanism(bodies, "ground")
    axes = np.broadcast_to(np.asarray(axes, float), (4, 3))
    for k, name in enumerate("abcd"):
        m.add(line_joint(algebra, bodies[k], bodies[(k + 1) % 4], places[k], axes[k], radius), name)
    return m


class FourBar:
    """A planar four-bar by its lengths, from its angles alone."""

    def __init__(self, ground=3.0, crank=1.0, coupler=3.2, rocker=2.0, branch=1):
        self.lengths, self.branch = (ground, crank, coupler, rocker), branch

    def rocker_angle(self, theta, ring=np):
        """Freudenstein's equation, solved: x cos r + y sin r = value, with the crank's end less the rocker's foot."""
        d, a, b, c = self.lengths
        ct, st = ring.cos(theta), ring.sin(theta)
        x, y = a * ct - d, a * st
        size = ring.sqrt(x * x + y * y)
        value = -(x * x + y * y + c * c - b * b) / (2 * c)
        middle = ring.arctan2(-y, -x) if ring is np else ring.atan2(-y, -x)
        arc = ring.arccos(value / size) if ring is np else ring.acos(value / size)
        return middle + self.branch * arc

    def places(self, theta):
        d, a, _, c = self.lengths
        r = self.rocker_angle(theta)
        return np.array(
            [
                [0, 0, 0],
                [a * np.cos(theta), a * np.sin(theta), 0],
                [d + c * np.cos(r), c * np.sin(r), 0],
                [d, 0, 0],
            ]
        )

    def slope(self, theta):
        """d(rocker)/d(crank) by central differences of 50 digits."""
        step = MP.mpf(10) ** -15
        t = MP.mpf(theta)
        return float((self.rocker_angle(t + step, MP) - self.rocker_angle(t - step, MP)) / (2 * step))


def stewart(base, top, algebra=cga):
    """Six legs of two halves: universal joints stand in for balls at the base, so that no leg spins."""
    bodies = ["base", *(f"{part}_{i}" for i in range(6) for part in ("lower", "upper")), "top"]
    m = kin.Mechanism(bodies, "base")
    for i, (p, q) in enumerate(zip(base, top, strict=True)):
        way = (q - p) / np.linalg.norm(q - p)
        across = np.cross(way, [0.3, 1.0, 0.2])
        across /= np.linalg.norm(across)
        other = np.cross(way, across)
        if algebra is cga:
            first = kin.Universal("base", f"lower_{i}", cga.circle(p, across, 1.0), cga.circle(p, other, 1.0))
        else:
            first = kin.Spherical("base", f"lower_{i}", pga.point(p))
        m.add(first, f"foot_{i}")
        planes = [algebra.plane(n, float(p @ n)) for n in (across, other)]
        m.add(kin.Prismatic(f"lower_{i}", f"upper_{i}", *planes), f"leg_{i}")
        m.add(kin.Spherical(f"upper_{i}", "top", algebra.point(q)), f"ball_{i}")
    return m


def hexagon(radius, height, spread, phase=0.0):
    """Six points in pairs about a circle."""
    angles = np.deg2rad([120 * (i // 2) + (spread if i % 2 else -spread) for i in range(6)]) + phase
    return np.stack([radius * np.cos(angles), radius * np.sin(angles), np.full(6, height)], 1)


STEWART = hexagon(2.0, 0.0, 12.0), hexagon(1.1, 1.7, 48.0, 0.1) + [0.1, -0.05, 0.0]


class Delta:
    """A Delta robot by its lengths; y is the point of the platform, from three spheres in 50 digits."""

    def __init__(self, scale=1.0, centre=(0.0, 0.0, 0.0), lengths=(0.4, 0.15, 0.6, 1.2)):
        self.base, self.effector, self.upper, self.fore = (scale * v for v in lengths)
        self.scale, self.centre = scale, np.asarray(centre, float)
        phi = 2 * np.pi / 3 * np.arange(3)
        self.s = np.stack([np.cos(phi), np.sin(phi), 0 * phi], 1)
        self.axes = np.cross(self.s, AXIS)

    def elbows(self, theta, ring=np):
        theta = [MP.mpf(float(t)) if not isinstance(t, MP.mpf) else t for t in theta] if ring is MP else theta
        found = []
        for i in range(3):
            out = self.base + self.upper * ring.cos(theta[i])
            up = self.upper * ring.sin(theta[i])
            found.append([out * self.s[i][0], out * self.s[i][1], up])
        return found

    def forward(self, theta):
        """y (3) in 50 digits: the far point at one distance from three places."""
        own = self.elbows([MP.mpf(t) for t in theta], MP)
        p = [[own[i][k] - self.effector * MP.mpf(float(self.s[i][k])) for k in range(3)] for i in range(3)]
        rows = MP.matrix([[2 * (p[i][k] - p[0][k]) for k in range(3)] for i in (1, 2)])
        right = MP.matrix([sum(c * c for c in p[i]) - sum(c * c for c in p[0]) for i in (1, 2)])
        way = [
            rows[0, 1] * rows[1, 2] - rows[0, 2] * rows[1, 1],
            rows[0, 2] * rows[1, 0] - rows[0, 0] * rows[1, 2],
            rows[0, 0] * rows[1, 1] - rows[0, 1] * rows[1, 0],
        ]
        square = MP.matrix([[rows[0, 0], rows[0, 1], rows[0, 2]], [rows[1, 0], rows[1, 1], rows[1, 2]], way])
        start = MP.lu_solve(square, MP.matrix([right[0], right[1], 0]))
        a = sum(c * c for c in way)
        b = sum(way[k] * (start[k] - p[0][k]) for k in range(3))
        c = sum((start[k] - p[0][k]) ** 2 for k in range(3)) - MP.mpf(self.fore) ** 2
        roots = [(-b + sign * MP.sqrt(b * b - a * c)) / a for sign in (1, -1)]
        return max(([start[k] + root * way[k] for k in range(3)] for root in roots), key=lambda v: v[2])

    def place(self, theta):
        return np.array([float(v) for v in self.forward(theta)]) + self.centre

    def slope(self, theta):
        """dy/dtheta (3, 3), by central differences of 50 digits."""
        step, found = MP.mpf(10) ** -15, np.zeros((3, 3))
        for j in range(3):
            ends = [
                self.forward([MP.mpf(float(t)) + sign * step * (i == j) for i, t in enumerate(theta)])
                for sign in (1, -1)
            ]
            found[:, j] = [float((p - q) / (2 * step)) for p, q in zip(*ends, strict=True)]
        return found

    def mechanism(self, theta, algebra=cga, y=None):
        """Closed at these angles; y is the far root, if not given."""
        y = self.place(theta) if y is None else np.asarray(y) + self.centre
        bodies = ["base", *(f"upper_{i}" for i in range(3)), *(f"rod_{i}" for i in range(6)), "platform"]
        m = kin.Mechanism(bodies, "base")
        side = self.effector / np.tan(np.pi / 6)
        elbows = np.asarray(self.elbows(theta)) + self.centre
        for i in range(3):
            hub = self.base * self.s[i] + self.centre
            m.add(line_joint(algebra, "base", f"upper_{i}", hub, self.axes[i], self.upper), f"motor_{i}")
        for k in range(6):
            i, sign = k // 2, 1 - 2 * (k % 2)
            across = sign * side * self.axes[i]
            m.add(kin.Spherical(f"upper_{i}", f"rod_{k}", algebra.point(elbows[i] + across)))
            m.add(kin.Spherical(f"rod_{k}", "platform", algebra.point(y + self.effector * self.s[i] + across)))
        return m


def bennett(a=1.0, b=1.7, alpha=0.6, theta=0.9):
    """Joints of a Bennett linkage: places (4, 3) and axes (4, 3), closed for any theta.

    Lengths a, b, a, b, twists alpha, beta, alpha, beta, sin(alpha)/a = sin(beta)/b, no offsets.
    """
    beta = np.arcsin(b * np.sin(alpha) / a)
    # tan(theta/2) tan(phi/2) = sin((beta + alpha)/2) / sin((beta - alpha)/2)
    phi = 2 * np.arctan(np.sin((beta + alpha) / 2) / np.sin((beta - alpha) / 2) / np.tan(theta / 2))
    frame, places, axes = np.eye(4), [], []
    for turned, length, bent in ((theta, a, alpha), (phi, b, beta), (-theta, a, alpha), (-phi, b, beta)):
        places.append(frame[:3, 3].copy())
        axes.append(frame[:3, 2].copy())
        step = np.eye(4)
        step[:3, :3] = Rotation.from_euler("zx", [turned, 0]).as_matrix()
        out = np.eye(4)
        out[:3, :3] = Rotation.from_euler("x", bent).as_matrix()
        out[0, 3] = length
        frame = frame @ step @ out
    return np.array(places), np.array(axes), frame


def sarrus(height=1.0, reach=1.0, length=0.8):
    """Two chains of three parallel hinges at right angles: the top goes straight up."""
    m = kin.Mechanism(["base", "low_0", "high_0", "low_1", "high_1", "top"], "base")
    half = np.sqrt(length**2 - (height / 2) ** 2)
    for k, out in enumerate(np.eye(3)[:2]):
        axis = np.cross(AXIS, out)
        places = reach * out, (reach + half) * out + height / 2 * AXIS, reach * out + height * AXIS
        names = ["base", f"low_{k}", f"high_{k}", "top"]
        for j in range(3):
            m.add(kin.Revolute(names[j], names[j + 1], cga.circle(places[j], axis, 0.3)), f"hinge_{k}{j}")
    return m


def placements(rng, count, far):
    """Places (n, 3) near one that is so far from the origin, and orthonormal frames (n, 3, 3)."""
    way = rng.normal(size=3)
    return far * way / np.linalg.norm(way) + rng.normal(size=(count, 3)), Rotation.random(
        count, random_state=rng
    ).as_matrix()
