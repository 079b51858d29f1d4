"""The program of motions of trees of links in joint coordinates: one for all trees, whose sizes are data."""

from __future__ import annotations

import json
from collections import namedtuple
from collections.abc import Callable
from functools import cache
from typing import TYPE_CHECKING, Any, NamedTuple

from ..build import text_cache
from ..formulas.mechanics import articulated, joint_laws, link_poses, mechanics
from ..targets.loops import in_calling_order
from . import KernelSpec, Program, chains
from .algorithms import numba_text
from .dynamics.loads import BODY_LOADS, LAW_PLACES
from .stock import ENTRIES, entries, stock_program
from .trees import kernel_specs

if TYPE_CHECKING:
    from ..ir.loops.nodes import Function

#: Of names of loops: one simulation of a batch each.
PART = "items"
#: What the texts depend on, from the package's folder.
_SOURCE = "algorithms/trees/motion.py"
_SOURCES = (_SOURCE, "programs/tree_motion.py", "../templates/c/programs/algorithms.c.j2")
#: Formulas that trees of links have not, by their arguments.
_FORMULAS: dict[Callable[..., Any], str] = {
    link_poses.ball_rotation: "layout rotor, position",
    link_poses.ball_rotor: "layout rotor, layout rotor, position",
    link_poses.ball_reference: "layout rotor, position",
    link_poses.ball_rate: "position, position",
    link_poses.screw_in_frame: "layout rotor, position, twist",
    link_poses.screw_from_frame: "layout rotor, position, twist",
    link_poses.wrench_of_powers: "numbers6",
    link_poses.joint_wrench: "position, number, number, number",
    link_poses.point_in_world: "layout rotor, position, position",
    link_poses.loop_wrench: "layout rotor, position, position, position",
    link_poses.loop_wrench_rate: "layout rotor, position, position, position, twist, twist",
    link_poses.loop_errors: "layout rotor, position, position, position, layout rotor, position",
    link_poses.screw_power: "twist, twist",
    articulated.pass_wrench: "numbers9, position, twist, twist, number, number, twist",
    joint_laws.joint_law: "number, number, numbers9",
    mechanics.spring: "motor, twist, position, motor, twist, position, numbers3",
}


class TreeMotionTexts(NamedTuple):
    """What a program is made of: C, or Python for numba, and what callers know of its loops."""

    name: str
    text: str
    entries: str


def _kernels(algebra: str) -> tuple[dict[str, KernelSpec], tuple[Any, ...]]:
    """Kernels by name, and the laws of loads of one body."""
    found = kernel_specs(algebra)
    for formula, kinds in _FORMULAS.items():
        found[formula.__name__] = KernelSpec(formula, tuple(kinds.split(", ")), f"tree_{formula.__name__}", algebra)
    laws = []
    for name, place in LAW_PLACES.items():
        load = BODY_LOADS[name]
        spec = KernelSpec(load.formula, tuple(load.kinds.split(", ")), f"tree_{name}", algebra)
        laws.append((spec, place.first, place.last, place.has_motor, place.has_twist))
    return found, tuple(laws)


@cache
def motion_functions(algebra: str, is_implicit: bool = False) -> dict[str, Function]:
    """The algorithms that callers call: runs; steps of a fixed size, or with implicit ones intervals."""
    from ..algorithms.chains import ChainKernels
    from ..algorithms.trees.accelerations import motion_algorithms
    from ..algorithms.trees.closing import closing_algorithms
    from ..algorithms.trees.implicit_steps import implicit_step_algorithms
    from ..algorithms.trees.loops import loop_algorithms
    from ..algorithms.trees.motion import tree_motion_algorithms
    from ..algorithms.trees.steps import step_algorithms

    specs, laws = _kernels(algebra)
    names: Any = namedtuple("Kernels", list(specs))  # type: ignore[misc]
    k = names(*specs.values())
    chain = ChainKernels(**chains.kernel_specs(algebra))
    motion = motion_algorithms(k, chain, chains.identity_rotor(algebra), laws)
    closing = closing_algorithms(k, motion, loop_algorithms(k, chains.identity_rotor(algebra)))
    steps = step_algorithms(k, closing)
    if is_implicit:
        steps = implicit_step_algorithms(closing, steps)
    found = tree_motion_algorithms(motion, closing, steps)._asdict()
    del found["steps" if is_implicit else "intervals"]
    return {name: each.specialised([p.type for p in each.text.parameters]) for name, each in found.items()}


@cache
def tree_motion_program(algebra: str, is_implicit: bool = False) -> Program:
    """The program in C, of explicit steps or of implicit ones."""
    name = _name(algebra, is_implicit)

    def make() -> str:
        specs, laws = _kernels(algebra)
        used = [*specs.values(), *(law[0] for law in laws), *chains.kernel_specs(algebra).values()]
        functions = motion_functions(algebra, is_implicit)
        own = {spec.name for spec in used}
        used += [x.kernel for x in in_calling_order(functions.values())[1] if x.kernel.name not in own]  # tangents
        program = stock_program(name, "Motion of trees", {PART: functions}, used, _SOURCE)
        return json.dumps(dict(program.files))

    return Program(name, (), json.loads(_made_once(f"c_{name}", algebra, make)), options=("-O2",))


def tree_motion_numba(algebra: str, is_implicit: bool = False) -> TreeMotionTexts:
    """The same as Python text for numba."""

    name = _name(algebra, is_implicit)

    def make() -> str:
        functions = motion_functions(algebra, is_implicit)
        text = numba_text(name, {f"{each}_{PART}": f for each, f in functions.items()})
        return json.dumps([text, entries({PART: functions})])

    return TreeMotionTexts(name, *json.loads(_made_once(f"numba_{name}", algebra, make)))


def _made_once(title: str, algebra: str, make: Callable[[], str]) -> str:
    return text_cache.made_once("tree_motion", (*_SOURCES, f"specs/{algebra}.toml"), f"{title}.json", make)


def _name(algebra: str, is_implicit: bool) -> str:
    return f"tree_motion_{algebra}" + ("_implicit" if is_implicit else "")


__all__ = ["ENTRIES", "PART", "motion_functions", "tree_motion_numba", "tree_motion_program"]
