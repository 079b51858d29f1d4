"""Compilers that optimise less than the package has them do: results have the same bits, and half of the time of tests
was gcc's.

What users get is compiled at install, by `codegen/targets`, of which the compiler's work is the subject, for all
programs by `project/test_ziglang.py`, and everywhere where BLADESMITH_FULL_BARS=1 is set.
"""

from __future__ import annotations

import os
import shlex
from pathlib import Path

from bladesmith.codegen.build.toolchain import compiler

from ..checkout import CHECKOUT, TEST_CACHE
from ..effort import FULL

#: By folder of tests, or module; the last that holds a test counts. Programs of dynamics, kinematics
#: and documentation are many, and run briefly.
LEVELS = {
    "": "-O1", "dynamics": "-O0", "kinematics": "-O0", "project": "-O0", "release": "-O0", "codegen/targets": "",
    "codegen/targets/test_cuda_algorithms.py": "-O0",  # of which C is the reference
}  # fmt: skip
#: What asks for less than the level gets that.
SCRIPT = """#!/bin/sh
for option; do
  shift
  case $option in -O[1-3]) option={level} ;; esac
  set -- "$@" "$option"
done
exec {command} "$@"
"""


def level_of(module: Path) -> str:
    """How much programs of a module of tests are optimised; nothing where it is as the package has it."""
    folder = module.resolve().relative_to(CHECKOUT / "tests")
    return "" if FULL else next(level for name, level in reversed(LEVELS.items()) if folder.is_relative_to(name))


def compiler_at(level: str) -> str | None:
    """The path of one, for the variable CC; None where there is no compiler, or no shell.

    It is always the same, so that what is compiled by it serves the next session too.
    """
    found = compiler()
    if found is None or os.name != "posix":
        return None
    script = Path(TEST_CACHE, "compilers", f"cc{level}")
    if str(script) in found.command:  # it is in use, and must not call itself
        return str(script)
    script.parent.mkdir(parents=True, exist_ok=True)
    part = script.with_name(f"{script.name}.{os.getpid()}")
    part.write_text(SCRIPT.format(command=shlex.join(found.command), level=level))
    part.chmod(0o755)
    part.replace(script)
    return str(script)
