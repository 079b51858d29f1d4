"""Taylor coefficients of series functions against mpmath at 50 digits: every node, and the kernels of motion."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache
from typing import Any

import numpy as np
import pytest

from bladesmith.codegen import algorithm
from bladesmith.codegen.algebra.multivector import absolute, atan2, cos, exp, log, select, sin, sqrt, stumpff1
from bladesmith.codegen.algorithms.series.functions import Argument, SeriesFunction, Term, series_function
from bladesmith.codegen.algorithms.series.recurrences import HIGHEST_ORDER
from bladesmith.codegen.build import cpu_features
from bladesmith.codegen.build.cpu_features import has_wide_vectors
from bladesmith.codegen.build.extension import load
from bladesmith.codegen.errors import TraceError
from bladesmith.codegen.formulas.mechanics import laws, mechanics
from bladesmith.codegen.formulas.motions import flows
from bladesmith.codegen.language import InOut, Rows, Vector
from bladesmith.codegen.programs.dynamics.config import DynamicsConfig
from bladesmith.codegen.programs.dynamics.dynamics import dynamics_program
from bladesmith.codegen.programs.kernel_spec import KernelSpec, trace_spec
from bladesmith.codegen.rings.protocol import PrecisionRing
from bladesmith.codegen.targets.c.loops import c_functions
from bladesmith.codegen.targets.c.source import ExtensionSource
from bladesmith.codegen.targets.templates import included_headers
from bladesmith.codegen.trace.kernel import Kernel
from bladesmith.codegen.trace.outputs import row

ORDER = 20
ALGEBRAS = ["cga3d", "pga3d"]
#: Bytes of vectors: one number, those of every machine, AVX2.
WIDTHS = (8, 16, 32) if has_wide_vectors() else (8, 16)
#: Of coefficients that are about one: rounding of the inputs and of convolutions.
ROUNDING = 1e-13

SOURCE = """
#include "platform.h"
#define BS_BITS 64
#define BS_BYTES 0
#define BS_TAG f64_scalar
#include "instance.h"
#include "loops.h"
#include "elementary.h"
#define BS_SERIES_BYTES %(width)d
%(begin)s
#include "series.h"
%(text)s
%(declared)s
{
  double work[%(work)d];
  for (int k = 0; k <= order; k++) FN(series)(k, work, %(arguments)s);
}
%(end)s
#ifndef BS_SOURCE_HASH
#define BS_SOURCE_HASH ""
#endif
const char *bs_source_hash(void) { return BS_SOURCE_HASH; }
#include "instance_end.h"
"""


def series_of_kernel(kernel: Kernel, still: tuple[str, ...] = ()) -> SeriesFunction:
    """A row for each argument."""
    arguments = tuple(Argument(i.name, 0, i.name not in still) for i in kernel.inputs)
    term = Term(kernel, arguments, tuple(o.name for o in kernel.outputs))
    return series_function("series", [term], {i.name: i.kind.size for i in kernel.inputs})


class Compiled:
    """A series function, compiled by itself."""

    def __init__(self, kernel: Kernel, still: tuple[str, ...] = (), width: int = 16) -> None:
        self.made = made = series_of_kernel(kernel, still)
        declared = "void run(int order, " + ", ".join(
            [f"double *{o}" for o in made.results] + [f"const double *{i}" for i in made.rows]
        )
        moving = {**made.results, **{i: n for i, n in made.rows.items() if i not in still}}
        arguments = [f"{x} + {moving[x]} * k" if x in moving else x for x in (*made.results, *made.rows)]
        wide = width == 32
        source = SOURCE % {
            "text": c_functions([made.compute.instance()]), "declared": declared + ")", "work": made.size,
            "width": width, "arguments": ", ".join(arguments), "begin": "BS_V3_BEGIN" * wide,
            "end": "BS_V3_END" * wide,
        }  # fmt: skip
        cdef = f"{declared}); const char *bs_source_hash(void);"
        self.module = load(ExtensionSource(f"series_{kernel.name}_{width}", cdef, source, included_headers([source])))

    def __call__(self, order: int, given: dict[str, Any]) -> dict[str, Any]:
        """Coefficients (order + 1, size) of the outputs, from those of the inputs."""
        found = {o: np.full((order + 1, n), np.nan) for o, n in self.made.results.items()}
        arrays = [np.ascontiguousarray(given[i], float) for i in self.made.rows]
        ffi = self.module.ffi
        self.module.lib.run(order, *[ffi.from_buffer("double[]", a) for a in (*found.values(), *arrays)])
        return found


def kernel(formula: Callable[..., Any], kinds: str, algebra: str = "cga3d") -> Kernel:
    return trace_spec(KernelSpec(formula, tuple(kinds.split(", ")), "", algebra))


def series_of(function: Callable[[Any], Sequence[Any]], ring: PrecisionRing, order: int = ORDER) -> Any:
    """Taylor coefficients (order + 1, size) of a function of time: differences over 2^-100, with digits to spare."""
    mp, bits = ring.context, 100
    with mp.workprec(bits * order + 200):
        step = mp.ldexp(1, -bits)
        rows = [[mp.mpf(x) for x in function(i * step)] for i in range(order + 1)]
        found = []
        for k in range(order + 1):
            found.append([float(x / (mp.factorial(k) * step**k)) for x in rows[0]])
            rows = [[b - a for a, b in zip(*pair, strict=True)] for pair in zip(rows, rows[1:], strict=False)]
    return np.array(found)


# -- every node -----------------------------------------------------------------------------------------------


def nodes_first(x, y, a):  # type: ignore[no-untyped-def]
    """Sums, products, squares, quotients, roots."""
    z = sqrt(x * x + y * y + 1)
    return row([x * y - 2 * z, a * x * (3 * y) + a, z / (2 + a * x), (x + y) * (x + y) * (x - 3), 1 / (1 + y * y)])


def nodes_second(x, y, a):  # type: ignore[no-untyped-def]
    """Elementary functions."""
    return row([sin(x * y) + a, cos(x * y) * y, exp(a * x), log(3 + x), atan2(x, 2 + y), sin(y), cos(a) * x])


def nodes_third(x, y, a):  # type: ignore[no-untyped-def]
    """Choices, as they are at the start."""
    inner = (x < y) & ~(y <= a * x)
    return row([
        select(x < y, x * y, y), select(y < x, x, y * y), absolute(x - 2) * y, select(inner, a * y, x),
        select(a > 0, x, y), select(x > 0, a, a * a), select(a < 0, a, x * 0 + 1), absolute(a) * x,
    ])  # fmt: skip


def nodes_without(x):  # type: ignore[no-untyped-def]
    """sin(sqrt(x))/sqrt(x)."""
    return row([stumpff1(x)])


@pytest.mark.parametrize("formula", [nodes_first, nodes_second, nodes_third])
def test_every_node(formula: Callable[..., Any]) -> None:
    ring = PrecisionRing()
    mp = ring.context
    made = kernel(formula, "number, number, number")
    a = mp.mpf(3) / 4

    def given(t: Any) -> list[Any]:
        return [mp.sin(t + mp.mpf(1) / 5) / (t / 3 + 1), mp.mpf(1) / 2 + mp.exp(-t) / 3]

    def wanted(t: Any) -> list[Any]:
        x, y = given(t)
        return made.reference(ring, [[x], [y], [a]])[0]

    columns = series_of(given, ring)
    found = Compiled(made, ("a",), WIDTHS[-1])(ORDER, {"x": columns[:, :1], "y": columns[:, 1:], "a": [float(a)]})
    expected = series_of(wanted, ring)
    (values,) = found.values()
    assert np.abs(expected[1:]).max() > 0.1
    np.testing.assert_allclose(values, expected, rtol=0, atol=ROUNDING * max(1, np.abs(expected).max()))


def test_widths_agree_to_the_bit() -> None:
    made = kernel(mechanics.gyroscopic, "twist, numbers6")
    rng = np.random.default_rng(1)
    given = {"omega": rng.normal(size=(HIGHEST_ORDER + 1, 6)), "momentum": rng.normal(size=(HIGHEST_ORDER + 1, 6))}
    found = [Compiled(made, (), width)(HIGHEST_ORDER, given)["gyroscopic"] for width in WIDTHS]
    for other in found[1:]:
        np.testing.assert_array_equal(other, found[0])


@pytest.mark.slow
def test_targets_agree_to_the_bit() -> None:
    """Every node but those of elementary functions, by C, by numba and as Python."""
    made = series_of_kernel(kernel(nodes_first, "number, number, number"), ("a",))
    compute = made.compute

    @algorithm
    def all_orders(work: InOut[Vector], results: InOut[Rows[5]], x: Rows[1], y: Rows[1], a: Vector[1]) -> None:
        """Coefficients of all orders."""
        for k in range(len(x)):
            compute(k, work, results[k], x[k], y[k], a)

    rng = np.random.default_rng(2)
    x, y, a = rng.uniform(0.5, 1.5, (ORDER + 1, 1)), rng.uniform(0.5, 1.5, (ORDER + 1, 1)), np.array([0.7])
    given = np.zeros(made.size), np.zeros((ORDER + 1, 5)), x, y, a
    (name,) = made.results
    expected = Compiled(kernel(nodes_first, "number, number, number"), ("a",))(ORDER, {"x": x, "y": y, "a": a})[name]
    assert np.isfinite(expected).all()
    np.testing.assert_array_equal(all_orders.on("numba")(*given)[1], expected)
    np.testing.assert_array_equal(all_orders.reference(*given)[1], expected)


def test_functions_without_recurrence_are_told() -> None:
    with pytest.raises(TraceError, match="stumpff.* no Taylor recurrence; take another integrator"):
        series_of_kernel(kernel(nodes_without, "number"))


# -- the kernels of motion ------------------------------------------------------------------------------------

KERNELS = {
    "motor_rate": ("layout motor, twist", ()),
    "gyroscopic": ("twist, numbers6", ()),
    "pull": ("motor, position, position", ("center", "weight")),
    "wrench_to_body": ("motor, twist", ("wrench",)),
    "drag": ("twist, position, numbers2", ("center", "law")),
    "spring": ("motor, twist, position, motor, twist, position, numbers3", ("point", "other_point", "law")),
    "rotor_rate": ("layout rotor, position", ()),
    "spin_rate": ("position, position, position", ("moments", "inverse")),
}


class Motion:
    """Analytic motions at any precision; motors are motors all the time."""

    def __init__(self, algebra: str, ring: PrecisionRing) -> None:
        self.ring, self.mp = ring, ring.context
        self._landed = kernel(flows.state_after_flight, "layout rotor, position, position, position", algebra)
        self._rng = np.random.default_rng(3)
        self._numbers: dict[str, Any] = {}
        self.motor = cache(self._motor)

    def numbers(self, name: str, size: int) -> list[Any]:
        if name not in self._numbers:
            self._numbers[name] = [self.mp.mpf(float(x)) for x in self._rng.uniform(0.5, 1.5, size)]
        return self._numbers[name]

    def moving(self, name: str, size: int, t: Any) -> list[Any]:
        rates = self.numbers(name, size)
        return [self.mp.sin(r * t + 3 * r) + (r - 1) * t for r in rates]

    def _motor(self, name: str, t: Any) -> list[Any]:
        parts = [self.moving(name + part, n, t) for part, n in (("q", 4), ("x", 3), ("v", 3), ("w", 3))]
        parts[0][0] += 3  # far from no rotor at all
        return self._landed.reference(self.ring, parts)[0]

    def argument(self, name: str, kind: Any, still: bool, t: Any) -> list[Any]:
        if kind.name.startswith("motor") or kind.blades == self._landed.outputs[0].kind.blades:
            return self.motor(name, t)
        return self.numbers(name, kind.size) if still else self.moving(name, kind.size, t)


@pytest.mark.compiles
@pytest.mark.parametrize("algebra", ALGEBRAS)
@pytest.mark.parametrize("name", KERNELS)
def test_coefficients_of_kernels(name: str, algebra: str) -> None:
    kinds, still = KERNELS[name]
    formula = next(getattr(module, name) for module in (mechanics, laws, flows) if hasattr(module, name))
    made = kernel(formula, kinds, algebra)
    order = ORDER if algebra == "cga3d" and name != "spring" else ORDER // 2  # PGA: the same text but for signs
    ring = PrecisionRing()
    motion = Motion(algebra, ring)
    places = [(i.name, i.kind, i.name in still) for i in made.inputs]

    def wanted(t: Any) -> list[Any]:
        results = made.reference(ring, [motion.argument(*place, t) for place in places])
        return [x for values in results for x in values]

    given = {}
    for place in places:
        columns = series_of(lambda t, place=place: motion.argument(*place, t), ring, order)
        given[place[0]] = columns[0] if place[2] else columns
    found = np.concatenate(list(Compiled(made, still)(order, given).values()), 1)
    expected = series_of(wanted, ring, order)
    scale = np.abs(expected).max(1, keepdims=True)
    assert (scale[:5] > 1e-3).all()
    np.testing.assert_array_less(np.abs(found - expected) / np.maximum(scale, 1), ROUNDING)


def test_the_text_does_not_depend_on_the_machine(monkeypatch: pytest.MonkeyPatch) -> None:
    """A processor with AVX2 differs from one without by an option of the compiler alone."""
    config = DynamicsConfig(method="taylor", loads=("gravity", "drag"), rows=0)
    programs = []
    for wide in (False, True):
        monkeypatch.setattr(cpu_features, "has_wide_vectors", lambda wide=wide: wide)
        programs.append(dynamics_program.__wrapped__(config))
    assert programs[0].files == programs[1].files and programs[0].options != programs[1].options
