"""Without a C compiler everything public gives an answer, or an error that says what is compiled and what to do."""

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import bladesmith as bs
from bladesmith import cga3d as cga
from bladesmith import codegen, curves, dynamics, kinematics, objects, registration, tracer
from bladesmith.cli import main
from bladesmith.codegen.build import toolchain
from bladesmith.codegen.build.extension import generated_extension, load
from bladesmith.codegen.build.installed import bundled_folder, headers, installed_program
from bladesmith.codegen.declarations import plain_spec
from bladesmith.codegen.generator import generate
from bladesmith.codegen.language import Real, Reals
from bladesmith.codegen.targets.capabilities import PROGRAMS, compiled_only, markdown_table
from bladesmith.dispatch import algorithm_loops, stock_algorithms
from bladesmith.dynamics.integration import program as simulation_program
from bladesmith.dynamics.integration.program import program_for
from bladesmith.errors import CompilerMissingError
from bladesmith.kinematics.mechanism import loop_calls
from bladesmith.kinematics.serial import driver
from bladesmith.tracer.rendering import program

from ..support.build.levels import compiler_at
from ..support.build.numba_code import shared_numba_code
from ..support.kinematics import FourBar, four_bar

CAMERA = tracer.Camera.look_at((0.0, -8.0, 2.0), (0.0, 0.0, 0.5))
LINES = cga.line(np.random.default_rng(0).normal(size=(9, 3)), np.random.default_rng(1).normal(size=(9, 3)))
MOTOR = cga.translator([1.0, 2.0, 3.0]).as_kind("motor")
DELTA = kinematics.DeltaRobot(0.4, 0.1, 0.5, 1.0)
Y = np.array([0.1, 0.2, 0.9])


def installed(test):
    """For a test of an installation that holds compiled programs."""
    return pytest.mark.compiles(pytest.mark.usefixtures("programs")(test))


@pytest.fixture(scope="module")
def programs():
    """The package's programs as a wheel holds them in which everything is compiled."""
    names = [name for name in ("scene", "merge", "reform") if installed_program(name) is None]
    modules = [f"bladesmith.generated.{name}._kernels" for name in names]
    with pytest.MonkeyPatch.context() as patch:
        if script := compiler_at("-O0"):
            patch.setenv("CC", script)
        for name, module in zip(names, modules, strict=True):
            sys.modules[module] = load(generated_extension(bundled_folder(name), headers()))
    installed_program.cache_clear()
    assert all(installed_program(name) for name in names)
    yield
    for name in modules:
        del sys.modules[name]
    installed_program.cache_clear()


@pytest.fixture(params=["CC", "PATH"])
def no_compiler(request, monkeypatch, tmp_path):
    """Nothing compiled in this process counts, nor what is in the cache; what begins the message."""
    monkeypatch.setenv("BLADESMITH_CACHE_DIR", str(tmp_path))
    if request.param == "CC":
        monkeypatch.setenv("CC", "/nonexistent/cc")
    else:
        monkeypatch.setenv("CC", "")
        monkeypatch.setenv("PATH", str(tmp_path))
        monkeypatch.setattr(toolchain, "find_spec", lambda _: None)
    caches = [program.engine_for, program._stock, driver._loop, loop_calls.mechanism_loop]
    caches.append(program_for)
    for each in caches:
        each.cache_clear()
    refused = set(cga.stock._refused)
    with shared_numba_code(tmp_path):
        yield "the C compiler CC='/nonexistent/cc' does not run" if request.param == "CC" else "no C compiler was found"
    for each in caches:
        each.cache_clear()
    cga.stock._refused.intersection_update(refused)


def circles(count):
    return [((0.6 * i, 0.1 * i * i, 0.0), (1.0, 0.2 * i, 0.1), 1.0 + 0.1 * i) for i in range(count)]


def pairs(count):
    return [((0.6 * i, 0.0, 0.0), (0.6 * i, 0.3 * i, 1.0)) for i in range(count)]


def render(surface):
    return tracer.Scene(CAMERA, [tracer.Light((4, -6, 8))], [surface]).render(8, 6)


def chain():
    return kinematics.Chain(kinematics.revolute_axis([[0, 0, 0], [1, 0, 0]], [0, 0, 1]))


def body():
    return dynamics.RigidBody(1.0, [1.0, 2.0, 3.0])


NEEDS_ONE = {
    "circles of degree 4": (lambda: render(tracer.EvolvedCircles(circles(5))), "evolved_circles_4 are compiled"),
    "circles of degree 6": (lambda: render(tracer.EvolvedCircles(circles(7))), "evolved_circles_6 are compiled"),
    "point pairs of degree 4": (lambda: render(tracer.EvolvedPointPairs(pairs(5))), "evolved_point_pairs_4 are"),
    "one ray": (lambda: tracer.EvolvedCircles(circles(5)).intersect([0, -9, 0], [0, 1, 0]), "evolved_circles_4 are"),
}


