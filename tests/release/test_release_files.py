"""What a release consists of beside the package: one version everywhere, changes, citation, workflows, the recipe."""

from __future__ import annotations

import re
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path

import pytest

import bladesmith

from ..support.checkout import CHECKOUT

PROJECT = tomllib.loads((CHECKOUT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
RECIPE = (CHECKOUT / "packaging" / "conda" / "meta.yaml").read_text(encoding="utf-8")


def test_the_version_is_the_same_everywhere() -> None:
    (cited,) = re.findall(r"^version: (\S+)$", (CHECKOUT / "CITATION.cff").read_text(encoding="utf-8"), re.M)
    newest = re.findall(r"^## (\S+)", (CHECKOUT / "CHANGELOG.md").read_text(encoding="utf-8"), re.M)[0]
    assert bladesmith.__version__ == cited == newest


def test_the_recipe_needs_what_the_package_needs() -> None:
    (run,) = re.findall(r"^  run:\n((?:    - .*\n)+)", RECIPE, re.M)
    there = {line.split("- ")[1].replace(" ", "") for line in run.splitlines()}
    assert there == {*PROJECT["dependencies"], f"python{PROJECT['requires-python']}"}
    pattern = re.search(r"load_file_regex\(\"(\S+)\", '(.+?)'", RECIPE)
    assert pattern is not None
    file = CHECKOUT / "packaging" / "conda" / pattern[1]
    assert re.findall(pattern[2], file.read_text(encoding="utf-8")) == [bladesmith.__version__]


@pytest.mark.parametrize("path", sorted((CHECKOUT / ".github" / "workflows").glob("*.yml")), ids=lambda p: p.stem)
def test_workflows_run_what_is_there(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    for command in re.findall(r"run: (.+)", text):
        for word in command.split():
            if word.startswith((".ci/", "packaging/")):
                assert (CHECKOUT / word).exists(), word
    served = [c.split(" :: ")[-1] for c in PROJECT["classifiers"] if re.search(r"3\.\d+$", c)]
    for listed in re.findall(r"python: \[(.+)\]", text):
        assert set(re.findall(r"[\d.]+", listed)) <= set(served)


def test_links_of_the_files_lead_somewhere() -> None:
    for name in ("CONTRIBUTING.md", "SECURITY.md", "CHANGELOG.md"):
        for link in re.findall(r"\]\((?!https?:)([^)#]+)\)", (CHECKOUT / name).read_text(encoding="utf-8")):
            assert (CHECKOUT / link).exists(), link


@pytest.mark.parametrize(
    ("names", "said"),
    [
        (["bladesmith/tests/test_x.py", "bladesmith/_kernels.so"], "nobody needs"),
        (["bladesmith/__init__.py"], "no compiled kernels"),
    ],
)
def test_wheels_that_are_not_to_be_shipped_are_refused(names: list[str], said: str, tmp_path: Path) -> None:
    wheel = tmp_path / "bladesmith-0-py3-none-any.whl"
    with zipfile.ZipFile(wheel, "w") as opened:
        for name in names:
            opened.writestr(name, "")
    command = [sys.executable, str(CHECKOUT / "packaging" / "check_wheel.py"), str(wheel)]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 1 and said in done.stderr


@pytest.mark.slow
def test_what_is_installed_runs_the_first_snippet_without_a_compiler() -> None:
    command = [sys.executable, str(CHECKOUT / "packaging" / "check_wheel.py"), "--installed"]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
