"""All C texts of the package, as a compiler gets them: one list for tests that go over them."""

from __future__ import annotations

import subprocess
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from itertools import product
from pathlib import Path

from bladesmith.codegen.algebra.loader import STOCK
from bladesmith.codegen.build.extension import generated_extension, generated_unit
from bladesmith.codegen.build.flags import C_FLAGS, WARNING_FLAGS
from bladesmith.codegen.build.installed import bundled_folder, headers
from bladesmith.codegen.build.toolchain import compiler
from bladesmith.codegen.programs import chains, mechanisms
from bladesmith.codegen.programs.mechanisms import program as mechanism_program
from bladesmith.codegen.programs.tracer.scene import EVERYTHING, needs, scene_program
from bladesmith.codegen.targets.c.extension import extension_source
from bladesmith.codegen.targets.c.instances import BY_TAG, PORTABLE, SCALAR
from bladesmith.codegen.targets.c.source import ExtensionSource, Unit

from ..specimens import VARIANTS

#: Scenes that need all parts of the driver.
SCENES = {
    "everything": EVERYTHING,
    "nothing": needs([]),
    "plain": needs(["plane", "sphere"], single=True),
    "disc": needs(["disc"], single=True),
    "spheres without pictures": needs(["sphere"], pictures=False),
    "circles": needs(["evolved_circles_1"], ["isolate"], single=True),
    "circles by companion": needs(["evolved_circles_1"], ["companion"], pictures=False),
    "free circles": needs(["evolved_circles_free_2"], ["companion", "sampled"]),
    "point pairs": needs(["evolved_point_pairs_1"], ["isolate", "companion", "sampled"]),
    "free point pairs": needs(["evolved_point_pairs_free_2"], ["sampled"]),
}


def _units(*extensions: ExtensionSource) -> list[Unit]:
    return [unit for extension in extensions for unit in (*extension.units, extension.main())]


def _generated(name: str) -> list[Unit]:
    return _units(generated_extension(bundled_folder(name), headers()))


def _kernels(algebra: str, tag: str) -> list[Unit]:
    folder = bundled_folder(algebra)
    modules = sorted(file.stem for file in (folder / "kernels").glob("*.c"))
    return _units(*(generated_unit(folder, headers(), module, BY_TAG[tag]) for module in modules))


def _chains(algebra: str) -> list[Unit]:
    rooms = (chains.CLASSES[0], chains.CLASSES[-1])
    names = (*chains.SHARED, "inverse")
    return _units(*(chains.chain_extension(algebra, room, name)[0] for room, name in product(rooms, names)))


def _mechanisms(algebra: str) -> list[Unit]:
    rooms = mechanism_program.CLASSES[:3]
    made = product(rooms, mechanism_program.NAMES)
    return _units(*(mechanisms.program.mechanism_extension(algebra, room, name)[0] for room, name in made))


#: Texts by program: what makes them.
PROGRAMS: dict[str, Callable[[], list[Unit]]] = {
    "specimens of kernels": lambda: _units(extension_source("specimens", list(VARIANTS.values()), PORTABLE + SCALAR)),
    **{f"kernels of {a} for f64_v3": lambda a=a: _kernels(a, "f64_v3") for a in STOCK},
    **{f"kernels of pga3d for {tag}": lambda t=tag: _kernels("pga3d", t) for tag in ("f64_v4", "f32_v4")},
    "kernels of pga3d for f32_base": lambda: _kernels("pga3d", "f32_base"),  # other numbers, the same text
    **{f"table of {name}": lambda name=name: _generated(name) for name in STOCK},
    **{name: lambda name=name: _generated(name) for name in ("general", "merge", "reform")},
    **{f"scene, {name}": lambda s=s: _units(scene_program(s).extension()) for name, s in SCENES.items()},
    "scene in one text": lambda: _units(replace(scene_program(SCENES["point pairs"]), parts=()).extension()),
    **{f"chains of {a}": lambda a=a: _chains(a) for a in chains.ALGEBRAS},
    **{f"mechanisms of {a}": lambda a=a: _mechanisms(a) for a in mechanism_program.ALGEBRAS},
}  # fmt: skip


def warnings_of(units: Iterable[Unit], folder: Path, options: Sequence[str] = ("-O1",)) -> str:
    """What the compiler says of some texts, at a level at which it looks into functions."""
    chosen = compiler()
    assert chosen is not None
    said = ""
    for unit in units:
        for name, text in {**unit.headers, "unit.c": unit.source}.items():
            path = folder / name
            path.parent.mkdir(exist_ok=True)
            path.write_text(text, encoding="utf-8")
        own = [option for option in unit.options if not option.startswith("-O")]
        command = [*chosen.command, *C_FLAGS, *own, *options, *WARNING_FLAGS, "-c", "unit.c", "-o", "unit.o"]
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
        assert bool(done.returncode) == bool(done.stderr)
        said += done.stderr[:2000]
    return said
