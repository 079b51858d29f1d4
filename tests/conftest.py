"""What every test runs under: one cache of compiled kernels, no display, repeatable examples."""

import os
import shutil
import tempfile

import pytest
from hypothesis import settings

CACHE_VARIABLE = "BLADESMITH_CACHE_DIR"
KEPT_CACHE = os.environ.get("BLADESMITH_TEST_CACHE_DIR")  # a developer's: kept between sessions

STRICT = os.environ.get("BLADESMITH_STRICT_TESTS", "") not in ("", "0")
MACHINE_LACKS = (
    "no device",
    "no GPU to run on",
    "no CUDA device",
    "root may",
    "shell scripts",
    "no gcc with libasan",
)  # reasons that no install can mend

settings.register_profile("ci", deadline=None, derandomize=True)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "ci"))


def pytest_configure(config: pytest.Config) -> None:
    """Before collection, since modules declare kernels when they are imported.

    The workers of pytest-xdist inherit the variable from their controller, and so share the cache.
    """
    os.environ["MPLBACKEND"] = "Agg"
    if not hasattr(config, "workerinput"):
        os.environ[CACHE_VARIABLE] = KEPT_CACHE or tempfile.mkdtemp(prefix="bladesmith-tests-")


def pytest_unconfigure(config: pytest.Config) -> None:
    if not hasattr(config, "workerinput") and not KEPT_CACHE:
        shutil.rmtree(os.environ[CACHE_VARIABLE], ignore_errors=True)


def pytest_sessionfinish(session: pytest.Session) -> None:
    """Where it is asked for, a test skipped for want of a tool is a failure: nobody would read of it."""
    reporter = session.config.pluginmanager.get_plugin("terminalreporter")
    if not STRICT or reporter is None:
        return
    reasons = {str(report.longrepr[2]) for report in reporter.stats.get("skipped", [])}
    missing = sorted(reason for reason in reasons if not any(words in reason for words in MACHINE_LACKS))
    for reason in missing:
        reporter.write_line(f"skipped, and should not have been: {reason}", red=True)
    if missing and session.exitstatus == pytest.ExitCode.OK:
        session.exitstatus = pytest.ExitCode.TESTS_FAILED
