"""Kernels shipped with the package: the manifest of a generated folder, and the compiled library behind it.

Kernels are found by formula and by the kinds of the operands. Those of one module of formulas, for one precision, are
a unit: compiled at install, or when the first of them is called. Without a compiler the same kernels run as plain
Python on whole columns, and through numba once they are used much.
"""

from __future__ import annotations

import json
import logging
from collections.abc import Mapping, Sequence
from functools import cache, cached_property, partial
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..codegen.algebra.algebra import Kind
from ..codegen.build.flags import compiled_files, source_hash, unit_file
from ..codegen.build.installed import bundled_folder as bundled_folder
from ..codegen.build.installed import headers, is_fresh, linked_units
from ..codegen.errors import BladesmithError, SpecError
from ..codegen.execute.arrays import Array, Binding
from ..codegen.execute.bound_kernels import BoundKernel, Library
from ..codegen.ir.argument import Argument
from .kernel_entries import Entry, Key, Result
from .types import TypedAlgebra

if TYPE_CHECKING:
    from ..codegen.execute.numba_jit import NumbaLibrary

#: Manifests of this form are read.
FORMAT = 2
#: Without a compiled library: items of one kernel after which numba is worth its compilation (seconds).
WORTH_NUMBA = 1_000_000
_log = logging.getLogger("bladesmith")


class StockKernels:
    """Kernels of one generated folder.

    Parameters
    ----------
    algebra : TypedAlgebra
        The algebra that the kinds of the manifest belong to.
    folder : Path
        ``generated/<name>``.
    manifest : mapping
        Contents of its manifest.json.
    """

    def __init__(self, algebra: TypedAlgebra, folder: Path, manifest: Mapping[str, Any]) -> None:
        self.algebra = algebra
        self.folder = folder
        self.entries: dict[str, list[Entry]] = {}
        self._modules: dict[str, str] = {}
        for kernel in manifest.get("kernels", ()):
            entry = _entry(algebra, kernel)
            self.entries.setdefault(entry.formula, []).append(entry)
            self._modules[entry.symbol] = entry.module
        self._bound: dict[str, Binding] = {}
        self._refused: set[tuple[str, str]] = set()

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
        text = self.folder / "kernels" / f"{entry.module}.py"
        written = partial(PlainKernel, text, entry.symbol, inputs, outputs)
        if self.library is None or entry.symbol not in self.library.index:
            return written()
        return BoundKernel(self.library, entry.symbol, inputs, outputs, written)

    @cached_property
    def library(self) -> Library | None:
        """The tables of compiled kernels, filled as they are called; None where nothing can be compiled."""
        module = self._installed_module
        if module is not None and not is_fresh(module, self.folder):
            _log.warning("the compiled kernels of %s are older than their sources; compiling them now.", self.folder)
            module = None
        try:
            return Library(module or self._compile_library(), self._supply)
        except (BladesmithError, OSError) as error:
            _log.warning("the kernels of %s are run as plain Python: %s", self.algebra.name, error)
            return None

    @cached_property
    def _installed_module(self) -> Any:
        if self.folder != bundled_folder(self.algebra.name):
            return None
        try:
            return import_module(f"...generated.{self.folder.name}._kernels", __name__)
        except ImportError:
            return None

    @cached_property
    def _linked_units(self) -> dict[tuple[str, str, str], Any]:
        return linked_units(self._installed_module)

    def _compile_library(self) -> Any:
        from ..codegen.build.extension import generated_extension, load, required_compiler

        required_compiler("generated kernels are compiled when they are loaded")
        return load(generated_extension(self.folder, headers()))

    def _supply(self, symbol: str, instances: Sequence[str]) -> None:
        """Add a unit with this kernel: one that was compiled at install from these sources, else one compiled now."""
        assert self.library is not None
        module = self._modules[symbol]
        made_of = source_hash(compiled_files(self.folder, headers(), [unit_file(module)]))
        for instance in instances:
            unit = self._linked_units.get((module, instance, made_of))
            if unit is not None:
                self.library.lib.bs_add_unit(unit)
                return
        if (module, instances[0]) not in self._refused:
            try:
                self.library.lib.bs_add_unit(self._compile_unit(module, instances[0]))
            except (BladesmithError, OSError) as error:  # no compiler, no room, no place that can be written
                self._refused.add((module, instances[0]))
                _log.warning("%s, %s: run as plain Python: %s", self.algebra.name, module, error)

    def _compile_unit(self, module: str, instance: str) -> Any:
        from ..codegen.build.extension import generated_unit, load_unit, required_compiler
        from ..codegen.targets.c.instances import BY_TAG

        required_compiler("what was not compiled at install is compiled at its first use")
        unit = load_unit(generated_unit(self.folder, headers(), module, BY_TAG[instance]))
        assert self.library is not None
        return self.library.ffi.cast("void *", unit)


