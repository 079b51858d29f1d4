"""Robots from SDF files."""
