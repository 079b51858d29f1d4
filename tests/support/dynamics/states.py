"""Random bodies for tests of dynamics, what the driver makes of a state, and how wrong that is.

One program serves all constraints: it is compiled once.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from bladesmith import cga3d as cga
from bladesmith import dynamics
from bladesmith import pga3d as pga
from bladesmith.codegen.programs.dynamics.config import LOADS, DynamicsConfig
from bladesmith.dispatch.formulas import evaluate
from bladesmith.dynamics.assembly.assemble import assemble
from bladesmith.dynamics.assembly.data import Assembly
from bladesmith.dynamics.integration import driver, integrators

from ...oracles import newton_euler as ne
from ...oracles.newton_euler import State, times
from ..effort import FULL
from .conditions import wrench

ALGEBRAS = {"cga": cga, "pga": pga}
#: All kinds of object that constraints are made of, and more equations than any test has.
LAYOUTS = {
    "cga3d": ("direction", "flat_point", "plane", "point", "line", "twist", "point_pair", "circle", "sphere"),
    "pga3d": ("direction", "point", "plane", "line", "twist"),
}
ROWS = 24
#: Share of an acceleration or a reaction that may be wrong.
BAR = 1e-10
#: Objects drawn for each constraint, and states of each.
OBJECTS, STATES = (5, 200) if FULL else (3, 40)
GRAVITY = np.array([0.3, -0.7, -9.81])
#: Moments of inertia of a body of unit mass and a radius of gyration of about a half.
MOMENTS = np.array([0.1, 0.2, 0.25])


class Wide(Assembly):
    """An assembly that asks for a program with all loads and objects: it is compiled once, for all tests."""

    @property
    def layouts(self):
        return LAYOUTS[self.algebra.name]

    def needs(self, method, chart):
        return DynamicsConfig(self.algebra.name, 1, self.mode, LOADS, self.layouts, ROWS, method, chart, True)


def wide_driver(made):
    """A driver of the wide program for an assembly."""
    made.__class__ = Wide
    return driver.Driver(made, integrators.Method("rk4", 1.0, 1e-12, 0.0), "exponential", False, 0.0)


def states(n, seed, size=2.0, speed=3.0):
    """n random bodies, of shapes that can be, at random places, at random speeds."""
    rng = np.random.default_rng(seed)
    mass = rng.uniform(0.5, 3.0, n)
    boxes = rng.uniform(0.2, 1.5, (n, 3)) ** 2
    moments = mass[:, None] * (boxes.sum(1, keepdims=True) - boxes)
    axes = Rotation.random(n, random_state=seed).as_matrix()
    tensor = np.einsum("nij,nj,nkj->nik", axes, moments, axes)
    turn = Rotation.random(n, random_state=seed + 1).as_matrix()
    x, v, w = rng.normal(size=(3, n, 3)) * np.array([size, speed, speed])[:, None, None]
    return State(mass, (tensor + np.swapaxes(tensor, 1, 2)) / 2, x, turn, v, w)


def alike(n, seed):
    """States of one body."""
    s = states(n, seed)
    s.mass[:], s.tensor[:] = s.mass[0], s.tensor[0]
    return s


def body_of(s, algebra):
    """The package's body in this state."""
    spin = np.einsum("nji,nj->ni", s.turn, s.w)
    return dynamics.RigidBody(s.mass, s.tensor, s.x, s.turn, s.v, spin, algebra=algebra)


def single(s, i):
    """One of them."""
    return State(*(getattr(s, name)[i : i + 1] for name in ("mass", "tensor", "x", "turn", "v", "w")))


def _item(body):
    """The only body of a batch of one."""
    return dynamics.RigidBody(
        float(body.mass[0]), body.axes[0] @ np.diag(body.moments[0]) @ body.axes[0].T, body.position[0],
        body.rotation[0], body.velocity[0], body.angular_velocity[0], algebra=body.algebra,
    )  # fmt: skip


def screws(algebra, rows):
    """Vectors a and b of a I3 + b n."""
    found = evaluate(
        algebra, "mechanics.screw_vectors", algebra.wrap(algebra.kind("twist"), np.ascontiguousarray(rows))
    )
    return found.values[0].values, found.values[1].values


def pose(motor, twist):
    """Place, turn and velocities in the world that functions of the state are given."""
    matrix = motor.algebra.matrix(motor)
    w, v = screws(motor.algebra, twist.values)
    return matrix[:3, 3], matrix[:3, :3], matrix[:3, :3] @ v, matrix[:3, :3] @ w