@installed
@pytest.mark.parametrize("name", NEEDS_ONE)
def test_what_needs_a_compiler_says_so(name, no_compiler, monkeypatch):
    make, what = NEEDS_ONE[name]
    monkeypatch.setattr(program, "find_spec", lambda _: None)  # numba is not there, either
    with pytest.raises(CompilerMissingError) as caught:
        make()
    message = str(caught.value)
    assert message.startswith(no_compiler) and what in message
    assert "Install gcc or clang" in message and "numba" not in message


@codegen.kernel(cga.kind("motor"), cga.kind("point"))
def moved(m, x):
    return m * x * ~m


SERVES = {
    **{f"circles of degree {n}": lambda n=n: render(tracer.EvolvedCircles(circles(n + 1))) for n in (1, 2, 3)},
    **{f"point pairs of degree {n}": lambda n=n: render(tracer.EvolvedPointPairs(pairs(n + 1))) for n in (1, 3)},
    "a sphere": lambda: render(tracer.Sphere((0, 0, 0), 1.0)),
    "a mesh of degree 4": lambda: tracer.mesh_of(tracer.EvolvedCircles(circles(5)), 6, 6).vertices,
    "a curve": lambda: curves.Bezier([cga.circle(*c) for c in circles(6)])(np.linspace(0, 1, 9)).values,
    "merging": lambda: objects.merge_similar(LINES, 0.5).objects.values,
    "kmeans": lambda: objects.kmeans(LINES, 3).labels,
    "costs": lambda: objects.cost_matrix(LINES, LINES),
    "costs in float32": lambda: objects.cost_matrix(LINES.astype(np.float32), LINES.astype(np.float32)),
    "registration": lambda: registration.estimate_rotor(LINES, MOTOR >> LINES).values,
    "matching": lambda: np.asarray(registration.match(LINES, LINES).indices),
    "a model": lambda: repr(registration.model_from_points(np.random.default_rng(2).normal(size=(400, 3)), 4)),
    "delta": lambda: DELTA.forward(DELTA.inverse(Y)),
    "delta in float32": lambda: DELTA.inverse(Y.astype(np.float32)),
    "delta precise": lambda: DELTA.forward(DELTA.inverse(Y, precise=True), precise=True),
    "delta by screws": lambda: DELTA.inverse_jacobian(Y, "screw"),
    "delta many": lambda: DELTA.inverse(np.tile(Y, (150_000, 1)), precise=True, threads=2)[::50_000],
    "delta workspace": lambda: DELTA.workspace(points=5).condition,
    "mobility": lambda: DELTA.mechanism(DELTA.inverse(Y)).mobility(),
    "a mechanism's Jacobian": lambda: DELTA.mechanism(DELTA.inverse(Y)).rank(),
    "a kernel": lambda: moved.on("numpy")(MOTOR, cga.point([1.0, 2.0, 3.0])).values,
}


@installed
@pytest.mark.parametrize("name", SERVES)
def test_what_does_not_need_one_gives_the_same(name, no_compiler, monkeypatch):
    found = SERVES[name]()
    monkeypatch.undo()
    for each in (program.engine_for, program._stock):
        each.cache_clear()
    expected = SERVES[name]()
    is_array = isinstance(found, np.ndarray)
    assert np.shape(found) == np.shape(expected) and np.array_equal(found, expected, equal_nan=is_array)


@pytest.fixture
def nothing_installed(monkeypatch):
    """No program is installed, and what this process compiled of algorithms does not count."""
    monkeypatch.setattr(stock_algorithms, "installed_program", lambda _: None)
    caches = [stock_algorithms.stock_algorithm, stock_algorithms._compiled_part, stock_algorithms._numba_module]
    for each in caches:
        each.cache_clear()
    yield
    for each in caches:
        each.cache_clear()


@pytest.mark.compiles
@pytest.mark.peers
def test_merging_runs_by_numba(no_compiler, nothing_installed, monkeypatch, caplog):
    pytest.importorskip("numba")
    found = objects.merge_similar(LINES, 2.0)
    assert [r for r in caplog.records if r.getMessage() == f"merge_line runs by numba: {no_compiler}."]
    monkeypatch.undo()
    stock_algorithms.stock_algorithm.cache_clear()
    expected = objects.merge_similar(LINES, 2.0)
    assert len(found.merge_costs) > 2
    assert np.array_equal(found.objects.values, expected.objects.values)
    assert np.array_equal(found.merge_costs, expected.merge_costs) and np.array_equal(found.pairs, expected.pairs)


