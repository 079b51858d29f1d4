"""Programs of Rust around exported modules."""

from __future__ import annotations

import subprocess
from collections.abc import Sequence
from pathlib import Path

from bladesmith.codegen.export.names import camel_case
from bladesmith.codegen.export.unit import Entry, Slot, Unit
from bladesmith.codegen.ir.loops.nodes import Function
from bladesmith.codegen.ir.loops.types import ArrayType

from .drivers import output_places

RUSTC = ("rustc", "--edition", "2021", "-D", "warnings")
_FRAME = """\
mod {file};
fn main() {{
    let names: Vec<String> = std::env::args().collect();
    let size = std::mem::size_of::<{real}>();
    let numbers: Vec<{real}> = std::fs::read(&names[1]).unwrap().chunks_exact(size)
        .map(|c| {real}::from_ne_bytes(c.try_into().unwrap())).collect();
    let (mut rest, mut out) = (&numbers[..], Vec::<u8>::new());
{body}
    assert!(rest.is_empty());
    std::fs::write(&names[2], out).unwrap();
}}
"""


def compile_rust(folder: Path, *flags: str) -> list[str]:
    """Compile main.rs; the command that runs it."""
    subprocess.run([*RUSTC, "-C", "opt-level=1", *flags, "main.rs", "-o", "main"], cwd=folder, check=True)
    return ["./main"]


def kernels_program(unit: Unit, count: int) -> str:
    """All kernels, each on so many rows."""
    body = []
    for entry in unit.entries:
        size = sum(slot.size or 1 for slot in entry.inputs)
        call = f"{unit.name}::{entry.name}({', '.join(_arguments(unit, entry))})"
        body += _loop(count, size, [f"let r = {call};"], output_places(entry), unit.precision)
    return _FRAME.format(file=unit.name, real=unit.precision, body="\n".join(body))


def algorithm_program(file: str, name: str, function: Function, sizes: Sequence[int], count: int) -> str:
    """One algorithm on so many items: numbers of its parameters as float64, then what it changes and returns."""
    lines, arguments, results, start = [], [], [], 0
    for k, (p, size) in enumerate(zip(function.parameters, sizes, strict=True)):
        if isinstance(p.type, ArrayType):
            mut = "" if p.access == "in" else "mut "
            kind = {"Int32": "i32", "Int8": "u8", "Real": "f64", "Int": "i64"}[p.type.storage]
            lines.append(f"let {mut}a{k} = std::array::from_fn::<{kind}, {size}, _>(|i| x[{start} + i] as {kind});")
            arguments.append(f"&{mut}a{k}")
            results += [f"a{k}[{i}]" for i in range(size if mut else 0)]
        else:
            number = f"x[{start}]"
            arguments.append({"Real": number, "Int": f"{number} as i64", "Bool": f"{number} != 0.0"}[str(p.type)])
        start += size
    for k, type in enumerate(function.results):
        result = f"r.{k}" if len(function.results) > 1 else "r"
        results.append(f"{result} as i64" if str(type) == "Bool" else result)
    lines.append(f"let r = {file}::{name}({', '.join(arguments)});")
    return _FRAME.format(file=file, real="f64", body="\n".join(_loop(count, start, lines, results, "f64")))


def _loop(count: int, size: int, lines: Sequence[str], results: Sequence[str], real: str) -> list[str]:
    taken = [f"let (x, behind) = rest.split_at({size});", "rest = behind;"]
    written = [f"out.extend(({r} as {real}).to_ne_bytes());" for r in results]
    return [f"for _ in 0..{count} {{", *taken, *lines, *written, "}"]


def _arguments(unit: Unit, entry: Entry) -> list[str]:
    found, start = [], 0
    for slot in entry.inputs:
        found.append(_argument(unit, slot, start))
        start += slot.size or 1
    return found


def _argument(unit: Unit, slot: Slot, start: int) -> str:
    numbers = [f"x[{k}]" for k in range(start, start + (slot.size or 1))]
    if slot.struct:
        fields = ", ".join(f"{f}: {n}" for f, n in zip(slot.struct.fields, numbers, strict=True))
        return f"{unit.name}::{camel_case(slot.struct.name)} {{ {fields} }}"
    return f"&[{', '.join(numbers)}]" if slot.size else numbers[0]
