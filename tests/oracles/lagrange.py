"""Torques of serial chains from Lagrange's equations, in as many digits as mpmath has."""

import mpmath as mp

from .serial_chains import columns, oracle


def _vector(x):
    return mp.matrix([mp.mpf(float(c)) for c in x])


def _cross(a, b):
    return mp.matrix([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


def _jacobians(screws, q, center):
    """For each link the Jacobians of its rotation and of its center of mass, the center, and its rotation."""
    _, before = oracle(screws, mp.eye(4), q)
    axes = columns(screws, before)
    n = len(q)
    for j in range(n):
        pose = before[j + 1]
        place = pose[:3, :3] * _vector(center[j]) + pose[:3, 3]
        turning, moving = mp.zeros(3, n), mp.zeros(3, n)
        for i in range(j + 1):
            w, v = axes[:3, i], axes[3:, i]
            velocity = v + _cross(w, place)
            for r in range(3):
                turning[r, i], moving[r, i] = w[r], velocity[r]
        yield turning, moving, place, pose[:3, :3]


def exact_mass_matrix(screws, masses, centers, tensors, q):
    """Sums of J^T m J and of J^T R I R^T J, centers and tensors in the world where all joints are at zero."""
    matrix = mp.zeros(len(q))
    for (turning, moving, _, turn), m, tensor in zip(_jacobians(screws, q, centers), masses, tensors, strict=True):
        about = turn * mp.matrix([[mp.mpf(float(x)) for x in row] for row in tensor]) * turn.T
        matrix += mp.mpf(float(m)) * moving.T * moving + turning.T * about * turning
    return matrix


def exact_torques(screws, masses, centers, tensors, gravity, q, qd, qdd):
    """M qdd + dM/dt qd - d/dq (qd^T M qd / 2) - sum of m g . dc/dq, with derivatives of M as central differences."""
    n = len(q)
    x, v, a = (mp.matrix([mp.mpf(float(c)) for c in row]) for row in (q, qd, qdd))
    g = _vector(gravity)

    def mass(at):
        return exact_mass_matrix(screws, masses, centers, tensors, list(at))

    step = mp.mpf(10) ** (-mp.mp.dps // 3)  # the error of a difference is its square
    slopes = []
    for k in range(n):
        ahead, behind = x.copy(), x.copy()
        ahead[k] += step
        behind[k] -= step
        slopes.append((mass(ahead) - mass(behind)) / (2 * step))
    forces = mass(x) * a
    for k in range(n):
        forces += slopes[k] * v * v[k]
    for k in range(n):
        forces[k] -= (v.T * slopes[k] * v)[0] / 2
    for (_, moving, _, _), m in zip(_jacobians(screws, list(x), centers), masses, strict=True):
        forces -= mp.mpf(float(m)) * moving.T * g
    return forces
