"""What pyproject.toml cannot state: packages, their data and the extensions, found by walking the folders.

One extension is made for each algebra in `generated`, of units: kernels of one module of formulas for one instance
(precision and vector width). The units of `FIRST_MODULES` are compiled here, for the best instance of double precision
that this machine runs; the rest is compiled at first use, from the text that is shipped. With BLADESMITH_COMPILE=all
everything is compiled here, for wheels that others install. Extensions are optional (without a compiler the numba
target serves) unless BLADESMITH_REQUIRE_EXTENSION=1 is set.
"""

import os
import platform
import runpy
import shutil
import subprocess
import sysconfig
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from cffi import FFI
from setuptools import Extension, setup
from setuptools.command.build_ext import build_ext
from setuptools.command.build_py import build_py
from setuptools.errors import CompileError, LinkError

ROOT = Path(__file__).resolve().parent
os.chdir(ROOT)  # setuptools wants relative paths; some front ends start elsewhere

PACKAGES = {
    "bladesmith": "runtime",
    "bladesmith.codegen": "codegen",
    "bladesmith.templates": "templates",
    "bladesmith.generated": "generated",
}
NOT_DATA = {".py", ".pyc", ".so", ".pyd", ".o", ".obj"}
STABLE_ABI = "cp311"  # oldest Python served; one wheel for it and all later ones
LIMITED = not sysconfig.get_config_var("Py_GIL_DISABLED")  # a free-threaded Python has no stable ABI
NO_DEBUG = "-g0"  # most Pythons hand on -g, which makes the libraries four times larger
FLAGS = runpy.run_path("codegen/build/flags.py")
INSTANCES = runpy.run_path("codegen/targets/c/instances.py")
HEADERS = Path("templates/c")
INCLUDED = [str(path) for path in FLAGS["header_folders"](HEADERS)]
WANTED = os.environ.get("BLADESMITH_COMPILE", "") or "first"
if WANTED not in ("first", "all"):
    raise SystemExit(f"BLADESMITH_COMPILE={WANTED!r}: it is first (the default) or all")
EVERYTHING = WANTED == "all"
REQUIRED = os.environ.get("BLADESMITH_REQUIRE_EXTENSION", "") not in ("", "0")


def folders(root: str) -> list[Path]:
    """A folder and every folder in it, caches and hidden ones left out."""
    below = [path for path in Path(root).rglob("*") if path.is_dir()]
    return [
        path
        for path in [Path(root), *sorted(below)]
        if all(part.isidentifier() and part != "__pycache__" for part in path.parts)
    ]


def packages() -> dict[str, Path]:
    """Package name -> folder. A folder of templates or sources counts: so that its files are shipped."""
    return {
        ".".join([package, *path.parts[1:]]): path
        for package, folder in PACKAGES.items()
        for path in folders(folder)
    }


def data(folder: Path) -> list[str]:
    """Every file of a package that is neither Python nor built."""
    return sorted(
        path.name
        for path in folder.iterdir()
        if path.is_file() and path.suffix not in NOT_DATA and not path.name.startswith(".")
    )


def modules(folder: Path) -> list[str]:
    """Modules of formulas whose kernels are compiled here."""
    found = sorted(path.stem for path in folder.glob("kernels/*.c"))
    first = FLAGS["FIRST_MODULES"].get(folder.name, ())
    return [name for name in found if EVERYTHING or name in first]


def is_first(folder: Path) -> bool:
    """Whether an extension is made here: of algebras always, of programs some."""
    return EVERYTHING or (folder / "kernels").is_dir() or folder.name in FLAGS["FIRST_PROGRAMS"]


def extension(cdef: Path) -> Extension:
    """The compiled kernels of one generated folder, as `bladesmith.generated.<name>._kernels`."""
    folder = cdef.parent
    files = FLAGS["compiled_files"](folder, HEADERS)
    units = Path("build/cffi", folder.name)
    units.mkdir(parents=True, exist_ok=True)
    ffi = FFI()
    ffi.cdef(files[cdef.name])
    ffi.set_source(
        f"bladesmith.generated.{folder.name}._kernels",
        '#include "units.h"\n#include "kernels.c"\n',
        include_dirs=[str(units), str(folder), *INCLUDED],
        define_macros=[(FLAGS["HASH_MACRO"], f'"{FLAGS["source_hash"](files)}"')],
        depends=[
            str(path)
            for home in (folder, folder / "kernels", *map(Path, INCLUDED))
            for path in sorted(home.glob("*"))
            if path.is_file()
        ],
        py_limited_api=LIMITED,
        optional=not REQUIRED,
    )
    made = ffi.distutils_extension(tmpdir="build/cffi", verbose=False)
    made.folder, made.units = folder, units / "units.h"
    return made


