"""Serial chains for tests."""

import numpy as np

import bladesmith as bs
from bladesmith.dynamics import screw_coordinates
from bladesmith.kinematics.serial.axes import prismatic_axis, revolute_axis, screw_axis
from bladesmith.kinematics.serial.chain import Chain

ALGEBRAS = [bs.cga3d, bs.pga3d]
UP = (0.0, 0.0, 1.0)


def mixed(algebra, seed, count=6, scale=1.0, origin=0.0):
    """A chain of turns, slides and screws, around a place."""
    rng = np.random.default_rng(seed)
    center = origin * np.array([0.6, -0.7, 0.4])
    axes = []
    for i in range(count):
        p, d = center + scale * rng.normal(size=3), rng.normal(size=3)
        kind = rng.integers(4) if i else 0
        axes.append(
            prismatic_axis(d, algebra) if kind == 1
            else screw_axis(p, d, scale * rng.normal(), algebra) if kind == 2
            else revolute_axis(p, d, algebra)
        )  # fmt: skip
    tool = algebra.translator(center + scale * rng.normal(size=3)) * algebra.rotor(rng.normal(size=3), rng.normal())
    chain = Chain(axes, tool)
    q = rng.uniform(-3, 3, (4, count))
    slides = np.abs(np.stack([screw_coordinates(a)[:3] for a in axes])).max(-1) == 0
    q[:, slides] *= scale
    return chain, q


def arm(algebra=bs.cga3d, scale=1.0, center=(0.0, 0.0, 0.0), **options):
    """Six axes, three of them parallel."""
    positions = scale * np.array(
        [[0, 0, 0.1], [0, 0.1, 0.3], [0, 0.1, 0.9], [0.4, 0.1, 0.9], [0.5, 0.1, 0.9], [0.6, 0.1, 0.9]]
    )
    directions = [[0, 0, 1], [0, 1, 0], [0, 1, 0], [1, 0, 0], [0, 1, 0], [1, 0, 0]]
    tool = algebra.translator(np.add(center, scale * np.array([0.7, 0.1, 0.9])))
    return Chain(revolute_axis(np.add(center, positions), directions, algebra), tool, **options)
