"""Roots of rays on evolved surfaces against references of 50 digits (tests/oracles/references): none lost, none false.

A parameter may be off by `ROUNDINGS` units of rounding times the condition number of the root, which the reference
has from the definition. Two roots count as two as long as the condition between them exceeds what rounding makes of
it; rays that graze a surface closer than that, and only those, may be answered by one touching root, two or none.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from hashlib import sha256

import numpy as np
import pytest

from bladesmith import cga3d, tracer
from bladesmith.curves import KochanekBartels

from ...oracles.references.families import (
    FAMILIES,
    MARGIN_ZERO,
    PER_DECADE,
    Controls,
    Family,
    controls,
    input_bytes,
    rays,
)
from ...support.checkout import CHECKOUT

FOLDER = CHECKOUT / "tests" / "oracles" / "references"
UNIT = 2.0**-53
#: What a parameter may be off by, in units of rounding times its condition number: pairs that nearly share a circle
#: are told in a frame of their own.
ROUNDINGS = {"circles": 8, "pairs": 1024}
#: Rays near tangents are decided where the condition between the roots is this many units of its rounding.
DECIDED = {"circles": 32, "pairs": 128}
CERTAIN = [name for name, family in FAMILIES.items() if family.nature != "grazing"]
#: Those that run by default: one of each nature and kind.
QUICK = ("circles_far", "circles_tangent", "pairs_tangent", "pairs_cubic")
GRAZING = [name for name in FAMILIES if name not in CERTAIN]
#: Of rays 1e-9 off tangents so many may be undecided: those at places where the surface itself is nearly singular.
FEW = 0.002


@dataclass(frozen=True)
class Answers:
    """Of all rays: wanted roots with their conditions, found ones, both rising; which rounding does not leave open."""

    wanted: list[np.ndarray]
    condition: list[np.ndarray]
    found: list[np.ndarray]
    decided: np.ndarray


def surface_of(family: Family, objects: Controls):
    """The surface, its objects given by parameters wherever a curve takes them."""
    made = tracer.EvolvedCircles if family.kind == "circles" else tracer.EvolvedPointPairs
    given = objects.given()
    if family.curve == "bezier":
        return made(given)
    if family.kind == "pairs":
        given = cga3d.point_pair(*(np.array(ends) for ends in zip(*given, strict=True)))
    return made(KochanekBartels(given, *objects.shape))


@cache
def answers(name: str) -> Answers:
    """What the tracer says about a family, beside the file; the inputs are those that the file was made from."""
    family = FAMILIES[name]
    with np.load(FOLDER / f"{name}.npz") as file:
        data = dict(file)
    found, digest = [], sha256()
    for number, attempt in enumerate(data["attempts"]):
        objects = controls(family, number, int(attempt))
        origins, directions = rays(family, number, objects)
        origins = origins + objects.shift
        digest.update(input_bytes(objects.given(), origins, directions))
        surface = surface_of(family, objects)
        assert not np.any(surface.flipped)
        hits = surface.intersect(origins, directions)
        assert np.all((hits.count > 0) | np.isnan(hits.alpha[:, 0]))
        check_points(hits, origins, directions, max(1.0, float(np.abs(objects.shift).max())))
        found += [np.sort(row[:count]) for row, count in zip(hits.alpha, hits.count, strict=True)]
    assert digest.digest() == data["digest"].tobytes(), "this machine makes other inputs than the file was made from"
    ends = np.cumsum(data["counts"].ravel())[:-1]
    condition = 10.0 ** (data["condition"] / PER_DECADE)
    decided = np.ones(len(found), bool)
    if "margin" in data:
        decided = 10.0 ** ((data["margin"].ravel() - float(MARGIN_ZERO)) / PER_DECADE) > DECIDED[family.kind] * UNIT
    return Answers(np.split(data["roots"], ends), np.split(condition, ends), found, decided)


def check_points(hits, origins, directions, size):
    """Points are where their t says, on the ray."""
    unit = directions / np.linalg.norm(directions, axis=-1, keepdims=True)
    there = origins[:, None] + hits.t[..., None] * unit[:, None]
    miss = np.abs(hits.point - there)
    assert np.array_equal(np.isnan(hits.t), np.isnan(hits.alpha))
    assert not np.any(miss > 1e-6 * size + 1e-14 * np.abs(hits.t[..., None]))


def first_of(bad, a: Answers) -> str:
    return "; ".join(f"ray {i}: wanted {a.wanted[i].tolist()}, found {a.found[i].tolist()}" for i in bad[:3])


def wrong(a: Answers) -> np.ndarray:
    """By how many roots the tracer finds more than there are, for each ray."""
    return np.array([len(f) - len(w) for w, f in zip(a.wanted, a.found, strict=True)])


@pytest.mark.slow
@pytest.mark.parametrize("name", CERTAIN)
def test_no_root_is_lost_and_none_is_false(name):
    a = answers(name)
    bad = np.flatnonzero(a.decided & (wrong(a) != 0))
    assert not len(bad), f"{len(bad)} of {len(a.wanted)} rays; {first_of(bad, a)}"
    assert np.mean(~a.decided) <= FEW


@pytest.mark.parametrize(
    "name", [name if name in QUICK else pytest.param(name, marks=pytest.mark.slow) for name in CERTAIN]
)
def test_roots_are_off_by_little_more_than_their_condition(name):
    a = answers(name)
    same = np.flatnonzero(wrong(a) == 0)
    wanted, found, condition = (np.concatenate([x[i] for i in same]) for x in (a.wanted, a.found, a.condition))
    assert len(wanted) > 0.2 * len(a.wanted)
    off = np.abs(wanted - found) / (condition * UNIT)
    assert off.max() <= ROUNDINGS[FAMILIES[name].kind], f"{off.max():.3g} units at {wanted[off.argmax()]!r}"


@pytest.mark.parametrize("name", GRAZING)
def test_only_what_rounding_hides_is_left_open(name):
    """Rays that miss being tangent by 1e-18 to 1e-6: above the rounding of the condition answers are exact."""
    a = answers(name)
    assert 0.3 < a.decided.mean() < 0.7
    more = wrong(a)
    bad = np.flatnonzero(a.decided & (more != 0))
    assert not len(bad), f"{len(bad)} of {a.decided.sum()} rays; {first_of(bad, a)}"
    assert np.all(np.abs(more) <= 2)
