"""docs/algebra/export.md as a stranger follows it: its command, its program, its compiler's line."""

from __future__ import annotations

import re
import shlex
import subprocess
from pathlib import Path

import pytest

from bladesmith.cli.main import run

from ...support.checkout import CHECKOUT

TEXT = (CHECKOUT / "docs" / "algebra" / "export.md").read_text("utf-8")


@pytest.mark.slow
def test_the_project_of_the_guide_compiles_and_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    export, compile_ = (shlex.split(line) for line in re.findall(r"^\$ (.*)", TEXT, re.MULTILINE)[:2])
    assert run(export[1:]) == 0
    (program,) = re.findall(r"^```c\n(.*?)^```", TEXT, re.MULTILINE | re.DOTALL)
    Path("main.c").write_text(program)
    assert compile_[0] == "cc"
    subprocess.run([*compile_, "-Wall", "-Wextra", "-Werror"], check=True)
    printed = subprocess.run(["./a.out"], check=True, capture_output=True, text=True).stdout
    assert [float(text) for text in printed.split()] == [0, 1, 0]


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
