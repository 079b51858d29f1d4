"""Compiling and caching, and what can go wrong: races, kills, damage, no compiler, no room to write."""

import hashlib
import json
import logging
import os
import shutil
import signal
import subprocess
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

import pytest

from bladesmith.codegen.build import cache
from bladesmith.codegen.build import extension as build
from bladesmith.codegen.build.extension import extension_key, generated_extension, load
from bladesmith.codegen.build.flags import compiled_files, source_hash
from bladesmith.codegen.targets.c.source import ExtensionSource
from bladesmith.errors import CompileError, CompilerMissingError, SpecError

from ...support.extension_parts import forget

PATIENCE = 60.0  # seconds a child process may take on a busy machine

ADD = ExtensionSource(
    "adder",
    "double add(double, double); void scale(double *out, const double *x, long n, double by);",
    """
    #include "shared.h"
    double add(double a, double b) { return a + b + SHARED_OFFSET; }
    void scale(double *out, const double *x, long n, double by) {
        for (long i = 0; i < n; i++) out[i] = by * x[i];
    }
    """,
    {"shared.h": "#define SHARED_OFFSET 0.0\n"},
)

CHILD = """
import sys
from bladesmith.codegen.build.extension import load
from bladesmith.codegen.targets.c.source import ExtensionSource
extension = ExtensionSource("raced", "int answer(void);", "int answer(void) { return 42; }")
print(load(extension).lib.answer())
"""

needs_compiler = pytest.mark.skipif(build.compiler() is None, reason="no C compiler")
needs_posix = pytest.mark.skipif(os.name != "posix", reason="shell scripts and signals")


def counting_compiler(tmp_path, before="") -> tuple[str, Path]:
    """A compiler that notes each compilation in a file, and runs a line of shell before it."""
    marker, script = tmp_path / "compilations", tmp_path / "counting-cc"
    script.write_text(
        "#!/bin/sh\n"
        f'case "$*" in *--version*) exec {build.compiler().command[0]} --version;; esac\n'
        f'echo compiled >> "{marker}"\n{before}\n'
        f'exec {build.compiler().command[0]} "$@"\n'
    )
    script.chmod(0o755)
    return str(script), marker


