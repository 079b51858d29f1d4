"""Labels of clusters."""

import numpy as np


def same_partition(a: np.ndarray, b: np.ndarray) -> bool:
    """Whether two labellings differ by names only."""
    return len({*zip(a.tolist(), b.tolist(), strict=True)}) == len(set(a.tolist())) == len(set(b.tolist()))
