"""What a formula reads as text: everything that changes the kernel changes it, and what cannot be told has none."""

from __future__ import annotations

import functools
from collections.abc import Callable
from types import ModuleType
from typing import Any, NamedTuple

import numpy as np
import pytest

from bladesmith import cga3d as cga
from bladesmith import codegen
from bladesmith import pga3d as pga
from bladesmith.codegen.api import KernelFunction
from bladesmith.codegen.trace.reached_code import reached_text

TEXT = """
import math
import numpy as np
from itertools import product
from bladesmith import codegen

SHIFT = 3
TABLE = {"a": [1, 2.5], "b": (True, None)}
ROW = np.array([1.0, 2.0])

def inner(x):
    return x + 1

def helper(x, weight=2):
    return weight * inner(x) + SHIFT

def scaled(factor):
    return lambda x: factor * x

outside = scaled(5)

def formula(x):
    "What it does."
    parts = [helper(x + i) for i in range(4)]
    return sum(parts, x) + outside(codegen.sqrt(1 + x * x)) * math.sqrt(2.0) + TABLE["a"][1] + ROW[0]
"""


def formula(text: str) -> Any:
    namespace: dict[str, Any] = {"__name__": "somewhere"}
    exec(compile(text, "<somewhere>", "exec"), namespace)
    return namespace["formula"]


def test_the_same_code_has_the_same_text_wherever_it_stands() -> None:
    first = reached_text(formula(TEXT))
    assert first is not None
    assert reached_text(formula(f"# a comment\n\n{TEXT}")) == first
    assert reached_text(formula(TEXT.replace("SHIFT = 3", "SHIFT = 3\nUNUSED = 4"))) == first


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("x + 1", "x + 2"),  # a helper of a helper
        ("x + 1", "x + 1.0"),
        ("x + 1", "x - 1"),
        ("x + 1", "x + True"),
        ("weight=2", "weight=3"),
        ("SHIFT = 3", "SHIFT = 4"),
        ("SHIFT = 3", "SHIFT = -0.0"),
        ("scaled(5)", "scaled(6)"),  # a closure
        ("2.5", "2.25"),
        ("(True, None)", "(1, None)"),
        ("[1.0, 2.0]", "[1.0, 3.0]"),
        ("[1.0, 2.0]", "[1.0, 2.0], np.float32"),
        ("range(4)", "range(5)"),
        ("math.sqrt", "math.exp"),
        ("codegen.sqrt", "codegen.cos"),
        ("What it does.", "What it did."),  # it stands in the generated text
    ],
)
def test_every_change_of_what_it_reaches_changes_its_text(old: str, new: str) -> None:
    assert old in TEXT
    changed = reached_text(formula(TEXT.replace(old, new)))
    assert changed is not None and changed != reached_text(formula(TEXT))


@pytest.mark.parametrize(
    "text",
    [
        "import random\ndef formula(x): return x * random.random()",
        "from random import random\ndef formula(x): return x * random()",
        "import numpy as np\ndef formula(x): return x * np.random.rand()",
        "import time\ndef formula(x): return x * time.time()",
        "import os\ndef formula(x): return x * len(os.environ)",
        "def formula(x):\n    import math\n    return x * math.pi",
        "def formula(x): return x * __import__('time').time()",
        "def formula(x): return x * len(open('/etc/hostname').read())",
        "def formula(x): return x * id(x)",
        "def formula(x): return x * eval('2')",
        "def formula(x): return x * globals()['y']",
        "def formula(x): return x * getattr(x, 'y')",
        "count = 0\ndef formula(x):\n    global count\n    count += 1\n    return x * count",
        "def f(): pass\nf.calls = 0\ndef formula(x):\n    f.calls += 1\n    return x * f.calls",
        "class C: y = 2\ndef formula(x): return x * C.y",
        "class C: y = 2\nc = C()\ndef formula(x): return x * c.y",
        "from functools import lru_cache\n@lru_cache\ndef f(): return 2\ndef formula(x): return x * f()",
        "from functools import partial\nformula = partial(pow, 2)",
        "class Formula:\n    def __call__(self, x): return x\nformula = Formula()",
        "from bladesmith import cga3d\ndef formula(x): return x * cga3d.ni",
        "import bladesmith\ndef formula(x): return x * bladesmith.cga3d.ni",
        "d = {}\nd['d'] = d\nsum = print\ndef formula(x): return sum(d)",
    ],
)
def test_what_cannot_be_told_has_no_text(text: str) -> None:
    assert reached_text(formula(text)) is None


