"""`bladesmith check`: the kernels of a spec against 50 digits, on every target of this machine."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from . import options

if TYPE_CHECKING:
    from ..codegen.checks.kernels import KernelCheck

TARGETS = ("c", "numba", "numpy", "cuda")


@options.command("check pga2d.toml --kernel products.geometric --target c", "algebra/specs")
@options.input_file("spec")
@click.option("--kernel", "names", multiple=True, help="Only this kernel, or formula (repeatable). Default: all.")
@click.option(
    "--target", "requested", multiple=True, type=click.Choice(TARGETS),
    help="Only this target (repeatable). Default: all that run here.",
)  # fmt: skip
@options.option_with_default("--items", 12, "Items of each case of operands.", options.COUNT)
@options.option_with_default("--seed", 0, "Of the operands.", click.IntRange(min=0))
@options.feedback
def command(
    spec: Path, names: tuple[str, ...], requested: tuple[str, ...], items: int, seed: int, feedback: options.Feedback
) -> int:
    """Test the kernels of a spec file against 50 digits.

    Each runs on random members of its kinds, on huge, tiny and equal ones and on versors near 1 and -1, in float64 and
    float32, and is compared with its formula in exact or 50-digit numbers. Columns: operations; error bound (the median
    for ordinary operands) and largest errors found, in units of roundoff of the result's largest coefficient; the
    largest error in units of what rounding may do to the formula at these operands, to first order, of which 8 are
    allowed. The exit status is 1 if a kernel is off by more; then its operands are printed.
    """
    from ..codegen.algebra.schema import load_spec
    from ..codegen.checks.kernels import available_targets, check_kernel, selected_kernels
    from ..codegen.progress import open_progress
    from ..errors import InputError

    declared = selected_kernels(load_spec(spec), names)
    reasons = available_targets()
    targets = [t for t in TARGETS if (t in requested if requested else not reasons[t])]
    for target in targets:
        if reasons[target]:
            raise InputError(f"--target {target} does not run here: {reasons[target]}")
    width = max(len("kernel"), *(len(d.name) for d in declared))
    columns = ("operations", "bound", "float64", "float32", "of allowed 8", "targets")
    click.echo(_line(width, "kernel", *columns))
    faults = []
    with open_progress(feedback.shows_bars, "check", "kernels", len(declared)) as report:
        for done, each in enumerate(declared, 1):
            found = check_kernel(each, targets, items, seed)
            click.echo(_row(width, found))
            faults += [found.fault] if found.fault else []
            report(done, each.name)
    missing = [f"{target}: {reason}" for target, reason in reasons.items() if reason and not requested]
    if missing:
        feedback.say(f"not run here: {'; '.join(missing)}")
    for fault in faults:
        click.echo(fault)
    click.echo(f"{len(declared) - len(faults)} of {len(declared)} kernels are as exact as their formulas")
    return 1 if faults else 0


def _row(width: int, found: KernelCheck) -> str:
    cells = [str(found.operations), *(f"{x:.2g}" for x in (found.bound, *found.errors.values(), found.fraction))]
    return _line(width, found.name, *cells, f"{' '.join(found.targets)}{'  FAILED' if found.fault else ''}")


def _line(width: int, name: str, *cells: str) -> str:
    *numbers, last = cells
    return f"{name:<{width}}  {'  '.join(f'{cell:>12}' for cell in numbers)}  {last}"
