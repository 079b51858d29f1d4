"""Where algorithms on W items at once are called: a loop over items, and a function of numbers."""

from __future__ import annotations

from collections.abc import Collection

from ....errors import AlgorithmError
from ....ir.loops.nodes import Function
from ....ir.loops.types import BOOL, REAL, ArrayType, Scalar
from ...blocks import wrap_arguments
from ...loops import counted
from ..loops import CLoopPrinter
from ..names import TYPES, c_function_name, c_name, stored_type
from .varying import Lanes

#: Tag of the instance of wide vectors, where another calls it.
LANES_TAG = "f64_v3"


def lanes_item(lanes: Lanes, scratch: Collection[str] = ()) -> tuple[list[str], list[str]]:
    """Arrays of a loop over items, and statements that compute those from item i on; see algorithm.c.j2.

    Arrays of ``scratch`` are memory for vectors, of as many numbers for each lane, and for one vector more: nothing is
    brought there, and nothing fetched.
    """
    root = lanes.root
    arrays, load, arguments, store = [], [], [], []
    for k, p in enumerate(root.parameters):
        assert isinstance(p.type, (ArrayType, Scalar))
        given, is_array = f"({stored_type(p.type)} *)arrays[{k}]", isinstance(p.type, ArrayType)
        size = str(p.type.size) if isinstance(p.type, ArrayType) else "1"
        size += f" * counts[{k}]" if isinstance(p.type, ArrayType) and p.type.is_open else ""
        if p.name in scratch:
            vector, own = _vector_of(p.type)[0], f"{p.name}_lanes_"
            aligned = f"((uintptr_t)arrays[{k}] + sizeof(V) - 1) & ~(uintptr_t)(sizeof(V) - 1)"
            arrays.append(f"{vector} *const {own} = ({vector} *)({aligned});")
            arguments.append(own)
        elif p.name in lanes.names[root]:
            own, row = f"{p.name}_lanes_", f"{given} + i * strides[{k}], strides[{k}], {size}, lanes"
            vector, bits = _vector_of(p.type)
            room = f"{size} > 0 ? {size} : 1" if "counts" in size else size  # C has no arrays without numbers
            arrays.append(f"{vector} {own}[{room}];")
            load += [f"FN(bs_gather{bits})({own}, {row});"] if p.access != "out" else []
            store += [f"FN(bs_scatter{bits})({own}, {row});"] if p.access != "in" else []
            truth = f"NE({own}[0], FN(bs_spread)(0))" if p.type == BOOL else f"{own}[0]"
            arguments.append(own if is_array else truth)
        else:
            arguments.append(given if is_array else f"*({given})")
        if p.name in counted(root):
            arguments.append(f"counts[{k}]")
    declared = []
    for k, result in enumerate(root.results):
        row = f"arrays[{len(root.parameters) + k}] + i * strides[{len(root.parameters) + k}]"
        end = f"strides[{len(root.parameters) + k}], 1, lanes"
        vector, bits = _vector_of(result)
        own, differs = f"result{k}_", lanes.results[root][k]
        declared.append(f"{('M' if result == BOOL else vector) if differs else TYPES[result]} {own};")
        if result != REAL:
            value = f"FN(bs_choose)({own}, FN(bs_spread)(1), FN(bs_spread)(0))" if result == BOOL else own
            store.append(f"const I integers{k}_ = {value if differs else f'FN(bs_spread)({own})'};")
            own = f"integers{k}_"
        store.append(f"FN(bs_scatter{bits})(&{own}, ({stored_type(result)} *){row}, {end});")
    count = len(root.results)
    arguments += [f"&result{k}_" for k in range(count) if count > 1]
    call = f"{'result0_ = ' if count == 1 else ''}FN({c_function_name(root.name)})({', '.join(arguments)});"
    return arrays, [*load, *declared, call, *store]


def _vector_of(type: ArrayType | Scalar) -> tuple[str, str]:
    """What the numbers of an argument are in vectors, and the end of the names of functions that bring them there."""
    if isinstance(type, ArrayType):
        return ("V", "") if type.scalar == REAL else ("I", str(type.bits))
    return ("V", "") if type == REAL else ("I", "64")


def c_call_of_lanes(function: Function, lanes: Lanes, tag: str, direct: Collection[str]) -> str:
    """C text that an instance of single numbers has of a `CFunction`: a call of the root as vectors have it.

    Parameters
    ----------
    function : Function
        With the root's parameters; arrays that differ have the numbers of all lanes, those of one index side by side.
    lanes : Lanes
    tag : str
        Of the instance of vectors.
    direct : collection of str
        Arrays that begin where a vector may: others are copied.
    """
    root, vector = lanes.root, f"vector_{tag}"
    if any(lanes.results[root]):
        raise AlgorithmError(f"what {root.name} returns differs between items", remedy="Put it into an array.")
    before, after, arguments = [], [], []
    for p in root.parameters:
        name, own = c_name(p.name), f"{p.name}_lanes_"
        assert isinstance(p.type, (ArrayType, Scalar))
        if p.name not in lanes.names[root]:
            arguments.append(name)
        elif p.name in direct:
            arguments.append(f"({'const ' if p.access == 'in' else ''}{vector} *){name}")
        else:
            before.append(f"{vector} {own}[{p.type.size if isinstance(p.type, ArrayType) else 1}];")
            before += [f"memcpy({own}, {name}, sizeof {own});"] if p.access != "out" else []
            after += [f"memcpy({name}, {own}, sizeof {own});"] if p.access != "in" else []
            arguments.append(own)
    call = wrap_arguments(f"const ptrdiff_t result_ = {c_function_name(root.name)}_{tag}(", arguments, ");")
    body = [*before, *call, *after, "return result_;"]
    return "\n".join([*CLoopPrinter(function).head("BS_INLINE"), "{", *(f"  {line}" for line in body), "}", ""])
