"""Reverse derivatives of stock kernels: against dual numbers with 50 digits, to the bound of their own rounding, finite
where forward derivatives are, and of at most four times the kernel's operations.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from functools import cache
from typing import Any

import numpy as np
import pytest

import bladesmith as bs
from bladesmith.codegen.algebra.members import sample
from bladesmith.codegen.api import KernelFunction
from bladesmith.codegen.checks.errors import compare, exact_rows
from bladesmith.codegen.checks.exact_items import ColumnRing
from bladesmith.codegen.checks.operands import operand_cases
from bladesmith.codegen.errors import TraceError
from bladesmith.codegen.rings.dual import DualRing
from bladesmith.codegen.rings.protocol import NumericRing, PrecisionRing, Ring
from bladesmith.codegen.trace.kernel import Kernel, operand, value_layouts
from bladesmith.codegen.trace.outputs import as_outputs

from ...support.effort import FULL
from ...support.targets.stock_kernels import all_kernels, declared

#: Most operations of a reverse derivative, in those of the kernel.
MOST = 4.0
DIGITS = 50
ITEMS = 12 if FULL else 6
#: What 50 digits leave of the pairing of tangents and cotangents, relative to its terms.
PAIRED = 1e-36
EXACT_ITEMS = 3


class ExactSource:
    """Numbers with 50 digits, from short random fractions: members hold their constraints to 50 digits."""

    def __init__(self, ring: ColumnRing, seed: int) -> None:
        self.ring, self.random = ring, np.random.default_rng(seed)

    def scalar(self) -> Any:
        return [self.ring.ring.constant(Fraction(float(x))) for x in self.random.normal(size=self.ring.items)]


@cache
def kernel_of(algebra: str, name: str) -> KernelFunction:
    formula, kinds, own, home = declared(algebra)[name]
    return KernelFunction(formula, kinds, None, own, home)


def numbers_like(counts: Sequence[int], source: ExactSource) -> list[list[Any]]:
    return [[source.scalar() for _ in range(count)] for count in counts]


def paired(rows: Sequence[Sequence[Any]], others: Sequence[Sequence[Any]], item: int) -> tuple[Any, Any]:
    """The sum of products of coefficients, and that of their sizes."""
    products = [
        a[item] * b[item] for row, other in zip(rows, others, strict=True) for a, b in zip(row, other, strict=True)
    ]
    return sum(products), sum(map(abs, products))


def forward_tangents(
    kernel: KernelFunction, ring: Ring, given: Sequence[Sequence[Any]], directions: Sequence[Sequence[Any]]
) -> list[list[Any]]:
    """Tangents of the values, from the formula on dual numbers."""
    dual = DualRing(ring)
    operands = [
        operand(i.kind, dual, list(zip(row, along, strict=True)), i.row)
        for i, row, along in zip(kernel.traced.inputs, given, directions, strict=True)
    ]
    zero = ring.constant(Fraction(0))
    results = [r for r in as_outputs(kernel.formula(*operands)) if r.role != "status"]
    tangents = []
    for result, layout in zip(results, value_layouts(kernel.outputs), strict=True):
        values = [v.scalar() for v in result.values] if layout.form == "numbers" else layout.values(result.value)
        tangents.append([zero if v[1] is None else v[1] for v in values])
    return tangents


def operands_with_values(kernel: KernelFunction) -> list[np.ndarray]:
    """Operands of a kernel that has no values of random ones; none for others. Cotangents, which follow, are left out.

    Rotations, circles on a sphere, lines in a plane, positions that a robot reaches; else members of the kinds with
    constraints that have the blades of the layouts.
    """
    name, rng = kernel.name, np.random.default_rng(3)
    positions = rng.normal(size=(ITEMS, 3))
    quaternions = rng.normal(size=(ITEMS, 4))
    quaternions /= np.linalg.norm(quaternions, axis=1, keepdims=True)
    matrices = np.linalg.qr(rng.normal(size=(ITEMS, 3, 3)))[0]
    matrices[:, :, 0] *= np.linalg.det(matrices)[:, None]
    if name.startswith("rotor_from_matrix"):
        return list(matrices.transpose(2, 0, 1))
    if name.startswith("motor_from_matrix"):
        return [*matrices.transpose(2, 0, 1), positions]
    if name.startswith("pose_of_quaternion"):
        return [quaternions, positions]
    if name.startswith("pose_of_matrix"):
        return [np.concatenate([matrices, positions[:, :, None]], 2).reshape(ITEMS, 12)]
    if name.startswith(("delta_inverse", "delta_motion")):
        rates = list(rng.normal(size=(2, ITEMS, 3))) if name.startswith("delta_motion") else []
        robot, sides = np.tile([0.3, 0.5, 1.0, 1.0, 1.0, 0.0], (ITEMS, 1)), np.sign(positions)
        return [0.1 * positions + [0.0, 0.0, 0.8], *rates, robot, sides]
    if name.startswith("common_sphere_any_circle"):
        on_sphere = rng.normal(size=(6, ITEMS, 3))
        on_sphere /= np.linalg.norm(on_sphere, axis=2, keepdims=True)
        p = [bs.cga3d.point(x) for x in on_sphere]
        circles = [p[0] ^ p[1] ^ p[2], p[3] ^ p[4] ^ p[5]]
        return [*(c.as_kind(kernel.kinds[0]).values for c in circles), np.full(ITEMS, 2.0)]
    if name.startswith("common_sphere_any_line"):
        in_plane = np.einsum("kni,nij->knj", rng.normal(size=(4, ITEMS, 2)), matrices[:, :2])
        in_plane[::2] += positions
        lines = [bs.cga3d.line(in_plane[k], in_plane[k + 1]) for k in (0, 2)]
        return [*(x.as_kind(kernel.kinds[0]).values for x in lines), np.full(ITEMS, 2.0)]
    if name.startswith(("velocity_motor", "velocity_rate_motor")):  # of a body: its mass and its moments are positive
        frame = getattr(bs, kernel.algebra.name).random("motor", ITEMS, seed=5).values
        return [frame, rng.uniform(0.5, 2.0, ITEMS), rng.uniform(0.5, 2.0, (ITEMS, 3))]
    if name.startswith(("log_motor_any_motor", "sqrt_motor_any_motor", "log_rotor_even", "sqrt_rotor_even")):
        layout, algebra = kernel.kinds[0], getattr(bs, kernel.algebra.name)
        # A rotation with a translation, or with a transversion and a dilation: by turns without one, or alone.
        x, y, z = positions.T
        x[1::4] = z[2::4] = z[3::4] = x[3::4] = 0.0
        rotation = (1 + x * algebra.e12) / np.sqrt(1 + x * x)
        if "any_motor" in name:
            infinity = algebra.ni if algebra is bs.cga3d else algebra.e0
            versor = rotation * (1 - (y * algebra.e1 + z * algebra.e3) * infinity)
        else:
            dilation = np.sqrt(1 + z * z) + z * (algebra.no ^ algebra.ni)
            versor = rotation * dilation * (1 - (y * algebra.e1 + z * algebra.e2) * algebra.no)
        return [versor.as_kind(layout).values]
    return []


def check_exactly(kernel: KernelFunction) -> None:
    """A tangent from dual numbers, paired with a cotangent, is its direction paired with what is pulled back."""
    ring = ColumnRing(PrecisionRing(DIGITS), EXACT_ITEMS)
    source, kinds = ExactSource(ring, 1), kernel.kinds
    given = [
        [source.scalar() for _ in range(k.size)] if k.form != "multivector" else k.values(sample(k, source))
        for k in kinds
    ]
    for n, array in enumerate(operands_with_values(kernel)):
        rows = array[:EXACT_ITEMS].reshape(EXACT_ITEMS, -1).T.tolist()
        given[n] = [[ring.ring.constant(Fraction(x)) for x in column] for column in rows]
    layouts = value_layouts(kernel.outputs)
    directions, cotangents = (numbers_like([k.size for k in each], source) for each in (kinds, layouts))
    tangents = forward_tangents(kernel, ring, given, directions)
    pulled = kernel.pullback().traced.evaluate_flat([v for row in (*given, *cotangents) for v in row], ring)
    compared = 0
    for item in range(EXACT_ITEMS):
        forward, size = paired(tangents, cotangents, item)
        reverse, other = paired(pulled, directions, item)
        if forward == forward:  # no number of a root that is held at zero: the derivative of the zero is zero
            assert abs(forward - reverse) <= PAIRED * max(size, other)
            compared += 1
    assert compared


def units(kernel: Kernel, members: Sequence[np.ndarray]) -> list[np.ndarray]:
    """The members, but versors are 1 and -1 in turn, and with them plain numbers 1 and 0."""
    found, signs = list(members), np.resize([1.0, -1.0], ITEMS)
    for n, (item, rows) in enumerate(zip(kernel.inputs, members, strict=True)):
        kind = item.kind
        if kind.form != "multivector":
            found[n] = (np.reshape(signs, (-1,) + (1,) * (rows.ndim - 1)) + 1) / 2 + np.zeros_like(rows)
        elif kind.blades[0] == 0 and not kind.is_layout:
            own = np.abs(signs) if any("x['1']" in text for text in kind.constraints) else signs
            found[n] = np.eye(kind.size)[:1] * own[:, None]
    return found


def check_rounding(kernel: KernelFunction) -> None:
    """Cotangents are as near to those with 50 digits as their formula's bound allows, and finite where tangents are."""
    pullback = kernel.pullback()
    traced, rng = pullback.traced, np.random.default_rng(2)
    run, reduced = pullback.on("numpy"), pullback.variant.name.startswith("reduced")
    cases = list(operand_cases(traced, np.float64, ITEMS))
    ordinary = cases[0][1]
    cases.append(("versors 1 and -1", units(traced, ordinary)))
    if special := operands_with_values(kernel):
        cases.append(("operands that have a value", [*special, *ordinary[len(special) :]]))
    seen = False
    for case, arrays in cases:
        found = run(*arrays)
        exact = exact_rows(traced, arrays)
        fault = compare(traced, arrays, found, exact, reduced).fault
        assert not fault, f"{case}, {fault}"
        given = [list(np.reshape(a, (ITEMS, -1)).T) for a in arrays[: len(kernel.kinds)]]
        directions = [list(rng.normal(size=(len(row), ITEMS))) for row in given]
        with np.errstate(all="ignore"):
            tangents = forward_tangents(kernel, NumericRing(), given, directions)
        forward = np.all([np.broadcast_to(np.isfinite(t), ITEMS) for row in tangents for t in row], axis=0)
        results = found if isinstance(found, tuple) else (found,)
        seen |= bool(np.all([np.isfinite(r).reshape(ITEMS, -1).all(1) for r in results], 0).any())
        for values in results:
            assert np.isfinite(values[forward]).all(), f"{case}: not finite, and the forward derivative is"
    assert seen, "no case has a derivative"


