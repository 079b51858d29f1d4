"""Reverse derivatives of batches."""
