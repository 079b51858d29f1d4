"""The schema of an algebra's spec file, and reading one. Imported only when a file is read (pydantic is slow).

name = "pga2d"                                  # identifier
vectors = ["0", "1", "2"]                       # digits give e0, e1, ...; identifiers stand for themselves
metric = [["1", "1", 1], ["2", "2", 1]]         # non-zero inner products of basis vectors, integers or "1/2"
pseudoscalar = "e120"                           # optional: order of the dual's pseudoscalar

[kinds.plane]                                   # blades, what holds for every member, and a random member
grades = [1]                                    # or blades = ["e1", ...]
constraints = ["x * x - 1"]
member = "unit(e1, e2) + scalar() * e0"

[[kernels]]                                     # what is compiled
formula = "products.geometric"                  # module.function of codegen/formulas
operands = [["motor", "motor"], ["motor", "layout point"]]
serves = "products.geometric"                   # optional: the operation it stands for, if another
"""

from __future__ import annotations

from collections.abc import Mapping
from importlib import resources
from pathlib import Path
from typing import Any

from pydantic import Field

from ..documents.document import Table, read_document
from ..errors import SpecError, suggest
from .loader import PRESETS, STOCK


class KindTable(Table):
    """[kinds.<name>]."""

    blades: list[str] = Field(default_factory=list)
    grades: list[int] = Field(default_factory=list)
    constraints: list[str] = Field(default_factory=list)
    member: str = ""


class KernelTable(Table):
    """[[kernels]]."""

    formula: str
    operands: list[list[str]]
    name: str | None = None
    serves: str | None = None


class SpecFile(Table):
    """A whole spec file."""

    name: str
    vectors: list[str]
    metric: list[tuple[str, str, int | str]] = Field(default_factory=list)
    pseudoscalar: str | None = None
    kinds: dict[str, KindTable] = Field(default_factory=dict)
    kernels: list[KernelTable] = Field(default_factory=list)


def load_spec(path: str | Path) -> Mapping[str, Any]:
    """Read and check a spec file.

    Raises
    ------
    SpecError
        If the file cannot be read, is not TOML, or does not fit the schema: file, line, key and remedy.
    """
    return read_document(path, SpecFile, SpecError).contents.model_dump(exclude_none=True)


def stock_spec_path(name: str) -> Path:
    """Path of a bundled spec.

    Raises
    ------
    SpecError
        If there is no stock algebra of this name.
    """
    known = (*STOCK, *PRESETS)
    if name not in known:
        raise SpecError(f"there is no stock algebra {name!r}{suggest(name, known)}; there are: {', '.join(known)}.")
    return Path(str(resources.files(__package__.rpartition(".")[0]).joinpath("specs", f"{name}.toml")))
