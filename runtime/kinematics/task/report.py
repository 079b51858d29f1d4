"""What is known of a mechanism at a pose, as numbers for programs and in words for people."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..dynamics.screws import screw_coordinates
from ..status import Status
from .models import SINGULAR, ChainModel, Found
from .models_general import MechanismModel
from .sketch import sketched
from .urdf import _free_name

if TYPE_CHECKING:
    from ..multivector import Multivector
    from .mechanism import Mechanism
    from .setup import Setup

Array = NDArray[Any]
#: Entries of a list that are told in words; all of them are in the numbers.
MOST = 16
#: Twists of bodies in the numbers, at most; beyond, each motion has that of the tool, or of the last body that moves.
MOST_TWISTS = 10_000
#: Digits of numbers in words.
DIGITS = 5
#: Parts of a screw below this share of it are zero in words, such as its pitch.
SMALL = 1e-9


@dataclass(frozen=True)
class Report:
    """A mechanism at a pose.

    Attributes
    ----------
    data : dict
        Plain numbers, texts, lists and dicts, as of JSON.
    lines : list of (str, str)
        What to say; an empty key continues the one before it.
    """

    data: dict[str, Any]
    lines: list[tuple[str, str]]

    def text(self) -> str:
        """The lines, aligned."""
        width = max(len(key) for key, _ in self.lines) + 2
        return "\n".join(f"{key + ':' if key else '':<{width}}{text}".rstrip() for key, text in self.lines)


def reported(setup: Setup) -> Report:
    """See `Setup.report`."""
    found = setup.found()
    m = found.at(0)
    data: dict[str, Any] = {"file": setup.name, "kind": setup.model.kind, "algebra": m.algebra.name}
    lines: list[tuple[str, str]] = []
    tool = (setup.model.tool, found.position[0]) if setup.model.tool else ("", None)
    _parts(data, lines, m, setup.model.kind, tool)
    _motions(data, lines, m, setup)
    if setup.model.inputs:
        _pose(data, lines, setup, found)
    if setup.model.inputs and setup.model.tool:
        _jacobian(data, lines, setup, found, m)
    return Report(data, lines)


# -- words -----------------------------------------------------------------------------------------------------


def vector(x: Any) -> str:
    """Coordinates in brackets."""
    values = np.asarray(x, float)
    size = float(np.abs(values).max(initial=0.0))
    return f"({', '.join(f'{0.0 if abs(v) <= SMALL * size else v:.{DIGITS}g}' for v in values)})"


def motion_words(twist: Multivector) -> str:
    """What a twist does: "turns about (0, 0, 1) through (1, 0, 0)"."""
    turn, way = np.split(np.asarray(screw_coordinates(twist), float), 2)
    if not np.linalg.norm(turn) > SMALL * np.linalg.norm(way):
        return "rests" if not way.any() else f"slides along {vector(_unit(way))}"
    place, pitch = _axis(turn, way)
    along = f"about {vector(_unit(turn))} through {vector(place)}"
    return f"screws {along}, pitch {pitch:.{DIGITS}g} per radian" if pitch else f"turns {along}"


def wrench_words(wrench: Multivector) -> str:
    """What a wrench is: a force along a line, a couple, or both."""
    force, moment = np.split(np.asarray(screw_coordinates(wrench), float), 2)
    if not np.linalg.norm(force) > SMALL * np.linalg.norm(moment):
        return f"a couple about {vector(_unit(moment))}"
    place, pitch = _axis(force, moment)
    more = " and a couple about it" if pitch else ""
    return f"a force along {vector(_unit(force))} through {vector(place)}{more}"


def _axis(main: Array, other: Array) -> tuple[Array, float]:
    """A point of a screw's axis, and its pitch."""
    square = float(main @ main)
    place, pitch = np.cross(main, other) / square, float(main @ other) / square
    reach = max(float(np.linalg.norm(place)), float(np.linalg.norm(other)) / np.sqrt(square))
    return place, pitch if abs(pitch) > SMALL * max(reach, 1.0) else 0.0


def _unit(x: Array) -> Array:
    """A direction, whose first large coordinate is positive only if it was."""
    return np.asarray(x / np.linalg.norm(x))


