"""Mechanism files: the examples, and files that tests write."""

from ..checkout import CHECKOUT

EXAMPLES = CHECKOUT / "examples" / "kinematics"


def written(tmp_path, text, name="robot.toml"):
    (tmp_path / name).write_text(text)
    return tmp_path / name


# -- poses -----------------------------------------------------------------------------------------------------

DELTA = """
[delta]
base_radius = 0.4
effector_radius = 0.15
upper_arm = 0.6
forearm = 1.2
"""


# -- joints ----------------------------------------------------------------------------------------------------

PAIR = (
    '[mechanism]\nbodies = ["a", "b"]\nalgebra = "{algebra}"\n[points]\nP = [0.3, -0.2, 0.5]\n'
    '[[joints]]\na = "a"\nb = "b"\n'
)
CGA_PAIR = PAIR.format(algebra="cga3d")


# -- faults ----------------------------------------------------------------------------------------------------

FOUR = (EXAMPLES / "four_bar.toml").read_text()