def child(environment=None) -> subprocess.Popen:
    return subprocess.Popen(
        [sys.executable, "-c", CHILD], env={**os.environ, **(environment or {})},
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip


def only_entry(root: Path) -> Path:
    (folder,) = [path for path in root.iterdir() if path.name.startswith("bs_")]
    return folder


@needs_compiler
def test_compiles_once_then_loads_from_the_cache(cache_dir, monkeypatch, caplog):
    caplog.set_level(logging.INFO, "bladesmith")
    module = load(ADD)
    assert module.lib.add(1.0, 2.0) == 3.0
    out, x = module.ffi.new("double[2]"), module.ffi.new("double[2]", [1.0, 2.0])
    module.lib.scale(out, x, 2, 3.0)
    assert list(out) == [3.0, 6.0]
    assert load(ADD) is module
    forget(monkeypatch)
    assert load(ADD).lib.add(1.0, 2.0) == 3.0
    assert [record.message.split(" in ")[0] for record in caplog.records] == ["compiled adder"]


@needs_compiler
def test_prints_nothing(cache_dir, capfd):
    load(ADD)
    assert capfd.readouterr() == ("", "")


@needs_compiler
@pytest.mark.parametrize(
    "other",
    [
        replace(ADD, name="adder2"),
        replace(ADD, cdef=ADD.cdef + " "),
        replace(ADD, source=ADD.source + "\n"),
        replace(ADD, headers={"shared.h": "#define SHARED_OFFSET 1.0\n"}),
        replace(ADD, headers={**ADD.headers, "more.h": ""}),
        replace(ADD, options=("-DX",)),
    ],
    ids=["name", "cdef", "source", "header text", "header", "options"],
)
def test_key_follows_every_part(other):
    assert extension_key(other) != extension_key(ADD)


@needs_compiler
@needs_posix
def test_key_follows_the_compiler(tmp_path, monkeypatch):
    before = extension_key(ADD)
    monkeypatch.setenv("CC", counting_compiler(tmp_path)[0])
    assert extension_key(ADD) != before


@needs_compiler
def test_key_follows_versions_and_flags(monkeypatch):
    keys = {extension_key(ADD)}
    for name, value in [("__version__", "9.9"), ("C_FLAGS", ("-O0",))]:
        with monkeypatch.context() as patch:
            patch.setattr(build, name, value)
            keys.add(extension_key(ADD))
    assert len(keys) == 3


@needs_compiler
def test_options_reach_the_compiler(cache_dir):
    extension = ExtensionSource("optional", "int x(void);", "int x(void) { return X; }", {}, ("-DX=7",))
    assert load(extension).lib.x() == 7


@pytest.mark.parametrize("name", ["", "a b", "../x", "naïve", "x;y"])
def test_names_that_are_no_identifiers_are_refused(name):
    with pytest.raises(SpecError, match="cannot name an extension"):
        replace(ADD, name=name)


@pytest.mark.parametrize("header", ["../shared.h", "/etc/passwd", "", ".hidden", "a/b.h"])
def test_header_names_stay_in_their_folder(header):
    with pytest.raises(SpecError, match="cannot name a header"):
        replace(ADD, headers={header: ""})


@needs_compiler
@needs_posix
def test_racing_processes_build_once(cache_dir, tmp_path):
    command, marker = counting_compiler(tmp_path, before="sleep 0.3")
    racers = [child({"CC": command}) for _ in range(4)]
    answers = [racer.communicate(timeout=PATIENCE) for racer in racers]
    assert answers == [("42\n", "")] * 4
    assert marker.read_text().splitlines() == ["compiled"]


@needs_compiler
def test_racing_threads_build_once(cache_dir, caplog):
    caplog.set_level(logging.INFO, "bladesmith")
    start = threading.Barrier(4)

    def race(_):
        start.wait()
        return load(ADD)

    with ThreadPoolExecutor(4) as pool:
        modules = set(map(id, pool.map(race, range(4))))
    assert len(modules) == 1
    assert len(caplog.records) == 1


@needs_compiler
@needs_posix
def test_killed_in_mid_compile_then_works(cache_dir, tmp_path):
    pause = tmp_path / "pause"
    pause.write_text("")
    pid_file = tmp_path / "pid"
    command, marker = counting_compiler(
        tmp_path, f'if [ -e "{pause}" ]; then echo $$ > "{pid_file}"; exec sleep 60; fi'
    )
    victim = child({"CC": command})
    deadline = time.monotonic() + PATIENCE
    while not (pid_file.exists() and pid_file.read_text().strip()):
        assert time.monotonic() < deadline and victim.poll() is None
        time.sleep(0.02)
    victim.send_signal(signal.SIGKILL)
    victim.communicate()
    assert list(cache_dir.glob(".bs_raced*"))
    pause.unlink()
    try:
        assert child({"CC": command}).communicate(timeout=PATIENCE) == ("42\n", "")
    finally:
        os.kill(int(pid_file.read_text()), signal.SIGKILL)
    assert marker.read_text().splitlines() == ["compiled"] * 2
    assert not list(cache_dir.glob(".bs_raced*")), "the folder of the killed process is swept"


def flip_a_byte(folder: Path) -> None:
    library = folder / (folder.name + cache.LIBRARY_SUFFIX)
    content = bytearray(library.read_bytes())
    content[len(content) // 2] ^= 0xFF
    library.unlink()  # never write into a library that this process has mapped
    library.write_bytes(content)


def truncate(folder: Path) -> None:
    library = folder / (folder.name + cache.LIBRARY_SUFFIX)
    content = library.read_bytes()
    library.unlink()
    library.write_bytes(content[:100])


def lie(folder: Path) -> None:
    """A file that is what its record says, and no library."""
    truncate(folder)
    content = (folder / (folder.name + cache.LIBRARY_SUFFIX)).read_bytes()
    record = {"size": len(content), "sha256": hashlib.sha256(content).hexdigest()}
    (folder / "entry.json").write_text(json.dumps(record))


@pytest.mark.compiles
@needs_compiler
@pytest.mark.parametrize(
    ("damage", "warned"),
    [
        (flip_a_byte, True),
        (truncate, True),
        (lambda folder: (folder / (folder.name + cache.LIBRARY_SUFFIX)).unlink(), True),
        (lambda folder: (folder / "entry.json").write_text("{"), True),
        (lambda folder: (folder / "entry.json").write_text("[]"), True),
        (lambda folder: (folder / "entry.json").unlink(), True),
        (lambda folder: shutil.rmtree(folder), False),
        (lie, False),
    ],
    ids=[
        "flipped",
        "truncated",
        "no library",
        "bad record",
        "odd record",
        "no record",
        "gone",
        "no code inside",
    ],
)
def test_damaged_entry_is_rebuilt(cache_dir, damage, warned):
    """In new processes: Python itself remembers the libraries of this one."""
    assert child().communicate(timeout=PATIENCE) == ("42\n", "")
    damage(only_entry(cache_dir))
    answer, errors = child().communicate(timeout=PATIENCE)
    assert answer == "42\n"
    assert ("is damaged; building it again" in errors) == warned
    assert len(errors.splitlines()) == int(warned)
    assert child().communicate(timeout=PATIENCE) == ("42\n", "")


def test_whether_a_directory_can_be_written_is_found_out_by_trying(tmp_path):
    (tmp_path / "file").write_text("")
    assert cache.is_writable(tmp_path / "new" / "cache") and not list(tmp_path.glob("new"))
    assert not cache.is_writable(tmp_path / "file" / "cache")
    if Path("/proc/self").exists():
        assert not cache.is_writable(Path("/proc/bladesmith"))


@needs_compiler
def test_unusable_directory_falls_back_with_one_warning(cache_dir, tmp_path, monkeypatch, caplog):
    (tmp_path / "file").write_text("")
    monkeypatch.setenv(cache.DIRECTORY_VARIABLE, str(tmp_path / "file" / "cache"))
    assert load(ADD).lib.add(1.0, 2.0) == 3.0
    assert load(replace(ADD, name="another")).lib.add(1.0, 2.0) == 3.0
    warnings = [record.message for record in caplog.records if record.levelno == logging.WARNING]
    assert len(warnings) == 1 and "cannot be used" in warnings[0] and cache.DIRECTORY_VARIABLE in warnings[0]
    (private,) = cache._private
    assert len(list(private.glob("bs_*"))) == 2
    assert private.stat().st_mode & 0o077 == 0
    shutil.rmtree(private)


@needs_compiler
@needs_posix
@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="root may write anywhere")
def test_read_only_directory_still_serves_what_it_holds(cache_dir, monkeypatch, caplog):
    load(ADD)
    cache_dir.chmod(0o555)
    try:
        forget(monkeypatch)
        load(ADD)
        assert not caplog.records
        load(replace(ADD, name="another"))
        assert len(caplog.records) == 1
    finally:
        cache_dir.chmod(0o755)


@needs_compiler
def test_private_directory_goes_with_its_process(tmp_path):
    (tmp_path / "file").write_text("")
    text = CHILD + "\nfrom bladesmith.codegen.build import cache\nprint(cache._private[0])"
    done = subprocess.run(
        [sys.executable, "-c", text], capture_output=True, text=True, timeout=PATIENCE,
        env={**os.environ, cache.DIRECTORY_VARIABLE: str(tmp_path / "file" / "cache")},
    )  # fmt: skip
    answer, private = done.stdout.split()
    assert answer == "42" and not Path(private).exists()


@pytest.mark.parametrize(
    ("cc", "says"), [("/nonexistent/cc", "CC='/nonexistent/cc'"), ("'open", "CC="), ("", "no C compiler")]
)
def test_missing_compiler_names_the_remedy(cache_dir, monkeypatch, cc, says):
    monkeypatch.setenv("CC", cc)
    monkeypatch.setenv("PATH", "")
    with pytest.raises(CompilerMissingError, match="Install gcc or clang") as caught:
        load(ADD)
    assert says in str(caught.value) and "numba" in str(caught.value)


@needs_compiler
def test_bad_c_text_is_reported_and_kept(cache_dir):
    broken = ExtensionSource("broken", "double f(double);", "double f(double x) { return x + y; }")
    with pytest.raises(CompileError, match="'y' undeclared|undeclared identifier 'y'") as caught:
        load(broken)
    assert "\n" not in str(caught.value)
    assert caught.value.source.is_file() and str(caught.value.source) in str(caught.value)
    with pytest.raises(CompileError):
        load(broken)
    assert not list(cache_dir.glob("bs_*")) and not list(cache_dir.glob(".bs_*"))


@needs_compiler
def test_bad_declarations_are_reported(cache_dir):
    with pytest.raises(CompileError, match="declarations of broken"):
        load(ExtensionSource("broken", "duoble f(double);", ""))


@needs_compiler
def test_without_python_headers_the_library_is_opened_plainly(cache_dir, monkeypatch):
    monkeypatch.setattr(build, "_include", lambda: "/nonexistent")
    module = load(ADD)
    assert module.lib.add(1.0, 2.0) == 3.0
    out = module.ffi.new("double[1]")
    module.lib.scale(out, module.ffi.new("double[1]", [2.0]), 1, 4.0)
    assert out[0] == 8.0


@needs_compiler
def test_listing_and_clearing(cache_dir):
    load(ADD)
    load(replace(ADD, name="another"))
    found = cache.entries()
    assert [entry.stem.rsplit("_", 1)[0] for entry in found] == ["bs_another", "bs_adder"]
    assert all(entry.library.is_file() and entry.size > 0 for entry in found)
    assert cache.clear() == (2, sum(entry.size for entry in found))
    assert cache.entries() == [] and cache.clear() == (0, 0)


@needs_compiler
def test_clearing_leaves_what_is_being_built(cache_dir):
    load(ADD)
    with cache._lock(cache_dir, only_entry(cache_dir).name):
        assert cache.clear() == (0, 0)
    assert len(cache.entries()) == 1


@needs_compiler
def test_the_oldest_entries_go_when_the_cache_is_full(cache_dir, monkeypatch):
    load(ADD)
    os.utime(only_entry(cache_dir) / "entry.json", (1, 1))
    load(replace(ADD, name="second"))
    monkeypatch.setattr(cache, "LIMIT_BYTES", 2 * max(entry.size for entry in cache.entries()))
    load(replace(ADD, name="third"))
    assert sorted(entry.stem.rsplit("_", 1)[0] for entry in cache.entries()) == ["bs_second", "bs_third"]


@needs_compiler
@needs_posix
def test_forked_child_can_load(cache_dir):
    module = load(ADD)
    with build._loading._guard:  # as held by another thread at the moment of the fork
        pid = os.fork()
        if pid == 0:
            os._exit(0 if load(ADD) is module else 1)
    assert os.waitpid(pid, 0)[1] == 0


@needs_compiler
def test_generated_folder_compiles_with_its_hash(cache_dir, tmp_path):
    folder, headers = tmp_path / "tiny2d", tmp_path / "shared"
    folder.mkdir()
    headers.mkdir()
    (headers / "platform.h").write_text("#define TWO 2\n")
    (folder / "kernels.cdef").write_text("int two(void); const char *bs_source_hash(void);")
    (folder / "kernels.c").write_text(
        '#include "platform.h"\nint two(void) { return TWO; }\n'
        "const char *bs_source_hash(void) { return BS_SOURCE_HASH; }\n"
    )
    module = load(generated_extension(folder, headers))
    expected = source_hash(compiled_files(folder, headers))
    assert module.lib.two() == 2
    assert module.ffi.string(module.lib.bs_source_hash()).decode() == expected
    (headers / "platform.h").write_text("#define TWO 3\n")
    assert source_hash(compiled_files(folder, headers)) != expected
    assert load(generated_extension(folder, headers)).lib.two() == 3


def test_generated_folder_without_sources_is_refused(tmp_path):
    with pytest.raises(SpecError, match="bladesmith generate"):
        generated_extension(tmp_path, tmp_path)


def test_source_hash_separates_names_and_texts():
    assert source_hash({"a": "b", "c": "d"}) == source_hash({"c": "d", "a": "b"})
    assert len({source_hash(files) for files in [{"a": "bc"}, {"ab": "c"}, {"a": "b", "c": ""}, {}]}) == 4
    assert len(source_hash({})) == 16


@needs_compiler
@needs_posix
def test_full_disk_falls_back(cache_dir, tmp_path, monkeypatch, caplog):
    full = "fatal error: error writing to out.s: No space left on device"
    command, _ = counting_compiler(tmp_path, f'case "$PWD" in "{cache_dir}"/*) echo "{full}" >&2; exit 1;; esac')
    monkeypatch.setenv("CC", command)
    assert load(ADD).lib.add(1.0, 2.0) == 3.0
    assert ["No space left" in record.message for record in caplog.records] == [True]
    shutil.rmtree(cache._private[0])


@needs_compiler
def test_what_the_linker_says_is_reported(cache_dir):
    absent = ExtensionSource("absent", "int f(void);", "int f(void) { return 1; }", {}, ("-lbladesmith_absent",))
    with pytest.raises(CompileError, match="bladesmith_absent"):
        load(absent)
