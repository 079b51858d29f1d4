"""Programs of trees of links: the algorithms of algorithms/trees on the formulas of one algebra."""

from __future__ import annotations

import json
from functools import cache
from typing import TYPE_CHECKING

from ..build import text_cache
from ..build.cpu_features import best_instances
from ..errors import InputError
from ..formulas.mechanics import articulated
from ..ir.loops.tangent import tangent
from ..targets.c.instances import ONE_BY_ONE, Instance
from ..targets.c.source import ExtensionSource
from . import KernelSpec, chains, extension_of
from .chains import ALGEBRAS

if TYPE_CHECKING:
    from ..algorithms.trees.dynamics import TreeAlgorithms
    from ..ir.loops.algorithm import Algorithm
    from ..ir.loops.nodes import Function

#: Joints that an algorithm has room for.
CLASSES = (16, 64, 256, 2048)
#: Beyond this many joints items are not computed several at a time: their numbers would fill a thread's stack.
MOST_WIDE = 64
#: What all items share, by algorithm.
SHARED = {
    "inverse_dynamics": ("joints", "links", "parents", "kinds", "places", "gravity"),
    "mass_matrix": ("joints", "links", "parents", "kinds", "places"),
    "forward_dynamics": ("joints", "links", "parents", "kinds", "places", "gravity"),
    "poses": ("joints", "parents", "coordinates", "frames", "carriers", "base"),
}
#: What derivatives are by. Torques are linear in accelerations: that derivative is the mass matrix.
VARIED = {"inverse_dynamics": ("x", "speeds"), "forward_dynamics": ("x", "speeds", "forces")}
#: What the C texts depend on, from the package's folder.
_SOURCES = (
    "programs/trees.py",
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
    raise InputError(f"a tree of {joints} joints is larger than the largest whose motion is computed, {CLASSES[-1]}.")


@cache
def algorithms_of(algebra: str, room: int, has_frames: bool = False) -> TreeAlgorithms:
    """The algorithms of trees of up to so many joints, of which some may be displaced by frames.

    Raises
    ------
    InputError
        If trees are not in this algebra.
    """
    from ..algorithms.trees.dynamics import TreeKernels, tree_algorithms

    if algebra not in ALGEBRAS:
        raise InputError(f"{algebra!r} is not an algebra of chains; there are: {', '.join(ALGEBRAS)}.")
    return tree_algorithms(TreeKernels(**kernel_specs(algebra)), room, has_frames)


@cache
def pose_algorithm_of(algebra: str, room: int) -> Algorithm:
    """The algorithm of poses of trees of up to so many joints."""
    from ..algorithms.chains import ChainKernels
    from ..algorithms.trees.poses import pose_algorithm

    return pose_algorithm(ChainKernels(**chains.kernel_specs(algebra)), chains.identity_rotor(algebra), room)


def tree_function(algebra: str, room: int, name: str, by: str = "", has_frames: bool = False) -> Function:
    """The IR of one of the algorithms of `SHARED`, or of its derivative by one of `VARIED`.

    A derivative takes the direction behind the algorithm's parameters, then gives the tangent of the result.
    """
    if name == "poses":
        algorithm = pose_algorithm_of(algebra, room)
    else:
        algorithm = getattr(algorithms_of(algebra, room, has_frames), name)
    function: Function = algorithm.specialised([p.type for p in algorithm.text.parameters])
    return tangent(function, (by,)).function if by else function


def tree_extension(
    algebra: str, room: int, name: str, by: str = "", instance: Instance | None = None, has_frames: bool = False
) -> tuple[ExtensionSource, str]:
    """C text of one of the algorithms, ready to compile, and the tag of its loop.

    Parameters
    ----------
    name, by : str
    instance : Instance, optional
        Default: the one that this processor runs best.
    has_frames : bool
        As of `tree_function`, as are the others.
    """
    chosen, shared = ONE_BY_ONE[0], None
    if room <= MOST_WIDE:
        (chosen,), shared = best_instances("f64") if instance is None else (instance,), SHARED[name]

    def make() -> str:
        from .algorithms import algorithm_files

        return json.dumps(algorithm_files(tree_function(algebra, room, name, by, has_frames), (chosen,), shared))

    sources = (*_SOURCES, f"specs/{algebra}.toml")
    title = f"{algebra}_{room}_{name}" + (f"_by_{by}" if by else "") + ("_frames" if has_frames else "")
    text = text_cache.made_once("tree", sources, f"{title}_{chosen.tag}.json", make)
    return extension_of(f"tree_{title}", json.loads(text)), chosen.tag


def kernel_specs(algebra: str) -> dict[str, KernelSpec]:
    """The kernels by the names of `TreeKernels`."""
    place, joint, link = "numbers9, position", "position, number, number", "number, position, numbers6"
    kinds = {
        "joint_rotation": "position, number",
        "joint_displacement": "position, position, number",
        "frame_rotation": "layout rotor",
        "to_child": f"{place}, twist",
        "add_motion": f"{joint}, number, number, twist, twist, twist",
        "add_velocity": f"{joint}, number, twist, twist",
        "link_motion": f"{place}, {joint}, number, number, twist, twist",
        "link_velocity": f"{place}, {joint}, number, twist",
        "add_to_parent": f"{place}, twist, twist",
        "joint_force": f"{joint}, twist",
        "link_wrench": f"{link}, twist, twist",
        "link_bias": f"{link}, twist",
        "joint_momentum": f"{link}, {joint}",
        "add_link": f"{place}, {link}, position, numbers6",
        "rigid_inertia": link,
        "articulated_momentum": f"numbers21, {joint}",
        "release": "numbers21, twist, twist, twist, number, number",
        "add_articulated": f"{place}, numbers21, numbers21",
        "joint_acceleration": f"{place}, {joint}, twist, twist, number, number, twist",
        "rest_rate": "position",
    }
    return {
        name: KernelSpec(getattr(articulated, name), tuple(text.split(", ")), f"tree_{name}", algebra)
        for name, text in kinds.items()
    }
