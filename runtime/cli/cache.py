"""`bladesmith cache`: list and clear the compiled kernels of this user."""

from __future__ import annotations

from datetime import datetime

import click

from ..codegen.build import cache
from ..errors import InputError
from . import options


def readable(size: int) -> str:
    """A number of bytes for people: `1.4 MB`."""
    return f"{size / 1e6:.1f} MB" if size >= 100_000 else f"{size / 1e3:.1f} kB"


def count_entries(entries: int) -> str:
    """`1 entry`, `2 entries`."""
    return "1 entry" if entries == 1 else f"{entries} entries"


@options.command("cache --clear", "development/cache")
@options.flag("--clear", "Remove all entries; they are compiled again when needed.")
def command(clear: bool) -> None:
    """List the compiled kernels of this user, most recently used first, or clear them."""
    root = cache.directory()
    if root.exists() and not root.is_dir():
        raise InputError(f"{root} is not a directory.", remedy=f"Set {cache.DIRECTORY_VARIABLE} to one")
    if clear:
        removed, size = cache.clear()
        click.echo(f"removed {count_entries(removed)}, {readable(size)}, from {root}")
        return
    found = cache.entries()
    for entry in found:
        used = datetime.fromtimestamp(entry.used).isoformat(" ", "minutes")
        click.echo(f"{readable(entry.size):>10}  {used}  {entry.stem}")
    total = sum(entry.size for entry in found)
    click.echo(f"{count_entries(len(found))}, {readable(total)}, in {root}")
