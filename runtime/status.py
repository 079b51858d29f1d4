"""`bladesmith.Status`: what became of one item. The codes live with the formulas that set them."""

from __future__ import annotations

from .codegen.status import Status

__all__ = ["Status"]
