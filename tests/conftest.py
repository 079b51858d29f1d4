"""What every test runs under: one cache of compiled kernels, no display, repeatable examples."""

import os
import signal
from collections import Counter
from collections.abc import Iterator
from importlib import resources
from pathlib import Path

import pytest
from hypothesis import settings

from bladesmith.codegen.generator import outdated_modules
from bladesmith.errors import BladesmithError

from .support.build.levels import compiler_at, level_of
from .support.checkout import TEST_CACHE

CACHE_VARIABLE = "BLADESMITH_CACHE_DIR"
STRICT = os.environ.get("BLADESMITH_STRICT_TESTS", "") not in ("", "0")
_PEERS = ("pinocchio", "mujoco", "pytransform3d", "jaxlie", "example_robot_data", "torch")
MACHINE_LACKS = (
    "no device",
    "no GPU to run on",
    "no CUDA device",
    "root may",
    "shell scripts",
    "no gcc with libasan",
    "no tsc",
    "no package example-robot-data",
    "no full bars",
    *(f"could not import '{peer}" for peer in _PEERS),
)  # reasons that no install can mend, or that were chosen; and peers of the extra `benchmark`, which `ci` is without
#: Half a minute each or more, of few tests: begun last, one core would wait for another. test_without_a_compiler finds
#: the code that numba made for those before it.
LONGEST = (
    "integration/test_targets.py",
    "test_sanitizers.py",
    "rendering/test_numba.py",
    "mechanism/test_targets.py",
    "algorithms/test_chains.py",
    "test_same_bits.py",
    "test_warnings.py",
    "test_without_a_compiler.py",
    "test_ziglang.py",
    "test_docs.py",
    "test_generated_sources.py",
    "test_like_objects.py",
    "exporting/test_exported_robots.py",
)

settings.register_profile("ci", deadline=None, derandomize=True)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "ci"))


def refuse_outdated() -> None:
    """Compiled kernels are what most tests run: of formulas that have changed since, they would say nothing.

    Raises
    ------
    pytest.UsageError
        If formulas are newer than the texts that were generated from them.
    """
    try:
        stale = outdated_modules(Path(str(resources.files("bladesmith.generated"))))
    except BladesmithError as error:
        raise pytest.UsageError(str(error)) from None
    if stale:
        raise pytest.UsageError(
            f"formulas, or generated files by hand, have changed since these were generated: {', '.join(stale)}.\n"
            "Run `bladesmith generate --update` (it writes ./generated), then the tests again."
        )


def pytest_configure(config: pytest.Config) -> None:
    """Before collection, since modules declare kernels when they are imported."""
    os.environ["MPLBACKEND"] = "Agg"
    if not hasattr(config, "workerinput"):
        refuse_outdated()
    os.environ[CACHE_VARIABLE] = TEST_CACHE
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:  # of what a script starts in the background, and its children
        signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture(scope="module", autouse=True)
def compiler_level(request: pytest.FixtureRequest) -> Iterator[None]:
    """Programs of a module's tests are optimised as `support/build/levels.py` says."""
    with pytest.MonkeyPatch.context() as patch:
        if (level := level_of(request.path)) and (script := compiler_at(level)):
            patch.setenv("CC", script)
        yield


@pytest.hookimpl(trylast=True)  # when what is not selected has gone
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """The longest files first, then those of most tests, so that all cores end together."""
    counts = Counter(item.path for item in items)

    def place(item: pytest.Item) -> tuple[int, int]:
        name = item.path.as_posix()
        return next((i for i, end in enumerate(LONGEST) if name.endswith(end)), len(LONGEST)), -counts[item.path]

    items.sort(key=place)


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
