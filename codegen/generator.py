"""From a spec to the texts of one generated folder. Returns text; writing files is the command's work.

The order of everything follows the spec, so the same spec gives the same bytes on every machine. The forms that
were chosen are part of the manifest: given them, nothing is searched again.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from importlib import import_module
from typing import Any

from .algebra import Algebra, validated_identifier
from .catalogue import algebra_from_data, data_from_algebra
from .errors import SpecError, suggest
from .factor_record import Record
from .kinds import Kind, numbers, scalar_argument
from .programs.kept import INDEX
from .simplify import choose, chosen_form, record_of
from .targets.c import symbol
from .targets.extension import kernel_files
from .trace import Formula, Input, Kernel, Output, argument_names, trace
from .verify import verify

MANIFEST_FORMAT = 1
#: Called with (done, total, name) as kernels are traced; for progress bars.
Progress = Callable[[int, int, str], None]


def generate(
    spec: Mapping[str, Any], choices: Mapping[str, Record] | None = None, progress: Progress | None = None
) -> dict[str, str]:
    """Generated files of one algebra.

    Parameters
    ----------
    spec : mapping
        Contents of a spec file (`load_spec`), or any mapping of that form.
    choices : mapping of symbol to record, optional
        Forms chosen earlier (the contents of forms.json); others are searched.
    progress : callable, optional
        ``progress(done, total, name)``.

    Returns
    -------
    dict of str to str
        File name to text: kernels.c, kernels.h, batch.h, kernels.cdef, kernels_numba.py,
        manifest.json, forms.json.

    Raises
    ------
    SpecError, SignatureError, KindError, TraceError
        If the spec is not valid, a kind's member breaks its constraints, or a formula cannot be traced.
    """
    algebra = algebra_from_data(spec)
    for kind in algebra.kinds.values():
        verify(kind)
    declared = declared_kernels(algebra, spec.get("kernels", []))
    kernels = []
    for i, (formula_name, name, formula, kinds) in enumerate(declared):
        if progress:
            progress(i, len(declared), name)
        kernel = trace(formula, kinds, name, algebra=algebra)
        choose(kernel, (choices or {}).get(symbol(kernel)))
        kernels.append((formula_name, kernel))
    files = kernel_files(f"{algebra.name}", [k for _, k in kernels])
    files["kernels_numba.py"] = _numba([k for _, k in kernels])
    files["manifest.json"] = json.dumps(_manifest(algebra, kernels), indent=1) + "\n"
    records = [f"{json.dumps(symbol(k))}: {json.dumps(record_of(k), separators=(',', ':'))}" for _, k in kernels]
    files["forms.json"] = "{\n" + ",\n".join(records) + "\n}\n"
    return files


def generate_programs() -> dict[str, dict[str, str]]:
    """Generated files of the general programs that the wheel carries for machines without a compiler, by folder."""
    from .programs.kernels import printed_anew
    from .programs.merge import merge_program
    from .programs.reform import KINDS, reform_program
    from .programs.scene import EVERYTHING, scene_program

    with printed_anew():
        programs = {
            "merge": merge_program.__wrapped__(),
            "reform": reform_program.__wrapped__(KINDS),
            "scene": scene_program(EVERYTHING),
        }
        return {name: {**made.files, INDEX: made.index()} for name, made in programs.items()}


def declared_kernels(
    algebra: Algebra, entries: Sequence[Mapping[str, Any]]
) -> list[tuple[str, str, Formula, list[Kind]]]:
    """Operation served, kernel name, formula and kinds of each kernel that a spec asks for.

    Raises
    ------
    SpecError
        If a formula is unknown, a name is not an identifier, or two kernels share a name.
    """
    found: dict[str, tuple[str, str, Formula, list[Kind]]] = {}
    for entry in entries:
        formula = formula_by_name(entry["formula"])
        for operands in entry["operands"]:
            kinds = [operand_kind(algebra, text) for text in operands]
            wanted = argument_names(formula)
            if len(kinds) != len(wanted):
                raise SpecError(
                    f"{entry['formula']} takes {len(wanted)} operands ({', '.join(wanted)}), not {len(kinds)}."
                )
            base = entry.get("name") or entry["formula"].rpartition(".")[2]
            parts = [base, *(text.replace("layout ", "any_").replace(" ", "") for text in operands)]
            name = validated_identifier("_".join(parts), "a kernel's name")
            if name in found:
                raise SpecError(f"the spec of {algebra.name} asks twice for the kernel {name!r}.")
            found[name] = (entry.get("serves") or entry["formula"], name, formula, kinds)
    return list(found.values())


def operand_kind(algebra: Algebra, text: str) -> Kind:
    """Kind of an operand as specs write it: ``motor``, ``layout circle``, ``number``, ``numbers 9``."""
    words = str(text).split()
    match words:
        case ["number"]:
            return scalar_argument(algebra)
        case ["numbers", count] if count.isdigit():
            return numbers(algebra, int(count))
        case ["layout", name]:
            return algebra.layout(name)
        case [name]:
            return algebra.kind(name)
    raise SpecError(f"operand {text!r} is not `kind`, `layout kind`, `number` or `numbers n`.")


def formula_by_name(name: str) -> Formula:
    """A function of `codegen.formulas`, named ``module.function``.

    Raises
    ------
    SpecError
        If there is none of that name.
    """
    module_name, _, function = str(name).partition(".")
    validated_identifier(module_name, "a formula's module")
    validated_identifier(function, "a formula's function")
    try:
        module = import_module(f".formulas.{module_name}", __package__)
    except ImportError:
        raise SpecError(f"there is no module of formulas {module_name!r} (in {name!r}).") from None
    formula = getattr(module, function, None)
    if not callable(formula) or getattr(formula, "__module__", None) != module.__name__:
        public = [n for n in vars(module) if not n.startswith("_")]
        raise SpecError(f"{module_name} has no formula {function!r}{suggest(function, public)}.")
    return formula  # type: ignore[no-any-return]


def plain_spec(p: int, q: int, r: int, name: str) -> dict[str, Any]:
    """Spec of Cl(p, q, r) on orthonormal vectors, with dense products (to 6 dimensions) and vector products."""
    from .algebra import orthonormal

    data = data_from_algebra(orthonormal(p, q, r, name))
    data["kernels"] = plain_kernels(p + q + r)
    return data


#: Dense products beyond this dimension are left to the general kernel: 4^n terms each.
DENSE_DIMENSION = 5


def plain_kernels(dimension: int) -> list[dict[str, Any]]:
    """Kernels of a plain algebra."""
    kinds = ["multivector", "even"] if dimension <= DENSE_DIMENSION else []
    products = ("geometric", "outer", "inner")
    entries: list[dict[str, Any]] = [
        {"formula": f"products.{p}", "operands": [[k, k] for k in [*kinds, "vector"]]} for p in products
    ]
    if kinds:
        entries.append({"formula": "products.sandwich", "operands": [["even", "vector"]]})
    return entries


def _kind_entry(kind: Kind, algebra: Algebra) -> dict[str, Any]:
    if kind.form == "number":
        return {"form": "number"}
    if kind.form == "numbers":
        return {"form": "numbers", "size": kind.size}
    named = algebra.kinds.get(kind.name)
    if named is not None and named.blades == kind.blades:
        return {"kind": kind.name, "layout": kind.is_layout and not named.is_layout}
    return {"blades": [algebra.blade_name(b) for b in kind.blades]}


def _argument_entry(item: Input, algebra: Algebra) -> dict[str, Any]:
    return {"name": item.name, **_kind_entry(item.kind, algebra)}


def _result_entry(item: Output, algebra: Algebra) -> dict[str, Any]:
    if item.role == "status":
        return {"name": item.name, "role": "status"}
    return {"name": item.name, **_kind_entry(item.kind, algebra)}


def _manifest(algebra: Algebra, kernels: Sequence[tuple[str, Kernel]]) -> dict[str, Any]:
    entries = []
    for formula, kernel in kernels:
        form = chosen_form(kernel)
        counts = form.operations
        entries.append(
            {
                "symbol": symbol(kernel),
                "formula": formula,
                "inputs": [_argument_entry(i, algebra) for i in kernel.inputs],
                "outputs": [_result_entry(o, algebra) for o in kernel.outputs],
                "form": form.name,
                "operations": [counts.multiplications, counts.additions, counts.others],
            }
        )
    return {"format": MANIFEST_FORMAT, "algebra": data_from_algebra(algebra), "kernels": entries}


def _numba(kernels: Sequence[Kernel]) -> str:
    from .targets.numba import numba_source

    return numba_source(list(kernels))
