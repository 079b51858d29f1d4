"""What is shipped: sdist, wheel and editable install of a copy of the checkout, used from another directory.

The copy's kernels are stubs, so that compiling them takes no time; the real ones are compiled by the install
that these tests run under.
"""

import os
import shutil
import subprocess
import sys
import tarfile
import zipfile
from pathlib import Path

import pytest

from bladesmith.codegen.build import extension
from bladesmith.codegen.build.cpu_features import best_instances, has_wide_vectors
from bladesmith.codegen.build.flags import compiled_files, source_hash
from bladesmith.codegen.targets.c.instances import PORTABLE

from ..support.checkout import CHECKOUT

PACKAGES = {"runtime": "", "codegen": "codegen", "templates": "templates", "generated": "generated"}
BUILT = {".pyc", ".so", ".o", ".pyd"}
PATIENCE = 120.0  # seconds for one build on a busy machine

STUB_CDEF = "const char *bs_source_hash(void); int bs_stub(void); const char *bs_units(void);\n"
STUB = """#include "platform.h"
#define NAME(module, instance) #module " " #instance " "
const char *bs_source_hash(void) { return BS_SOURCE_HASH; }
int bs_stub(void) { return 7; }
const char *bs_units(void) { return BS_UNITS(NAME) ""; }
"""
#: Units of kernels: one that is compiled at install, and one that is not.
UNITS = ("products", "costs")

pytestmark = [
    pytest.mark.packaging,
    pytest.mark.skipif(not (CHECKOUT / "setup.py").exists(), reason="not run from a checkout"),
    pytest.mark.skipif(extension.compiler() is None, reason="no C compiler"),
]


def template_names() -> list[str]:
    """Names of all templates and headers of the checkout."""
    found = [path.name for path in (CHECKOUT / "templates").rglob("*.*") if path.suffix not in {".py", *BUILT}]
    assert len(found) == len(set(found)) > 40
    return found


def run(*command, cwd, check=True, **environment) -> subprocess.CompletedProcess:
    clean = {key: value for key, value in os.environ.items() if not key.startswith(("BLADESMITH_", "PYTHON"))}
    done = subprocess.run(
        [sys.executable, *map(str, command)], cwd=cwd, env={**clean, **environment},
        capture_output=True, text=True, timeout=PATIENCE,
    )  # fmt: skip
    assert done.returncode == 0 or not check, done.stdout + done.stderr
    return done


def python(code: str, site: Path, cwd: Path) -> str:
    """Output of a new interpreter for which the package is installed in `site`, and nowhere else."""
    prelude = f"""
import site, sys
sys.meta_path[:] = [finder for finder in sys.meta_path if "editable" not in repr(finder).lower()]
for name in [name for name in sys.modules if name.startswith("__editable__")]:
    del sys.modules[name]
sys.path.insert(0, {str(site)!r})
site.addsitedir({str(site)!r})  # runs the .pth file of an editable install
sys.meta_path.sort(key=lambda finder: "editable" not in repr(finder).lower())
"""
    return run("-c", prelude + code, cwd=cwd).stdout.removesuffix("\n")


def sources(tree: Path) -> set[str]:
    """Every file of the packages, as it is to be called in an installed package."""
    found = set()
    for folder, package in PACKAGES.items():
        for path in (tree / folder).rglob("*"):
            inside = path.relative_to(tree / folder)
            if path.is_file() and path.suffix not in BUILT and "__pycache__" not in inside.parts:
                found.add(Path("bladesmith", package, inside).as_posix())
    return found


