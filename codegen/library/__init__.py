"""Kernels of whole algebras, as libraries to export."""
