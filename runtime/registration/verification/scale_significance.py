"""Whether matches tell the scale of a similarity. Directions say nothing of it, and any four planes agree at some scale
and place: the matches beyond those that determine these four numbers must not be accidental.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.programs.registration.registration import DIRECTED, matched_as
from ..model.similarity import similarity
from ..result import Registration
from ..search.problem import RegistrationProblem
from .ranking import GAP_LEVEL
from .significance import log_nfa

Array = NDArray[Any]
#: Scale and translation.
UNKNOWNS = 4
#: Coordinates of a position that agree in a match; of other kinds three.
POSITION_COORDINATES = {"line": 2, "plane": 1}
#: Standard deviation of the errors of matches over their largest distance, about.
ERROR = 0.4
#: Largest relative standard deviation of a scale.
MAX_DEVIATION = 0.2
#: Largest number of query objects of a kind whose directions are compared with those of the reference.
MAX_COMPARED = 256


def least_squares_scale(problem: RegistrationProblem, result: Registration) -> tuple[float, float]:
    """Scale of least squares over the matches, for the rotation of a result, and its standard deviation for errors of
    one unit; NaN where they do not determine it.

    Residuals of scale s and translation t: s R x + t - y, projected across lines and planes, and s r - r' of radii.
    """
    rotation = similarity(result.motor)[1]
    rows, targets = [np.zeros((0, UNKNOWNS))], [np.zeros(0)]
    for kind in problem.query.data.rows:
        matched = result.matches[kind]
        x = problem.query.data.elements[kind][matched >= 0]
        y = problem.reference.data.elements[kind][matched[matched >= 0]]
        normal_projection = np.einsum("ni,nj->nij", y[:, 3:6], y[:, 3:6])
        projection = {"plane": normal_projection, "line": np.eye(3) - normal_projection}.get(
            matched_as(kind), np.broadcast_to(np.eye(3), normal_projection.shape)
        )
        rows.append(
            np.concatenate([(projection @ (x[:, :3] @ rotation.T)[..., None]), projection], -1).reshape(-1, UNKNOWNS)
        )
        targets.append((projection @ y[:, :3, None]).ravel())
        rows.append(np.stack([x[:, 6], *np.zeros((3, len(x)))], -1))
        targets.append(y[:, 6])
    matrix = np.concatenate(rows)
    solution, _, rank, _ = np.linalg.lstsq(matrix, np.concatenate(targets), rcond=None)
    if rank < UNKNOWNS or not solution[0] > 0:
        return math.nan, math.nan
    return float(solution[0]), math.sqrt(float(np.linalg.inv(matrix.T @ matrix)[0, 0]))


def check_scale(problem: RegistrationProblem, result: Registration) -> Registration:
    """Clear ``converged`` of a result whose matches do not tell its scale."""
    if not result.converged:
        return result
    scale, deviation = least_squares_scale(problem, result)
    distance = result.threshold / problem.reference.unit
    if not ERROR * distance * deviation < MAX_DEVIATION * scale:
        return replace(result, converged=False, doubt=math.inf, message="the matches do not determine the scale")
    doubt = _scale_log_nfa(problem, result, result.threshold / result.unit)
    if doubt <= math.log10(GAP_LEVEL):
        return result
    counts = {kind: int((x >= 0).sum()) for kind, x in result.matches.items()}
    none = [kind.replace("_", " ") for kind, n in counts.items() if not n]
    lacking = f" (no match of {' or '.join(none)})" if none else ""
    message = f"the scale is not significant: too few matches confirm it{lacking}"
    return replace(result, converged=False, doubt=doubt, message=message)


def _scale_log_nfa(problem: RegistrationProblem, result: Registration, distance: float) -> float:
    """log10 of the number of accidental scales and translations, for the rotation of a result, with as many matches."""
    kinds = sorted(problem.query.data.rows, key=lambda kind: _coordinates(problem, kind))
    return max(_log_nfa_without_first(problem, result, distance, order) for order in (kinds, kinds[::-1]))


def _log_nfa_without_first(
    problem: RegistrationProblem, result: Registration, distance: float, kinds: list[str]
) -> float:
    """`_scale_log_nfa` if matches of the first of some kinds determine scale and translation, and confirm nothing. As
    many were tried as there are such sets of matches.
    """
    total, remaining = 0.0, UNKNOWNS
    for kind in kinds:
        coordinates, hits = _coordinates(problem, kind), int((result.matches[kind] >= 0).sum())
        count, alike = _agreeing_directions(problem, result, kind, distance)
        count = max(count, hits)
        used = min(hits, -(-remaining // coordinates))
        remaining = max(remaining - used * coordinates, 0)
        total += math.log10(math.comb(count, used)) + used * math.log10(alike)
        probability = min(alike * (2 * distance / math.sqrt(3)) ** coordinates, 1.0)
        total += min(log_nfa(hits - used, count - used, probability, 1), 0.0)
    return total


def _coordinates(problem: RegistrationProblem, kind: str) -> int:
    has_radius = bool((problem.reference.data.elements[kind][:, 6] > 0).all())
    return POSITION_COORDINATES.get(matched_as(kind), 3) + has_radius


def _agreeing_directions(
    problem: RegistrationProblem, result: Registration, kind: str, distance: float
) -> tuple[int, float]:
    """Number of query objects that the rotation of a result turns into a direction of the reference, within the
    distance of a match, and the mean number of reference objects of that direction.
    """
    query, reference = (side.data.elements[kind][:, 3:6] for side in (problem.query, problem.reference))
    if kind not in DIRECTED:
        return len(query), float(len(reference))
    some = query[:: -(-len(query) // MAX_COMPARED)]
    cosines = np.abs(some @ similarity(result.motor)[1].T @ reference.T)
    agreeing = (cosines >= math.cos(min(2 * distance / problem.length, math.pi / 2))).sum(1)
    fraction = float((agreeing > 0).mean())
    return round(fraction * len(query)), max(float(agreeing.mean()) / fraction, 1.0) if fraction else 1.0
