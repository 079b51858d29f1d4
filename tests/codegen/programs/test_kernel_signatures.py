"""What algorithms know of kernels is read off their printed text; the traced formula is the reference."""

from __future__ import annotations

import pytest

from bladesmith.codegen.programs import chains
from bladesmith.codegen.programs.dynamics import dynamics
from bladesmith.codegen.programs.dynamics.config import ALGEBRAS, LOADS, DynamicsConfig
from bladesmith.codegen.programs.kernel_spec import trace_spec

LAYOUTS = ("direction", "point", "plane", "line", "twist")


@pytest.mark.parametrize("algebra", ALGEBRAS)
def test_signatures_are_those_of_traced_formulas(algebra: str) -> None:
    needs = [
        DynamicsConfig(algebra, 2, "constrained", LOADS, LAYOUTS, 12, method, callbacks=True)
        for method in ("adaptive", "composition", "rk4")
    ]
    needs.append(DynamicsConfig(algebra, 1, "free", ("gravity",), method="rk4"))
    specs = {spec for each in needs for spec in dynamics._kernel_specs(each)}
    for spec in specs | set(chains.kernel_specs(algebra).values()):
        assert spec.kernel_signature == trace_spec(spec).signature(spec), spec.name
