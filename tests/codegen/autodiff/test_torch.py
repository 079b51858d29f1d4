"""Kernels as functions of PyTorch tensors, against the kernels and PyTorch's own checks of gradients and operators."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from bladesmith import cga3d as cga
from bladesmith import codegen
from bladesmith.codegen.errors import InputError, ShapeError

pytestmark = pytest.mark.peers


@pytest.fixture
def torch() -> Any:
    return pytest.importorskip("torch")


@codegen.kernel(cga.layout("motor"), cga.layout("point"))
def move(m: Any, x: Any) -> Any:
    return m * x * ~m


@codegen.kernel(codegen.scalar, codegen.numbers(2), algebra=cga, reduce="sum")
def total(a: Any, b: Any) -> Any:
    return codegen.row([codegen.sin(a) * b[0], a * b[1] * b[1]])


M = cga.rotor((0, 0, 1), 0.5, point=(1, 0, 0)).as_kind("motor").values
X = cga.point(np.random.default_rng(0).normal(size=(6, 3))).values


def test_values_and_derivatives(torch: Any) -> None:
    f = move.torch()
    m, x = (torch.tensor(a.copy(), requires_grad=True) for a in (M, X))
    y = f(m, x)
    np.testing.assert_array_equal(y.detach().numpy(), move(M, X))
    (y**2).sum().backward()
    for found, true in zip((m.grad, x.grad), move.vjp(M, X)(2 * move(M, X)), strict=True):
        np.testing.assert_allclose(found.numpy(), true, rtol=1e-14)
    assert torch.autograd.gradcheck(f, (m, x)) and torch.autograd.gradgradcheck(f, (m, x))
    assert f(m.float(), x.float()).dtype == torch.float32


def test_a_sum_over_all_items(torch: Any) -> None:
    a, b = (torch.tensor(v, dtype=torch.float64, requires_grad=True) for v in (np.linspace(0, 1, 300), [0.5, -1.5]))
    assert torch.autograd.gradcheck(total.torch(), (a, b))


def test_the_operator_is_one_by_the_rules_of_pytorch(torch: Any) -> None:
    from bladesmith.codegen.autodiff import torch_kernels
    from bladesmith.codegen.autodiff.calls import call_of

    operands = [torch.tensor(a.copy(), requires_grad=True) for a in (M, X)]
    results = torch.library.opcheck(torch_kernels._operator, (torch_kernels._number(call_of(move, (6,))), operands))
    assert set(results.values()) == {"SUCCESS"}


def test_wrong_tensors_are_refused(torch: Any) -> None:
    f, m, x = move.torch(), torch.tensor(M.copy()), torch.tensor(X.copy())
    for wrong, word in ((x.half(), "float16"), (x.to(torch.complex128), "complex"), (x.to_sparse(), "sparse"),
                        (x.to("meta"), "meta")):  # fmt: skip
        with pytest.raises(InputError, match=word):
            f(m, wrong)
    with pytest.raises(ShapeError, match="5 entries"):
        f(m, m)
    turned = x.T.contiguous().T
    assert not turned.is_contiguous() and torch.equal(f(m, turned), f(m, x))
