"""Extensions that tests compile into the kernel cache, in this process and in others."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from bladesmith.codegen.build import extension as build
from bladesmith.codegen.targets.c.source import ExtensionSource

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
