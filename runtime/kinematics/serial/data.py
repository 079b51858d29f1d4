"""Data of a serial chain and its forward kinematics: axes, tool, limits; poses and Jacobians (thesis 7.3).

Axes, tool and frames are given in the world where all joints are at zero. The loops are compiled (`driver`).
"""

from __future__ import annotations

import copy
from collections.abc import Sequence
from functools import cached_property
from typing import Any, Literal, Self, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...codegen.algorithms.chain_frames import JacobianFrame
from ...codegen.errors import GradeError, InputError
from ...common.dtypes import F64
from ...common.validation import (
    as_bool,
    as_choice,
    broadcast_to,
    check_shape,
    positive_float,
    real_array,
    short_repr,
)
from ...core.geometry.motors import motors_from
from ...core.multivector import Multivector
from ...dispatch.algorithm_loops import TARGETS
from ...dispatch.item_plans import is_plain, wrapped
from ...dispatch.item_statuses import array_result, invalidate_nonfinite, raise_first
from ...dispatch.multivector_data import Statuses
from ...dispatch.types import Type
from ..trees.driver import TreeDriver, TreeParameters
from ..trees.dynamics import JointDynamics
from ..trees.inertias import link_rows, moved, read_inertias
from ..trees.tree import Tree
from .axes import chain_parameters, join_axes, joint_limits, joint_names, translation_ranges
from .driver import Driver, SearchOptions

Array = NDArray[Any]
#: Frames of Jacobians.
FRAMES = ("world", "tool")
#: Singular values below this fraction of the largest are zero.
TOLERANCE = 1e-9
#: What is wrong, where, and the remedy, where torques are asked of a chain that is axes alone.
NO_INERTIAS = (
    "the links of this chain have no inertias: only its kinematics are known.", None,
    "Give them: chain.with_inertias(masses, centers, tensors); chains of a Robot have those of its file",
)  # fmt: skip
#: Poses from which the generic rank of a chain is determined.
SAMPLES = 5


