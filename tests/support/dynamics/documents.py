"""Simulation files for tests: the examples, a body's text, and a pendulum's setup with its trajectory."""

from __future__ import annotations

from bladesmith import dynamics

from ..checkout import CHECKOUT

EXAMPLES = sorted((CHECKOUT / "examples" / "dynamics").glob("*.toml"))
HOSTILE = "A </script><img src=x onerror=alert(1)> $\\frac$ {{ 7 * 7 }} %s"

BODY = """
[body]
mass = 2.0
moments = [1.0, 2.0, 2.5]
points = { tip = [0.0, 0.0, 0.5] }
"""
RUN = """
[simulation]
duration = 0.1
"""
TRACED = """
[[traces]]
point = "tip"
color = "red"
"""
GRAVITY = '[[loads]]\nkind = "gravity"\n'


def read(folder, text):
    """What a simulation file of this text says."""
    path = folder / "body.toml"
    path.write_text(text, encoding="utf-8")
    return dynamics.load_simulation(path)


def swung(folder):
    """A pendulum pinned at its tip: the setup, and its trajectory."""
    text = BODY.replace("moments = [1.0, 2.0, 2.5]", 'shape = { kind = "box", size = [0.2, 0.3, 1.0] }')
    text += "orientation = { axis = [1, 0, 0], degrees = 80 }\n" + GRAVITY
    text += '[[constraints]]\nkind = "pin"\nobject = { kind = "point", xyz = "tip" }\n'
    setup = read(folder, text + RUN.replace("0.1", "0.5\ninterval = 0.01") + TRACED)
    return setup, setup.run()
