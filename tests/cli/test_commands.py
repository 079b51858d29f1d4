"""The command: help, exit statuses, one line per error, and what is said of compiling."""

import os
import subprocess
import sys
import sysconfig
from pathlib import Path
from types import ModuleType

import click
import pytest

from bladesmith.cli import main
from bladesmith.codegen import version
from bladesmith.codegen.build import cache, extension
from bladesmith.codegen.errors import suggest
from bladesmith.codegen.programs import cga3d
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
