"""Multivectors on JAX arrays and PyTorch tensors: what these packages do differently, types, and calls of kernels."""
