"""From a spec to the texts of one generated folder. Returns text; writing files is the command's work.

The order of everything follows the spec, so the same spec gives the same bytes on every machine. The forms that
were chosen are part of the manifest: given them, nothing is searched again.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from contextlib import nullcontext
from dataclasses import dataclass
from multiprocessing import get_context
from pathlib import Path
from typing import Any

from .algebra.algebra import Algebra
from .algebra.kind_checks import check_kind
from .algebra.loader import STOCK, algebra_from_data, data_from_algebra
from .build.flags import unit_file
from .build.formula_digest import file_digest, formula_digest
from .build.kernel_cache import INDEX
from .build.stamps import STAMPS, Stamps, generated_files, module_stamp, printers_stamp, read_stamps
from .compiler import optimise_kernel, print_source, print_unit, trace_kernel
from .declarations import Declaration, by_module, declared_kernels
from .errors import SpecError
from .interrupts import keep_partial
from .manifest import manifest_entry, operations_table
from .optimise.factor.record import Record
from .optimise.variants import Variant
from .progress import ProgressOption, open_progress
from .targets.c.extension import main_files
from .targets.c.printer import symbol
from .targets.c.table_product import general_files
from .trace.kernel import Kernel, symbol_of

MANIFEST_FORMAT = 2
#: Table of what kernels cost.
OPERATIONS = "OPERATIONS.md"
#: General programs: what `generate_programs` makes.
PROGRAMS = ("merge", "reform", "scene")


@dataclass(frozen=True)
class Group:
    """Generated texts of the kernels of one module: files, and entries and records by symbol."""

    files: dict[str, str]
    entries: dict[str, dict[str, Any]]
    records: dict[str, Record]


def generate(
    spec: Mapping[str, Any],
    choices: Mapping[str, Record] | None = None,
    progress: ProgressOption = False,
    kept: Mapping[str, str] | None = None,
    processes: int = 1,
) -> dict[str, str]:
    """Generate the files of one algebra.

    Parameters
    ----------
    spec : mapping
        Contents of a spec file (`load_spec`), or any mapping of that form.
    choices : mapping of symbol to record, optional
        Variants selected earlier (the contents of variants.json), good for kernels that are traced to the same nodes as
        then; others are searched.
    progress : bool or callable
        True: a bar on standard error. A callable gets a `Progress` of modules of formulas.
    kept : mapping of str to str, optional
        Files generated earlier: what was made of the same formulas is taken from there.
    processes : int
        How many processes share the modules.

    Returns
    -------
    dict of str to str
        Path to text: kernels.c, kernels.cdef, manifest.json, variants.json, sources.json, OPERATIONS.md, and for each
        module of formulas kernels/<module>.c and kernels/<module>.py.

    Raises
    ------
    SpecError, SignatureError, KindError, TraceError
        If the spec is not valid, a kind's member breaks its constraints, or a formula cannot be traced.
    Interrupted
        On an interrupt; its ``partial`` holds the files of the modules that are done.
    """
    algebra = algebra_from_data(spec)
    declared = declared_kernels(algebra, spec.get("kernels", []))
    modules = by_module(declared)
    stamps, earlier = Stamps(_module_stamps(spec, modules), printers_stamp()), read_stamps(kept or {})
    same = earlier.printers == stamps.printers
    groups = {
        m: _group_from_files(kept or {}, m, listed, algebra)
        for m, listed in modules.items()
        if same and earlier.modules.get(m) == stamps.modules[m]
    }
    waiting = [m for m in modules if m not in groups]
    if waiting:
        for kind in algebra.kinds.values():
            check_kind(kind)
    with (
        open_progress(progress, f"generate {algebra.name}", "modules", len(waiting)) as report,
        keep_partial(lambda: {name: text for group in groups.values() for name, text in group.files.items()}),
    ):
        for done, (module, group) in enumerate(_generate_groups(spec, waiting, choices or {}, processes), 1):
            groups[module] = group
            report(done, module)
    symbols = {m: [symbol_of(algebra, d.name) for d in listed] for m, listed in modules.items()}
    order = [symbol_of(algebra, d.name) for d in declared]
    entries = {k: v for group in groups.values() for k, v in group.entries.items()}
    records = {k: v for group in groups.values() for k, v in group.records.items()}
    files = {name: text for m in modules for name, text in groups[m].files.items()}
    files |= main_files(algebra.name, symbols)
    about = json.dumps({"format": MANIFEST_FORMAT, "algebra": data_from_algebra(algebra)}, indent=1)
    kernels = ",\n".join(_line(entries[k]) for k in order)
    files["manifest.json"] = about.removesuffix("\n}") + f',\n "kernels": [\n{kernels}\n]\n}}\n'
    files["variants.json"] = "{\n" + ",\n".join(f"{json.dumps(k)}: {_line(records[k])}" for k in order) + "\n}\n"
    files[OPERATIONS] = operations_table(algebra.name, [entries[k] for k in order])
    files[STAMPS] = stamps.text(files)
    return files


def _line(data: Mapping[str, Any]) -> str:
    return json.dumps(data, separators=(",", ":"))


def outdated_modules(root: Path, printers: bool = False) -> list[str]:
    """Modules, as ``folder/module``, whose generated files are older than their formulas.

    Only sources are read: nothing is traced. With ``printers``, the code that traces and prints counts, too.
    """
    from .algebra.schema import load_spec, stock_spec_path

    stale = []
    for name in STOCK:
        if printers and read_stamps(generated_files(root / name)).printers != printers_stamp():
            stale.append(f"{name} (all modules: code that traces or prints has changed)")
            continue
        spec = load_spec(stock_spec_path(name))
        modules = by_module(declared_kernels(algebra_from_data(spec), spec.get("kernels", [])))
        stale += _changed_modules(root / name, _module_stamps(spec, modules))
    for name in PROGRAMS:
        formulas = read_stamps(generated_files(root / name)).modules
        stale += _changed_modules(root / name, {formula: _digest_or_none(formula) for formula in formulas})
    return stale


def _changed_modules(folder: Path, stamps: Mapping[str, str]) -> list[str]:
    earlier = read_stamps(generated_files(folder)).modules
    if not earlier:
        return [f"{folder.name} (a file of it is not as it was generated)"]
    return [f"{folder.name}/{key}" for key in sorted({*stamps, *earlier}) if earlier.get(key) != stamps.get(key)]


def _digest_or_none(formula: str) -> str:
    """Of a formula, ``module.function``, or of a file with algorithms."""
    try:
        return file_digest(formula) if formula.endswith(".py") else formula_digest(formula)
    except (SpecError, OSError, SyntaxError):  # it has gone
        return ""


def _module_stamps(spec: Mapping[str, Any], modules: Mapping[str, Sequence[Declaration]]) -> dict[str, str]:
    """Stamps of modules as their sources are now."""
    algebra = {key: value for key, value in spec.items() if key != "kernels"}
    return {
        m: module_stamp(algebra, [(d.serves, d.name, *d.operands) for d in listed], [d.formula_name for d in listed])
        for m, listed in modules.items()
    }


def _generate_groups(
    spec: Mapping[str, Any],
    modules: Sequence[str],
    choices: Mapping[str, Record],
    processes: int,
) -> Iterator[tuple[str, Group]]:
    """Groups of modules, by as many processes, as they are finished."""
    if processes <= 1 or len(modules) < 2:
        for module in modules:
            yield module, generate_group(spec, module, choices)
        return
    with ProcessPoolExecutor(min(processes, len(modules)), mp_context=get_context("spawn")) as pool:
        waiting = {pool.submit(generate_group, spec, module, choices): module for module in modules}
        for done in as_completed(waiting):
            yield waiting[done], done.result()


def generate_group(spec: Mapping[str, Any], module: str, choices: Mapping[str, Record]) -> Group:
    """Trace, optimise and print the kernels of one module."""
    algebra = algebra_from_data(spec)
    variants: list[Variant] = []
    callees: dict[Kernel, Variant] = {}
    entries: dict[str, dict[str, Any]] = {}
    records: dict[str, Record] = {}
    for each in by_module(declared_kernels(algebra, spec.get("kernels", [])))[module]:
        kernel = trace_kernel(each.formula, each.kinds, each.name, algebra=algebra)
        record = choices.get(symbol(kernel))
        if record and record.get("traced") != kernel.fingerprint:
            record = None
        variant = optimise_kernel(kernel, record, selected=callees)
        variants.append(variant)
        entries[symbol(kernel)] = manifest_entry(each, variant)
        records[symbol(kernel)] = {"traced": kernel.fingerprint, **variant.record()}
    return Group(_module_files(f"{algebra.name}, {module}", module, variants), entries, records)


def _group_from_files(
    files: Mapping[str, str], module: str, declarations: Sequence[Declaration], algebra: Algebra
) -> Group:
    """Group of a module from files that are up to date."""
    entries = {entry["symbol"]: entry for entry in json.loads(files["manifest.json"])["kernels"]}
    records = json.loads(files["variants.json"])
    symbols = [symbol_of(algebra, d.name) for d in declarations]
    own = {path: files[path] for path in (unit_file(module), _python_file(module))}
    return Group(own, {k: entries[k] for k in symbols}, {k: records[k] for k in symbols})


def _module_files(title: str, module: str, variants: Sequence[Variant]) -> dict[str, str]:
    python = print_source(variants, "numba", title)
    return {unit_file(module): print_unit(title, module, variants), _python_file(module): python}


def _python_file(module: str) -> str:
    return f"kernels/{module}.py"


def generate_programs(anew: bool = True) -> dict[str, dict[str, str]]:
    """Generated files of the general programs that the wheel carries for machines without a compiler, by folder.

    Kernels are made ``anew``, or taken from what the package carries while their sources are the same.
    """
    from .programs.kernel_spec import without_kernel_cache
    from .programs.merging.program import merge_program
    from .programs.registration.program import reform_program
    from .programs.tracer.scene import EVERYTHING, scene_program

    with without_kernel_cache() if anew else nullcontext():
        programs = {
            "merge": merge_program.__wrapped__(),
            "reform": reform_program.__wrapped__(),
            "scene": scene_program(EVERYTHING),
        }
        made = {name: {**program.files, INDEX: program.index()} for name, program in programs.items()}
    for name, program in programs.items():
        digests = {formula: formula_digest(formula) for formula in sorted(program.formulas())}
        digests |= {file: file_digest(file) for file in program.algorithms}
        made[name][STAMPS] = Stamps(digests).text(made[name])
    return {**made, "general": general_files()}
