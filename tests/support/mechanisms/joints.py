"""Places and directions of joints."""

import numpy as np

P, Q = np.array([0.3, -0.4, 0.7]), np.array([1.0, 2.0, -0.5])
U, W = np.array([0.6, 0.0, 0.8]), np.array([0.0, 1.0, 0.0])
