"""`bladesmith generate`: write an algebra's sources and manifest, or check that they are up to date."""

from __future__ import annotations

import difflib
import json
import os
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any, NoReturn

import click

from ..errors import InputError, SignatureError, SpecError
from . import options

#: Lines of difference that --check prints for each file.
DIFF_LINES = 20


@options.command("generate --signature 2,0,1 --name pga2d --out generated/", "algebra/specs")
@options.file("--spec", help="Spec file of the algebra.")
@click.option("--signature", help="p,q,r of a plain algebra, instead of a spec.")
@click.option("--name", help="Name of the plain algebra. Default: clp_q_r.")
@click.option("--out", type=options.FOLDER, help="Folder that holds one folder per algebra.")
@options.flag("--check", "Write nothing; exit 1 and say what is not up to date.")
@options.flag("--update", "Make only what has changed since: seconds after a formula was edited.")
@options.flag("--search", "Search the cheapest form of every kernel again (minutes).")
@options.feedback
def command(
    spec: Path | None, signature: str | None, name: str | None, out: Path | None, check: bool, update: bool,
    search: bool, feedback: options.Feedback,
) -> None:  # fmt: skip
    """Generate an algebra: C, numba and CUDA-ready sources, and a manifest.

    Without --spec and --signature, all stock algebras and programs. Without --out, into ./generated, or for --check
    the installed package's own folder. The variants selected earlier are read from variants.json there, and are good
    for formulas that have not changed; others are searched. --update and --check make only what is older than its
    formulas (see sources.json); without them everything is made anew.
    """
    from ..codegen.build.stamps import generated_files
    from ..codegen.generator import HEADERS, generate, generate_headers, generate_programs, outdated_modules

    if search and (check or update):
        raise InputError("--search makes everything anew; give it without --check and --update.")
    folder = out or (_installed_folder() if check else Path("generated"))
    if check and not folder.is_dir():
        raise InputError(f"{folder} is not a folder; --check compares what is generated there.")
    stock, specs = spec is None and signature is None, _specs(spec, signature, name)
    if check and stock and (stale := outdated_modules(folder, printers=True)):  # digests tell: nothing is traced
        _report_outdated(stale)
    processes = os.cpu_count() or 1
    made = {}
    with ThreadPoolExecutor(1) as beside:
        if stock:
            programs = beside.submit(generate_programs, not (check or update), processes)
        for data in specs:
            texts = generated_files(folder / str(data["name"]))
            forms = {} if search else _recorded_forms(folder / str(data["name"]), texts)
            made[str(data["name"])] = generate(
                data, forms, feedback.shows_bars, texts if check or update else None, processes
            )
        if stock:
            made.update(programs.result())
    if stock and (folder / HEADERS).is_dir():  # a checkout, or an installed package
        made[HEADERS] = generate_headers()
    differences = []
    for stem, files in made.items():
        target, old = folder / stem, generated_files(folder / stem)
        changed = {n: t for n, t in files.items() if old.get(n) != t}
        gone = [n for n in old if n not in files and n.startswith("kernels/")]  # of modules without kernels now
        if check:
            differences += [_difference(target / n, old.get(n, ""), t) for n, t in changed.items()]
            differences += [f"{target / n} is not generated any more" for n in gone]
        elif changed or gone or not update:
            _write(target, changed if update else files, gone)
            click.echo(f"wrote {target} ({len(changed)} of {len(files)} files changed)")
            if signature is not None:
                _tell_omissions(signature)
    if differences:
        _report_outdated(differences)
    if check:
        click.echo("generated files are up to date")


def _report_outdated(what: Sequence[str]) -> NoReturn:
    click.echo("\n".join(what))
    click.echo("generated files are older than their formulas; run: bladesmith generate --update")
    raise click.exceptions.Exit(1)


def _specs(spec: Path | None, signature: str | None, name: str | None) -> list[Mapping[str, Any]]:
    from ..codegen.algebra.loader import STOCK
    from ..codegen.algebra.schema import load_spec, stock_spec_path
    from ..codegen.declarations import plain_spec

    if spec is not None and signature is not None:
        raise InputError("--spec and --signature exclude each other; give one.")
    if name is not None and signature is None:
        raise InputError("--name goes with --signature; a spec file and the stock algebras have their own names.")
    if spec is not None:
        return [load_spec(spec)]
    if signature is not None:
        p, q, r = _numbers(signature)
        if name == "":
            raise SignatureError("--name is empty; leave it out, or give the algebra's name.")
        if p == q == r == 0:
            raise SignatureError("--signature is 0,0,0; an algebra without vectors has nothing to generate.")
        return [plain_spec(p, q, r, name or f"cl{p}_{q}_{r}")]
    return [load_spec(stock_spec_path(stock)) for stock in STOCK]


def _numbers(signature: str) -> tuple[int, int, int]:
    try:
        p, q, r = (int(part) for part in signature.split(","))
    except ValueError:
        raise SignatureError(f"--signature is {signature!r}; write three integers p,q,r, such as 3,0,1.") from None
    return p, q, r


def _tell_omissions(signature: str) -> None:
    """Say what a plain algebra is without."""
    from ..codegen.declarations import omissions

    for each in omissions(*_numbers(signature)):
        click.echo(f"  {each}")


def _installed_folder() -> Path:
    from importlib import resources

    return Path(str(resources.files(f"{__package__.partition('.')[0]}.generated")))


def _recorded_forms(folder: Path, texts: Mapping[str, str]) -> Any:
    try:
        return json.loads(texts.get("variants.json", "{}"))
    except ValueError as error:
        raise SpecError(
            f"not a record of forms ({error})",
            where=str(folder / "variants.json"),
            remedy="Take it from version control, or remove it: all forms are searched again then (minutes)",
        ) from None


def _write(folder: Path, files: Mapping[str, str], gone: Sequence[str]) -> None:
    from ..common.files import write_atomically

    for file, text in files.items():
        (folder / file).parent.mkdir(parents=True, exist_ok=True)
        write_atomically(folder / file, text)
    for file in gone:
        (folder / file).unlink()


def _difference(path: Path, old: str, new: str) -> str:
    lines = difflib.unified_diff(
        old.splitlines(), new.splitlines(), str(path), f"{path} (generated now)", lineterm="", n=1
    )
    return "\n".join(list(lines)[:DIFF_LINES])
