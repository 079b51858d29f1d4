"""The kernels that the package carries: what a generated folder's manifest says, and the compiled library behind it.

Kernels are found by formula and by the kinds of the operands. Where the extension was not built, the same kernels
run as plain Python on whole columns, and through numba once they are used much.
"""

from __future__ import annotations

import json
import logging
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .codegen.binding import Argument, Array, Binding, BoundKernel, Library
from .codegen.errors import BladesmithError, SpecError
from .codegen.kinds import Kind
from .installed import bundled as bundled
from .installed import headers, is_fresh

if TYPE_CHECKING:
    from .algebras import Algebra

#: What an operand is: a kind, 0 for a plain number per item, or the length of a row of plain numbers.
Key = Kind | int
#: Manifests of this form are read.
FORMAT = 1
#: Without a compiled library: items of one kernel after which numba is worth its compilation (seconds).
WORTH_NUMBA = 1_000_000
_log = logging.getLogger("bladesmith")


@dataclass(frozen=True)
class Result:
    """One result of a kernel: a multivector's kind, a row of ``size`` plain numbers, or a status."""

    name: str
    kind: Kind | None
    size: int
    is_status: bool = False


@dataclass(frozen=True)
class Entry:
    """One kernel of a manifest."""

    symbol: str
    formula: str
    names: tuple[str, ...]
    inputs: tuple[Key, ...]
    outputs: tuple[Result, ...]


class StockKernels:
    """Kernels of one generated folder.

    Parameters
    ----------
    algebra : Algebra
        What the kinds of the manifest belong to.
    folder : Path
        ``generated/<name>``.
    manifest : mapping
        Contents of its manifest.json.
    """

    def __init__(self, algebra: Algebra, folder: Path, manifest: Mapping[str, Any]) -> None:
        self.algebra = algebra
        self.folder = folder
        self.entries: dict[str, list[Entry]] = {}
        for kernel in manifest.get("kernels", ()):
            entry = _entry(algebra, kernel)
            self.entries.setdefault(entry.formula, []).append(entry)
        self._bound: dict[str, Binding] = {}

    def bound(self, entry: Entry) -> Binding:
        """The kernel as a function of arrays."""
        if entry.symbol not in self._bound:
            self._bound[entry.symbol] = self._bind(entry)
        return self._bound[entry.symbol]

    def _bind(self, entry: Entry) -> Binding:
        inputs = [
            Argument(name, key if isinstance(key, int) else key.size)
            for name, key in zip(entry.names, entry.inputs, strict=True)
        ]
        outputs = [Argument(o.name, 0 if o.is_status else o.size, o.is_status) for o in entry.outputs]
        if self.library is not None and entry.symbol in self.library.index:
            return BoundKernel(self.library, entry.symbol, inputs, outputs)
        return PlainKernel(self.folder, entry.symbol, inputs, outputs)

    @cached_property
    def library(self) -> Library | None:
        """The compiled extension, or None where there is none."""
        module = self._installed()
        if module is not None and module.lib.bs_source_hash() and not is_fresh(module, self.folder):
            _log.warning("the compiled kernels of %s are older than their sources; compiling them now.", self.folder)
            module = None
        elif module is None and self._is_bundled:
            _log.info("%s has no compiled kernels: running them as plain Python.", self.algebra.name)
            return None
        try:
            return Library(module or self._compiled())
        except BladesmithError as error:
            _log.warning("the kernels of %s are run as plain Python: %s", self.algebra.name, error)
            return None

    @property
    def _is_bundled(self) -> bool:
        return self.folder == bundled(self.algebra.name)

    def _installed(self) -> Any:
        if not self._is_bundled:
            return None
        try:
            return import_module(f".generated.{self.folder.name}._kernels", __package__)
        except ImportError:
            return None

    def _compiled(self) -> Any:
        from .codegen.build import generated_extension, load

        return load(generated_extension(self.folder, headers()))


class PlainKernel(Binding):
    """A kernel of kernels_numba.py: on whole columns with NumPy, and with numba when it is used much."""

    def __init__(
        self, folder: Path, symbol: str, inputs: Sequence[Argument], outputs: Sequence[Argument]
    ) -> None:
        super().__init__(symbol, inputs, outputs)
        self._source = (folder / "kernels_numba.py").read_text(encoding="utf-8")
        self._items = 0
        self._on_columns = self._kernel(compiled=False)
        self._compiled: Binding | None = None

    def _kernel(self, compiled: bool) -> Binding:
        from .codegen.targets.numba_run import NumbaKernel, NumbaLibrary

        return NumbaKernel(NumbaLibrary(self._source, compiled), self.symbol, self.inputs, self.outputs)

    def run(self, arrays: Sequence[Array], results: Sequence[Array], n: int) -> None:
        """Compute ``n`` items."""
        self._items += n
        if self._compiled is None and self._items > WORTH_NUMBA and find_spec("numba") is not None:
            _log.info("compiling %s with numba after %d items.", self.symbol, self._items)
            self._compiled = self._kernel(compiled=True)
        (self._compiled or self._on_columns).run(arrays, results, n)


def read_manifest(folder: Path) -> dict[str, Any]:
    """Contents of a generated folder's manifest.json.

    Raises
    ------
    SpecError
        If it is missing, damaged or of another format.
    """
    path = folder / "manifest.json"
    try:
        manifest = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise SpecError(f"not a manifest ({error})", where=str(path), remedy="Run: bladesmith generate") from None
    if not isinstance(manifest, dict) or manifest.get("format") != FORMAT:
        raise SpecError(f"not a manifest of format {FORMAT}", where=str(path), remedy="Run: bladesmith generate")
    return manifest


def _entry(algebra: Algebra, kernel: Mapping[str, Any]) -> Entry:
    inputs = [_operand(algebra, item) for item in kernel["inputs"]]
    return Entry(
        kernel["symbol"],
        kernel.get("serves", kernel["formula"]),
        tuple(item["name"] for item in kernel["inputs"]),
        tuple(inputs),
        tuple(_result(algebra, item) for item in kernel["outputs"]),
    )


def _operand(algebra: Algebra, item: Mapping[str, Any]) -> Key:
    form = item.get("form")
    if form == "number":
        return 0
    if form == "numbers":
        return int(item["size"])
    if "blades" in item:
        return algebra.layout_of(algebra.parse_blade(name)[0] for name in item["blades"])
    kind = algebra.kind(item["kind"])
    return kind.layout if item.get("layout") else kind


def _result(algebra: Algebra, item: Mapping[str, Any]) -> Result:
    if item.get("role") == "status":
        return Result(item["name"], None, 1, True)
    operand = _operand(algebra, item)
    if isinstance(operand, int):
        return Result(item["name"], None, max(operand, 1))
    return Result(item["name"], operand, operand.size)
