"""Geometric algebra for 3D geometry, compiled."""
