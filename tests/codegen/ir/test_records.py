"""Records: one declaration for algorithms, NumPy and C."""

from __future__ import annotations

import subprocess
from pathlib import Path

import mpmath
import numpy as np
import pytest

from bladesmith import errors
from bladesmith.codegen import algorithm
from bladesmith.codegen.build import extension
from bladesmith.codegen.language import InOut, Int, IntVector, Matrix, Out, Real, Reals, Rows, Vector, record

Body = record("Body", mass=Real, position=Vector[3], inertia=Matrix[3, 3], energy=Real)


@algorithm
def quadratic_form(a: Matrix[3, 3], x: Vector[3]) -> Real:
    """x^T a x."""
    total = 0.0
    for i in range(3):
        for j in range(3):
            total += a[i, j] * x[i] * x[j]
    return total


@algorithm
def energies(bodies: InOut[Rows[Body]], spin: Vector[3], heaviest: Out[Body]) -> Real:
    """Energies of bodies, and a copy of the heaviest."""
    total = 0.0
    best = 0
    for i in range(len(bodies)):
        body = bodies[i]
        body.energy = 0.5 * quadratic_form(body.inertia, spin)
        body.energy += 9.81 * body.mass * bodies[i].position[2]
        body.position[2] -= 1.0
        total += body.energy
        if body.mass > bodies[best].mass:
            best = i
    heaviest[:] = bodies[best]
    heaviest.inertia[0, 0] = -1.0
    return total


def bodies(n: int) -> np.ndarray:
    return np.random.default_rng(3).uniform(0.5, 2.0, (n, Body.size))


@pytest.mark.skipif(extension.compiler() is None, reason="no C compiler")
def test_fields_in_c_and_python_are_those_of_numpy() -> None:
    given, spin = bodies(6), np.array([1.0, -2.0, 0.5])
    found, heaviest, total = energies(given, spin)
    expected = Body.view(given.copy())
    rotation = 0.5 * np.einsum("nij,i,j->n", expected.inertia, spin, spin)
    expected.energy = rotation + 9.81 * expected.mass * expected.position[:, 2]
    expected.position[:, 2] -= 1.0
    assert np.allclose(found, expected, rtol=1e-14) and abs(total - expected.energy.sum()) < 1e-12
    assert Body.view(heaviest).mass == expected.mass.max() and Body.view(heaviest).inertia[0, 0] == -1.0
    for a, b in zip(energies.reference(given, spin), (found, heaviest, total), strict=True):
        assert np.array_equal(a, b)
    context = mpmath.mp.clone()
    context.dps = 50
    precise = energies.reference(given, spin, numbers=context)[2]
    assert abs(float(precise) - total) < 1e-13 * abs(total)


@pytest.mark.compiles
@pytest.mark.peers
def test_numba_has_the_bits_of_c() -> None:
    arguments = bodies(5), np.array([1.0, -2.0, 0.5])
    for a, b in zip(energies(*arguments), energies.on("numba")(*arguments), strict=True):
        assert np.array_equal(a, b)


Cell = record("Cell", begin=Int, sides=IntVector[2])


@algorithm
def neighbour(cells: InOut[Rows[Cell]], at: Int) -> Int:
    """Fields of integers."""
    cell = cells[at]
    cell.sides[1] += 10 * cell.begin
    cells[at + 1].sides[:] = cell.sides
    return cell.sides[0]


@pytest.mark.skipif(extension.compiler() is None, reason="no C compiler")
def test_records_of_integers() -> None:
    cells = Cell.zeros(3)
    cells.begin = [4, 5, 6]
    cells.sides = [[1, 2], [3, 4], [5, 6]]
    assert cells.dtype == np.int64
    changed, first = neighbour(cells, 1)
    assert first == 3 and Cell.view(changed).sides.tolist() == [[1, 2], [3, 54], [3, 54]]
    reference, first = neighbour.reference(cells, 1)
    assert first == 3 and np.array_equal(reference, changed)


def test_arrays_with_fields() -> None:
    rows = Body.zeros(4)
    rows.position = [1.0, 2.0, 3.0]
    rows.mass = np.arange(4.0)
    rows[2].inertia = np.eye(3)
    assert rows.shape == (4, 14) and rows[:, 0].tolist() == [0, 1, 2, 3]
    assert rows.position.tolist() == [[1, 2, 3]] * 4 and rows[2].inertia.trace() == 3
    assert rows[1].mass == 1.0 and (rows[1:3] * 2).mass.tolist() == [2, 4]
    with pytest.raises(AttributeError, match="no field 'velocity' of Body"):
        _ = rows.velocity
    with pytest.raises(AttributeError, match="no field 'mass'"):
        _ = rows[:, 1:].mass
    with pytest.raises(errors.AlgorithmError, match="last axis must be 14"):
        Body.view(np.zeros(3))


@pytest.mark.skipif(extension.compiler() is None, reason="no C compiler")
def test_offsets_in_c(tmp_path: Path) -> None:
    checks = "".join(f'_Static_assert(BODY_{n.upper()} == {at}, "");\n' for n, at in Body.offsets.items())
    text = Body.c_text("BODY") + checks + '_Static_assert(BODY_SIZE == 14, "");\n'
    (tmp_path / "body.c").write_text(text, encoding="utf-8")
    subprocess.run([*extension.required_compiler().command, "-std=c11", "-c", "body.c"], cwd=tmp_path, check=True)


