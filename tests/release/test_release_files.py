"""What a release consists of beside the package: one version everywhere, changes, citation, workflows, the recipe."""

from __future__ import annotations

import re
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path

import jinja2
import pytest

import bladesmith
from bladesmith.codegen.version import SITE

from ..support.checkout import CHECKOUT

DECLARED = tomllib.loads((CHECKOUT / "pyproject.toml").read_text(encoding="utf-8"))
PROJECT, BUILD = DECLARED["project"], DECLARED["build-system"]
WORKFLOWS = sorted((CHECKOUT / ".github" / "workflows").glob("*.yml"))
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


@pytest.mark.peers
def test_the_recipe_renders() -> None:
    yaml = pytest.importorskip("yaml")

    def load_file_regex(path: str, pattern: str, from_recipe_dir: bool) -> re.Match[str] | None:
        assert from_recipe_dir
        return re.search(pattern, (CHECKOUT / "packaging" / "conda" / path).read_text(encoding="utf-8"))

    toolchain = {name: lambda language, name=name: f"{name}_{language}" for name in ("compiler", "stdlib")}
    names = {"PYTHON": "python", "target_platform": "osx-arm64", "load_file_regex": load_file_regex, **toolchain}
    recipe = yaml.safe_load(jinja2.Environment(undefined=jinja2.StrictUndefined).from_string(RECIPE).render(names))
    order = ["package", "source", "build", "requirements", "test", "about", "extra"]
    assert list(recipe) == order and list(recipe["requirements"]) == ["build", "host", "run"]
    assert recipe["package"] == {"name": PROJECT["name"], "version": bladesmith.__version__}
    assert "-m pip install . " in recipe["build"]["script"] and "pip check" in recipe["test"]["commands"]
    assert set(BUILD["requires"]) <= {need.replace(" ", "") for need in recipe["requirements"]["host"]}
    assert recipe["about"]["license"] == PROJECT["license"] and (CHECKOUT / recipe["about"]["license_file"]).exists()
    assert [recipe["about"][key] for key in ("home", "doc_url")] == [
        PROJECT["urls"][key] for key in ("Homepage", "Documentation")
    ]


def test_the_address_of_the_site_and_its_pages() -> None:
    assert PROJECT["urls"]["Documentation"] == SITE
    named = [
        name
        for folder in ("runtime", "codegen")
        for path in (CHECKOUT / folder).rglob("*.py")
        for line in path.read_text(encoding="utf-8").splitlines()
        if "site_page(" in line or "@options.command(" in line
        for name in re.findall(r"""["']([a-z_]+/[a-z_]+|index)["']\)""", line)
    ]
    assert len(named) >= 14
    assert all((CHECKOUT / "docs" / f"{name}.md").exists() for name in named)


@pytest.mark.parametrize("path", WORKFLOWS, ids=lambda p: p.stem)
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
