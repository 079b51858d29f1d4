"""C sources of the table-driven product that every algebra falls back on; no algebra is known here."""

from __future__ import annotations

from collections.abc import Sequence

from ..templates import render, template_text
from .instances import OF_KERNELS, Instance


def general_files(instances: Sequence[Instance] = OF_KERNELS) -> dict[str, str]:
    """Generated files of the general product's extension: kernels.c and kernels.cdef."""
    return {
        "kernels.c": render("general.c.j2", instances=instances),
        "kernels.cdef": template_text("general.cdef"),
    }
