"""What runs on which target: declared once, for `bladesmith doctor` and docs/algebra/targets.md."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

#: What an entry says of a program that runs as a whole, and of one that does not at all; others say how much of it.
YES = "yes"
NO = "no"

#: Programs by name, and what they are.
PROGRAMS = {
    "kernels": "kernels, `@codegen.kernel`: float64, float32, statuses, kernels that call kernels",
    "algorithms": "algorithms, `@codegen.algorithm`",
    "table products": "any product of any algebra, by table",
    "all pairs": "all pairs of two batches, nearest of a batch (costs, k-means)",
    "scenes": "scenes (`tracer`)",
    "registration": "registration",
    "merging": "merging of similar objects",
    "simulations": "simulations",
    "chains": "serial chains; torques and accelerations of robots",
    "mechanisms": "poses and Jacobians of mechanisms",
}


@dataclass(frozen=True)
class Target:
    """A language, and what is printed in it.

    Attributes
    ----------
    name : str
    needs : str
        What must be installed.
    programs : mapping of str to str
        For each of `PROGRAMS`: `YES`, `NO`, or how much of it.
    """

    name: str
    needs: str
    programs: Mapping[str, str]

    def __post_init__(self) -> None:
        assert self.programs.keys() == PROGRAMS.keys(), self.name


C = Target("C", "a C compiler, or the stock kernels of the wheel", dict.fromkeys(PROGRAMS, YES))
NUMBA = Target(
    "numba", "the extra `numba`",
    {
        **dict.fromkeys(PROGRAMS, NO),
        "kernels": YES,
        "algorithms": "float64",
        "table products": "large batches, float64",
        "all pairs": "written out in blocks",
        "scenes": "float64",
        "registration": "float64",
        "merging": "float64",
        "simulations": "float64",
        "chains": "float64",
        "mechanisms": "float64",
    },
)  # fmt: skip
NUMPY = Target(
    "NumPy", "nothing",
    {**dict.fromkeys(PROGRAMS, NO), "kernels": YES, "table products": YES, "all pairs": "written out in blocks"},
)  # fmt: skip
CUDA = Target(
    "CUDA", "the extra `cuda` to compile, a GPU to run",
    {
        **dict.fromkeys(PROGRAMS, NO),
        "kernels": YES,
        "algorithms": YES,
        "table products": "`product_table(...).on(\"cuda\")`",
        "all pairs": "written out in blocks",
        "scenes": YES,
        "registration": "float64",
        "merging": "float64: the first search",
        "simulations": "float64, without functions of users",
        "chains": "float64",
        "mechanisms": "float64",
    },
)  # fmt: skip

TARGETS = (C, NUMBA, NUMPY, CUDA)


def markdown_table() -> str:
    """The table of docs/algebra/targets.md."""
    rows = [["", *(t.name for t in TARGETS)], ["---"] * (1 + len(TARGETS)), ["needs", *(t.needs for t in TARGETS)]]
    rows += [[what, *(t.programs[name] for t in TARGETS)] for name, what in PROGRAMS.items()]
    return "".join("| " + " | ".join(row).lstrip() + " |\n" for row in rows)


def compiled_only() -> list[str]:
    """Programs that only C and CUDA have."""
    return [name for name in PROGRAMS if NUMBA.programs[name] == NO and NUMPY.programs[name] == NO]