@pytest.fixture(scope="module")
def tree(tmp_path_factory) -> Path:
    """A copy of the checkout, with stubs for kernels, and an algebra and a program that the checkout does not know."""
    copy = tmp_path_factory.mktemp("packaging") / "checkout"
    skipped = shutil.ignore_patterns("__pycache__", "*.so", "*.egg-info", ".*_cache", ".hypothesis")
    copy.mkdir()
    for name in [*PACKAGES, "tests", "docs", "examples", "benchmarks"]:
        if (CHECKOUT / name).exists():
            shutil.copytree(CHECKOUT / name, copy / name, ignore=skipped)
    for name in ["pyproject.toml", "setup.py", "MANIFEST.in", "README.md", "LICENSE"]:
        shutil.copy(CHECKOUT / name, copy / name)
    for path in (copy / "generated").glob("*/kernels/*"):
        path.unlink()
    for name in ("another3d", "program"):
        (copy / "generated" / name).mkdir()
    (copy / "generated" / "another3d" / "kernels").mkdir()
    for folder in (copy / "generated").iterdir():
        if folder.is_dir():
            (folder / "kernels.c").write_text(STUB)
            (folder / "kernels.cdef").write_text(STUB_CDEF)
        if (folder / "kernels").is_dir():
            for module in UNITS:
                text = f'#include "platform.h"\nint BS_PASTE({module}, BS_TAG);\n'
                (folder / "kernels" / f"{module}.c").write_text(text)
    return copy


@pytest.fixture(scope="module")
def dist(tree) -> Path:
    """An sdist, and the wheel that is built from it."""
    run(
        "-m",
        "build",
        "--no-isolation",
        "--outdir",
        tree.parent / "dist",
        cwd=tree,
        BLADESMITH_REQUIRE_EXTENSION="1",
    )
    return tree.parent / "dist"


@pytest.fixture(scope="module")
def wheel(dist) -> Path:
    (found,) = dist.glob("*.whl")
    return found


def test_sdist_holds_what_a_build_needs(tree, dist):
    (archive,) = dist.glob("*.tar.gz")
    with tarfile.open(archive) as opened:
        names = {name.partition("/")[2] for name in opened.getnames()}
    for path in tree.rglob("*"):
        inside = path.relative_to(tree).as_posix()
        if path.is_file() and not inside.startswith(("build/", "bladesmith.egg-info/")):
            assert inside in names, f"{inside} is not in the sdist"


def test_wheel_holds_every_source_and_the_first_extensions(tree, wheel):
    with zipfile.ZipFile(wheel) as opened:
        names = set(opened.namelist())
        metadata = opened.read(next(name for name in names if name.endswith("METADATA"))).decode()
    packed = {name for name in names if name.startswith("bladesmith/")}
    extensions = {name for name in packed if Path(name).suffix in BUILT}
    assert packed - extensions == sources(tree)
    algebras = {path.parent.name for path in (tree / "generated").glob("*/kernels")}
    assert {Path(name).parent.name for name in extensions} == algebras | {"general", "calls"}
    assert "another3d" in algebras
    for extra in ["numba", "plot", "mesh", "distributed", "cuda", "test", "benchmark", "all"]:
        assert f"Provides-Extra: {extra}" in metadata
    assert "abi3" in wheel.name or "t-" in wheel.name


def test_wheel_works_from_another_directory(tree, wheel, tmp_path):
    target = tmp_path / "site"
    run("-m", "pip", "install", "--quiet", "--no-deps", "--no-index", "--target", target, wheel, cwd=tmp_path)
    code = (
        "import bladesmith, bladesmith.codegen, bladesmith.templates, bladesmith.errors\n"
        "from bladesmith.generated.another3d import _kernels\n"
        "print(bladesmith.__file__)\n"
        "from bladesmith.codegen.targets.templates import template_text\n"
        f"print(all(template_text(name) for name in {template_names()}))\n"
        "print(_kernels.lib.bs_stub(), _kernels.ffi.string(_kernels.lib.bs_source_hash()).decode())\n"
        "print(_kernels.ffi.string(_kernels.lib.bs_units()).decode())"
    )
    file, found, stub, units = python(code, target, cwd=tmp_path).split("\n")
    expected = source_hash(compiled_files(tree / "generated" / "another3d", tree / "templates" / "c"))
    assert Path(file) == target / "bladesmith" / "__init__.py"
    assert found == "True"
    assert stub == f"7 {expected}"
    best = best_instances("f64")[0].tag  # of this machine
    assert not units.split(), "what FIRST_MODULES does not name is compiled at first use"
    known = python(code.replace("another3d", "cga3d"), target, cwd=tmp_path).split("\n")[-1]
    assert known.split() == ["products", best]
    version = python("from bladesmith.cli.main import run; run(['--version'])", target, cwd=tmp_path)
    assert version.startswith("bladesmith, version")


