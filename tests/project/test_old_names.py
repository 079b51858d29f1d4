"""Old public names and keywords that stay for one release: each works as the new one does, and warns."""

from __future__ import annotations

import sys
from collections.abc import Callable
from importlib import import_module
from typing import Any

import numpy as np
import pytest

from bladesmith import cga3d, curves, dynamics, kinematics, objects, plot, registration, tracer
from bladesmith.common import deprecation
from bladesmith.interchange.meshes import Mesh

X, Y = cga3d.circle((0, 0, 1), (0, 0, 1), 1.0), cga3d.circle((0, 1, 1), (0, 0.6, 0.8), 2.0)
CAP = cga3d.circle((0, 0, 2), (0, 0, 1), 1.0)
L, M = cga3d.line((0, 0, 1), (1, 0, 0)), cga3d.line((0, 1, 2), (0, 0.6, 0.8))
T = dynamics.twist((1, 2, 3), (4, 5, 6))
W = dynamics.wrench((1, 0, 2), (0, 1, 0))
HINGE = kinematics.Mechanism(["a", "b"], "a")
HINGE.add(kinematics.Revolute("a", "b", X))
ROTOR = cga3d.rotor((0, 0, 1), 1.0)


def values(x: Any) -> Any:
    """Numbers of a result, whatever it is."""
    if isinstance(x, tuple) or hasattr(x, "labels"):
        return np.concatenate([values(each) for each in x])
    return np.ravel(getattr(x, "values", x))


KEYWORDS: list[tuple[Callable[..., Any], dict[str, Any], tuple[str, ...]]] = [
    *((f, {"X": X, "Y": Y}, ("X1", "X2")) for f in (objects.rotor_between, objects.mirror_between, objects.trs_rotor)),
    (objects.rotor_between, {"X": X, "Y": Y}, ("x1", "x2")),
    *((f, {"X": X, "Y": Y, "alpha": 0.3}, ("X1", "X2")) for f in (objects.interpolate, objects.interpolate_derivative)),
    *((f, {"X": X, "Y": CAP}, ("C1", "C2")) for f in (objects.common_sphere, objects.orthogonal_sphere)),
    *((f, {"X": L, "Y": M}, ("first", "second")) for f in (objects.closest_point, objects.screw_of_lines)),
    *((f, {"X": L, "Y": X}, ("a", "b")) for f in (objects.join, objects.meet)),
    *((f, {"X": T, "Y": T}, ("a", "b")) for f in (dynamics.killing_form, dynamics.screw_cross)),
    (dynamics.reciprocal, {"X": T, "Y": W}, ("a", "b")),
    (HINGE.allowed_twists, {"relative_to": "a", "body": "b"}, ("against",)),
    (objects.rotor_cost, {"cost": "thesis", "R": ROTOR}, ("kind",)),
    (objects.cost_matrix, {"cost": "thesis", "X": X, "Y": Y}, ("kind",)),
    (objects.kmeans, {"cost": "thesis", "iterations": 3, "X": L[None], "k": 1}, ("kind", "max_iterations")),
]


