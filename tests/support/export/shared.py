"""Exported C99 as a shared library: each function of a file on arrays of numbers."""

from __future__ import annotations

import ctypes
import subprocess
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

GCC = ["gcc", "-std=c99", "-pedantic", "-Wall", "-Wextra", "-Wshadow", "-Werror", "-O2", "-ffp-contract=off"]


class SharedLibrary:
    """Functions of a header.

    Parameters
    ----------
    folder : Path
        Where the header is.
    name : str
        Of the file.
    functions : mapping of str to int
        Names of functions, and how many arrays of float64 each takes; those whose count is negative return an integer.
    """

    def __init__(self, folder: Path, name: str, functions: Mapping[str, int]) -> None:
        lines = [f'#include "{name}.h"']
        for function, count in functions.items():
            taken = [f"double *a{k}" for k in range(abs(count))]
            given = ", ".join(f"a{k}" for k in range(abs(count)))
            call = f"{name}_{function}({given});"
            body = f"return (int){call}" if count < 0 else f"{call} return 0;"
            head = f"int call_{function}({', '.join(taken)})"
            lines += [f"{head};", f"{head} {{ {body} }}"]
        (folder / "shared.c").write_text("\n".join(lines) + "\n")
        subprocess.run([*GCC, "-shared", "-fPIC", "shared.c", "-o", f"{name}.so", "-lm"], cwd=folder, check=True)
        self.library = ctypes.CDLL(str(folder / f"{name}.so"))

    def __call__(self, function: str, *arrays: Any) -> int:
        pointers = [a.ctypes.data_as(ctypes.POINTER(ctypes.c_double)) for a in arrays]
        assert all(a.dtype == np.float64 and a.flags.c_contiguous for a in arrays)
        return int(getattr(self.library, f"call_{function}")(*pointers))
