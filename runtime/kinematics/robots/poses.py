"""Poses of a robot's links: coordinates read, links in parts that joints with one coordinate move, compiled."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.errors import ShapeError
from ...common.validation import as_bool
from ...core.multivector import Multivector
from ...dispatch.formulas import evaluate
from ...dispatch.item_statuses import invalidate_nonfinite, raise_first
from ..trees.poses import PoseDriver, PoseParameters
from .coordinates import Coordinates, read_coordinates
from .description import BY_MOTOR, MOVING, RobotJoint, joints_from_root
from .tree import LinkTree

Array = NDArray[Any]


class LinkPoses:
    """Poses of all links of a robot, compiled where they are first needed."""

    def __init__(self, robot: LinkTree) -> None:
        self._algebra, self._links = robot.algebra, robot.links
        joints = joints_from_root(robot.joints.values(), robot.root)
        heads: list[tuple[str, RobotJoint | None]] = [(robot.root, None)]
        heads += [(j.child, j) for j in joints if j.type in BY_MOTOR]
        owner = {robot.root: robot.root}
        for joint in joints:
            owner[joint.child] = joint.child if joint.type in BY_MOTOR else owner[joint.parent]
        self._parts = []
        for head, mover in heads:
            links = [name for name in robot.links if owner[name] == head]
            within = [j for j in joints if owner[j.child] == head and j.child != head]
            origin = None if mover is None else self._algebra.motor_from_matrix(mover.origin).as_kind("motor")
            self._parts.append((head, mover, origin, links, _Part(robot, head, links, within)))

    def poses(self, q: Coordinates, strict: bool, threads: int | None) -> dict[str, Multivector]:
        """Motors (...) of the links, in their order."""
        algebra, found = self._algebra, dict[str, Multivector]()
        kind = algebra.kind("motor")
        x = q.x.reshape(-1, q.x.shape[-1]) if q.x.shape[-1] else np.zeros((int(np.prod(q.shape)), 0))
        is_finite = bool(np.isfinite(x).all())
        for _, joint, origin, links, part in self._parts:
            motors = part.poses(x, threads)
            base = None
            if joint is not None:
                assert origin is not None
                base = (found[joint.parent] * _displaced(origin, joint, q.motors.get(joint.name))).as_kind("motor")
            for name, data in zip(links, motors, strict=True):
                motor = algebra.wrap(kind, data.reshape(*q.shape, 8))
                motor = motor if base is None else (base * motor).as_kind("motor")
                found[name] = motor if is_finite and not q.motors else invalidate_nonfinite(motor)
                if strict:
                    raise_first(found[name]._status, f"poses: {name}")
        return {name: found[name] for name in self._links}


def _displaced(origin: Multivector, joint: RobotJoint, motor: Multivector | None) -> Multivector:
    """The motor of a joint's origin, displaced about the joint's position."""
    if motor is None:
        return origin
    shift: Multivector = origin.algebra.translator(joint.position)
    return origin * shift * motor * ~shift if joint.position.any() else origin * motor


class _Part:
    """Links that joints with one coordinate move, relative to the first of them."""

    def __init__(self, robot: LinkTree, head: str, links: Sequence[str], joints: Sequence[RobotJoint]) -> None:
        algebra, zero = robot.algebra, robot.frames_at_zero
        inverse = np.linalg.inv(zero[head])
        # a frame in itself is the identity, which its inverse times itself need not be
        frames = {name: np.eye(4) if name == head else inverse @ zero[name] for name in links}
        if head == robot.root:
            frames = {name: zero[name] for name in links}
        moving = [joint for joint in joints if joint.type in MOVING]
        carrier = {head: -1}
        for joint in joints:
            carrier[joint.child] = moving.index(joint) if joint.type in MOVING else carrier[joint.parent]
        motors = algebra.motor_from_matrix(np.stack([frames[name] for name in links]), strict=True)
        self._fixed = None if moving else np.asarray(motors.as_kind("motor").values)
        if not moving:
            return
        at = {joint.child: frames[joint.child] for joint in moving}
        positions = np.stack([at[j.child][:3, :3] @ j.position + at[j.child][:3, 3] for j in moving])
        axes = np.stack([at[j.child][:3, :3] @ j.axis for j in moving])
        parents = np.array([carrier[j.parent] for j in moving])
        base = positions[0]
        offsets = positions - np.where(parents[:, None] >= 0, positions[parents], base)
        ratios = np.array([1.0 if j.follows is None else j.follows.multiplier for j in moving])
        turns = np.array([j.type != "prismatic" for j in moving], float)
        advances = np.array([1.0 if j.type == "prismatic" else j.pitch for j in moving])
        names = [j.name if j.follows is None else j.follows.joint for j in moving]
        rotors = evaluate(algebra, "motions.motor_parts", motors).values[0]
        carriers = np.array([carrier[name] for name in links])
        places = np.stack([frames[name][:3, 3] for name in links])
        places = places - np.where(carriers[:, None] >= 0, positions[carriers], base)
        self._driver = PoseDriver(
            algebra.name,
            PoseParameters(
                np.column_stack([offsets, axes, turns * ratios, advances * ratios]), parents,
                np.array([robot.joint_names.index(name) for name in names]),
                np.column_stack([places, rotors.as_kind("rotor", check=False).values]), carriers, base,
            ),
        )  # fmt: skip

    def poses(self, x: Array, threads: int | None) -> Array:
        """Motors (links, items, 8), for coordinates (items, n)."""
        if self._fixed is not None:
            return np.repeat(self._fixed[:, None], len(x), 1)
        return self._driver.poses(x, threads)


class PosedTree(LinkTree):
    """Links in a tree of joints, with their poses."""

    def poses(self, q: Any = None, *, strict: bool = False, threads: int | None = None) -> dict[str, Multivector]:
        """Motors of all links' frames, in the frame of the root, by name; compiled, in batches.

        Parameters
        ----------
        q : array (..., n), or mapping, optional
            Coordinates, radians and lengths, in the order of `joint_names`; or by name (...), zero where there is none.
            A ball, planar or floating joint takes a motor, the displacement of its child in the frame that this has at
            zero, or with an array of `nq` numbers those of `coordinate_slices`. Default: zero.
        strict : bool
            Raise for coordinates that are not finite; otherwise their items are NaN and INVALID.
        threads : int, optional
            Default: the package's (`bladesmith.set_threads`).

        Returns
        -------
        dict of str to Multivector of motors (...)

        Raises
        ------
        InputError, ShapeError
            If a name is not that of a joint with coordinates of its own, or numbers are missing.
        """
        return self._link_poses.poses(read_coordinates(self, q), as_bool(strict, "strict"), threads)

    @cached_property
    def _link_poses(self) -> LinkPoses:
        return LinkPoses(self)

    def pose_at(self, q: Any) -> dict[str, Multivector]:
        """Poses of links at one set of finite coordinates."""
        coordinates = read_coordinates(self, q)
        if coordinates.shape:
            raise ShapeError(f"q is for a batch {coordinates.shape}; one pose is needed.")
        return self._link_poses.poses(coordinates, True, 1)
