"""Serial chains: poses and Jacobians against 50 digits, beside Pinocchio and matrices of NumPy."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any

import numpy as np

from ....kinematics.serial.axes import revolute_axis
from ....kinematics.serial.chain import Chain
from ...harness.algebras import cga3d
from ...harness.study import Array, Case, Errors, Method, Study, lost_beyond, optional_module, sweep_cases
from ...harness.vectors import unit, vector_text
from .chains_exact import ExactArm

COUNT, COPIES, FEW_COPIES = 40, 200, 20
#: A six-axis arm: three axes parallel, three through the wrist.
POSITIONS = ((0, 0, 0.1), (0, 0.1, 0.3), (0, 0.1, 0.9), (0.4, 0.1, 0.9), (0.5, 0.1, 0.9), (0.6, 0.1, 0.9))
DIRECTIONS = ((0, 0, 1), (0, 1, 0), (0, 1, 0), (1, 0, 0), (0, 1, 0), (1, 0, 0))
TOOL = (0.7, 0.1, 0.9)
JOINTS, UNITS, DISTANCES = (6.0, 20.0, 60.0, 200.0), (1e-6, 1e-3, 1.0, 1e3), (1.0, 1e2, 1e4, 1e6)
#: Displacement from the origin, of a length of about one.
AWAY = (0.6, -0.7, 0.4)
LOST = 1.0


@dataclass(frozen=True)
class Arm:
    """A chain of revolute joints, and its configurations.

    Attributes
    ----------
    positions, directions : array (n, 3)
        Parameters of the axes, in the world at zero angles.
    tool : array (3,)
    q : array (m, n)
    quantity : {"pose", "jacobian"}
    """

    positions: Array
    directions: Array
    tool: Array
    q: Array
    quantity: str = "jacobian"

    def __len__(self) -> int:
        return len(self.q)

    @cached_property
    def chain(self) -> Chain:
        """Chain of ours."""
        return Chain(revolute_axis(self.positions, self.directions), cga3d.translator(self.tool))

    @cached_property
    def pinocchio(self) -> tuple[Any, Any, int]:
        """Pinocchio's model and data, and its number of the last joint."""
        return pinocchio_arm(self)

    @cached_property
    def digits(self) -> ExactArm:
        """Chain with 50 digits."""
        return ExactArm(self.positions, self.directions, self.tool)

    @cached_property
    def exact(self) -> Array:
        """Poses (m, 3, 4) or Jacobians (m, 6, n), from 50 digits."""
        function = self.digits.matrix if self.quantity == "pose" else self.digits.jacobian
        return np.array([function(x) for x in self.q])


def pinocchio_arm(arm: Arm) -> tuple[Any, Any, int]:
    """Model, data and number of the last joint."""
    pin = optional_module("pinocchio")
    model, last, before = pin.Model(), 0, np.zeros(3)
    for i, (p, d) in enumerate(zip(arm.positions, arm.directions, strict=True)):
        joint = pin.JointModelRevoluteUnaligned(d / np.linalg.norm(d))
        last = model.addJoint(last, joint, pin.SE3(np.eye(3), p - before), f"joint_{i}")
        before = p
    model.addFrame(pin.Frame("tool", last, 0, pin.SE3(np.eye(3), arm.tool - before), pin.FrameType.OP_FRAME))
    return model, model.createData(), last


# -- methods -----------------------------------------------------------------------------------------------


def by_chain(arm: Arm, q: Array) -> Array:
    """Poses or Jacobians at some angles (..., n)."""
    if arm.quantity == "jacobian":
        return np.asarray(arm.chain.jacobian(q, point=np.zeros(3)))
    return matrices(arm.chain.forward(q))


def run_batch(arm: Arm, setting: Any, *, copies: int) -> Array:
    """All in a call, each so often."""
    return by_chain(arm, np.tile(arm.q, (copies, 1)))[: len(arm)]


def run_singly(arm: Arm, setting: Any) -> Array:
    """One pose after the other."""
    return np.stack([by_chain(arm, x) for x in arm.q])


def matrices(motors: Any) -> Array:
    """Rotation and position (..., 3, 4)."""
    return np.asarray(motors.algebra.matrix(motors)[..., :3, :])


def by_pinocchio(arm: Arm, setting: Any) -> Array:
    """Calls of Pinocchio from Python, pose by pose."""
    pin = optional_module("pinocchio")
    model, data, _ = arm.pinocchio
    frame = model.getFrameId("tool")
    results = []
    for q in arm.q:
        if arm.quantity == "jacobian":
            jacobian = pin.computeFrameJacobian(model, data, q, frame, pin.LOCAL_WORLD_ALIGNED)
            results.append(np.concatenate([jacobian[3:], jacobian[:3]]))
        else:
            pin.forwardKinematics(model, data, q)
            results.append(pin.updateFramePlacement(model, data, frame).homogeneous[:3])
    return np.stack(results)


