"""Compiled kernels against exact evaluation of their formulas, on random and extreme operands."""
