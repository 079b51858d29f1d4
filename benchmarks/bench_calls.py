"""One item at a time: what a call costs from Python, beside kingdon and clifford.

    python benchmarks/bench_calls.py
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import time
import timeit
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import bladesmith as bs

REPEATS, CALLS = 9, 20_000
#: Bars, in nanoseconds, and in seconds for the import.
BARS = {"R >> x": 2000.0, "stock kernel on arrays": 2000.0, "bound plan": 300.0}
IMPORT_BAR = 0.030


def best(run: Callable[[], Any], calls: int = CALLS) -> float:
    """Nanoseconds of processor time per call of the fastest series."""
    run()
    return min(timeit.repeat(run, number=calls, repeat=REPEATS, timer=time.process_time)) / calls * 1e9


def ours() -> dict[str, float]:
    cga, plain = bs.cga3d, bs.algebra(3)
    motor = cga.translator([1.0, 2.0, 3.0]) * cga.rotor([0.0, 0.0, 1.0], 0.5)
    x, circle = cga.point([1.0, 2.0, 3.0]), cga.circle([1.0, 2.0, 3.0], [0.0, 0.0, 1.0], 2.0)
    v, w = plain.multivector([1.0, 2.0, 3.0], grades=[1]), plain.multivector([1.0, 2.0, 3.0, 4.0], grades=[0, 2])
    dense = cga.multivector(np.ones(32))
    stock = cga.stock
    assert stock is not None
    entries = stock.entries["products.sandwich"]
    entry = next(e for e in entries if e.inputs == (cga.kind("motor"), cga.kind("point")))
    kernel: Any = stock.bound(entry)
    rows = motor.values.copy(), x.values.copy()
    plan = kernel.plan(*rows)
    return {
        "R >> x": best(lambda: motor >> x),
        "R >> circle": best(lambda: motor >> circle),
        "R * R": best(lambda: motor * motor),
        "dense product": best(lambda: dense * dense),
        "general product, v * w": best(lambda: v * w),
        "general sandwich, w >> v": best(lambda: w >> v),
        "stock kernel on arrays": best(lambda: kernel(*rows)),
        "bound plan": best(plan),
        "~R": best(lambda: ~motor),
        "x + x": best(lambda: x + x),
        "2.0 * x": best(lambda: 2.0 * x),
        'x["e1"]': best(lambda: x["e1"]),
        "cga.point(array)": best(lambda: cga.point(rows[1][:3]), 5000),
        "circle.parameters()": best(circle.parameters, 2000),
        "R.log()": best(motor.log, 5000),
        "(3 x).normalized()": best((3 * x).normalized, 1000),
    }


def objects_table() -> dict[str, tuple[float, float]]:
    """Nanoseconds of constructors and of readers of all kinds of objects: of one item, and of ten at once."""
    found: dict[str, list[float]] = {}
    for count in (1, 10):
        random = np.random.default_rng(0)
        lead = () if count == 1 else (count,)
        a, b, c, d = random.normal(size=(4, *lead, 3))
        number = np.abs(random.normal(size=lead)) + 0.5
        r: Any = number if lead else float(number)
        arguments = {
            "point": (a,), "direction": (a,), "line": (a, b), "line_through": (a, b), "plane": (a, r),
            "plane_through": (a, b, c), "translator": (a,), "rotor": (b, r), "rotor about": (b, r, a),
            "flat_point": (a,), "point_pair": (a, b), "circle": (a, b, r), "sphere": (a, r),
            "circle_through": (a, b, c), "sphere_through": (a, b, c, d), "dilator": (r,),
            "dilator about": (r, a), "transversor": (a,),
        }  # fmt: skip
        for algebra in (bs.cga3d, bs.pga3d):
            for name, given in arguments.items():
                make = getattr(algebra, name.partition(" ")[0], None)
                if make is None:
                    continue
                made, label = make(*given), f"{algebra.name}.{name}"
                found.setdefault(label, []).append(best(lambda make=make, given=given: make(*given), 1000))
                if "_through" not in name:
                    found.setdefault(f"{label}, parameters", []).append(best(made.parameters, 200))
                if name in ("point", "line", "plane", "circle", "sphere", "point_pair"):
                    found.setdefault(f"{label}, normalized", []).append(best((3 * made).normalized, 200))
            motor = algebra.translator(a) * algebra.rotor(b, r)
            matrix, twist = motor.to_matrix(), motor.log()
            for name, run in {
                "motor_from_matrix": lambda m=matrix, g=algebra: g.motor_from_matrix(m), "R.to_matrix": motor.to_matrix,
                "R.parameters": motor.parameters, "R.log": motor.log, "B.exp": twist.exp, "R.sqrt": motor.sqrt,
                "R.inverse": motor.inverse,
            }.items():  # fmt: skip
                found.setdefault(f"{algebra.name} {name}", []).append(best(run, 200))
    return {name: (one, ten) for name, (one, ten) in found.items()}


def peers() -> dict[str, float]:
    found: dict[str, float] = {}
    try:
        from kingdon import Algebra

        alg = Algebra(4, 1)
        r = alg.multivector(e=0.9, e12=0.4)
        x = alg.vector([1.0, 2.0, 3.0, 0.5, 0.5])
        found["kingdon R >> x"] = best(lambda: r >> x, 2000)
    except ImportError:
        pass
    try:
        import clifford

        layout, blades = clifford.Cl(4, 1)
        r = 0.9 + 0.4 * blades["e12"]
        x = blades["e1"] + 2 * blades["e2"]
        found["clifford R x ~R"] = best(lambda: r * x * ~r, 2000)
    except ImportError:
        pass
    return found


def import_seconds() -> float:
    """Best of several fresh interpreters: bladesmith after NumPy."""
    code = "import numpy, time; s = time.perf_counter(); import bladesmith; print(time.perf_counter() - s)"
    runs = [subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True) for _ in range(5)]
    return min(float(run.stdout) for run in runs)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--json", type=Path, help="write the numbers here too")
    options = parser.parse_args()
    found = {**ours(), **peers()}
    for name, value in found.items():
        bar = f"   bar {BARS[name]:.0f}" if name in BARS else ""
        print(f"{name:28s}{value:10.0f} ns{bar}")
    table = objects_table()
    print(f"\n{'objects':34s}{'one item':>12s}{'ten':>12s}   ns")
    for name, (one, ten) in table.items():
        print(f"{name:34s}{one:12.0f}{ten:12.0f}")
    seconds = import_seconds()
    print(f"{'import after numpy':28s}{seconds * 1e3:10.1f} ms   bar {IMPORT_BAR * 1e3:.0f}")
    if options.json:
        options.json.write_text(json.dumps({**found, "objects": table, "import seconds": seconds}, indent=1) + "\n")
    missed = [name for name, bar in BARS.items() if found[name] > bar] + ["import"] * (seconds > IMPORT_BAR)
    if missed:
        print(f"missed: {', '.join(missed)}")
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
