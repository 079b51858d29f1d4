"""Serial chains: poses and Jacobians against 50 digits, beside Pinocchio and matrices of NumPy."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, partial
from importlib import import_module
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..study import Case, Errors, Method, Study, swept
from .chains_exact import ExactArm

if TYPE_CHECKING:
    from ...kinematics.chains import Chain

Array = NDArray[Any]
COUNT, COPIES, FEW_COPIES = 40, 200, 20
#: A six-axis arm: three axes parallel, three through the wrist.
POSITIONS = ((0, 0, 0.1), (0, 0.1, 0.3), (0, 0.1, 0.9), (0.4, 0.1, 0.9), (0.5, 0.1, 0.9), (0.6, 0.1, 0.9))
DIRECTIONS = ((0, 0, 1), (0, 1, 0), (0, 1, 0), (1, 0, 0), (0, 1, 0), (1, 0, 0))
TOOL = (0.7, 0.1, 0.9)
JOINTS, UNITS, PLACES = (6.0, 20.0, 60.0, 200.0), (1e-6, 1e-3, 1.0, 1e3), (1.0, 1e2, 1e4, 1e6)
#: A way in some direction.
WAY = (0.6, -0.7, 0.4)
LOST = 1.0


@dataclass(frozen=True)
class Arm:
    """A chain of turns, and where it is looked at.

    Attributes
    ----------
    positions, directions : array (n, 3)
        Of the axes, in the world where all angles are zero.
    tool : array (3,)
    q : array (m, n)
    what : {"pose", "jacobian"}
    """

    positions: Array
    directions: Array
    tool: Array
    q: Array
    what: str = "jacobian"

    def __len__(self) -> int:
        return len(self.q)

    @cached_property
    def chain(self) -> Chain:
        """Ours."""
        from ... import cga3d
        from ...kinematics.chains import Chain
        from ...kinematics.chains_axes import revolute_axis

        return Chain(revolute_axis(self.positions, self.directions), cga3d.translator(self.tool))

    @cached_property
    def pinocchio(self) -> tuple[Any, Any, int]:
        """Pinocchio's model and data, and its number of the last joint."""
        return pinocchio_arm(self)

    @cached_property
    def digits(self) -> ExactArm:
        """The same with 50."""
        return ExactArm(self.positions, self.directions, self.tool)

    @cached_property
    def exact(self) -> Array:
        """Poses (m, 3, 4) or Jacobians (m, 6, n), from 50 digits."""
        found = self.digits.matrix if self.what == "pose" else self.digits.jacobian
        return np.array([found(x) for x in self.q])


def pinocchio_arm(arm: Arm) -> tuple[Any, Any, int]:
    """Model, data and number of the last joint."""
    pin: Any = import_module("pinocchio")

    model, last, before = pin.Model(), 0, np.zeros(3)
    for i, (p, d) in enumerate(zip(arm.positions, arm.directions, strict=True)):
        joint = pin.JointModelRevoluteUnaligned(d / np.linalg.norm(d))
        last = model.addJoint(last, joint, pin.SE3(np.eye(3), p - before), f"joint_{i}")
        before = p
    model.addFrame(pin.Frame("tool", last, 0, pin.SE3(np.eye(3), arm.tool - before), pin.FrameType.OP_FRAME))
    return model, model.createData(), last


# -- methods -----------------------------------------------------------------------------------------------


def ours(arm: Arm, setting: Any, *, copies: int) -> Array:
    """All in a call, each so often."""
    q = np.tile(arm.q, (copies, 1))
    if arm.what == "jacobian":
        found: Array = arm.chain.jacobian(q, point=np.zeros(3))[: len(arm)]
        return found
    return matrices(arm.chain.forward(q)[: len(arm)])


def ours_singly(arm: Arm, setting: Any) -> Array:
    """One after the other."""
    if arm.what == "jacobian":
        return np.stack([arm.chain.jacobian(x, point=np.zeros(3)) for x in arm.q])
    return np.stack([matrices(m) for m in [arm.chain.forward(x) for x in arm.q]])


def matrices(motors: Any) -> Array:
    """Turn and place (..., 3, 4)."""
    found: Array = motors.algebra.matrix(motors)[..., :3, :]
    return found


def by_pinocchio(arm: Arm, setting: Any) -> Array:
    """As it is called from Python, pose by pose."""
    pin: Any = import_module("pinocchio")

    model, data, _ = arm.pinocchio
    frame = model.getFrameId("tool")
    made = []
    for q in arm.q:
        if arm.what == "jacobian":
            found = pin.computeFrameJacobian(model, data, q, frame, pin.LOCAL_WORLD_ALIGNED)
            made.append(np.concatenate([found[3:], found[:3]]))
        else:
            pin.forwardKinematics(model, data, q)
            made.append(pin.updateFramePlacement(model, data, frame).homogeneous[:3])
    return np.stack(made)