@pytest.fixture(autouse=True)
def nothing_warned(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(deprecation, "_warned", set())


@pytest.mark.parametrize(("function", "arguments", "old"), KEYWORDS)
def test_old_keywords(function: Callable[..., Any], arguments: dict[str, Any], old: tuple[str, ...]) -> None:
    renamed = {new: name for name, new in zip(old, arguments, strict=False)}
    with pytest.warns(FutureWarning) as seen:
        found = function(**{renamed.get(name, name): x for name, x in arguments.items()})
    expected = {f"{function.__qualname__}({name}=) is now {new}=" for new, name in renamed.items()}
    assert {str(each.message).partition(";")[0] for each in seen} == expected
    np.testing.assert_array_equal(values(found), values(function(**arguments)))


def test_the_target_of_a_linear_pin_is_called_as_that_of_a_bilinear_joint() -> None:
    plane = cga3d.plane((0, 0, 1), 0.5)
    with pytest.warns(FutureWarning, match=r"PinLinear\(target=\) is now H="):
        pin = dynamics.PinLinear(lambda x: x, plane, target=plane)
    assert pin.H is plane
    with pytest.warns(FutureWarning, match="PinLinear.target is now PinLinear.H"):
        assert pin.target is plane


BALL = tracer.Sphere((0, 0, 0), 1.0).mesh(4, 4)
CURVE = curves.Bezier([X, Y])
STRETCHED = kinematics.Chain([kinematics.revolute_axis((0, 0, 0), (0, 0, 1))], cga3d.translator((1, 0, 0)))
ATTRIBUTES: list[tuple[Any, str, str]] = [
    (CURVE, "turned", "with_flipped_controls"),
    (CURVE, "given", "original_controls"),
    (BALL, "welded", "weld"),
    (BALL, "moved", "transformed"),
    (X, "scaled", "scale_blades"),
    (HINGE, "redundant", "self_stresses"),
    (objects.merge_similar(L[None], 1.0), "merges", "merge_costs"),
    (STRETCHED.singularity([0.0]), "lost", "lost_twist"),
    (STRETCHED.singularity([0.0]), "still", "null_rates"),
    (STRETCHED.singularity([0.0]), "values", "singular_values"),
    (kinematics.DeltaRobot(0.4, 0.1, 0.5, 1.0).singularity((0.1, 0.2, 0.3)), "lost", "lost_direction"),
    (dynamics, "recorded", "as_record"),
    (plot, "skipped", "count_skipped"),
]


@pytest.mark.parametrize(("owner", "old", "new"), ATTRIBUTES, ids=[old for _, old, _ in ATTRIBUTES])
def test_old_attributes(owner: Any, old: str, new: str) -> None:
    with pytest.warns(FutureWarning, match=rf"\.{old} is now \S+\.{new};"):
        found = getattr(owner, old)
    assert found == getattr(owner, new) if callable(found) else str(found) == str(getattr(owner, new))


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("codegen.formulas.blades", "codegen.formulas.objects.blades"),
        ("codegen.pairs", "codegen.execute.pairs"),
        ("kinematics.document", "kinematics.io.reader"),
        ("kinematics.pictures", "kinematics.plotting.picture"),
        ("report", "benchmarks"),
    ],
)
def test_old_modules_that_the_docs_imported(old: str, new: str, monkeypatch: pytest.MonkeyPatch) -> None:
    package, _, name = f"bladesmith.{old}".rpartition(".")
    monkeypatch.delitem(sys.modules, f"bladesmith.{old}", raising=False)
    monkeypatch.delitem(vars(import_module(package)), name, raising=False)
    with pytest.warns(FutureWarning, match=f"bladesmith.{old} is now bladesmith.{new};") as seen:
        found = import_module(f"bladesmith.{old}")
    assert found is import_module(f"bladesmith.{new}")
    assert seen[0].filename == __file__
    namespace: dict[str, Any] = {}
    exec(f"from {package} import {name} as again", namespace)  # the spelling of the docs
    assert namespace["again"] is found


@pytest.mark.peers
def test_old_options_of_models_from_points() -> None:
    xyz = np.random.default_rng(0).normal(size=(60, 3)) * (1, 1, 0)
    with pytest.warns(FutureWarning, match="is now (min_points|max_objects)="):
        found = registration.model_from_points(xyz, 1e-6, ["plane"], least=20, most=1)  # type: ignore[call-overload]
    assert found.counts == {"plane": 1}


def test_old_options_of_models_from_meshes() -> None:
    with pytest.warns(FutureWarning, match="is now min_size="):
        registration.model_from_mesh(Mesh(BALL.vertices, BALL.faces), least=0.1)  # type: ignore[call-arg]
