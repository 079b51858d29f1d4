"""Only what has changed is generated again, and what has changed is noticed."""

from __future__ import annotations

import ast
import gc
import json
import tracemalloc
from collections.abc import Iterator
from importlib import resources
from pathlib import Path
from typing import Any

import pytest

from bladesmith import cga3d as cga
from bladesmith import codegen
from bladesmith.cli.main import run
from bladesmith.codegen import generator
from bladesmith.codegen.build import formula_digest as dependencies
from bladesmith.codegen.build import source_digest
from bladesmith.codegen.build.formula_digest import formula_digest
from bladesmith.codegen.build.stamps import STAMPS, generated_files, read_stamps
from bladesmith.codegen.declarations import plain_spec
from bladesmith.codegen.formulas.objects.blades import blade_projector
from bladesmith.codegen.generator import generate, outdated_modules
from bladesmith.codegen.optimise.variants import variants

from .. import conftest

GENERATED = Path(str(resources.files("bladesmith.generated")))
SPEC = {
    **plain_spec(2, 0, 1, "plane"),
    "kernels": [
        {"formula": "products.outer", "operands": [["vector", "vector"]]},
        {"formula": "versors.normalise", "operands": [["vector"]]},
    ],
}


class Edited:
    """The package's files, some of them with other text."""

    def __init__(self) -> None:
        self.texts: dict[str, str] = {}
        self.read = source_digest.text_of

    def __call__(self, name: str) -> str:
        return self.texts.get(name) or self.read(name)

    def replace(self, name: str, old: str, new: str) -> None:
        text = self(name)
        assert old in text
        self.texts[name] = text.replace(old, new)
        dependencies._module.cache_clear()


@pytest.fixture
def edited(monkeypatch: pytest.MonkeyPatch) -> Iterator[Edited]:
    files = Edited()
    monkeypatch.setattr(dependencies, "text_of", files)
    dependencies._module.cache_clear()
    yield files
    dependencies._module.cache_clear()


