"""Algebras, multivectors, their operators and functions. Importing it sets up the registry of algebras."""

from __future__ import annotations

from . import registry as registry
