"""Chains from tables of Denavit and Hartenberg's numbers, against their matrices written out."""

import numpy as np
import pytest

import bladesmith as bs
from bladesmith.errors import InputError, ShapeError
from bladesmith.kinematics.serial.chain import Chain

from ...support.mechanisms.chains import ALGEBRAS


def matrix(convention, a, alpha, d, theta):
    """As the textbooks have it."""
    ca, sa, ct, st = np.cos(alpha), np.sin(alpha), np.cos(theta), np.sin(theta)
    if convention == "standard":  # Spong, Hutchinson and Vidyasagar (3.10)
        return np.array(
            [[ct, -st * ca, st * sa, a * ct], [st, ct * ca, -ct * sa, a * st], [0, sa, ca, d], [0, 0, 0, 1]]
        )
    return np.array(  # Craig (3.6)
        [[ct, -st, 0, a], [st * ca, ct * ca, -sa, -sa * d], [st * sa, ct * sa, ca, ca * d], [0, 0, 0, 1]]
    )


@pytest.mark.parametrize("algebra", ALGEBRAS, ids=lambda a: a.name)
@pytest.mark.parametrize("convention", ["standard", "modified"])
def test_poses_are_products_of_matrices(algebra, convention):
    rng = np.random.default_rng(0)
    rows, q = rng.uniform(-2, 2, (5, 4)), rng.uniform(-2, 2, (3, 5))
    tool = algebra.translator([0.1, 0.2, 0.3]) * algebra.rotor([1, 2, 3], 0.4)
    chain = Chain.from_dh(rows, convention, joints="RPrRP", tool=tool, algebra=algebra)
    for x in q:
        pose = np.eye(4)
        frames = []
        for (a, alpha, d, theta), kind, value in zip(rows, "RPRRP", x, strict=True):
            d, theta = (d + value, theta) if kind == "P" else (d, theta + value)
            pose = pose @ matrix(convention, a, alpha, d, theta)
            frames.append(pose)
        assert np.abs(algebra.matrix(chain.forward(x)) - pose @ algebra.matrix(tool)).max() < 2e-14
        assert np.abs(algebra.matrix(chain.forward(x, all=True)) - frames).max() < 2e-14


def test_rows_by_name_and_in_degrees():
    table = [{"alpha": 90.0, "d": 0.4}, {"a": 0.3, "theta": -90.0}, {"a": 0.2}]
    named = Chain.from_dh(table, angles="degrees", names=["x", "y", "z"])
    plain = Chain.from_dh([[0, np.pi / 2, 0.4, 0], [0.3, 0, 0, -np.pi / 2], [0.2, 0, 0, 0]])
    q = [0.1, 0.2, 0.3]
    assert np.abs(named.forward(q).values - plain.forward(q).values).max() < 1e-15
    assert named.names == ("x", "y", "z") and named.algebra is bs.cga3d
    masses = named.with_inertias(np.ones(3), np.zeros((3, 3)), np.zeros((3, 3, 3)))  # points at the links' frames
    assert masses.gravity_torques(q)[0] == pytest.approx(0, abs=1e-14)
    assert masses.gravity_torques(q)[1] == pytest.approx(9.81 * (2 * 0.3 * np.sin(0.2) + 0.2 * np.sin(0.5)), rel=1e-13)


def test_bad_tables():
    for rows, error, match in (
        ([[0, 90, 0, 0]], InputError, "alpha of row 0 is 90 radians.*degrees"),
        ([[0, 0, 0]], ShapeError, r"shape \(1, 3\); \(n, 4\)"),
        (np.zeros((0, 4)), ShapeError, "shape"),
        ([[0, 0, np.nan, 0]], InputError, "rows.*finite"),
        ([{"alfa": 1.0}], InputError, "row 0 has 'alfa' .*did you mean 'alpha'"),
        ([{"a": 1.0}, [0, 0, 0, 0]], InputError, "row 1 has no names"),
    ):
        with pytest.raises(error, match=match):
            Chain.from_dh(rows)
    rows = np.zeros((2, 4))
    with pytest.raises(InputError, match="2 letters are needed"):
        Chain.from_dh(rows, joints="R")
    with pytest.raises(InputError, match="'RX'"):
        Chain.from_dh(rows, joints="RX")
    with pytest.raises(InputError, match="convention"):
        Chain.from_dh(rows, "craig")
    with pytest.raises(InputError, match="angles"):
        Chain.from_dh(rows, angles="turns")
