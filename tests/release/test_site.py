"""The site of the docs: it builds without a warning and without network, and has every public name."""

from __future__ import annotations

import importlib
import inspect
import os
import re
import resource
import subprocess
import sys
from pathlib import Path

import pytest

import bladesmith

from ..support.checkout import CHECKOUT, public_modules

pytestmark = pytest.mark.packaging
#: Seconds of processor time for the whole.
MOST_SECONDS = 240


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    pytest.importorskip("sphinx")
    folder = tmp_path_factory.mktemp("site")
    environment = {k: v for k, v in os.environ.items() if k != "BLADESMITH_DOCS_ONLINE"}
    command = [sys.executable, "-m", "sphinx", "-W", "--keep-going", "-q", "-d", str(folder / "kept")]
    begin = _children_seconds()
    done = subprocess.run(
        [*command, str(CHECKOUT / "docs"), str(folder / "html")], env=environment, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr[-4000:]
    assert _children_seconds() - begin < MOST_SECONDS
    return folder / "html"


def _children_seconds() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def test_every_public_name_is_in_the_reference(site: Path) -> None:
    from sphinx.util.inventory import InventoryFile

    inventory = InventoryFile.loads((site / "objects.inv").read_bytes(), uri="")
    known = {name for kind in inventory.data for name in inventory.data[kind] if kind.startswith("py:")}
    aliases = {"bladesmith.registration"}
    wanted = {
        f"{module}.{name}"
        for module, names in public_modules().items()
        for name in names
        if module not in aliases and not inspect.ismodule(getattr(importlib.import_module(module), name))
    }
    errors = {f"bladesmith.codegen.{n}" for n in dir(bladesmith.errors)}
    assert len(wanted) > 250
    assert not wanted - known - errors


def test_pages_lead_somewhere(site: Path) -> None:
    missing = []
    for page in (p for p in site.rglob("*.html") if "_static" not in p.parts):
        for link in re.findall(r'(?:href|src)="([^"#:?]+)(?:[#?][^"]*)?"', page.read_text(encoding="utf-8")):
            if not (page.parent / link).exists():
                missing.append((page.name, link))
    assert not missing
