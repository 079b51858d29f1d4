"""What the algorithms of trees take of a system: joints, links, bodies and loads, and its state at the start."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.algorithms.chain_records import Joint
from ...codegen.algorithms.dynamics.records import Spring
from ...codegen.algorithms.trees.motion_records import TreeBody
from ...codegen.algorithms.trees.records import Link
from ...codegen.programs.dynamics.loads import LAW_PLACES
from ...dispatch.formulas import evaluate
from ...mechanics.system import System
from ..assembly.body_parameters import constant_wrenches, law_numbers
from ..assembly.data import Assembly
from ..model import loads as load_types
from ..model.joint_loads import JointLoad
from .joint_laws import joint_laws
from .loops import loop_parameters
from .spanning_tree import SpanningTree, TreeJoint

Array = NDArray[Any]
#: Part of the velocities at the start that joints do not allow, which is rounding of the user's numbers.
ROUNDING = 1e-9
UPPER = np.triu_indices(3)


@dataclass(frozen=True, eq=False)
class TreeParameters:
    """Numbers of all simulations of a batch, and integers that they share.

    Attributes
    ----------
    each : dict of str to array (size, ...)
        By the names of the algorithms' parameters.
    shared : dict of str to array
    rows : array (rows, k)
        Of loops and couplings.
    start : array (size, 2 n)
        Coordinates and speeds.
    length : float
        What counts as a radian.
    options : dict of str to int
        Which loads there are.
    """

    each: dict[str, Array]
    shared: dict[str, Array]
    rows: Array
    start: Array
    length: float
    options: dict[str, int]

    def part(self, begin: int, end: int) -> TreeParameters:
        """Those of some simulations."""
        each = {name: x[begin:end] for name, x in self.each.items()}
        return replace(self, each=each, start=self.start[begin:end])


def tree_parameters(
    system: System, tree: SpanningTree, assembly: Assembly, loads: tuple[Any, ...]
) -> TreeParameters | str:
    """Parameters of a tree; or the reason why its start is none."""
    size, n, algebra = assembly.size, tree.count, assembly.algebra
    origin = np.broadcast_to(assembly.origin, (size, 3))
    joints = Joint.zeros(size, n)
    inner = tree.parents >= 0
    offsets = tree.positions - np.where(inner[:, None], tree.positions[tree.parents], 0.0)
    joints.offset = offsets - np.where(inner[:, None], 0.0, origin[:, None])
    joints.axis, joints.rotation, joints.advance = tree.axes, tree.turns, tree.advances
    links, bodies = Link.zeros(size, n), TreeBody.zeros(size, len(assembly.bodies))
    moved = np.empty((size, len(assembly.bodies), 4, 4))
    for i, (body, frame, carrier) in enumerate(zip(assembly.bodies, assembly.frames, tree.carriers, strict=True)):
        poses = np.broadcast_to(algebra.matrix(frame.pose), (size, 4, 4)).copy()
        poses[:, :3, 3] += origin - tree.positions[carrier]
        moved[:, i] = poses
        turns, centers = poses[:, :3, :3], poses[:, :3, 3]
        masses = np.broadcast_to(body.mass, (size,))
        moments = np.broadcast_to(frame.moments, (size, 3))
        square = (centers * centers).sum(-1)[:, None, None] * np.eye(3) - centers[:, :, None] * centers[:, None, :]
        tensors = turns * moments[:, None, :] @ np.swapaxes(turns, -1, -2) + masses[:, None, None] * square
        row, link = bodies[:, i], links[:, carrier]
        row.mass, row.moment, row.tensor = masses, masses[:, None] * centers, tensors[:, *UPPER]
        link.mass += masses
        link.moment += masses[:, None] * centers
        link.tensor += tensors[:, *UPPER]
        motors = algebra.motor_from_matrix(poses)
        row.center, row.position = centers, centers
        row.rotor = evaluate(algebra, "motions.motor_parts", motors).values[0].as_kind("rotor", check=False).values
        in_body = constant_wrenches(assembly, i, loads, load_types.BodyWrench, frame.to_body)
        row.wrench = (motors >> algebra.wrap(algebra.kind("twist"), in_body)).as_kind("twist", check=False).values
        row.world = constant_wrenches(assembly, i, loads, load_types.WorldWrench, assembly.shift)
        row.laws = law_numbers(assembly, i, loads)
    start = _start(system, tree, assembly, size)
    if isinstance(start, str):
        return start
    mass, trace = np.asarray(bodies.mass), np.asarray(bodies.tensor)[..., [0, 3, 5]].sum(-1)
    length = float(np.sqrt((trace / (2 * mass)).mean())) or 1.0
    closed = loop_parameters(system, tree, origin, length)
    if isinstance(closed, str):
        return closed
    springs = _springs(tree, assembly, moved)
    gravity = sum((g.acceleration for g in loads if isinstance(g, load_types.Gravity)), np.zeros(3))
    has_motor = any(LAW_PLACES[name].has_motor for name in assembly.loads if name in LAW_PLACES)
    options = {
        "world": bool(np.asarray(bodies.world).any()), "laws": any(name in LAW_PLACES for name in assembly.loads),
        "joint_laws": any(isinstance(load, JointLoad) for load in loads),
    }  # fmt: skip
    laws, torques = joint_laws(system, tree, loads, size)
    options["poses"] = options["world"] or bool(assembly.springs) or has_motor or bool(len(closed.rows))
    each = {
        "joints": joints, "links": links, "bodies": bodies, "springs": springs, "joint_laws": laws,
        "torques": torques, "loops": closed.loops, "gravity": np.broadcast_to(gravity, (size, 3)),
    }  # fmt: skip
    shared = {
        "parents": tree.parents, "balls": tree.balls, "carriers": tree.carriers, "ends": tree.ends,
        "places": closed.places, "firsts": closed.firsts,
        "spring_ends": np.array(assembly.springs or np.zeros((0, 2)), np.int64),
    }  # fmt: skip
    return TreeParameters(
        {name: np.ascontiguousarray(x, np.float64) for name, x in each.items()},
        {name: np.ascontiguousarray(x, np.int64) for name, x in shared.items()},
        closed.rows, start, length, {name: int(x) for name, x in options.items()},
    )  # fmt: skip


def _springs(tree: SpanningTree, assembly: Assembly, poses: Array) -> Array:
    """Springs (size, count), with ends in the frames of links."""
    first = assembly.spring_offset
    rows = assembly.parameters[:, first : first + Spring.size * len(assembly.springs)]
    springs = Spring.view(rows.reshape(assembly.size, len(assembly.springs), Spring.size).copy())
    for i, (a, b) in enumerate(assembly.springs):
        for name, body in (("point", a), ("anchor", b)):
            if body >= 0:
                point, pose = getattr(springs[:, i], name), poses[:, body]
                setattr(springs[:, i], name, (pose[:, :3, :3] @ point[..., None])[..., 0] + pose[:, :3, 3])
    return np.asarray(springs)


def _start(system: System, tree: SpanningTree, assembly: Assembly, size: int) -> Array | str:
    """Coordinates, which are zero, and speeds (size, 2 n) at the start."""
    start = np.zeros((size, 2 * tree.count))
    spins = np.stack([_spin(body, size) for body in assembly.bodies])
    velocities = np.stack([np.broadcast_to(body.velocity, (size, 3)) for body in assembly.bodies])
    centers = np.stack([np.broadcast_to(body.position, (size, 3)) for body in assembly.bodies])
    gyration = [np.sqrt(np.max(body.moments / body.mass[..., None])) for body in assembly.bodies]
    largest = max(np.abs(spins).max(), np.abs(velocities).max() / max(gyration))
    if largest == 0.0:
        return start
    number = {name: i for i, name in enumerate(system.bodies)} | {system.fixed: -1}
    cuts = [
        TreeJoint(i, number[system.joints[i].b], number[system.joints[i].a], freedoms, -1, False)
        for i in tree.cuts
        if (freedoms := system.freedoms[i]) is not None
    ]
    for joint in [*tree.joints, *cuts]:
        spin, velocity = _relative(joint, spins, velocities, centers)
        columns = joint.freedoms.columns()
        relative = np.hstack([spin, velocity])
        own = relative @ np.linalg.pinv(columns) if len(columns) else np.zeros((size, 0))
        off = np.abs(relative - own @ columns).max(initial=0)
        if off > ROUNDING * max(np.abs(relative).max(), largest):
            return "the velocities at the start are none that the joints allow"
        if joint.first >= 0:
            start[:, tree.count + joint.first : tree.count + joint.first + len(columns)] = own
    return start


def _spin(body: Any, size: int) -> Array:
    """Angular velocities (size, 3) along the world's axes."""
    return np.broadcast_to(np.einsum("...ij,...j->...i", body.rotation, body.angular_velocity), (size, 3))


def _relative(joint: TreeJoint, spins: Array, velocities: Array, centers: Array) -> tuple[Array, Array]:
    """Angular velocity of a joint's body relative to its parent, and the velocity of the joint's point."""
    parts = []
    for body in (joint.body, joint.parent):
        if body < 0:
            parts.append((np.zeros_like(spins[0]), np.zeros_like(spins[0])))
        else:
            spin = spins[body]
            parts.append((spin, velocities[body] + np.cross(spin, joint.freedoms.position - centers[body])))
    return parts[0][0] - parts[1][0], parts[0][1] - parts[1][1]
