"""docs/algebra/export.md as a stranger follows it: its commands, its programs, and what they print."""

from __future__ import annotations

import re
import shlex
import shutil
import subprocess
from pathlib import Path

import pytest

from bladesmith.cli.main import run

from ...support.checkout import CHECKOUT

PAGE = CHECKOUT / "docs" / "algebra" / "export.md"
URDF = CHECKOUT / "runtime" / "kinematics" / "urdf" / "data" / "arm.urdf"
#: Languages of the page's blocks, the file of each program, and what must be there to run it.
PROGRAMS = {
    "c": ("main.c", "cc"), "cpp": ("main.cpp", "c++"), "rust": ("main.rs", "rustc"), "js": ("main.mjs", "node"),
    "glsl": ("main.glsl", "glslangValidator"),
}  # fmt: skip


def projects() -> list[tuple[str, str, list[str], str]]:
    """Of each program of the page: its language and text, its commands, and what the last one prints."""
    blocks = re.findall(r"^```(\w+)\n(.*?)^```", PAGE.read_text("utf-8"), re.MULTILINE | re.DOTALL)
    found = []
    for k, (language, text) in enumerate(blocks):
        if language not in PROGRAMS:
            continue
        before = blocks[k - 1][1] if blocks[k - 1][0] == "console" and language == "c" else ""
        lines = (before + blocks[k + 1][1]).splitlines()
        commands = [line.removeprefix("$ ") for line in lines if line.startswith("$ ")]
        found.append((language, text, commands, "\n".join(line for line in lines if not line.startswith("$ "))))
    return found


@pytest.mark.slow
@pytest.mark.parametrize("project", projects(), ids=lambda p: f"{p[0]}_{p[2][0].split()[2].partition('.')[0]}")
def test_projects_of_the_guide_compile_and_run(
    project: tuple[str, str, list[str], str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    language, text, (export, command), printed = project
    file, tool = PROGRAMS[language]
    if not shutil.which(tool):
        pytest.skip(f"no {tool}")
    monkeypatch.chdir(tmp_path)
    shutil.copy(URDF, "robot.urdf")
    assert run(shlex.split(export)[1:]) == 0
    Path(file).write_text(text)
    if tool in ("cc", "c++"):
        command = command.replace(tool, f"{tool} -Wall -Wextra -Werror", 1)
    found = subprocess.run(command, shell=True, check=True, capture_output=True, text=True)
    assert found.stdout.strip() == printed


def test_the_guide_has_a_project_of_each_language() -> None:
    assert {project[0] for project in projects()} == set(PROGRAMS) and len(projects()) == len(PROGRAMS) + 1


@pytest.mark.slow
def test_the_file_of_the_tutorial_compiles_and_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    text = (CHECKOUT / "docs" / "algebra" / "tutorial.md").read_text("utf-8")
    monkeypatch.chdir(tmp_path)
    (kernel,) = re.findall(r"^```python\n(from bladesmith import vga3d.*?)^```", text, re.MULTILINE | re.DOTALL)
    (export,) = re.findall(r"^turn\.export\(.*?\)", text, re.MULTILINE)
    exec(f"import numpy as np\nfrom bladesmith import codegen\n{kernel}\n{export}", {})
    (program,) = re.findall(r"^```c\n(.*?)^```", text, re.MULTILINE | re.DOTALL)
    ((line, printed),) = re.findall(r"^\$ (cc .*?) && \./a\.out\n(.*)", text, re.MULTILINE)
    Path("main.c").write_text(program)
    subprocess.run([*shlex.split(line), "-Wall", "-Wextra", "-Werror"], check=True)
    assert subprocess.run(["./a.out"], check=True, capture_output=True, text=True).stdout.strip() == printed
