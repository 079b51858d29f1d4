"""Spanning trees of systems: links of one freedom each, and the bodies that they carry."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.algorithms.trees.motion_records import IN_BALL, PLAIN
from ...mechanics.joints.freedoms import Freedoms
from ...mechanics.system import System

Array = NDArray[Any]


@dataclass(frozen=True)
class TreeJoint:
    """A joint of the tree, or the six freedoms of a body that nothing holds.

    Attributes
    ----------
    index : int
        Of the joint in the system; -1 for none.
    body, parent : int
        The body that it moves, and the one that it is on; -1 is the world.
    freedoms : Freedoms
        Of the body relative to its parent.
    first : int
        Number of its first coordinate.
    is_reversed : bool
        Whether the body is the first one of the joint.
    """

    index: int
    body: int
    parent: int
    freedoms: Freedoms
    first: int
    is_reversed: bool


@dataclass
class SpanningTree:
    """A system by freedoms, one link for each, and the joints that close loops of them.

    Attributes
    ----------
    joints : list of TreeJoint
        Parents before their children.
    positions, axes : array (n, 3)
        A point of each freedom's axis and its direction, in the world at the start.
    turns : bool array (n,)
        Rotations.
    parents, balls : integer array (n,)
        See codegen/algorithms/trees/motion_records.py.
    carriers : integer array (bodies,)
        Link that carries each body.
    ends : integer array (n, 2)
        Bodies behind and before each freedom; -1 is the world.
    cuts : list of int
        Joints of the system that close loops.
    """

    joints: list[TreeJoint] = field(default_factory=list)
    positions: Array = field(default_factory=lambda: np.zeros((0, 3)))
    axes: Array = field(default_factory=lambda: np.zeros((0, 3)))
    turns: Array = field(default_factory=lambda: np.zeros(0, bool))
    advances: Array = field(default_factory=lambda: np.zeros(0))
    parents: Array = field(default_factory=lambda: np.zeros(0, np.int64))
    balls: Array = field(default_factory=lambda: np.zeros(0, np.int64))
    carriers: Array = field(default_factory=lambda: np.zeros(0, np.int64))
    ends: Array = field(default_factory=lambda: np.zeros((0, 2), np.int64))
    cuts: list[int] = field(default_factory=list)

    @property
    def count(self) -> int:
        """Number of freedoms."""
        return len(self.parents)

    def of_joint(self, index: int) -> TreeJoint | None:
        """The joint of the tree that is a joint of the system; None of one that closes a loop."""
        return next((joint for joint in self.joints if joint.index == index), None)

    def ranges(self) -> Array:
        """First and last link (n, 2) of what hangs together with each, without the world."""
        roots = np.flatnonzero(self.parents < 0)
        ends = np.append(roots[1:], self.count)
        return np.repeat(np.stack([roots, ends], -1), ends - roots, 0)


def spanning_tree(system: System) -> SpanningTree | str:
    """The spanning tree of a system, shallow from the world; or the reason why its joints have no coordinates."""
    names = list(system.bodies)
    number = {name: i for i, name in enumerate(names)} | {system.fixed: -1}
    unknown = next((j for j, own in zip(system.joints, system.freedoms, strict=True) if own is None), None)
    if unknown is not None:
        return f"{unknown.label} is no sequence of motions that is closed at the start"
    at: dict[int, list[int]] = {i: [] for i in range(-1, len(names))}
    for index, joint in enumerate(system.joints):
        for name in (joint.a, joint.b):
            at[number[name]].append(index)
    found: dict[int, list[TreeJoint]] = {i: [] for i in range(-1, len(names))}  # by parent
    reached, used, cuts = {-1}, set[int](), list[int]()
    for root in range(-1, len(names)):
        if root >= 0:
            if root in reached:
                continue
            center = np.reshape(system.bodies[names[root]].position, (-1, 3))[0]
            free = Freedoms(center, np.tile(np.eye(3), (2, 1)), np.repeat([False, True], 3), is_ball=True)
            found[-1].append(TreeJoint(-1, root, -1, free, 0, False))
            reached.add(root)
        waiting = deque([root])
        while waiting:
            parent = waiting.popleft()
            for index in at[parent]:
                if index in used:
                    continue
                used.add(index)
                joint, own = system.joints[index], system.freedoms[index]
                assert own is not None
                is_reversed = number[joint.b] == parent
                body = number[joint.a if is_reversed else joint.b]
                if body in reached:
                    cuts.append(index)
                    continue
                if parent < 0 and not len(own.axes):
                    return f"{joint.label} holds a body to the world"
                reached.add(body)
                found[parent].append(
                    TreeJoint(index, body, parent, own.reversed() if is_reversed else own, 0, is_reversed)
                )
                waiting.append(body)
    ordered, first, left = list[TreeJoint](), 0, found[-1][::-1]
    while left:  # what hangs together has numbers without gaps
        each = left.pop()
        ordered.append(replace(each, first=first))
        first += len(each.freedoms.axes)
        left += found[each.body][::-1]
    tree = _links(ordered, len(names))
    tree.cuts = cuts
    return tree


def _links(joints: list[TreeJoint], bodies: int) -> SpanningTree:
    """The links of a tree."""
    tree = SpanningTree(joints, carriers=np.full(bodies, -1))
    parents, balls, ends, ball = list[int](), list[int](), list[tuple[int, int]](), 0
    for joint in joints:
        carrier = -1 if joint.parent < 0 else int(tree.carriers[joint.parent])
        kinds = [PLAIN] * len(joint.freedoms.axes)
        if joint.freedoms.is_ball:
            kinds[-3:] = [ball, IN_BALL, IN_BALL]
            ball += 1
        for kind in kinds:
            parents.append(carrier)
            balls.append(kind)
            ends.append((joint.body, joint.parent))
            carrier = len(parents) - 1
        tree.carriers[joint.body] = carrier
    counts = [len(joint.freedoms.axes) for joint in joints]
    tree.positions = np.repeat([joint.freedoms.position for joint in joints], counts, 0)
    tree.axes = np.concatenate([joint.freedoms.axes for joint in joints])
    tree.turns = np.concatenate([joint.freedoms.turns for joint in joints])
    tree.advances = np.concatenate([joint.freedoms.advances for joint in joints])
    tree.parents, tree.balls = np.array(parents), np.array(balls)
    tree.ends = np.array(ends).reshape(-1, 2)
    return tree


__all__ = ["SpanningTree", "TreeJoint", "spanning_tree"]
