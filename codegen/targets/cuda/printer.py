"""CUDA: the kernel bodies of the C target as device functions, and a launcher around each.

One text serves both precisions. It includes headers of templates/c, which are found by name when it is
compiled or made self-contained.
"""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence

from ...errors import SpecError
from ...optimise.variants import Variant
from ..c.extension import in_dependency_order
from ..c.printer import c_function, symbol
from ..templates import INCLUDE, included_headers, render

#: The file that is compiled; the others are included by it.
MAIN = "kernels.cu"
#: For drivers: their loops are written for C, and carry no words of CUDA.
DRIVER_OPTIONS = ("--device-as-default-execution-space",)
#: In programs, the first line of the functions that the host calls, which a GPU has no use for.
_HOST_PART = "const char *bs_source_hash(void)"


def cuda_source(variants: Sequence[Variant], title: str = "") -> dict[str, str]:
    """Generated files: the main one, the bodies, and the launchers ``<symbol>_batch_f64`` and ``_f32``.

    Parameters
    ----------
    variants : sequence of Variant
    title : str, optional
        First words of the main file's comment; default: the algebra's name.
    """
    functions = [c_function(v) for v in in_dependency_order(variants)]
    values = {
        "title": title or (variants[0].kernel.algebra.name if variants else "kernels"),
        "functions": functions,
        "batched": [symbol(v.kernel) for v in variants],
        "count": len(variants),
        "elementary": any(f.elementary for f in functions),
    }
    return {
        MAIN: render("kernels.cu.j2", **values),
        "kernels.h": render("kernels.h.j2", **values),
        "launch.h": render("launch.h.j2", **values),
    }


def scene_source(files: Mapping[str, str]) -> dict[str, str]:
    """A scene's compiled program as CUDA text: the same driver, with launchers in place of what Python calls.

    Parameters
    ----------
    files : mapping
        File name to text, as in ``scene_program(...).files``. Compile the result with `DRIVER_OPTIONS`.
    """
    driver = _device_part(files)
    tags = re.findall(r"^#define BS_TAG (\w+)$", driver, re.MULTILINE)
    features = dict(re.findall(r"^#define BS_SCENE_(LINES|PICTURES) (\w+)$", driver, re.MULTILINE))
    has = {name.lower(): value != "0" for name, value in features.items()}
    return _with_launchers(files, "scene.cu.j2", driver=driver, tags=tags, **has)


def loops_source(files: Mapping[str, str], loops: Mapping[str, int]) -> dict[str, str]:
    """Loops over items as CUDA text: those of C, and a launcher ``launch_<loop>`` for each.

    Parameters
    ----------
    files : mapping
        File name to text: a C program of algorithms. Compile the result with `DRIVER_OPTIONS`.
    loops : mapping of str to int
        Functions of the program, and how many arrays each takes.
    """
    headers = {name: text for name, text in files.items() if name.endswith(".h")}
    main = render("algorithm.cu.j2", driver=files["kernels.c"], names=list(loops), most=max(loops.values()))
    return {MAIN: main, **headers}


def stock_source(files: Mapping[str, str], part: str = "") -> dict[str, str]:
    """The algorithms of a stock program, or of a part of it, as CUDA text: see `programs.stock` and `loops_source`."""
    entries = {n: e for n, e in json.loads(files["algorithms.json"]).items() if part in ("", e["part"])}
    chosen = f"#define BS_SOME_PARTS\n#define BS_PART_{part}\n" if part else ""
    return loops_source(
        {**files, "kernels.c": chosen + files["kernels.c"]},
        {f"bs_{name}_f64": len(e["parameters"]) + len(e["results"]) for name, e in entries.items()},
    )


def _device_part(files: Mapping[str, str]) -> str:
    """The driver without what Python calls."""
    driver, found, _ = files["kernels.c"].partition(_HOST_PART)
    if not found:
        raise SpecError(f"this program's kernels.c does not have the line {_HOST_PART!r} after its driver.")
    return driver.rstrip() + "\n"


def _with_launchers(files: Mapping[str, str], template: str, **values: object) -> dict[str, str]:
    """The launchers around a driver, and the driver's own headers."""
    own = {name: text for name, text in files.items() if name != "kernels.c"}
    return {MAIN: render(template, **values), **own}


def with_headers(files: Mapping[str, str]) -> dict[str, str]:
    """The files and every header of templates that they include, directly or not."""
    return {**files, **included_headers(files.values(), files)}


def self_contained(files: Mapping[str, str]) -> str:
    """One text without includes of ours: for nvcc, or for other packages that compile CUDA."""
    texts = with_headers(files)

    def expand(text: str) -> str:
        return INCLUDE.sub(lambda found: expand(texts[found[1]]).rstrip(), text)

    return expand(texts[MAIN])
