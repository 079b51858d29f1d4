"""The backends of `reform.register`: numba and CUDA compute the bits of C, stage by stage and as a whole.

CUDA's text is compiled by NVRTC without a GPU; what would run on one runs here through the C compiler, thread by
thread, behind a stand-in for the driver. The last test runs on a real GPU where there is one.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from contextlib import suppress
from functools import partial
from itertools import combinations_with_replacement
from pathlib import Path
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np
import pytest

import bladesmith as bs
from bladesmith import registration
from bladesmith.codegen.build import installed
from bladesmith.codegen.build.flags import compiled_files, source_hash
from bladesmith.codegen.errors import DeviceError, InputError, MissingExtraError
from bladesmith.codegen.execute import cuda_items, numba_cache, numba_jit
from bladesmith.codegen.execute.cuda_driver import Device, unavailable
from bladesmith.codegen.execute.items import CompiledLoop
from bladesmith.codegen.programs.registration.program import ALGORITHMS, reform_numba
from bladesmith.codegen.programs.registration.registration import KINDS, matched_as, set_name
from bladesmith.codegen.targets.cuda.printer import DRIVER_OPTIONS, self_contained, stock_source
from bladesmith.registration.backends import algorithms, cuda, interface
from bladesmith.registration.backends.driver import Driver
from bladesmith.registration.backends.model_rows import CenterRule, MatchCriterion, ModelData
from bladesmith.registration.backends.scene import Scene

from ...support import cuda as cuda_support

COUNT = 40


class Backend(NamedTuple):
    """Constructors of what computes on a backend."""

    driver: Callable[..., Driver]
    scene: Callable[..., Scene]


def backend_of(name: str) -> Backend:
    return Backend(partial(Driver, backend=name), partial(Scene, backend=name))


def objects_of(kind: str, count: int, rng: np.random.Generator) -> bs.Multivector:
    """Random unit objects about the origin."""
    places, directions = rng.uniform(-1, 1, (count, 3)), rng.normal(size=(count, 3))
    sizes, others = rng.uniform(0.1, 0.5, count), rng.uniform(-1, 1, (count, 3))
    makers: dict[str, Callable[[], bs.Multivector]] = {
        "point": lambda: bs.cga3d.point(places),
        "point_pair": lambda: bs.cga3d.point_pair(places, others),
        "line": lambda: bs.cga3d.line(places, directions),
        "circle": lambda: bs.cga3d.circle(places, directions, sizes),
        "plane": lambda: bs.cga3d.plane(directions, sizes),
        "sphere": lambda: bs.cga3d.sphere(places, sizes),
    }
    return makers[matched_as(kind)]()


def ends_of(lines: bs.Multivector) -> np.ndarray:
    """The stretches (n, 2, 3) of lines from their points next to the origin, of length 1."""
    found = bs.cga3d.parameters(lines.as_kind("line"))
    return np.stack([found.point, found.point + found.direction], 1)


def models(kinds: tuple[str, ...], count: int = COUNT, seed: int = 3) -> tuple[registration.Model, registration.Model]:
    """A reference, and a query that lacks some of its objects, has others, and stands elsewhere."""
    rng = np.random.default_rng(seed)
    pose = bs.cga3d.translator(rng.normal(size=3)) * bs.cga3d.rotor(rng.normal(size=3), 2.0)
    shaken = bs.cga3d.translator(1e-3 * rng.normal(size=(count, 3)))
    query, reference = {}, {}
    for kind in kinds:
        known, extra = objects_of(kind, count, rng), objects_of(kind, count // 4, rng)
        moved = shaken >> (pose >> known)
        query[f"{kind}s"] = [*(moved[i] for i in range(count // 4, count)), *extra]
        reference[f"{kind}s"] = known
        if kind == "segment":
            query[f"{kind}s"] = np.concatenate([ends_of(moved[count // 4 :]), ends_of(extra)])
            reference[f"{kind}s"] = ends_of(known)
    return registration.Model(**query), registration.Model(**reference)


def stages(backend: Backend, kinds: tuple[str, ...], threads: int = 1, samples: int = 300) -> dict[str, list[Any]]:
    """What every stage returns for random input, by its name: the same input for every backend."""
    rng = np.random.default_rng(6)
    driver = backend.driver(kinds, threads)
    rows = [{k: np.asarray(objects_of(k, COUNT, rng)._data) for k in kinds} for _ in range(2)]
    rows[0][kinds[0]][3] = np.nan
    near = [rng.random(COUNT) < 0.5 for _ in kinds]
    for kind, same in zip(kinds, near, strict=True):
        rows[1][kind][same] = rows[0][kind][same]
    found = {f"elements of {k}": [driver.elements(k, rows[0][k])] for k in kinds}
    origin, other = rng.normal(size=(2, 3))
    found |= {f"{k} as seen from elsewhere": [driver.to_frame(k, rows[0][k], origin)] for k in kinds}
    placed = np.concatenate([driver.elements(k, rows[1][k]) for k in kinds])
    placed[::9, :3] += 100.0
    rule = CenterRule(8, round(0.75 * len(placed)), 3.0, 1e-12, 1e-6)
    found["robust_center"] = [driver.robust_center(np.repeat([KINDS.index(k) for k in kinds], COUNT), placed, rule)]
    found["motors_to_world"] = [
        driver.motors_to_world(driver.step(np.eye(8)[0], rng.normal(size=6))[None], origin, other)
    ]
    found["unseen twists"] = [driver.twists_to_world(rng.normal(size=(5, 6)), origin)]
    pairs = rng.integers(0, COUNT, (2, samples))
    for a, b in combinations_with_replacement(kinds, 2):
        found[f"invariants of {a}, {b}"] = [driver.invariants((a, b), (rows[0][a], rows[1][b]), tuple(pairs))]
        some = np.arange(0, COUNT, 2), np.arange(0, COUNT, 2 if a == b else 3)
        found[f"invariants of all {a}, {b}"] = list(driver.invariants_of_all((a, b), (rows[0][a], rows[1][b]), some))
    motor = driver.step(np.eye(8)[0], rng.normal(size=6) / 8)
    found["step"] = [motor]
    sides = [ModelData(r, {k: driver.elements(k, x) for k, x in r.items()}) for r in rows]
    asked_kinds = np.repeat([KINDS.index(k) for k in kinds], COUNT)
    asked_rows = np.tile(np.arange(COUNT), len(kinds))
    scene = backend.scene(*sides, asked_kinds, asked_rows, threads)
    scene.set_criterion(MatchCriterion((0.75, 0.25, 0.75), 0.2**2, 0.05))
    sets = rng.integers(0, len(asked_rows), (samples, 3))
    of, row = asked_kinds[sets], asked_rows[sets]
    of[::7, 2] = -1
    signs, others = rng.choice([-1.0, 1.0], (samples, 3)), rng.integers(0, COUNT, (samples, 3))
    images = np.where(rng.random((samples, 1)) < 0.5, row, others)
    found["stiffness"] = [scene.conditioning(of, row)]
    found["samples"] = list(scene.samples(of, row, images, signs, 10.0))
    starts = np.concatenate([motor[None], np.eye(8)[:1], found["samples"][0][:6]])
    starts = starts[np.isfinite(starts).all(1)]
    found["refine"] = list(scene.refine(starts, 10))
    found["match"] = list(scene.match(np.eye(8)[0]))
    ends = rng.uniform(-1, 1, (2, COUNT, 6))
    if "segment" in kinds:
        found["match_segments"] = list(scene.match_segments(np.arange(COUNT), motor, *ends))
    forms = rng.normal(size=(COUNT, 6, 7))
    found["residual_rates"] = [scene.residual_rates(motor, ends[0], directed, forms) for directed in (0, 1)]
    found["rates"] = [scene.rates(k, motor, *pairs % COUNT) for k in kinds]
    paired = {k: (np.arange(COUNT), np.arange(COUNT)) for k in kinds}
    weights = rng.choice([0.0, 0.5, 2.0], COUNT * len(kinds))
    for given in (None, weights):
        lowest, rates, steps = scene.descend(motor, paired, given, 6)
        found[f"descend, {'no' if given is None else 'some'} weights"] = [lowest, rates, np.array(steps)]
    whiten = np.linalg.qr(rng.normal(size=(6, 6)))[0] * np.array([0.3, 0.2, 0.2, 0.1, 0.1, 0.0])
    found["influences"] = list(driver.influences(rates, whiten))
    matches, others = np.stack([asked_kinds, asked_rows]), rng.integers(-1, COUNT, len(asked_kinds))
    partners = np.where(others < 0, -1, others + COUNT * (np.arange(len(others)) // COUNT))
    start, turned = np.eye(8)[0], rng.choice([-1.0, 1.0], len(others))
    for rounds in (0, 4):
        moved, changes, skipped = scene.direct(start, (*matches, matches[1], partners, turned), rounds, 0.0)
        found[f"{rounds} rounds of Algorithm 1"] = [moved, changes, np.array(skipped)]
    scene.select_objects(asked_kinds[::-2], asked_rows[::-2])
    scene.set_criterion(MatchCriterion((0.75, 0.5, 0.25), 0.3**2, 0.0, align=False))
    found["match others"] = list(scene.match(motor))
    return found


def assert_same_bits(actual: dict[str, list[Any]], expected: dict[str, list[Any]]) -> None:
    assert actual.keys() == expected.keys()
    for name, results in expected.items():
        for mine, theirs in zip(actual[name], results, strict=True):
            assert mine.dtype == theirs.dtype and mine.shape == theirs.shape, name
            different = (mine != theirs) & ~((mine != mine) & (theirs != theirs))
            assert not different.any(), f"{name}: {mine[different][:3]} instead of {theirs[different][:3]}"


def assert_same_answer(backend: str, kinds: tuple[str, ...]) -> None:
    query, reference = models(kinds)
    mine, theirs = (registration.register(query, reference, seed=2, backend=name) for name in (backend, "c"))
    assert theirs.converged and np.asarray(theirs.matches).max() > 0
    assert np.array_equal(np.asarray(mine.matches), np.asarray(theirs.matches))
    assert np.array_equal(mine.motor.values, theirs.motor.values)
    assert mine.converged and mine.cost == theirs.cost


def test_stages_have_something_to_do() -> None:
    found = stages(backend_of("c"), KINDS)
    scores, hits, tested = found["samples"][1:]
    assert (scores > 0).any() and (scores < 0).any() and (hits > 3).any() and len(set(tested)) > 2
    assert (found["match"][0] >= 0).any() and (found["match"][0] < 0).any() and (found["match"][2] < 0).any()
    assert (found["match_segments"][0] >= 0).any() and (found["match_segments"][0] < 0).any()
    assert (found["refine"][3] > 1).any() and (found["stiffness"][0] > 0).any() and (found["stiffness"][0] == 0).any()
    assert np.isnan(found[f"elements of {KINDS[0]}"][0][3]).any()
    moved, changes, skipped = found["4 rounds of Algorithm 1"]
    assert np.isfinite(moved).all() and len(changes) == 4 and 0 < skipped < COUNT * len(KINDS)


def test_an_unknown_backend_is_refused() -> None:
    with pytest.raises(InputError, match="'opencl'.*c, numba, cuda"):
        Driver(KINDS, backend="opencl")


# -- the program that is installed ---------------------------------------------------------------------


@pytest.mark.compiles
def test_the_installed_driver_is_taken_where_it_is_fresh(monkeypatch: pytest.MonkeyPatch) -> None:
    carried, made = SimpleNamespace(ffi=SimpleNamespace(from_buffer=None)), []
    monkeypatch.setattr(algorithms, "load", made.append)
    for module, compiled in ((carried, 0), (None, 1)):
        algorithms.c_algorithms.cache_clear()
        monkeypatch.setattr(algorithms, "installed_program", lambda name, m=module: m if name == "reform" else None)
        with suppress(AttributeError):  # what `load` gives here has no functions
            algorithms.c_algorithms(("line",))
        assert len(made) == compiled
    assert "bs_samples_line_f64" in made[0].cdef
    algorithms.c_algorithms.cache_clear()


def test_programs_older_than_their_sources_are_left(tmp_path: Path) -> None:
    (tmp_path / "kernels.c").write_text('#include "platform.h"\n')
    made_of = source_hash(compiled_files(tmp_path, installed.headers()))

    def module(text: str) -> Any:
        ffi = SimpleNamespace(string=str.encode)
        return SimpleNamespace(ffi=ffi, lib=SimpleNamespace(bs_source_hash=lambda: text))

    assert installed.is_fresh(module(made_of), tmp_path) and installed.is_fresh(module(""), tmp_path)
    (tmp_path / "kernels.c").write_text('#include "instance.h"\n')
    assert not installed.is_fresh(module(made_of), tmp_path)
    assert installed.installed_program("absent") is None


# -- numba ---------------------------------------------------------------------------------------------


@pytest.mark.peers
@pytest.mark.slow
@pytest.mark.parametrize("threads", [1, 2])
def test_numba_computes_the_bits_of_c(threads: int) -> None:
    assert_same_bits(stages(backend_of("numba"), ("line",), threads), stages(backend_of("c"), ("line",)))


@pytest.mark.peers
def test_numba_gives_the_answer_of_c() -> None:
    assert_same_answer("numba", ("line",))


@pytest.mark.slow
def test_the_python_text_computes_the_bits_of_c_for_all_kinds(monkeypatch: pytest.MonkeyPatch) -> None:
    """Run as it is, without numba: that takes 30 s to compile for all kinds."""
    names: dict[str, Any] = {}
    exec(reform_numba(KINDS), names)
    entries = algorithms.entries_of(KINDS)
    text = algorithms.Algorithms(
        set_name(KINDS), entries, lambda entry: CompiledLoop(names[f"bs_{entry.name}"]), np.ravel
    )
    monkeypatch.setitem(interface.BACKENDS, "numba", lambda kinds: text)
    with np.errstate(all="ignore"):
        mine = stages(backend_of("numba"), KINDS, samples=20)
    assert_same_bits(mine, stages(backend_of("c"), KINDS, samples=20))


@pytest.mark.peers
def test_machine_code_is_kept_and_other_text_is_not_trusted(tmp_path: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("BLADESMITH_CACHE_DIR", str(tmp_path))
    types = numba_jit.numba().types
    text = "def twice(x):\n    return helped(x) * 2.0\n\n\ndef helped(x):\n    return x\n"

    def made() -> Any:
        return numba_cache.CachedModule("twice", text, {"twice": types.f8(types.f8)})["twice"]

    first, second = made(), made()
    assert first(4.0) == second(4.0) == 8.0
    assert not first.stats.cache_hits and second.stats.cache_hits
    (file,) = tmp_path.glob("*/*.py")
    file.write_text("def twice(x):\n    return 0.0\n")
    assert made()(4.0) == 8.0 and file.read_text() == text
    for code in tmp_path.glob("*/__pycache__/*.nbc"):
        code.write_bytes(b"damaged")
    assert made()(4.0) == 8.0


def test_without_numba_the_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    def absent() -> None:
        raise MissingExtraError("numba", "This")

    monkeypatch.setattr(numba_cache, "numba", absent)
    algorithms.numba_algorithms.cache_clear()
    with pytest.raises(MissingExtraError, match=r"bladesmith\[numba\]"):
        registration.register(*models(("plane",)), backend="numba")


@pytest.mark.peers
def test_without_a_compiler_numba_registers(monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture) -> None:
    reference, query = models(("line",), 12)
    expected = registration.register(query, reference, seed=2), registration.estimate_rotor(reference, reference)
    monkeypatch.setattr(algorithms, "installed_program", lambda name: None)
    monkeypatch.setattr(algorithms, "compiler", lambda: None)
    algorithms.c_algorithms.cache_clear()
    found = registration.register(query, reference, seed=2), registration.estimate_rotor(reference, reference)
    algorithms.c_algorithms.cache_clear()
    assert "registration runs by numba" in caplog.text
    assert np.array_equal(found[0].motor.values, expected[0].motor.values)
    assert np.array_equal(found[1].values, expected[1].values)


# -- CUDA ----------------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("kinds", [("line",), KINDS], ids=["lines", "all kinds"])
def test_the_driver_compiles_for_a_gpu_without_a_warning(kinds: tuple[str, ...]) -> None:
    compiled = cuda_support.compiled_for_gpus(stock_source(algorithms.program_of(kinds).files), options=DRIVER_OPTIONS)
    assert compiled.log == ""
    ptx = compiled.image.decode()
    launchers = {f"launch_bs_{each.name}_{set_name(kinds)}_f64" for each in ALGORITHMS}
    assert set(re.findall(r"\.entry (\w+)\(", ptx)) == launchers
    assert not re.search(r"\bfma\.|\.approx|\.ftz", re.sub(r"//.*", "", ptx))


@pytest.mark.skipif(not unavailable(), reason="there is a GPU")
def test_without_a_gpu_the_error_says_what_to_do() -> None:
    cuda.gpu.cache_clear()
    with pytest.raises(DeviceError, match=r'backend="cuda" needs a GPU.*backend="c"'):
        registration.register(*models(("line",)), backend="cuda")


def stand_in(kinds: tuple[str, ...]) -> str:
    """Path of a library that looks like the GPU's driver and runs the launchers thread by thread."""
    text = self_contained(stock_source(algorithms.program_of(kinds).files))
    types = ("long long", "long long", "bs_items")
    launchers = {f"launch_bs_{name}_f64": types for name in algorithms.entries_of(kinds)}
    return cuda_support.stand_in("reform_stand_in", text, launchers)


