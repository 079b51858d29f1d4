"""Serial chains as products of matrix exponentials, in as many digits as mpmath has."""

import mpmath as mp

DIGITS = 50


def hat(s):
    """The matrix of a twist's six numbers (w, v)."""
    w, v = s[:3], s[3:]
    return mp.matrix([[0, -w[2], w[1], v[0]], [w[2], 0, -w[0], v[1]], [-w[1], w[0], 0, v[2]], [0, 0, 0, 0]])


def oracle(screws, tool, q):
    """exp(q1 S1) ... exp(qn Sn) tool, and what stands before each joint's exponential and behind the last."""
    pose, before = mp.eye(4), []
    for s, x in zip(screws, q, strict=True):
        before.append(pose)
        pose = pose * mp.expm(hat([mp.mpf(float(c)) * mp.mpf(x) for c in s]))
    return pose * mp.matrix(tool.tolist()), [*before, pose]


def columns(screws, before):
    """Twists of the joints where they are, six numbers each: R w, R v + p x R w."""
    found = []
    for s, pose in zip(screws, before, strict=False):
        w, v = (pose[:3, :3] * mp.matrix([mp.mpf(float(c)) for c in part]) for part in (s[:3], s[3:]))
        p = pose[:3, 3]
        cross = [p[1] * w[2] - p[2] * w[1], p[2] * w[0] - p[0] * w[2], p[0] * w[1] - p[1] * w[0]]
        found.append([*w, *(v[k] + cross[k] for k in range(3))])
    return mp.matrix(found).T