def by_matrices(arm: Arm, setting: Any, *, copies: int) -> Array:
    """Products of 4 x 4 matrices, all poses at once; columns a, a x (p - o) from points p of the axes."""
    q = np.tile(arm.q, (copies, 1))
    axes = unit(arm.directions)
    pose, moved_axes = np.tile(np.eye(4), (len(q), 1, 1)), []
    for i, (a, p) in enumerate(zip(axes, arm.positions, strict=True)):
        moved_axes.append((pose[:, :3, :3] @ a, pose[:, :3, :3] @ p + pose[:, :3, 3]))
        hat = np.cross(a, np.eye(3)).T
        sine, versine = np.sin(q[:, i, None, None]), 1 - np.cos(q[:, i, None, None])
        step = np.tile(np.eye(4), (len(q), 1, 1))
        step[:, :3, :3] += sine * hat + versine * (hat @ hat)
        step[:, :3, 3] = p - step[:, :3, :3] @ p
        pose = pose @ step
    pose[:, :3, 3] += pose[:, :3, :3] @ arm.tool
    if arm.quantity == "pose":
        return pose[: len(arm), :3]
    columns = [np.concatenate([a, np.cross(a, pose[:, :3, 3] - p)], -1) for a, p in moved_axes]
    return np.stack(columns, -1)[: len(arm)]


def error(answer: Array, truth: Array, arm: Arm) -> Errors:
    """Relative errors of rotation and position; the latter relative to the distance, or to the arm's length."""
    if arm.quantity == "pose":
        rotation = np.linalg.norm((answer - truth)[:, :, :3], axis=(1, 2))
        size = np.maximum(np.linalg.norm(truth[:, :, 3], axis=1), arm.chain.length)
        position = np.linalg.norm((answer - truth)[:, :, 3], axis=1) / size
    else:
        rotation, position = (
            np.linalg.norm((answer - truth)[:, part], axis=(1, 2)) / np.linalg.norm(truth[:, part], axis=(1, 2))
            for part in (slice(0, 3), slice(3, 6))
        )
    return lost_beyond(np.maximum(rotation, position), LOST)


# -- cases -------------------------------------------------------------------------------------------------


def six(rng: np.random.Generator, count: int, unit: float = 1.0, **options: Any) -> Arm:
    """Poses of the six-axis arm; options are those of `six_at`."""
    return six_at(rng.uniform(-np.pi, np.pi, (count, 6)), unit=unit, **options)


def six_at(q: Array, quantity: str = "jacobian", unit: float = 1.0, away: float = 0.0) -> Arm:
    """The six-axis arm in some unit of length and so far from the origin, at angles (m, 6)."""
    shift, directions = away * np.array(AWAY), np.array(DIRECTIONS, float)
    return Arm(unit * np.array(POSITIONS, float) + shift, directions, unit * np.array(TOOL) + shift, q, quantity)


def random(rng: np.random.Generator, count: int, joints: float) -> Arm:
    """Poses of a chain whose axes lie anywhere, of one length however many there are."""
    n = int(joints)
    positions = np.cumsum(rng.normal(size=(n + 1, 3)) / np.sqrt(n), axis=0)
    return Arm(positions[:-1], rng.normal(size=(n, 3)), positions[-1], rng.uniform(-np.pi, np.pi, (count, n)))


def describe(arm: Arm, i: int) -> str:
    """The angles, the first of many."""
    text = vector_text(arm.q[i][:6])
    return f"angles {text[:-1]}, ...)" if arm.q.shape[1] > 6 else f"angles {text}"


def prepare() -> None:
    """Compile the driver."""
    run_batch(six(np.random.default_rng(0), 1), None, copies=1)


STUDY = Study(
    name="chains",
    title="Serial chains: poses and Jacobians",
    methods=(
        Method("chain", partial(run_batch, copies=COPIES), copies=COPIES, repeats=1, prepare=prepare),
        Method("chain, one by one", run_singly, repeats=1),
        Method("Pinocchio from Python, one by one", by_pinocchio, repeats=1, requires="pinocchio"),
        Method("matrices, NumPy", partial(by_matrices, copies=FEW_COPIES), copies=FEW_COPIES, repeats=1),
    ),
    cases=(
        Case("poses of a six-axis arm", partial(six, quantity="pose")),
        Case("Jacobians of a six-axis arm", six),
        *sweep_cases("joints", JOINTS, random),
        *sweep_cases("unit of length", UNITS, six),
        *sweep_cases("distance from the origin", DISTANCES, lambda rng, count, away: six(rng, count, away=away)),
    ),
    reference=lambda arm: arm.exact,
    error=error,
    describe=describe,
    unit="relative",
    count=COUNT,
    source="thesis 7.3",
    notes="Jacobians against differences of poses with 50 digits. Pinocchio is called pose by pose, as it is from "
    "Python.",
)
