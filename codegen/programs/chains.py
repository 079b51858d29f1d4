"""The driver of serial chains: kernels of one algebra, and the loops over joints and poses around them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

from ..errors import InputError
from ..formulas import chains
from ..targets.instances import BASELINE, SCALAR, WIDE
from . import Declared, Program, program, stock_algebra

ALGEBRAS = ("cga3d", "pga3d")
#: Joints that a driver has room for: one that fits a six-axis arm keeps all it needs near.
CLASSES = (16, 256, 4096)
#: Beyond this many joints poses are not taken several at a time: their numbers would fill a thread's stack.
MOST_WIDE = 256
_HEADERS = (
    "platform.h", "instance.h", "instance_end.h", "elementary.h", "rows.h", "chain_types.h", "chain_loops.h",
    "chain_inverse.h",
)  # fmt: skip


@dataclass(frozen=True)
class Needs:
    """What chains have in common that one driver serves.

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
def chain_program(needs: Needs) -> Program:
    """The program of chains of up to so many joints."""
    if needs.algebra not in ALGEBRAS:
        raise InputError(f"{needs.algebra!r} is no algebra of chains; there are: {', '.join(ALGEBRAS)}.")
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
    return program(name, _declared(needs.algebra), "c/chain.c.j2", "c/chain_types.h", _HEADERS, values)


def _declared(algebra: str) -> list[Declared]:
    turn, pose = "layout rotor", "layout rotor, position"
    joint = "position, position, number, number"
    kinds = {
        "placed": f"{pose}, position, position, number",
        "turned": f"{turn}, position, number",
        "pointed": f"{turn}, position",
        "framed": f"{pose}, position, layout rotor",
        "landed": f"{pose}, position",
        "unit_twist": joint,
        "column": "position, position, position, number, number",
        "seen_column": f"{turn}, position, position, position, number, number",
        "accumulated": "twist, twist, twist, number, number",
        "taken_apart": "layout motor, position",
        "missing": f"{pose}, layout rotor, position",
    }
    return [
        Declared(getattr(chains, name), tuple(text.split(", ")), f"chain_{name}", algebra)
        for name, text in kinds.items()
    ]
