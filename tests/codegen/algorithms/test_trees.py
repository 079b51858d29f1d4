"""Algorithms of trees of links: the text with 50 digits against the compiled one, and every target and instance."""

from __future__ import annotations

import subprocess
from dataclasses import replace
from pathlib import Path
from typing import Any

import mpmath as mp
import numpy as np
import pytest

import bladesmith as bs
from bladesmith.codegen import algorithm
from bladesmith.codegen.algorithms.chain_records import Joint
from bladesmith.codegen.algorithms.trees.records import FRAME, SAME, Link
from bladesmith.codegen.build import extension
from bladesmith.codegen.build.cpu_features import runs
from bladesmith.codegen.build.flags import C_FLAGS, WARNING_FLAGS
from bladesmith.codegen.language import Ints, Out, Reals, Rows, Vector
from bladesmith.codegen.programs.tree_motion import tree_motion_program
from bladesmith.codegen.programs.trees import CLASSES, SHARED, algorithms_of, tree_extension, tree_function
from bladesmith.codegen.targets.c.instances import BY_TAG, OF_KERNELS
from bladesmith.kinematics.trees.driver import TreeDriver, TreeParameters, tree_loop
from bladesmith.kinematics.trees.inertias import link_rows

from ...support.build.numba_code import numba_text_as_python
from ...support.effort import FULL
from ...support.mechanisms.robots import random_inertias

pytestmark = pytest.mark.skipif(extension.compiler() is None, reason="no C compiler")
ALGEBRAS = [bs.cga3d, bs.pga3d]
#: Seven joints: a trunk of two, an arm of three on it, and another of two, which a joint with a pitch begins.
PARENTS = np.array([-1, 0, 1, 2, 3, 1, 5])
N = len(PARENTS)
#: Seven freedoms of five joints: a ball, a hinge on it, a joint of two freedoms on that, and another hinge on the ball.
FRAMES = TreeParameters(
    np.empty((0, 8)), np.empty((0, 10)), np.array([-1, 0, 1, 2, 3, 4, 2]),
    np.array([FRAME, SAME, SAME, 0, FRAME, SAME, 0]), np.array([0, 0, 0, 7, 8, 8, 15]),
)  # fmt: skip
GRAVITY = np.array([0.3, -0.2, -9.81])


def tree(has_frames: bool = False) -> TreeParameters:
    """A tree that branches, with joints of all sorts."""
    rng = np.random.default_rng(0)
    axes = rng.normal(size=(N, 3))
    axes /= np.linalg.norm(axes, axis=-1, keepdims=True)
    rotation, advance = np.array([1, 0, 1, 1, 1, 1, 1.0]), np.array([0, 1, 0, 0, 0, 0.4, 0])
    joints = np.column_stack([rng.normal(size=(N, 3)), axes, rotation, advance])
    links = link_rows(*random_inertias(rng, N))
    if has_frames:
        joints[FRAMES.kinds == SAME, :3], links[[0, 1, 4]] = 0.0, 0.0
        return replace(FRAMES, joints=joints, links=links)
    return TreeParameters(joints, links, PARENTS)


def motions(items: int, has_frames: bool = False) -> Any:
    rng = np.random.default_rng(1)
    qd, qdd = rng.uniform(-2, 2, (2, items, N))
    return rng.uniform(-2, 2, (items, 16 if has_frames else N)), qd, qdd


def results(driver: TreeDriver, items: int, has_frames: bool = False) -> list[Any]:
    q, qd, qdd = motions(items, has_frames)
    found = [
        driver.inverse_dynamics(GRAVITY, q, qd, qdd, items, 1),
        driver.inverse_dynamics(GRAVITY, q[0], qd, qdd, items, 1), driver.mass_matrix(q, 1),
        driver.forward_dynamics(GRAVITY, q, qd, qdd, items, 1),
    ]  # fmt: skip
    if not has_frames:
        found.append(driver.derivative("inverse_dynamics", "x", GRAVITY, (q, qd, qdd), np.eye(N), items, 1))
    return found


