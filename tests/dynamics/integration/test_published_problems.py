"""Problems that others published, with their solutions: examples/dynamics/published_problems.py."""

from __future__ import annotations

import pytest

from ...support.scripts import script

pytestmark = pytest.mark.slow


@pytest.mark.parametrize("number", ["A01", "A03", "A04", "A05"])
def test_published_problems(number: str) -> None:
    with script("examples/dynamics", "published_problems") as problems:
        problem = next(problem for problem in problems.PROBLEMS if problem.name.startswith(number))
        trajectory = problem.run()
        assert trajectory.time[-1] == problem.duration
        assert problem.error(trajectory) <= min(problem.allowed, 1e-8)
