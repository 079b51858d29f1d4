"""Random algorithms: C, numba and the text run as Python agree bit for bit; derivatives agree with both targets."""

from __future__ import annotations

import importlib.util
import random
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bladesmith.codegen.build import extension

from ...support.effort import seeds
from ...support.targets.lanes import TAGS, by_lanes

HEAD = """
from bladesmith.codegen import algorithm
from bladesmith.codegen.language import (
    Bool, InOut, Int, IntVector, Matrix, Out, Real, Vector, atan2, cos, empty, exp, int_zeros, log, sin, sqrt, zeros)

@algorithm
def first_above(v: Vector[3], limit: Real, k: Int) -> Real:
    while k < 6:
        for j in range(2, -1, -1):
            if v[j] > limit:
                return v[j] - limit
            if j + k == 3:
                break
        k += 1
    return -limit

@algorithm
def rotate(v: InOut[Vector[3]], k: Int) -> Int:
    v[0], v[1], v[2] = v[1], v[2], v[0]
    if k % 2 == 0:
        return k // -3
    return k - 1
"""
SIGNATURE = "(x: InOut[Vector[4]], n: InOut[IntVector[4]], a: InOut[Matrix[3, 3]], s: Real, m: Int) -> tuple[Real, Int]"
#: Programs of one module, which is compiled as one; and the items that each runs on.
PROGRAMS, ITEMS = 6, 24


