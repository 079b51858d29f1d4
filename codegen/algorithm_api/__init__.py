"""Declared algorithms: compiled when they are first called, with forward and reverse derivatives."""

from .compiled import CompiledAlgorithm as CompiledAlgorithm
from .declared import AlgorithmFunction as AlgorithmFunction
from .declared import algorithm as algorithm
from .derivatives import AlgorithmDerivative as AlgorithmDerivative
from .derivatives import AlgorithmPullback as AlgorithmPullback
