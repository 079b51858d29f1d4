"""The command: help, exit statuses, one line per error, and what the doctor says."""

import json
import os
import subprocess
import sys
import sysconfig
from pathlib import Path
from types import ModuleType
from unittest import mock

import click
import pytest

from bladesmith.cli import demo, doctor, main
from bladesmith.codegen import version
from bladesmith.codegen.build import cache, extension
from bladesmith.codegen.errors import suggest
from bladesmith.codegen.programs import cga3d
from bladesmith.codegen.targets.c.source import ExtensionSource
from bladesmith.errors import (
    BladeError,
    CompileError,
    InputError,
    KindError,
    MissingExtraError,
    SceneError,
    SignatureError,
    SingularError,
    SpecError,
)

PATIENCE = 60.0  # seconds for a process on a busy machine
needs_compiler = pytest.mark.skipif(extension.compiler() is None, reason="no C compiler")


@pytest.fixture
def failing(monkeypatch):
    """A subcommand `fail` that raises what it is told to."""
    module = ModuleType("bladesmith.cli.fail")
    raised: list[BaseException] = []

    @click.command()
    @click.option("--times", type=int)
    def command(times):
        raise raised[0]

    module.command = command
    monkeypatch.setitem(sys.modules, module.__name__, module)
    monkeypatch.setitem(main.COMMANDS, "fail", "Fail.")
    return raised


@pytest.mark.parametrize("name", list(main.COMMANDS))
def test_every_subcommand_has_help_with_an_example(name, capsys):
    assert main.run([name, "--help"]) == 0
    out = capsys.readouterr().out
    assert f"bladesmith {name}" in out and "Example" in out
    assert main.run([name, "-h"]) == 0


def test_help_lists_every_subcommand(capsys):
    assert main.run(["--help"]) == 0
    out = capsys.readouterr().out
    assert all(f"\n  {name} " in out for name in main.COMMANDS)


def test_the_package_runs_as_a_module():
    done = subprocess.run(
        [sys.executable, "-m", "bladesmith", "--version"], capture_output=True, text=True, timeout=PATIENCE
    )
    assert (done.returncode, done.stdout) == (0, f"bladesmith, version {version.__version__}\n")


def test_suggestions_stand_anywhere_in_a_sentence():
    assert suggest("moter", ["motor", "line"]) == " (did you mean 'motor'?)" and suggest("x", ["motor"]) == ""
    with pytest.raises(KindError, match=r"kind 'moter' \(did you mean 'motor'\?\); it has: "):
        cga3d().kind("moter")
    with pytest.raises(BladeError, match=r"of cga3d \(did you mean 'e12'\?\); its vectors are "):
        cga3d().parse_blade("e1x2")


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["--signature", ""], "three integers"),
        (["--signature", "0,0,0"], "without vectors"),
        (["--signature", "2,0,0", "--name", ""], "--name is empty"),
        (["--name", "mine"], "--name goes with --signature"),
        (["--spec", "", "--signature", "2,0,0"], "exclude each other"),
    ],
)
def test_empty_options_of_generate_are_not_taken_as_missing(arguments, says, tmp_path, capsys):
    assert main.run(["generate", *arguments, "--out", str(tmp_path / "made")]) == 2
    assert says in capsys.readouterr().err
    assert not (tmp_path / "made").exists()


def test_a_signature_says_what_it_leaves_out(tmp_path, capsys):
    assert main.run(["generate", "--signature", "2,0,0", "--out", str(tmp_path)]) == 0
    wrote, *left_out = capsys.readouterr().out.splitlines()
    assert wrote.startswith("wrote ") and "  no kinds trivector, quadvector: grades go to 2" in left_out
    assert "rotor" in left_out[-1] and "bladesmith.vga2d has them" in left_out[-1]


def test_pipes_and_logs_get_no_progress_bars(tmp_path, capsys):
    assert main.run(["generate", "--signature", "1,0,0", "--out", str(tmp_path)]) == 0
    assert capsys.readouterr().err == ""


