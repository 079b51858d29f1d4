"""Functions that only others of a printed text call, compiled as far as their callers need them.

numba optimises each function with all that it calls and makes machine code of it, then links it into its callers,
where the same is done again. Of what nobody calls from Python a caller needs the typed, unoptimised code alone: a
third of the time that a program takes to compile. Made of numba's extension points (`CompilerBase`, passes, libraries).
"""

from __future__ import annotations

from functools import cache
from importlib import import_module
from typing import Any


@cache
def inner_compiler() -> Any:
    """numba's compiler (the option ``pipeline_class``) for functions that are never called from Python."""
    codegen: Any = import_module("numba.core.codegen")
    compiler: Any = import_module("numba.core.compiler")
    machinery: Any = import_module("numba.core.compiler_machinery")
    passes: Any = import_module("numba.core.typed_passes")

    class NoEnvironment:
        """Where a function's address in machine code would be told its environment."""

        @staticmethod
        def set_env(name: str, environment: Any) -> None:
            """There is no machine code."""

    class InnerLibrary(codegen.JITCodeLibrary):  # type: ignore[misc]
        """Code that is linked into a caller's, and nothing else."""

        codegen = NoEnvironment

        def get_pointer_to_function(self, name: str) -> int:
            """None."""
            return 0

        def _optimize_final_module(self) -> None:
            pass

        def _finalize_final_module(self) -> None:
            self._finalize_dynamic_globals()
            self._finalized = True

    @machinery.register_pass(mutates_CFG=True, analysis_only=False)  # type: ignore[untyped-decorator, unused-ignore]
    class InnerLowering(passes.NativeLowering):  # type: ignore[misc]
        """numba's own lowering, into such a library."""

        _name = "bladesmith_inner_lowering"

        def run_pass(self, state: Any) -> bool:
            """Lower one function."""
            state.library = InnerLibrary(state.targetctx.codegen(), state.func_id.func_qualname)
            state.library.enable_object_caching()
            return bool(super().run_pass(state))

    class InnerCompiler(compiler.CompilerBase):  # type: ignore[misc]
        """numba's usual passes but for the last."""

        def define_pipelines(self) -> list[Any]:
            """The one that makes native code."""
            manager = compiler.DefaultPassBuilder.define_nopython_pipeline(self.state)
            own = {passes.NativeLowering: InnerLowering}
            manager.passes = [(own.get(each, each), told) for each, told in manager.passes]
            manager.finalize()
            return [manager]

    return InnerCompiler
