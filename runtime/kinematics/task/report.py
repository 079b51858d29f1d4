"""Report of a mechanism at a pose: numbers for programs, text for people."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...core.multivector import Multivector
from ...mechanics.screws import screw_coordinates
from ...mechanics.units import Units
from ...status import Status
from ..mechanism.jacobian import Analysis
from ..mechanism.mechanism import Mechanism
from ..plotting.glyphs import mechanism_sketch
from ..robots.description import unused_name
from .mechanism_model import MechanismModel
from .robot_model import SINGULAR, ChainModel, DeltaModel, PoseBatch

Array = NDArray[Any]
AnyModel = DeltaModel | ChainModel | MechanismModel
#: Entries of a list that the text has at most; the numbers have all of them.
MOST = 16
#: Twists of bodies in the numbers, at most; beyond, each motion has the twist of the tool or of the last moving body.
MOST_TWISTS = 10_000
#: Digits of numbers in the text.
DIGITS = 5
#: Parts of a screw below this fraction of it, such as its pitch, are zero in the text.
SMALL = 1e-9


@dataclass(frozen=True)
class Report:
    """A mechanism at a pose.

    Attributes
    ----------
    data : dict
        Plain numbers, texts, lists and dicts, as of JSON.
    lines : list of (str, str)
        Keys and texts; an empty key continues the one before it.
    """

    data: dict[str, Any]
    lines: list[tuple[str, str]]

    def text(self) -> str:
        """The lines, aligned."""
        width = max(len(key) for key, _ in self.lines) + 2
        return "\n".join(f"{key + ':' if key else '':<{width}}{text}".rstrip() for key, text in self.lines)


def build_report(model: AnyModel, pose: PoseBatch, units: Units, name: str) -> Report:
    """Report of a model at a pose, from a file of a name; see `Setup.report`."""
    m = pose.at(0)
    data: dict[str, Any] = {"file": name, "kind": model.kind, "algebra": m.algebra.name}
    lines: list[tuple[str, str]] = []
    tool = (model.tool, pose.position[0]) if model.tool else ("", None)
    _structure(data, lines, m, model.kind, tool)
    _mobility(data, lines, m, model.tool)
    if model.inputs:
        _pose(data, lines, model, units, pose)
    if model.inputs and model.tool:
        _jacobian(data, lines, model, pose, m)
    return Report(data, lines)


# -- words -----------------------------------------------------------------------------------------------------


def vector(x: Any) -> str:
    """Coordinates in brackets."""
    values = np.asarray(x, float)
    size = float(np.abs(values).max(initial=0.0))
    return f"({', '.join(f'{0.0 if abs(v) <= SMALL * size else v:.{DIGITS}g}' for v in values)})"


def motion_words(twist: Multivector) -> str:
    """Text of a twist: "turns about (0, 0, 1) through (1, 0, 0)"."""
    angular, linear = np.split(np.asarray(screw_coordinates(twist), float), 2)
    if not np.linalg.norm(angular) > SMALL * np.linalg.norm(linear):
        return "rests" if not linear.any() else f"slides along {vector(_unit(linear))}"
    point, pitch = _axis(angular, linear)
    along = f"about {vector(_unit(angular))} through {vector(point)}"
    return f"screws {along}, pitch {pitch:.{DIGITS}g} per radian" if pitch else f"turns {along}"


def wrench_words(wrench: Multivector) -> str:
    """Text of a wrench: a force along a line, a couple, or both."""
    force, moment = np.split(np.asarray(screw_coordinates(wrench), float), 2)
    if not np.linalg.norm(force) > SMALL * np.linalg.norm(moment):
        return f"a couple about {vector(_unit(moment))}"
    point, pitch = _axis(force, moment)
    more = " and a couple about it" if pitch else ""
    return f"a force along {vector(_unit(force))} through {vector(point)}{more}"


def _axis(main: Array, other: Array) -> tuple[Array, float]:
    """A point of a screw's axis, and its pitch."""
    square = float(main @ main)
    point, pitch = np.cross(main, other) / square, float(main @ other) / square
    size = max(float(np.linalg.norm(point)), float(np.linalg.norm(other)) / np.sqrt(square))
    return point, pitch if abs(pitch) > SMALL * max(size, 1.0) else 0.0


def _unit(x: Array) -> Array:
    """The unit vector of a direction."""
    return np.asarray(x / np.linalg.norm(x))