def test_without_a_compiler_everything_but_the_extensions_is_installed(tree, tmp_path):
    """The tree is built twice, with a file deleted in between, which must not be shipped the second time."""
    build_wheel = ["-m", "build", "--wheel", "--no-isolation", "--outdir", tmp_path]
    extra = tree / "codegen" / "soon_deleted.py"
    extra.write_text("")
    try:
        refused = run(*build_wheel, cwd=tree, check=False, CC="/bin/false", BLADESMITH_REQUIRE_EXTENSION="1")
    finally:
        extra.unlink()
    assert refused.returncode != 0
    assert list((tree / "build").rglob("soon_deleted.py")), "the first build left it behind"
    run(*build_wheel, cwd=tree, CC="/bin/false")
    (made,) = tmp_path.glob("*.whl")
    with zipfile.ZipFile(made) as opened:
        packed = {name for name in opened.namelist() if name.startswith("bladesmith/")}
    assert packed == sources(tree)


def test_editable_install_follows_the_checkout(tree, tmp_path):
    """As pip makes one: the wheel of the editable hook, unpacked; and with everything compiled."""
    code = f"from setuptools import build_meta; build_meta.build_editable({str(tmp_path)!r})"
    run("-c", code, cwd=tree, BLADESMITH_REQUIRE_EXTENSION="1", BLADESMITH_COMPILE="all")
    (made,) = tmp_path.glob("*.whl")
    site = tmp_path / "site"
    with zipfile.ZipFile(made) as opened:
        opened.extractall(site)
    (tree / "codegen" / "added_later.py").write_text("value = 5\n")
    code = (
        "import bladesmith, bladesmith.codegen.added_later as added\n"
        "from bladesmith.generated.another3d import _kernels\n"
        "from bladesmith.generated.program import _kernels as program\n"
        "print(bladesmith.__file__, added.value, program.lib.bs_stub())\n"
        "print(_kernels.ffi.string(_kernels.lib.bs_units()).decode())"
    )
    try:
        first, units = python(code, site, cwd=tmp_path).splitlines()
        assert first == f"{tree / 'runtime' / '__init__.py'} 5 7"
        tags = [i.tag for i in PORTABLE if not i.wide or "f64_v3" in units]
        assert {*zip(*[iter(units.split())] * 2, strict=True)} == {(m, tag) for m in UNITS for tag in tags}
        assert "f64_v3" in units or not has_wide_vectors()
    finally:
        (tree / "codegen" / "added_later.py").unlink()
        for path in (tree / "generated").rglob("*.so"):
            path.unlink()


def test_objects_are_those_of_this_compiler_and_of_this_build(tree, tmp_path):
    """Compilers are upgraded in place: the same command is another compiler then."""
    compiler, log = tmp_path / "compiler", tmp_path / "log"

    def built(version: str) -> tuple[int, set[str]]:
        log.write_text("")
        compiler.write_text(
            f'#!/bin/sh\ncase "$*" in *--version*) exec echo {version};; esac\n'
            f'case "$*" in *" -c "*kernels/products.c*) echo "$@" >> {log};; esac\nexec {shutil.which("cc")} "$@"\n'
        )
        compiler.chmod(0o755)
        run("setup.py", "-q", "build_ext", "--build-lib", tmp_path / "lib", "--build-temp", tmp_path / "temp",
            cwd=tree, CC=str(compiler), BLADESMITH_REQUIRE_EXTENSION="1")  # fmt: skip
        return len(log.read_text().splitlines()), {path.name for path in (tmp_path / "temp" / "units").iterdir()}

    count, first = built("1")
    assert count and built("1") == (0, first), "nothing has changed"
    again, second = built("2")
    assert again == count and len(second) == len(first) and not first & second