@pytest.fixture
def device(monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[[tuple[str, ...]], Device]]:
    """Puts a stand-in for some kinds in the GPU's place."""

    def placed(kinds: tuple[str, ...]) -> Device:
        made = Device(driver=stand_in(kinds))
        cuda.cuda_module.cache_clear()
        monkeypatch.setattr(cuda, "gpu", lambda: made)
        monkeypatch.setattr(cuda_items, "compile_cached", lambda *_: b"no image")
        return made

    yield placed
    cuda.cuda_module.cache_clear()


@pytest.mark.compiles
@pytest.mark.parametrize("kinds", [("line",), KINDS], ids=["lines", "all kinds"])
def test_the_cuda_text_computes_the_bits_of_c(
    kinds: tuple[str, ...], device: Callable[[tuple[str, ...]], Device]
) -> None:
    used = device(kinds)
    assert_same_bits(stages(backend_of("cuda"), kinds), stages(backend_of("c"), kinds))
    used.call("bs_left_open")  # fails unless it returns zero: nothing stays allocated


@pytest.mark.peers
def test_cuda_gives_the_answer_of_c(device: Callable[[tuple[str, ...]], Device]) -> None:
    device(("line",))
    assert_same_answer("cuda", ("line",))


@pytest.mark.peers
@pytest.mark.skipif(bool(unavailable()), reason=f"no GPU to run on: {unavailable()}")
@pytest.mark.parametrize("kinds", [("line",), KINDS], ids=["lines", "all kinds"])
def test_a_gpu_computes_the_bits_of_c(kinds: tuple[str, ...]) -> None:
    assert_same_bits(stages(backend_of("cuda"), kinds), stages(backend_of("c"), kinds))
    assert_same_answer("cuda", kinds)