def test_version(capsys):
    assert main.run(["--version"]) == 0
    assert capsys.readouterr().out == f"bladesmith, version {version.__version__}\n"


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        ([], "Usage"),
        (["rendr"], "did you mean 'render'?"),
        (["doctor", "--jsn"], "--json"),
        (["doctor", "extra"], "extra"),
        (["fail", "--times", "many"], "many"),
        (["--nonsense"], "--nonsense"),
    ],
)
def test_bad_arguments_exit_with_2(arguments, says, failing, capsys):
    assert main.run(arguments) == 2
    assert says in capsys.readouterr().err


@pytest.mark.parametrize(
    ("error", "status", "line"),
    [
        (SceneError("surfaces[2].radius is -0.4; a radius is positive.", where="tube.toml, line 14"), 2,
         "SceneError: tube.toml, line 14: surfaces[2].radius is -0.4; a radius is positive."),
        (SpecError("x"), 2, "SpecError: x"),
        (SignatureError("x"), 2, "SignatureError: x"),
        (InputError("x"), 2, "InputError: x"),
        (KindError("x"), 2, "KindError: x"),
        (BladeError("x"), 2, "BladeError: x"),
        (SingularError("x"), 1, "SingularError: x"),
        (CompileError("two\nlines"), 1, "CompileError: two lines"),
        (MissingExtraError("plot", "Saving images"), 1,
         "MissingExtraError: Saving images needs the extra 'plot'. Run: pip install 'bladesmith[plot]'"),
        (click.ClickException("failed"), 1, "Error: failed"),
        (PermissionError(13, "Permission denied", "image.png"), 1, "image.png: Permission denied"),
        (ZeroDivisionError("division by zero"), 1,
         "internal error: ZeroDivisionError: division by zero. `bladesmith --debug ...` shows where."),
        (KeyboardInterrupt(), 130, "interrupted"),
    ],
    ids=lambda value: type(value).__name__ if isinstance(value, BaseException) else "",
)  # fmt: skip
def test_errors_become_a_status_and_one_line(error, status, line, failing, capsys):
    failing.append(error)
    assert main.run(["fail"]) == status
    captured = capsys.readouterr()
    assert captured.err.strip() == line
    assert captured.out == ""


def test_debug_shows_the_traceback(failing, capsys):
    failing.append(SpecError("x"))
    assert main.run(["--debug", "fail"]) == 2
    err = capsys.readouterr().err
    assert "Traceback" in err and err.endswith("SpecError: x\n")


def test_a_status_chosen_by_a_subcommand_is_kept(failing):
    failing.append(click.exceptions.Exit(1))
    assert main.run(["fail"]) == 1


def test_main_leaves_the_process_with_the_status(failing):
    failing.append(SpecError("x"))
    with pytest.raises(SystemExit) as left:
        main.main(["fail"])
    assert left.value.code == 2