class BuildExtensions(build_ext):
    """Compiles the units of all extensions side by side, those that take longest first, and then the extensions."""

    def finalize_options(self) -> None:
        super().finalize_options()
        self.parallel = self.parallel or True  # as many as there are processors

    def build_extensions(self) -> None:
        self.microsoft = self.compiler.compiler_type == "msvc"
        self.flags = list(FLAGS["MSVC_FLAGS"] if self.microsoft else [*FLAGS["C_FLAGS"], NO_DEBUG])
        instances = self.instances()
        self.version = self.asked_version()
        jobs = [(each, module, i) for each in self.extensions for module in modules(each.folder) for i in instances]
        jobs.sort(key=lambda job: -(job[0].folder / FLAGS["unit_file"](job[1])).stat().st_size)
        programs = [each for each in self.extensions if not (each.folder / "kernels").is_dir()]
        for each in programs:
            self.prepare(each, [], [])
        with ThreadPoolExecutor(os.cpu_count()) as pool:
            begun = [pool.submit(self.build_program, each) for each in programs]
            objects = list(pool.map(lambda job: self.unit(*job), jobs))
        self.drop_unused(objects)
        for each in begun:
            each.result()
        everything = self.extensions
        self.extensions = [each for each in everything if each not in programs]
        for each in self.extensions:
            self.prepare(each, jobs, objects)
        super().build_extensions()
        self.extensions = everything

    def build_program(self, each: Extension) -> None:
        """An extension without units, which need not wait for those of others."""
        with self._filter_build_errors(each):
            self.build_extension(each)

    def prepare(self, each: Extension, jobs: list, objects: list) -> None:
        """Link an extension to those objects that are of its units, and choose its flags."""
        compiled = [(job, made) for job, made in zip(jobs, objects, strict=True) if job[0] is each and made]
        names = " ".join(f"U({module}, {i.tag})" for (_, module, i), _ in compiled)
        text = f"#define BS_UNITS(U) {names}\n"
        if not each.units.exists() or each.units.read_text() != text:
            each.units.write_text(text)
        each.extra_objects = [made for _, made in compiled]
        each.depends = [*each.depends, str(each.units), *each.extra_objects]
        each.extra_compile_args = list(self.flags)
        each.libraries = [] if self.microsoft else ["m"]

    def instances(self) -> list:
        """Those that are compiled here."""
        wide = not self.microsoft and platform.machine().lower() in ("x86_64", "amd64")
        if EVERYTHING:
            return [i for i in INSTANCES["PORTABLE"] if wide or not i.wide]
        level = self.level() if wide else 0
        return [i for i in INSTANCES["OF_KERNELS"] if i.bits == 64 and i.level <= level][-1:]

    def level(self) -> int:
        """The level of instances that this machine runs, by a program that asks."""
        home = Path(self.build_temp)
        home.mkdir(parents=True, exist_ok=True)
        source = home / "asks.c"
        text = "int main(void) { return BS_CPU_HAS_V4() ? 4 : BS_CPU_HAS_V3() ? 3 : 0; }"
        source.write_text(f'#include "platform.h"\n{text}\n')
        try:
            absolute = [str(Path(home).resolve()) for home in INCLUDED]
            objects = self.compiler.compile([str(source)], output_dir=str(home), include_dirs=absolute)
            self.compiler.link_executable(objects, "asks", output_dir=str(home))
            said = subprocess.run([str(home / "asks")], check=False).returncode
            return said if said in {i.level for i in INSTANCES["OF_KERNELS"]} else 0
        except (CompileError, LinkError, OSError):
            return 0

    def asked_version(self) -> str:
        """What the compiler says about itself: one that is upgraded keeps its name."""
        command = getattr(self.compiler, "compiler_so", None)
        if not command:  # Microsoft's
            return ""
        try:
            return subprocess.run([*command, "--version"], capture_output=True, text=True, check=False).stdout
        except OSError:
            return ""

    def drop_unused(self, objects: list) -> None:
        """Remove units that this build did not link: of texts that have changed, or of another compiler."""
        used = {Path(made).relative_to(self.build_temp).parts[1] for made in objects if made}
        for path in Path(self.build_temp, "units").glob("*"):
            if path.name not in used:
                shutil.rmtree(path, ignore_errors=True)

    def unit(self, extension: Extension, module: str, instance: object) -> str | None:
        """The object of one unit: kept from an earlier build of the same text, or compiled; None where that fails."""
        source = FLAGS["unit_file"](module)
        files = FLAGS["compiled_files"](extension.folder, HEADERS, [source])
        options = list(FLAGS["unit_options"](module, instance, FLAGS["source_hash"](files)))
        if self.microsoft:
            options = [option for option in options if option.startswith("-D")]
        arguments = [*self.flags, *options]
        path = str(extension.folder / source)
        how = repr((path, getattr(self.compiler, "compiler_so", ""), self.version, arguments))
        kept = Path(self.build_temp, "units", FLAGS["source_hash"]({**files, "how": how}))
        (made,) = self.compiler.object_filenames([path], output_dir=str(kept))
        if Path(made).exists() and not self.force:
            return made
        try:
            being_made = f"{kept}.{os.getpid()}"
            self.compiler.compile(
                [path], being_made, include_dirs=[*INCLUDED, sysconfig.get_path("include")],
                extra_postargs=arguments,
            )  # fmt: skip
            shutil.rmtree(kept, ignore_errors=True)
            os.replace(being_made, kept)
        except CompileError:
            if REQUIRED:
                raise
            return None
        return made


class BuildFresh(build_py):
    """Starts from an empty build/lib: a second `pip wheel .` would otherwise ship files since deleted."""

    def run(self) -> None:
        if not self.editable_mode:
            shutil.rmtree(Path(self.build_lib) / "bladesmith", ignore_errors=True)
        super().run()


PACKAGES = packages()
CDEFS = [
    path
    for path in sorted(Path("generated").glob("*/kernels.cdef"))
    if path.with_suffix(".c").exists() and is_first(path.parent)
]

setup(
    packages=list(PACKAGES),
    package_dir=PACKAGES,
    package_data={name: data(folder) for name, folder in PACKAGES.items()},
    ext_modules=[extension(path) for path in CDEFS],
    cmdclass={"build_ext": BuildExtensions, "build_py": BuildFresh},
    options={"bdist_wheel": {"py_limited_api": STABLE_ABI}} if CDEFS and LIMITED else {},
)
