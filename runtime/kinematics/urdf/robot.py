"""Robots from URDF files: chains to their links, mechanisms, rigid bodies (parsed by yourdfpy, the extra ``urdf``)."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..codegen.errors import InputError, suggest
from ..dynamics.given import finite
from ..dynamics.screws import geometry
from ..multivector import Multivector
from ..objects.inputs import chosen
from .urdf_read import MOVING, UrdfJoint, inertia_of, joint_of, parsed
from .urdf_text import Text, bytes_of

if TYPE_CHECKING:
    from ..algebras import Algebra
    from ..dynamics.bodies import RigidBody
    from ..dynamics.system import System
    from .chains import Chain
    from .joints import Joint
    from .mechanism import Mechanism

Array = NDArray[Any]
MIMIC = ("error", "free")


def load_urdf(
    path: str | os.PathLike[str],
    algebra: Algebra | None = None,
    *,
    mimic: str = "error",
    ignore: Iterable[str] = (),
) -> Robot:
    """A robot from a URDF file.

    Parameters
    ----------
    path : str or path
    algebra : Algebra, optional
        `bladesmith.cga3d` (default) or `pga3d`.
    mimic : {"error", "free"}
        Joints that follow others are refused, or are joints of their own.
    ignore : list of str
        Tags that may be left out although they are not known.

    Raises
    ------
    InputError
        With file, line and tag: no such file, no XML, a document type (entities are neither expanded nor fetched),
        doubled names, missing parents or children, links that are not connected, loops, axes of no length, numbers
        that are none, types of joints and tags that are not known. Looks, contacts, transmissions and what is meant
        for simulators are left out.
    MissingExtraError
        Without yourdfpy: the extra ``urdf``.
    """
    if isinstance(ignore, str):
        raise InputError(f"ignore is {ignore!r}; a list of tags is needed.")
    home = geometry(algebra)
    text = Text(str(path), bytes_of(path), chosen(mimic, MIMIC, "mimic"), ignore)
    return Robot(text, home)


#: What a robot answers as its mechanism does.
_OF_MECHANISM = frozenset(
    {
        "allowed_twists",
        "analysis",
        "at",
        "constraint_matrix",
        "free_motions",
        "jacobian",
        "mobility",
        "moving",
        "rank",
        "redundant",
        "residual",
        "residuals",
        "solve",
        "solve_pose",
    }  # fmt: skip
)


class Robot:
    """A tree of links. All is in the frame of the root link.

    What a `Mechanism` answers (`mobility`, `jacobian`, `solve`, `solve_pose`, ...) a robot does too: as its
    `mechanism()`, where all coordinates are zero.

    Attributes
    ----------
    name, root : str
    links : tuple of str
    joints : dict of str to UrdfJoint
        In the order of the file.
    inertias : dict of str to UrdfInertia
        Of the links that have some.
    """

    def __init__(self, text: Text, algebra: Algebra) -> None:
        found = parsed(text)
        self.path, self.algebra, self.name = text.path, algebra, str(found.name)
        self.links = tuple(link.name for link in found.links)
        elements = {str(x.get("name")): x for x in text.root.findall("joint")}
        self.joints = {j.name: joint_of(j, text, elements[j.name]) for j in found.joints}
        self.inertias = {x.name: inertia_of(x.inertial) for x in found.links if x.inertial is not None}
        self._above = {j.child: j for j in self.joints.values()}
        self.root = next(name for name in self.links if name not in self._above)

    def __repr__(self) -> str:
        return f"<Robot {self.name!r}: {len(self.links)} links, {len(self.joint_names)} moving joints>"

    def __getattr__(self, name: str) -> Any:
        if name in _OF_MECHANISM:
            return getattr(self._at_zero, name)
        raise AttributeError(f"a Robot has no {name!r}.")

    @cached_property
    def _at_zero(self) -> Mechanism:
        return self.mechanism()

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Joints with a coordinate, in the order of the file."""
        return tuple(j.name for j in self.joints.values() if j.type in MOVING)

    @property
    def limits(self) -> Array:
        """Of `joint_names` (n, 2)."""
        return np.array([self.joints[name].limits for name in self.joint_names]).reshape(-1, 2)

    # -- poses -----------------------------------------------------------------------------------------------

    def poses(self, q: Any = None) -> dict[str, Multivector]:
        """Motor of every link's frame, for coordinates by name, or in the order of `joint_names`; 0 where left out."""
        values = self._coordinates(q)
        one = self.algebra.translator(np.zeros(3)).as_kind("motor")
        origins = self._origins()
        found = {self.root: one}
        for joint in self._ordered():
            motor = found[joint.parent] * origins[joint.name]
            if values.get(joint.name):
                motor = motor * (-values[joint.name] / 2 * self._own_axis(joint)).exp()
            found[joint.child] = motor.as_kind("motor")
        return {name: found[name] for name in self.links}

    def _coordinates(self, q: Any) -> dict[str, float]:
        names = self.joint_names
        if q is None:
            return {}
        if isinstance(q, Mapping):
            for name in q:
                if name not in names:
                    raise InputError(f"{name!r} is no moving joint of {self.name!r}{suggest(name, names)}.")
            return {name: float(finite(value, f"q[{name!r}]")) for name, value in q.items()}
        values = finite(q, "q")
        if values.shape != (len(names),):
            raise InputError(f"q has shape {values.shape}; {(len(names),)} is needed, for {', '.join(names)}.")
        return dict(zip(names, values.tolist(), strict=True))

    def _ordered(self) -> list[UrdfJoint]:
        """From the root outwards."""
        below: dict[str, list[UrdfJoint]] = {}
        for joint in self.joints.values():
            below.setdefault(joint.parent, []).append(joint)
        found, front = [], [self.root]
        while front:
            own = below.get(front.pop(), [])
            found += own
            front += [joint.child for joint in own]
        return found

    def _origins(self) -> dict[str, Multivector]:
        if not self.joints:
            return {}
        matrices = np.stack([joint.origin for joint in self.joints.values()])
        motors = self.algebra.motor_from_matrix(matrices, strict=True)
        return {name: motors[i] for i, name in enumerate(self.joints)}

    def _own_axis(self, joint: UrdfJoint) -> Multivector:
        """The twist of a joint in the child's frame."""
        from .chains_axes import prismatic_axis, revolute_axis

        if joint.type == "prismatic":
            return prismatic_axis(joint.axis, self.algebra)
        return revolute_axis(np.zeros(3), joint.axis, self.algebra)

    # -- what is made of it ------------------------------------------------------------------------------------

    def chain(self, tip: str, root: str | None = None) -> Chain:
        """The chain of joints from one link to another, with names and limits; the tool is the frame of ``tip``.

        Parameters
        ----------
        tip : str
        root : str, optional
            The fixed link, whose frame is the world's. Default: the root of the file. Joints between it and where
            both ways meet are gone through backwards.

        Raises
        ------
        InputError
            If there is no such link, no joint on the way, or one that floats or is planar.
        """
        from .chains import Chain
        from .chains_axes import joined

        start = self.root if root is None else root
        ways = [self._way(name) for name in (start, tip)]
        while ways[0] and ways[1] and ways[0][-1] is ways[1][-1]:
            ways[0].pop()
            ways[1].pop()
        signed = [(joint, -1.0) for joint in ways[0]] + [(joint, 1.0) for joint in reversed(ways[1])]
        for joint, _ in signed:
            if joint.type not in (*MOVING, "fixed"):
                raise InputError(
                    f"{joint.name!r} is {joint.type}: a chain has joints with one coordinate.", where=self.path,
                    remedy="Take the mechanism, or a chain that begins behind it",
                )  # fmt: skip
        moving = [(joint, sign) for joint, sign in signed if joint.type in MOVING]
        if not moving:
            raise InputError(f"no joint moves between {start!r} and {tip!r}.", where=self.path)
        poses = self.poses()
        seen = {name: (~poses[start] * poses[name]).as_kind("motor") for name in self.links}
        axes = [sign * (seen[joint.child] >> self._own_axis(joint)) for joint, sign in moving]
        frames = [seen[joint.child if sign > 0 else joint.parent] for joint, sign in moving]
        data = np.stack([frame.values for frame in frames])
        return Chain(
            joined(axes), seen[tip], [joint.name for joint, _ in moving], [joint.limits for joint, _ in moving],
            frames=self.algebra.wrap(frames[0].kind, data),
        )  # fmt: skip

    def _way(self, link: Any) -> list[UrdfJoint]:
        """Joints from a link up to the root."""
        if link not in self.links:
            raise InputError(
                f"there is no link {link!r} in {self.name!r}{suggest(link, self.links)}; there are: "
                f"{', '.join(self.links)}."
            )
        found = []
        while link in self._above:
            found.append(self._above[link])
            link = found[-1].parent
        return found

    def mechanism(self, q: Any = None, root: str | None = None) -> Mechanism:
        """Links as bodies, and the joints between them by their names, at coordinates: see `poses`.

        Welded links are joined by `Rigid`.

        Parameters
        ----------
        q : array or mapping, optional
        root : str, optional
            The fixed link; what floats against it is left out. Default: the root of the file.

        Raises
        ------
        InputError
            If something floats and no root was given: a mechanism is held together by its joints.
        """
        from .mechanism import Mechanism

        floating = next((joint for joint in self.joints.values() if joint.type == "floating"), None)
        if floating is not None and root is None:
            raise InputError(
                f"{floating.name!r} is floating: nothing holds {floating.child!r} to the rest.", where=self.path,
                remedy=f"Take the parts, such as mechanism(root={floating.child!r})",
            )  # fmt: skip
        start = self.root if root is None else root
        self._way(start)  # checks the name
        parts = {self.root: self.root}
        for joint in self._ordered():
            parts[joint.child] = joint.child if joint.type == "floating" else parts[joint.parent]
        links = [name for name in self.links if parts[name] == parts[start]]
        made, poses = Mechanism(links, start), self.poses(q)
        for joint in self.joints.values():
            if joint.child in links and joint.parent in links:
                shared = self._shared(joint, poses)
                if shared is not None:
                    made.add(shared, _free_name(joint.name, links))
        return made

    def _shared(self, joint: UrdfJoint, poses: Mapping[str, Multivector]) -> Joint | None:
        """The joint as geometry that two bodies share."""
        from .joints import Planar, Prismatic, Revolute, Rigid

        if joint.type == "floating":
            return None
        a, b = joint.parent, joint.child
        matrix = self.algebra.matrix(poses[joint.child])
        place, axis = matrix[:3, 3], matrix[:3, :3] @ joint.axis
        if joint.type == "fixed":
            return Rigid(a, b, place, self.algebra)
        if joint.type == "planar":
            return Planar(a, b, self.algebra.plane(axis, float(place @ axis)))
        line = self.algebra.line(place, axis)
        if joint.type == "prismatic":
            across = np.cross(axis, np.eye(3)[np.abs(axis).argmin()])
            return Prismatic(a, b, line, self.algebra.direction(across / np.linalg.norm(across)))
        return Revolute(a, b, line, self.algebra.point(place))

    def bodies(self, q: Any = None) -> dict[str, RigidBody]:
        """A `dynamics.RigidBody` at rest for every link that has a mass, at coordinates: see `poses`."""
        from ..dynamics.bodies import RigidBody

        poses, found = self.poses(q), {}
        for name, inertia in self.inertias.items():
            if not inertia.mass > 0:
                continue
            frame = self.algebra.matrix(poses[name]) @ inertia.origin
            motor = self.algebra.motor_from_matrix(frame)
            try:
                found[name] = RigidBody(inertia.mass, inertia.tensor, orientation=motor, algebra=self.algebra)
            except InputError as error:
                raise InputError(f"the inertia of <link name={name!r}>: {error}", where=self.path) from None
        return found

    def system(self, q: Any = None) -> System:
        """All of it as a `dynamics.System` at coordinates: see `poses`. What is welded is welded there, too.

        Raises
        ------
        InputError
            If a link that moves has no mass, and something hangs on it that has.
        """
        from ..dynamics.system import System

        bodies, poses = self.bodies(q), self.poses(q)
        bodies.pop(self.root, None)
        heavy = {name for name in bodies}
        for joint in reversed(self._ordered()):  # what carries something counts, and must have a mass
            if joint.child in heavy:
                heavy.add(joint.parent)
        missing = sorted(heavy - {self.root} - set(bodies))
        if missing:
            raise InputError(
                f"<link name={missing[0]!r}> moves, carries others, and has no mass.", where=self.path,
                remedy="Give it an <inertial> with a mass",
            )  # fmt: skip
        joints = (self._shared(j, poses) for j in self.joints.values() if j.child in bodies)
        return System(bodies, [joint for joint in joints if joint is not None], fixed=self.root)


def _free_name(name: str, taken: Iterable[str]) -> str:
    """A joint's name, which no link has."""
    while name in taken:
        name += "_joint"
    return name


def urdf_example(name: str) -> Path:
    """The path of a robot that comes with the package: "arm" (six axes) or "scara" (four)."""
    place = Path(__file__).parent / "data"
    known = sorted(x.stem for x in place.glob("*.urdf"))
    return place / f"{chosen(name, known, 'the robot')}.urdf"