def _add_list(lines: list[tuple[str, str]], key: str, texts: list[str]) -> None:
    """Add a list under a key, shortened."""
    for i, text in enumerate(texts[:MOST]):
        lines.append(("" if i else key, text))
    if len(texts) > MOST:
        lines.append(("", f"and {len(texts) - MOST} more"))


# -- parts of the report ---------------------------------------------------------------------------------------


def _structure(
    data: dict[str, Any], lines: list[tuple[str, str]], m: Mechanism, kind: str, tool: tuple[str, Any]
) -> None:
    lines.append((kind, f"{len(m.bodies)} bodies, {len(m.joints)} joints ({m.algebra.name})"))
    names = [f"{name} (fixed)" if name == m.fixed else name for name in m.bodies]
    lines.append(("bodies", ", ".join(names[:MOST]) + (f" and {len(names) - MOST} more" if len(names) > MOST else "")))
    texts, rows = [], []
    for joint, mark in zip(m.joints, mechanism_sketch(m, *tool).marks, strict=True):
        row = {"name": mark.name, "kind": mark.kind, "a": joint.a, "b": joint.b, "place": mark.position.tolist()}
        where = f"at {vector(mark.position)}"
        if len(mark.axes):
            row["axis"] = mark.axes[0].tolist()
            where += f", axis {vector(mark.axes[0])}"
        rows.append(row)
        own = "" if mark.name == joint.label else f"{mark.name}, "
        texts.append(f"{own}{mark.kind}, {joint.a} to {joint.b}, {where}")
    _add_list(lines, "joints", texts)
    _add_list(lines, "coupled joints", [_coupling_words(row) for row in m.couplings])
    if m.couplings:
        data["couplings"] = [
            [{"joint": name, "freedom": k, "coefficient": c} for (name, k), c in row.items()] for row in m.couplings
        ]
    data |= {"bodies": list(m.bodies), "fixed": m.fixed, "joints": rows}


def _coupling_words(row: dict[tuple[str, int], float]) -> str:
    """Text of a linear relation of speeds."""
    (first, own), *others = row.items()
    names = {key: key[0] if key[1] == 0 else f"{key[0]}[{key[1]}]" for key in row}
    terms = [f"{-c / own:.{DIGITS}g} {names[key]}" for key, c in others]
    return f"{names[first]} = {' + '.join(terms) or '0'}, in speeds"


def _mobility(data: dict[str, Any], lines: list[tuple[str, str]], m: Mechanism, tool: str) -> None:
    matrix, mobility, rank = m.constraint_matrix(), m.mobility(), m.rank()
    rows, columns = (int(x) for x in matrix.shape)
    lines.append(("mobility", f"{mobility} (rank {rank} of {rows} constraints on {columns} speeds)"))
    data |= {"mobility": mobility, "rank": rank, "constraints": rows, "speeds": columns, "residual": m.residual()}
    free, texts, rows_ = m.free_motions(), [], []
    every = len(free) * len(m.bodies) <= MOST_TWISTS
    for motion in free:
        moving = motion.bodies
        body = tool if tool in moving else moving[-1] if moving else ""
        listed = moving if every else [body]
        twists = {name: np.asarray(screw_coordinates(motion[name]), float).tolist() for name in listed if name}
        words = {name: motion_words(motion[name]) for name in ([body] if body else [])}
        rows_.append({"driver": motion.driver, "alone": motion.idle, "twists": twists})
        what = f"{motion.driver} alone: it " if motion.idle else f"{motion.driver}: {body} "
        texts.append(what + (words[body] if body else "rests"))
    _add_list(lines, "free motions", texts)
    stresses, stress_texts = m.self_stresses(), []
    for stress in stresses:
        first = next(iter(stress))
        others = ", ".join(list(stress)[:4]) + (f" and {len(stress) - 4} more" if len(stress) > 4 else "")
        stress_texts.append(f"{others} bear {wrench_words(stress[first])}{' at the first' if len(stress) > 1 else ''}")
    lines.append(("redundant constraints", str(len(stresses))))
    _add_list(lines, "", stress_texts)
    data |= {
        "free_motions": rows_,
        "redundant": [{n: np.asarray(screw_coordinates(w), float).tolist() for n, w in s.items()} for s in stresses],
    }