def test_installed_command_is_quick_and_imports_little():
    """The script itself runs; help needs neither NumPy's friends nor a subcommand."""
    script = Path(sysconfig.get_path("scripts")) / "bladesmith"
    done = subprocess.run([script, "--version"], capture_output=True, text=True, timeout=PATIENCE)
    assert (done.returncode, done.stderr) == (0, "")
    code = (
        "import sys; from bladesmith.cli.main import run; status = run(['--help'])\n"
        "heavy = {'sympy', 'jinja2', 'numba', 'pydantic', 'matplotlib', 'bladesmith.cli.doctor'}\n"
        "heavy &= set(sys.modules)\n"
        "sys.exit(f'imported {heavy}' if heavy else status)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=PATIENCE)
    assert (done.returncode, done.stderr) == (0, "")


def test_doctor(capsys):
    assert main.run(["doctor"]) == 0
    out = capsys.readouterr().out
    assert all(f"{title}:" in out for title in doctor.SECTIONS)
    assert str(cache.directory()) in out and version.__version__ in out


def test_doctor_as_json(capsys):
    assert main.run(["doctor", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert list(found) == list(doctor.SECTIONS)
    assert all(isinstance(value, str) for facts in found.values() for value in facts.values())
    assert not any("failed" in facts for facts in found.values()), found


def test_doctor_on_a_bare_machine(capsys, monkeypatch, tmp_path):
    """No compiler, no cache to write to, and a section that fails: still a report and status 0."""
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("CC", "/nonexistent")
    monkeypatch.setenv(cache.DIRECTORY_VARIABLE, str(tmp_path / "file" / "cache"))
    monkeypatch.setattr(doctor, "find_spec", lambda name: None)
    monkeypatch.setattr(doctor.nvrtc, "_library", mock.Mock(side_effect=MissingExtraError("cuda", "Compiling")))
    monkeypatch.setitem(doctor.SECTIONS, "processor", lambda: 1 / 0)
    assert main.run(["doctor"]) == 0
    out = capsys.readouterr().out
    for part in ["CC='/nonexistent' does not run", "not writable", "bladesmith[numba]", "bladesmith[cuda]"]:
        assert part in out
    assert "ZeroDivisionError" in out


@needs_compiler
def test_doctor_tells_fresh_from_stale(monkeypatch, tmp_path):
    folder, headers = tmp_path / "tiny2d", tmp_path / "c"
    folder.mkdir()
    headers.mkdir()
    (headers / "platform.h").write_text("")
    (folder / "kernels.cdef").write_text("const char *bs_source_hash(void); int bs_kernel_count(void);")
    (folder / "kernels.c").write_text(
        '#include "platform.h"\n'
        "const char *bs_source_hash(void) { return BS_SOURCE_HASH; }\n"
        "int bs_kernel_count(void) { return 3; }\n"
    )
    module = extension.load(extension.generated_extension(folder, headers))
    monkeypatch.setattr(doctor, "_extension", lambda name: module)
    assert doctor._freshness(folder, headers) == "3 kernels, compiled from these sources"
    (headers / "scene.h").write_text("/* not included */")
    assert "STALE" not in doctor._freshness(folder, headers)
    (headers / "platform.h").write_text("/* changed */")
    assert "STALE" in doctor._freshness(folder, headers)
    monkeypatch.setattr(doctor, "_extension", lambda name: None)
    assert "compiled at first use" in doctor._freshness(folder, headers)


@needs_compiler
def test_cache_lists_and_clears(monkeypatch, tmp_path, capsys):
    monkeypatch.setenv(cache.DIRECTORY_VARIABLE, str(tmp_path / "cache"))
    monkeypatch.setattr(extension, "_loading", extension._Loading())
    assert main.run(["cache"]) == 0
    assert capsys.readouterr().out == f"0 entries, 0.0 kB, in {tmp_path / 'cache'}\n"
    extension.load(ExtensionSource("listed", "int one(void);", "int one(void) { return 1; }"))
    assert main.run(["cache"]) == 0
    assert "bs_listed_" in capsys.readouterr().out
    assert main.run(["cache", "--clear"]) == 0
    assert "removed 1 " in capsys.readouterr().out
    assert cache.entries() == []


def test_a_cache_that_is_a_file_is_told(monkeypatch, tmp_path, capsys):
    (tmp_path / "file").write_text("")
    monkeypatch.setenv(cache.DIRECTORY_VARIABLE, str(tmp_path / "file"))
    for arguments in (["cache"], ["cache", "--clear"]):
        assert main.run(arguments) == 2
        assert cache.DIRECTORY_VARIABLE in capsys.readouterr().err


@pytest.mark.compiles
def test_the_demo_renders_the_scene_as_it_is_shown(tmp_path):
    from PIL import Image

    said = demo.parts.render_part(demo.parts.Page(tmp_path, 48), 1, shows_bars=True)
    with Image.open(tmp_path / "scene.png") as picture:
        assert picture.size == (48, 32) and said.startswith("48 x 32 pixels")  # 768 x 512, smaller


def interrupt(*_):
    raise KeyboardInterrupt


@pytest.mark.compiles
def test_a_folder_that_cannot_be_made_is_bad_input(tmp_path, capsys):
    (tmp_path / "file").touch()
    assert main.run(["demo", "-o", str(tmp_path / "file" / "d"), "--quiet"]) == main.BAD_INPUT
    assert "cannot be written: Not a directory" in capsys.readouterr().err


def test_the_demo_keeps_what_was_done_before_an_interrupt(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(demo.parts, "compile_part", interrupt)
    assert main.run(["demo", "-o", str(tmp_path / "d"), "--width", "48", "--quiet"]) == main.INTERRUPTED
    page = (tmp_path / "d" / "index.html").read_text()
    assert (tmp_path / "d" / "scene.png").exists() and 'src="scene.png"' in page
    assert "48 x 32 pixels" in page and "was interrupted" in page and "objects.png" not in page
    assert "index.html" in capsys.readouterr().err


@pytest.mark.compiles
def test_the_formula_of_the_demo_is_what_the_page_says():
    from bladesmith.benchmarks.harness.compilation import blend, compile_blend

    made = compile_blend()
    assert made.formula.splitlines()[1] == "def blend(x, y, alpha):" and "type:" not in made.formula
    assert f"blend {made.operations.multiplications} mul" in made.source
    assert made.kind == "circle" and blend.traced.outputs[0].kind.name == "circle"
    assert 0 < made.error < 1e-14


def small_study(name, run=lambda inputs, setting: inputs):
    import numpy as np

    from bladesmith.benchmarks.harness.study import Case, Method, Study

    case = Case("numbers", lambda rng, count: rng.normal(size=count))
    return Study(name, name, (Method("itself", run),), (case,), lambda x: x, lambda a, b, _: np.abs(a - b), "units")


@pytest.mark.slow
def test_a_report_says_first_how_long_it_takes_and_keeps_each_study(tmp_path, capsys, monkeypatch):
    from bladesmith.benchmarks import registry
    from bladesmith.benchmarks.harness import write

    studies = {"one": small_study("one"), "two": small_study("two", interrupt)}
    entries = {"one": registry.Entry("one", 40, 4), "two": registry.Entry("two", 200, 20)}
    monkeypatch.setattr(write, "load_study", studies.__getitem__)
    monkeypatch.setattr(registry, "STUDIES", entries)
    assert main.run(["report", "-o", str(tmp_path)]) == main.INTERRUPTED
    said = capsys.readouterr()
    first, second = said.out.splitlines()
    assert first == "2 studies, about 4 min on two cores"
    assert second.startswith("one: 1 measurements") and second.endswith("1 left, about 3 min")
    assert f"1 of 2 studies are in {tmp_path / 'index.html'}" in said.err
    assert list(json.loads((tmp_path / "report.json").read_text())["studies"]) == ["one"]
    assert (tmp_path / "one.png").exists() and 'src="one.png"' in (tmp_path / "index.html").read_text()


def test_an_unknown_study_is_refused_before_any_is_run(tmp_path, capsys):
    assert main.run(["report", "-o", str(tmp_path / "r"), "--study", "products", "--study", "distanc"]) == 2
    assert "distance" in capsys.readouterr().err and not (tmp_path / "r").exists()


@pytest.mark.slow
def test_a_report_measures_each_study_once_and_not_where_nothing_can_be_written(tmp_path, capsys, monkeypatch):
    from bladesmith.benchmarks import registry
    from bladesmith.benchmarks.harness import write

    measured = []
    studies = {"one": small_study("one", lambda x, setting: measured.append(1) or x)}
    monkeypatch.setattr(write, "load_study", studies.__getitem__)
    monkeypatch.setattr(registry, "load_study", studies.__getitem__)
    monkeypatch.setattr(registry, "STUDIES", {"one": registry.Entry("one", 40, 4)})
    (tmp_path / "file").write_text("")
    assert main.run(["report", "-o", str(tmp_path / "file" / "r"), "--study", "one"]) == 2
    assert not measured and f"{tmp_path / 'file' / 'r'}: cannot be written: Not a directory" in capsys.readouterr().err
    assert main.run(["report", "-o", str(tmp_path / "r"), "--study", "one", "--study", "one"]) == 0
    assert measured and capsys.readouterr().out.startswith("1 study, about ")


def test_every_study_says_how_long_it_takes():
    from bladesmith.benchmarks.harness.runner import duration_text
    from bladesmith.benchmarks.registry import STUDIES, expected_seconds

    assert set(demo.parts.DEMO_STUDIES) <= set(STUDIES)
    assert all(0 < entry.quick_seconds <= entry.seconds for entry in STUDIES.values())
    assert expected_seconds(demo.parts.DEMO_STUDIES, quick=True) < 45
    assert [duration_text(s) for s in (1, 42, 99, 100, 1790)] == ["5 s", "40 s", "100 s", "2 min", "30 min"]


def test_plots_tell_errors_from_losses_and_keep_labels_apart(tmp_path):
    from bladesmith.benchmarks.harness import plot
    from bladesmith.benchmarks.harness.runner import Measurement
    from bladesmith.benchmarks.harness.study import Case, Study

    def row(setting, error, lost, time):
        return Measurement("m", "n", setting, "c", "ordinary", 10, error, "", lost, "", time, "")

    rows = [row("8", 1e-2, 9, 400.0), row("16", 9e-3, 1, 410.0), row("32", 1e-9, 0, 420.0), row("64", 0.0, 3, 900.0)]
    study = Study("s", "S", (), (Case("c", lambda rng, n: None),), lambda x: x, lambda a, b, c: a, "units")
    figure = plot.draw(study, rows)
    panel = figure.axes[0]
    crosses = [line for line in panel.lines if line.get_marker() == "x"]
    assert [line.get_ydata()[0] for line in crosses] == [plot.LOST_HEIGHT]
    boxes = [text.get_window_extent() for text in panel.texts]
    frame = panel.get_window_extent()
    assert [text.get_text() for text in panel.texts] == ["8 (9 lost)", "16 (1 lost)", "32", "64 (3 lost)"]
    assert not any(a.overlaps(b) for i, a in enumerate(boxes) for b in boxes[:i])
    assert all(frame.x0 <= b.x0 and b.x1 <= frame.x1 and frame.y0 <= b.y0 and b.y1 <= frame.y1 for b in boxes)
    assert any("lost, no error" in text.get_text() for text in figure.legends[0].get_texts())


@pytest.mark.compiles
@needs_compiler
def test_verbose_says_what_is_compiled(tmp_path):
    code = (
        "import sys, click; from types import ModuleType; from bladesmith.cli import main\n"
        "from bladesmith.codegen.build.extension import load\n"
        "from bladesmith.codegen.targets.c.source import ExtensionSource\n"
        "module = ModuleType('bladesmith.cli.work'); main.COMMANDS['work'] = ''\n"
        "sys.modules[module.__name__] = module\n"
        "source = ExtensionSource('worked', 'int one(void);', 'int one(void) { return 1; }')\n"
        "module.command = click.Command('work', callback=lambda: load(source))\n"
        "main.main(sys.argv[1:])"
    )
    for arguments, says in [(["work"], False), (["-v", "work"], True)]:
        environment = {**os.environ, cache.DIRECTORY_VARIABLE: str(tmp_path / arguments[0])}
        done = subprocess.run(
            [sys.executable, "-c", code, *arguments], capture_output=True, text=True, env=environment,
            timeout=PATIENCE,
        )  # fmt: skip
        assert done.returncode == 0
        assert ("compiled worked in" in done.stderr) == says
