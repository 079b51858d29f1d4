"""What importing costs, and that nothing heavy comes with it; each check is a fresh interpreter."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

HEAVY = ("sympy", "jinja2", "numba", "pydantic", "clifford", "matplotlib", "cffi", "pycparser", "tqdm", "click")
#: Room for what `import bladesmith` costs beyond NumPy.
BUDGET_SECONDS = 0.030


def run(code: str, *arguments: str) -> dict[str, object]:
    done = subprocess.run([sys.executable, "-c", code, *arguments], capture_output=True, text=True, check=True)
    result: dict[str, object] = json.loads(done.stdout.splitlines()[-1])
    return result


@pytest.mark.compiles
def test_import_is_as_cheap_as_numpy() -> None:
    code = (
        "import time, json, numpy; start = time.process_time(); import bladesmith; "
        "print(json.dumps({'seconds': time.process_time() - start}))"
    )
    assert min(float(str(run(code)["seconds"])) for _ in range(5)) <= BUDGET_SECONDS


def test_nothing_heavy_is_imported() -> None:
    code = (
        "import sys, json, bladesmith as bs; first = sorted(sys.modules)\n"
        "cga = bs.cga3d; x = cga.rotor([0, 0, 1], 0.5) >> cga.point([1.0, 2.0, 3.0])\n"
        "y = bs.algebra(3).e1 * bs.algebra(3).e2\n"
        "x.parameters(); repr(x); cga.classify(x); (x + x).normalized(); x.isclose(x)\n"
        "print(json.dumps({'first': first, 'then': sorted(sys.modules)}))"
    )
    found = run(code)
    for stage in ("first", "then"):
        modules = {str(name).partition(".")[0] for name in found[stage]}  # type: ignore[attr-defined]
        assert not modules & set(HEAVY), stage
    assert "numpy" not in found["first"]  # type: ignore[operator]


def test_names_of_the_package() -> None:
    code = (
        "import json, bladesmith as bs; from bladesmith import cga3d as cga, pga3d, cga2d, codegen, errors\n"
        "names = [n for n in bs.__all__ if not hasattr(bs, n)]\n"
        "import bladesmith.core.registry; same = bs.algebra(3, 0, 1) is pga3d and bs.cga3d is cga\n"
        "print(json.dumps({'missing': names, 'same': same, 'callable': callable(bs.algebra)}))"
    )
    assert run(code) == {"missing": [], "same": True, "callable": True}


def test_misspelt_names_have_suggestions() -> None:
    """Of lazily loaded names and of algebras; what protocols ask for is not looked for, and nothing is loaded."""
    code = (
        "import sys, json, copy, pickle, bladesmith as bs; from bladesmith import cga3d, dynamics\n"
        "def text(home, name):\n"
        "    try: getattr(home, name)\n"
        "    except AttributeError as error: return str(error)\n"
        "misses = [(bs, 'registraton'), (bs, 'tracr'), (bs, 'cga3'), (dynamics, 'Simulatoin'), (cga3d, 'cirlce'),\n"
        "          (bs, 'zzz'), (cga3d, 'zzz'), (bs, '__circle__'), (cga3d, '__circle__')]\n"
        "found = [text(*miss) for miss in misses]\n"
        "from bladesmith.codegen import errors; asked = []\n"
        "errors.nearest = lambda *a: asked.append(a)\n"
        "quiet = [hasattr(x, n) for x in (bs, cga3d) for n in ('__array__', '_repr_png_', '__getstate__0')]\n"
        "same = all(x is cga3d for x in (copy.copy(cga3d), copy.deepcopy(cga3d), pickle.loads(pickle.dumps(cga3d))))\n"
        "print(json.dumps({'found': found, 'asked': len(asked), 'quiet': any(quiet), 'same': same}))"
    )
    result = run(code)
    found: list[str] = result.pop("found")  # type: ignore[assignment]
    for line, near in zip(found, ("registration", "tracer", "cga3d", "Simulation", "circle"), strict=False):
        assert f"(did you mean {near!r}?)" in line
    assert not any("did you mean" in line for line in found[5:])
    assert result == {"asked": 0, "quiet": False, "same": True}


def test_algebras_are_imported_as_modules() -> None:
    code = (
        "import json, bladesmith.cga3d, bladesmith.pga3d as pga, bladesmith.cga2d, pickle\n"
        "from bladesmith.cga3d import e12; import bladesmith as bs; from importlib import import_module\n"
        "same = [bladesmith.cga3d is bs.cga3d, pga is bs.pga3d, bladesmith.cga2d is bs.cga2d]\n"
        "same += [import_module('bladesmith.cga3d') is bs.cga3d, pickle.loads(pickle.dumps(pga)) is pga]\n"
        "same += [e12.algebra is bs.cga3d]\n"
        "try: import bladesmith.cga9d\n"
        "except ModuleNotFoundError as error: same += [error.name == 'bladesmith.cga9d']\n"
        "print(json.dumps({'same': same}))"
    )
    assert run(code) == {"same": [True] * 7}


def test_an_algebra_generated_into_the_package_is_imported_as_a_module(tmp_path: Path) -> None:
    (tmp_path / "plane").mkdir()
    spec = {"name": "plane", "vectors": ["1", "2"], "metric": [["1", "1", "1"], ["2", "2", "1"]], "kinds": {}}
    (tmp_path / "plane" / "manifest.json").write_text(json.dumps({"format": 2, "algebra": spec, "kernels": []}))
    code = (
        "import json, bladesmith.generated, sys; bladesmith.generated.__path__.append(sys.argv[1])\n"
        "from bladesmith.core import registry\n"
        "from pathlib import Path; registry.stock_kernels.bundled_folder = lambda name: Path(sys.argv[1]) / name\n"
        "import bladesmith.plane, bladesmith as bs\n"
        "print(json.dumps({'same': bladesmith.plane is bs.plane, 'name': bs.plane.name}))"
    )
    assert run(code, str(tmp_path)) == {"same": True, "name": "plane"}