#: Kernels of so few operations, because constraints hide what they depend on, that reverse derivatives take more.
EXCEPTIONS = {
    "cga3d_anchor_plane": 6.0,
    "pga3d_motor_to_matrix_translator": 6.0,
}


def check(algebra: str, name: str) -> None:
    kernel = kernel_of(algebra, name)
    check_exactly(kernel)
    check_rounding(kernel)
    assert kernel.pullback().operations.total <= EXCEPTIONS.get(name, MOST) * kernel.operations.total


@pytest.mark.slow
@pytest.mark.parametrize(("algebra", "name"), all_kernels()[:: 1 if FULL else 12], ids=lambda v: str(v))
def test_stock_kernel(algebra: str, name: str) -> None:
    check(algebra, name)


@pytest.mark.parametrize(
    "name", ["exp_bivector_twist", "log_motor_motor", "rotor_between_line_line", "bortz_rate_world_twist_twist"]
)
def test_some_kernels(name: str) -> None:
    check("cga3d", f"cga3d_{name}")


@pytest.mark.slow
@pytest.mark.parametrize(("algebra", "name"), all_kernels()[:: 1 if FULL else 80], ids=lambda v: str(v))
def test_reverse_derivative_of_a_reverse_derivative(algebra: str, name: str) -> None:
    pullback = kernel_of(algebra, name).pullback()
    if any(node.op in ("stumpff6", "stumpff7") for node in pullback.traced.graph.nodes):  # these have no derivatives
        with pytest.raises(TraceError, match="beyond stumpff7"):
            check_exactly(pullback)
        return
    check_exactly(pullback)
    check_rounding(pullback)
