"""Robots from URDF files: chains to their links, mechanisms, rigid bodies (parsed by yourdfpy, the extra ``urdf``)."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.errors import InputError, suggest
from ...common.validation import as_choice, check_shape, finite_array, real_array
from ...core.multivector import Multivector
from ...mechanics.screws import geometry
from .elements import MOVING, UrdfJoint, inertia_of, joint_of, parse_robot
from .parser import Text, bytes_of

if TYPE_CHECKING:
    from ...core.multivector import Algebra
    from ...mechanics.joints.base import Joint
    from ...mechanics.rigid_body import RigidBody
    from ...mechanics.system import System
    from ..mechanism.mechanism import Mechanism
    from ..serial.chain import Chain

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
        Joints that follow others are refused, or treated as independent joints.
    ignore : list of str
        Unknown tags that may be left out.

    Raises
    ------
    InputError
        With file, line and tag: no such file, not XML, a document type (entities are neither expanded nor fetched),
        duplicate names, missing parents or children, links that are not connected, loops, axes of length zero,
        numbers that are not finite, unknown types of joints and tags. Visuals, contacts, transmissions and tags for
        simulators are left out.
    MissingExtraError
        Without yourdfpy: the extra ``urdf``.
    """
    if isinstance(ignore, str):
        raise InputError(f"ignore is {ignore!r}; a list of tags is needed.")
    home = geometry(algebra)
    text = Text(str(path), bytes_of(path), as_choice(mimic, "mimic", MIMIC), ignore)
    return Robot(text, home)