@pytest.fixture
def traced(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Names of the kernels that the generator traces."""
    names: list[str] = []
    trace = generator.trace_kernel

    def noted(formula: Any, kinds: Any, name: str, **more: Any) -> Any:
        names.append(name)
        return trace(formula, kinds, name, **more)

    monkeypatch.setattr(generator, "trace_kernel", noted)
    return names


def test_a_change_reaches_the_formulas_that_use_it_and_no_others(edited: Edited) -> None:
    names = ("rotors.rotor_between", "costs.pair_cost", "blades.project_to_blade", "products.geometric")
    before = [formula_digest(name) for name in names]
    edited.replace("formulas/motions/rotors.py", "h0 = 1 + p0", "h0 = 1 - p0")
    after = [formula_digest(name) for name in names]
    assert [a == b for a, b in zip(before, after, strict=True)] == [False, False, True, True]


def test_constants_and_what_stands_beside_definitions_count(edited: Edited) -> None:
    before = formula_digest("exponentials.exp_bivector"), formula_digest("products.geometric")
    extra = "EXTRA = 1\nif EXTRA:\n    NOISE = EXTRA\n\n\ndef size("
    edited.replace("formulas/products/outcome.py", "def size(", extra)
    assert formula_digest("exponentials.exp_bivector") != before[0]
    assert formula_digest("products.geometric") == before[1]


def test_comments_and_layout_do_not_count(edited: Edited) -> None:
    before = formula_digest("rotors.rotor_between")
    edited.replace("formulas/motions/rotors.py", "h0 = 1 + p0", "# a remark\n    h0 = (\n        1 + p0\n    )")
    assert formula_digest("rotors.rotor_between") == before


def test_outdated_files_are_named_by_folder_and_module(edited: Edited) -> None:
    assert outdated_modules(GENERATED) == []
    edited.replace("formulas/motions/rotors.py", "h0 = 1 + p0", "h0 = 1 - p0")
    stale = outdated_modules(GENERATED)
    assert {"cga3d/rotors", "cga3d/costs", "merge/costs.pair_cost"} <= set(stale)
    assert not [name for name in stale if name.startswith(("pga3d", "scene"))]


def test_algorithms_of_programs_count(edited: Edited) -> None:
    edited.replace("algorithms/cost_queue.py", "beside = min(below + 1, size - 1)", "beside = below")
    assert outdated_modules(GENERATED) == ["merge/algorithms/cost_queue.py"]


def test_check_names_outdated_modules_and_traces_nothing(
    edited: Edited, traced: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    edited.replace("formulas/motions/rotors.py", "h0 = 1 + p0", "h0 = 1 - p0")
    assert run(["generate", "--check", "--quiet"]) == 1
    said = capsys.readouterr().out
    assert "cga3d" in said and "bladesmith generate --update" in said and traced == []


def test_doctor_and_the_tests_say_what_to_run(edited: Edited, capsys: pytest.CaptureFixture[str]) -> None:
    conftest.refuse_outdated()
    edited.replace("formulas/motions/rotors.py", "h0 = 1 + p0", "h0 = 1 - p0")
    with pytest.raises(pytest.UsageError, match=r"cga3d/rotors(?s:.*)bladesmith generate --update"):
        conftest.refuse_outdated()
    assert run(["doctor"]) == 0
    said = capsys.readouterr().out
    assert "NEWER than the generated texts: " in said and "cga3d/rotors, " in said and "generate --update" in said


def test_what_is_up_to_date_is_not_traced(traced: list[str]) -> None:
    files = generate(SPEC)
    assert sorted(traced) == ["normalise_vector", "outer_vector_vector"]
    traced.clear()
    assert generate(SPEC, kept=files) == files
    assert traced == []


def test_only_modules_that_changed_are_traced(edited: Edited, traced: list[str]) -> None:
    files = generate(SPEC)
    traced.clear()
    edited.replace("formulas/products/versors.py", "def normalise(", "PLUS = 0\n\n\ndef normalise(")
    assert generate(SPEC, kept=files) == files  # nothing that normalise reaches
    edited.replace("formulas/products/versors.py", "PLUS = 0", "if True:\n    PLUS = 0")
    again = generate(SPEC, kept=files)
    assert traced == ["normalise_vector"]
    assert {name for name in files if again[name] != files[name]} == {STAMPS}


def test_an_edited_or_missing_file_is_made_again(traced: list[str]) -> None:
    files = generate(SPEC)
    for change in ({"kernels/products.c": "int x;"}, {"manifest.json": "{}"}, {STAMPS: "{"}, {STAMPS: "[]"}):
        assert generate(SPEC, kept={**files, **change}) == files
    without = {name: text for name, text in files.items() if name != "kernels/versors.py"}
    assert read_stamps(without).modules == {} and generate(SPEC, kept=without) == files


def test_a_recorded_form_serves_the_same_nodes_only(monkeypatch: pytest.MonkeyPatch) -> None:
    files = generate(SPEC)
    records = json.loads(files["variants.json"])
    given: list[Any] = []
    optimise = generator.optimise_kernel

    def noting(kernel: Any, record: Any, *options: Any) -> Any:
        given.append(record)
        return optimise(kernel, record, *options)

    monkeypatch.setattr(generator, "optimise_kernel", noting)
    assert generate(SPEC, records) == files
    assert all(record is not None for record in given)
    given.clear()
    other = {name: {**record, "traced": "of another formula"} for name, record in records.items()}
    assert generate(SPEC, other) == files
    assert given == [None, None]


def test_processes_make_the_same_files() -> None:
    assert generate(SPEC, processes=2) == generate(SPEC)


def test_the_command_writes_what_changed_and_nothing_else(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    def generated(*options: str) -> str:
        status = run(
            ["generate", "--signature", "2,0,0", "--name", "flat", "--out", str(tmp_path), "--quiet", *options]
        )
        return f"{status} {''.join(capsys.readouterr())}"

    assert generated("--update").startswith("0 wrote")
    files = generated_files(tmp_path / "flat")
    times = {path: path.stat().st_mtime_ns for path in (tmp_path / "flat").rglob("*") if path.is_file()}
    assert generated("--update") == "0 " and generated("--check") == "0 generated files are up to date\n"
    assert {path: path.stat().st_mtime_ns for path in times} == times
    (tmp_path / "flat/kernels/products.c").write_text("")
    (tmp_path / "flat/kernels/gone.c").write_text("")
    said = generated("--check")
    assert said.startswith("1 ") and "products.c" in said and "gone.c" in said and "--update" in said
    assert generated("--update").startswith("0 wrote")
    assert generated_files(tmp_path / "flat") == files
    assert "give it without" in generated("--update", "--search")


@pytest.mark.slow
def test_a_declared_kernel_keeps_little(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """At most 0.2 MB for each: the sample points of its nodes go once its form is chosen."""

    def declare(i: int) -> Any:
        @codegen.kernel(cga.kind("circle"), cga.kind("circle"), codegen.scalar, name=f"blend{i}")
        def blend(x: Any, y: Any, alpha: Any) -> Any:
            z = alpha * x + (1 - alpha + i) * y
            return blade_projector(z) * z

        assert blend.operations.total > 100
        return blend

    kept = [declare(0)]
    gc.collect()
    tracemalloc.start()
    kept += [declare(i) for i in range(1, 4)]
    gc.collect()
    size, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert size / 3 < 0.2e6, f"{size / 3e6:.2f} MB for each kernel"
    assert peak > 10 * size  # the points were there
    # and a kernel that was released can be searched again

    assert [form.name for form in variants(kept[0].traced)][:2] == ["as_written", "local"]


def test_digests_are_those_of_all_versions_of_python() -> None:
    """Digests are kept in generated folders: `ast.dump` has more fields in Python 3.12, and fewer in 3.13."""
    text = "@d\ndef f(x, *, y=None):\n    return x[:-1] if y else {'a': 1.5}"
    assert dependencies._canonical(ast.parse(text)) == (
        "Module(body=[FunctionDef(name='f', args=arguments(args=[arg(arg='x')], kwonlyargs=[arg(arg='y')], "
        "kw_defaults=[Constant()]), body=[Return(value=IfExp(test=Name(id='y', ctx=Load()), body=Subscript("
        "value=Name(id='x', ctx=Load()), slice=Slice(upper=UnaryOp(op=USub(), operand=Constant(value=1))), "
        "ctx=Load()), orelse=Dict(keys=[Constant(value='a')], values=[Constant(value=1.5)])))], "
        "decorator_list=[Name(id='d', ctx=Load())])])"
    )
