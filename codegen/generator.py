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
from .build import text_cache
from .build.calls import CALLS
from .build.flags import unit_file
from .build.formula_digest import file_digest, formula_digest
from .build.kernel_cache import INDEX
from .build.source_digest import ROOT
from .build.stamps import STAMPS, Stamps, generated_files, module_stamp, printers_stamp, read_stamps
from .compiler import optimise_kernel, print_source, print_unit, trace_kernel
from .declarations import Declaration, by_module, declared_kernels
from .errors import SpecError
from .interrupts import keep_partial
from .manifest import manifest_entry, operations_table
from .optimise.factor.record import Record
from .optimise.variants import Variant
from .progress import ProgressOption, open_progress
from .targets.c.extension import calls_files, main_files
from .targets.c.printer import symbol
from .targets.c.table_product import general_files
from .trace.kernel import Kernel, symbol_of

MANIFEST_FORMAT = 2
#: Table of what kernels cost.
OPERATIONS = "OPERATIONS.md"
#: General programs: what `generate_programs` makes, and the files that they begin in.
PROGRAMS = {
    "merge": "programs/merging/program.py",
    "reform": "programs/registration/program.py",
    "scene": "programs/tracer/scene.py",
}
#: Into how many shares a process's part of a search is cut: kernels take very different times.
SHARES = 4
#: Beside the generated folders: headers that all generated sources share, one of which is printed, too.
HEADERS = "../templates/c/lib"


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
        known = choices or {}
        if same and len(waiting) <= processes:  # a few formulas were edited
            known = {**known, **_missing_records(spec, waiting, known, processes)}
        for done, (module, group) in enumerate(_generate_groups(spec, waiting, known, processes), 1):
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


def _missing_records(
    spec: Mapping[str, Any], modules: Sequence[str], choices: Mapping[str, Record], processes: int
) -> dict[str, Record]:
    """Records of the kernels that must be searched, a module's kernels shared by the processes."""
    if processes <= 1 or not modules:
        return {}
    found: dict[str, Record] = {}
    with ProcessPoolExecutor(processes, mp_context=get_context("spawn")) as pool:
        shares = [
            (spec, module, choices, i, SHARES * processes) for module in modules for i in range(SHARES * processes)
        ]
        for records in pool.map(_search_share, *zip(*shares, strict=True)):
            found |= records
    return found


def _search_share(
    spec: Mapping[str, Any], module: str, choices: Mapping[str, Record], share: int, shares: int
) -> dict[str, Record]:
    """Of a share of the kernels of a module, records of those that have none that is of the formula as it is now."""
    algebra = algebra_from_data(spec)
    declared = by_module(declared_kernels(algebra, spec.get("kernels", [])))[module]
    records = {}
    for each in declared[share::shares]:
        kernel = trace_kernel(each.formula, each.kinds, each.name, algebra=algebra)
        if _record_of(kernel, choices) is None:
            records[symbol(kernel)] = _new_record(kernel, optimise_kernel(kernel))
    return records


def _record_of(kernel: Kernel, choices: Mapping[str, Record]) -> Record | None:
    """The record of a kernel, if it is of the same nodes."""
    record = choices.get(symbol(kernel))
    return record if record and record.get("traced") == kernel.fingerprint else None


def _new_record(kernel: Kernel, variant: Variant) -> Record:
    return {"traced": kernel.fingerprint, **variant.record()}


def generate_group(spec: Mapping[str, Any], module: str, choices: Mapping[str, Record]) -> Group:
    """Trace, optimise and print the kernels of one module."""
    algebra = algebra_from_data(spec)
    variants: list[Variant] = []
    entries: dict[str, dict[str, Any]] = {}
    records: dict[str, Record] = {}
    declared = by_module(declared_kernels(algebra, spec.get("kernels", [])))[module]
    for each, variant in selected_variants(algebra, declared, choices):
        variants.append(variant)
        entries[symbol(variant.kernel)] = manifest_entry(each, variant)
        records[symbol(variant.kernel)] = _new_record(variant.kernel, variant)
    return Group(_module_files(f"{algebra.name}, {module}", module, variants), entries, records)


def selected_variants(
    algebra: Algebra, declared: Sequence[Declaration], choices: Mapping[str, Record], quick: bool = False
) -> Iterator[tuple[Declaration, Variant]]:
    """Declared kernels with the variants that are printed: those of ``choices``, else searched, perhaps quickly."""
    callees: dict[Kernel, Variant] = {}
    for each in declared:
        kernel = trace_kernel(each.formula, each.kinds, each.name, algebra=algebra)
        yield each, optimise_kernel(kernel, _record_of(kernel, choices), quick, callees)


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


def generate_headers() -> dict[str, str]:
    """Printed headers, by name, for the folder `HEADERS`."""
    from .targets.c.elementary import elementary_header

    return {"elementary.h": elementary_header()}


def generate_programs(anew: bool = True, processes: int = 1) -> dict[str, dict[str, str]]:
    """Generated files of the general programs that the wheel carries for machines without a compiler, by folder.

    Parameters
    ----------
    anew : bool
        Trace and print everything. Else programs whose sources are in the state of an earlier call are read from the
        cache, and so are kernels of the others.
    processes : int
        How many processes share the programs.
    """
    made = {"general": general_files(), CALLS: calls_files()}
    if processes <= 1:
        return made | {name: _program_files(name, anew) for name in PROGRAMS}
    with ProcessPoolExecutor(min(processes, len(PROGRAMS)), mp_context=get_context("spawn")) as pool:
        return made | dict(zip(PROGRAMS, pool.map(_program_files, PROGRAMS, [anew] * len(PROGRAMS)), strict=True))


def _program_files(name: str, anew: bool) -> dict[str, str]:
    if anew:
        files, formulas, algorithms = _make_program(name, anew)
    else:
        folder = ROOT.parent / "templates"
        templates = sorted(f"../templates/{p.relative_to(folder).as_posix()}" for p in folder.glob("c/**/*.*"))
        sources = (PROGRAMS[name], "generator.py", *(f"specs/{spec}.toml" for spec in STOCK), *templates)
        text = text_cache.made_once(
            f"program_{name}", sources, "files.json", lambda: json.dumps(_make_program(name, anew))
        )
        files, formulas, algorithms = json.loads(text)
    digests = {formula: formula_digest(formula) for formula in formulas}
    digests |= {file: file_digest(file) for file in algorithms}
    return {**files, STAMPS: Stamps(digests).text(files)}


def _make_program(name: str, anew: bool) -> tuple[dict[str, str], list[str], list[str]]:
    """Files of a program, the formulas that it calls, and files of its algorithms."""
    from .programs.kernel_spec import without_kernel_cache
    from .programs.merging.program import merge_program
    from .programs.registration.program import reform_program
    from .programs.tracer.scene import EVERYTHING, scene_program
    from .programs.tracer.surface_kinds import surface_kind
    from .programs.tracer.surfaces import texts

    with without_kernel_cache() if anew else nullcontext():
        if name == "scene":
            program = scene_program(EVERYTHING)
        else:
            program = (merge_program if name == "merge" else reform_program).__wrapped__()
        files = {**program.files, INDEX: program.index()}
        if name == "scene":
            files[texts.INDEX] = texts.index(map(surface_kind, EVERYTHING.kinds))
    return files, sorted(program.formulas()), list(program.algorithms)
