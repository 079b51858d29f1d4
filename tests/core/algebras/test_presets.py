"""Algebras that are made at first use: their kinds, constructors and readers."""

from __future__ import annotations

import importlib
import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import bladesmith as bs
from bladesmith.codegen.algebra.kind_checks import check_kind
from bladesmith.codegen.algebra.loader import PRESETS

RANDOM = np.random.default_rng(12)


@pytest.mark.parametrize("name", PRESETS)
def test_kinds_have_members(name: str) -> None:
    algebra = getattr(bs, name)
    assert algebra is importlib.import_module(f"bladesmith.{name}") is pickle.loads(pickle.dumps(algebra))
    for kind in algebra.kinds.values():
        if kind.constraints:
            check_kind(kind)
    assert name in dir(bs)


def test_vectors() -> None:
    space, plane = bs.vga3d, bs.vga2d
    axis, angle = RANDOM.normal(size=(20, 3)), RANDOM.uniform(0, 2 * np.pi, 20)
    rotor = space.rotor(axis, angle)
    read = rotor.parameters()
    assert np.allclose(read.axis, axis / np.linalg.norm(axis, axis=-1, keepdims=True))
    assert np.allclose(read.angle, angle)
    v = RANDOM.normal(size=(20, 3))
    matrices = rotor.to_matrix()[:, :3, :3]
    assert np.allclose((rotor >> space.vector(v)).as_kind("vector").values, np.einsum("nij,nj->ni", matrices, v))
    back = space.from_matrix(matrices)
    assert (back.isclose(rotor) | back.isclose(-rotor)).all() and back.kind == space.kind("rotor")
    assert (space.rotor([0, 0, 1], np.pi / 2) >> space.e1).isclose(space.e2, atol=1e-15)
    assert space.rotor([0, 0, 1], 0.0).parameters().status == bs.Status.NOT_UNIQUE
    assert space.rotor([0, 0, 0], 1.0).status == bs.Status.INVALID
    assert (plane.rotor(np.pi / 2) >> plane.e1).isclose(plane.e2, atol=1e-15)
    assert np.allclose(plane.rotor(angle).parameters().angle, angle)
    with pytest.raises(bs.errors.GradeError, match="translations"):
        space.translator([1, 2, 3])


def test_points_and_lines_of_the_plane() -> None:
    pga = bs.pga2d
    a, b = RANDOM.normal(size=(2, 20, 2))
    p, q = pga.point(a), pga.point(b)
    line = pga.line_through(a, b)
    assert (p & q).normalized("line").isclose(line, atol=1e-12).all() and line.kind == pga.kind("line")
    assert np.allclose(p.parameters().xyz, a) and np.allclose((line & p).values, 0, atol=1e-12)
    read = line.parameters()
    assert np.allclose((read.normal * a).sum(-1), read.offset)
    assert pga.line(read.normal, read.offset).isclose(line).all()
    meet = (line ^ pga.line([0, 1], 5.0)).normalized("point").parameters().xyz
    assert np.allclose(meet[:, 1], 5.0) and np.allclose((read.normal * meet).sum(-1), read.offset)
    turn = pga.rotor(0.3, a)
    moved = (turn >> q).parameters().xyz - a
    c, s = np.cos(0.3), np.sin(0.3)
    assert np.allclose(moved, (b - a) @ np.array([[c, s], [-s, c]]))
    assert np.allclose(turn.parameters().angle, 0.3) and np.allclose(turn.parameters().point, a)
    assert pga.motor_from_matrix(turn.to_matrix()).isclose(turn).all()
    assert pga.line_through([1, 2], [1, 2]).status == bs.Status.SINGULAR
    assert pga.line([0, 0], 1.0).status == bs.Status.INVALID
    shift = pga.translator([1, 2])
    assert shift.parameters().t.tolist() == [1, 2] and (shift >> pga.point([0, 0])).isclose(pga.point([1, 2]))