def by_matrices(arm: Arm, setting: Any, *, copies: int) -> Array:
    """Products of 4 x 4 matrices, all poses at once; columns a, a x (p - o) from the axes' places."""
    q = np.tile(arm.q, (copies, 1))
    axes = arm.directions / np.linalg.norm(arm.directions, axis=1, keepdims=True)
    pose, made = np.tile(np.eye(4), (len(q), 1, 1)), []
    for i, (a, p) in enumerate(zip(axes, arm.positions, strict=True)):
        made.append((pose[:, :3, :3] @ a, pose[:, :3, :3] @ p + pose[:, :3, 3]))
        hat = np.cross(a, np.eye(3)).T
        sine, versine = np.sin(q[:, i, None, None]), 1 - np.cos(q[:, i, None, None])
        step = np.tile(np.eye(4), (len(q), 1, 1))
        step[:, :3, :3] += sine * hat + versine * (hat @ hat)
        step[:, :3, 3] = p - step[:, :3, :3] @ p
        pose = pose @ step
    pose[:, :3, 3] += pose[:, :3, :3] @ arm.tool
    if arm.what == "pose":
        return pose[: len(arm), :3]
    columns = [np.concatenate([a, np.cross(a, pose[:, :3, 3] - p)], -1) for a, p in made]
    return np.stack(columns, -1)[: len(arm)]


def error(answer: Array, truth: Array, arm: Arm) -> Errors:
    """Of the turn and of the way, each relative; a place's error relative to where it is, or to the arm's length."""
    if arm.what == "pose":
        turn = np.linalg.norm((answer - truth)[:, :, :3], axis=(1, 2))
        size = np.maximum(np.linalg.norm(truth[:, :, 3], axis=1), arm.chain.length)
        way = np.linalg.norm((answer - truth)[:, :, 3], axis=1) / size
    else:
        turn, way = (
            np.linalg.norm((answer - truth)[:, part], axis=(1, 2)) / np.linalg.norm(truth[:, part], axis=(1, 2))
            for part in (slice(0, 3), slice(3, 6))
        )
    found = np.maximum(turn, way)
    return np.where(found < LOST, found, np.inf)


# -- cases -------------------------------------------------------------------------------------------------


def six(what: str = "jacobian", unit: float = 1.0, away: float = 0.0) -> Any:
    """Maker of poses of the six-axis arm."""

    def make(rng: np.random.Generator, count: int) -> Arm:
        return six_at(rng.uniform(-np.pi, np.pi, (count, 6)), what, unit, away)

    return make


def six_at(q: Array, what: str = "jacobian", unit: float = 1.0, away: float = 0.0) -> Arm:
    """The six-axis arm in some unit of length and so far from the origin, at angles (m, 6)."""
    place = away * np.array(WAY)
    return Arm(
        unit * np.array(POSITIONS, float) + place, np.array(DIRECTIONS, float), unit * np.array(TOOL) + place, q, what
    )


def random(joints: float) -> Any:
    """Maker of poses of a chain whose axes lie anywhere, of one length however many there are."""

    def make(rng: np.random.Generator, count: int) -> Arm:
        n = int(joints)
        steps = rng.normal(size=(n + 1, 3)) / np.sqrt(n)
        positions = np.cumsum(steps, axis=0)
        return Arm(positions[:-1], rng.normal(size=(n, 3)), positions[-1], rng.uniform(-np.pi, np.pi, (count, n)))

    return make


def describe(arm: Arm, i: int) -> str:
    """The angles, the first of many."""
    shown = ", ".join(f"{x:.6g}" for x in arm.q[i][:6])
    return f"angles ({shown}{', ...' if arm.q.shape[1] > 6 else ''})"


def prepare() -> None:
    """Compile the driver."""
    ours(six()(np.random.default_rng(0), 1), None, copies=1)


HAS_PINOCCHIO = find_spec("pinocchio") is not None
_PEERS = (Method("Pinocchio from Python, one by one", by_pinocchio, repeats=1),) if HAS_PINOCCHIO else ()

STUDY = Study(
    name="chains",
    title="Serial chains: poses and Jacobians",
    methods=(
        Method("chain", partial(ours, copies=COPIES), copies=COPIES, repeats=1, prepare=prepare),
        Method("chain, one by one", ours_singly, repeats=1),
        *_PEERS,
        Method("matrices, NumPy", partial(by_matrices, copies=FEW_COPIES), copies=FEW_COPIES, repeats=1),
    ),
    cases=(
        Case("poses of a six-axis arm", six("pose"), describe=describe),
        Case("Jacobians of a six-axis arm", six(), describe=describe),
        *swept("joints", JOINTS, random, describe),
        *swept("unit of length", UNITS, lambda unit: six(unit=unit), describe),
        *swept("distance from the origin", PLACES, lambda away: six(away=away), describe),
    ),
    reference=lambda arm: arm.exact,
    error=error,
    unit="relative",
    count=COUNT,
    source="thesis 7.3",
    notes="Jacobians against differences of poses with 50 digits. "
    + (
        "Pinocchio is called pose by pose, as it is from Python." if HAS_PINOCCHIO
        else "Pinocchio is not installed (the package pin), and left out."
    ),
)  # fmt: skip
