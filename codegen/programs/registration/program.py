"""The program that registers models of some kinds of object: the stages, the robust center, and Algorithm 1."""

from __future__ import annotations

import json
from collections.abc import Mapping
from functools import cache

from ...ir.loops.algorithm import Algorithm
from ...ir.loops.nodes import Function
from ...ir.loops.scope import Static
from ...ir.loops.types import StaticType
from .. import KernelSpec, Program
from ..stock import kept_text, stock_numba, stock_program
from . import center, direct, pairs, pose, scene, stages
from .registration import ALL, KIND_SETS, KINDS, PAIR_SETS, in_order, set_name

#: The files with the algorithms.
SOURCE = "programs/registration/program.py"
#: Templates of the C text.
_TEMPLATES = ("programs/algorithms.c", "kernels/kernels.h")
#: What the texts depend on, from the package's folder.
_SOURCES = (SOURCE, "specs/cga3d.toml", *(f"../templates/c/{name}.j2" for name in _TEMPLATES))
#: What callers call; see the docstrings there.
ALGORITHMS = (
    stages.elements, stages.to_frame, stages.squared_distances, stages.motors_to_world, stages.twists_to_world,
    stages.step, pairs.invariants, pairs.invariants_of_all, stages.rates, stages.stiffness, stages.samples,
    stages.refine, stages.match, stages.match_segments, stages.residual_rates, pose.descend, pose.influences,
    center.robust_center, direct.direct,
)  # fmt: skip


def _specialise(algorithm: Algorithm, name: str) -> Function:
    parameters = algorithm.text.parameters
    return algorithm.specialised([Static(name) if isinstance(p.type, StaticType) else p.type for p in parameters])


def _specs(name: str) -> list[KernelSpec]:
    """All kernels of a set of kinds."""
    specs = [scene.near_motor, scene.apart, stages.step_motor, stages.unseen, stages.unseen_twist, direct.change,
             scene.ends_apart, stages.position_rates, stages.direction_rates]  # fmt: skip
    for kind in KIND_SETS[name]:
        specs += [kind.element, kind.in_frame, kind.rates, kind.moved, kind.form, kind.off, kind.half_step]
        specs += [] if kind.directed else [kind.half_step_of_two]
    return list(dict.fromkeys([*specs, *(pair.invariants for pair in PAIR_SETS[name])]))


@cache
def reform_program(kinds: tuple[str, ...] = KINDS) -> Program:
    """The program that registers models of these kinds, and has nothing for others.

    Raises
    ------
    InputError
        If there is no such kind, or none at all.
    """
    name = set_name(kinds)
    title = f"Registration of models of {', '.join(in_order(kinds))}"
    functions = {each.name: _specialise(each, name) for each in ALGORITHMS}
    return stock_program("reform" if name == ALL else f"reform_{name}", title, {name: functions}, _specs(name), SOURCE)


@cache
def reform_texts(kinds: tuple[str, ...]) -> Mapping[str, str]:
    """Generated files of the program: made once for each state of the sources, and kept in the cache."""
    text = kept_text(f"reform_{set_name(kinds)}", lambda: json.dumps(dict(reform_program(kinds).files)), _SOURCES)
    files: dict[str, str] = json.loads(text)
    return files


@cache
def reform_numba(kinds: tuple[str, ...] = KINDS) -> str:
    """The same for numba."""
    name = set_name(kinds)

    def functions() -> dict[str, Function]:
        return {f"bs_{each.name}_{name}": _specialise(each, name) for each in ALGORITHMS}

    return stock_numba(f"reform_{name}", functions, _SOURCES)