#: Methods of a robot that are those of its mechanism.
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
    """A tree of links, in the frame of the root link.

    Methods of a `Mechanism` (`mobility`, `jacobian`, `solve`, `solve_pose`, ...) are those of its `mechanism()`, where
    all coordinates are zero.

    Attributes
    ----------
    name, root : str
    links : tuple of str
    joints : dict of str to UrdfJoint
        In the order of the file.
    inertias : dict of str to UrdfInertia
        Inertias of the links that have one.
    """

    def __init__(self, text: Text, algebra: Algebra) -> None:
        robot = parse_robot(text)
        self.path, self.algebra, self.name = text.path, algebra, str(robot.name)
        self.links = tuple(link.name for link in robot.links)
        elements = {str(x.get("name")): x for x in text.root.findall("joint")}
        self.joints = {j.name: joint_of(j, text, elements[j.name]) for j in robot.joints}
        self.inertias = {x.name: inertia_of(x.inertial) for x in robot.links if x.inertial is not None}
        self._above = {j.child: j for j in self.joints.values()}
        self.root: str = next(name for name in self.links if name not in self._above)

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
        """Limits (n, 2) of `joint_names`."""
        return np.array([self.joints[name].limits for name in self.joint_names]).reshape(-1, 2)

    # -- poses -----------------------------------------------------------------------------------------------

    def poses(self, q: Any = None) -> dict[str, Multivector]:
        """Motor of every link's frame, for coordinates by name or in the order of `joint_names`; default: zero."""
        values = self._coordinates(q)
        one = self.algebra.translator(np.zeros(3)).as_kind("motor")
        origins = self._origins()
        motors = {self.root: one}
        for joint in self._joints_from_root():
            motor = motors[joint.parent] * origins[joint.name]
            if values.get(joint.name):
                motor = motor * (-values[joint.name] / 2 * self._joint_twist(joint)).exp()
            motors[joint.child] = motor.as_kind("motor")
        return {name: motors[name] for name in self.links}

    def _coordinates(self, q: Any) -> dict[str, float]:
        names = self.joint_names
        if q is None:
            return {}
        if isinstance(q, Mapping):
            for name in q:
                if name not in names:
                    raise InputError(f"{name!r} is not a moving joint of {self.name!r}{suggest(name, names)}.")
            return {name: float(finite_array(value, f"q[{name!r}]")) for name, value in q.items()}
        values = np.asarray(real_array(q, "q"), np.float64)
        check_shape(values, "q", (len(names),), remedy=f"It is for {', '.join(names)}")
        values = finite_array(values, "q")
        return dict(zip(names, values.tolist(), strict=True))

    def _joints_from_root(self) -> list[UrdfJoint]:
        """Joints, parents first."""
        below: dict[str, list[UrdfJoint]] = {}
        for joint in self.joints.values():
            below.setdefault(joint.parent, []).append(joint)
        joints, front = [], [self.root]
        while front:
            children = below.get(front.pop(), [])
            joints += children
            front += [joint.child for joint in children]
        return joints

    def _origins(self) -> dict[str, Multivector]:
        if not self.joints:
            return {}
        matrices = np.stack([joint.origin for joint in self.joints.values()])
        motors = self.algebra.motor_from_matrix(matrices, strict=True)
        return {name: motors[i] for i, name in enumerate(self.joints)}

    def _joint_twist(self, joint: UrdfJoint) -> Multivector:
        """The twist of a joint in the child's frame."""
        from ..serial.axes import prismatic_axis, revolute_axis

        if joint.type == "prismatic":
            return prismatic_axis(joint.axis, self.algebra)
        return revolute_axis(np.zeros(3), joint.axis, self.algebra)

    # -- chains, mechanisms, bodies ------------------------------------------------------------------------------------

    def chain(self, tip: str, root: str | None = None, target: str = "c") -> Chain:
        """The chain of joints from one link to another, with names and limits; the tool is the frame of ``tip``.

        Parameters
        ----------
        tip : str
        root : str, optional
            The fixed link, whose frame is the world's. Default: the root of the file. Joints between it and the common
            ancestor are passed in reverse.
        target : {"c", "numba"}
            As of `Chain`.

        Raises
        ------
        InputError
            If there is no such link, no joint between the links, or one that is floating or planar.
        """
        from ..serial.axes import join_axes
        from ..serial.chain import Chain

        start = self.root if root is None else root
        paths = [self._joints_to_root(name) for name in (start, tip)]
        while paths[0] and paths[1] and paths[0][-1] is paths[1][-1]:
            paths[0].pop()
            paths[1].pop()
        signed = [(joint, -1.0) for joint in paths[0]] + [(joint, 1.0) for joint in reversed(paths[1])]
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
        frames_at_zero = {name: (~poses[start] * poses[name]).as_kind("motor") for name in self.links}
        axes = [sign * (frames_at_zero[joint.child] >> self._joint_twist(joint)) for joint, sign in moving]
        frames = [frames_at_zero[joint.child if sign > 0 else joint.parent] for joint, sign in moving]
        data = np.stack([frame.values for frame in frames])
        names, limits = [joint.name for joint, _ in moving], [joint.limits for joint, _ in moving]
        return Chain(
            join_axes(axes), frames_at_zero[tip], names, limits,
            frames=self.algebra.wrap(frames[0].kind, data), target=target,
        )  # fmt: skip

    def _joints_to_root(self, link: Any) -> list[UrdfJoint]:
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

    def mechanism(self, q: Any = None, root: str | None = None) -> Mechanism:
        """Links as bodies, and the joints between them by their names, at coordinates: see `poses`.

        Welded links are joined by `Rigid`.

        Parameters
        ----------
        q : array or mapping, optional
        root : str, optional
            The fixed link; parts that float relative to it are left out. Default: the root of the file.

        Raises
        ------
        InputError
            If a joint is floating and no root was given: joints connect all bodies of a mechanism.
        """
        from ..mechanism.mechanism import Mechanism

        floating = next((joint for joint in self.joints.values() if joint.type == "floating"), None)
        if floating is not None and root is None:
            raise InputError(
                f"{floating.name!r} is floating: nothing holds {floating.child!r} to the rest.", where=self.path,
                remedy=f"Take the parts, such as mechanism(root={floating.child!r})",
            )  # fmt: skip
        start = self.root if root is None else root
        self._joints_to_root(start)  # checks the name
        parts = {self.root: self.root}
        for joint in self._joints_from_root():
            parts[joint.child] = joint.child if joint.type == "floating" else parts[joint.parent]
        links = [name for name in self.links if parts[name] == parts[start]]
        mechanism, poses = Mechanism(links, start), self.poses(q)
        for joint in self.joints.values():
            if joint.child in links and joint.parent in links:
                shared = self._shared_joint(joint, poses)
                if shared is not None:
                    mechanism.add(shared, unused_name(joint.name, links))
        return mechanism

    def _shared_joint(self, joint: UrdfJoint, poses: Mapping[str, Multivector]) -> Joint | None:
        """The joint as geometry that two bodies share."""
        from ...mechanics.joints.standard import Planar, Prismatic, Revolute, Rigid

        if joint.type == "floating":
            return None
        a, b = joint.parent, joint.child
        matrix = self.algebra.matrix(poses[joint.child])
        position, axis = matrix[:3, 3], matrix[:3, :3] @ joint.axis
        if joint.type == "fixed":
            return Rigid(a, b, position, self.algebra)
        if joint.type == "planar":
            return Planar(a, b, self.algebra.plane(axis, float(position @ axis)))
        line = self.algebra.line(position, axis)
        if joint.type == "prismatic":
            across = np.cross(axis, np.eye(3)[np.abs(axis).argmin()])
            return Prismatic(a, b, line, self.algebra.direction(across / np.linalg.norm(across)))
        return Revolute(a, b, line, self.algebra.point(position))

    def bodies(self, q: Any = None) -> dict[str, RigidBody]:
        """A `dynamics.RigidBody` at rest for every link that has a mass, at coordinates: see `poses`."""
        from ...mechanics.rigid_body import RigidBody

        poses, bodies = self.poses(q), {}
        for name, inertia in self.inertias.items():
            if not inertia.mass > 0:
                continue
            frame = self.algebra.matrix(poses[name]) @ inertia.origin
            motor = self.algebra.motor_from_matrix(frame)
            try:
                bodies[name] = RigidBody(inertia.mass, inertia.tensor, orientation=motor, algebra=self.algebra)
            except InputError as error:
                raise InputError(f"the inertia of <link name={name!r}>: {error}", where=self.path) from None
        return bodies

    def system(self, q: Any = None) -> System:
        """The robot as a `dynamics.System` at coordinates: see `poses`. Welded links stay welded.

        Raises
        ------
        InputError
            If a moving link has no mass, and carries links that have.
        """
        from ...mechanics.system import System

        bodies, poses = self.bodies(q), self.poses(q)
        bodies.pop(self.root, None)
        heavy = {name for name in bodies}
        for joint in reversed(self._joints_from_root()):  # links that carry others must have a mass
            if joint.child in heavy:
                heavy.add(joint.parent)
        missing = sorted(heavy - {self.root} - set(bodies))
        if missing:
            raise InputError(
                f"<link name={missing[0]!r}> moves, carries others, and has no mass.", where=self.path,
                remedy="Give it an <inertial> with a mass",
            )  # fmt: skip
        joints = (self._shared_joint(j, poses) for j in self.joints.values() if j.child in bodies)
        return System(bodies, [joint for joint in joints if joint is not None], fixed=self.root)


def unused_name(name: str, used_names: Iterable[str]) -> str:
    """A joint's name, which no link has."""
    while name in used_names:
        name += "_joint"
    return name


def urdf_example(name: str) -> Path:
    """The path of a robot that comes with the package: "arm" (six axes) or "scara" (four)."""
    folder = Path(__file__).parent / "data"
    names = sorted(x.stem for x in folder.glob("*.urdf"))
    return folder / f"{as_choice(name, 'the robot', names)}.urdf"