class Grammar(random.Random):
    """Text of random algorithms. Integers stay small, and nothing is divided by zero: there Python raises."""

    def begin(self) -> None:
        self.loops = 0
        self.counters: list[str] = []

    def integer(self, depth: int) -> str:
        if depth == 0:
            leaves = ["i0", "i1", "i2", "m", str(self.randint(-7, 7)), f"n[{self.randint(-4, 3)}]", "len(x)"]
            return self.choice(leaves + self.counters)
        a, b, c = (self.integer(depth - 1) for _ in range(3))
        divided = f"({a} {self.choice(('//', '%'))} ({b}) if ({b}) != 0 else {c})"
        return self.choice((
            f"({a} + {b})", f"({a} - {b})", f"{self.integer(0)} * {b}", f"-{b}", f"abs({a} - {b})", divided, divided,
            f"({a}) {self.choice(('//', '%'))} {self.choice((-3, 2, 5))}", f"min({a}, {b})", f"max({a}, {b})",
            f"({a} if {self.condition(depth - 1)} else {b})", f"n[({a}) % 4]", f"{a} - {b} - {c}", f"{a} - ({b} - {c})",
            "(int({0}) if abs({0}) < 1e6 else {1})".format(self.real(0), b), f"({a} {self.choice('&|^')} {b})",
            f"(({a}) {self.choice(('<<', '>>'))} {self.randint(0, 5)})", f"(({a}) >> ({b} & 7))",
        ))  # fmt: skip

    def real(self, depth: int) -> str:
        if depth == 0:
            constants = ["0.5", "-0.0", "0.1", "1e3", "float(i1)", f"x[{self.randint(-4, 3)}]"]
            return self.choice([*constants, "r0", "r1", "r2", "s", "y[1]", "y[-1]", f"a[{self.randint(0, 2)}, 1]"])
        a, b, c = (self.real(depth - 1) for _ in range(3))
        k = self.integer(depth - 1)
        one, two = f"{self.choice(('sin', 'cos', 'abs'))}({a})", f"{self.choice(('min', 'max', 'atan2'))}({a}, {b})"
        return self.choice((
            f"({a} + {b})", f"{a} - {b}", f"{a} - ({b} - {c})", f"{a} * {b}", f"({a}) * ({b} - {c})", f"-({b})", one,
            two, f"({a} / ({b}) if ({b}) != 0.0 else {c})", f"({a} if {self.condition(depth - 1)} else {b})", two,
            f"x[({k}) % 4]", f"y[({k}) % 3]", f"a[({k}) % 3, {self.randint(-3, 2)}]", f"a[1][({k}) % 3]", f"sqrt({a})",
            f"({a}) * ({k})", f"2 - {a}", f"log(abs({a}) + 1.0)", f"exp(-abs({a}))",
        ))  # fmt: skip

    def condition(self, depth: int) -> str:
        compare = ("<", "<=", ">", ">=", "==", "!=")
        of = self.choice((self.integer, self.real))
        a, b, c = (of(max(depth - 1, 0)) for _ in range(3))
        leaves = (
            f"({a}) {self.choice(compare)} ({b})",
            f"({a}) {self.choice(compare)} ({b}) {self.choice(compare)} s",
            "q",
        )
        if depth == 0:
            return self.choice(leaves)
        p, q = self.condition(depth - 1), self.condition(depth - 1)
        return self.choice((*leaves, f"({p} and {q})", f"({p} or {q})", f"not ({p})", f"(not ({p}) or {q} and {p})",
                            f"(({p}) {self.choice('&|^')} ({q}))"))  # fmt: skip

    def statement(self, depth: int, in_loop: bool) -> list[str]:
        i, r, k = f"i{self.randint(0, 2)}", f"r{self.randint(0, 2)}", self.integer(1)
        simple = (
            f"{i} = ({self.integer(3)}) % {self.choice((97, -97))}", f"{r} = {self.real(3)}",
            f"{r} {self.choice('+-*')}= {self.real(2)}", f"x[({k}) % 4] {self.choice('+-*')}= {self.real(2)}",
            f"x[({k}) % 4] = {self.real(3)}",
            f"n[({k}) % 4] = ({self.integer(2)}) % 31", f"q = {self.condition(2)}", f"y[:] = x[{i} % 2 : {i} % 2 + 3]",
            f"r0, r1 = {self.real(2)}, {self.real(2)}", f"x[0], x[({k}) % 4] = x[({k}) % 4], x[0]",
            f"x[{i} % 2 : {i} % 2 + 2] = x[1:3]", f"y[:] = a[({k}) % 3]",
            f"a[({k}) % 3][:] = (r0, {self.real(1)}, y[0])",
            f"{r} = first_above(y, {self.real(1)}, ({k}) % 5) - s", f"{i} = rotate(a[({k}) % 3], {k})",
            f"y[:] = {self.real(1)}",
            f"v = a[({k}) % 3]\nv[{self.randint(-3, 2)}] -= {self.real(1)}\n{r} = v[0] - v[2]",
            f"t{self.loops} = int_zeros(2)\nt{self.loops}[{i} % 2] += 3\n{i} -= t{self.loops}[0]",
        )  # fmt: skip
        self.loops += 1
        if depth == 0 or self.random() < 0.5:
            return self.choice(simple).splitlines()
        kind, inner = self.randrange(5 if in_loop else 4), f"k{self.loops}"
        if kind == 0:
            lines = [f"if {self.condition(2)}:", *self.block(depth - 1, in_loop)]
            if self.random() < 0.5:
                lines += [f"elif {self.condition(1)}:", *self.block(depth - 1, in_loop)]
            return [*lines, "else:", *self.block(depth - 1, in_loop)] if self.random() < 0.5 else lines
        if kind == 1:
            bounds = self.choice(
                ("3", f"({k}) % 5", f"({k}) % 9 - 8, ({k}) % 3", f"({k}) % 7, -2, -2", f"{i}, {i} + 4")
            )
            self.counters.append(inner)
            lines = [f"for {inner} in range({bounds}):", *self.block(depth - 1, True)]
            self.counters.remove(inner)
            return lines
        if kind == 2:
            lines = [f"while w{inner} < 4 and {self.condition(1)}:", f"    w{inner} += 1", *self.block(depth - 1, True)]
            return [f"w{inner} = 0", *lines]
        if kind == 3:
            return [f"if {self.condition(2)}:", f"    return {self.real(2)}, {self.integer(2)}"]
        return [f"if {self.condition(2)}:", *self.block(0, False), f"    {self.choice(('break', 'continue'))}"]

    def block(self, depth: int, in_loop: bool) -> list[str]:
        return ["    " + line for _ in range(self.randint(1, 3)) for line in self.statement(depth, in_loop)]

    def program(self, name: str) -> str:
        self.begin()
        lines = ["y = zeros(3)", "i0, i1, i2 = m, m - 3, 2 * m", "r0, r1, r2 = s, x[0], s * s", "q = r0 < r1"]
        lines += [line for _ in range(6) for line in self.statement(3, False)]
        lines.append("return r0 - r1 * r2 + y[0], i0 - i1 * i2 + (1 if q else 0)")
        return "\n".join((f"\n@algorithm\ndef {name}{SIGNATURE}:", *("    " + line for line in lines), ""))


