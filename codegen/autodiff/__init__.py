"""Reverse derivatives of batches, and kernels as functions of other packages' arrays."""