class Looked:
    """Accelerations and reactions of a batch, as the driver finds them, in the world's axes.

    Attributes
    ----------
    acceleration, spin_rate : array (n, 3)
        Of the centre of mass, and dw.
    force, moment : array (n, 3)
        Of the reaction, the moment about the centre of mass.
    rank : array (n,)
        Of the constraints, where they are counted.
    mode : str
    """

    def __init__(self, s, algebra, loads, constraints, null_space, alone=False, before=None):
        """Alone: one simulation serves all states, those of one body; `before(i)` prepares what constraints read."""
        body = body_of(single(s, 0) if alone else s, algebra)
        self.made = made = assemble([_item(body) if alone else body], ["body"], loads, constraints, 1.0, null_space)
        self.before = before or (lambda i: None)
        self.mode = made.mode
        self.driver = wide_driver(made)
        self.frame = made.frames[0]
        rates, rows = self._all(s, algebra)
        self._to_world(s, algebra, rates, rows)

    def _all(self, s, algebra):
        n = len(s.mass)
        own, state = self.frame.to_body, body_of(s, algebra)
        place = algebra.translator(s.x - self.made.origin) * algebra.motor_from_matrix(state.rotation) * own
        motors = place.as_kind("motor", check=False).values
        twists = (~own >> state.twist_in_body).values
        if self.frame.allowed is not None:
            twists = np.where(self.frame.allowed, twists, 0.0)
        rates, rows, rank = np.empty((n, 6)), np.empty((n, 6)), np.empty(n, int)
        for i in range(n):
            self.before(i)
            found = self.driver.evaluate(0.0, motors[i : i + 1], twists[i : i + 1], i if self.made.size > 1 else 0)
            rates[i], rows[i], rank[i] = found["accelerations"][0], found["reactions"][0], found["rank"]
        self.rank, self.twists = rank, twists
        return rates, rows

    def _to_world(self, s, algebra, rates, rows):
        """The driver's frame is another than the body's: its origin is a point of the body, its axes are turned."""
        own = np.broadcast_to(algebra.matrix(self.frame.to_body), (len(s.mass), 4, 4))
        turn = s.turn @ own[:, :3, :3]
        r = times(s.turn, own[:, :3, 3])
        (w, v), (dw, dv) = screws(algebra, self.twists), screws(algebra, rates)
        self.spin_rate = times(turn, dw)
        at_origin = times(turn, dv + np.cross(w, v))
        self.acceleration = at_origin - np.cross(self.spin_rate, r) - np.cross(s.w, np.cross(s.w, r))
        turns, ways = screws(algebra, np.eye(6))  # a row holds the power of the reaction on each unit twist
        self.force, about_origin = times(turn, rows @ ways), times(turn, rows @ turns)
        self.moment = about_origin + np.cross(r, self.force)


def worst(found, a, dw, force, moment, s):
    """Largest share that is wrong; turns and moments are brought to lengths by the radius of gyration."""
    reach = np.sqrt(np.trace(s.tensor, axis1=1, axis2=2) / s.mass)[:, None]
    shares = []
    for mine, theirs in (
        ((found.acceleration, reach * found.spin_rate), (a, reach * dw)),
        ((found.force, found.moment / reach), (force, moment / reach)),
    ):
        error = np.linalg.norm(np.concatenate([x - y for x, y in zip(mine, theirs, strict=True)], 1), axis=1)
        size = np.linalg.norm(np.concatenate(theirs, 1), axis=1)
        shares.append(float(np.divide(error, size, out=error.copy(), where=size > 1e-3).max()))
    return max(shares)


def loads(algebra, rng):
    """Gravity, and a wrench of each sort; and what they are, for a state, about the centre of mass."""
    force, moment, own_force, own_moment = rng.normal(size=(4, 3))
    acting = [
        dynamics.Gravity(GRAVITY),
        dynamics.WorldWrench(wrench(algebra, force, moment)),
        dynamics.BodyWrench(wrench(algebra, own_force, own_moment)),
    ]

    def about_center(s):
        total = s.mass[:, None] * GRAVITY + force + times(s.turn, own_force)
        return total, moment - np.cross(s.x, force) + times(s.turn, own_moment)

    return acting, about_center


def settled(s, build):
    """The state next to s that obeys the rows, and they there."""
    s = ne.admissible(s, build(s))
    return s, build(s)


def compared(s, rows, algebra, constraints, null_space, rng, alone=False, before=None):
    """What the driver finds, and how wrong it is."""
    acting, about_center = loads(algebra, rng)
    found = Looked(s, algebra, acting, constraints, null_space, alone, before)
    return found, worst(found, *ne.motion(s, *about_center(s), rows), s)


def sized_body(size=1.0, position=(0.0, 0.0, 0.0), algebra=cga, **given):
    """A body whose lengths are `size` times as long."""
    return dynamics.RigidBody(size**3, MOMENTS * size**5, position, algebra=algebra, **given)
