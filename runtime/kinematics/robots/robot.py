"""Robots as trees of links: poses, chains, mechanisms, bodies, systems."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.errors import InputError
from ...codegen.export.options import describes_options
from ...core.multivector import Multivector
from ..trees.dynamics import JointDynamics
from ..trees.tree import Tree
from .carried_links import carried_links, lumped_rows, refuse_followers, robot_tree
from .coordinates import joined_coordinates, joined_speeds
from .description import MOVING, RobotJoint
from .poses import PosedTree

if TYPE_CHECKING:
    from ...mechanics.rigid_body import RigidBody
    from ...mechanics.system import System
    from ..mechanism.mechanism import Mechanism
    from ..serial.chain import Chain

Array = NDArray[Any]
#: Methods of a robot that are those of its mechanism.
_OF_MECHANISM = frozenset({
    "allowed_twists", "analysis", "at", "constraint_matrix", "free_motions", "jacobian", "mobility", "moving", "rank",
    "redundant", "residual", "residuals", "self_stresses", "solve", "solve_pose",
})  # fmt: skip


class Robot(PosedTree, JointDynamics):
    """A tree of links, in the frame of the root link; made by `load_urdf`, `load_mjcf` and `load_sdf`.

    Methods of a `Mechanism` (`mobility`, `jacobian`, `solve`, `solve_pose`, ...) are those of its `mechanism()`, where
    all coordinates are zero. Torques and accelerations (`inverse_dynamics`, `forward_dynamics`, ...) take coordinates
    (..., nq) and speeds (..., nv) of all joints in the order of the file, see `coordinate_slices` and `speed_slices`:
    those of `joint_names` where each has one. Both may be given by the names of joints, where a ball, planar or
    floating joint takes a motor, and a twist in the frame of its child. Welded links are one.

    Attributes
    ----------
    name, root, path : str
    links : tuple of str
    joints : dict of str to RobotJoint
        In the order of the file.
    joints_in_order : list of RobotJoint
        Parents before their children.
    inertias : dict of str to LinkInertia
        Inertias of the links that have one.
    loops : tuple of LoopJoint
        Joints that close loops of the tree.
    frames_at_zero : dict of str to array (4, 4)
        Poses of the links' frames where all coordinates are zero, and followers where these put them.
    size : float
        Length of the robot: the largest distance of a link's origin from the root's, all coordinates zero.
    """

    def __repr__(self) -> str:
        return f"<Robot {self.name!r}: {len(self.links)} links, {len(self.joint_names)} moving joints>"

    def __getattr__(self, name: str) -> Any:
        if name in _OF_MECHANISM:
            return getattr(self._at_zero, name)
        raise AttributeError(f"a Robot has no {name!r}.")

    @cached_property
    def tree(self) -> Tree:
        """Joints and links, compiled."""
        return robot_tree(self)

    def _numbers(self, value: Any, name: str) -> Array:
        """Numbers of all joints, by name too."""
        if isinstance(value, Mapping):
            return joined_coordinates(self, value) if name == "q" else joined_speeds(self, value, name)
        return super()._numbers(value, name)

    @cached_property
    def _at_zero(self) -> Mechanism:
        return self.mechanism()

    def chain(self, tip: str, root: str | None = None, target: str = "c") -> Chain:
        """The chain of joints from one link to another, with names and limits; the tool is the frame of ``tip``.

        Coordinates are those of `joint_names`: a joint that follows another moves with that one's. For its dynamics
        other joints are held at zero: what is beyond them goes with the links of the chain.

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
            If there is no such link, no joint between the links, or one that is a ball, floating or planar.
        """
        from ..serial.axes import join_axes
        from ..serial.chain import Chain

        start = self.root if root is None else root
        paths = [self.joints_to_root(name) for name in (start, tip)]
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
        axes = [
            sign * self._ratio(joint) * (frames_at_zero[joint.child] >> self._joint_twist(joint))
            for joint, sign in moving
        ]
        frames = [frames_at_zero[joint.child if sign > 0 else joint.parent] for joint, sign in moving]
        data = np.stack([frame.values for frame in frames])
        leaders = [self._leader(joint) for joint, _ in moving]
        names = [*dict.fromkeys(leaders)]
        limits = dict(zip(self.joint_names, self.limits, strict=True))
        chain = Chain(
            join_axes(axes), frames_at_zero[tip], names, [limits[name] for name in names],
            frames=self.algebra.wrap(frames[0].kind, data), target=target,
            coordinates=[names.index(name) for name in leaders],
        )  # fmt: skip
        owners = carried_links(self, start, {joint.name: i for i, (joint, _) in enumerate(moving)})
        poses_at_zero = {name: self.algebra.matrix(motor) for name, motor in frames_at_zero.items()}
        try:
            refuse_followers(self, [joint.name for joint, _ in moving if joint.follows is not None])
            return chain.with_links(lumped_rows(self, owners, poses_at_zero, chain.joint_positions))
        except InputError as error:  # which matters to those alone who ask for forces
            return chain.with_links(None, (error.what, error.where, error.remedy))

    @describes_options
    def export(
        self, language: str, folder: str | Path, name: str = "robot", *, tip: str | None = None,
        root: str | None = None, dtype: str = "", split: bool = False, overwrite: bool = False,
    ) -> list[Path]:  # fmt: skip
        """Write the `chain` to a link as a source file that needs nothing of this package; see `Chain.export`.

        What has loops is exported as a mechanism: ``robot.mechanism().export(language, folder, driven)``.

        Parameters
        ----------
        {language}
        {folder}
        {name}
        tip, root : str, optional
            The links that are moved and fixed. Default: that behind most joints, and the root of the file, or of the
            largest part that floats.
        {dtype}
        {split}
        {overwrite}

        {files}

        Raises
        ------
        InputError
            If there is no such link or no such chain, or joints share coordinates.
            {refusals}
        """
        start = self.largest_part if root is None else root
        chain = self.chain(self.most_moved(start) if tip is None else tip, start)
        return chain.export(language, folder, name, dtype=dtype, split=split, overwrite=overwrite)

    def _joint_twist(self, joint: RobotJoint) -> Multivector:
        """The twist of a joint in the child's frame."""
        from ..serial.axes import prismatic_axis, revolute_axis, screw_axis

        if joint.type == "prismatic":
            return prismatic_axis(joint.axis, self.algebra)
        if joint.type == "screw":
            return screw_axis(joint.position, joint.axis, joint.pitch, self.algebra)
        return revolute_axis(joint.position, joint.axis, self.algebra)

    def _leader(self, joint: RobotJoint) -> str:
        """The joint whose coordinate moves a joint."""
        return joint.name if joint.follows is None else joint.follows.joint

    def _ratio(self, joint: RobotJoint) -> float:
        """Displacement of a joint for a unit of the coordinate that moves it."""
        return 1.0 if joint.follows is None else joint.follows.multiplier

    def mechanism(self, q: Any = None, root: str | None = None) -> Mechanism:
        """Links as bodies, and the joints between them by their names, at coordinates: see `poses`.

        Welded links are joined by `Rigid`; joints that follow others are coupled to them.

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
        from .mechanisms import robot_mechanism

        return robot_mechanism(self, q, root)

    def bodies(self, q: Any = None, *, inertia: str | None = None, base: str = "fixed") -> dict[str, RigidBody]:
        """A `dynamics.RigidBody` at rest for every lump that moves and has a mass, at coordinates: see `poses`.

        Parameters
        ----------
        q : array or mapping, optional
        inertia : {"given", "nearest"}, optional
            Inertias that no body can have are refused, if rounding does not explain them; or the nearest possible ones
            are taken, with a warning. Default: "given", unless the file was loaded with impossible="nearest".
        base : {"fixed", "free"}
            Whether the root moves, too.
        """
        from .systems import robot_bodies

        return robot_bodies(self, self.pose_at(q), inertia, base, 4)

    def system(
        self, q: Any = None, *, inertia: str | None = None, base: str = "fixed", followers: str = "couple"
    ) -> System:
        """The robot as a `dynamics.System` at coordinates: see `poses`. Links that are welded are one body.

        Lumps at the end of a branch that have no mass are left out; the inertia of a fixed root is not needed.

        Parameters
        ----------
        q, inertia
            As of `bodies`.
        base : {"fixed", "free"}
            Whether the root is fixed to the world or a body that nothing holds.
        followers : {"couple", "lock", "free"}
            Joints that follow others: coupled to them, locked where they are, or free.

        Raises
        ------
        InputError
            If a lump that moves has no mass, and carries others that have, other than between joints that make a ball,
            universal, cylindrical or planar joint; if an inertia is impossible; or if the file has no inertias: it is
            for kinematics.
        """
        from .systems import robot_system

        return robot_system(self, q, inertia, base, followers)