class PlainKernel(Binding):
    """A kernel of kernels/<module>.py: on whole columns with NumPy, and with numba when it is used much."""

    def __init__(self, text: Path, symbol: str, inputs: Sequence[Argument], outputs: Sequence[Argument]) -> None:
        super().__init__(symbol, inputs, outputs)
        self._text = text
        self._items = 0
        self._on_columns = self._kernel(compiled=False)
        self._compiled: Binding | None = None

    def _kernel(self, compiled: bool) -> Binding:
        from ..codegen.execute.numba_jit import NumbaKernel

        return NumbaKernel(_plain_library(self._text, compiled), self.symbol, self.inputs, self.outputs)

    def run(self, arrays: Sequence[Array], results: Sequence[Array], n: int) -> None:
        """Compute ``n`` items."""
        self._items += n
        if self._compiled is None and self._items > WORTH_NUMBA and find_spec("numba") is not None:
            _log.info("compiling %s with numba after %d items.", self.symbol, self._items)
            self._compiled = self._kernel(compiled=True)
        (self._compiled or self._on_columns).run(arrays, results, n)


@cache
def _plain_library(text: Path, compiled: bool) -> NumbaLibrary:
    """The text of a module's kernels, read once."""
    from ..codegen.execute.numba_jit import NumbaLibrary

    try:
        return NumbaLibrary(text.read_text(encoding="utf-8"), compiled)
    except OSError as error:
        remedy = "Run: bladesmith generate"
        raise SpecError(f"no text of its kernels ({error})", where=str(text), remedy=remedy) from None


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
    except (OSError, ValueError, RecursionError) as error:
        raise SpecError(f"not a manifest ({error})", where=str(path), remedy="Run: bladesmith generate") from None
    if not isinstance(manifest, dict) or manifest.get("format") != FORMAT:
        raise SpecError(f"not a manifest of format {FORMAT}", where=str(path), remedy="Run: bladesmith generate")
    return manifest


def _entry(algebra: TypedAlgebra, kernel: Mapping[str, Any]) -> Entry:
    inputs = [_operand(algebra, item) for item in kernel["inputs"]]
    return Entry(
        kernel["symbol"],
        kernel["module"],
        kernel["formula"],
        tuple(item["name"] for item in kernel["inputs"]),
        tuple(inputs),
        tuple(_result(algebra, item) for item in kernel["outputs"]),
        _proved_results(algebra, kernel["results"]) if "results" in kernel else None,
    )


def _proved_results(algebra: TypedAlgebra, results: Sequence[Mapping[str, Any]]) -> dict[tuple[Key, ...], Kind]:
    pairs = ((tuple(_operand(algebra, i) for i in r["inputs"]), _operand(algebra, r["output"])) for r in results)
    return {inputs: kind for inputs, kind in pairs if isinstance(kind, Kind)}


def _operand(algebra: TypedAlgebra, item: Mapping[str, Any]) -> Key:
    form = item.get("form")
    if form == "number":
        return 0
    if form == "numbers":
        return int(item["size"])
    if "blades" in item:
        return algebra.layout_of(algebra.parse_blade(name)[0] for name in item["blades"])
    kind = algebra.kind(item["kind"])
    return kind.layout if item.get("layout") else kind


def _result(algebra: TypedAlgebra, item: Mapping[str, Any]) -> Result:
    if item.get("role") == "status":
        return Result(item["name"], None, 1, True)
    operand = _operand(algebra, item)
    if isinstance(operand, int):
        return Result(item["name"], None, max(operand, 1))
    return Result(item["name"], operand, operand.size)