@pytest.mark.parametrize("fields, message", [
    ({}, "no field"), ({"mass": Real, "count": Int}, "count has another type"), ({"x": Vector}, "another type"),
    ({"x": Rows[2]}, "another type"),
    ({"x": Out[Vector[2]]}, "another type"),
    ({"x": IntVector[2], "y": Vector[2]}, "y has another"), ({"x": 3}, "another type"),
    ({"shape": Real}, "cannot be a field"), ({"for": Real}, "cannot be a field"), ({"_x": Real}, "cannot be a field"),
])  # fmt: skip
def test_what_is_not_a_record(fields: dict[str, object], message: str) -> None:
    with pytest.raises(errors.AlgorithmError, match=message):
        record("Wrong", **fields)  # type: ignore[arg-type]


def test_fields_that_are_not_there() -> None:
    with pytest.raises(errors.AlgorithmError, match="no field mas .did you mean 'mass'"):

        @algorithm
        def wrong(body: Body) -> Real:  # type: ignore[valid-type]
            return body.mas

    with pytest.raises(errors.AlgorithmError, match="of several rows"):

        @algorithm
        def several(rows: Rows[Body]) -> Real:
            return rows.mass

    with pytest.raises(errors.AlgorithmError, match="is an input"):

        @algorithm
        def changed(body: Body) -> None:  # type: ignore[valid-type]
            body.mass = 1.0


@algorithm
def pushed(bodies: InOut[Rows[Body]], force: Vector[3]) -> Real:
    """Rows that are changed."""
    total = 0.0
    for i in range(len(bodies)):
        bodies[i].position[:] = (force[0] * bodies[i].mass, force[1], force[2] + bodies[i].position[2])
        total += bodies[i].position[0] * bodies[i].position[2]
    return total


def test_tangents_of_rows_that_are_changed() -> None:
    given, force, along = bodies(4), np.array([0.5, -1.0, 2.0]), np.array([1.0, 0.25, -3.0])
    found, tangents, total, change = pushed.derivative("force")(given, force, along)
    step = 1e-6
    up, above = pushed(given, force + step * along)
    down, below = pushed(given, force - step * along)
    assert np.allclose(tangents, (up - down) / (2 * step), atol=1e-8)
    assert np.isclose(change, (above - below) / (2 * step), rtol=1e-7)
    assert np.array_equal(found, pushed(given, force)[0]) and total == pushed(given, force)[1]
    single = pushed.derivative("force")(*(np.asarray(a, np.float32) for a in (given, force, along)))
    assert single[0].dtype == single[1].dtype == np.float32


Twin = record("Twin", weight=Real, rest=Vector[13])


@algorithm
def first_of(row: Vector) -> Real:
    """Any array: fields are those that a parameter declares."""
    return row[0]


@algorithm
def first_mass(row: Vector) -> Real:
    """The field of whoever called first is no field of the parameter."""
    return row.mass


@algorithm
def both_firsts(body: Body, twin: Twin) -> Real:  # type: ignore[valid-type]
    """Two records of one size."""
    return first_of(body) + first_of(twin) + twin.weight


def test_records_of_one_size() -> None:
    a, b = Body.zeros(), Twin.zeros()
    a.mass, b.weight = 2.0, 3.0
    assert both_firsts(a, b) == 8.0
    with pytest.raises(errors.AlgorithmError, match="no attribute mass"):
        first_mass(a)


Counter = record("Counter", steps=Int, others=IntVector[2])


@algorithm
def advance(count: InOut[Counter]) -> Int:
    """One step more; how many there were."""
    before = count.steps
    count.steps = before + 1
    return before


def test_a_number_of_a_row_does_not_change_with_the_row() -> None:
    changed, before = advance.reference(np.array([4, 0, 0]))
    assert (int(before), changed.tolist()) == (4, [5, 0, 0])


Gauge = record("Gauge", offset=Real, scale=Vector[2])
Meter = record("Meter", count=Real, gauge=Gauge, last=Real)


@algorithm
def total_of(x: Reals) -> Real:
    """Sum of single numbers."""
    total = 0.0
    for i in range(len(x)):
        total += x[i]
    return total


@algorithm
def read(gauge: InOut[Gauge]) -> None:
    """Change a record."""
    gauge.scale[1] += gauge.offset


@algorithm
def read_all(meters: InOut[Rows[Meter]]) -> Real:
    """Records within records; rows where single numbers are declared."""
    for i in range(len(meters)):
        gauge = meters[i].gauge
        gauge.offset += 1.0
        read(meters[i].gauge)
        meters[i].count = total_of(gauge.scale)
    return total_of(meters)


@pytest.mark.skipif(extension.compiler() is None, reason="no C compiler")
def test_fields_that_are_records_and_rows_that_are_numbers() -> None:
    given = np.arange(10.0).reshape(2, 5)
    found, total = read_all(given)
    expected = Meter.view(given.copy())
    assert Meter.offsets == {"count": 0, "gauge": 1, "last": 4}
    expected.gauge.offset += 1.0
    expected.gauge.scale[:, 1] += expected.gauge.offset
    expected.count = expected.gauge.scale.sum(-1)
    assert np.array_equal(found, expected) and total == expected.sum()
    again, other = read_all.reference(given)
    assert np.array_equal(again, found) and other == total
