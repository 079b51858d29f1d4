"""Programs of mechanisms: the algorithms of this folder on the formulas of one algebra. One serves all mechanisms."""

from __future__ import annotations

import json
from dataclasses import replace
from functools import cache
from typing import TYPE_CHECKING

from ...algebra.closed_kinds import closed_kinds
from ...build import text_cache
from ...errors import InputError
from ...formulas.mechanics import joints, mechanics, pins
from ...targets.c.instances import ONE_BY_ONE, Instance
from ...targets.c.source import ExtensionSource
from .. import KernelSpec, extension_of, stock_algebra

if TYPE_CHECKING:
    from ...ir.loops.algorithm import Algorithm
    from ...ir.loops.nodes import Function
    from .rows import MechanismKernels

ALGEBRAS = ("cga3d", "pga3d")
#: Rows and columns that an algorithm has room for.
CLASSES = (32, 96, 256, 512, 1024, 2048, 4096, 8192)
#: What each item has of its own, beside its results; the rest is shared, or work arrays.
OWN = ("given", "wanted", "goals")
#: The algorithms: poses, Jacobians by elimination and by all rows at once.
NAMES = ("poses", "elimination", "general")
#: Options of the compiler. Jacobians are short sums: gcc's vectors of them take up to a third longer.
_OPTIONS = dict.fromkeys(("elimination", "general"), ("-fno-tree-vectorize",))
_SOURCES = (
    "programs/mechanisms/program.py",
    "../templates/c/programs/algorithm.c.j2",
    "../templates/c/kernels/kernel.h.j2",
)


def class_of(size: int) -> int:
    """The least class that has room for so many rows and columns.

    Raises
    ------
    InputError
    """
    for most in CLASSES:
        if size <= most:
            return most
    raise InputError(f"a mechanism of {size} rows or columns is larger than the largest, {CLASSES[-1]}.")


@cache
def algorithms_of(algebra: str, room: int) -> dict[str, Algorithm]:
    """The algorithms of mechanisms of up to so many rows and columns, by name.

    Raises
    ------
    InputError
        If mechanisms are not in this algebra.
    """
    from ...algorithms.weighted_rows import weighted_rows
    from .jacobians import jacobian_algorithms
    from .poses import pose_algorithm
    from .rows import row_algorithms

    if algebra not in ALGEBRAS:
        raise InputError(f"mechanisms are compiled in {' and '.join(ALGEBRAS)}, not in {algebra!r}.")
    motor = stock_algebra(algebra).kind("motor").blades
    kernels = mechanism_kernels(algebra)
    identity = tuple(float(not blade) for blade in motor)
    rows = row_algorithms(kernels, identity)
    system = weighted_rows(room, room, is_open=True)
    jacobians = jacobian_algorithms(rows, system, room)
    return {
        "poses": pose_algorithm(kernels, rows, identity, system, room),
        "elimination": jacobians.elimination, "general": jacobians.general,
    }  # fmt: skip


def mechanism_function(algebra: str, room: int, name: str) -> Function:
    """The IR of one of `NAMES`."""
    algorithm = algorithms_of(algebra, room)[name]
    return algorithm.specialised([p.type for p in algorithm.text.parameters])


def mechanism_extension(
    algebra: str, room: int, name: str, instance: Instance = ONE_BY_ONE[0]
) -> tuple[ExtensionSource, str]:
    """C text of one of `NAMES`, ready to compile, and the tag of its loop.

    Parameters
    ----------
    instance : Instance
        With `wide_instance` several items are computed at once.
    """

    def make() -> str:
        from ..algorithms import algorithm_files

        function = mechanism_function(algebra, room, name)
        if not instance.wide:
            return json.dumps(algorithm_files(function, (instance,)))
        shared = {p.name for p in function.parameters if p.access == "in"} - set(OWN)
        scratch = [p.name for p in function.parameters if p.access == "inout"]
        return json.dumps(algorithm_files(function, (instance,), shared, scratch))

    sources = (*_SOURCES, f"specs/{algebra}.toml")
    text = text_cache.made_once("mechanism", sources, f"{algebra}_{room}_{name}_{instance.tag}.json", make)
    extension = extension_of(f"mechanism_{algebra}_{room}_{name}", json.loads(text))
    return replace(extension, options=_OPTIONS.get(name, ())), instance.tag


@cache
def work_of(room: int) -> dict[str, tuple[int]]:
    """Shapes of the system of rows, beside the arrays of `MechanismTables.work`."""
    from ...algorithms.weighted_rows import weighted_rows

    system = weighted_rows(room, room, is_open=True)
    return {"s": (system.numbers.size,), "indices": (system.integers.size,)}


def layouts_of(algebra: str) -> tuple[tuple[str, int], ...]:
    """Layouts of shared objects and their sizes, in the order of their indices."""
    home = stock_algebra(algebra)
    return tuple((name, home.kind(name).size) for name in closed_kinds(home))


@cache
def mechanism_kernels(algebra: str) -> MechanismKernels:
    """The kernels of one algebra."""
    from .rows import MechanismKernels

    def spec(formula: object, kinds: str, name: str) -> KernelSpec:
        return KernelSpec(formula, tuple(kinds.split(", ")), f"mechanism_{name}", algebra)  # type: ignore[arg-type]

    layouts = list(enumerate(layouts_of(algebra)))
    return MechanismKernels(
        spec(joints.compose, "motor, motor", "compose"),
        spec(joints.relative, "motor, motor", "relative"),
        spec(joints.adjoint_matrix, "motor", "adjoint_matrix"),
        spec(mechanics.adjoint, "motor", "adjoint"),
        spec(joints.move_by_twist, "twist, motor", "move_by_twist"),
        spec(joints.twist_between, "motor, motor", "twist_between"),
        spec(joints.point_rates, "position", "point_rates"),
        spec(mechanics.moved_point, "motor, position", "moved_point"),
        tuple(
            (n, size, spec(joints.transform_object, f"motor, layout {name}", f"transform_{name}"))
            for n, (name, size) in layouts
        ),
        tuple((n, size, spec(pins.moved_rates, f"layout {name}", f"rates_{name}")) for n, (name, size) in layouts),
    )