def test_without_numba_merging_says_what_it_needs(no_compiler, nothing_installed, monkeypatch):
    monkeypatch.setattr(stock_algorithms, "find_spec", lambda _: None)
    with pytest.raises(CompilerMissingError) as caught:
        objects.merge_similar(LINES, 0.5)
    message = str(caught.value)
    assert message.startswith(no_compiler) and "merging is compiled at its first use" in message
    assert "Install gcc or clang" in message and "or numba" in message


CHAIN = {
    "forward": lambda chain: chain.forward([0.1, 0.2]).values,
    "jacobian": lambda chain: chain.jacobian([0.1, 0.2]),
    "velocity": lambda chain: chain.velocity([0.1, 0.2], [0.3, 0.4]).values,
    "inverse": lambda chain: chain.inverse(chain.forward([0.1, 0.2]), start=[0.2, 0.1]).q,
    "singularity": lambda chain: chain.singularity([0.1, 0.2]).singular_values,
}


@pytest.mark.peers
@pytest.mark.compiles
@pytest.mark.parametrize("no_compiler", ["PATH"], indirect=True)
def test_chains_run_by_numba_to_the_same_bits(no_compiler, monkeypatch, caplog):
    pytest.importorskip("numba")
    found = {name: run(chain()) for name, run in CHAIN.items()}
    told = {r.getMessage() for r in caplog.records if "chains" in r.getMessage()}
    assert f"inverse of chains runs by numba: {no_compiler}." in told
    monkeypatch.undo()
    driver._loop.cache_clear()
    for name, run in CHAIN.items():
        assert found[name].tobytes() == run(chain()).tobytes()


@pytest.mark.parametrize("name", CHAIN)
def test_chains_with_neither_say_so(name, no_compiler, monkeypatch):
    monkeypatch.setattr(algorithm_loops, "find_spec", lambda package: None)
    with pytest.raises(CompilerMissingError, match="chains are compiled at their first use") as caught:
        CHAIN[name](chain())
    assert str(caught.value).startswith(no_compiler) and "Install gcc or clang" in str(caught.value)


SIMULATIONS = {
    "a body": lambda: dynamics.Simulation(body()),
    "a system": lambda: dynamics.Simulation(DELTA.system(DELTA.inverse(Y))),
}


@pytest.mark.peers
@pytest.mark.compiles
@pytest.mark.parametrize("no_compiler", ["PATH"], indirect=True)
def test_simulations_run_by_numba_to_the_same_bits(no_compiler, monkeypatch, caplog):
    pytest.importorskip("numba")
    found = SIMULATIONS["a body"]().run(0.1)
    assert f"simulations run by numba: {no_compiler}." in {r.getMessage() for r in caplog.records}
    monkeypatch.undo()
    program_for.cache_clear()
    assert found.motor.values.tobytes() == SIMULATIONS["a body"]().run(0.1).motor.values.tobytes()


@pytest.mark.parametrize("name", SIMULATIONS)
def test_simulations_with_neither_say_so(name, no_compiler, monkeypatch):
    monkeypatch.setattr(simulation_program, "find_spec", lambda package: None)
    with pytest.raises(CompilerMissingError, match="simulations are compiled when they first run") as caught:
        SIMULATIONS[name]().run(0.1)
    assert str(caught.value).startswith(no_compiler) and "Install gcc or clang" in str(caught.value)


def test_poses_of_mechanisms_with_neither_say_so(no_compiler, monkeypatch):
    loop_calls.mechanism_loop.cache_clear()
    monkeypatch.setattr(algorithm_loops, "find_spec", lambda package: None)
    with pytest.raises(CompilerMissingError, match="poses of mechanisms are compiled at their first use") as caught:
        DELTA.mechanism(DELTA.inverse(Y)).solve_pose()
    assert str(caught.value).startswith(no_compiler) and "Install gcc or clang" in str(caught.value)


def bars():
    """Those of which numba keeps the code that `kinematics/mechanism/test_targets.py` compiles."""
    made = four_bar(FourBar().places(0.8), bs.pga3d)
    found = kinematics.Mechanism(made.bodies, made.fixed)
    for joint, name in zip(made.joints, made.joint_names, strict=True):
        found.add(joint, name)
    return found


def fresh_kernel():
    @codegen.kernel(cga.kind("motor"), cga.kind("point"))
    def shifted(m, x):
        return m * x * ~m

    return shifted


