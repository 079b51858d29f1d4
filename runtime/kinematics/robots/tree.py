"""Links and joints of a robot: coordinates, poses, lumps, parts."""

from __future__ import annotations

import warnings
from collections.abc import Iterable
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.errors import InputError, suggest
from ...common.validation import as_choice
from ..trees.frame_joints import NEUTRAL, SIZES
from .description import MOVING, Description, Follower, RobotJoint, joints_from_root, zero_frames
from .inertias import IMPOSSIBLE
from .lumps import Lump, lumps_of

if TYPE_CHECKING:
    from ...core.multivector import Algebra

Array = NDArray[Any]
#: A robot that is larger, in metres, is probably in millimetres.
LARGEST = 50.0


class LinkTree:
    """Links in a tree of joints: what a `Robot` is made of, which has its attributes."""

    def __init__(self, description: Description, algebra: Algebra, impossible: str = "error") -> None:
        self.impossible = as_choice(impossible, "impossible", IMPOSSIBLE)
        self.description, self.algebra = description, algebra
        self.path, self.name, self.links = description.path, description.name, description.links
        self.joints, self.inertias, self.loops = description.joints, description.inertias, description.loops
        self._above = {j.child: j for j in self.joints.values()}
        self.root: str = next(name for name in self.links if name not in self._above)
        self.joints_in_order = joints_from_root(self.joints.values(), self.root)
        self.frames_at_zero = zero_frames(self.joints.values(), self.root)
        self.size = max(float(np.linalg.norm(frame[:3, 3])) for frame in self.frames_at_zero.values())
        if self.size > LARGEST:
            warnings.warn(
                f"{self.path}: the robot is {self.size:.4g} long; if these are millimetres, torques and motions under "
                "gravity will be wrong: lengths are in metres.",
                stacklevel=3,
            )

    def __getstate__(self) -> dict[str, Any]:
        """State without what is compiled: another process builds its own."""
        return {name: value for name, value in self.__dict__.items() if name not in ("_link_poses", "tree")}

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Joints with a coordinate of their own, in the order of the file."""
        return tuple(j.name for j in self.joints.values() if j.type in MOVING and j.follows is None)

    @cached_property
    def coordinate_slices(self) -> dict[str, slice]:
        """Where coordinates of each joint are in arrays (..., nq): in the order of the file.

        A joint that floats has x, y, z of its displacement and a unit quaternion x, y, z, w, a ball the quaternion, a
        planar joint x, y, cosine and sine, as in Pinocchio; others one.
        """
        return self._slices(0)

    @cached_property
    def speed_slices(self) -> dict[str, slice]:
        """Where speeds, accelerations and forces of each joint are in arrays (..., nv).

        Those of a joint that floats are the velocity of its child's origin and the angular velocity, along the child's
        axes; of a ball the angular velocity; of a planar joint two of the velocity, and that of the rotation.
        """
        return self._slices(1)

    def _slices(self, which: int) -> dict[str, slice]:
        found, start = dict[str, slice](), 0
        for joint in self.joints.values():
            if joint.type != "fixed" and joint.follows is None:
                size = SIZES.get(joint.type, (1, 1))[which]
                found[joint.name] = slice(start, start + size)
                start += size
        return found

    @property
    def nq(self) -> int:
        """Number of coordinates of all joints."""
        return max((part.stop for part in self.coordinate_slices.values()), default=0)

    @property
    def nv(self) -> int:
        """Number of speeds of all joints."""
        return max((part.stop for part in self.speed_slices.values()), default=0)

    @property
    def neutral(self) -> Array:
        """Coordinates (nq,) where all joints are at zero."""
        q = np.zeros(self.nq)
        for name, part in self.coordinate_slices.items():
            q[part] = NEUTRAL.get(self.joints[name].type, 0.0)
        return q

    @property
    def followers(self) -> dict[str, Follower]:
        """What the coordinates of joints follow that have none of their own (`<mimic>`)."""
        return {j.name: j.follows for j in self.joints.values() if j.follows is not None}

    def couplings(self, present: Iterable[str]) -> list[dict[str, float]]:
        """Linear relations of the joints that are present: coefficients of their displacements, whose sum is zero.

        Where a leader is not there, its followers are coupled to the first of them.
        """
        groups: dict[str, dict[str, float]] = {}
        for name in present:
            follows = self.joints[name].follows
            if follows is not None:
                groups.setdefault(follows.joint, {})[name] = follows.multiplier
        found = []
        for leader, ratios in groups.items():
            members = ({leader: 1.0} if leader in present else {}) | ratios
            (first, own), *others = members.items()
            found += [{name: own, first: -ratio} for name, ratio in others if own or ratio]
        return found

    @property
    def limits(self) -> Array:
        """Limits (n, 2) of `joint_names`, those of joints that follow included where all can be kept."""
        limits = {name: self.joints[name].limits for name in self.joint_names}
        for name, follows in self.followers.items():
            if follows.multiplier:
                ends = np.sort((self.joints[name].limits - follows.offset) / follows.multiplier)
                low, high = limits[follows.joint]
                both = np.array([max(low, ends[0]), min(high, ends[1])])
                limits[follows.joint] = both if both[0] < both[1] else limits[follows.joint]
        return np.array([*limits.values()]).reshape(-1, 2)

    def joints_to_root(self, link: Any) -> list[RobotJoint]:
        """Joints from a link up to the root."""
        if link not in self.links:
            raise InputError(
                f"there is no link {link!r} in {self.name!r}{suggest(link, self.links)}; there are: "
                f"{', '.join(self.links)}."
            )
        path = []
        while link in self._above:
            path.append(self._above[link])
            link = path[-1].parent
        return path

    @cached_property
    def _lumps(self) -> tuple[dict[str, Lump], dict[str, str]]:
        return lumps_of(self.joints.values(), self.root, self.inertias)

    @property
    def lumps(self) -> dict[str, Lump]:
        """Links that are welded to each other, as one body each, by the name of the link nearest to the root."""
        return self._lumps[0]

    @property
    def lump_of(self) -> dict[str, str]:
        """The name of the lump that each link belongs to."""
        return self._lumps[1]

    @cached_property
    def parts(self) -> dict[str, str]:
        """For each link the first one that it hangs together with, by joints that do not float and by loops."""
        parts = {self.root: self.root}
        for joint in self.joints_in_order:
            parts[joint.child] = joint.child if joint.type == "floating" else parts[joint.parent]
        for loop in self.loops:
            first, other = sorted((parts[loop.a], parts[loop.b]), key=self.links.index)
            if first != other:
                parts = {name: first if part == other else part for name, part in parts.items()}
        return parts

    @property
    def largest_part(self) -> str:
        """The root, or if it holds nothing that moves the first link of the largest part that floats."""
        parts = self.parts
        counts = {part: sum(parts[j.child] == part and j.type in MOVING for j in self.joints.values()) for part in
                  dict.fromkeys(parts.values())}
        return self.root if counts[self.root] else max(counts, key=lambda part: counts[part])

    def most_moved(self, root: str) -> str:
        """The link with the most moving joints between it and a root above it; the last one of several."""
        self.joints_to_root(root)  # a link that is there
        counts = {root: 0}
        for joint in self.joints_in_order:
            if joint.parent in counts and joint.type not in ("ball", "planar", "floating"):
                counts[joint.child] = counts[joint.parent] + (joint.type != "fixed")
        most = max(counts.values())
        return [name for name in self.links if counts.get(name) == most][-1]  # behind what is welded to it
