"""Tops by those whom people would use instead, each as its users write it: numba, heyoka, scipy, MuJoCo, Pinocchio and
clifford. What bench_dynamics.py measures.

A top turns about a point, with I dw = (I w) x w + k (g_2, -g_1, 0): g is upright as the top sees it, and k is zero
without loads.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache, partial
from importlib.util import find_spec
from typing import Any

import numpy as np

#: A run: what is timed; its end as quaternion (w, x, y, z) and spin.
Run = Callable[[], tuple[Any, Any]]
GRAVITY = 9.81
#: Tops of one call where a peer runs several.
MANY = 1000


@dataclass(frozen=True)
class Top:
    """A top, free or on its tip, upright but for its quaternion.

    Attributes
    ----------
    moments : tuple of 3
        About the centre of mass.
    arm : float
        From the tip to the centre of mass, along the third axis; 0 for a free one.
    """

    moments: tuple[float, float, float]
    spin: tuple[float, float, float]
    quaternion: tuple[float, float, float, float]
    duration: float
    mass: float = 1.0
    arm: float = 0.0

    @property
    def about_tip(self) -> tuple[float, float, float]:
        """Moments about the point that stays."""
        a, b, c = self.moments
        more = self.mass * self.arm**2
        return a + more, b + more, c

    @property
    def pull(self) -> float:
        """k."""
        return self.mass * GRAVITY * self.arm


def missing(package: str) -> bool:
    """Whether a peer is not installed."""
    return find_spec(package) is None


# -- numba -------------------------------------------------------------------------------------------------


@cache
def numba_rk4() -> Any:
    """Classical Runge-Kutta steps on quaternion and spin."""
    from numba import njit

    @njit(inline="always")
    def rates(y, a, b, c, k, dy):  # type: ignore[no-untyped-def]
        w, x, yy, z, p, q, r = y[0], y[1], y[2], y[3], y[4], y[5], y[6]
        dy[0] = -0.5 * (x * p + yy * q + z * r)
        dy[1] = 0.5 * (w * p + yy * r - z * q)
        dy[2] = 0.5 * (w * q + z * p - x * r)
        dy[3] = 0.5 * (w * r + x * q - yy * p)
        dy[4] = ((b - c) * q * r + k * 2 * (yy * z + w * x)) / a
        dy[5] = ((c - a) * r * p - k * 2 * (x * z - w * yy)) / b
        dy[6] = (a - b) * p * q / c

    @njit
    def steps(y, a, b, c, k, h, n):  # type: ignore[no-untyped-def]
        k1, k2, k3, k4, at = np.empty(7), np.empty(7), np.empty(7), np.empty(7), np.empty(7)
        for _ in range(n):
            rates(y, a, b, c, k, k1)
            for i in range(7):
                at[i] = y[i] + h / 2 * k1[i]
            rates(at, a, b, c, k, k2)
            for i in range(7):
                at[i] = y[i] + h / 2 * k2[i]
            rates(at, a, b, c, k, k3)
            for i in range(7):
                at[i] = y[i] + h * k3[i]
            rates(at, a, b, c, k, k4)
            for i in range(7):
                y[i] += h / 6 * (k1[i] + 2 * k2[i] + 2 * k3[i] + k4[i])

    return steps


def by_numba(top: Top, count: int) -> Run:
    """So many steps."""
    steps = numba_rk4()

    def run() -> tuple[Any, Any]:
        y = np.array([*top.quaternion, *top.spin])
        steps(y, *top.about_tip, top.pull, top.duration / count, count)
        return y[:4], y[4:]

    return run


# -- heyoka and scipy --------------------------------------------------------------------------------------


def by_heyoka(top: Top, tolerance: float, count: int = 1) -> Run:
    """Taylor series, compiled by LLVM; of several tops in its batch mode, as many at once as it recommends."""
    import heyoka as hy

    p, q, r, w, x, y, z = hy.make_vars("p", "q", "r", "w", "x", "y", "z")
    (a, b, c), k = top.about_tip, top.pull
    system = [
        (p, (b - c) / a * q * r + 2 * k / a * (y * z + w * x)),
        (q, (c - a) / b * r * p - 2 * k / b * (x * z - w * y)),
        (r, (a - b) / c * p * q),
        (w, -0.5 * (x * p + y * q + z * r)),
        (x, 0.5 * (w * p + y * r - z * q)),
        (y, 0.5 * (w * q + z * p - x * r)),
        (z, 0.5 * (w * r + x * q - y * p)),
    ]
    start = [*top.spin, *top.quaternion]
    if count > 1:
        return _by_heyoka_batch(hy, system, start, top.duration, tolerance, count)
    integrator = hy.taylor_adaptive(system, start, tol=tolerance)

    def run() -> tuple[Any, Any]:
        integrator.time, integrator.state[:] = 0.0, start
        integrator.propagate_until(top.duration)
        return integrator.state[3:], integrator.state[:3]

    return run


def _by_heyoka_batch(hy: Any, system: Any, start: Any, duration: float, tolerance: float, count: int) -> Run:
    lanes = hy.recommended_simd_size()
    starts = np.repeat(np.array(start)[:, None], lanes, axis=1)
    integrator = hy.taylor_adaptive_batch(system, starts, tol=tolerance)

    def run() -> tuple[Any, Any]:
        for _ in range(-(-count // lanes)):
            integrator.set_time(0.0)
            integrator.state[:] = starts
            integrator.propagate_until(duration)
        return integrator.state[3:, 0], integrator.state[:3, 0]

    return run


def by_scipy(top: Top, tolerance: float) -> Run:
    """DOP853 on a function of plain Python numbers, which is its fastest."""
    from scipy.integrate import solve_ivp

    (a, b, c), k = top.about_tip, top.pull

    def rates(t: float, state: Any) -> tuple[float, ...]:
        w, x, y, z, p, q, r = state.tolist()
        return (
            -0.5 * (x * p + y * q + z * r), 0.5 * (w * p + y * r - z * q), 0.5 * (w * q + z * p - x * r),
            0.5 * (w * r + x * q - y * p), ((b - c) * q * r + 2 * k * (y * z + w * x)) / a,
            ((c - a) * r * p - 2 * k * (x * z - w * y)) / b, (a - b) * p * q / c,
        )  # fmt: skip

    def run() -> tuple[Any, Any]:
        start = [*top.quaternion, *top.spin]
        end = solve_ivp(rates, (0, top.duration), start, "DOP853", rtol=tolerance, atol=tolerance).y[:, -1]
        return end[:4], end[4:]

    return run


# -- engines -----------------------------------------------------------------------------------------------


def mujoco_top(top: Top, step: float, integrator: str = "RK4") -> tuple[Any, Any]:
    """Model and data."""
    import mujoco

    joint = "ball" if top.arm else "free"
    text = f"""<mujoco><option timestep="{step!r}" integrator="{integrator}" gravity="0 0 {-GRAVITY if top.arm else 0}">
      <flag contact="disable"/></option><worldbody><body><joint type="{joint}"/>
      <inertial pos="0 0 {top.arm}" mass="{top.mass}" diaginertia="{" ".join(map(repr, top.moments))}"/>
      </body></worldbody></mujoco>"""
    model = mujoco.MjModel.from_xml_string(text)
    return model, mujoco.MjData(model)


def by_mujoco(top: Top, count: int, integrator: str = "RK4") -> Run:
    """So many steps, in one call."""
    import mujoco

    model, data = mujoco_top(top, top.duration / count, integrator)

    def run() -> tuple[Any, Any]:
        mujoco.mj_resetData(model, data)
        data.qpos[-4:], data.qvel[-3:] = top.quaternion, top.spin
        mujoco.mj_step(model, data, count)
        return data.qpos[-4:], data.qvel[-3:]

    return run


def pinocchio_top(top: Top) -> tuple[Any, Any]:
    """Model and data."""
    import pinocchio as pin

    model = pin.Model()
    if not top.arm:
        model.gravity = pin.Motion.Zero()
    joint = pin.JointModelSpherical() if top.arm else pin.JointModelFreeFlyer()
    at = model.addJoint(0, joint, pin.SE3.Identity(), "top")
    inertia = pin.Inertia(top.mass, np.array([0, 0, top.arm]), np.diag(top.moments))
    model.appendBodyToJoint(at, inertia, pin.SE3.Identity())
    return model, model.createData()


def by_pinocchio(top: Top, count: int) -> Run:
    """So many classical Runge-Kutta steps on quaternion and velocity, looped in Python."""
    import pinocchio as pin

    model, data = pinocchio_top(top)
    h, none = top.duration / count, np.zeros(model.nv)
    start, spin = np.zeros(model.nq), np.zeros(model.nv)
    start[-4:], spin[-3:] = np.roll(top.quaternion, -1), top.spin

    def rates(q: Any, v: Any) -> tuple[Any, Any]:
        x, y, z, w = q[-4:]
        a, b, c = v[-3:]
        dq = np.zeros_like(q)  # the centre of mass of a free one rests
        dq[-4:] = (w * a + y * c - z * b, w * b + z * a - x * c, w * c + x * b - y * a, -x * a - y * b - z * c)
        return dq / 2, pin.aba(model, data, q / np.linalg.norm(q[-4:]), v, none).copy()

    def run() -> tuple[Any, Any]:
        q, v = start.copy(), spin.copy()
        for _ in range(count):
            q1, v1 = rates(q, v)
            q2, v2 = rates(q + h / 2 * q1, v + h / 2 * v1)
            q3, v3 = rates(q + h / 2 * q2, v + h / 2 * v2)
            q4, v4 = rates(q + h * q3, v + h * v3)
            q = q + h / 6 * (q1 + 2 * q2 + 2 * q3 + q4)
            v = v + h / 6 * (v1 + 2 * v2 + 2 * v3 + v4)
        return np.roll(q[-4:], 1), v[-3:]

    return run


def clifford_rates(top: Top) -> Callable[[], Any]:
    """The rates of rotor and spin of a free top in `clifford`, as in the thesis: Q dw = -Psi x w."""
    from clifford import g3

    blades = g3.blades
    axes = [blades["e23"], -blades["e13"], blades["e12"]]
    rotor, spin = 1.0 + 0 * blades["e12"], sum(w * e for w, e in zip(top.spin, axes, strict=True))

    def run() -> Any:
        momentum = sum(i * -(spin | e) * e for i, e in zip(top.moments, axes, strict=True))
        bent = (momentum * spin - spin * momentum) / 2
        return -0.5 * rotor * spin, sum((bent | e) / i * e for i, e in zip(top.moments, axes, strict=True))

    return run


#: Peer, its package, how it runs, what is turned.
PEERS: dict[str, tuple[str, Callable[[Top, Any], Run], tuple[Any, ...]]] = {
    "heyoka": ("heyoka", by_heyoka, (1e-4, 1e-6, 1e-9, 1e-12, 1e-15)),
    f"heyoka, one of {MANY}": ("heyoka", partial(by_heyoka, count=MANY), (1e-4, 1e-6, 1e-9, 1e-12, 1e-15)),
    "numba RK4": ("numba", by_numba, (250, 1000, 4000, 16000)),
    "scipy DOP853": ("scipy", by_scipy, (1e-5, 1e-8, 1e-10, 1e-12)),
    "MuJoCo RK4": ("mujoco", by_mujoco, (250, 1000, 4000)),
    "Pinocchio, RK4 in Python": ("pinocchio", by_pinocchio, (250, 1000)),
}


def runs(top: Top) -> Iterator[tuple[str, Any, Run | None]]:
    """Peer, setting and run; without a run if it is not installed."""
    for name, (package, make, settings) in PEERS.items():
        if missing(package):
            yield name, "not installed", None
            continue
        for setting in settings:
            yield name, setting, make(top, setting)