def _few(lines: list[tuple[str, str]], key: str, texts: list[str]) -> None:
    """A list below a key."""
    for i, text in enumerate(texts[:MOST]):
        lines.append(("" if i else key, text))
    if len(texts) > MOST:
        lines.append(("", f"and {len(texts) - MOST} more"))


# -- parts of the report ---------------------------------------------------------------------------------------


def _parts(data: dict[str, Any], lines: list[tuple[str, str]], m: Mechanism, kind: str, tool: tuple[str, Any]) -> None:
    lines.append((kind, f"{len(m.bodies)} bodies, {len(m.joints)} joints ({m.algebra.name})"))
    names = [f"{name} (fixed)" if name == m.fixed else name for name in m.bodies]
    lines.append(("bodies", ", ".join(names[:MOST]) + (f" and {len(names) - MOST} more" if len(names) > MOST else "")))
    texts, rows = [], []
    for joint, mark in zip(m.joints, sketched(m, *tool).marks, strict=True):
        row = {"name": mark.name, "kind": mark.kind, "a": joint.a, "b": joint.b, "place": mark.place.tolist()}
        where = f"at {vector(mark.place)}"
        if len(mark.axes):
            row["axis"] = mark.axes[0].tolist()
            where += f", axis {vector(mark.axes[0])}"
        rows.append(row)
        own = "" if mark.name == joint.label else f"{mark.name}, "
        texts.append(f"{own}{mark.kind}, {joint.a} to {joint.b}, {where}")
    _few(lines, "joints", texts)
    data |= {"bodies": list(m.bodies), "fixed": m.fixed, "joints": rows}


def _motions(data: dict[str, Any], lines: list[tuple[str, str]], m: Mechanism, setup: Setup) -> None:
    matrix, mobility, rank = m.constraint_matrix(), m.mobility(), m.rank()
    rows, columns = (int(x) for x in matrix.shape)
    lines.append(("mobility", f"{mobility} (rank {rank} of {rows} constraints on {columns} speeds)"))
    data |= {"mobility": mobility, "rank": rank, "constraints": rows, "speeds": columns, "residual": m.residual()}
    free, texts, rows_ = m.free_motions(), [], []
    every = len(free) * len(m.bodies) <= MOST_TWISTS
    for motion in free:
        moving = motion.bodies
        shown = setup.model.tool if setup.model.tool in moving else moving[-1] if moving else ""
        kept = moving if every else [shown]
        twists = {name: np.asarray(screw_coordinates(motion[name]), float).tolist() for name in kept if name}
        words = {name: motion_words(motion[name]) for name in ([shown] if shown else [])}
        rows_.append({"driver": motion.driver, "alone": motion.idle, "twists": twists})
        what = f"{motion.driver} alone: it " if motion.idle else f"{motion.driver}: {shown} "
        texts.append(what + (words[shown] if shown else "rests"))
    _few(lines, "free motions", texts)
    borne, told = m.redundant(), []
    for stress in borne:
        first = next(iter(stress))
        others = ", ".join(list(stress)[:4]) + (f" and {len(stress) - 4} more" if len(stress) > 4 else "")
        told.append(f"{others} bear {wrench_words(stress[first])}{' at the first' if len(stress) > 1 else ''}")
    lines.append(("redundant constraints", str(len(borne))))
    _few(lines, "", told)
    data |= {
        "free_motions": rows_,
        "redundant": [{n: np.asarray(screw_coordinates(w), float).tolist() for n, w in s.items()} for s in borne],
    }


def _pose(data: dict[str, Any], lines: list[tuple[str, str]], setup: Setup, found: Found) -> None:
    model, units = setup.model, setup.units
    own = ["rad" if turns else units.length for turns in model.turning]
    values = [f"{n} = {x:.6g} {u}" for n, x, u in zip(model.inputs, found.coordinates[0], own, strict=True)]
    _few(lines, "pose", values)
    data["pose"] = dict(zip(model.inputs, found.coordinates[0].tolist(), strict=True))
    low, high = model.limits.T
    out = (found.coordinates[0] < low) | (found.coordinates[0] > high)
    names = [n for n, bad in zip(model.inputs, out, strict=True) if bad]
    data["outside_limits"] = names
    if names:
        lines.append(("outside their limits", ", ".join(names)))
    if model.tool:
        lines.append((f"tool ({model.tool})", f"{vector(found.position[0])} {units.length}"))
        data["tool"] = {"body": model.tool, "position": found.position[0].tolist()}


