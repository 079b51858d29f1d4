"""Trajectories that several tests of dynamics use."""

import pytest

from ..support.dynamics.documents import swung


@pytest.fixture(scope="module")
def swing(tmp_path_factory):
    """A pendulum pinned at its tip: the setup, and its trajectory."""
    return swung(tmp_path_factory.mktemp("swing"))
