"""Programs of JavaScript around exported modules."""

from __future__ import annotations

from collections.abc import Sequence

from bladesmith.codegen.export.names import lower_camel_case
from bladesmith.codegen.export.places import result_of
from bladesmith.codegen.export.unit import Entry, Slot, Unit
from bladesmith.codegen.ir.loops.nodes import Function
from bladesmith.codegen.ir.loops.types import ArrayType

NODE = ["node", "main.mjs"]
_FRAME = """\
import {{ readFileSync, writeFileSync }} from "node:fs";
import * as exported from "./{file}.mjs";
const bytes = readFileSync(process.argv[2]);
const numbers = new Float64Array(bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length));
const out = [];
let start = 0;
{body}
if (start !== numbers.length) throw new Error("numbers are left");
writeFileSync(process.argv[3], new Uint8Array(Float64Array.from(out).buffer));
"""


def kernels_program(unit: Unit, count: int) -> str:
    """All kernels, each on so many rows."""
    body = []
    for entry in unit.entries:
        arguments, start = [], 0
        for slot in entry.inputs:
            arguments.append(_argument(slot, start))
            start += slot.size or 1
        call = f"exported.{lower_camel_case(entry.name)}({', '.join(arguments)})"
        body += _loop(count, start, [f"const r = {call};"], _results(entry))
    return _FRAME.format(file=unit.name, body="\n".join(body))


def algorithm_program(file: str, name: str, function: Function, sizes: Sequence[int], count: int) -> str:
    """One algorithm on so many items: numbers of its parameters, then what it changes and returns."""
    lines, arguments, results, start = [], [], [], 0
    for k, (p, size) in enumerate(zip(function.parameters, sizes, strict=True)):
        if isinstance(p.type, ArrayType):
            kind = {"Int32": "Int32Array", "Int8": "Uint8Array"}.get(p.type.storage, "Float64Array")
            lines.append(f"const a{k} = {kind}.from(x.subarray({start}, {start + size}));")
            arguments.append(f"a{k}")
            results += [f"a{k}[{i}]" for i in range(size if p.access != "in" else 0)]
        else:
            arguments.append(f"x[{start}]" + (" !== 0" if str(p.type) == "Bool" else ""))
        start += size
    several = len(function.results) > 1
    results += [f"Number(r[{k}])" if several else "Number(r)" for k in range(len(function.results))]
    lines.append(f"const r = exported.{lower_camel_case(name)}({', '.join(arguments)});")
    return _FRAME.format(file=file, body="\n".join(_loop(count, start, lines, results)))


def _loop(count: int, size: int, lines: Sequence[str], results: Sequence[str]) -> list[str]:
    taken = f"const x = numbers.subarray(start, start += {size});"
    return [f"for (let item = 0; item < {count}; item++) {{", taken, *lines, f"out.push({', '.join(results)});", "}"]


def _results(entry: Entry) -> list[str]:
    own = result_of(entry)
    slots = [("r", own.slot)] if own.slot else [(f"r.{lower_camel_case(s.name)}", s) for s in own.fields]
    return [place for name, slot in slots for place in _places(name, slot)]


def _places(name: str, slot: Slot) -> list[str]:
    if slot.struct:
        return [f"{name}.{field}" for field in slot.struct.fields]
    return [f"{name}[{k}]" for k in range(slot.size)] if slot.size else [name]


def _argument(slot: Slot, start: int) -> str:
    numbers = [f"x[{k}]" for k in range(start, start + (slot.size or 1))]
    if slot.struct:
        return "{ " + ", ".join(f"{f}: {n}" for f, n in zip(slot.struct.fields, numbers, strict=True)) + " }"
    return f"[{', '.join(numbers)}]" if slot.size else numbers[0]
