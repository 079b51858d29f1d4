"""`bladesmith generate`: write an algebra's sources and manifest, or check that they are up to date."""

from __future__ import annotations

import difflib
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import click

from ..errors import InputError, SignatureError

#: Lines of difference that --check prints for each file.
DIFF_LINES = 20


@click.command(
    epilog="Example: bladesmith generate --signature 2,0,1 --name pga2d --out generated/",
    context_settings={"help_option_names": ["-h", "--help"]},
)
@click.option("--spec", type=click.Path(dir_okay=False), help="Spec file of the algebra (docs/specs.md).")
@click.option("--signature", help="p,q,r of a plain algebra, instead of a spec.")
@click.option("--name", help="Name of the plain algebra. Default: clp_q_r.")
@click.option("--out", type=click.Path(file_okay=False), help="Folder that holds one folder per algebra.")
@click.option("--check", is_flag=True, help="Write nothing; exit 1 with the difference when files are not up to date.")
@click.option("--search", is_flag=True, help="Search the cheapest form of every kernel again (slow).")
@click.option("--quiet", is_flag=True, help="No progress bar.")
def command(
    spec: str | None,
    signature: str | None,
    name: str | None,
    out: str | None,
    check: bool,
    search: bool,
    quiet: bool,
) -> None:
    """Generate an algebra: C, numba and CUDA-ready sources, and a manifest.

    Without --spec and --signature, all stock algebras and programs. Without --out, into ./generated, or for --check
    the installed package's own folder. The forms chosen earlier are read from forms.json there.
    """
    from ..codegen.generator import generate, generate_programs

    folder = Path(out) if out else (_installed() if check else Path("generated"))
    differences = []
    made = {}
    for data in _specs(spec, signature, name):
        forms = _read(folder / str(data["name"])).get("forms.json", "{}")
        with _bar(quiet, str(data["name"])) as progress:
            made[str(data["name"])] = generate(data, {} if search else json.loads(forms), progress)
    if spec is None and signature is None:
        made.update(generate_programs())
    for stem, files in made.items():
        target = folder / stem
        if check:
            old = _read(target)
            differences += [_difference(target / n, old.get(n, ""), t) for n, t in files.items() if old.get(n) != t]
        else:
            _write(target, files)
            click.echo(f"wrote {target} ({len(files)} files)")
    if differences:
        click.echo("\n".join(differences))
        raise click.exceptions.Exit(1)
    if check:
        click.echo("generated files are up to date")


def _specs(spec: str | None, signature: str | None, name: str | None) -> list[Mapping[str, Any]]:
    from ..codegen.catalogue import STOCK
    from ..codegen.generator import plain_spec
    from ..codegen.spec import load_spec, stock_spec_path

    if spec is not None and signature is not None:
        raise InputError("--spec and --signature exclude each other; give one.")
    if name is not None and signature is None:
        raise InputError("--name goes with --signature; a spec file and the stock algebras have their own names.")
    if spec is not None:
        return [load_spec(spec)]
    if signature is not None:
        try:
            p, q, r = (int(part) for part in signature.split(","))
        except ValueError:
            raise SignatureError(f"--signature is {signature!r}; write three integers p,q,r, such as 3,0,1.") from None
        if name == "":
            raise SignatureError("--name is empty; leave it out, or give the algebra's name.")
        if p == q == r == 0:
            raise SignatureError("--signature is 0,0,0; an algebra without vectors has nothing to generate.")
        return [plain_spec(p, q, r, name or f"cl{p}_{q}_{r}")]
    return [load_spec(stock_spec_path(stock)) for stock in STOCK]


def _installed() -> Path:
    from importlib import resources

    return Path(str(resources.files(f"{__package__.partition('.')[0]}.generated")))


def _read(folder: Path) -> dict[str, str]:
    if not folder.is_dir():
        return {}
    return {
        p.name: p.read_text(encoding="utf-8")
        for p in folder.iterdir()
        if p.suffix in (".c", ".h", ".cdef", ".py", ".json")
    }


def _write(folder: Path, files: Mapping[str, str]) -> None:
    from ..files import write_atomically

    folder.mkdir(parents=True, exist_ok=True)
    for file, text in files.items():
        write_atomically(folder / file, text)


def _difference(path: Path, old: str, new: str) -> str:
    lines = difflib.unified_diff(
        old.splitlines(), new.splitlines(), str(path), f"{path} (generated now)", lineterm="", n=1
    )
    return "\n".join(list(lines)[:DIFF_LINES])


class _bar:
    """Progress bar as a context; gives the callback that the generator calls."""

    def __init__(self, quiet: bool, text: str) -> None:
        from tqdm import tqdm

        self.bar = tqdm(desc=f"generate {text}", disable=quiet or None, unit="kernel", leave=False)

    def __enter__(self) -> Any:
        return self.update

    def update(self, done: int, total: int, name: str) -> None:
        """Show that ``done`` of ``total`` kernels are made."""
        self.bar.total, self.bar.n = total, done
        self.bar.set_postfix_str(name, refresh=True)

    def __exit__(self, *exception: object) -> None:
        self.bar.close()