class SerialChainData(JointDynamics):
    """A chain of joints from the fixed base to a tool: see `Chain`, which has its parameters."""

    def __init__(
        self,
        axes: Any,
        tool: Multivector | None = None,
        names: Sequence[str] | None = None,
        limits: Any = None,
        *,
        frames: Multivector | None = None,
        length: float | None = None,
        target: str = "c",
        coordinates: Sequence[int] | None = None,
    ) -> None:
        self.target = as_choice(target, "target", TARGETS)
        self.axes = join_axes(axes)
        self.algebra, self.joint_count = self.axes.algebra, len(self.axes)
        self.movers = _movers(coordinates, self.joint_count)
        self.count = self.joint_count if self.movers is None else int(self.movers.max()) + 1
        self.tool = self._motors(tool, "tool", ())
        self.frames = self._motors(frames, "frames", (self.joint_count,))
        self.names = joint_names(names, self.count)
        self.limits = joint_limits(limits, self.names)
        movers = slice(None) if self.movers is None else self.movers
        moved_by = [*np.array(self.names, object)[movers]]
        self.parameters, distances = chain_parameters(self.axes, self.tool, self.frames, moved_by)
        self.links: Array | None = None
        self.refusal: tuple[str, str | None, str | None] = NO_INERTIAS
        self.searches: dict[Any, SearchOptions] = {}
        self.reach = float(distances.sum() + translation_ranges(self.parameters, self.limits[movers]).sum())
        size = float(distances.sum()) or self.reach
        self.length = positive_float(length, "length") if length is not None else size if 0 < size < np.inf else 1.0

    def __repr__(self) -> str:
        return f"{type(self).__name__} of {self.count} joints in {self.algebra.name}: {', '.join(self.names[:8])}" + (
            ", ..." if self.count > 8 else ""
        )

    def __getstate__(self) -> dict[str, Any]:
        """State without what is compiled: another process builds its own."""
        return {name: value for name, value in self.__dict__.items() if name not in ("driver", "tree", "_motor")}

    def __len__(self) -> int:
        return self.count

    @cached_property
    def driver(self) -> Driver:
        """The compiled loops."""
        return Driver(self.algebra.name, self.parameters, self.target, movers=self.movers)

    def with_inertias(
        self, inertias: Any, centers: Any = None, tensors: Any = None, *, impossible: str = "error"
    ) -> Self:
        """This chain with inertias of its links, for torques and accelerations.

        Parameters
        ----------
        inertias : array (n,), or list of dynamics.Inertia
            Masses of the links, or inertias in their frames.
        centers : array (n, 3)
            Centers of mass, each in the frame of its link (`frames`; by default the world's where all joints are at
            zero). A link is what moves with its joint, the last one with the tool.
        tensors : array (n, 3, 3) or, but for three links, (n, 3)
            Tensors about the centers along the axes of the links' frames, mass included, or moments.
        impossible : {"error", "keep"}
            Inertias that no body can have (a mass or moment that is negative, a moment that exceeds the sum of the
            others) are an error, or are computed with as they are. A link may be massless, a point or a rod.

        Raises
        ------
        InputError, ShapeError
        """
        masses, found, about = read_inertias(inertias, centers, tensors, self.names, impossible)
        found, about = moved(self.algebra.matrix(self.frames), found, about)
        return self.with_links(link_rows(masses, found - self.joint_positions, about))

    def with_links(self, links: Array | None, refusal: tuple[str, str | None, str | None] | None = None) -> Self:
        """This chain with rows (n, 10) of `Link` about the joints' positions, or what says why it has none."""
        new = copy.copy(self)
        new.__dict__.pop("tree", None)
        new.links, new.refusal = links, refusal or new.refusal
        return new

    @property
    def joint_positions(self) -> Array:
        """A point (n, 3) on each joint's axis, where all joints are at zero."""
        return np.asarray(self.parameters.base + np.cumsum(self.parameters.joints[:, :3], axis=0))

    @cached_property
    def tree(self) -> Tree:
        """Joints and links, compiled."""
        if self.links is None:
            what, where, remedy = self.refusal
            raise InputError(what, where=where, remedy=remedy)
        parameters = TreeParameters(self.parameters.joints, self.links, np.arange(-1, self.joint_count - 1))
        return Tree(TreeDriver(self.algebra.name, parameters, self.target))

    def _motors(self, motor: Multivector | None, what: str, shape: tuple[int, ...]) -> Multivector:
        one = self.algebra.translator(np.zeros(3)).as_kind("motor")
        motors = one if motor is None else self.as_motors(motor, f"the {what}")
        if motor is not None:
            check_shape(motors, f"the {what}", shape)
        if not np.isfinite(motors.values).all():
            raise InputError(f"the {what} are not finite.")
        if motors.shape == shape:
            return motors
        return motors._make(motors._type, np.broadcast_to(motors._data, (*shape, 8)).copy(), shape, None)

    def as_motors(self, x: Any, what: str) -> Multivector:
        """x on the blades of the chain's motors, from what `motors_from` takes."""
        motor = motors_from(x, self.algebra, what)
        if motor.kind.name == "motor":
            return motor
        if not set(motor.kind.blades) <= set(self.algebra.kind("motor").blades):
            raise GradeError(f"{what}: a {motor.kind.name} is not a motor.", remedy="See Multivector.as_kind('motor')")
        return motor.as_kind("motor")

    # -- poses and velocities --------------------------------------------------------------------------------

    def coordinates(self, q: ArrayLike, name: str = "q") -> Array:
        """Coordinates (..., n) in the form that the driver takes.

        Raises
        ------
        InputError, ShapeError
        """
        return np.asarray(real_array(q, name, (..., self.count)), np.float64)

    @cached_property
    def _row(self) -> tuple[int, ...]:
        return (self.count,)

    @cached_property
    def _motor(self) -> Type:
        return self.algebra.type_of(self.algebra.kind("motor"), F64)

    def forward(
        self, q: ArrayLike, all: bool = False, *, strict: bool = False, threads: int | None = None
    ) -> Multivector:
        """Motor of the tool's frame, exp(-q1 S1/2) ... exp(-qn Sn/2) tool.

        Parameters
        ----------
        q : array (..., n)
            Coordinates of the joints: radians and lengths.
        all : bool
            Motors of the frames of all links instead: shape (..., n).
        strict : bool
            Raise for coordinates that are not finite; otherwise their items are NaN and INVALID.
        threads : int, optional
            Default: the package's (`bladesmith.set_threads`).

        Returns
        -------
        Multivector of motors, shape (...)
        """
        if all is strict is False and threads is None and is_plain(q, self._row):
            call = self.driver.motor_of_item
            motor = None if call is None else call(q)  # type: ignore[arg-type]
            if motor is not None:
                return wrapped(self._motor, motor)  # type: ignore[no-any-return]
        x = self.coordinates(q)
        every = as_bool(all, "all")
        motors = self.driver.forward(x.reshape(-1, self.count), every, threads)
        shape = (*x.shape[:-1], self.joint_count) if every else x.shape[:-1]
        return self.wrap("motor", motors, shape, strict, "forward")

    @overload
    def jacobian(
        self, q: ArrayLike, frame: str = ..., point: ArrayLike | None = ..., *,
        status: Literal[False] = ..., strict: bool = ..., threads: int | None = ...,
    ) -> Array: ...  # fmt: skip
    @overload
    def jacobian(
        self, q: ArrayLike, frame: str = ..., point: ArrayLike | None = ..., *,
        status: Literal[True], strict: bool = ..., threads: int | None = ...,
    ) -> tuple[Array, Statuses]: ...  # fmt: skip
    def jacobian(
        self,
        q: ArrayLike,
        frame: str = "world",
        point: ArrayLike | None = None,
        *,
        status: bool = False,
        strict: bool = False,
        threads: int | None = None,
    ) -> Array | tuple[Array, Statuses]:
        """Matrices (..., 6, n) from joint rates to the tool's angular velocity w and velocity v, three rows each.

        Parameters
        ----------
        q : array (..., n)
            Coordinates of the joints: radians and lengths.
        frame : {"world", "tool"}
            Axes along which both are given. In the world v is the velocity of the tool's point at the world's origin,
            as in twists w I3 + v n, in the tool's frame the velocity of the frame's own origin.
        point : array (3,) or (..., 3), optional
            A point of the tool, in its frame, to take the velocity v of instead.
        status : bool
            Return codes of `bladesmith.Status` (...), too: INVALID where a coordinate is not finite and the matrix NaN.
        strict : bool
            Raise for the first such item instead.
        """
        usual = frame.__class__ is str and frame == "world" and point is None and status is strict is False
        if usual and threads is None and is_plain(q, self._row):
            call = self.driver.jacobian_of_item
            matrix = None if call is None else call(q)  # type: ignore[arg-type]
            if matrix is not None:
                return matrix
        x = self.coordinates(q)
        lead = x.shape[:-1]
        world = JacobianFrame.ORIGIN if point is None else JacobianFrame.POINT
        axes = JacobianFrame.TOOL if as_choice(frame, "frame", FRAMES) == "tool" else world
        at = np.zeros(3) if point is None else np.asarray(real_array(point, "point", (..., 3)), np.float64)
        if at.ndim > 1:
            at = broadcast_to(at, (*lead, 3), "point").reshape(-1, 3)
        matrices = self.driver.jacobian(x.reshape(-1, self.count), axes, at, threads).reshape(*lead, 6, self.count)
        return array_result(matrices, None, "jacobian", status, strict, 2)

    @cached_property
    def freedom(self) -> int:
        """Rank of the Jacobian at generic poses."""
        low, high = (
            np.where(np.isfinite(side), side, other) for side, other in zip(self.limits.T, (-3.0, 3.0), strict=True)
        )
        joints = np.arange(self.count)
        fraction = (np.outer(np.arange(1, SAMPLES + 1), np.sqrt(2.0) * (joints + 1)) + 0.3 * joints) % 1
        matrices, _ = self.scaled_jacobian(low + fraction * (high - low), 1)
        values = np.linalg.svd(matrices, compute_uv=False)
        return int((values > TOLERANCE * values[:, :1]).sum(-1).max())

    def scaled_jacobian(self, x: Array, threads: int | None = None) -> tuple[Array, Array]:
        """Jacobians at the tool's origin in units of `length`, zero where they are not finite; and the finite ones."""
        matrices = self.jacobian(x, "world", np.zeros(3), threads=threads)
        matrices[..., 3:, :] /= self.length
        finite_items = np.asarray(np.isfinite(matrices).all((-1, -2)))
        return np.where(finite_items[..., None, None], matrices, 0.0), finite_items

    def wrap(self, kind: str, data: Array, shape: tuple[int, ...], strict: bool, name: str) -> Multivector:
        """Coefficients as a multivector of a kind; with ``strict`` an error for the first item that is not valid."""
        home = self.algebra.kind(kind)
        result = invalidate_nonfinite(self.algebra.wrap(home, data.reshape(*shape, home.size)))
        if as_bool(strict, "strict"):
            raise_first(result._status, name)
        return result


def _movers(coordinates: Any, joints: int) -> NDArray[np.int64] | None:
    """Coordinate that moves each joint; None if each has its own.

    Raises
    ------
    InputError
    """
    if coordinates is None:
        return None
    movers = np.asarray(coordinates)
    if movers.shape != (joints,) or movers.dtype.kind not in "iu" or set(movers.tolist()) != {*range(movers.max() + 1)}:
        raise InputError(
            f"coordinates are {short_repr(coordinates)}; one index is needed for each of {joints} joints, from 0 on "
            "without gaps."
        )
    return None if np.array_equal(movers, np.arange(joints)) else movers.astype(np.int64)
