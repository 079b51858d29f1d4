"""Which tests run by default: all that have no marker."""

import tomllib

from ..support.checkout import CHECKOUT

OPTIONS = tomllib.loads((CHECKOUT / "pyproject.toml").read_text())["tool"]["pytest"]["ini_options"]


def test_the_default_leaves_out_what_has_a_marker_and_ci_runs_that():
    names = [marker.split(":")[0] for marker in OPTIONS["markers"]]
    expression = OPTIONS["addopts"][OPTIONS["addopts"].index("-m") + 1]
    assert expression == f"not ({' or '.join(names)})"
