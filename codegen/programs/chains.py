"""Programs of serial chains: the algorithms of algorithms/chains.py on the formulas of one algebra."""

from __future__ import annotations

import json
from functools import cache
from typing import TYPE_CHECKING

from ..build import text_cache
from ..build.cpu_features import best_instances
from ..errors import InputError
from ..formulas.mechanics import chains
from ..targets.c.instances import ONE_BY_ONE, Instance
from ..targets.c.source import ExtensionSource
from . import KernelSpec, extension_of, stock_algebra

if TYPE_CHECKING:
    from ..algorithms.chains import ChainAlgorithms
    from ..ir.loops.nodes import Function

ALGEBRAS = ("cga3d", "pga3d")
#: Joints that an algorithm has room for: one that fits a six-axis arm keeps all it needs near.
CLASSES = (16, 256, 4096)
#: Beyond this many joints poses are not computed several at a time: their numbers would fill a thread's stack.
MOST_WIDE = 256
#: What all items share, by algorithm.
SHARED = {
    "forward": ("joints", "frames", "base"),
    "jacobian": ("joints", "tool", "base", "frame"),
    "twists": ("joints", "base"),
    "inverse": ("joints", "tool", "base", "limits", "restarts", "poses", "search", "iterations", "nearest"),
}
#: What the C texts depend on, from the package's folder.
_SOURCES = (
    "programs/chains.py",
    "../templates/c/programs/algorithm.c.j2",
    "../templates/c/kernels/kernel.h.j2",
)


def class_of(joints: int) -> int:
    """The least class that has room.

    Raises
    ------
    InputError
    """
    for most in CLASSES:
        if joints <= most:
            return most
    raise InputError(f"a chain of {joints} joints is longer than the longest that is computed, {CLASSES[-1]}.")


@cache
def algorithms_of(algebra: str, room: int) -> ChainAlgorithms:
    """The algorithms of chains of up to so many joints.

    Raises
    ------
    InputError
        If chains are not in this algebra.
    """
    from ..algorithms.chains import ChainKernels, chain_algorithms

    if algebra not in ALGEBRAS:
        raise InputError(f"{algebra!r} is not an algebra of chains; there are: {', '.join(ALGEBRAS)}.")
    return chain_algorithms(ChainKernels(**kernel_specs(algebra)), identity_rotor(algebra), room)


def identity_rotor(algebra: str) -> tuple[float, ...]:
    """Coefficients of the rotor 1."""
    return tuple(float(not blade) for blade in stock_algebra(algebra).kind("rotor").blades)


def chain_function(algebra: str, room: int, name: str) -> Function:
    """The IR of one of the algorithms, "forward", "jacobian", "twists" or "inverse"."""
    algorithm = getattr(algorithms_of(algebra, room), name)
    function: Function = algorithm.specialised([p.type for p in algorithm.text.parameters])
    return function


def chain_extension(
    algebra: str, room: int, name: str, instance: Instance | None = None, is_wide: bool = True
) -> tuple[ExtensionSource, str]:
    """C text of one of the algorithms, ready to compile, and the tag of its loop.

    Parameters
    ----------
    instance : Instance, optional
        Default: the one that this processor runs best.
    is_wide : bool
        Whether several poses are computed at once, where there is room for them.
    """
    chosen, shared = ONE_BY_ONE[0], None
    if is_wide and name in SHARED and room <= MOST_WIDE:
        (chosen,), shared = best_instances("f64") if instance is None else (instance,), SHARED[name]

    def make() -> str:
        from .algorithms import algorithm_files

        return json.dumps(algorithm_files(chain_function(algebra, room, name), (chosen,), shared))

    sources = (*_SOURCES, f"specs/{algebra}.toml")
    text = text_cache.made_once("chain", sources, f"{algebra}_{room}_{name}_{chosen.tag}.json", make)
    return extension_of(f"chain_{algebra}_{room}_{name}", json.loads(text)), chosen.tag


def kernel_specs(algebra: str) -> dict[str, KernelSpec]:
    """The kernels by the names of `ChainKernels`."""
    turn, pose = "layout rotor", "layout rotor, position"
    joint = "position, position, number, number"
    kinds = {
        "joint_position": f"{pose}, position, position, number",
        "rotate": f"{turn}, position, number",
        "link_direction": f"{turn}, position",
        "frame_pose": f"{pose}, position, layout rotor",
        "compose": f"{pose}, position",
        "unit_twist": joint,
        "column": "position, position, position, number, number",
        "body_column": f"{turn}, position, position, position, number, number",
        "link_twist": "twist, twist, twist, number, number",
        "decompose": "layout motor, position",
        "pose_error": f"{pose}, layout rotor, position",
    }
    return {
        name: KernelSpec(getattr(chains, name), tuple(text.split(", ")), f"chain_{name}", algebra)
        for name, text in kinds.items()
    }
