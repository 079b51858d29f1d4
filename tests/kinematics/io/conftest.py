"""Mechanisms of the examples and their motions."""

import pytest

from bladesmith.kinematics.io.reader import load_mechanism

from ...support.mechanisms.documents import EXAMPLES


@pytest.fixture(scope="module")
def setups():
    return {
        name: load_mechanism(EXAMPLES / f"{name}.toml") for name in ("delta", "four_bar", "stewart", "arm", "scara")
    }


class Motions(dict):
    """Motions of the examples by name, computed at the first use: each compiles a program."""

    def __init__(self, setups):
        self.setups = setups

    def __missing__(self, name):
        return self.setdefault(name, self.setups[name].motion())


@pytest.fixture(scope="module")
def motions(setups):
    return Motions(setups)
