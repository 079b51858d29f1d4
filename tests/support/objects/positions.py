"""Random positions, directions, sizes of objects: one row for each of 50 items."""

import numpy as np

N = 50
RANDOM = np.random.default_rng(11)
A, B, C, D, V = RANDOM.normal(size=(5, N, 3))
RADIUS = RANDOM.uniform(0.1, 3.0, N)
OFFSET = RANDOM.normal(size=N)
UNIT = V / np.linalg.norm(V, axis=-1, keepdims=True)