@pytest.mark.parametrize("numba", [pytest.param(True, marks=pytest.mark.peers), False])
def test_kernels_run_on_what_there_is(numba, no_compiler, monkeypatch, caplog):
    if numba:
        pytest.importorskip("numba")
    else:
        monkeypatch.setattr("bladesmith.codegen.kernels.compiled._has_numba", lambda: False)
    shifted = fresh_kernel()
    points = np.arange(15.0).reshape(5, 3)
    for dtype in (np.float64, np.float32):
        found = shifted(MOTOR.astype(dtype), cga.point(points.astype(dtype)))
        assert found.dtype == dtype and np.abs(found.values[:, 0] - points[:, 0] - 1).max() < 1e-5
    used = "numba" if numba else "numpy"
    told = {r.getMessage() for r in caplog.records if r.getMessage().startswith("shifted")}
    assert told == {f"shifted runs by {used}: {no_compiler}."}
    with pytest.raises(CompilerMissingError, match="a plan calls compiled C") as caught:
        shifted.plan(MOTOR, cga.point(points))
    assert str(caught.value).endswith("or call the kernel itself")


def test_folders_of_generated_kernels_run_as_plain_python(no_compiler, tmp_path, caplog):
    for name, text in generate(plain_spec(2, 0, 0, "without")).items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text)
    plane = bs.load_algebra(tmp_path)
    assert (plane.e1 * plane.e2).values.tolist() == [1.0]
    assert (plane.wrap(plane.kind("even"), np.array([2.0, 1.0])) * plane.e1).values.tolist() == [2.0, -1.0]
    assert plane.stock.library is None
    told = [r.getMessage() for r in caplog.records if "without" in r.getMessage()]
    assert told and all("numba" not in text and "generated kernels are compiled" in text for text in told)


def test_doctor_says_what_runs(no_compiler, capsys):
    assert main.run(["doctor", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["targets"]["C"] == "installed kernels only"
    assert "install gcc or clang" in found["compiler"]["compiler"]
    lacks = found["compiler"]["without it"]
    assert all(word in lacks for word in compiled_only())
    assert found["programs"]["scenes"].startswith("C: yes; numba: ")
    assert "target" not in found["compiler"]["compiler"] + lacks


@codegen.algorithm
def total(x: Reals) -> Real:
    """The sum of numbers."""
    result = 0.0
    for i in range(len(x)):
        result += x[i]
    return result


#: One call of each program of which nothing is installed here.
RUNS = {
    "kernels": lambda: fresh_kernel()(MOTOR, cga.point([1.0, 2.0, 3.0])),
    "algorithms": lambda: total(np.arange(4.0)),
    "table products": lambda: (
        bs.algebra(2, 1, 1).multivector(np.ones(16)) * bs.algebra(2, 1, 1).multivector(np.ones(16))
    ),
    "all pairs": lambda: objects.cost_matrix(LINES, LINES),
    "scenes": lambda: render(tracer.Sphere((0, 0, 0), 1.0)),
    "registration": lambda: registration.register(
        registration.Model(lines=LINES), registration.Model(lines=MOTOR >> LINES), backend="numba"
    ),
    "merging": lambda: objects.merge_similar(LINES, 0.5),
    "simulations": lambda: SIMULATIONS["a body"]().run(0.1),
    "chains": lambda: CHAIN["forward"](chain()),
    "mechanisms": lambda: bars().solve_pose({"a": 0.1}),
}


@pytest.mark.compiles
@pytest.mark.peers
@pytest.mark.parametrize("name", RUNS)
def test_the_table_of_targets_is_true(name, no_compiler, nothing_installed, monkeypatch):
    monkeypatch.setitem(sys.modules, "bladesmith.generated.scene._kernels", None)  # its import fails
    installed_program.cache_clear()
    try:
        if name in compiled_only():
            with pytest.raises(CompilerMissingError):
                RUNS[name]()
        else:
            RUNS[name]()
    finally:
        installed_program.cache_clear()


def test_the_table_of_targets_is_that_of_the_docs():
    assert RUNS.keys() == PROGRAMS.keys()
    text = (Path(__file__).parents[2] / "docs" / "algebra" / "targets.md").read_text(encoding="utf-8")
    assert markdown_table() in text


def test_no_text_is_made_for_nothing(tmp_path):
    """The error comes at once: not after seconds of printing programs that cannot be compiled."""
    script = (
        "import sys\nsys.modules['numba'] = None\n"
        "from bladesmith import dynamics, errors\n"
        "from bladesmith.codegen.programs.dynamics import dynamics as programs\n"
        "simulation = dynamics.Simulation(dynamics.RigidBody(1.0, [1.0, 2.0, 3.0]))\n"
        "try:\n    simulation.run(0.1)\nexcept errors.CompilerMissingError:\n"
        "    print(programs.dynamics_program.cache_info().currsize)\n"
    )
    env = {**os.environ, "CC": "/nonexistent/cc", "BLADESMITH_CACHE_DIR": str(tmp_path)}
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, env=env)
    assert done.stdout.strip() == "0", done.stderr
