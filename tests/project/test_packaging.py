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

from bladesmith.codegen import build
from bladesmith.codegen.flags import compiled_files, source_hash

CHECKOUT = Path(__file__).resolve().parents[1]
ROOMS = {"runtime": "", "codegen": "codegen", "templates": "templates", "generated": "generated"}
BUILT = {".pyc", ".so", ".o", ".pyd"}
PATIENCE = 120.0  # seconds for one build on a busy machine

STUB_CDEF = "const char *bs_source_hash(void); int bs_stub(void);\n"
STUB = """#include "platform.h"
const char *bs_source_hash(void) { return BS_SOURCE_HASH; }
int bs_stub(void) { return 7; }
"""

pytestmark = [
    pytest.mark.skipif(not (CHECKOUT / "setup.py").exists(), reason="not run from a checkout"),
    pytest.mark.skipif(build.compiler() is None, reason="no C compiler"),
]


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
    return run("-c", prelude + code, cwd=cwd).stdout.strip()


def sources(tree: Path) -> set[str]:
    """Every file of the rooms, as it is to be called in an installed package."""
    found = set()
    for room, package in ROOMS.items():
        for path in (tree / room).rglob("*"):
            inside = path.relative_to(tree / room)
            if path.is_file() and path.suffix not in BUILT and "__pycache__" not in inside.parts:
                found.add(Path("bladesmith", package, inside).as_posix())
    return found


@pytest.fixture(scope="module")
def tree(tmp_path_factory) -> Path:
    """A copy of the checkout, with stubs for kernels and one algebra that the checkout does not know."""
    copy = tmp_path_factory.mktemp("packaging") / "checkout"
    skipped = shutil.ignore_patterns("__pycache__", "*.so", "*.egg-info", ".*_cache", ".hypothesis")
    copy.mkdir()
    for name in [*ROOMS, "tests", "docs", "examples", "benchmarks"]:
        if (CHECKOUT / name).exists():
            shutil.copytree(CHECKOUT / name, copy / name, ignore=skipped)
    for name in ["pyproject.toml", "setup.py", "MANIFEST.in", "README.md", "LICENSE"]:
        shutil.copy(CHECKOUT / name, copy / name)
    (copy / "generated" / "another3d").mkdir()
    for folder in (copy / "generated").iterdir():
        if folder.is_dir():
            (folder / "kernels.c").write_text(STUB)
            (folder / "kernels.cdef").write_text(STUB_CDEF)
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


def test_wheel_holds_every_source_and_every_extension(tree, wheel):
    with zipfile.ZipFile(wheel) as opened:
        names = set(opened.namelist())
        metadata = opened.read(next(name for name in names if name.endswith("METADATA"))).decode()
    packed = {name for name in names if name.startswith("bladesmith/")}
    extensions = {name for name in packed if Path(name).suffix in BUILT}
    assert packed - extensions == sources(tree)
    algebras = [
        path.name for path in (tree / "generated").iterdir() if path.is_dir() and path.name != "__pycache__"
    ]
    assert {Path(name).parent.name for name in extensions} == set(algebras)
    assert "another3d" in algebras
    for extra in ["numba", "plot", "mesh", "distributed", "cuda", "test", "benchmark", "all"]:
        assert f"Provides-Extra: {extra}" in metadata
    assert "abi3" in wheel.name or "t-" in wheel.name


def test_wheel_works_from_another_directory(tree, wheel, tmp_path):
    target = tmp_path / "site"
    run("-m", "pip", "install", "--quiet", "--no-deps", "--no-index", "--target", target, wheel, cwd=tmp_path)
    code = (
        "import bladesmith, bladesmith.codegen, bladesmith.templates, bladesmith.errors\n"
        "from importlib import resources\n"
        "from bladesmith.generated.another3d import _kernels\n"
        "print(bladesmith.__file__)\n"
        "print(resources.files('bladesmith.templates').joinpath('c', 'platform.h').is_file())\n"
        "print(_kernels.lib.bs_stub(), _kernels.ffi.string(_kernels.lib.bs_source_hash()).decode())"
    )
    file, found, stub = python(code, target, cwd=tmp_path).splitlines()
    expected = source_hash(compiled_files(tree / "generated" / "another3d", tree / "templates" / "c"))
    assert Path(file) == target / "bladesmith" / "__init__.py"
    assert found == "True"
    assert stub == f"7 {expected}"
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
    """As pip makes one: the wheel of the editable hook, unpacked."""
    code = f"from setuptools import build_meta; build_meta.build_editable({str(tmp_path)!r})"
    run("-c", code, cwd=tree, BLADESMITH_REQUIRE_EXTENSION="1")
    (made,) = tmp_path.glob("*.whl")
    site = tmp_path / "site"
    with zipfile.ZipFile(made) as opened:
        opened.extractall(site)
    (tree / "codegen" / "added_later.py").write_text("value = 5\n")
    code = (
        "import bladesmith, bladesmith.codegen.added_later as added\n"
        "from bladesmith.generated.another3d import _kernels\n"
        "print(bladesmith.__file__, added.value, _kernels.lib.bs_stub())"
    )
    try:
        assert python(code, site, cwd=tmp_path) == f"{tree / 'runtime' / '__init__.py'} 5 7"
    finally:
        (tree / "codegen" / "added_later.py").unlink()
        for path in (tree / "generated").rglob("*.so"):
            path.unlink()
