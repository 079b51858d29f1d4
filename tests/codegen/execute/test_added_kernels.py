"""Numbers of kernels that are made at run time: of the extension that they were added to."""

from types import SimpleNamespace

from bladesmith.codegen.execute.bound_kernels import AddedKernel


class Lib:
    """An extension's functions, as far as they are asked."""

    def __init__(self) -> None:
        self.units: list[int] = []

    def bs_add_kernel(self, unit: int) -> int:
        self.units.append(unit)
        return len(self.units) - 1


def test_a_unit_has_a_number_in_each_extension() -> None:
    first, second = (SimpleNamespace(ffi=SimpleNamespace(cast=lambda _, x: x), lib=Lib()) for _ in range(2))
    for unit in (8, 16, 16):
        AddedKernel(first, "f", unit)
    assert first.lib.units == [8, 16], "a unit is added once"
    assert AddedKernel(second, "f", 16).index == {"f": 0}
    assert AddedKernel(first, "f", 16).index == {"f": 1}