def test_spacetime() -> None:
    sta = bs.sta
    v = RANDOM.uniform(-0.5, 0.5, (20, 3))
    gamma = 1 / np.sqrt(1 - (v**2).sum(-1))
    u = (sta.boost(v) >> sta.e0).as_kind("vector").values
    assert np.allclose(u, np.concatenate([gamma[:, None], gamma[:, None] * v], -1))
    assert sta.velocity(v).isclose(sta.boost(v) >> sta.e0).all()
    event = sta.event(2.0, [1, 2, 3])
    assert np.isclose((event**2)["1"], 4 - 14) and np.isclose(((sta.boost(v[0]) >> event) ** 2)["1"], 4 - 14)
    assert (sta.rotor([0, 0, 1], np.pi / 2) >> sta.e1).isclose(sta.e2, atol=1e-15)
    assert (sta.rotor([0, 0, 2], 0.7) >> sta.e3).isclose(sta.e3)
    rotor = sta.boost(v) * sta.rotor([1, 2, 3], 0.4)
    assert rotor.log().exp().isclose(rotor, rtol=1e-12).all() and rotor.kind == sta.kind("rotor")
    for fast in ([1.0, 0, 0], [1.0, 1.0, 1.0]):
        assert sta.velocity(fast).status == sta.boost(fast).status == bs.Status.INVALID


def test_quadrics() -> None:
    qcga = bs.qcga
    squares, mixed, linear, x = RANDOM.normal(size=(4, 30, 3))
    constant = RANDOM.normal(size=30)
    value = (qcga.point(x) | qcga.quadric(squares, mixed, linear, constant))["1"]
    pairs = np.stack([x[:, 0] * x[:, 1], x[:, 0] * x[:, 2], x[:, 1] * x[:, 2]], -1)
    expected = (squares * x**2 + mixed * pairs + linear * x).sum(-1) + constant
    assert np.allclose(value, expected, atol=1e-13)
    assert np.allclose((qcga.point(x) | qcga.point(x))["1"], 0, atol=1e-13)
    dcga = bs.dcga
    a, b = RANDOM.normal(size=(2, 30, 3))
    square = ((a - b) ** 2).sum(-1)
    assert np.allclose((dcga.point(a) | dcga.point(b))["1"], -(square**2) / 4)  # -(d^2/2)^2


def test_bad_values() -> None:
    calls: list[Any] = [
        lambda: bs.pga2d.point([1, 2, 3]),
        lambda: bs.sta.event("a", [1, 2, 3]),
        lambda: bs.vga3d.rotor([1, 2], 0.1),
        lambda: bs.qcga.quadric([1, 2, 3], [1, 2], [1, 2, 3], 1),
    ]
    for call in calls:
        with pytest.raises((bs.errors.ShapeError, bs.errors.InputError)):
            call()
    assert bs.dcga.point([np.nan, 0, 0]).status == bs.Status.INVALID


def test_matrices_of_motions_of_the_plane_are_checked() -> None:
    bad: Any
    for bad in (np.eye(2), np.zeros(3), np.eye(4), "x", [[1, 2], [3]], np.eye(3) + 1j):
        with pytest.raises(bs.errors.InputError):
            bs.pga2d.motor_from_matrix(bad)
    scaled = [np.diag([2.0, 2, 1]), np.diag([1.0, -1, 1]), np.array([[1.0, 0, 0], [0, 1, 0], [5, 5, 7]]), np.eye(3)]
    assert list(bs.pga2d.motor_from_matrix(np.array(scaled)).status) == [bs.Status.INVALID] * 3 + [bs.Status.OK]
    with pytest.raises(bs.errors.SingularError):
        bs.pga2d.motor_from_matrix(scaled[0], strict=True)


def test_algebras_without_parameters_say_so() -> None:
    with pytest.raises(bs.errors.KindError, match="no kind that has parameters.$"):
        bs.sta.boost([0.6, 0, 0]).parameters()


@pytest.mark.parametrize("name", PRESETS)
def test_files_give_back_the_algebra_and_its_kinds(name: str, tmp_path: Path) -> None:
    algebra = getattr(bs, name)
    members = {kind: algebra.random(kind, n=2, seed=1) for kind in algebra.kinds}
    bs.save(tmp_path / "members.npz", **members)
    for kind, x in bs.load(tmp_path / "members.npz").items():
        assert x.algebra is algebra and x.kind == members[kind].kind and x.isclose(members[kind]).all()
