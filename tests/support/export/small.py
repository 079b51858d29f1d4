"""Small algorithms to export."""

from bladesmith.codegen import algorithm
from bladesmith.codegen.algorithm_api import AlgorithmFunction
from bladesmith.codegen.export.bound import ExportedAlgorithm
from bladesmith.codegen.language import InOut, Out, Real, Rows, Vector, sin


@algorithm
def shifted(x: InOut[Vector[3]], by: Real):
    """Adds a number to all elements."""
    for k in range(3):
        x[k] = x[k] + by


@algorithm
def twice_shifted(x: InOut[Vector[3]], by: Real):
    """Adds a number twice."""
    shifted(x, by)
    shifted(x, by)


@algorithm
def first_shifted(x: InOut[Vector[6]], by: Real):
    """Adds a number to the first elements."""
    shifted(x[:3], by)


@algorithm
def total(x: Rows[2]) -> Real:
    """The sum of the first column."""
    result = 0.0
    for k in range(len(x)):
        result = result + x[k, 0]
    return result


@algorithm
def copied(x: Vector[2], gl_found: Out[Vector[2]], uniform: Real) -> Real:
    """Names that GLSL cannot have, a sine, and integers below zero."""
    sum__1 = 0
    for k in range(2):
        sum__1 = sum__1 + (k - 3) // 2
        gl_found[k] = x[k] + uniform
    return sin(uniform) * float(sum__1)


def algorithm_to_export(function: AlgorithmFunction) -> ExportedAlgorithm:
    return ExportedAlgorithm(function.__name__, function.function_for(function.declared_arguments()))
