"""Motions of rigid bodies with 30 digits: what studies of integrators compare against. No kernels, no floats.

Tops without loads and pendulums about an axis by elliptic functions; any body that turns about a point by power series.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]
DIGITS = 30
#: Numbers of the power series are integers over 2^BITS: 33 digits after the point.
BITS = 112
#: Terms of the series; a step is so long that the last one is 2^-TAIL of the largest state.
TERMS, TAIL = 44, 104


def context() -> Any:
    """The numbers of `mpmath`, with a reserve for what cancels near the middle axis."""
    from ....codegen.rings.protocol import PrecisionRing

    return PrecisionRing(DIGITS + 20).context


# -- elliptic functions ------------------------------------------------------------------------------------


def free_top(moments: Array, spin: Array, t: float) -> tuple[Array, Array]:
    """Turn (3, 3) of a body without loads, and its angular velocity (3,), after a time t.

    The turn takes the body's axes to where they were at first. Elliptic functions, and the elliptic integral of the
    third kind for the angle about the momentum (Landau and Lifshitz, Mechanics, section 37). The moments are not all
    equal, and the spin is about no principal axis.
    """
    mp = context()
    order, sign = _order(mp, moments, spin)
    a, b, c = (mp.mpf(float(moments[i])) for i in order)
    w = [mp.mpf(float(spin[i])) for i in order]
    w[2] *= sign  # of an order that is left-handed the last axis is turned round
    twice_energy, square = (a**k * w[0] ** 2 + b**k * w[1] ** 2 + c**k * w[2] ** 2 for k in (1, 2))
    beside, along = twice_energy * c - square, square - twice_energy * a
    last = mp.sign(w[2]) * mp.sqrt(along / (c * (c - a)))
    sizes = [mp.sqrt(beside / (a * (c - a))), mp.sign((c - b) * last) * mp.sqrt(beside / (b * (c - b))), last]
    rate, m = mp.sqrt((c - b) * along / (a * b * c)), (b - a) * beside / ((c - b) * along)
    start = mp.ellipf(mp.atan2(w[1] / sizes[1], w[0] / sizes[0]), m)
    end, length = start + rate * mp.mpf(t), mp.sqrt(square)
    rest = square - (c * last) ** 2
    n = -((c * last) ** 2) * m / rest
    third = (_third(mp, n, end, m) - _third(mp, n, start, m)) / rate
    angle = length / c * mp.mpf(t) + length * (twice_energy - square / c) / rest * third
    w_end = [size * mp.ellipfun(name, end, m=m) for size, name in zip(sizes, ("cn", "sn", "dn"), strict=True)]
    frames = [_along(mp, [a * x[0] / length, b * x[1] / length, c * x[2] / length]) for x in (w, w_end)]
    about = mp.matrix([[mp.cos(angle), -mp.sin(angle), 0], [mp.sin(angle), mp.cos(angle), 0], [0, 0, 1]])
    turn = frames[0].T * about * frames[1]
    signs, found, omega = (1, 1, sign), np.empty((3, 3)), np.empty(3)
    for i in range(3):
        omega[order[i]] = float(signs[i] * w_end[i])
        for j in range(3):
            found[order[i], order[j]] = float(signs[i] * signs[j] * turn[i, j])
    return found, omega


def _order(mp: Any, moments: Array, spin: Array) -> tuple[list[int], int]:
    """The axes: last the one that the momentum goes around, first the one at the other end; and their handedness."""
    order = [int(i) for i in np.argsort(moments, kind="stable")]
    i, w = ([mp.mpf(float(x)) for x in values] for values in (moments, spin))
    if sum(x * x * y * y for x, y in zip(i, w, strict=True)) <= i[order[1]] * sum(
        x * y * y for x, y in zip(i, w, strict=True)
    ):
        order.reverse()
    return order, 1 if (order[1] - order[0]) % 3 == 1 else -1


def _along(mp: Any, u: list[Any]) -> Any:
    """The rotation of no angle about the third axis that takes a direction to it."""
    sine = mp.hypot(u[0], u[1])
    s, c = u[0] / sine, u[1] / sine
    return mp.matrix([[c, -s, 0], [u[2] * s, u[2] * c, -sine], [sine * s, sine * c, u[2]]])


def _third(mp: Any, n: Any, u: Any, m: Any) -> Any:
    """The integral of 1/(1 - n sn^2)."""
    return mp.ellippi(n, _amplitude(mp, u, m), m)


def _amplitude(mp: Any, u: Any, m: Any) -> Any:
    """The angle of sn and cn that grows with u."""
    angle = mp.atan2(mp.ellipfun("sn", u, m=m), mp.ellipfun("cn", u, m=m))
    return angle + 2 * mp.pi * mp.nint((u / mp.ellipk(m) / 4) - angle / (2 * mp.pi))


def pendulum(strength: float, angle: float, rate: float, t: float) -> tuple[float, float]:
    """Angle from hanging and its rate, after a time t, of angle'' = -strength sin(angle)."""
    mp = context()
    w = mp.sqrt(mp.mpf(float(strength)))
    angle, rate, t = (mp.mpf(float(x)) for x in (angle, rate, t))
    place, speed = mp.sin(angle / 2), rate / (2 * w)
    m = speed**2 + place**2
    if m == 0:
        return 0.0, 0.0
    size = mp.sqrt(m)
    if m < 1:  # to and fro
        end = mp.ellipf(mp.atan2(place / size, speed / size), m) + w * t
        sn, cn = (mp.ellipfun(name, end, m=m) for name in ("sn", "cn"))
        return float(2 * mp.asin(size * sn)), float(2 * w * size * cn)
    way = mp.sign(rate) * w * size
    end = mp.ellipf(angle / 2, 1 / m) + way * t
    return float(2 * _amplitude(mp, end, 1 / m)), float(2 * way * mp.ellipfun("dn", end, m=1 / m))


# -- power series ------------------------------------------------------------------------------------------


def turning(
    mass: Array, moments: Array, arm: Array, gravity: Array, rotation: Array, spin: Array, t: float
) -> tuple[Array, Array]:
    """Orientations (n, 3, 3) and angular velocities (n, 3) along the bodies' axes, after a time t.

    Parameters
    ----------
    mass, moments : arrays (n,), (n, 3)
        Moments are about the center of mass, along its principal axes.
    arm : array (n, 3)
        From the point that stays to the center of mass, in the body.
    gravity : array (3,)
    rotation, spin : arrays (n, 3, 3), (n, 3)
        At the start: body to world, and along the body's axes.
    """
    mp = context()
    n, inertia = len(mass), _inertia_about(mp, mass, moments, arm)
    unit = 2.0 ** round(math.log2(float(max(np.max(np.abs(spin)), _swing(mass, arm, gravity, inertia)))))
    inverse, pull, momentum = (np.empty(shape, object) for shape in ((3, 3, n), (3, 3, n), (3, n)))
    for k in range(n):
        size = mp.mpf(2) ** round(math.log2(float(max(inertia[k][i, i] for i in range(3)))))
        turned = (inertia[k] / size) ** -1
        w = [mp.mpf(float(x)) / unit for x in spin[k]]
        for i in range(3):
            momentum[i, k] = _to_fixed_point(mp, sum(inertia[k][i, j] * w[j] for j in range(3)) / size)
            for j in range(3):
                inverse[i, j, k] = _to_fixed_point(mp, turned[i, j])
                force = mp.mpf(float(mass[k])) * mp.mpf(float(gravity[j])) / (size * mp.mpf(unit) ** 2)
                pull[i, j, k] = _to_fixed_point(mp, force * mp.mpf(float(arm[k, i])))
    rows = np.vectorize(lambda x: _to_fixed_point(mp, mp.mpf(float(x))), otypes=[object])(np.moveaxis(rotation, 0, -1))
    state = np.concatenate([momentum[None], rows])
    left = mp.mpf(t) * mp.mpf(unit)
    while left > 0:
        series = _series(state, inverse, pull)
        step = min(left, mp.mpf(_step(series)))
        state, left = _at(series, _to_fixed_point(mp, step)), left - step
    omega = _product(inverse, state[0]) >> BITS
    scale = 2.0**-BITS
    return (np.moveaxis(state[1:].astype(float) * scale, -1, 0), np.moveaxis(omega.astype(float) * scale * unit, -1, 0))


def _inertia_about(mp: Any, mass: Array, moments: Array, arm: Array) -> list[Any]:
    """Tensors about the point that stays."""
    found = []
    for m, own, way in zip(mass, moments, arm, strict=True):
        c = mp.matrix([mp.mpf(float(x)) for x in way])
        tensor = mp.mpf(float(m)) * ((c.T * c)[0] * mp.eye(3) - c * c.T)
        found.append(tensor + mp.diag([mp.mpf(float(x)) for x in own]))
    return found


def _swing(mass: Array, arm: Array, gravity: Array, inertia: list[Any]) -> float:
    """The rate of small oscillations, about."""
    pulls = np.asarray(mass) * np.linalg.norm(arm, axis=-1) * np.linalg.norm(gravity)
    least = [float(min(tensor[i, i] for i in range(3))) for tensor in inertia]
    return float(np.sqrt(np.max(pulls / least)))


def _to_fixed_point(mp: Any, x: Any) -> int:
    return int(mp.nint(mp.ldexp(x, BITS)))


def _product(matrix: Array, vector: Array) -> Array:
    found: Array = (matrix * vector).sum(1)
    return found


def _series(state: Array, inverse: Array, pull: Array) -> Array:
    """Coefficients (TERMS + 1, 4, 3, n) of the momentum about the point and of the rows of the orientation.

    With w = J L along the body's axes, L' = L x w + arm x weight and r' = r x w for the rows r of the orientation.
    """
    x = np.empty((TERMS + 1, *state.shape), object)
    w = np.empty((TERMS, 1, *state.shape[1:]), object)
    x[0] = state
    for order in range(TERMS):
        w[order] = _product(inverse, x[order, 0]) >> BITS
        a, b = x[: order + 1], w[order::-1]
        rate = np.empty_like(state)
        for i in range(3):
            j, k = (i + 1) % 3, (i + 2) % 3
            rate[:, i] = (a[:, :, j] * b[:, :, k] - a[:, :, k] * b[:, :, j]).sum(0)
            # the weight's moment: arm x (sum of the world's axes r by the parts of gravity along them)
            rate[0, i] += (pull[j] * x[order, 1:, k] - pull[k] * x[order, 1:, j]).sum(0)
        x[order + 1] = (rate >> BITS) // (order + 1)
    return x


def _step(series: Array) -> float:
    """A step of which the last two terms are small enough."""
    sizes = [max(1, int(np.max(np.abs(series[k])))) for k in (0, TERMS - 1, TERMS)]
    logs = [math.log2(size) for size in sizes]
    return float(2 ** min((logs[0] - TAIL - logs[1]) / (TERMS - 1), (logs[0] - TAIL - logs[2]) / TERMS))


def _at(series: Array, step: int) -> Array:
    """The series at a step."""
    found: Array = series[-1]
    for k in range(TERMS - 1, -1, -1):
        found = (found * step >> BITS) + series[k]
    return found