def test_modules_are_read_for_all_names_that_any_code_has() -> None:
    module = weights
    code = "def scale(x, m): return x * m.a\ndef other(x): return x * weights.b\n"
    code += "def formula(x): return scale(x, weights) + other(x) + weights.c(x)"

    def text(c: Any, **values: float) -> str | None:
        vars(module).update(values, c=c)
        namespace: dict[str, Any] = {"weights": module}
        exec(code, namespace)
        return reached_text(namespace["formula"])

    texts = [
        text(lambda x: x, a=1, b=1),
        text(lambda x: x, a=2, b=1),
        text(lambda x: x, a=1, b=2),
        text(lambda x: x * weights.d, a=1, b=1, d=3),
        text(lambda x: x * weights.d, a=1, b=1, d=4),
    ]
    assert None not in texts and len(set(texts)) == 5
    assert text(lambda x: x, a=1, b=1, unused=5.0) == texts[0]


weights = ModuleType("weights")


def test_what_goes_in_circles_has_a_text() -> None:
    text = "d = [1]\nd.append(d)\ndef formula(x, n=3): return x if n == 0 else d[0] * formula(x, n - 1)"
    assert reached_text(formula(text)) not in (None, reached_text(formula(text.replace("d[0]", "d[1]"))))


def test_wrapped_functions_are_read_through() -> None:
    def wrapped(weight: int) -> Callable[..., Any]:
        def inside(x: Any) -> Any:
            return weight * x

        @functools.wraps(inside)
        def outside(x: Any) -> Any:
            return inside(x)

        return outside

    assert reached_text(wrapped(2)) == reached_text(wrapped(2)) != reached_text(wrapped(3))


def declared(*kinds: Any, f: Any = lambda x: x * x, **options: Any) -> KernelFunction:
    return codegen.kernel(*kinds, **{"name": "f", **options})(f)


def test_declarations_differ_by_kinds_names_results_and_algebras() -> None:
    layout = cga.layout("circle")
    kernels = [
        declared(cga.kind("circle")),
        declared(layout),
        declared(cga.kind("motor")),
        declared(pga.kind("motor")),
        declared(layout, name="g"),
        declared(layout, returns=cga.layout("even")),
        declared(layout, f=lambda y: y * y),
        declared(codegen.scalar, algebra=cga),
        declared(codegen.scalar, algebra=pga),
        declared(codegen.numbers(2), f=lambda x: x[0], algebra=cga),
        declared(codegen.numbers(3), f=lambda x: x[0], algebra=cga),
        declared(cga.kind("motor"), f=lambda x: x + 1).derivative("x"),
        declared(cga.kind("motor"), f=lambda x: x + 2).derivative("x"),
    ]
    texts = [reached_text(kernel) for kernel in kernels]
    assert None not in texts and len(set(texts)) == len(kernels)
    assert reached_text(declared(layout)) == texts[1]


def test_kernels_that_a_formula_calls_count() -> None:
    def outer(weight: int) -> KernelFunction:
        called = declared(cga.kind("point"), f=lambda x: weight * x)
        return declared(cga.kind("point"), f=lambda x: called(x) + x)

    assert reached_text(outer(2)) == reached_text(outer(2)) != reached_text(outer(3))
    assert reached_text(outer(2)) is not None


class Pair(NamedTuple):
    a: Any
    b: Any


def test_rows_that_are_named_by_a_foreign_class_are_traced() -> None:
    def spring(law: Pair) -> Any:
        return law.a * law.b

    assert reached_text(declared(codegen.numbers(2), f=spring, algebra=cga)) is None
    assert np.array(declared(codegen.numbers(2), f=spring, algebra=cga)(np.array([2.0, 3.0]))).ravel() == [6.0]
