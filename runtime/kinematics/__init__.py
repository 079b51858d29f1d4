"""Joints as shared geometry, mechanisms, chains and robots (thesis chapter 7); each name is loaded when it is used."""

from __future__ import annotations

from ..codegen.lazy_names import lazy_names

__getattr__, __dir__ = lazy_names(__name__, __file__)
