"""The driver of serial chains: kernels of one algebra, and the loops over joints and poses around them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

from ..errors import InputError
from ..formulas.mechanics import chains
from ..targets.c.instances import BASELINE, SCALAR, WIDE
from . import KernelSpec, Program, program, stock_algebra

ALGEBRAS = ("cga3d", "pga3d")
#: Joints that a driver has room for: one that fits a six-axis arm keeps all it needs near.
CLASSES = (16, 256, 4096)
#: Beyond this many joints poses are not taken several at a time: their numbers would fill a thread's stack.
MOST_WIDE = 256


@dataclass(frozen=True)
class ChainConfig:
    """Algebra and capacity of a driver of chains.

    Parameters
    ----------
    algebra : str
    joints : int
        Of `CLASSES`: how many it has room for.
    """

    algebra: str = "cga3d"
    joints: int = CLASSES[0]


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
def chain_program(needs: ChainConfig) -> Program:
    """The program of chains of up to so many joints."""
    if needs.algebra not in ALGEBRAS:
        raise InputError(f"{needs.algebra!r} is not an algebra of chains; there are: {', '.join(ALGEBRAS)}.")
    rotor = stock_algebra(needs.algebra).kind("rotor").blades
    wide = [i for i in (*BASELINE, *WIDE) if i.bits == 64] if needs.joints <= MOST_WIDE else []
    values = {
        "title": f"Chains of up to {needs.joints} joints in {needs.algebra}",
        "prefix": needs.algebra,
        "joints": needs.joints,
        "identity": [int(not b) for b in rotor],
        "instances": [*(i for i in SCALAR if i.bits == 64), *wide],
        "elementary": True,
    }
    name = f"chain_{needs.algebra}_{needs.joints}"
    return program(name, _kernel_specs(needs.algebra), "chain.c.j2", "chain_types.h", values)


def _kernel_specs(algebra: str) -> list[KernelSpec]:
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
    return [
        KernelSpec(getattr(chains, name), tuple(text.split(", ")), f"chain_{name}", algebra)
        for name, text in kinds.items()
    ]
