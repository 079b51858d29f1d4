"""The command: help, exit statuses, one line per error, and what the doctor says."""

import json
import os
import subprocess
import sys
import sysconfig
from pathlib import Path
from types import ModuleType

import click
import pytest

from bladesmith.cli import doctor, main
from bladesmith.codegen import build, cache, version
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
needs_compiler = pytest.mark.skipif(build.compiler() is None, reason="no C compiler")


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
    module = build.load(build.generated_extension(folder, headers))
    monkeypatch.setattr(doctor, "_extension", lambda name: module)
    assert doctor._freshness(folder, headers) == "3 kernels, compiled from these sources"
    (headers / "scene.h").write_text("/* not included */")
    assert "STALE" not in doctor._freshness(folder, headers)
    (headers / "platform.h").write_text("/* changed */")
    assert "STALE" in doctor._freshness(folder, headers)
    monkeypatch.setattr(doctor, "_extension", lambda name: None)
    assert "not compiled" in doctor._freshness(folder, headers)


@needs_compiler
def test_cache_lists_and_clears(monkeypatch, tmp_path, capsys):
    monkeypatch.setenv(cache.DIRECTORY_VARIABLE, str(tmp_path / "cache"))
    monkeypatch.setattr(build, "_loading", build._Loading())
    assert main.run(["cache"]) == 0
    assert capsys.readouterr().out == f"0 entries, 0.0 kB, in {tmp_path / 'cache'}\n"
    build.load(build.ExtensionSource("listed", "int one(void);", "int one(void) { return 1; }"))
    assert main.run(["cache"]) == 0
    assert "bs_listed_" in capsys.readouterr().out
    assert main.run(["cache", "--clear"]) == 0
    assert "removed 1 " in capsys.readouterr().out
    assert cache.entries() == []


@needs_compiler
def test_verbose_says_what_is_compiled(tmp_path):
    code = (
        "import sys, click; from types import ModuleType; from bladesmith.cli import main\n"
        "from bladesmith.codegen.build import ExtensionSource, load\n"
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
