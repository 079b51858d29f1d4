"""What pyproject.toml cannot state: packages, their data and the extensions, found by walking the folders.

One extension is made for each `generated/<name>/kernels.cdef`. Extensions are optional (without a compiler
the numba target serves) unless BLADESMITH_REQUIRE_EXTENSION=1 is set.
"""

import os
import runpy
import shutil
import sysconfig
from pathlib import Path

from cffi import FFI
from setuptools import Extension, setup
from setuptools.command.build_ext import build_ext
from setuptools.command.build_py import build_py

ROOT = Path(__file__).resolve().parent
os.chdir(ROOT)  # setuptools wants relative paths; some front ends start elsewhere

ROOMS = {
    "bladesmith": "runtime",
    "bladesmith.codegen": "codegen",
    "bladesmith.templates": "templates",
    "bladesmith.generated": "generated",
}
NOT_DATA = {".py", ".pyc", ".so", ".pyd", ".o", ".obj"}
STABLE_ABI = "cp311"  # oldest Python served; one wheel for it and all later ones
LIMITED = not sysconfig.get_config_var("Py_GIL_DISABLED")  # a free-threaded Python has no stable ABI
NO_DEBUG = "-g0"  # most Pythons hand on -g, which makes the libraries four times larger
FLAGS = runpy.run_path("codegen/flags.py")
REQUIRED = os.environ.get("BLADESMITH_REQUIRE_EXTENSION", "") not in ("", "0")


def folders(room: str) -> list[Path]:
    """The room and every folder in it, caches and hidden ones left out."""
    below = [path for path in Path(room).rglob("*") if path.is_dir()]
    return [
        path
        for path in [Path(room), *sorted(below)]
        if all(part.isidentifier() and part != "__pycache__" for part in path.parts)
    ]


def packages() -> dict[str, Path]:
    """Package name -> folder. A folder of templates or sources counts: so that its files are shipped."""
    return {
        ".".join([package, *path.parts[1:]]): path
        for package, room in ROOMS.items()
        for path in folders(room)
    }


def data(folder: Path) -> list[str]:
    """Every file of a package that is neither Python nor built."""
    return sorted(
        path.name
        for path in folder.iterdir()
        if path.is_file() and path.suffix not in NOT_DATA and not path.name.startswith(".")
    )


def extension(cdef: Path) -> Extension:
    """The compiled kernels of one generated folder, as `bladesmith.generated.<name>._kernels`."""
    folder, shared = cdef.parent, Path("templates/c")
    files = FLAGS["compiled_files"](folder, shared)
    ffi = FFI()
    ffi.cdef(files[cdef.name])
    ffi.set_source(
        f"bladesmith.generated.{folder.name}._kernels",
        '#include "kernels.c"\n',
        include_dirs=[str(folder), str(shared)],
        define_macros=[(FLAGS["HASH_MACRO"], f'"{FLAGS["source_hash"](files)}"')],
        depends=[str(path) for home in (folder, shared) for path in sorted(home.iterdir()) if path.is_file()],
        py_limited_api=LIMITED,
        optional=not REQUIRED,
    )
    return ffi.distutils_extension(tmpdir="build/cffi", verbose=False)


class BuildExtensions(build_ext):
    """Chooses the flags once the compiler is known, and compiles the extensions side by side."""

    def finalize_options(self) -> None:
        super().finalize_options()
        self.parallel = self.parallel or True  # as many as there are processors

    def build_extensions(self) -> None:
        microsoft = self.compiler.compiler_type == "msvc"
        for each in self.extensions:
            each.extra_compile_args = list(
                FLAGS["MSVC_FLAGS"] if microsoft else [*FLAGS["C_FLAGS"], NO_DEBUG]
            )
            each.libraries = [] if microsoft else ["m"]
        super().build_extensions()


class BuildFresh(build_py):
    """Starts from an empty build/lib: a second `pip wheel .` would otherwise ship files since deleted."""

    def run(self) -> None:
        if not self.editable_mode:
            shutil.rmtree(Path(self.build_lib) / "bladesmith", ignore_errors=True)
        super().run()


PACKAGES = packages()
CDEFS = [path for path in sorted(Path("generated").glob("*/kernels.cdef")) if path.with_suffix(".c").exists()]

setup(
    packages=list(PACKAGES),
    package_dir=ROOMS,
    package_data={name: data(folder) for name, folder in PACKAGES.items()},
    ext_modules=[extension(path) for path in CDEFS],
    cmdclass={"build_ext": BuildExtensions, "build_py": BuildFresh},
    options={"bdist_wheel": {"py_limited_api": STABLE_ABI}} if CDEFS and LIMITED else {},
)
