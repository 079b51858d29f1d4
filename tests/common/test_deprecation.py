"""Old names work, and say once which name is new."""

from __future__ import annotations

import sys
import timeit
import types
import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from bladesmith.common import deprecation
from bladesmith.common.deprecation import renamed_attribute, renamed_keywords, renamed_names, reordered


@pytest.fixture(autouse=True)
def nothing_warned(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(deprecation, "_warned", set())


@renamed_keywords(kind="cost", count="n")
def price(x: float, *, cost: str = "least", n: int = 1) -> tuple[float, str, int]:
    return x, cost, n


@renamed_keywords(H="target")
@dataclass(frozen=True)
class Pin:
    place: int
    target: float = 0.0

    level = renamed_attribute("target")
    measured = renamed_attribute("measure")
    counted = renamed_attribute("count")

    def measure(self) -> float:
        return self.place + self.target

    @classmethod
    def count(cls) -> str:
        return cls.__name__


def test_a_keyword_warns_once_at_the_users_line() -> None:
    with pytest.warns(FutureWarning, match=r"price\(kind=\) is now cost=") as seen:
        assert price(1.0, kind="most", n=3) == (1.0, "most", 3)
        assert price(1.0, kind="most") == (1.0, "most", 1)
    assert len(seen) == 1 and Path(seen[0].filename) == Path(__file__)
    with pytest.warns(FutureWarning, match=r"price\(count=\) is now n="):
        assert price(1.0, count=2) == (1.0, "least", 2)


def test_new_names_do_not_warn() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert price(1.0, cost="most") == (1.0, "most", 1)
        assert Pin(1, target=2.0).measure() == 3.0


def test_both_names_are_an_error() -> None:
    with pytest.raises(TypeError, match="'cost' twice: also as 'kind'"):
        price(1.0, cost="most", kind="least")


def test_a_class_keeps_its_type_and_takes_old_keywords() -> None:
    with pytest.warns(FutureWarning, match=r"Pin\(H=\) is now target="):
        pin = Pin(1, H=3.0)
    assert isinstance(pin, Pin) and pin == Pin(1, 3.0)


def test_attributes_of_instances_and_classes() -> None:
    pin = Pin(1, 3.0)
    with pytest.warns(FutureWarning, match="Pin.level is now Pin.target"):
        assert pin.level == 3.0
    with pytest.warns(FutureWarning, match="Pin.measured is now Pin.measure"):
        assert pin.measured() == 4.0
    with pytest.warns(FutureWarning, match="Pin.counted is now Pin.count"):
        assert Pin.counted() == "Pin"


@pytest.mark.parametrize("lazy", [False, True])
def test_names_of_modules(lazy: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    def find(name: str) -> Any:
        if name != "path":
            raise AttributeError(name)
        return 7

    module = types.ModuleType("a_module")
    monkeypatch.setitem(sys.modules, "a_module", module)
    if not lazy:
        module.path = 7  # type: ignore[attr-defined]
    module.__getattr__ = renamed_names("a_module", find if lazy else None, way="path")  # type: ignore[method-assign]
    with pytest.warns(FutureWarning, match="a_module.way is now a_module.path") as seen:
        from a_module import way  # type: ignore[import-not-found]

        assert way == module.way == module.path == 7
    assert len(seen) == 1 and Path(seen[0].filename) == Path(__file__)
    with pytest.raises(AttributeError):
        _ = module.other


def test_another_order() -> None:
    class Writer:
        @reordered("self", "image", "path", when=lambda self, first, *_: not isinstance(first, str))
        def save(self, path: str, image: int) -> tuple[str, int]:
            return path, image

    with pytest.warns(
        FutureWarning, match=r"save\(\) with its arguments in this order is now called with image=, path="
    ):
        assert Writer().save(1, "x.png") == ("x.png", 1)  # type: ignore[arg-type]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert Writer().save("x.png", 1) == Writer().save("x.png", image=1) == ("x.png", 1)


def test_the_cost_of_a_wrapper_is_some_microseconds_at_most() -> None:
    plain = price.__wrapped__  # type: ignore[attr-defined]
    times = [min(timeit.repeat(lambda f=f: f(1.0, cost="most"), number=20_000, repeat=5)) for f in (price, plain)]
    assert (times[0] - times[1]) / 20_000 < 5e-6  # 0.2 us, on a machine that does nothing else