def module_of(seed: int, folder: Path) -> Any:
    """Random algorithms, and one that calls each on parts of its own."""
    grammar = Grammar(seed)
    text = HEAD + "".join(grammar.program(f"f{k}") for k in range(PROGRAMS))
    text += (
        f"\n@algorithm\ndef run(x: InOut[Matrix[{PROGRAMS}, 4]], n: InOut[IntVector[{4 * PROGRAMS}]], "
        f"a: InOut[Matrix[{3 * PROGRAMS}, 3]], s: Real, m: Int, "
        f"r: Out[Vector[{PROGRAMS}]], i: Out[IntVector[{PROGRAMS}]]) -> None:\n"
    )
    for k in range(PROGRAMS):
        text += f"    r[{k}], i[{k}] = f{k}(x[{k}], n[{4 * k}:{4 * k + 4}], a[{3 * k}:{3 * k + 3}], s, m)\n"
    path = folder / f"random_algorithms_{seed}.py"
    path.write_text(text, encoding="utf-8")
    spec = importlib.util.spec_from_file_location(path.stem, path)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def items(seed: int) -> tuple[Any, ...]:
    rng = np.random.default_rng(seed)
    x, a = rng.normal(size=(ITEMS, PROGRAMS, 4)), rng.normal(size=(ITEMS, 3 * PROGRAMS, 3))
    x[::4] = np.round(x[::4])  # ties, and zeros of both signs
    x[1, :, 0], x[2, :, 1], x[3, :, 2] = np.nan, np.inf, -np.inf
    n = rng.integers(-30, 30, (ITEMS, 4 * PROGRAMS))
    return x, n, a, rng.normal(size=ITEMS), rng.integers(-20, 20, ITEMS)


def same_bits(found: Any, expected: Any) -> None:
    for a, b in zip(found, expected, strict=True):
        assert a.dtype == b.dtype
        np.testing.assert_array_equal(a, b)
        if a.dtype.kind == "f":
            known = ~np.isnan(b)
            np.testing.assert_array_equal(np.signbit(a[known]), np.signbit(b[known]))


@pytest.mark.compiles
@pytest.mark.peers
@pytest.mark.skipif(extension.compiler() is None, reason="no C compiler")
@pytest.mark.parametrize("seed", [1, 2])
def test_random_algorithms_have_the_same_bits_everywhere(seed: int, tmp_path: Path) -> None:
    run, given = module_of(seed, tmp_path).run, items(seed)
    expected = [run.reference(*(a[i] for a in given)) for i in range(ITEMS)]
    by_c = run(*given)
    same_bits(by_c, [np.array([e[k] for e in expected]) for k in range(5)])
    same_bits(run.on("numba")(*given), by_c)


@pytest.mark.compiles
@pytest.mark.peers
@pytest.mark.skipif(extension.compiler() is None, reason="no C compiler")
@pytest.mark.parametrize(("seed", "shared"), [(3, ()), (4, ("s", "m"))])
def test_random_algorithms_have_the_same_bits_on_several_items(
    seed: int, shared: tuple[str, ...], tmp_path: Path
) -> None:
    run, given = module_of(seed, tmp_path).run, items(seed)
    given = tuple(a[0] if name in shared else a for name, a in zip("xnasm", given, strict=True))
    expected = run(*given)
    for tag in TAGS:
        found = by_lanes(run, given, ITEMS, tag, shared)
        same_bits([f.reshape(e.shape) for f, e in zip(found, expected, strict=True)], expected)


@pytest.mark.compiles
@pytest.mark.skipif(extension.compiler() is None, reason="no C compiler")
@pytest.mark.parametrize("seed", seeds(1, 200))
def test_cotangents_of_random_algorithms_are_those_of_tangents(seed: int, tmp_path: Path) -> None:
    """Paired with directions as the tangents are with the cotangents of the results."""
    module, rng = module_of(100 + seed, tmp_path), np.random.default_rng(100 + seed)
    sizes, compared = ((ITEMS, 4), (ITEMS, 3, 3), (ITEMS,)), 0
    for k in range(2):
        function = getattr(module, f"f{k}")
        x, a, s = (rng.normal(size=size) for size in sizes)
        given = (x, rng.integers(-30, 30, (ITEMS, 4)), a, s, rng.integers(-20, 20, ITEMS))
        along, weights = ([rng.normal(size=size) for size in sizes] for _ in range(2))
        _, _, _, dx, da, _, _, d_result = function.derivative("x", "a", "s")(*given, *along)
        found = function.pullback("x", "a", "s")(*given, *weights)
        pairs = [np.sum((c * t).reshape(ITEMS, -1), 1) for c, t in zip(weights, (dx, da, d_result), strict=True)]
        others = [np.sum((c * t).reshape(ITEMS, -1), 1) for c, t in zip(found, along, strict=True)]
        known = np.isfinite(sum(pairs))
        scale = sum(np.abs(p) for p in (*pairs, *others))[known]
        assert np.all(np.abs(sum(pairs) - sum(others))[known] <= 1e-12 * scale)
        compared += known.sum()
    assert compared > ITEMS // 2  # of some programs all tangents are NaN: of roots of zero
