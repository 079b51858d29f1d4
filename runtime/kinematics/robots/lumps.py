"""Links that are welded to each other, as one body: inertias composed about the common center of mass.

`Robot.lumps` has them by name; inverse dynamics takes `Lump.inertia` as it is, a simulation the nearest valid one.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .description import LinkInertia, RobotJoint, homogeneous, joints_from_root

Array = NDArray[Any]


@dataclass(frozen=True, eq=False)
class Lump:
    """Links that fixed joints weld to one.

    Attributes
    ----------
    name : str
        The link that is nearest to the root; its frame is the lump's.
    links : dict of str to array (4, 4)
        The links, and their frames in the lump's.
    joint : RobotJoint or None
        The joint that moves the lump; None: that of the root.
    inertia : LinkInertia or None
        Of all links together, in the lump's frame, as the file has it, valid or not; None without mass. Of one link it
        is that link's own, else `origin` is along the lump's axes.
    parts : tuple of LinkInertia
        The links' inertias in the lump's frame, which `inertia` is composed of.
    """

    name: str
    links: dict[str, Array]
    joint: RobotJoint | None
    inertia: LinkInertia | None
    parts: tuple[LinkInertia, ...] = ()

    @property
    def words(self) -> str:
        """Text for messages."""
        more = f", with {len(self.links) - 1} welded to it" if len(self.links) > 1 else ""
        return f"<link name={self.name!r}>{more}"


def lumps_of(
    joints: Iterable[RobotJoint], root: str, inertias: Mapping[str, LinkInertia]
) -> tuple[dict[str, Lump], dict[str, str]]:
    """Lumps by name, parents first, and the name of the lump of each link.

    A link without mass and moments counts as without inertia.
    """
    own: dict[str, str] = {root: root}
    frames: dict[str, dict[str, Array]] = {root: {root: np.eye(4)}}
    movers: dict[str, RobotJoint | None] = {root: None}
    for joint in joints_from_root(joints, root):
        if joint.type == "fixed":
            lump = own[joint.parent]
            own[joint.child] = lump
            frames[lump][joint.child] = frames[lump][joint.parent] @ joint.origin
        else:
            own[joint.child] = joint.child
            frames[joint.child], movers[joint.child] = {joint.child: np.eye(4)}, joint
    lumps = {}
    for name, links in frames.items():
        parts = [
            LinkInertia(inertias[link].mass, inertias[link].tensor, frame @ inertias[link].origin)
            for link, frame in links.items()
            if link in inertias and _is_felt(inertias[link])
        ]
        lumps[name] = Lump(name, links, movers[name], compose_inertias(parts), tuple(parts))
    return lumps, own


def _is_felt(inertia: LinkInertia) -> bool:
    return bool(inertia.mass != 0 or inertia.tensor.any())


def compose_inertias(parts: Sequence[LinkInertia]) -> LinkInertia | None:
    """Inertia of bodies together, all in one frame; None of no bodies.

    Tensors are moved to the common center by the parallel-axis theorem.
    """
    if len(parts) < 2:
        return parts[0] if parts else None
    masses, centers = np.array([part.mass for part in parts]), np.stack([part.center for part in parts])
    mass = float(masses.sum())
    center = masses @ centers / mass if mass else centers.mean(0)
    tensor = np.zeros((3, 3))
    for part, x in zip(parts, centers - center, strict=True):
        tensor += part.tensor_along_link + part.mass * (x @ x * np.eye(3) - np.outer(x, x))
    return LinkInertia(mass, (tensor + tensor.T) / 2, homogeneous(np.eye(3), center))
