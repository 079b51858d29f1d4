"""A four-bar and a Delta robot at known poses, bodies on a joint, and where points of bodies are."""

import numpy as np

from ..kinematics import FourBar

THETA = np.array([0.3, 0.5, 0.1])
MOTORS = ["motor_0", "motor_1", "motor_2"]
BAR = FourBar()