@pytest.mark.parametrize("has_frames", [False, pytest.param(True, marks=pytest.mark.slow)])
@pytest.mark.parametrize("algebra", ALGEBRAS, ids=lambda a: a.name)
def test_fifty_digits(algebra, has_frames):
    parts, p = algorithms_of(algebra.name, CLASSES[0], has_frames), tree(has_frames)
    inverse, mass, forward = parts.inverse_dynamics, parts.mass_matrix, parts.forward_dynamics

    @algorithm
    def both(
        joints: Rows[Joint], links: Rows[Link], parents: Ints, kinds: Ints, places: Ints, gravity: Vector[3],
        x: Reals, dx: Reals, ddx: Reals, forces: Out[Vector[7]], accelerations: Out[Vector[7]], matrix: Out[Vector[49]],
    ) -> None:  # fmt: skip
        """All that is computed of one motion."""
        inverse(joints, links, parents, kinds, places, gravity, x, dx, ddx, forces)
        forward(joints, links, parents, kinds, places, gravity, x, dx, ddx, accelerations)
        mass(joints, links, parents, kinds, places, x, matrix)

    q, qd, qdd = (x[0] for x in motions(1, has_frames))
    forces, _, matrices, accelerations, *_ = results(TreeDriver(algebra.name, p), 1, has_frames)
    given = p.joints, p.links, *TreeDriver(algebra.name, p).tree[2:], GRAVITY, q, qd
    with mp.workdps(50):
        exact = both.reference(*given, qdd, numbers=mp.mp)
        for found, digits in zip((forces, accelerations, matrices), exact, strict=True):
            assert isinstance(digits[0], mp.mpf)
            expected = np.array([float(x) for x in digits])
            assert np.abs(found.ravel() - expected).max() < 4e-14 * np.abs(expected).max()
        again = both.reference(*given, forces[0], numbers=mp.mp)[1]
        assert np.abs(np.array([float(x) for x in again]) - qdd).max() < 1e-12
    matrix = matrices[0]
    branches = matrix[3:6, 6:] if has_frames else matrix[2:5, 5:]
    assert np.array_equal(matrix == 0, (matrix == 0).T) and (branches == 0).all()  # they do not feel each other


@pytest.mark.compiles
@pytest.mark.parametrize("has_frames", [False, True])
@pytest.mark.parametrize("tag", ["f64_scalar", *(i.tag for i in OF_KERNELS if i.bits == 64 and runs(i))])
def test_every_instance_gives_the_same_bits(tag, has_frames):
    p = tree(has_frames)
    one, other = TreeDriver("pga3d", p, instance=BY_TAG[tag]), TreeDriver("pga3d", p)
    for found, expected in zip(results(one, 103, has_frames), results(other, 103, has_frames), strict=True):
        assert found.tobytes() == expected.tobytes()


@pytest.mark.compiles
@pytest.mark.parametrize("has_frames", [False, True])
@pytest.mark.parametrize("algebra", ALGEBRAS, ids=lambda a: a.name)
def test_text_for_numba_has_the_bits_of_c(algebra, has_frames):
    tree_loop.cache_clear()
    with numba_text_as_python():
        assert_same_bits(algebra, has_frames, 3)
    tree_loop.cache_clear()


@pytest.mark.peers
@pytest.mark.compiles
@pytest.mark.skipif(not FULL, reason="no full bars: a quarter of a minute for text that runs as Python above")
@pytest.mark.parametrize("has_frames", [False, True])
def test_numba_has_the_bits_of_c(has_frames):
    pytest.importorskip("numba")
    assert_same_bits(bs.cga3d, has_frames, 11)


def assert_same_bits(algebra, has_frames, count):
    """Of so many configurations."""
    p = tree(has_frames)
    one, other = TreeDriver(algebra.name, p, "numba"), TreeDriver(algebra.name, p)
    for found, expected in zip(results(one, count, has_frames), results(other, count, has_frames), strict=True):
        assert found.tobytes() == expected.tobytes()


@pytest.mark.compiles
@pytest.mark.parametrize("name", SHARED)
@pytest.mark.parametrize(("room", "has_frames"), [(CLASSES[0], False), (CLASSES[-1], True)])
def test_the_text_compiles_without_a_warning(name: str, room: int, has_frames: bool, tmp_path: Path) -> None:
    assert_clean(tree_extension("pga3d", room, name, has_frames=has_frames)[0], tmp_path)


@pytest.mark.compiles
@pytest.mark.parametrize("is_implicit", [False, True])
def test_the_text_of_motions_compiles_without_a_warning(is_implicit: bool, tmp_path: Path) -> None:
    assert_clean(tree_motion_program("pga3d", is_implicit).extension(), tmp_path)


def assert_clean(made: Any, tmp_path: Path) -> None:
    (tmp_path / "kernels.c").write_text(made.source)
    for header, text in made.headers.items():
        (tmp_path / header).write_text(text)
    command = [*extension.compiler().command, *C_FLAGS, "-O0", *WARNING_FLAGS, "-c", "kernels.c", "-o", "kernels.o"]
    run = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
    assert run.returncode == 0, run.stderr


def test_what_items_share_are_parameters():
    for name, shared in SHARED.items():
        parameters = [p.name for p in tree_function("cga3d", CLASSES[0], name).parameters]
        assert list(shared) == parameters[: len(shared)]
