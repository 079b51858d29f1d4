"""Multivectors whose coefficients are JAX arrays or PyTorch tensors."""
