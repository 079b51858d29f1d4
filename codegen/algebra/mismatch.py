"""What is said where a multivector of another algebra is given: motors of space have a way from one to the other."""

from __future__ import annotations

from typing import Any

from ..errors import AlgebraMismatchError

#: Algebras of space whose motors are the same motions, by the names that users give their modules.
SPATIAL = {"pga3d": "pga", "cga3d": "cga"}
MOTORS = ("motor", "rotor", "translator")


def algebra_mismatch(what: str, given: Any, wanted: Any, otherwise: str | None = None) -> AlgebraMismatchError:
    """The error for a value of another algebra.

    Parameters
    ----------
    what : str
        What is wrong.
    given
        A multivector, or a type: it has a kind and an algebra.
    wanted : Algebra
    otherwise : str, optional
        The remedy where no motor of space is given, or none is wanted.
    """
    return AlgebraMismatchError(what, remedy=motor_conversion(given, wanted) or otherwise)


def motor_conversion(given: Any, wanted: Any) -> str | None:
    """How a motor of pga3d becomes one of cga3d, or back; None for anything else."""
    home = given.algebra.name
    if home == wanted.name or not {home, wanted.name} <= set(SPATIAL) or given.kind.name not in MOTORS:
        return None
    return (
        f"Convert the {given.kind.name}: {SPATIAL[wanted.name]}.motor_from_matrix(poses.to_matrix(x)), "
        "with bladesmith.poses"
    )


__all__ = ["algebra_mismatch", "motor_conversion"]
