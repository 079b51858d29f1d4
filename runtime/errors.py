"""Every exception of the package, as `bladesmith.errors`.

The classes live in the code generator, which may not import the runtime; here is where users find them.
"""

from __future__ import annotations

from .codegen.errors import (
    AlgebraMismatchError,
    AlgorithmError,
    BladeError,
    BladesmithError,
    CompileError,
    CompilerMissingError,
    ConstraintError,
    DeviceError,
    ExecutorError,
    GradeError,
    InputError,
    Interrupted,
    KindError,
    MissingExtraError,
    NotARotorError,
    NotInvertibleError,
    SceneError,
    ShapeError,
    SignatureError,
    SimulationError,
    SingularError,
    SpecError,
    TraceError,
    UndeterminedError,
    suggest,
)

__all__ = [
    "AlgebraMismatchError",
    "AlgorithmError",
    "BladeError",
    "BladesmithError",
    "CompileError",
    "CompilerMissingError",
    "ConstraintError",
    "DeviceError",
    "ExecutorError",
    "GradeError",
    "InputError",
    "Interrupted",
    "KindError",
    "MissingExtraError",
    "NotARotorError",
    "NotInvertibleError",
    "SceneError",
    "ShapeError",
    "SignatureError",
    "SimulationError",
    "SingularError",
    "SpecError",
    "TraceError",
    "UndeterminedError",
    "suggest",
]
