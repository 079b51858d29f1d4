"""Compiled kernels as targets of XLA's foreign-function interface, with the headers that jaxlib ships."""

from __future__ import annotations

import hashlib
from functools import cache
from threading import Lock
from typing import Any

from ..build.extension import load
from ..errors import CompileError, CompilerMissingError
from ..execute.arrays import Binding
from ..execute.bound_kernels import PLAN_INPUTS, PLAN_OUTPUTS, AddedKernel, BoundKernel, Library
from ..execute.reductions.sums import BLOCK, LANES, TILE
from ..targets.c.source import ExtensionSource
from ..targets.templates import render

#: The one target: an attribute names the kernel.
TARGET = "bladesmith_kernel"
#: What it calls of the extension of kernels that are made at run time.
_FUNCTIONS = ("bs_run_sums", "bs_fold", "bs_join")
_DECLARATIONS = """
void bs_jax_start(void *sums, void *fold, void *join);
int bs_jax_add(int64_t key, int kernel, void *run);
void *bs_jax_call(void *frame);
"""


class Calls:
    """The extension that XLA calls, and the kernels that it knows."""

    def __init__(self) -> None:
        import jax
        import jaxlib

        text = render("jax_calls.c.j2", block=BLOCK, lanes=LANES, tile=TILE)
        text = text.replace("XLA_FFI_Error *bs_jax_call(", "void *bs_jax_call(")
        options = (f"-I{jax.ffi.include_dir()}", f'-DBS_JAXLIB="{jaxlib.__version__}"')
        module = load(ExtensionSource("jax_calls", _DECLARATIONS, text, {}, options))
        self.lib, self.ffi = module.lib, module.ffi
        self._known: dict[int, AddedKernel | Library] = {}
        self._lock = Lock()
        handler = self.ffi.addressof(self.lib, "bs_jax_call")
        jax.ffi.register_ffi_target(TARGET, jax.ffi.pycapsule(_ctypes_function(self.ffi, handler)), platform="cpu")

    def key(self, kernel: BoundKernel) -> int | None:
        """The number by which computations name a kernel, the same in each process; None if there are too many."""
        library = kernel.library
        made_of = library.unit if isinstance(library, AddedKernel) else library.made_of
        if not made_of:
            return None
        digest = hashlib.sha256(f"{kernel.symbol} {made_of}".encode()).digest()
        key = int.from_bytes(digest[:8], "little", signed=True)
        with self._lock:
            if key not in self._known:
                if isinstance(library, AddedKernel):
                    self.lib.bs_jax_start(*(self._pointer(library, name) for name in _FUNCTIONS))
                if not self.lib.bs_jax_add(key, kernel.index, self._pointer(library, "bs_run")):
                    return None
                self._known[key] = library
        return key

    def _pointer(self, library: Any, name: str) -> Any:
        """A function of another extension."""
        return self.ffi.cast("void *", int(library.ffi.cast("intptr_t", library.ffi.addressof(library.lib, name))))


def _ctypes_function(ffi: Any, handler: Any) -> Any:
    import ctypes

    return ctypes.CFUNCTYPE(ctypes.c_void_p, ctypes.c_void_p)(int(ffi.cast("intptr_t", handler)))


@cache
def _calls() -> Calls | None:
    try:
        return Calls()
    except (CompilerMissingError, CompileError):
        return None


def key_of(kernel: Binding, is_single: bool) -> int | None:
    """The number by which XLA calls a kernel; None where it is no compiled one, or no compiler is there."""
    is_small = len(kernel.inputs) <= PLAN_INPUTS and len(kernel.outputs) <= PLAN_OUTPUTS
    if not isinstance(kernel, BoundKernel) or not is_small or not kernel.provide(is_single):
        return None
    calls = _calls()
    return calls.key(kernel) if calls else None