def _pose(data: dict[str, Any], lines: list[tuple[str, str]], model: AnyModel, units: Units, pose: PoseBatch) -> None:
    own = ["rad" if turns else units.length for turns in model.is_revolute]
    values = [f"{n} = {x:.6g} {u}" for n, x, u in zip(model.inputs, pose.coordinates[0], own, strict=True)]
    _add_list(lines, "pose", values)
    data["pose"] = dict(zip(model.inputs, pose.coordinates[0].tolist(), strict=True))
    low, high = model.limits.T
    out = (pose.coordinates[0] < low) | (pose.coordinates[0] > high)
    names = [n for n, bad in zip(model.inputs, out, strict=True) if bad]
    data["outside_limits"] = names
    if names:
        lines.append(("outside their limits", ", ".join(names)))
    if model.tool:
        lines.append((f"tool ({model.tool})", f"{vector(pose.position[0])} {units.length}"))
        data["tool"] = {"body": model.tool, "position": pose.position[0].tolist()}


def _jacobian(
    data: dict[str, Any], lines: list[tuple[str, str]], model: AnyModel, pose: PoseBatch, m: Mechanism
) -> None:
    """Jacobian from the inputs' speeds to the tool's; at singular poses the lost and the unconstrained directions."""
    position = pose.position[0]
    inputs = list(model.inputs)
    if isinstance(model, ChainModel):
        inputs = [unused_name(name, m.bodies) for name in inputs]
    whole = isinstance(model, ChainModel) or (isinstance(model, MechanismModel) and model.controls_orientation)
    bodies = [model.tool] if whole else []
    analysis = m.analysis(inputs, [*bodies, (model.tool, position)])
    matrix = analysis.jacobian
    if whole:
        twists = m.algebra.wrap(m.algebra.kind("twist"), np.ascontiguousarray(matrix[:6].T))
        matrix = np.concatenate([np.asarray(screw_coordinates(twists)).T[:3], matrix[6:]])
    condition, code = float(pose.condition[0]), Status(int(pose.status[0]))
    data["jacobian"] = {
        "inputs": list(model.inputs), "rows": [*(["wx", "wy", "wz"] if whole else []), "vx", "vy", "vz"],
        "matrix": matrix.tolist(), "condition": condition if np.isfinite(condition) else None,
        "singular_values": np.linalg.svd(matrix, compute_uv=False).tolist(), "status": code.name,
    }  # fmt: skip
    rows = [f"{name:>2} {vector(row)}" for name, row in zip(data["jacobian"]["rows"], matrix, strict=True)]
    _add_list(lines, "Jacobian", rows)
    lines.append(
        ("condition number", f"{condition:.{DIGITS}g}" if np.isfinite(condition) else "infinite: the pose is singular")
    )
    lost, stuck, open_ = _singular(matrix, model, whole, analysis)
    data["jacobian"] |= {"lost": lost, "without_effect": stuck, "open": open_}
    for key, directions in (
        ("the tool cannot move", lost),
        ("inputs that do not move it", stuck),
        ("it moves while inputs rest", open_),
    ):
        _add_list(lines, key, [_direction_words(x) for x in directions])
    bad = analysis.residual > analysis.noise
    names = [n for n, no in zip(model.inputs, bad, strict=True) if no]
    data["jacobian"]["not_allowed"] = names
    if names:
        lines.append(("inputs that joints forbid", ", ".join(names)))


def _direction_words(direction: list[float]) -> str:
    """Text of a direction; of six numbers, of its angular and its linear part."""
    if len(direction) == 6 and np.abs(direction[:3]).max() > SINGULAR:
        return f"turning {vector(direction[:3])}, its point by {vector(direction[3:])}"
    return f"along {vector(direction[-3:])}" if len(direction) in (3, 6) else vector(direction)


def _singular(
    matrix: Array, model: AnyModel, whole: bool, analysis: Analysis
) -> tuple[list[list[float]], list[list[float]], list[list[float]]]:
    """Lost directions of the tool, inputs without effect, and directions that the inputs do not constrain."""
    rows = np.array([1.0] * (matrix.shape[0] - 3) + [1 / model.length] * 3)
    scaled = matrix * rows[:, None] * np.where(model.is_revolute, 1.0, model.length)
    left, sizes, right = np.linalg.svd(scaled)
    most = model.chain.freedom if isinstance(model, ChainModel) else min(matrix.shape)
    rank = int((sizes > SINGULAR * sizes.max(initial=0.0)).sum())
    lost = (left[:, rank:most] / rows[:, None]).T.tolist() if rank < most == matrix.shape[0] else []
    stuck = right[rank : matrix.shape[1]].tolist() if rank < min(most, matrix.shape[1]) else []
    free = analysis.open[-3:].T if analysis.open.size else np.zeros((0, 3))
    return lost, stuck, free.tolist()


__all__ = ["Report", "build_report", "motion_words", "vector", "wrench_words"]
