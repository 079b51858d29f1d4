"""Programs around exported files: they read rows of numbers of all kernels, and write the results of each row."""

from __future__ import annotations

import subprocess
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from bladesmith.codegen.export.names import camel_case
from bladesmith.codegen.export.places import result_of
from bladesmith.codegen.export.unit import Entry, Slot, Unit

from .stock import Case

#: For gcc and clang: none is to be seen.
WARNINGS = ("-pedantic", "-Wall", "-Wextra", "-Wshadow", "-Wconversion", "-Werror")
#: From a unit to the program's text.
DriverText = Callable[[Unit, int], str]


def run_driver(command: Sequence[str], cases: Sequence[Case], folder: Path) -> list[np.ndarray]:
    """Feed the cases to a program, and take its results."""
    run_program(command, np.concatenate([c.inputs.ravel() for c in cases]), folder)
    found, start = np.fromfile(folder / "results.bin", cases[0].inputs.dtype), 0
    results = []
    for case in cases:
        size = case.results.size
        results.append(found[start : start + size].reshape(case.results.shape))
        start += size
    assert start == found.size
    return results


def run_program(command: Sequence[str], inputs: np.ndarray, folder: Path) -> None:
    """Run a program on a file of numbers; it writes a file of results."""
    (folder / "inputs.bin").write_bytes(inputs.tobytes())
    subprocess.run([*command, "inputs.bin", "results.bin"], cwd=folder, check=True, timeout=300)


def input_places(entry: Entry, row: str) -> list[str]:
    """Arguments as texts of C, made of the numbers of a row."""
    found, start = [], 0
    for slot in entry.inputs:
        size = slot.size or 1
        numbers = [f"{row}[{k}]" for k in range(start, start + size)]
        found.append("{" + ", ".join(numbers) + "}" if slot.size else numbers[0])
        start += size
    return found


def output_places(entry: Entry) -> list[str]:
    """Places of all results behind ``r``, in their order."""
    own = result_of(entry)
    if own.slot:
        return _places(own.slot, "r")
    return [place for slot in own.fields for place in _places(slot, f"r.{slot.name}")]


def _places(slot: Slot, name: str) -> list[str]:
    if slot.struct:
        return [f"{name}.{field}" for field in slot.struct.fields]
    return [f"{name}[{k}]" for k in range(slot.size)] if slot.size else [name]


def c_driver(unit: Unit, count: int) -> str:
    """A program of C for `run_driver`."""
    return c_program(unit, count, f'#include "{unit.name}.h"', prefixed(unit), prefixed(unit))


def cpp_driver(unit: Unit, count: int) -> str:
    """A program of C++ for `run_driver`."""
    real = _real(unit)
    return c_program(
        unit, count, f'#include "{unit.name}.hpp"', lambda name: f"{unit.name}::{camel_case(name)}<{real}>",
        lambda name: f"{unit.name}::{name}",
    )  # fmt: skip


def prefixed(unit: Unit) -> Callable[[str], str]:
    """What C and GLSL call a function or a struct."""
    return lambda name: f"{unit.name}_{name}"


def _real(unit: Unit) -> str:
    return "double" if unit.precision == "f64" else "float"


def c_program(unit: Unit, count: int, text: str, struct: Callable[[str], str], function: Callable[[str], str]) -> str:
    """A program in what C and C++ share, after a text; ``struct``, ``function``: what these are called there."""
    real = _real(unit)
    lines = [text, "#include <stdio.h>", "int main(int count, char **names)", "{"]
    lines += ["  (void)count;", '  FILE *in = fopen(names[1], "rb"), *out = fopen(names[2], "wb");']
    for entry in unit.entries:
        size = sum(slot.size or 1 for slot in entry.inputs)
        places = output_places(entry)
        lines += [f"  for (int i = 0; i < {count}; i++) {{", f"    {real} x[{size}], y[{len(places)}];"]
        lines += [f"    if (fread(x, sizeof(x[0]), {size}, in) != {size}) return 1;"]
        arguments = []
        for k, (slot, text) in enumerate(zip(entry.inputs, input_places(entry, "x"), strict=True)):
            kind = struct(slot.struct.name) if slot.struct else real
            length = f"[{slot.size}]" if slot.size and not slot.struct else ""
            lines.append(f"    {kind} a{k}{length} = {text};")
            arguments.append(f"a{k}")
        own = result_of(entry)
        kind = struct(f"{entry.name}_result")
        if own.slot:
            kind = struct(own.slot.struct.name) if own.slot.struct else real
        lines.append(f"    {kind} r = {function(entry.name)}({', '.join(arguments)});")
        lines += [f"    y[{k}] = ({real}){place};" for k, place in enumerate(places)]
        lines += [f"    fwrite(y, sizeof(y[0]), {len(places)}, out);", "  }"]
    return "\n".join([*lines, "  return fclose(out) != 0;", "}", ""])
