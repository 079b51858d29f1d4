"""`bladesmith cache`: what was compiled for this user, and getting rid of it."""

from __future__ import annotations

from datetime import datetime

import click

from ..codegen import cache
from ..errors import InputError


def readable(size: int) -> str:
    """A number of bytes for people: `1.4 MB`."""
    return f"{size / 1e6:.1f} MB" if size >= 100_000 else f"{size / 1e3:.1f} kB"


def counted(entries: int) -> str:
    """`1 entry`, `2 entries`."""
    return "1 entry" if entries == 1 else f"{entries} entries"


@click.command(epilog="Example: bladesmith cache --clear")
@click.option("--clear", is_flag=True, help="Remove all entries; they are compiled again when needed.")
def command(clear: bool) -> None:
    """List the compiled kernels of this user, most recently used first, or clear them."""
    root = cache.directory()
    if root.exists() and not root.is_dir():
        raise InputError(f"{root} is no directory.", remedy=f"Set {cache.DIRECTORY_VARIABLE} to one")
    if clear:
        removed, size = cache.clear()
        click.echo(f"removed {counted(removed)}, {readable(size)}, from {root}")
        return
    found = cache.entries()
    for entry in found:
        used = datetime.fromtimestamp(entry.used).isoformat(" ", "minutes")
        click.echo(f"{readable(entry.size):>10}  {used}  {entry.stem}")
    total = sum(entry.size for entry in found)
    click.echo(f"{counted(len(found))}, {readable(total)}, in {root}")