def _jacobian(data: dict[str, Any], lines: list[tuple[str, str]], setup: Setup, found: Found, m: Mechanism) -> None:
    """From the inputs' speeds to the tool's; where it is singular what is lost, and what is left free."""
    model, place = setup.model, found.position[0]
    inputs = list(model.inputs)
    if isinstance(model, ChainModel):
        inputs = [_free_name(name, m.bodies) for name in inputs]
    whole = isinstance(model, ChainModel) or (isinstance(model, MechanismModel) and model.whole)
    turn = [model.tool] if whole else []
    analysis = m.analysis(inputs, [*turn, (model.tool, place)])
    matrix = analysis.jacobian
    if whole:
        twists = m.algebra.wrap(m.algebra.kind("twist"), np.ascontiguousarray(matrix[:6].T))
        matrix = np.concatenate([np.asarray(screw_coordinates(twists)).T[:3], matrix[6:]])
    condition, code = float(found.condition[0]), Status(int(found.status[0]))
    data["jacobian"] = {
        "inputs": list(model.inputs), "rows": [*(["wx", "wy", "wz"] if whole else []), "vx", "vy", "vz"],
        "matrix": matrix.tolist(), "condition": condition if np.isfinite(condition) else None,
        "singular_values": np.linalg.svd(matrix, compute_uv=False).tolist(), "status": code.name,
    }  # fmt: skip
    rows = [f"{name:>2} {vector(row)}" for name, row in zip(data["jacobian"]["rows"], matrix, strict=True)]
    _few(lines, "Jacobian", rows)
    lines.append(
        ("condition number", f"{condition:.{DIGITS}g}" if np.isfinite(condition) else "infinite: the pose is singular")
    )
    lost, stuck, open_ = _singular(matrix, model, whole, analysis, place)
    data["jacobian"] |= {"lost": lost, "without_effect": stuck, "open": open_}
    for key, ways in (
        ("the tool cannot move", lost),
        ("inputs that do not move it", stuck),
        ("it moves while inputs rest", open_),
    ):
        _few(lines, key, [_way_words(way) for way in ways])
    bad = analysis.residual > analysis.noise
    names = [n for n, no in zip(model.inputs, bad, strict=True) if no]
    data["jacobian"]["not_allowed"] = names
    if names:
        lines.append(("inputs that joints forbid", ", ".join(names)))


def _way_words(way: list[float]) -> str:
    """A direction; of six numbers its turn and its way."""
    if len(way) == 6 and np.abs(way[:3]).max() > SINGULAR:
        return f"turning {vector(way[:3])}, its point by {vector(way[3:])}"
    return f"along {vector(way[-3:])}" if len(way) in (3, 6) else vector(way)


def _singular(
    matrix: Array, model: Any, whole: bool, analysis: Any, place: Array
) -> tuple[list[list[float]], list[list[float]], list[list[float]]]:
    """Directions of the tool that no inputs give, inputs without effect, and what inputs do not hold."""
    rows = np.array([1.0] * (matrix.shape[0] - 3) + [1 / model.length] * 3)
    scaled = matrix * rows[:, None] * np.where(model.turning, 1.0, model.length)
    left, sizes, right = np.linalg.svd(scaled)
    most = model.chain.freedom if isinstance(model, ChainModel) else min(matrix.shape)
    rank = int((sizes > SINGULAR * sizes.max(initial=0.0)).sum())
    lost = (left[:, rank:most] / rows[:, None]).T.tolist() if rank < most == matrix.shape[0] else []
    stuck = right[rank : matrix.shape[1]].tolist() if rank < min(most, matrix.shape[1]) else []
    free = analysis.open[-3:].T if analysis.open.size else np.zeros((0, 3))
    return lost, stuck, free.tolist()


__all__ = ["Report", "motion_words", "reported", "vector", "wrench_words"]
